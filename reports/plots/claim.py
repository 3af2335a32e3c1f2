"""The evidence for a claim as a plot: error against the parameter, with the tolerance."""

from __future__ import annotations

import numpy as np

from comparisons import formatting as fmt
from comparisons.judging.verdicts import NOT_RESOLVED, OUTSIDE, WITHIN
from comparisons.questions.claims.record import ClaimRecord, PointRecord
from comparisons.questions.claims.wording import value
from reports.plots.axes import error_axis, error_range, tolerance_line
from reports.plots.figure import Axis, Figure, Series, Stretch
from reports.plots.style import BLUE, CIRCLE, GREEN, VERMILION, Look, Marker

CAPTION = (
    "Error magnitude with its 95 % bar at every measured value. The claim holds in the shaded "
    "interval, whose ends are known to the spacing of the neighbouring markers."
)
LOOKS = {
    WITHIN: Look("within", GREEN, CIRCLE, size=9),
    OUTSIDE: Look("outside", VERMILION, Marker("x", "X"), size=9),
    NOT_RESOLVED: Look("not resolved", BLUE, CIRCLE, size=9),
}


def evidence(claim: ClaimRecord, fewest: int = 2) -> Figure | None:
    """Return the error against the varied parameter, or None if no parameter varies."""
    points = [p for p in claim.points if p.parameter is not None and p.error is not None]
    if len(points) < fewest:
        return None
    low, high = error_range(np.array([abs(p.error or 0.0) for p in points]), claim.tolerance)
    groups = {word: [p for p in points if p.word == word] for word in LOOKS}
    return Figure(
        "evidence",
        f"Error against {claim.parameter}",
        CAPTION,
        Axis(claim.parameter, log=claim.spacing == "log"),
        error_axis(low, high, "magnitude of relative error"),
        tuple(_marks(points, word, low) for word, points in groups.items() if points),
        levels=(tolerance_line(claim.tolerance),),
        stretches=tuple(
            Stretch(interval.low, interval.high, GREEN, "holds") for interval in claim.ranges
        ),
    )


def _marks(points: list[PointRecord], word: str, low: float) -> Series:
    """Return the points with one verdict; errors below the axis are placed at its edge."""
    return Series(
        LOOKS[word],
        np.array([p.parameter for p in points], dtype=float),
        np.array([max(abs(p.error or 0.0), low) for p in points]),
        line=False,
        hollow=word == NOT_RESOLVED,
        bars=np.array([p.uncertainty or 0.0 for p in points]),
        hover=tuple(_hover(p) for p in points),
    )


def _hover(point: PointRecord) -> str:
    lines = [f"{value(point.parameter or 0.0)}: {fmt.plus_minus(point.error, point.uncertainty)}"]
    lines += [f"{key}: {detail(number)}" for key, number in point.details.items()]
    return "\n".join(lines)


def detail(number: float | str | None) -> str:
    """Return a detail of a measurement as text."""
    return number if isinstance(number, str) else fmt.number(number)
