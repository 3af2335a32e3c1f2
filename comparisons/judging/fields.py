"""Pressures and distributions compared at the last load.

Of pressures: the L2 difference, the integral, the peak. Of distributions: how far values of equal
rank are apart. With x(s) the pressure, gap or size that a share s of all of them stays below, the
distance is int_0^1 |x_1 - x_2| ds over the mean of the truth (Wasserstein's, of first order): 10 %
is an average over the ranks. Both are normalised, as the area itself is a quantity of its own.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from scipy import special
from scipy.interpolate import LinearNDInterpolator

from comparisons.facts.methods import GRID, METHODS
from comparisons.facts.quantities import DISTRIBUTIONS
from comparisons.geometry.prepare import IndenterGeometry, RoughGeometry
from comparisons.judging.levels import Levels
from comparisons.judging.metrics import (
    SINGULAR_RING,
    Measure,
    grid_pressure_at,
    pressure_difference,
)
from comparisons.judging.truth import Truth
from comparisons.judging.uncertainty import SAFE, combined
from comparisons.methods.normal.closed_form import form_of
from comparisons.scene.polygons import distance_to_outline
from comparisons.solving.plan import Plan
from comparisons.tasks.distributions import edges
from comparisons.tasks.solution import Solution, Solved
from reference.closed_form import ClosedForm

Fields = dict[str, np.ndarray]


@dataclass(frozen=True)
class TruePressure:
    """The pressure that a truth gives at the last load."""

    plan: Plan
    truth: Truth

    @cached_property
    def form(self) -> ClosedForm | None:
        """The closed form of the shape, which knows where its pressure is singular."""
        geometry, scene = self.plan.geometry, self.plan.scene
        if not isinstance(geometry, IndenterGeometry) or not scene.half_space.uniform:
            return None
        return form_of(geometry.indenter, scene.effective_modulus)

    @property
    def formula(self) -> ClosedForm | None:
        """That, if it is the truth."""
        return self.form if self.truth.exact else None

    @property
    def is_known(self) -> bool:
        """Whether there is one: a closed form has it everywhere, a solution where it was kept."""
        return self.formula is not None or "pressure" in self.truth.solution.fields

    def at(self, fields: Fields) -> np.ndarray | None:
        """Return it at a method's points; None where the truth gives none."""
        x, y = fields["pressure_x"], fields["pressure_y"]
        if self.formula is not None:
            depth = float(self.truth.curves["penetration"][-1])
            return np.asarray(self.formula.pressure(x, y, depth))
        if not self.is_known:
            return None
        stored = self.truth.solution.fields
        if "pressure_shape" in stored:
            other_shape = fields.get("pressure_shape")
            shape = None if other_shape is None else tuple(int(n) for n in other_shape)
            return grid_pressure_at(stored, x, y, shape)
        points = np.stack([stored["pressure_x"], stored["pressure_y"]], axis=-1)
        # a half or a quarter stands for the whole
        x, y = (np.abs(c) if (p >= 0).all() else c for c, p in zip((x, y), points.T, strict=True))
        look_up = LinearNDInterpolator(points, stored["pressure"], fill_value=0.0)
        return np.asarray(look_up(x, y))

    def regular(self, fields: Fields) -> np.ndarray:
        """Return which points lie away from every singularity."""
        x, y = fields["pressure_x"], fields["pressure_y"]
        geometry, form = self.plan.geometry, self.form
        if form is not None and form.singular_at is not None:
            rho = form.relative_radius(x, y, float(self.truth.curves["penetration"][-1]))
            return np.abs(rho - (1.0 if form.singular_at == "edge" else 0.0)) > SINGULAR_RING
        corners = geometry.indenter.outline if isinstance(geometry, IndenterGeometry) else None
        if form is not None or corners is None or not isinstance(geometry, IndenterGeometry):
            return np.ones(len(x), dtype=bool)
        return distance_to_outline(x, y, corners) > SINGULAR_RING * geometry.contact_radius

    def bar(self, fields: Fields | None = None) -> float:
        """Return how well it is known, as an L2 difference; NaN with one resolution.

        The change from the next coarser resolution, at first order: with r the ratio of
        resolutions, 1.25 times that change over r - 1. A compared solution (`fields`) on coarser
        cells meets the mean over k of the truth's cells, in which errors at the contact's edges
        cancel: its bar is that of the change between means over k cells of the coarser grid.
        """
        if self.formula is not None:
            return 0.0
        coarser = self.truth.levels.below(self.truth.resolution)
        if coarser is None:
            return float("nan")
        coarse = self.truth.levels.solutions[coarser].fields
        finest = self.at(coarse) if "pressure" in coarse else None
        if finest is None:
            return float("nan")
        weight, keep = coarse["pressure_weight"], self.regular(coarse)
        before, after = coarse["pressure"], finest
        grids = (self.truth.solution.fields, fields or {}, coarse)
        own, other, shape = (known.get("pressure_shape") for known in grids)
        if own is not None and other is not None and shape is not None and not np.any(own % other):
            # how many of the truth's cells along x and y one cell of the solution covers; blocks of
            # as many as divide the coarser grid, kept where all of their cells are
            covered = own // other
            (bx, by), (nx, ny) = np.gcd(shape, covered), shape

            def in_blocks(array: np.ndarray) -> np.ndarray:
                split = array.reshape(nx // bx, bx, ny // by, by)
                return split.transpose(0, 2, 1, 3).reshape(-1, bx * by)

            if np.any(covered > 1):
                parts = in_blocks(weight)
                weight, keep = parts.sum(axis=1), np.asarray(in_blocks(keep).all(axis=1))
                pair = (in_blocks(p) * parts for p in (before, after))
                before, after = (products.sum(axis=1) / weight for products in pair)
        change = pressure_difference(before, weight, after, keep)
        return SAFE * change / (self.truth.resolution / coarser - 1)


def pressure_measures(
    plan: Plan, solved: Solved, method: str, resolution: int, truth: Truth
) -> list[Measure]:
    """Return name, error and bar of each pressure measure, without rings of `SINGULAR_RING`."""
    solution = solved[method, resolution]
    fields = solution.fields
    if "pressure" not in fields or not solution.converged[0, -1]:
        return []
    force = float(solution.quantities["force"][0, -1])
    integral = float(np.nansum(fields["pressure"] * fields["pressure_weight"]) / force - 1)
    measures = [("pressure_integral", integral, 0.0)]
    # A grid solver's pressure from FFT BEM's on its cells: both solve the same equations, so it is
    # of the order of their violations of the contact conditions, or one of them is wrong.
    other = solved.get((GRID, resolution)) if method != GRID else None
    if other is not None and other.converged[0, -1] and "pressure_shape" in fields:
        theirs, every = other.fields, np.ones(fields["pressure"].shape, dtype=bool)
        if np.array_equal(fields["pressure_shape"], theirs.get("pressure_shape", ())):
            same = pressure_difference(
                fields["pressure"], fields["pressure_weight"], theirs["pressure"], every
            )
            measures.append(("pressure_same_grid", same, 0.0))
    true = TruePressure(plan, truth)
    values = true.at(fields)
    if values is None:
        return measures
    keep = true.regular(fields) & np.isfinite(fields["pressure"])
    distance = pressure_difference(fields["pressure"], fields["pressure_weight"], values, keep)
    bar = true.bar(fields)
    return [*measures, ("pressure", distance, bar)]


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


def last_histograms(name: str, *solutions: Solution) -> list[np.ndarray]:
    """Return the means of a distribution at the last load over the surfaces of all, (bins,)."""
    common, means = min(len(solution.distributions[name]) for solution in solutions), []
    for solution in solutions:
        several = solution.distributions[name][:common]
        answered = several[np.isfinite(several).all(axis=1)]
        nothing = np.full(several.shape[1], np.nan)
        means.append(np.asarray(answered.mean(axis=0)) if len(answered) else nothing)
    return means


def mean_histogram(levels: Levels, name: str, resolution: int) -> np.ndarray:
    """Return a distribution's mean over surfaces: the coarsest grid's, and finer grids' changes."""
    grids = [s for n, s in levels.solutions.items() if n <= resolution and name in s.distributions]
    (mean,) = last_histograms(name, grids[0])
    for coarser, finer in pairwise(grids):
        before, after = last_histograms(name, coarser, finer)
        mean = mean + after - before
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
        before, after = last_histograms(self.name, *pair)
        return SAFE * distance(before, after, self.bins) / (resolution / coarser - 1)

    def scatter(self, levels: Levels) -> float:
        """Return the 95 % half-width of a mean by the jackknife; zero of a single surface."""
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
            true, own = last_histograms(self.name, *both)
            return distance(own, true, self.bins), self.bar()
        true = mean_histogram(self.truth.levels, self.name, self.truth.resolution)
        own = mean_histogram(levels, self.name, resolution)
        bars = [self.bar(), self.scatter(self.truth.levels), self.scatter(levels)]
        if resolution == levels.finest:
            bars.append(float(np.nan_to_num(self.change(levels, resolution))))
        return distance(own, true, self.bins), float(combined(*map(np.asarray, bars)))


def distribution_rows(plan: Plan, solved: Solved) -> list[dict[str, Any]]:
    """Return each method's distributions at the last load on its finest grid, by bins with any.

    ``amount`` is the share of the nominal area, or the number of contacts on it: a mean.
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
    measures = pressure_measures(plan, solved, method, resolution, truth)
    levels = Levels.of(solved, method)
    for name in (name for name in DISTRIBUTIONS if name in plan.compared):
        true = TrueDistribution(plan, truth, name)
        if true.is_known and name in levels.solutions[resolution].distributions:
            measures.append((name, *true.compared(levels, resolution)))
    return measures


def field_bar(plan: Plan, truth: Truth, name: str) -> list[float]:
    """Return how well the truth knows a field at the last load; nothing where it gives none."""
    if name in DISTRIBUTIONS:
        distribution = TrueDistribution(plan, truth, name)
        return [distribution.bar()] if distribution.is_known else []
    pressure = TruePressure(plan, truth)
    return [pressure.bar()] if pressure.is_known else []
