"""One walk along a rough line for all contact levels at once.

The line is given by its depths y_i >= 0 below its highest peak, the levels by increasing
penetrations d_k: point i is in contact at level k when y_i < d_k. Walking from point to point, the
number of levels that leave a point out of contact changes only where the line crosses a level, and
every crossing is one edge of one contact. So a walk costs one step per point and one per contact
edge, and needs no sorting; what lies fully inside a contact is added once, at the shallowest level
that contains it, and summed over levels at the end. Nothing is subtracted that was added before, so
no digits are lost to running sums.

Lengths are in units of the spacing. Free lines end half a cell beyond their outer points.
"""

from __future__ import annotations

import numpy as np
from numba import njit

FORCE, LENGTH, SQUARES, COUNT, LONGEST, ENERGY = range(6)
MEASURES = 6


@njit(cache=True)
def walk(
    depth: np.ndarray, start: int, levels: np.ndarray, sub_cell: bool, periodic: bool
) -> np.ndarray:
    """Measures of the contact at every level.

    Parameters
    ----------
    depth : ndarray, shape (n,)
        Depths below the highest peak, >= 0.
    start : int
        Index of the deepest point of a periodic line (no contact short of the full one passes it);
        0 for a free line.
    levels : ndarray, shape (k,)
        Increasing penetrations.
    sub_cell : bool
        Linear line between points and contacts that end inside cells; False: whole springs.
    periodic : bool
        Whether the last point is the first point's neighbour.

    Returns
    -------
    ndarray, shape (6, k)
        Force over E* dx, contact length, sum of squared contact lengths, number of contacts,
        longest contact (lengths in dx), energy over E* dx.
    """
    n, k = depth.size, levels.size
    out, full = np.zeros((MEASURES, k)), np.zeros((3, k + 1))
    first, lead = np.zeros(k, np.int64), np.zeros(k)
    y = depth[start]
    level = np.searchsorted(levels, y, side="right")
    if not periodic:
        for j in range(level, k):
            lead[j] = _end_half_cell(out, j, levels[j] - y)
    for i in range(1, n + 1 if periodic else n):
        at = start + i
        z = depth[at - n if at >= n else at]
        shallowest = level
        if z < y:
            while level > 0 and levels[level - 1] > z:
                level -= 1
                first[level] = i
                lead[level] = _edge_cell(out, level, levels[level] - z, y - z, sub_cell)
        else:
            while level < k and levels[level] <= z:
                part = _edge_cell(out, level, levels[level] - y, z - y, sub_cell)
                _close(out, level, (i - 1 - first[level]) + lead[level] + part)
                level += 1
            shallowest = level
        if shallowest < k:
            _whole_cell(full, shallowest, y, z, sub_cell)
        y = z
    for j in range(level, k):
        if periodic:
            _close(out, j, float(n))
        else:
            part = _end_half_cell(out, j, levels[j] - y)
            _close(out, j, (n - 1 - first[j]) + lead[j] + part)
    _sum_whole_cells(out, full, levels)
    return out


@njit(cache=True)
def _edge_cell(out, level, deflection, drop, sub_cell):
    """Add the cell that holds a contact edge; returns how far the contact reaches into it.

    `deflection` is that of the cell's point in contact, `drop` the height difference in the cell.
    """
    if not sub_cell:
        return _end_half_cell(out, level, deflection)
    part = deflection / drop
    out[FORCE, level] += 0.5 * deflection * part
    out[ENERGY, level] += deflection * deflection * part / 6.0
    return part


@njit(cache=True)
def _end_half_cell(out, level, deflection):
    """Add the outer half of a whole spring: nodal edges, and the ends of a free line."""
    out[FORCE, level] += 0.5 * deflection
    out[ENERGY, level] += 0.25 * deflection * deflection
    return 0.5


@njit(cache=True)
def _close(out, level, length):
    """Count a finished contact."""
    out[LENGTH, level] += length
    out[SQUARES, level] += length * length
    out[COUNT, level] += 1.0
    out[LONGEST, level] = max(out[LONGEST, level], length)


@njit(cache=True)
def _whole_cell(full, level, y, z, sub_cell):
    """Note a cell that lies inside a contact at this level and all deeper ones."""
    full[0, level] += 1.0
    full[1, level] += 0.5 * (y + z)
    if sub_cell:
        full[2, level] += (y * y + y * z + z * z) / 3.0
    else:
        full[2, level] += 0.5 * (y * y + z * z)


@njit(cache=True)
def _sum_whole_cells(out, full, levels):
    """Force and energy of the whole cells, summed from the shallowest level down."""
    count = depth = square = 0.0
    for j in range(levels.size):
        count += full[0, j]
        depth += full[1, j]
        square += full[2, j]
        d = levels[j]
        out[FORCE, j] += count * d - depth
        out[ENERGY, j] += 0.5 * (d * (count * d - 2.0 * depth) + square)
