r"""Force of a free rough patch at a penetration, between proved bounds.

The force is the value of a linear programme and of its dual (Barber 1974; u = K p everywhere):

    F = min { int q : q >= 0, K q >= d - g } = max { int (d - g) dm : m >= 0, K m <= 1 on supp m }.

So any pressure that pushes the surface down to the body *everywhere* carries at least F, and any
pressure that pushes the surface nowhere it acts deeper than a unit carries at most F in the mean of
d - g. Both are pressures uniform on the cells of a grid; that they keep their conditions between
the cells' centres is proved by `GridPotential`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import LinearOperator, cg

from reference.bounds.heights import Waves
from reference.bounds.interval import EPSILON, Interval
from reference.bounds.potentials import GridPotential
from reference.halfspace import FreeOperator, fft
from reference.halfspace.solution import Press
from reference.loads import Load

Array = NDArray[np.float64]

_SQUARES = 4
# Rounds in which a penetration too shallow is deepened, and a displacement too deep taken back.
_ROUNDS = 5


@dataclass(frozen=True)
class Gap:
    """The gap on every square of the grid's cells: value, slopes and bound of the rest."""

    values: list[Array]
    slopes: list[tuple[Array, Array]]
    rest: float
    bulge: float


class Patch:
    """A square patch of a band-limited rough surface over an elastic half-space.

    Parameters
    ----------
    heights : (n, n)
        Heights, growing towards the half-space; the surface is the trigonometric polynomial
        through them (`reference.surfaces.refine`), its area the n x n cells about the points.
    size : float
        Side of the patch.
    finer : int
        Cells per point along a side.
    """

    def __init__(self, heights: Array, size: float, finer: int = 4) -> None:
        points = heights.shape[0]
        if heights.shape != (points, points) or not np.isfinite(heights).all():
            raise ValueError(f"heights are a finite square map, not of shape {heights.shape}")
        self.size = float(size)
        self.grid = (finer * points, finer * points)
        self.spacing = size / self.grid[0]
        self.potential = GridPotential(self.grid, self.spacing, _SQUARES)
        waves = Waves(heights, (size, size))
        self.top = waves.highest()[0]
        xx, xy, yy = waves.curvatures()
        half = self.potential.half
        self.gap = Gap(
            values=[self.top - waves.at(self.grid, place) for place in self.potential.places],
            slopes=[
                (-waves.at(self.grid, place, (1, 0)), -waves.at(self.grid, place, (0, 1)))
                for place in self.potential.places
            ],
            rest=0.5 * half**2 * (xx + 2 * xy + yy) + 64 * EPSILON * np.abs(heights).sum(),
            # of the mean over a square against the middle
            bulge=half**2 / 6 * (xx + yy),
        )
        self.operator = FreeOperator(self.grid, (self.spacing, self.spacing), 1.0)
        self.centres = self.top - waves.at(self.grid, (0.0, 0.0))

    def force(self, penetration: float, effective_modulus: float) -> Interval:
        """Force at a penetration, counted from the highest sample of the surface.

        Raises
        ------
        ValueError
            For a penetration or modulus that is not positive and finite.
        """
        if not all(x > 0 and math.isfinite(x) for x in (penetration, effective_modulus)):
            raise ValueError(
                "penetration and modulus must be positive and finite, got "
                f"{penetration!r} and {effective_modulus!r}"
            )
        return effective_modulus * Interval(self._below(penetration), self._above(penetration))

    def on_grid(self, penetration: float) -> Array:
        """Return the pressure of the conditions at the cells' middles, which proves nothing."""
        return self._pressed(penetration, np.zeros(self.grid))

    def shortfall(self, pressure: Array, penetration: float) -> Array:
        """By how much a pressure fails at most, anywhere in each cell, to reach d - g."""
        worst = np.zeros(self.grid)
        half = self.potential.half
        for place, gap in enumerate(self.gap.values):
            u = self.potential.expansion(pressure, place)
            slope_x, slope_y = self.gap.slopes[place]
            sway = half * (np.abs(u.slope_x + slope_x) + np.abs(u.slope_y + slope_y))
            missing = penetration - gap - u.value + sway + u.under + self.gap.rest
            # beyond the body's reach d - g is negative everywhere on the square
            reach = half * (np.abs(slope_x) + np.abs(slope_y)) + self.gap.rest
            worst = np.maximum(worst, np.where(penetration - gap + reach > 0, missing, 0.0))
        return worst

    def deepest(self, pressure: Array, loaded: NDArray[np.bool_]) -> Array:
        """Upper bound of the displacement on each loaded cell; zero elsewhere."""
        most = np.zeros(self.grid)
        for place in range(len(self.gap.values)):
            u = self.potential.expansion(pressure, place)
            sway = self.potential.half * (np.abs(u.slope_x) + np.abs(u.slope_y))
            most = np.maximum(most, np.where(loaded, u.value + sway + u.over, 0.0))
        return most

    def _above(self, penetration: float) -> float:
        """Force of a pressure that reaches the body everywhere: of a body raised where it fails."""
        raised = np.zeros(self.grid)
        for _ in range(_ROUNDS):
            pressure = self._pressed(penetration, raised)
            shortfall = self.shortfall(pressure, penetration)
            raised += 1.02 * shortfall
            if shortfall.max() <= 1e-3 * penetration:
                break
        # what little is left is made up for by the whole body
        while (left := self.shortfall(pressure, penetration).max()) > 0:
            raised += 1.1 * left
            pressure = self._pressed(penetration, raised)
        return float(pressure.sum() * self.spacing**2 * (1 + self.grid[0] ** 2 * EPSILON))

    def _pressed(self, penetration: float, raised: Array) -> Array:
        gap = self.centres - raised
        lowest = min(float(gap.min()), 0.0)
        press = Press(self.operator, gap - lowest)
        return fft.solve(press, Load("penetration", penetration - lowest)).pressure

    def _below(self, penetration: float) -> float:
        """Mean of d - g under a pressure that pushes nowhere it acts deeper than a unit."""
        loaded = self.on_grid(penetration) > 0
        target = np.ones(self.grid)
        best = 0.0
        work = self._work(penetration)
        for _ in range(_ROUNDS):
            pressure = self._pushing(target, loaded)
            deepest = self.deepest(pressure, pressure > 0)
            best = max(best, float((pressure * work).sum() / deepest.max()))
            target -= np.maximum(deepest - np.quantile(deepest[loaded], 0.5), 0.0) * loaded
        return best * (1 - self.grid[0] ** 2 * EPSILON)

    def _work(self, penetration: float) -> Array:
        """Lower bounds of the integrals of d - g over the cells."""
        mean = sum(self.gap.values) / len(self.gap.values)
        return (penetration - mean - self.gap.bulge) * self.spacing**2

    def _pushing(self, target: Array, loaded: NDArray[np.bool_]) -> Array:
        """Pressure on loaded cells for given displacements of their middles, cut at zero."""
        inside = np.flatnonzero(loaded)

        def displacement(values: Array) -> Array:
            field = np.zeros(self.grid)
            field.flat[inside] = values
            return self.operator.apply(field).flat[inside]

        operator = LinearOperator((len(inside),) * 2, matvec=displacement, dtype=float)
        values, _ = cg(operator, target.flat[inside], rtol=1e-6, maxiter=400)
        pressure = np.zeros(self.grid)
        pressure.flat[inside] = np.maximum(values, 0.0)
        return pressure
