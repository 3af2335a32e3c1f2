r"""Energy of a pressed body, between those of an admissible pressure and displacement.

A rigid body with the gap g, pressed by d into an elastic half-space without friction, stores

    U = max { <p, d - g> - <p, K p>/2 : p >= 0 } = min { <v, K^-1 v>/2 : v >= d - g },

K from pressure to displacement, E* = 1 (complementary energy: Kalker & van Randen 1972; Johnson
1985, section 5.3). So *every* pressure p >= 0 bounds U from below and *every* displacement
v >= d - g from above: solvers only look for sharp ones. The best multiple of p gives

    U >= <p, d - g>^2/(2 <p, K p>).

The pressures are uniform on rings, or on the cells of a fan, whose energy has a closed form; the
displacements are those of the surface of `dirichlet.Prisms`.
"""

from abc import ABC, abstractmethod

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from reference.arrays import Array, Mask
from reference.bounds.dirichlet import Prisms
from reference.bounds.interval import EPSILON, complete
from reference.bounds.outlines import Outline
from reference.bounds.quadrangles import areas, fan_cells, mutual_integrals
from reference.contact.pivot import compliance, pivot

# Steps of the pressures on rings, relative to the largest: differences of such numbers are exact.
_STEP = 2.0**-44
# Of the products around an elliptic integral, and of the integrals of d - g over a disc.
_FORMULA = 32 * EPSILON
# Rounding of a cell's corners, and of the images of these, in parts of the largest coordinate.
_CORNER = 16 * EPSILON


class Pressures(ABC):
    """Pressures uniform on parts of a surface, as sums of given ones times amounts x.

    The energy is that of whole parts (Galerkin's); displacements at their middles times forces
    (collocation) would bound nothing.

    The parts make up the whole by a number of `images`, less the relative rounding of the bound.
    For each <p, K p> is x . matrix . x to |x| . errors . |x|, and the work <p, d - g> is x . work,
    to a share `rounding` of |x| . magnitude, the same of d + g.
    """

    def __init__(self, matrix: Array, errors: Array, rounding: float, images: float) -> None:
        self.matrix, self.errors = matrix, errors
        self.rounding, self.images = rounding, images

    @abstractmethod
    def best(self, work: Array) -> Array:
        """Pressure p >= 0 on every part that nearly has the least complementary energy."""

    def amounts(self, pressure: Array) -> Array:
        """Return x for pressures p >= 0 on the parts: these, if not said otherwise."""
        return pressure


def mutual_energies(radii: Array) -> tuple[Array, Array]:
    r"""Integrals of 1/|x - y| over all pairs of concentric discs, and bounds of their errors.

    Over two discs of radii b <= a it is, with k = b/a,

        I(a, b) = (8 pi/3) a b^2 [B(k) + E(k)]
                = (8 pi/3) a b^2 int (2 cos^2 t + (1 - k^2) sin^2 t)/(1 - k^2 sin^2 t)^(1/2) dt,

    t from 0 to pi/2, the integral over the smaller disc of the potential 4 a E(r/a) of the larger
    one (Johnson 1985, (3.29)); B and E are complete elliptic integrals.
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


def energy_below(
    pressures: Pressures, work: Array, magnitude: Array, pressure: Array | None = None
) -> float:
    """Lower bound of the energy by the best pressure, or a given one, for E* = 1.

    Work and magnitude (n,) are the integrals of d - g and of d + g over what the amounts stand for.
    A pressure that is negative anywhere raises ValueError: it proves nothing.
    """
    if pressure is None:
        pressure = pressures.best(work)
    if not (pressure >= 0).all():
        raise ValueError(
            f"pressure must be at least 0 everywhere, not {float(pressure.min())!r}: "
            "one that pulls proves no bound from below"
        )
    if not pressure.any():
        return 0.0
    x = pressures.amounts(pressure)
    size = np.abs(x)
    done = x @ work - pressures.rounding * (size @ magnitude)
    stored = x @ pressures.matrix @ x + size @ pressures.errors @ size
    if done <= 0:
        return 0.0
    return float(pressures.images * done**2 / (2 * stored))


def energy_above(elements: Prisms, floor: Array, touching: Mask | None = None) -> float:
    """Upper bound of the energy by the least displacement above a floor, for E* = 1.

    The floor (n,) is in Bernstein's coefficients: with none below it v is nowhere below d - g. It
    covers the whole surface, -inf where nothing is asked. On the elements' retained coefficients
    the search begins with v = floor where it is touching; if that is not given, v stays there. On
    all others the floor must prove to be met.
    """
    retained = elements.retained
    v = floor[retained]
    if touching is not None:
        v = least_above(elements.stiffness, 0 * v, v, touching)
    values = elements.extend(v)
    if (values[elements.surface] < floor).any():
        raise ArithmeticError("the displacement falls below the body beyond the contact")
    return elements.energy_above(values)


def least_above(stiffness: Array, load: Array, floor: Array, touching: Mask) -> Array:
    """Minimise v . S v/2 - f . v over v >= floor, from v = floor where it is touching.

    v - floor and the forces S v - f are complementary, as pressures and clearances are
    (`reference.contact.pivot`).
    """
    # next to needles the matrix is nearly singular; a wrong set only makes a bound less sharp
    force = stiffness @ floor - load
    return floor + pivot(compliance(stiffness), force, ~touching, 0.0, rounding=1e-9).pressures
