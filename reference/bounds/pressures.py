r"""Pressures uniform on the cells of a fan, and the energy that they prove from below.

For every pressure p >= 0 on the surface U >= <p, d - g> - <p, K p>/2, and the best multiple of p
gives U >= <p, d - g>^2/(2 <p, K p>): the complementary energy of a frictionless contact is least
for the true pressure (Kalker & van Randen 1972; Johnson 1985, section 5.3). The energy <p, K p> is
that of uniform pressure on every cell (Galerkin's), not displacements at the cells' centres times
forces (collocation), which bounds nothing.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from reference.bounds.cells import areas, fan_cells, mutual_integrals
from reference.bounds.interval import EPSILON
from reference.bounds.obstacle import least_above
from reference.bounds.outlines import Outline

Array = NDArray[np.float64]

# Rounding of a cell's corners, and of the images of these, in parts of the largest coordinate.
_CORNER = 16 * EPSILON


class FanPressures:
    """Uniform pressures on the cells between scaled copies of an outline.

    Parameters
    ----------
    outline : Outline
    factors : (n + 1,)
        Increasing from 0.

    Attributes
    ----------
    cells : (m n, 4, 2)
    areas : (m n,)
    images : int
        How many times the cells make up the whole.
    """

    def __init__(self, outline: Outline, factors: Array) -> None:
        self.cells = fan_cells(outline.points, factors, closed=outline.closed)
        self.areas = areas(self.cells)
        # relative, of the areas and of the mutual integrals that they are factors of
        width = self.areas / np.hypot(*np.ptp(self.cells, axis=1).T)
        self._corners = _CORNER * float(np.abs(self.cells).max() / width.min())
        self.images = len(outline.images)
        self.matrix, self._errors = (
            part / np.pi for part in mutual_integrals(self.cells, outline.images)
        )

    def best(self, work: Array) -> Array:
        """Pressure p >= 0 of least complementary energy for the integrals of d - g over cells."""
        zero = np.zeros(len(work))
        return least_above(self.matrix, work, zero, zero > 0)

    def energy_below(self, pressure: Array, work: Array, magnitude: Array) -> float:
        """Lower bound of the energy that a pressure proves, for E* = 1, with rounding taken off.

        Parameters
        ----------
        pressure : (m n,)
        work : (m n,)
            Integrals of d - g over the cells.
        magnitude : (m n,)
            The same of d + g, which scale the rounding.

        Raises
        ------
        ValueError
            For a pressure that is negative anywhere: it proves nothing.
        """
        if not (pressure >= 0).all():
            raise ValueError(
                f"pressure must be at least 0 everywhere, not {float(pressure.min())!r}: "
                "one that pulls proves no bound from below"
            )
        rounding = (2 * len(pressure) + 64) * EPSILON
        done = pressure @ work - (rounding + self._corners) * (pressure @ magnitude)
        stored = pressure @ self.matrix @ pressure + pressure @ self._errors @ pressure
        if done <= 0:
            return 0.0
        return float(self.images * done**2 / (2 * stored) * (1 - rounding - 2 * self._corners))
