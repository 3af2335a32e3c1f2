r"""Pressures that are steps on rings: their energy from below, in closed form.

A pressure that is uniform on concentric rings is a sum of pressures uniform on discs, and the
double integral of 1/r over two concentric discs of radii b <= a is, with k = b/a,

    I(a, b) = (8 pi/3) a b^2 [B(k) + E(k)]
            = (8 pi/3) a b^2 int (2 cos^2 t + (1 - k^2) sin^2 t)/(1 - k^2 sin^2 t)^(1/2) dt,

t from 0 to pi/2, the integral over the smaller disc of the potential 4 a E(r/a) of the larger one
(Johnson 1985, (3.29)); B and E are complete elliptic integrals, enclosed by `elliptic.complete`.
Sums over discs instead of differences over rings cancel no digits where the pressure falls
outwards.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from reference.bounds.elliptic import complete
from reference.bounds.interval import EPSILON

Array = NDArray[np.float64]

# Steps of the pressures, relative to the largest: differences of such numbers are exact.
_STEP = 2.0**-44
# Of the products around an elliptic integral, and of the integrals of d - g over a disc.
_FORMULA = 32 * EPSILON


def mutual_energies(radii: Array) -> tuple[Array, Array]:
    """Integrals of 1/|x - y| over all pairs of concentric discs, and bounds of their errors.

    Parameters
    ----------
    radii : ndarray, shape (n,)
        Positive radii of the discs, in any order.

    Returns
    -------
    (ndarray, ndarray), shape (n, n)

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


class Discs:
    """The best pressure on given rings, and what it proves.

    Parameters
    ----------
    radii : (n,)
        Outer radii of the rings, increasing; the innermost ring is a disc.
    """

    def __init__(self, radii: Array) -> None:
        self.radii = radii
        self.matrix, self.errors = (part / np.pi for part in mutual_energies(radii))
        self._factor = cho_factor(self.matrix)

    def energy_below(self, work: Array, magnitude: Array) -> float:
        r"""Lower bound of the energy, in units with E* = 1.

        For every pressure p >= 0 on the surface U >= <p, d - g> - <p, K p>/2, and the best
        multiple of p gives U >= <p, d - g>^2/(2 <p, K p>): the complementary energy of a
        frictionless contact is least for the true pressure (Kalker & van Randen 1972; Johnson
        1985, section 5.3). Pressures uniform on rings, the energy exact: collocation would bound
        nothing. Rounding is taken off.

        Parameters
        ----------
        work : (n,)
            Integrals of d - g over the discs, not rounded up by more than the magnitude allows.
        magnitude : (n,)
            The same integrals of d + g, for the rounding.
        """
        return bound_of_pressure(self, self.best_pressure(work), work, magnitude)

    def best_pressure(self, work: Array) -> Array:
        """Return the pressure on each ring with the least complementary energy, cut at zero."""
        return np.maximum(np.cumsum(cho_solve(self._factor, work)[::-1])[::-1], 0.0)


def bound_of_pressure(discs: Discs, pressure: Array, work: Array, magnitude: Array) -> float:
    """Lower bound of the energy that one pressure on the rings proves, see `Discs`.

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
    peak = pressure.max(initial=0.0)
    if peak == 0.0:
        return 0.0
    # Multiples of a power of two: the steps below are differences without rounding, so that the
    # pressure they add up to is the one that was tested for its sign.
    steps = np.round(pressure / peak / _STEP) * _STEP
    steps[:-1] -= steps[1:]
    rounding = 2 * len(steps) * EPSILON
    done = steps @ work - (rounding + _FORMULA) * (np.abs(steps) @ magnitude)
    stored = steps @ discs.matrix @ steps
    doubt = 2 * rounding * discs.matrix + discs.errors
    stored += np.abs(steps) @ doubt @ np.abs(steps)
    return float(done**2 / (2 * stored) * (1 - 8 * EPSILON)) if done > 0 else 0.0
