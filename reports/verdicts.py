"""The verdict on the reduced model: whether it holds the tolerance that was asked for."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from comparisons.store import SceneRecord
from comparisons.verdicts import NO_RESULT, NOT_RESOLVED, OUTSIDE, WITHIN
from reports import selection
from reports.figure_style import style

MODEL = "reduced"


@dataclass(frozen=True)
class Verdict:
    """One compared quantity of one scene.

    Attributes
    ----------
    quantity, at : str
        What was compared, and what was equal when it was ("penetration", "force", "last load").
    error, rms : float
        Largest and root mean square relative error over the load steps (NaN: no result).
    uncertainty : float
        95 % half-width of that error (NaN where it is not known).
    tolerance : float
    word : str
        "within", "outside", "not resolved" or "no result".
    reason : str
        Why there is no result.
    resolution : float
        The resolution of the reduced model.
    """

    quantity: str
    at: str
    error: float
    rms: float
    uncertainty: float
    tolerance: float
    word: str
    reason: str = ""
    resolution: float = math.nan


def verdicts(scene: SceneRecord, method: str = MODEL) -> list[Verdict]:
    """Return a verdict per compared quantity, from a method's finest resolution."""
    table = selection.compared_measures(scene, method)
    levels = selection.column(table, "resolution")
    finest = table[levels == np.nanmax(levels)] if np.isfinite(levels).any() else table
    found = [_verdict(scene, row) for row in finest.to_dict("records")]
    judged = {item.quantity for item in found if item.word != NO_RESULT}
    lost = [name for name in scene.quantities if name not in judged]
    kept = [item for item in found if item.word != NO_RESULT]
    nan = math.nan
    return kept + [
        Verdict(
            name, "", nan, nan, nan, scene.tolerance, NO_RESULT, _why_missing(scene, name, method)
        )
        for name in lost
    ]


def worst(items: list[Verdict]) -> Verdict:
    """Return the verdict that decides: outside before not resolved before within."""
    order = (OUTSIDE, NOT_RESOLVED, WITHIN, NO_RESULT)
    return min(items, key=lambda item: (order.index(item.word), -abs(item.error)))


def _verdict(scene: SceneRecord, row: dict) -> Verdict:
    error, rms = _float(row.get("maximum")), _float(row.get("rms"))
    bar = _float(row.get("uncertainty"))
    return Verdict(
        quantity=str(row["quantity"]),
        at=str(row.get("at", "") or ""),
        error=error,
        rms=rms,
        uncertainty=bar,
        tolerance=scene.tolerance,
        word=str(row.get("verdict") or NO_RESULT),
        resolution=_float(row.get("resolution")),
    )


def _why_missing(scene: SceneRecord, name: str, method: str) -> str:
    refused = selection.unsupported(scene)
    if method in refused:
        return refused[method]
    lost = [item.reason for item in selection.failures(scene) if item.method == method]
    if lost:
        return lost[0]
    title = style(method).label
    if method not in selection.methods(scene):
        return f"the {title} was not asked for"
    table = selection.compared_measures(scene)
    if (table["quantity"] == name).any():
        return f"the {title} does not give it, or there is one load only"
    return "there is nothing to compare it with"


def _float(value: object) -> float:
    try:
        return float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return math.nan
