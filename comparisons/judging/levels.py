"""The solutions of one method at all its resolutions: means over surfaces, convergence."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from comparisons.facts.methods import METHODS
from comparisons.judging.metrics import sizes_along_path
from comparisons.judging.uncertainty import grid_uncertainty
from comparisons.tasks.solution import Solution, Solved


def mean_curves(solution: Solution) -> dict[str, np.ndarray]:
    """Return each quantity's mean over the realisations that converged, (k,)."""
    curves = {}
    for name, values in solution.quantities.items():
        count = np.isfinite(values).sum(axis=0)
        total = np.nansum(values, axis=0)
        curves[name] = np.divide(
            total, count, out=np.full(values.shape[1], np.nan), where=count > 0
        )
    return curves


def on_common_realisations(solved: Solved) -> Solved:
    """Take out of every 3-D ensemble the steps that another 3-D solution lost on the same surface.

    Means over different surfaces would differ by their scatter. A solution that lost a step on
    all surfaces takes part in nothing there, and removes nothing from the others.
    """
    ensembles = {
        key: solution
        for key, solution in solved.items()
        if METHODS[key[0]].dimension == 3 and len(solution.converged) > 1
    }
    if not ensembles:
        return solved
    kept = [s.converged | ~s.converged.any(axis=0) for s in ensembles.values()]
    common = np.logical_and.reduce(kept)
    if common.all():
        return solved
    return solved | {
        key: replace(
            solution,
            quantities={n: np.where(common, v, np.nan) for n, v in solution.quantities.items()},
        )
        for key, solution in ensembles.items()
    }


@dataclass(frozen=True)
class Levels:
    """One method's solutions, by resolution.

    Attributes
    ----------
    method : str
    solutions : dict
        Resolution -> Solution, ascending.
    """

    method: str
    solutions: dict[int, Solution]

    @classmethod
    def of(cls, solved: Solved, method: str) -> Levels:
        """Pick a method's solutions out of those of a scene."""
        return cls(method, {n: solved[m, n] for m, n in sorted(solved) if m == method})

    @property
    def finest(self) -> int | None:
        """The finest resolution among those that solved the most load steps."""
        steps = {n: int(s.converged.any(axis=0).sum()) for n, s in self.solutions.items()}
        most = max(steps.values(), default=0)
        return max((n for n, count in steps.items() if count == most > 0), default=None)

    def below(self, resolution: int) -> int | None:
        """Return the next coarser resolution."""
        return max((n for n in self.solutions if n < resolution), default=None)

    def discretisation(self, name: str) -> np.ndarray:
        """Return the grid uncertainty of a quantity of the finest solution, (k,).

        NaN with a single resolution.
        """
        curves = {n: mean_curves(s).get(name) for n, s in self.solutions.items()}
        kept = {n: curve for n, curve in curves.items() if curve is not None}
        last = list(self.solutions.values())[-1]
        if not kept:
            return np.full(last.converged.shape[1], np.nan)
        series = np.array(list(kept.values()))
        sizes = sizes_along_path(series[-1]) if last.path else None
        return grid_uncertainty(np.array(list(kept)), series, sizes=sizes)
