"""The solutions of one method at all its resolutions: means over surfaces, convergence."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from comparisons.facts.methods import ELEMENTS, GRID, METHODS
from comparisons.judging.metrics import sizes_along_path
from comparisons.judging.multilevel import Estimate, estimate, in_words
from comparisons.judging.uncertainty import Kind, combined, discretisation, line_uncertainty
from comparisons.tasks.solution import Contact, Solution, Solved

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

    Over random surfaces the mean at a resolution is that of the coarsest, over many, and of the
    differences from one resolution to the next, over fewer (`multilevel`): so means at two
    resolutions differ by their grids alone. Another 3-D method than the leading grid
    (GRID) solves some of the same surfaces: its mean is that of the leading grid, and what the two
    differ by on the surfaces of both.
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
        several = anchor is not None and not all(map(anchor._single, anchor.solutions))
        return cls(method, solutions, anchor if several else None)

    @property
    def finest(self) -> int | None:
        """The finest resolution among those that solved the most load steps."""
        steps = {n: int(s.converged.any(axis=0).sum()) for n, s in self.solutions.items()}
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
        """Return the relative 95 % half-width of a mean, for the surfaces are a sample of many.

        NaN where the scatter is not known. For a single surface the mean is the value itself: zero.
        """
        if self._single(resolution):
            return np.zeros(self.solutions[resolution].converged.shape[1])
        means = self._means(name, resolution)
        return self._relative(means.half_width, means.mean, resolution)

    def standard_error(self, name: str, resolution: int) -> np.ndarray:
        """Return the standard error of a mean; NaN where there is one surface."""
        if self._single(resolution):
            return np.full(self.solutions[resolution].converged.shape[1], np.nan)
        return np.sqrt(self._means(name, resolution).parts.sum(axis=0))

    def apart(self, name: str, resolution: int, truth: Levels, finest: int) -> np.ndarray:
        """Return the relative 95 % half-width of its mean less the truth's, on common surfaces.

        Zero where both are the same surfaces on the same grids. Where the two share none it is
        that of two independent means.
        """
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
        """Return the grid uncertainty of a quantity of the finest solution, (k,).

        NaN with a single resolution.
        """
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
        return in_words(numbers, list(self.solutions)) if max(numbers, default=1) > 1 else ""

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
        leading grid over all its surfaces times r = <q>/<c>, which scatters with q - r c, because
        solvers differ by shares of the value. Along a path, where values pass zero, with q - c.
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

    def _nearest(self, resolution: int) -> int:
        """Return the leading grid's grid that is nearest in cells."""
        assert self.anchor is not None
        return min(self.anchor.solutions, key=lambda n: (abs(np.log(n / resolution)), n))

    def _relative(self, width: np.ndarray, mean: np.ndarray, resolution: int) -> np.ndarray:
        size = np.abs(mean)
        if self.solutions[resolution].path:
            size = sizes_along_path(size)
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.where(size > 0, width / size, np.nan)
