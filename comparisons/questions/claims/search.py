"""Where a claim holds: along its parameter, and over what its statement leaves open.

A grid is measured, then every interval that contains a boundary is bisected. A verdict that hangs
on a choice that the statement does not make is a verdict on the choice. A claim therefore names
these nuisance parameters. Along each of them it is measured from end to end, the others as stated;
then a space-filling sample of all of them (and of its own parameter) shows what they do together.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, replace
from itertools import groupby, pairwise

import numpy as np
from scipy.stats import qmc

from comparisons.files import plain
from comparisons.judging.verdicts import OUTSIDE, WITHIN, judged
from comparisons.questions.claims.claim import Claim
from comparisons.questions.claims.parameters import Nuisance, Span, Vary
from comparisons.questions.claims.record import (
    MapRecord,
    NuisanceRecord,
    PointRecord,
    RangeRecord,
    RowRecord,
)
from comparisons.questions.claims.wording import value as in_words
from comparisons.questions.experiments import Measurement
from comparisons.questions.experiments.experiment import Effort
from comparisons.solving.inquiries import Inquiry, together

SEED = 19  # of the space-filling sample
Setting = Mapping[str, float]
Measure = Callable[[float | None], Inquiry[Measurement]]
# The measurement of a claim under a setting of its nuisance parameters.
Under = Callable[[Setting], Measure]


def along(claim: Claim, measure: Measure, effort: Effort) -> Inquiry[list[PointRecord]]:
    """Measure a claim along its own parameter; without one, once."""
    if claim.vary is None:
        return (yield from points_at([None], claim.tolerance, measure))
    halvings = claim.vary.halvings(effort)
    return (yield from walk(claim.vary, grid(claim.vary), claim.tolerance, measure, halvings))


def walk(
    span: Span, values: Sequence[float], tolerance: float, measure: Measure, bisections: int
) -> Inquiry[list[PointRecord]]:
    """Measure a claim at values of a parameter, then bisect all intervals that contain a boundary.

    These are intervals between a point within and one outside, and intervals between two points
    outside with errors of opposite signs, because the error passes zero there and the claim holds
    nearby. If a midpoint is not resolved, the bisection ends. Points come back in order.
    """
    points = yield from points_at(values, tolerance, measure)
    intervals = list(pairwise(points))
    for _ in range(bisections):
        split = []
        for low, high in intervals:
            words = {low.word, high.word}
            opposite = words == {OUTSIDE} and _number(low.error) * _number(high.error) < 0
            ends = _number(low.parameter), _number(high.parameter)
            middle = span.between(*ends)
            consecutive = span.is_integer and not ends[0] < middle < ends[1]
            if (words == {WITHIN, OUTSIDE} or opposite) and not consecutive:
                split.append((low, middle, high))
        if not split:
            break
        middles = yield from points_at([middle for _, middle, _ in split], tolerance, measure)
        halves = zip(split, middles, strict=True)
        intervals = [
            half for (low, _, high), point in halves for half in ((low, point), (point, high))
        ]
        points += middles
    return sorted(points, key=lambda point: _number(point.parameter))


def points_at(
    values: Sequence[float | None],
    tolerance: float,
    measure: Measure,
    setting: dict[str, str] | None = None,
) -> Inquiry[list[PointRecord]]:
    """Measure and judge a claim at several values of a parameter, under a setting in words."""
    measured = yield from together(measure(value) for value in values)
    return [
        PointRecord(
            word=judged(m.error, m.uncertainty, tolerance).word,
            setting=setting or {},
            **plain(asdict(m)),
        )
        for m in measured
    ]


def _number(value: float | None) -> float:
    return np.nan if value is None else value


def grid(vary: Vary) -> list[float]:
    """Return the initial values of the parameter, with exact end points."""
    spaced = np.geomspace if vary.spacing == "log" else np.linspace
    inner = spaced(vary.start, vary.end, vary.steps)[1:-1]
    values = [vary.start, *(float(value) for value in inner), vary.end]
    return list(dict.fromkeys(float(round(v)) for v in values)) if vary.is_integer else values


def ranges_of(points: list[PointRecord]) -> list[RangeRecord]:
    """Return the intervals in which a claim holds (none without a parameter)."""
    stretches, start = [], 0
    for word, group in groupby(points, key=lambda point: point.word):
        members = list(group)
        stop = start + len(members)
        low, high = members[0].parameter, members[-1].parameter
        if word == WITHIN and low is not None and high is not None:
            below = points[start - 1].parameter if start else None
            above = points[stop].parameter if stop < len(points) else None
            stretches.append(RangeRecord(low=low, high=high, below=below, above=above))
        start = stop
    return stretches


def along_nuisance(
    claim: Claim, nuisance: Nuisance, at: float | None, under: Under, effort: Effort
) -> Inquiry[NuisanceRecord]:
    """Measure a claim along a nuisance parameter, at a value of its own, the others as stated."""

    def measure(number: float | None) -> Inquiry[Measurement]:
        assert number is not None
        measured = yield from under({**claim.as_stated, nuisance.key: number})(at)
        return replace(measured, parameter=number)

    halvings = 0 if nuisance.values else nuisance.halvings(effort)
    points = yield from walk(nuisance, nuisance.numbers(), claim.tolerance, measure, halvings)
    return NuisanceRecord(
        name=nuisance.name,
        reason=nuisance.reason,
        stated=nuisance.stated_number,
        spacing=nuisance.spacing,
        choices=nuisance.choices,
        at=at,
        points=points,
        ranges=[] if nuisance.values else ranges_of(points),
    )


def representative(points: Sequence[PointRecord]) -> PointRecord:
    """Return the middle one of the points within, else that of the smallest error."""
    within = [point for point in points if point.word == WITHIN]
    if within:
        return within[len(within) // 2]
    return min(points, key=lambda p: np.inf if p.error is None else abs(p.error))


def drawn(claim: Claim, share: np.ndarray, under: Under) -> Inquiry[PointRecord]:
    """Measure a claim at one place of the sample."""
    setting = {n.key: n.draw(float(s)) for n, s in zip(claim.nuisance, share, strict=False)}
    words = {
        n.name: n.choices[int(setting[n.key])] if n.values else in_words(setting[n.key])
        for n in claim.nuisance
    }
    value = None
    if claim.vary is not None:
        value = claim.vary.between(claim.vary.start, claim.vary.end, float(share[-1]))
    (point,) = yield from points_at([value], claim.tolerance, under(setting), words)
    return point


def shares(claim: Claim, effort: Effort, seed: int = SEED) -> np.ndarray:
    """Return the sample, one row per draw: scrambled Sobol points (Owen 1998) in the unit cube.

    The last column is the claim's own parameter. Quick effort takes the first eighth, at least two.
    """
    sample = qmc.Sobol(len(claim.nuisance) + 1, scramble=True, seed=seed)
    points: np.ndarray = sample.random_base2(int(np.ceil(np.log2(max(claim.draws, 1)))))
    few = min(claim.draws, max(2, claim.draws // 8))
    return points[: claim.draws if effort == "full" else few]


def mapped(claim: Claim, under: Under, effort: Effort) -> Inquiry[MapRecord | None]:
    """Measure a claim along its own parameter in rows of a nuisance parameter, if it has a map."""
    if claim.map is None:
        return None
    nuisance = next(n for n in claim.nuisance if n.key == claim.map.up)
    numbers = nuisance.numbers()
    if not nuisance.values:
        count = claim.map.rows if effort == "full" else 2
        numbers = [nuisance.draw(share) for share in np.linspace(0, 1, count)]
    settings = [{**claim.as_stated, nuisance.key: number} for number in numbers]
    lines = yield from together(along(claim, under(setting), effort) for setting in settings)
    rows = [
        RowRecord(number=number, points=points, ranges=ranges_of(points))
        for number, points in zip(numbers, lines, strict=True)
    ]
    return MapRecord(
        up=nuisance.name, spacing=nuisance.spacing, choices=nuisance.choices, rows=rows
    )
