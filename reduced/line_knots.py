"""Penetrations of one short rough line from its ordered heights: piecewise quadratic, so exact.

Between two neighbouring depths of the line the set of cells cut by the surface does not change:
the contact length grows at a constant rate (or not at all for nodal sums) and the force is
quadratic (linear) in d. One pass over the ordered depths meets all loads. Rates of steep and flat
cells are added and taken away again, which costs digits when slopes differ by orders of magnitude:
the result is a start for Newton's method on the walk, which as a rule confirms it.
"""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True)
def roots(
    depth: np.ndarray,
    order: np.ndarray,
    offset: np.ndarray,
    slope: float,
    sub_cell: bool,
    periodic: bool,
    found: np.ndarray,
) -> None:
    """Zeros of Phi(d) - offset - slope d, see `line_inversion`; they increase along `offset`.

    Parameters
    ----------
    depth, order : ndarray, shape (n,)
        Depths, and the indices that put them in increasing order.
    offset : ndarray, shape (k,)
        Right-hand sides.
    slope : float
        0 for forces, n for mean gaps.
    sub_cell, periodic : bool
        As for `line_walk.walk`.
    found : ndarray, shape (k,)
        Is filled with the penetrations.
    """
    n = depth.size
    side = 1.0 if slope == 0.0 else -1.0
    force = length = rate = y = 0.0
    j = 0
    for i in range(offset.size):
        while j < n:
            t = depth[order[j]] - y
            next_force = force + t * (length + 0.5 * rate * t)
            excess = next_force - offset[i] - slope * (y + t)
            if t > 0.0 and side * excess >= 0.0:
                break
            force, y = next_force, y + t
            jump, bend = _knot(depth, order[j], sub_cell, periodic)
            length = max(length + rate * t + jump, 0.0)
            rate = max(rate + bend, 0.0)
            j += 1
        excess = force - offset[i] - slope * y
        tilt = length - slope
        root = np.sqrt(max(tilt * tilt - 2.0 * rate * excess, 0.0))
        total = tilt + side * root
        found[i] = y - 2.0 * excess / total if total != 0.0 else y


@njit(cache=True)
def _knot(depth, i, sub_cell, periodic):
    """Jump of the contact length, and of its rate of growth, as the surface passes point i."""
    if not sub_cell:
        return 1.0, 0.0
    n, y = depth.size, depth[i]
    jump = bend = 0.0
    for step in (-1, 1):
        other = i + step
        if other < 0 or other == n:
            if not periodic:
                jump += 0.5
                continue
            other = n - 1 if other < 0 else 0
        rise = depth[other] - y
        if rise != 0.0:
            bend += 1.0 / rise
        elif step == 1:
            jump += 1.0
    return jump, bend
