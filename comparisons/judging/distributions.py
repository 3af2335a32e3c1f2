"""Distributions compared at the last load: how far values of equal rank are apart.

With x(s) the pressure, gap or size that a share s of all of them stays below, the distance is
int_0^1 |x_1 - x_2| ds over the mean of the truth (Wasserstein's, of first order): 10 % is an
average over the ranks. Both are normalised, as the area itself is a quantity of its own.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import special

from comparisons.facts.methods import METHODS
from comparisons.facts.quantities import DISTRIBUTIONS
from comparisons.geometry.prepare import RoughGeometry
from comparisons.judging.levels import Levels
from comparisons.judging.metrics import Measure
from comparisons.judging.pressures import TruePressure, pressure_measures
from comparisons.judging.truth import Truth
from comparisons.judging.uncertainty import SAFE, combined
from comparisons.solving.plan import Plan
from comparisons.tasks.distributions import edges
from comparisons.tasks.solution import Solution, Solved

ALL = slice(None)


def distance(values: np.ndarray, reference: np.ndarray, bins: np.ndarray) -> float:
    """Return the mean difference at equal rank, over the reference's mean; NaN of empty histograms.

    >>> bins = np.geomspace(1, 10, 11)
    >>> shape = np.arange(10.0)
    >>> distance(3 * shape, shape, bins)
    0.0
    """
    shares = []  # below each edge of the bins
    for histogram in (values, reference):
        total = float(histogram.sum())
        if not total > 0:
            return float("nan")
        shares.append(np.concatenate([[0.0], np.cumsum(histogram) / total]))
    mean = bins[0] + float(np.trapezoid(1 - shares[1], bins))
    return float(np.trapezoid(np.abs(shares[0] - shares[1]), bins) / mean)


def last_histogram(solution: Solution, name: str, rows: slice = ALL) -> np.ndarray:
    """Return the mean over surfaces of a distribution at the last load, (bins,)."""
    several = solution.distributions[name][rows]
    answered = several[np.isfinite(several).all(axis=1)]
    return np.asarray(answered.mean(axis=0) if len(answered) else np.full(several.shape[1], np.nan))


def _common(name: str, *solutions: Solution) -> slice:
    """Return the surfaces that all of several solutions know a distribution of."""
    return slice(min(len(solution.distributions[name]) for solution in solutions))


def mean_histogram(levels: Levels, name: str, resolution: int) -> np.ndarray:
    """Return the mean of a distribution over the surfaces, on all grids up to a resolution.

    That of the coarsest grid, and what each finer one changes on the surfaces that it solved.
    """
    grids = [s for n, s in levels.solutions.items() if n <= resolution and name in s.distributions]
    mean, coarser = last_histogram(grids[0], name), grids[0]
    for finer in grids[1:]:
        rows = _common(name, finer, coarser)
        mean = mean + last_histogram(finer, name, rows) - last_histogram(coarser, name, rows)
        coarser = finer
    return mean


@dataclass(frozen=True)
class TrueDistribution:
    """A distribution of the truth at the last load, and how well it is known."""

    plan: Plan
    truth: Truth
    name: str

    @property
    def is_known(self) -> bool:
        """Whether the truth's method gives it."""
        return self.name in self.truth.solution.distributions

    @property
    def bins(self) -> np.ndarray:
        """Edges of its bins."""
        assert isinstance(self.plan.geometry, RoughGeometry)
        return edges(self.name, self.plan.scene, self.plan.geometry)

    def bar(self) -> float:
        """Return how far the grid moves it, on the same surfaces; NaN with one grid."""
        return self.change(self.truth.levels, self.truth.resolution)

    def change(self, levels: Levels, resolution: int) -> float:
        """Return 1.25 times what is left of the change from the next coarser grid, first order."""
        coarser = levels.below(resolution)
        if coarser is None:
            return float("nan")
        pair = [levels.solutions[n] for n in (coarser, resolution)]
        if any(self.name not in solution.distributions for solution in pair):
            return float("nan")
        common = _common(self.name, *pair)
        before, after = (last_histogram(solution, self.name, common) for solution in pair)
        return SAFE * distance(before, after, self.bins) / (resolution / coarser - 1)

    def scatter(self, levels: Levels) -> float:
        """Return the 95 % half-width of a mean over surfaces or lines; zero of a single one.

        The jackknife: the mean moves by its distance to that without one of the sample.
        """
        coarsest = next(s for s in levels.solutions.values() if self.name in s.distributions)
        if len(coarsest.distributions[self.name]) == 1:
            return 0.0
        rows = coarsest.distributions[self.name]
        rows = rows[np.isfinite(rows).all(axis=1)]
        count = len(rows)
        if count < 2:
            return float("nan")
        mean = rows.mean(axis=0)
        moves = [distance((count * mean - row) / (count - 1), mean, self.bins) for row in rows]
        error = np.sqrt((count - 1) / count * np.square(moves).sum())
        return float(special.stdtrit(count - 1, 0.975) * error)

    def compared(self, levels: Levels, resolution: int) -> tuple[float, float]:
        """Return how far a method's distribution is from it, and the bar of that."""
        if METHODS[levels.method].dimension == 3:
            both = self.truth.solution, levels.solutions[resolution]
            common = _common(self.name, *both)
            true, own = (last_histogram(solution, self.name, common) for solution in both)
            return distance(own, true, self.bins), self.bar()
        true = mean_histogram(self.truth.levels, self.name, self.truth.resolution)
        own = mean_histogram(levels, self.name, resolution)
        bars = [self.bar(), self.scatter(self.truth.levels), self.scatter(levels)]
        if resolution == levels.finest:
            bars.append(float(np.nan_to_num(self.change(levels, resolution))))
        return distance(own, true, self.bins), float(combined(*map(np.asarray, bars)))


def distribution_measures(
    plan: Plan, solved: Solved, method: str, resolution: int, truth: Truth
) -> list[Measure]:
    """Return name, distance and bar of each distribution of one solution that is compared."""
    levels = Levels.of(solved, method)
    solution = levels.solutions[resolution]
    measures = []
    for name in (name for name in DISTRIBUTIONS if name in plan.compared):
        true = TrueDistribution(plan, truth, name)
        if true.is_known and name in solution.distributions:
            apart, bar = true.compared(levels, resolution)
            measures.append((name, apart, bar))
    return measures


def distribution_rows(plan: Plan, solved: Solved) -> list[dict[str, Any]]:
    """Return each method's distributions at the last load on its finest grid, bin by bin.

    ``amount`` is the share of the nominal area, or the number of contacts on it, between ``low``
    and ``high``: a mean over surfaces or lines. Empty bins have no row.
    """
    rows = []
    for method in dict.fromkeys(method for method, _ in solved):
        levels = Levels.of(solved, method)
        finest = levels.finest
        known = () if finest is None else levels.solutions[finest].distributions
        for name in (name for name in DISTRIBUTIONS if name in known):
            assert finest is not None
            assert isinstance(plan.geometry, RoughGeometry)
            bins = edges(name, plan.scene, plan.geometry)
            amount = mean_histogram(levels, name, finest)
            common = {"scene": plan.scene.name, "method": method, "resolution": finest}
            rows += [
                common | {"quantity": name, "low": low, "high": high, "amount": float(part)}
                for low, high, part in zip(bins[:-1], bins[1:], amount, strict=True)
                if part > 0
            ]
    return rows


def field_measures(
    plan: Plan, solved: Solved, method: str, resolution: int, truth: Truth
) -> list[Measure]:
    """Return name, error and bar of each measure at the last load of one solution."""
    of_one = plan, solved, method, resolution, truth
    return [*pressure_measures(*of_one), *distribution_measures(*of_one)]


def field_bar(plan: Plan, truth: Truth, name: str) -> list[float]:
    """Return how well the truth knows a field at the last load; nothing where it gives none."""
    if name in DISTRIBUTIONS:
        distribution = TrueDistribution(plan, truth, name)
        return [distribution.bar()] if distribution.is_known else []
    pressure = TruePressure(plan, truth)
    return [pressure.bar()] if pressure.is_known else []
