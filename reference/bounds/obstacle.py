"""The least energy of coefficients that stay above given ones."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from reference.contact.pivot import compliance, pivot

Array = NDArray[np.float64]


def least_above(stiffness: Array, load: Array, floor: Array, touching: NDArray[np.bool_]) -> Array:
    """Minimise v . S v/2 - f . v over v >= floor (`reference.contact.pivot`).

    v - floor and the forces S v - f are complementary, as pressures and clearances are.

    Parameters
    ----------
    stiffness : (n, n)
        S, positive definite.
    load : (n,)
        f.
    floor : (n,)
    touching : (n,)
        Where v = floor to begin with.
    """
    # next to needles the matrix is nearly singular; a wrong set only makes a bound less sharp
    force = stiffness @ floor - load
    return floor + pivot(compliance(stiffness), force, ~touching, 0.0, rounding=1e-9).pressures
