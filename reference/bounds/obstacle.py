"""The least energy of coefficients that stay above given ones."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_ROUNDS = 60


def least_above(stiffness: Array, load: Array, floor: Array, touching: NDArray[np.bool_]) -> Array:
    """Minimise v . S v/2 - f . v over v >= floor by an active set (Hintermueller et al. 2002).

    What comes back is above the floor in any case, so a bound stays a bound even if the rounds
    were to end early; only its sharpness is at stake.

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
    for _ in range(_ROUNDS):
        free = ~touching
        v = floor.copy()
        if free.any():
            pull = load[free] - stiffness[np.ix_(free, touching)] @ floor[touching]
            v[free] = np.linalg.solve(stiffness[np.ix_(free, free)], pull)
        force = stiffness @ v - load
        loaded = np.where(touching, force > 0, v < floor)
        if np.array_equal(loaded, touching):
            break
        touching = loaded
    return np.maximum(v, floor)
