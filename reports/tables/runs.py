"""Tables of what was run: changes between two runs, one solve, an ensemble of surfaces."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from comparisons import formatting as fmt
from comparisons.facts.quantities import quantity
from comparisons.results.run_comparison import Change
from reports.tables import cells
from reports.tables.table import Cell, Table, table

if TYPE_CHECKING:
    import pandas as pd

    from comparisons.questions.single import SingleResult
    from comparisons.results.ensemble_folder import EnsembleRecord

TIMES = "time, before → after"


def changes(solves: Sequence[Change]) -> Table:
    """Return the change of each solve; those that make the comparison fail are highlighted."""
    rows = (
        (
            change.scene,
            cells.method(change.method),
            cells.number(str(change.resolution or fmt.MISSING), change.resolution),
            cells.verdict(*change.kinds),
            Cell(change.text, change.text, "wrap"),
            cells.change(*change.errors),
            cells.change(*change.seconds, fmt.duration),
        )
        for change in solves
    )
    heads = ("scene", "method", "N", "what", "in words", "error, before → after", TIMES)
    bad = frozenset(place for place, change in enumerate(solves) if change.bad)
    return table(heads, rows, title="Solves that changed", strong=bad)


def shown_columns(result: SingleResult) -> list[str]:
    """Return the prescribed and the compared quantities."""
    prescribed = list(result.plan.loads.columns)
    compared = [q for q in result.plan.scene.compare.quantities if q not in prescribed]
    columns = result.solved()
    return [name for name in (*prescribed, *compared) if name in columns]


def load_steps(result: SingleResult, digits: int = 4) -> Table:
    """Return one row per load step, each quantity in one unit."""
    solved = result.solved()
    columns = {name: solved[name] for name in shown_columns(result)}
    scales = {name: fmt.prefix_for(v, quantity(name).unit) for name, v in columns.items()}
    heads = [quantity(name).title(scale.unit) for name, scale in scales.items()]
    rows = zip(
        *(
            [cells.number(fmt.number(v * scales[name].factor, digits), float(v)) for v in values]
            for name, values in columns.items()
        ),
        strict=True,
    )
    return table(heads, rows, title=f"{result.plan.scene.heading}: {result.method}")


SHOWN = ("force", "penetration", "mean_gap", "contact_area")


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
