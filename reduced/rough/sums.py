"""Force, contact length and its rate of growth at many levels of a rough line.

These sums are needed repeatedly to invert a load. Contacts need not be distinguished, so all levels
that cut a cell are added in one step.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from reduced.rough.lines import Ends

FORCE, LENGTH, RATE = range(3)
_CELLS, _TOTAL = 3, 4  # whole cells and their mean heights, counted at the shallowest level
ROOM = 5


@njit(cache=True, error_model="numpy")
def add_up(depth: np.ndarray, levels: np.ndarray, ends: Ends, out: np.ndarray) -> None:
    """Compute the force Phi, its slope l and the rate l' of the slope at every level.

    Parameters
    ----------
    depth, levels, ends
        As for `walk.walk`.
    out : ndarray, shape (k + 1, ROOM)
        Output in the first three numbers of the first k rows: force over E* dx,
        contact length over dx, and the rate of growth of the length with penetration (0 for whole
        springs); the rest is workspace.
    """
    out[: levels.size + 1] = 0.0
    if ends.sub_cell:
        _cut_cells(depth, levels, ends.periodic, out)
    else:
        _whole_springs(depth, levels, out)
    count = total = 0.0
    for j in range(levels.size):
        count += out[j, _CELLS]
        total += out[j, _TOTAL]
        out[j, FORCE] += count * levels[j] - total
        out[j, LENGTH] += count


@njit(cache=True)
def _whole_springs(depth, levels, out):
    """Add every spring to the shallowest level at which it is in contact."""
    k, level = levels.size, 0
    lower, upper = -np.inf, levels[0]
    count = total = 0.0
    for i in range(depth.size):
        z = depth[i]
        if z < lower or z >= upper:
            out[level, _CELLS] += count
            out[level, _TOTAL] += total
            count = total = 0.0
            while level > 0 and levels[level - 1] > z:
                level -= 1
            while level < k and levels[level] <= z:
                level += 1
            lower = levels[level - 1] if level > 0 else -np.inf
            upper = levels[level] if level < k else np.inf
        count += 1.0
        total += z
    out[level, _CELLS] += count
    out[level, _TOTAL] += total


@njit(cache=True, error_model="numpy")
def _cut_cells(depth, levels, periodic, out):
    """Add every cell to the shallowest level fully in contact, and to all that cut it."""
    n, k = depth.size, levels.size
    # The walk starts with the cell across the seam, or half a flat cell at a free end.
    y = depth[n - 1]
    level = np.searchsorted(levels, y, side="right")
    if not periodic:
        out[level, _CELLS] += 0.5
        out[level, _TOTAL] += 0.5 * y
        y = depth[0]
        level = np.searchsorted(levels, y, side="right")
        out[level, _CELLS] += 0.5
        out[level, _TOTAL] += 0.5 * y
    lower = levels[level - 1] if level > 0 else -np.inf
    upper = levels[level] if level < k else np.inf
    count = total = 0.0
    for i in range(0 if periodic else 1, n):
        z = depth[i]
        if z < lower or z >= upper:
            out[level, _CELLS] += count
            out[level, _TOTAL] += total
            count = total = 0.0
            old = level
            while level > 0 and levels[level - 1] > z:
                level -= 1
            while level < k and levels[level] <= z:
                level += 1
            top, inverse = min(y, z), 1.0 / abs(z - y)
            for j in range(min(old, level), max(old, level)):
                deflection = levels[j] - top
                part = deflection * inverse
                out[j, FORCE] += 0.5 * deflection * part
                out[j, LENGTH] += part
                out[j, RATE] += inverse
            out[max(old, level), _CELLS] += 1.0
            out[max(old, level), _TOTAL] += 0.5 * (y + z)
            lower = levels[level - 1] if level > 0 else -np.inf
            upper = levels[level] if level < k else np.inf
        else:
            count += 1.0
            total += 0.5 * (y + z)
        y = z
    out[level, _CELLS] += count
    out[level, _TOTAL] += total
