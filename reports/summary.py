"""The first screen: per scene the verdict on the reduced model, and the cheapest way to the error.

Also the times to fixed errors, which compare methods at equal accuracy.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from comparisons import formatting as fmt
from comparisons.advice import Advice
from comparisons.store import SceneRecord
from comparisons.verdicts import NO_RESULT
from reports import selection
from reports.figure_style import style
from reports.tables import Cell, Head, Table
from reports.verdicts import Verdict, worst

FIXED_ERRORS = (0.01, 0.001)
MOST_NAMED = 2


@dataclass(frozen=True)
class Timed:
    """A method that is sure of the tolerance, and how long it takes."""

    method: str
    seconds: float


@dataclass(frozen=True)
class Summary:
    """What the first screen says of a scene."""

    decisive: Verdict | None
    fastest: tuple[Timed, ...]
    truth: str


def summary(scene: SceneRecord, found: dict[str, Verdict], advice: Advice) -> Summary:
    """Return the deciding verdict, the fastest methods at the asked tolerance, and the truth."""
    judged = [item for item in found.values() if item.word != NO_RESULT]
    times = advice.times_to(scene.tolerance)
    sure = [Timed(name, seconds) for name, seconds in times.items() if np.isfinite(seconds)]
    # A closed form needs no choice: where there is one, nobody solves.
    ordered = sorted((each for each in sure if each.method != "closed_form"), key=_seconds)
    decisive = worst(judged or list(found.values())) if found else None
    return Summary(decisive, tuple(ordered[:MOST_NAMED]), _truth(scene, advice))


def _seconds(item: Timed) -> float:
    return item.seconds


def _truth(scene: SceneRecord, advice: Advice) -> str:
    method, _ = selection.reference(scene)
    if not method:
        return "none"
    label = style(method).label
    if method == "closed_form":
        return label
    bars = scene.reference.get("uncertainty") or {}
    known = [bars[name] for name in advice.quantities if fmt.finite(bars.get(name))]
    return f"{label} ± {fmt.relative(max(known))}" if known else f"{label} ± ?"


def compared_methods(scenes: tuple[SceneRecord, ...]) -> list[str]:
    """Return the labels of all methods that solved something, the reduced model first."""
    names = [m for scene in scenes for m in selection.methods(scene)]
    solved = {
        m for scene in scenes for m in set(names) if not selection.solved_rows(scene, m).empty
    }
    ordered = [name for name in selection.METHOD_ORDER if name in solved]
    ordered += [name for name in dict.fromkeys(names) if name in solved and name not in ordered]
    return [style(name).label for name in ordered if name != "reduced"]


def times_to_errors(scene: SceneRecord, advice: Advice) -> Table:
    """Return how long each method takes to be sure of 1 %, 0.1 % and the asked tolerance."""
    wanted = sorted({*FIXED_ERRORS, scene.tolerance}, reverse=True)
    columns = {error: advice.times_to(error) for error in wanted}
    known = {name for times in columns.values() for name in times}
    headers = [Head("method")]
    headers += [
        Head(f"time to {fmt.tolerance(error)}", csv=f"time to {error:g} / s") for error in wanted
    ]
    rows = tuple(
        (
            Cell(style(name).label, style(name).label, "method", name),
            *(_time_cell(times.get(name, float("nan"))) for times in columns.values()),
        )
        for name in selection.methods(scene)
        if name in known
    )
    quantities = ", ".join(fmt.quantity(name).words for name in advice.quantities)
    note = (
        f"Until the rms error over the load steps is below the value in all of {quantities}, and "
        "its bars leave no doubt. Interpolated between the settings of a method, never "
        "extrapolated; –: not reached, or not resolved. The truth counts with its own bar."
    )
    return Table(tuple(headers), rows, note)


def _time_cell(seconds: float) -> Cell:
    return Cell(fmt.duration(seconds), seconds)
