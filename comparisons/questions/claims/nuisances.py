"""A claim over what its statement leaves open: along one parameter at a time, and over all of them.

A verdict that hangs on a choice that the statement does not make is a verdict on the choice. A
claim therefore names these nuisance parameters. Along each of them the claim is measured from end
to end and its boundary bisected, the others as stated; then a space-filling sample of all of them
(and of the claim's own parameter) shows what they do together.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import qmc

from comparisons.judging.verdicts import WITHIN
from comparisons.questions.claims.boundaries import Measure, Point, grid, points_at, walk
from comparisons.questions.claims.claim import Claim
from comparisons.questions.claims.parameters import Nuisance
from comparisons.questions.experiments.experiment import Effort, Measurement
from comparisons.solving.inquiries import Inquiry, together

SEED = 19  # of the space-filling sample
Setting = Mapping[str, float]
# The measurement of a claim under a setting of its nuisance parameters.
Under = Callable[[Setting], Measure]


@dataclass(frozen=True)
class Along:
    """A claim along one nuisance parameter, the others as stated.

    at: the value of the claim's own parameter, None without one. points: ordered by the number of
    the nuisance parameter.
    """

    nuisance: Nuisance
    at: float | None
    points: list[Point]


@dataclass(frozen=True)
class Draw:
    """A claim at one place of the sample: a setting, with the point measured there."""

    setting: Setting
    point: Point


@dataclass(frozen=True)
class Row:
    """A row of a validity map: the claim along its own parameter, at one number of another.

    stated: whether it is the stated one.
    """

    number: float
    stated: bool
    points: list[Point]


@dataclass(frozen=True)
class Openness:
    """What was measured beside the claim as stated."""

    along: list[Along]
    draws: list[Draw]
    rows: list[Row]

    @property
    def points(self) -> list[Point]:
        """All points."""
        lines = [line.points for line in self.along] + [row.points for row in self.rows]
        return [p for points in lines for p in points] + [draw.point for draw in self.draws]

    @property
    def unstated(self) -> list[Point]:
        """The points along one parameter, and of the map, at another than its stated value."""
        along = [
            point
            for line in self.along
            for point in line.points
            if point.parameter != line.nuisance.stated_number
        ]
        return along + [point for row in self.rows if not row.stated for point in row.points]


def over_all(
    claim: Claim, stated: list[Point], under: Under, effort: Effort, seed: int = SEED
) -> Inquiry[Openness]:
    """Measure a claim over its nuisance parameters.

    Parameters
    ----------
    claim : Claim
    stated : list of Point
        The claim along its own parameter, as stated.
    under : callable
        ``under(setting)`` measures the claim at a value of its own parameter under a setting.
    effort : "quick" or "full"
    seed : int
        Of the sample.
    """
    if not claim.nuisance:
        return Openness([], [], [])
    at = representative(stated).measurement.parameter
    lines = yield from together(
        _along(claim, nuisance, at, under, effort) for nuisance in claim.nuisance
    )
    draws = yield from together(
        _drawn(claim, share, under) for share in shares(claim, effort, seed)
    )
    rows: Sequence[Row] = ()
    if claim.map is not None:
        nuisance = next(n for n in claim.nuisance if n.key == claim.map.up)
        count = claim.map.rows if effort == "full" else 2
        numbers = nuisance.numbers()
        if not nuisance.values:
            numbers = [nuisance.draw(share) for share in np.linspace(0, 1, count)]
        rows = yield from together(_row(claim, nuisance, n, under, effort) for n in numbers)
    return Openness(list(lines), list(draws), list(rows))


def representative(points: Sequence[Point]) -> Point:
    """Return the point at which a claim is varied along other parameters.

    The middle one of those within; where none is, the one with the smallest error.
    """
    within = [point for point in points if point.word == WITHIN]
    if within:
        return within[len(within) // 2]
    size = [np.nan_to_num(abs(point.measurement.error), nan=np.inf) for point in points]
    return points[int(np.argmin(size))]


def shares(claim: Claim, effort: Effort, seed: int = SEED) -> np.ndarray:
    """Return the sample, one row per draw: scrambled Sobol points (Owen 1998) in the unit cube.

    The last column is the claim's own parameter. Quick effort takes the first eighth, at least two.
    """
    sample = qmc.Sobol(len(claim.nuisance) + 1, scramble=True, seed=seed)
    points: np.ndarray = sample.random_base2(int(np.ceil(np.log2(max(claim.draws, 1)))))
    few = min(claim.draws, max(2, claim.draws // 8))
    return points[: claim.draws if effort == "full" else few]


def _along(
    claim: Claim, nuisance: Nuisance, at: float | None, under: Under, effort: Effort
) -> Inquiry[Along]:
    def measure(number: float | None) -> Inquiry[Measurement]:
        assert number is not None
        measured = yield from under({**claim.as_stated, nuisance.key: number})(at)
        return replace(measured, parameter=number)

    halvings = 0 if nuisance.values else nuisance.halvings(effort)
    points = yield from walk(nuisance, nuisance.numbers(), claim.tolerance, measure, halvings)
    return Along(nuisance, at, points)


def _drawn(claim: Claim, share: np.ndarray, under: Under) -> Inquiry[Draw]:
    setting = {n.key: n.draw(float(s)) for n, s in zip(claim.nuisance, share, strict=False)}
    value = None
    if claim.vary is not None:
        value = claim.vary.between(claim.vary.start, claim.vary.end, float(share[-1]))
    (point,) = yield from points_at([value], claim.tolerance, under(setting))
    return Draw(setting, point)


def _row(
    claim: Claim, nuisance: Nuisance, number: float, under: Under, effort: Effort
) -> Inquiry[Row]:
    assert claim.vary is not None
    measure = under({**claim.as_stated, nuisance.key: number})
    halvings = claim.vary.halvings(effort)
    points = yield from walk(claim.vary, grid(claim.vary), claim.tolerance, measure, halvings)
    return Row(number, number == nuisance.stated_number, points)
