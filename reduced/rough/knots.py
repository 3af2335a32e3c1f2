"""Exact penetrations of a short rough line from its sorted heights (piecewise quadratic force).

Between two neighbouring depths of the line the set of cells cut by the surface does not change:
the contact length grows at a constant rate (or not at all for nodal sums) and the force is
quadratic (linear) in d. One pass over the sorted depths covers all loads. Rates of cells with very
different slopes are added and subtracted in a compensated sum; all other sums only increase.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from reduced.rough.lines import Ends


@njit(cache=True, error_model="numpy")
def roots(
    depth: np.ndarray,
    order: np.ndarray,
    rising: bool,
    goals: np.ndarray,
    ends: Ends,
    depths: np.ndarray,
) -> None:
    """Compute the penetrations d at which the force over E* dx equals the goals.

    Parameters
    ----------
    depth : ndarray, shape (n,)
        Depths below the highest peak, >= 0.
    order : ndarray, shape (n,)
        Indices that sort the depths in increasing order, or in decreasing order if not `rising`.
    rising : bool
        Whether the order is increasing.
    goals : ndarray, shape (k,)
        Increasing forces.
    depths : ndarray, shape (k,)
        Output: the penetrations.
    """
    n = depth.size
    sub_cell, periodic = ends
    rises = _inverse_rises(depth, sub_cell, periodic)
    outer = 0.5 if sub_cell and not periodic else 0.0
    force = length = rate = carry = y = 0.0
    j = 0
    for i in range(goals.size):
        while j < n:
            point = order[j] if rising else order[n - 1 - j]
            t = depth[point] - y
            grown = t * (rate + carry)
            next_force = force + t * (length + 0.5 * grown)
            if next_force >= goals[i] and t > 0.0:
                break
            force, y = next_force, depth[point]
            length += grown
            before, after = rises[point], rises[point + 1]
            if not sub_cell or after == np.inf:  # a whole spring, or the flat cell behind a point
                length, after = length + 1.0, 0.0
            if before == np.inf:
                before = 0.0
            if point == 0 or point == n - 1:
                length += outer
            rate, carry = _add(rate, carry, after)
            rate, carry = _add(rate, carry, -before)
            j += 1
        missing = goals[i] - force
        slope_rate = max(rate + carry, 0.0)
        root = np.sqrt(length * length + 2.0 * slope_rate * missing)
        depths[i] = y + 2.0 * missing / (length + root)


@njit(cache=True)
def _add(total, carry, term):
    """Return the sum and its rounding error (Knuth's two-sum)."""
    result = total + term
    back = result - total
    return result, carry + ((total - (result - back)) + (term - back))


@njit(cache=True, error_model="numpy")
def _inverse_rises(depth, sub_cell, periodic):
    """Return the inverse rises of the cells before the points and of the last cell; inf if flat.

    Zero if cells are never cut: with whole springs, and beyond free ends.
    """
    n = depth.size
    out = np.zeros(n + 1)
    if not sub_cell:
        return out
    for i in range(1, n):
        out[i] = 1.0 / (depth[i] - depth[i - 1])
    out[0] = out[n] = 1.0 / (depth[0] - depth[n - 1]) if periodic else 0.0
    for i in range(n + 1):
        if out[i] == -np.inf:
            out[i] = np.inf
    return out
