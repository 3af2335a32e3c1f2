r"""Square cells below a part of a rough surface: what pressures on them prove of it.

The gap g of a band-limited surface on a small square about a point c is g(c) + g'(c) (x - c) and a
rest that its largest curvatures bound. With the same of the displacement (`GridPotential`) the
conditions of a linear programme are proved everywhere on a cell, not at its middle.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from reference.bounds.interval import EPSILON
from reference.bounds.potentials import Expansion, GridPotential
from reference.bounds.trigonometric import Waves
from reference.halfspace import FreeOperator, fft
from reference.halfspace.solution import Press
from reference.loads import Load

Array = NDArray[np.float64]

# Squares per side of a cell.
_SQUARES = 4


class Block:
    """A rectangle of square cells, and the surface above it.

    Parameters
    ----------
    waves : Waves
        The heights; the first point of their map lies in the origin.
    top : float
        Height from which the gap is counted.
    spacing : float
        Side of the cells.
    corner : float
        Place of the outer corner of cell (0, 0), along x and along y.
    first, shape : (int, int)
        Number of the first cell along x and y, and of cells from there.

    Attributes
    ----------
    centres : (n, m)
        Gap in the middles of the cells.
    above_samples : float
        How far the body rises above the top at most, between the samples that this was found in.

    All for E* = 1.
    """

    def __init__(
        self,
        waves: Waves,
        top: float,
        spacing: float,
        corner: float,
        first: tuple[int, int],
        shape: tuple[int, int],
    ) -> None:
        self.shape, self.spacing = shape, spacing
        self.above_samples = max(waves.highest()[1] - top, 0.0)
        self.potential = GridPotential(shape, spacing, _SQUARES)
        self.operator = FreeOperator(shape, (spacing, spacing), 1.0)
        x, y = (
            corner / spacing + k + 0.5 + np.arange(float(n))
            for k, n in zip(first, shape, strict=True)
        )

        def above(place: tuple[float, float], order: tuple[int, int] = (0, 0)) -> Array:
            return waves.on((x + place[0]) * spacing, (y + place[1]) * spacing, order)

        places = self.potential.places
        self.centres = top - above((0.0, 0.0))
        self._gaps = [top - above(place) for place in places]
        self._slopes = [(-above(place, (1, 0)), -above(place, (0, 1))) for place in places]
        xx, xy, yy = waves.curvatures()
        half = self.potential.half
        rounding = 4 * waves.rounding + 4 * EPSILON * abs(top)
        # of the gap against the linear part, and of its mean over a square against the middle: the
        # mean along x for every y first, which leaves no mixed derivative
        self._rest = 0.5 * half**2 * (xx + 2 * xy + yy) + rounding
        self._bulge = half**2 / 6 * (xx + yy) + rounding

    def pressed(self, penetration: float, raised: Array | float = 0.0) -> Array:
        """Return the pressure under the body, raised in places, that is met in the cells' middles.

        It proves nothing by itself.
        """
        gap = self.centres - raised
        lowest = min(float(gap.min()), 0.0)
        press = Press(self.operator, gap - lowest)
        return fft.solve(press, Load("penetration", penetration - lowest)).pressure

    def shortfall(self, pressure: Array, penetration: float) -> tuple[Array, float]:
        """By how much a pressure fails at most, anywhere in each cell, to reach d - g.

        With an upper bound of <p, K p>, see `stored`.
        """
        worst, stored = np.zeros(self.shape), 0.0
        half = self.potential.half
        for gap, (along, across), u in zip(
            self._gaps, self._slopes, self.potential.expansions(pressure), strict=True
        ):
            sway = half * (np.abs(u.slope_x + along) + np.abs(u.slope_y + across))
            missing = penetration - gap - u.value + sway + u.under + self._rest
            # beyond the body's reach d - g is negative everywhere on the square
            reach = half * (np.abs(along) + np.abs(across)) + self._rest
            worst = np.maximum(worst, np.where(penetration - gap + reach > 0, missing, 0.0))
            stored += self.stored(pressure, u)
        return worst, stored

    def deepest(self, pressure: Array) -> tuple[Array, float]:
        """Upper bound of the displacement on each loaded cell; zero elsewhere. And of <p, K p>."""
        most, stored = np.zeros(self.shape), 0.0
        for u in self.potential.expansions(pressure):
            sway = self.potential.half * (np.abs(u.slope_x) + np.abs(u.slope_y))
            most = np.maximum(most, np.where(pressure > 0, u.value + sway + u.over, 0.0))
            stored += self.stored(pressure, u)
        return most, stored

    def stored(self, pressure: Array, u: Expansion) -> float:
        """Upper bound of the integral of p u over a square of each cell, p >= 0.

        The mean of value and slopes over a square about its middle is the value.
        """
        total = math.fsum((pressure * (u.value + u.over)).flat) * (1 + 16 * EPSILON)
        return total * (2 * self.potential.half) ** 2

    def force(self, pressure: Array) -> float:
        """Integral of a pressure."""
        return math.fsum(pressure.flat) * self.spacing**2

    def work(self, pressure: Array, penetration: float) -> float:
        """Lower bound of the integral of p (d - g), p >= 0."""
        mean = sum(self._gaps) / len(self._gaps)
        terms = pressure * (penetration - mean - self._bulge)
        rounding = 32 * EPSILON * math.fsum((pressure * (penetration + np.abs(mean))).flat)
        return (math.fsum(terms.flat) - rounding) * self.spacing**2
