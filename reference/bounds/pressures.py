"""Pressures uniform on rings, or on the cells of a fan: their energy in closed form."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from reference.bounds.duality import Pressures, least_above
from reference.bounds.interval import EPSILON, complete
from reference.bounds.outlines import Outline
from reference.bounds.quadrangles import areas, fan_cells, mutual_integrals

Array = NDArray[np.float64]

# Steps of the pressures on rings, relative to the largest: differences of such numbers are exact.
_STEP = 2.0**-44
# Of the products around an elliptic integral, and of the integrals of d - g over a disc.
_FORMULA = 32 * EPSILON
# Rounding of a cell's corners, and of the images of these, in parts of the largest coordinate.
_CORNER = 16 * EPSILON


def towards_edge(cells: int, exponent: float) -> Array:
    """Return factors (n + 1,) from 0 to 1, spaced more finely towards 1."""
    return 1 - (1 - np.arange(cells + 1) / cells) ** exponent


def mutual_energies(radii: Array) -> tuple[Array, Array]:
    r"""Integrals of 1/|x - y| over all pairs of concentric discs, and bounds of their errors.

    Over two discs of radii b <= a it is, with k = b/a,

        I(a, b) = (8 pi/3) a b^2 [B(k) + E(k)]
                = (8 pi/3) a b^2 int (2 cos^2 t + (1 - k^2) sin^2 t)/(1 - k^2 sin^2 t)^(1/2) dt,

    t from 0 to pi/2, the integral over the smaller disc of the potential 4 a E(r/a) of the larger
    one (Johnson 1985, (3.29)); B and E are complete elliptic integrals.

    Examples
    --------
    >>> import numpy as np
    >>> energy, error = mutual_energies(np.array([1.0]))
    >>> bool(abs(energy - 16 * np.pi / 3)[0, 0] < error[0, 0] < 1e-12)
    True
    """
    large = np.maximum(radii[:, None], radii[None, :])
    small = np.minimum(radii[:, None], radii[None, :])
    complement = (large - small) / large * ((large + small) / large)  # 1 - k^2
    same = large == small
    complement[same] = 1.0
    lower, upper = complete(complement, 2.0, complement)
    lower[same] = upper[same] = 2.0
    scale = 8 * np.pi / 3 * large * small**2
    return scale * 0.5 * (lower + upper), scale * (0.5 * (upper - lower) + _FORMULA * upper)


class Rings(Pressures):
    """Pressures uniform on concentric rings of these outer radii, increasing.

    They are sums of pressures uniform on discs, the amounts: sums over discs instead of differences
    over rings cancel no digits where the pressure falls outwards.
    """

    def __init__(self, radii: Array) -> None:
        self.radii = radii
        matrix, errors = (part / np.pi for part in mutual_energies(radii))
        self._factor = cho_factor(matrix)
        rounding = 2 * len(radii) * EPSILON
        errors += 2 * rounding * matrix
        super().__init__(matrix, errors, rounding + _FORMULA, 1 - 8 * EPSILON)

    def best(self, work: Array) -> Array:
        """Pressure of least complementary energy, cut at zero."""
        return np.maximum(np.cumsum(cho_solve(self._factor, work)[::-1])[::-1], 0.0)

    def amounts(self, pressure: Array) -> Array:
        """Return the steps of the pressure over its peak.

        Multiples of a power of two: they are differences without rounding, so that the pressure
        they add up to is the one that was tested for its sign.
        """
        steps = np.round(pressure / pressure.max() / _STEP) * _STEP
        steps[:-1] -= steps[1:]
        return steps


class Fan(Pressures):
    """Pressures uniform on the cells between copies of an outline, scaled by growing factors.

    Attributes
    ----------
    cells : (m n, 4, 2)
        Those of one image of the outline; the first factor is 0.
    areas : (m n,)
    """

    def __init__(self, outline: Outline, factors: Array) -> None:
        self.cells = fan_cells(outline.points, factors, closed=outline.closed)
        self.areas = areas(self.cells)
        # relative, of the areas and of the mutual integrals that they are factors of
        width = self.areas / np.hypot(*np.ptp(self.cells, axis=1).T)
        corners = _CORNER * float(np.abs(self.cells).max() / width.min())
        matrix, errors = (part / np.pi for part in mutual_integrals(self.cells, outline.images))
        rounding = (2 * len(matrix) + 64) * EPSILON
        images = len(outline.images) * (1 - rounding - 2 * corners)
        super().__init__(matrix, errors, rounding + corners, images)

    def best(self, work: Array) -> Array:
        """Pressure of least complementary energy."""
        zero = np.zeros(len(work))
        return least_above(self.matrix, work, zero, zero > 0)
