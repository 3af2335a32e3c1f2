"""Search for the range of a parameter in which a claim holds: a grid, then bisection."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import groupby, pairwise

import numpy as np

from comparisons.judging.verdicts import OUTSIDE, WITHIN, judge
from comparisons.questions.claims.parameters import Span, Vary
from comparisons.questions.experiments import Measurement
from comparisons.solving.inquiries import Inquiry, together

Measure = Callable[[float | None], Inquiry[Measurement]]


@dataclass(frozen=True)
class Point:
    """A measurement and its verdict: "within", "outside", "not resolved" or "no result"."""

    measurement: Measurement
    word: str

    @property
    def parameter(self) -> float:
        """The measured value of the parameter, NaN without a parameter."""
        value = self.measurement.parameter
        return float("nan") if value is None else value


@dataclass(frozen=True)
class Range:
    """An interval of the parameter with all measured points within the tolerance.

    low, high: the outermost points within. below, above: the next measured points, which are not
    within (None at the end of the tested range). The boundary lies between them, and their distance
    is its resolution.
    """

    low: float
    high: float
    below: float | None
    above: float | None


def search(
    vary: Vary | None, tolerance: float, measure: Measure, bisections: int
) -> Inquiry[list[Point]]:
    """Measure a claim over its grid, then bisect all intervals that contain a boundary (`walk`)."""
    if vary is not None:
        return (yield from walk(vary, grid(vary), tolerance, measure, bisections))
    return (yield from points_at([None], tolerance, measure))


def points_at(
    values: Sequence[float | None], tolerance: float, measure: Measure
) -> Inquiry[list[Point]]:
    """Measure and judge a claim at several values of a parameter."""
    measured = yield from together(measure(value) for value in values)
    return [Point(m, judge(m.error, m.uncertainty, tolerance)) for m in measured]


def walk(
    span: Span, values: Sequence[float], tolerance: float, measure: Measure, bisections: int
) -> Inquiry[list[Point]]:
    """Measure a claim at values of a parameter, then bisect all intervals that contain a boundary.

    These are intervals between a point within and one outside, and intervals between two points
    outside with errors of opposite signs, because the error passes zero there and the claim holds
    nearby. If a midpoint is not resolved, the bisection ends.

    Returns
    -------
    list of Point
        Ordered by the parameter.
    """
    points = yield from points_at(values, tolerance, measure)
    intervals = list(pairwise(points))
    for _ in range(bisections):
        split = [
            (low, middle, high)
            for low, high in intervals
            if _holds_boundary(low, high)
            and (middle := _between(span, low.parameter, high.parameter)) is not None
        ]
        if not split:
            break
        middles = yield from points_at([middle for _, middle, _ in split], tolerance, measure)
        halves = zip(split, middles, strict=True)
        intervals = [
            half for (low, _, high), point in halves for half in ((low, point), (point, high))
        ]
        points += middles
    return sorted(points, key=lambda point: point.parameter)


def _holds_boundary(low: Point, high: Point) -> bool:
    """Return whether a boundary must lie between two neighbours."""
    verdicts = {low.word, high.word}
    opposite = low.measurement.error * high.measurement.error < 0
    return verdicts == {WITHIN, OUTSIDE} or (verdicts == {OUTSIDE} and opposite)


def grid(vary: Vary) -> list[float]:
    """Return the initial values of the parameter, with exact end points."""
    if vary.spacing == "log":
        inner = np.geomspace(vary.start, vary.end, vary.steps)[1:-1]
    else:
        inner = np.linspace(vary.start, vary.end, vary.steps)[1:-1]
    values = [vary.start, *(float(inner_value) for inner_value in inner), vary.end]
    return list(dict.fromkeys(float(round(v)) for v in values)) if vary.is_integer else values


def _between(span: Span, low: float, high: float) -> float | None:
    """Return the midpoint on the parameter's scale, or None between consecutive integers."""
    middle = span.between(low, high)
    return middle if not span.is_integer or low < middle < high else None


def ranges_of(points: list[Point]) -> list[Range]:
    """Return the intervals in which a claim holds (none without a parameter)."""
    stretches, start = [], 0
    for word, group in groupby(points, key=lambda point: point.word):
        members = list(group)
        stop = start + len(members)
        if word == WITHIN and members[0].measurement.parameter is not None:
            below = points[start - 1].parameter if start else None
            above = points[stop].parameter if stop < len(points) else None
            stretches.append(Range(members[0].parameter, members[-1].parameter, below, above))
        start = stop
    return stretches
