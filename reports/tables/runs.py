"""Tables of runs: what is planned, one solve, an ensemble of surfaces, changes between two runs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from comparisons import formatting as fmt
from comparisons.facts.quantities import quantity
from comparisons.facts.quantities.rows import HALF_AXES
from comparisons.judging.levels import ensemble_text
from comparisons.results.record import SceneRecord
from comparisons.solving.plan import MethodPlan, Plan
from reports.tables import cells
from reports.tables.cells import Cell, Table, table

if TYPE_CHECKING:
    import pandas as pd

    from comparisons.questions.single import SingleResult
    from comparisons.results.ensemble_folder import EnsembleRecord
    from comparisons.results.run_comparison import Change

TIMES = "time, before → after"
SHOWN = ("force", "penetration", "mean_gap", "contact_area")


def plan(planned: Plan) -> Table:
    """Return the planned model and resolutions of each method."""
    rows = []
    for method in planned.methods:
        levels = ", ".join(str(n) for n in method.resolutions) if method.supported else fmt.MISSING
        left_out = f" [{method.reason}]" if method.reason.startswith("left out") else ""
        modelled = method.modelled + left_out if method.supported else f"not run: {method.reason}"
        ensemble = ensemble_text(method.method, method.numbers, method.resolutions)
        if ensemble:
            modelled += f"; to begin with, {ensemble}"
        rows.append((cells.method(method.method, method.method), levels, modelled))
    title = f"{planned.scene.heading} ({planned.scene.name})"
    return table(("method", "resolutions", "plan"), rows, title=title)


def plan_rows(scene: SceneRecord) -> list[tuple[Cell, str, str]]:
    """Return the model and resolutions of each method that ran."""
    planned = {item.method: item for item in scene.plan.methods}
    rows = []
    for method in (name for name in scene.methods if name not in scene.unsupported):
        item = planned.get(method, MethodPlan(method, True, ""))
        levels = item.resolutions or scene.resolutions_solved(method)
        ensemble = ensemble_text(method, item.numbers, item.resolutions)
        text = "; ".join(filter(None, [item.modelled, ensemble]))
        rows.append((cells.method(method, scene=scene), text, ", ".join(map(fmt.count, levels))))
    return rows


def shown_columns(result: SingleResult) -> list[str]:
    """Return the prescribed and the compared quantities, and the half-axes of an ellipse."""
    shown = (*result.plan.loads.columns, *result.plan.scene.compare.quantities, *HALF_AXES)
    columns = result.curves()
    return [name for name in dict.fromkeys(shown) if name in columns]


def load_steps(result: SingleResult, digits: int = 4) -> Table:
    """Return one row per load step, each quantity in one unit."""
    solved = result.curves()
    columns = [cells.column(name, solved[name], digits) for name in shown_columns(result)]
    return cells.of_columns(columns, title=f"{result.plan.scene.heading}: {result.method}")


def settings(record: EnsembleRecord) -> Table:
    """Return one row per method and resolution: surfaces and what they cost."""
    rows = [
        (
            cells.method(setting.method),
            cells.count(setting.resolution),
            cells.count(setting.surfaces),
            cells.count(setting.bundles),
            cells.count(setting.lost),
            cells.duration(setting.processor_seconds),
            cells.duration(setting.processor_seconds / max(setting.surfaces, 1)),
        )
        for setting in record.settings
    ]
    heads = ("method", "points", "surfaces", "files", "lost steps", "processor", "per surface")
    return table(heads, rows, title=f"{record.name}: {fmt.count(record.surfaces)} surfaces")


def means(record: EnsembleRecord, statistics: pd.DataFrame) -> Table:
    """Return the means with their standard errors at the first, middle and last load."""
    quantities = [name for name in SHOWN if name != record.control]
    last = len(record.loads) - 1
    rows = []
    for setting in record.settings:
        chosen = (statistics["method"] == setting.method) & (
            statistics["resolution"] == setting.resolution
        )
        own = statistics[chosen].set_index(["step", "quantity"])
        for step in sorted({0, last // 2, last}):
            row = [cells.method(setting.method), cells.count(setting.resolution)]
            row.append(_value(record.control, record.loads[step], 0.0))
            for name in quantities:
                known = (step, name) in own.index
                mean, error = own.loc[(step, name), ["mean", "standard_error"]] if known else (0, 0)
                row.append(_value(name, float(mean), float(error)) if known else cells.NOTHING)
            rows.append(row)
    labels = [quantity(name).label for name in (record.control, *quantities)]
    return table(["method", "points", *labels], rows, title="means ± standard errors")


def _value(name: str, mean: float, error: float) -> Cell:
    scale = fmt.prefix_for([mean], quantity(name).unit)
    text = fmt.number(mean * scale.factor, 4)
    if error:
        text += f" ± {fmt.number(error * scale.factor, 2)}"
    return cells.number(f"{text} {scale.unit}".rstrip(), mean)


def changes(solves: Sequence[Change]) -> Table:
    """Return the change of each solve; those that make the comparison fail are highlighted."""
    rows = (
        (
            change.scene,
            cells.method(change.method),
            cells.number(str(change.resolution or fmt.MISSING), change.resolution),
            cells.verdict(*change.kinds),
            Cell(change.text, change.text, "wrap"),
            cells.change(*change.errors, of=[quantity(n).label for n in change.errors_of if n]),
            cells.change(*change.seconds, fmt.duration),
        )
        for change in solves
    )
    heads = ("scene", "method", "N", "what", "in words", "largest error, before → after", TIMES)
    bad = frozenset(place for place, change in enumerate(solves) if change.bad)
    return table(heads, rows, title="Solves that changed", strong=bad)
