r"""Energy of a pressed body, between those of an admissible pressure and displacement.

A rigid body with the gap g, pressed by d into an elastic half-space without friction, stores

    U = max { <p, d - g> - <p, K p>/2 : p >= 0 } = min { <v, K^-1 v>/2 : v >= d - g },

K from pressure to displacement, E* = 1 (complementary energy: Kalker & van Randen 1972; Johnson
1985, section 5.3). So *every* pressure p >= 0 bounds U from below and *every* displacement
v >= d - g from above: solvers only look for sharp ones. The best multiple of p gives

    U >= <p, d - g>^2/(2 <p, K p>).
"""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import NDArray

from reference.bounds.dirichlet import Prisms
from reference.contact.pivot import compliance, pivot

Array = NDArray[np.float64]


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


def energy_above(
    elements: Prisms, floor: Array, touching: NDArray[np.bool_] | None = None
) -> float:
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


def least_above(stiffness: Array, load: Array, floor: Array, touching: NDArray[np.bool_]) -> Array:
    """Minimise v . S v/2 - f . v over v >= floor, from v = floor where it is touching.

    v - floor and the forces S v - f are complementary, as pressures and clearances are
    (`reference.contact.pivot`).
    """
    # next to needles the matrix is nearly singular; a wrong set only makes a bound less sharp
    force = stiffness @ floor - load
    return floor + pivot(compliance(stiffness), force, ~touching, 0.0, rounding=1e-9).pressures
