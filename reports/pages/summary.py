"""The summary: for each scene, the verdict on the reduced model and the cheapest settings.

Also the settings that reach fixed errors, which compare methods at equal accuracy. All words and
numbers come from `decisions` and `advice` in `comparisons.results`.
"""

from __future__ import annotations

from dataclasses import dataclass

from comparisons import formatting as fmt
from comparisons.facts.methods import CLOSED_FORM, MODEL, ours
from comparisons.facts.quantities import quantity
from comparisons.results import selection
from comparisons.results.advice import ITSELF, Advice, Setting, truth_known_to
from comparisons.results.decisions import Verdict, worst
from comparisons.results.store import SceneRecord
from reports.plots.style import look
from reports.tables import cells
from reports.tables.table import Cell, Head, Table, table

FIXED_ERRORS = (0.01, 0.001)
MOST_NAMED = 2


@dataclass(frozen=True)
class Summary:
    """The summary of one scene."""

    decisive: Verdict | None
    fastest: tuple[Setting, ...]
    truth: str


def summary(scene: SceneRecord, judged: list[Verdict], advice: Advice) -> Summary:
    """Return the deciding verdict, the fastest settings within the tolerance, and the reference."""
    decisive = worst(judged) if judged else None
    return Summary(decisive, tuple(advice.reaching()[:MOST_NAMED]), _truth(scene, advice))


def _truth(scene: SceneRecord, advice: Advice) -> str:
    method, _ = selection.reference(scene)
    if not method:
        return "none"
    label = look(method, scene).label
    if method == CLOSED_FORM:
        return label
    accuracy = truth_known_to(scene, advice.quantities)
    return f"{label} ± {fmt.relative(accuracy)}" if fmt.finite(accuracy) else f"{label} ± ?"


def compared_methods(scenes: tuple[SceneRecord, ...]) -> list[str]:
    """Return the labels of all methods that solved a scene, the reduced model first."""
    names = [m for scene in scenes for m in selection.methods(scene)]
    solved = {
        m for scene in scenes for m in set(names) if not selection.solved_rows(scene, m).empty
    }
    ordered = [name for name in ours() if name in solved]
    ordered += [name for name in dict.fromkeys(names) if name in solved and name not in ordered]
    return [
        label
        for name in ordered
        if name != MODEL
        for label in dict.fromkeys(look(name, scene).label for scene in scenes)
    ]


def times_to_errors(scene: SceneRecord, advice: Advice) -> Table:
    """Return the cheapest setting of each method that reaches 1 %, 0.1 % and the tolerance."""
    errors = sorted({*FIXED_ERRORS, scene.tolerance}, reverse=True)
    columns = {error: advice.cheapest_for(error) for error in errors}
    methods = {name for settings in columns.values() for name in settings}
    heads = (
        Head(f"time to {fmt.tolerance(error)}", csv=f"time to {error:g} / s") for error in errors
    )
    rows = (
        (
            cells.method(name, scene=scene),
            *(_time_cell(settings.get(name)) for settings in columns.values()),
        )
        for name in selection.methods(scene)
        if name in methods
    )
    quantities = ", ".join(quantity(name).label for name in advice.quantities)
    note = (
        "Measured time of the cheapest setting that was run with |e| + u below this value in "
        f"{quantities}, at every load step, for this setting and all finer ones of the method. "
        f"–: none. {ITSELF}; the reference counts with its own error bar."
    )
    return table(("method", *heads), rows, note=note)


def _time_cell(setting: Setting | None) -> Cell:
    if setting is None:
        return cells.NOTHING
    star = "*" if setting.judges_itself and not setting.is_truth else ""
    text = f"{fmt.duration(setting.seconds)}{star} (N = {setting.resolution})"
    return cells.number(text, setting.seconds)
