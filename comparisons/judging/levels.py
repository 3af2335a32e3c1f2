"""The solutions of one method at all its resolutions: means over surfaces, convergence.

Means are by multilevel Monte Carlo: many surfaces on a coarse grid, few differences.

Between surfaces a quantity scatters by ten to thirty per cent, but the difference between two grids
on the same surface by one, and a fine grid costs a hundred times as much as a coarse one. So

    E[Q_L] = E[Q_0] + sum over l of E[Q_l - Q_(l-1)],

each mean over its own number of surfaces (M. B. Giles, Acta Numerica 24 (2015) 259, eq. 1.4). Here
the surfaces of a finer grid are the first of those of the coarser one, so that each is solved once
per grid. The terms then share surfaces: with Y_0 = Q_0, Y_l = Q_l - Q_(l-1) and n_l surfaces on
grid l, the variance of the sum is

    sum over l of a_l / n_l,   a_l = Var Y_l + 2 sum over m > l of Cov(Y_l, Y_m),

because two means over n_l >= n_m of the same surfaces have the covariance Cov(Y_l, Y_m) / n_l.

Features of a surface that cost no solve, as its highest peak, could serve as control variates
(Giles, section 2.1): they explain 1 % of the variance of the worst mean, which sets the numbers.

Estimates know of no scenes: arrays (surfaces, load steps) go in, NaN where a solve was lost.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy import special

from comparisons.facts.methods import ELEMENTS, GRID, METHODS
from comparisons.judging.metrics import sizes_along_path
from comparisons.judging.uncertainty import Kind, combined, discretisation, line_uncertainty
from comparisons.tasks.solution import Contact, Solution, Solved

# A variance from fewer surfaces than this says nothing.
FEWEST = 2
ROUND_OFF = 1e-12  # relative: what is prescribed scatters by it
# Multipliers of the constraints settle in some tens of rounds; more change no number of surfaces.
_ROUNDS = 500


@dataclass(frozen=True)
class Estimate:
    """A mean over random surfaces, and how well it is known."""

    # (m, k), mean on each grid, coarse to fine: partial sums, all with the surfaces of the first.
    levels: np.ndarray
    # (m, k), what each grid contributes to the variance of the last mean, a_l / n_l.
    parts: np.ndarray
    freedom: np.ndarray  # (k,), degrees of freedom of the variance (Welch and Satterthwaite)
    counts: np.ndarray  # (m, k), surfaces that each term is a mean over
    # Per load step: what is missing for a mean or for its bar; "" where nothing is.
    missing: tuple[str, ...]

    @property
    def mean(self) -> np.ndarray:
        """Mean on the finest grid, (k,)."""
        return self.levels[-1]

    @property
    def half_width(self) -> np.ndarray:
        """95 % half-width of the mean, (k,); NaN where the scatter is not known."""
        variance = self.parts.sum(axis=0)
        with np.errstate(invalid="ignore"):
            return special.stdtrit(self.freedom, 0.975) * np.sqrt(variance)

    def differing(self, level: int) -> np.ndarray:
        """Return the 95 % half-width of the finest grid's mean less that of another, (k,)."""
        if level == len(self.levels) - 1:
            return np.zeros(self.levels.shape[1])
        parts, counts = self.parts[level + 1 :], self.counts[level + 1 :]
        freedom = _freedom(parts, counts)
        with np.errstate(invalid="ignore"):
            return special.stdtrit(freedom, 0.975) * np.sqrt(parts.sum(axis=0))


def estimate(values: Sequence[np.ndarray]) -> Estimate:
    """Return the mean on the finest of several grids, of values (n_l, k) coarse to fine.

    Row i is the same surface on all grids. NaN where a solve was lost: the surface then takes part
    in no difference that needs it. Surfaces that a coarser grid does not have count on no finer
    one.

    >>> coarse = np.array([[1.0], [2.0], [3.0], [6.0]])
    >>> known = estimate([coarse, coarse[:2] + 0.5])
    >>> float(known.mean[0]), known.counts[:, 0].tolist(), known.missing
    (3.5, [4, 2], ('',))
    """
    terms = _terms(values)
    means, counts = (np.array(term) for term in zip(*map(_mean, terms), strict=True))
    levels = np.where(counts > 0, np.cumsum(np.nan_to_num(means), axis=0), np.nan)
    parts = np.where(counts > 0, [_part(terms, level) for level in range(len(terms))], 0.0)
    parts[-1, counts[-1] == 0] = np.nan
    # Rounding may leave less than nothing of a variance that covariances cancel.
    parts = np.where(parts.sum(axis=0) < 0, np.maximum(parts, 0.0), parts)
    missing = []  # at each load step, where a grid has too few surfaces
    for numbers in counts.T:
        alone = (numbers > 0) & (numbers < FEWEST)
        if numbers[-1] == 0:
            missing.append(f"no surface has an answer on grid {len(counts)} of {len(counts)}")
        elif alone.any():
            grid = f"grid {int(np.argmax(alone)) + 1} of {len(counts)}"
            missing.append(f"one surface on {grid}: how it scatters is not known")
        else:
            missing.append("")
    return Estimate(levels, parts, _freedom(parts, counts), counts, tuple(missing))


def variances(values: Sequence[np.ndarray]) -> np.ndarray:
    """Return a_l of each grid and load step, (m, k): the mean's variance is sum of a_l / n_l."""
    terms = _terms(values)
    counts = np.array([_mean(term)[1] for term in terms])
    return np.array([_part(terms, level) for level in range(len(terms))]) * counts


def allocate(variance: np.ndarray, cost: np.ndarray, allowed: np.ndarray) -> np.ndarray:
    """Return how many surfaces on each grid know all means well enough, at the least cost.

    Minimises sum n_l c_l under sum a_lj / n_l <= allowed_j for all j, with the costs c (m,) of a
    surface in any unit and the variances a (m, j). For one mean that is n_l = sqrt(a_l / c_l) sum
    sqrt(a_m c_m) / allowed (Giles, eq. 1.6); for several the same with sum over j of w_j a_lj, the
    weights w grown where a mean is known too badly, shrunk where it is known better than asked. The
    numbers do not increase.

    >>> allocate(np.array([[1.0], [0.01]]), np.array([1.0, 4.0]), np.array([0.01])).tolist()
    [120, 6]
    """
    variance, cost, allowed = (
        np.asarray(array, dtype=float) for array in (variance, cost, allowed)
    )
    if not (np.isfinite(variance).all() and np.isfinite(cost).all() and (cost > 0).all()):
        raise ValueError("variances and costs must be finite, and costs positive")
    if not (allowed > 0).all():
        raise ValueError("no number of surfaces knows a mean without any error")
    # Covariances may take away from a grid more than its own variance: it then needs no surfaces.
    shares = np.maximum(variance, 0.0) / allowed
    weights = np.full(shares.shape[1], 1.0 / shares.shape[1])
    numbers = np.zeros(len(cost))
    for _ in range(_ROUNDS):
        weighted = shares @ weights
        numbers = np.sqrt(weighted / cost) * np.sqrt(weighted * cost).sum()
        reached = (shares / np.maximum(numbers, 1e-300)[:, None]).sum(axis=0)
        if reached.max() <= 0:
            break
        weights *= reached / reached.max()
        weights /= weights.sum()
    numbers = numbers * max(reached.max(), 0.0)
    counts = np.maximum(np.ceil(numbers * (1 - 1e-9)), FEWEST)
    # The surfaces of a finer grid are among those of the coarser ones.
    return np.maximum.accumulate(counts[::-1])[::-1].astype(int)


def within_budget(numbers: np.ndarray, cost: np.ndarray, budget: float) -> np.ndarray:
    """Return numbers in the same proportion that cost no more than a budget, at least FEWEST.

    >>> within_budget(np.array([400, 40]), np.array([1.0, 5.0]), 300.0).tolist()
    [200, 20]
    """
    total = float(numbers @ cost)
    if total <= budget:
        return numbers
    needed = FEWEST * float(cost.sum())
    if needed > budget:
        raise ValueError(
            f"a budget of {budget:.3g} is too small: {FEWEST} surfaces on each grid, the fewest "
            f"that know how much they scatter, cost {needed:.3g}"
        )
    scaled = np.maximum(np.floor(numbers * (budget / total)), FEWEST).astype(int)
    while float(scaled @ cost) > budget:  # what the fewest of one grid take is saved on the first
        scaled[np.argmax(scaled > FEWEST)] -= 1
    return scaled


def ensemble_text(method: str, numbers: Sequence[int], resolutions: Sequence[int]) -> str:
    """Return how many surfaces or lines a method solves on which grid; "" where it is no matter.

    >>> ensemble_text("bem_fft", [450, 38, 9], [64, 128, 256])
    '450 surfaces at 64, 38 at 128, 9 at 256'
    """
    if not numbers:
        return ""
    first, *rest = [f"{n} at {grid}" for n, grid in zip(numbers, resolutions, strict=True)]
    noun = "line" if METHODS[method].dimension == 1 else "surface"
    plural = noun if numbers[0] == 1 else f"{noun}s"
    return ", ".join([first.replace(" at", f" {plural} at", 1), *rest])


def _terms(values: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Return Y_l, (k, n_l) each: the difference to the next coarser grid that has any answer."""
    # by load step: sums along contiguous rows take a fifth of the time
    grids = [np.array(np.asarray(answers, dtype=float).T, order="C") for answers in values]
    if not grids:
        raise ValueError("a mean needs at least one grid")
    terms, below = [], np.zeros_like(grids[0])
    for whole in grids:
        grid = whole[:, : below.shape[1]]
        below = below[:, : grid.shape[1]]
        terms.append(grid - below)
        below = np.where(np.isfinite(grid).any(axis=1, keepdims=True), grid, below)
    return terms


def _mean(term: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return mean and number of the surfaces that have an answer, (k,) each."""
    known = np.isfinite(term)
    count = known.sum(axis=1)
    with np.errstate(invalid="ignore"):
        return np.where(known, term, 0.0).sum(axis=1) / count, count


def _part(terms: Sequence[np.ndarray], level: int) -> np.ndarray:
    """Return what a term adds to the variance: its own, and twice its covariances with finer ones.

    Of two means that is the covariance of the surfaces times shared surfaces, over both numbers.
    """
    total = np.zeros(len(terms[0]))
    for finer, term in enumerate(terms[level:], level):
        pair = terms[level][:, : term.shape[1]], term
        shared = np.isfinite(pair[0]) & np.isfinite(pair[1])
        number = shared.sum(axis=1)
        counts = [np.isfinite(terms[index]).sum(axis=1) for index in (level, finer)]
        with np.errstate(invalid="ignore", divide="ignore"):
            means = [np.where(shared, t, 0.0).sum(axis=1) / number for t in pair]
            first, second = (t - mean[:, None] for t, mean in zip(pair, means, strict=True))
            product = np.where(shared, first * second, 0.0).sum(axis=1)
            covariance = product / (number - 1) * number / counts[0] / counts[1]
        if finer > level:  # without a shared pair nothing is known to be common
            total += 2 * np.where(number >= FEWEST, covariance, 0.0)
        else:
            total += np.where(number >= FEWEST, covariance, np.nan)
    return total


def _freedom(parts: np.ndarray, counts: np.ndarray) -> np.ndarray:
    """Return the degrees of freedom of a sum of variances, by Welch and Satterthwaite.

    As many surfaces on all grids are one sample, of the finest: its parts cancel.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        spread = (parts**2 / np.maximum(counts - 1, 1)).sum(axis=0)
        freedom = parts.sum(axis=0) ** 2 / spread
    several = (counts != counts[-1]).any(axis=0) & (spread > 0)
    return np.where(several, np.maximum(freedom, 1.0), np.maximum(counts[-1] - 1, 1))


Curves = dict[str, np.ndarray]


def mean_curves(solution: Solution) -> Curves:
    """Return each quantity's mean over the realisations that converged, (k,)."""
    curves = {}
    for name, values in solution.quantities.items():
        count = np.isfinite(values).sum(axis=0)
        total = np.nansum(values, axis=0)
        curves[name] = np.divide(
            total, count, out=np.full(values.shape[1], np.nan), where=count > 0
        )
    return curves


@dataclass(frozen=True)
class Levels:
    """One method's solutions, by resolution.

    Over random surfaces means at two resolutions differ by their grids alone. Another 3-D method
    than the leading grid (GRID) solves some of the same surfaces: its mean is that of the leading
    grid, and what the two differ by on the surfaces of both, where its answers scatter with that
    grid's.
    """

    method: str
    solutions: dict[int, Solution]  # resolution -> Solution, ascending
    anchor: Levels | None = None  # those of the leading grid
    _estimates: dict[tuple[str, int], Estimate] = field(
        default_factory=dict, repr=False, compare=False
    )

    @classmethod
    def of(cls, solved: Solved, method: str) -> Levels:
        """Pick a method's solutions out of those of a scene."""
        solutions = {n: solved[m, n] for m, n in sorted(solved) if m == method}
        anchor = None
        if METHODS[method].dimension == 3 and method != GRID:
            anchor = cls.of(solved, GRID)
            if all(map(anchor._single, anchor.solutions)):
                anchor = None
        levels = cls(method, solutions, anchor)
        return levels if levels._follows_anchor() else cls(method, solutions)

    @property
    def finest(self) -> int | None:
        """The finest resolution among those that answered the most load steps."""
        steps = {n: int(s.answered.any(axis=0).sum()) for n, s in self.solutions.items()}
        most = max(steps.values(), default=0)
        return max((n for n, count in steps.items() if count == most > 0), default=None)

    def below(self, resolution: int) -> int | None:
        """Return the next coarser resolution."""
        return max((n for n in self.solutions if n < resolution), default=None)

    def curves(self, resolution: int) -> Curves:
        """Return each quantity's mean over the surfaces at a resolution, (k,)."""
        solution = self.solutions[resolution]
        if self._single(resolution):
            return mean_curves(solution)
        return {name: self._means(name, resolution).mean for name in solution.quantities}

    def cost(self, resolution: int) -> dict[str, float]:
        """Return the seconds, with those of the set-up, of all solves that a mean stands on."""
        coarsest = 0 if self.anchor is None and not self._single(resolution) else resolution
        own = [s for n, s in self.solutions.items() if coarsest <= n <= resolution]
        below = {} if self.anchor is None else self.anchor.cost(self._nearest(resolution))
        return {
            f"{name}_all": below.get(f"{name}_all", 0.0) + sum(getattr(s, name) for s in own)
            for name in ("seconds", "setup_seconds")
        }

    def scatter(self, name: str, resolution: int) -> np.ndarray:
        """Return the relative 95 % half-width of a mean, or NaN; zero of a single surface."""
        if self._single(resolution):
            return np.zeros(self.solutions[resolution].converged.shape[1])
        means = self._means(name, resolution)
        return self._relative(means.half_width, means.mean, resolution)

    def standard_error(self, name: str, resolution: int) -> np.ndarray:
        """Return the standard error of a mean over several surfaces."""
        return np.sqrt(self._means(name, resolution).parts.sum(axis=0))

    def apart(self, name: str, resolution: int, truth: Levels, finest: int) -> np.ndarray:
        """Return the relative 95 % half-width of its mean less the truth's, on common surfaces."""
        if self._single(resolution):
            return np.zeros(self.solutions[resolution].converged.shape[1])
        means = truth._means(name, finest)
        if self.method == truth.method:
            width = means.differing([n for n in truth.solutions if n <= finest].index(resolution))
        elif self.anchor is not None and truth.method == GRID:
            near = self._nearest(resolution)
            index = [n for n in truth.solutions if n <= finest].index(near)
            width = combined(means.differing(index), self._paired(name, resolution).half_width)
        else:
            width = combined(means.half_width, self._means(name, resolution).half_width)
        return self._relative(width, means.mean, resolution)

    def discretisation(self, name: str) -> np.ndarray:
        """Return the grid uncertainty of a quantity of the finest solution, (k,); or NaN."""
        curves = {
            n: self.curves(n)[name] for n, s in self.solutions.items() if name in s.quantities
        }
        last = list(self.solutions.values())[-1]
        if not curves:
            return np.full(last.converged.shape[1], np.nan)
        series = np.array(list(curves.values()))
        sizes = sizes_along_path(series[-1]) if last.path else None
        areas = None if self.finest is None else self.curves(self.finest).get("contact_area")
        grids = np.array(list(curves))
        known, apparent = (name, self.kind), last.apparent_area
        bar = discretisation(grids, series, known, sizes=sizes, areas=areas, apparent=apparent)
        zero = (series == 0).all(axis=0)  # as the stick of a contact that slips all over
        if len(series) > 1 and not zero.all():
            unseen = 0.0
            if name == "stick_area" and sizes is not None and areas is not None:
                # A disc between four cell centres, of 1.6 cells, is the largest that holds none.
                # N cells are a contact radius, or a side. What rolls may stick in more, a crescent
                # along its leading edge; but that is no path, and no error is relative to a zero.
                whole = np.nanmax(areas) / np.pi if np.isnan(apparent) else apparent
                unseen = 2 * whole / grids[-1] ** 2 / np.where(sizes > 0, sizes, np.nan)
            bar = np.where(zero, unseen, bar)
        located = METHODS[self.method].grid and self.rough and "contact_area_raw" in last.quantities
        if name != "contact_area" or not located:
            return bar
        # of cells at the contact line, on the finest grid that has any area
        finest = max(
            (n for n, area in curves.items() if np.isfinite(area).any()), default=max(curves)
        )
        sides = finest, (self.solutions[finest].unknowns or finest**2) / finest
        counted = self.curves(finest)["contact_area_raw"]
        periodic = self._contact == "periodic"
        return combined(bar, line_uncertainty(curves[finest], counted, sides, periodic=periodic))

    @property
    def kind(self) -> Kind | None:
        """As what the share of an error was measured, None if it was not."""
        row, contact = METHODS[self.method], self._contact
        if contact == "single":
            return "cells" if row.grid else "elements" if self.method == ELEMENTS else None
        if contact == "pair":
            return "pair"
        if not contact or row.dimension != 3:
            return None
        # of elements under periodic surfaces the wider share holds
        return contact if row.grid else "free"

    @property
    def rough(self) -> bool:
        """Whether it is a rough surface without physics."""
        return self._contact in ("free", "periodic")

    @property
    def _contact(self) -> Contact:
        return next(reversed(self.solutions.values())).contact

    @property
    def ensemble(self) -> str:
        """How many surfaces were solved on which grid; "" where there is only one surface."""
        numbers = [len(solution.converged) for solution in self.solutions.values()]
        several = max(numbers, default=1) > 1
        return ensemble_text(self.method, numbers, list(self.solutions)) if several else ""

    def missing(self, name: str, resolution: int) -> tuple[str, ...]:
        """Return per load step what is missing for a mean or its bar; "" where nothing is."""
        if self._single(resolution):
            return ("",) * self.solutions[resolution].converged.shape[1]
        return self._means(name, resolution).missing

    def _single(self, resolution: int) -> bool:
        """Whether there is one surface, which stands for nothing but itself."""
        return self.anchor is None and len(self.solutions[resolution].converged) == 1

    def _means(self, name: str, resolution: int) -> Estimate:
        """Return the mean of a quantity over the surfaces, on all grids up to a resolution."""
        key = name, resolution
        if key in self._estimates:
            return self._estimates[key]
        if self.anchor is None:
            grids = [s for n, s in self.solutions.items() if n <= resolution]
            found = estimate([s.quantities[name] for s in grids if name in s.quantities])
        else:
            # the leading grid's mean on the nearest grid, with what this method makes of it
            near = self._nearest(resolution)
            if name in self.anchor.solutions[near].quantities:
                means, pairs = self.anchor._means(name, near), self._paired(name, resolution)
                found = Estimate(
                    levels=np.vstack([means.levels, pairs.mean]),
                    parts=np.vstack([means.parts, pairs.parts]),
                    freedom=means.freedom,
                    counts=np.vstack([means.counts, pairs.counts]),
                    missing=pairs.missing,
                )
            else:
                found = estimate([self.solutions[resolution].quantities[name]])
        self._estimates[key] = found
        return found

    def _paired(self, name: str, resolution: int) -> Estimate:
        """Return this method's mean, and of its variance what is not the leading grid's.

        On the surfaces of both, q of this method and c of the leading grid: the mean is that of the
        leading grid times r = <q>/<c>, which scatters with q - r c; along a path, with q - c.
        """
        assert self.anchor is not None
        near = self._nearest(resolution)
        values = self.solutions[resolution].quantities[name]
        base = self.anchor.solutions[near].quantities[name]
        common = min(len(values), len(base))
        values, base = values[:common], base[:common]
        values, base = (
            np.where(np.isfinite(values + base), series, np.nan) for series in (values, base)
        )
        mean = self.anchor._means(name, near).mean
        if self.solutions[resolution].path:
            pairs = estimate([values - base])
            return replace(pairs, levels=(mean + pairs.mean)[None, :])
        with np.errstate(invalid="ignore", divide="ignore"):
            ratio = estimate([values]).mean / estimate([base]).mean
            pairs = estimate([(values - ratio * base) * (mean / estimate([base]).mean)])
        return replace(pairs, levels=(ratio * mean)[None, :])

    def _follows_anchor(self) -> bool:
        """Whether its answers scatter with the leading grid's, as those of solvers do.

        Those of a theory, or of a rule of thumb, do not: the grid's scatter would only add to
        theirs.
        """
        follows = []
        for resolution, solution in self.solutions.items() if self.anchor else ():
            assert self.anchor is not None
            near = self.anchor.solutions[self._nearest(resolution)]
            for name in solution.quantities.keys() & near.quantities.keys():
                paired = self._paired(name, resolution).half_width
                alone = estimate([solution.quantities[name]])
                known = np.maximum(paired, alone.half_width) > ROUND_OFF * np.abs(alone.mean)
                follows.extend(paired[known] < alone.half_width[known])
        return not follows or bool(np.mean(follows) > 0.5)

    def _nearest(self, resolution: int) -> int:
        """Return the leading grid's grid that is nearest in cells."""
        assert self.anchor is not None
        return min(self.anchor.solutions, key=lambda n: (abs(np.log(n / resolution)), n))

    def _relative(self, width: np.ndarray, mean: np.ndarray, resolution: int) -> np.ndarray:
        size = np.abs(mean)
        if self.solutions[resolution].path:
            size = sizes_along_path(size)
        with np.errstate(invalid="ignore", divide="ignore"):
            # a mean of zeros does not scatter: the gap of lines that are all closed
            return np.where(size > 0, width / size, np.where(width == 0, 0.0, np.nan))
