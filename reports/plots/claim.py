"""The evidence for a claim as plots: error against a parameter, and maps of two parameters."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from comparisons import formatting as fmt
from comparisons.judging.verdicts import NOT_RESOLVED, OUTSIDE, WITHIN
from comparisons.questions.claims.record import (
    ClaimRecord,
    NuisanceRecord,
    PointRecord,
    RangeRecord,
    RowRecord,
)
from comparisons.questions.claims.wording import error_text, value
from reports.plots.axes import error_axis, error_range, tolerance_line
from reports.plots.figure import Axis, Figure, Series, Stretch
from reports.plots.style import BLUE, CIRCLE, GREEN, INK, VERMILION, Look, Marker

CAPTION = (
    "Error magnitude with its bar at every measured value. The claim holds in the shaded "
    "interval, whose ends are known to the spacing of the neighbouring markers."
)
MAP_CAPTION = (
    "Each row is a search along the parameter across. The bars are the boundaries: each lies "
    "somewhere on its bar."
)
LOOKS = {
    WITHIN: Look("within", GREEN, CIRCLE, size=9),
    OUTSIDE: Look("outside", VERMILION, Marker("x", "X"), size=9),
    NOT_RESOLVED: Look("not resolved", BLUE, CIRCLE, size=9),
}
# Points that carry a shaded interval.
FEWEST = 4
BOUNDARY = Look("boundary", INK, CIRCLE, size=4)


def evidence(claim: ClaimRecord, fewest: int = 2) -> Figure | None:
    """Return the error against the varied parameter, or None if no parameter varies."""
    axis = Axis(fmt.greek(claim.parameter), log=claim.spacing == "log")
    return _errors("evidence", axis, claim.points, claim.ranges, claim.tolerance, fewest)


def along(claim: ClaimRecord, nuisance: NuisanceRecord) -> Figure | None:
    """Return the error against a parameter that the statement leaves open, None for choices."""
    if nuisance.choices:
        return None
    axis = Axis(fmt.greek(nuisance.name), log=nuisance.spacing == "log")
    key = f"along-{claim.nuisances.index(nuisance)}"
    return _errors(key, axis, nuisance.points, nuisance.ranges, claim.tolerance, 2)


def _errors(
    key: str,
    axis: Axis,
    measured: Sequence[PointRecord],
    ranges: Sequence[RangeRecord],
    tolerance: float,
    fewest: int,
) -> Figure | None:
    points = [p for p in measured if p.parameter is not None and p.error is not None]
    if len(points) < fewest:
        return None
    low, high = error_range(np.array([abs(p.error or 0.0) for p in points]), tolerance)
    groups = {word: [p for p in points if p.word == word] for word in LOOKS}
    return Figure(
        key,
        f"Error against {axis.title}",
        CAPTION,
        axis,
        error_axis(low, high, "magnitude of relative error"),
        tuple(_marks(points, word, low) for word, points in groups.items() if points),
        levels=(tolerance_line(tolerance),),
        stretches=tuple(
            Stretch(interval.low, interval.high, GREEN, "holds")
            for interval in ranges
            if sum(interval.low <= (p.parameter or 0.0) <= interval.high for p in points) >= FEWEST
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


def validity_map(claim: ClaimRecord) -> Figure | None:
    """Return where a claim holds in two parameters, or None if that was not measured."""
    drawn = claim.map
    if drawn is None:
        return None
    ticks = tuple((float(place), fmt.greek(name)) for place, name in enumerate(drawn.choices))
    series = [_cells(drawn.rows, word) for word in LOOKS]
    return Figure(
        "map",
        f"Where it holds: {fmt.greek(claim.parameter)} and {fmt.greek(drawn.up)}",
        MAP_CAPTION,
        Axis(fmt.greek(claim.parameter), log=claim.spacing == "log"),
        Axis(fmt.greek(drawn.up), log=drawn.spacing == "log", ticks=ticks),
        (*(marks for marks in series if len(marks.x)), _boundaries(drawn.rows)),
    )


def _cells(rows: Sequence[RowRecord], word: str) -> Series:
    """Return the points of a map with one verdict."""
    points = [(row.number, p) for row in rows for p in row.points if p.word == word]
    return Series(
        LOOKS[word],
        np.array([p.parameter for _, p in points], dtype=float),
        np.array([number for number, _ in points], dtype=float),
        line=False,
        hollow=word == NOT_RESOLVED,
        hover=tuple(_hover(p) for _, p in points),
    )


def _boundaries(rows: Sequence[RowRecord]) -> Series:
    """Return the intervals in which the boundaries of the rows lie, with gaps between them.

    Between a point within and the next one outside; points that are not resolved are on neither
    side, and beside them alone no boundary is certain.
    """
    ends = [
        (row.number, low.parameter, high.parameter)
        for row in rows
        for low, high in pairwise(p for p in row.points if p.word in (WITHIN, OUTSIDE))
        if low.word != high.word
    ]
    x = [float(end) for _, low, high in ends for end in (low or 0.0, high or 0.0, np.nan)]
    y = [number for number, *_ in ends for _ in range(3)]
    return Series(BOUNDARY, np.array(x), np.array(y), marks=False, width=5.0)


def _hover(point: PointRecord) -> str:
    lines = [f"{value(point.parameter or 0.0)}: {error_text(point)}"]
    lines += [f"{key}: {detail(number)}" for key, number in point.details.items()]
    return "\n".join(lines)


def detail(number: float | str | None) -> str:
    """Return a detail of a measurement as text."""
    return number if isinstance(number, str) else fmt.number(number)
