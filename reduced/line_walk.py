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
    depth: np.ndarray,
    start: int,
    levels: np.ndarray,
    sub_cell: bool,
    periodic: bool,
    out: np.ndarray,
    scratch: np.ndarray,
) -> None:
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
    out : ndarray, shape (6, k)
        Is filled with: force over E* dx, contact length, sum of squared contact lengths, number of
        contacts, longest contact (lengths in dx), energy over E* dx.
    scratch : ndarray, shape (5 (k + 1),) or longer
        Room to work in, so that short lines do not wait for memory.
    """
    n, k = depth.size, levels.size
    out[:] = 0.0
    # Per level: whole cells, their heights and squares, where the open contact begins, and how far
    # it reaches beyond that point.
    cells = scratch[: 5 * (k + 1)].reshape(5, k + 1)
    cells[:] = 0.0
    level = np.searchsorted(levels, depth[start], side="right")
    if not periodic:
        for j in range(level, k):
            cells[4, j] = _end_half_cell(out, j, levels[j] - depth[start])
    y = depth[start]
    level = _stretch(depth, y, start + 1, n, level, levels, sub_cell, cells, out, start)
    if periodic:
        y = depth[n - 1]
        level = _stretch(depth, y, 0, start + 1, level, levels, sub_cell, cells, out, start - n)
    for j in range(level, k):
        if periodic:
            _close(out, j, float(n))
        else:
            part = _end_half_cell(out, j, levels[j] - depth[n - 1])
            _close(out, j, (n - 1 - cells[3, j]) + cells[4, j] + part)
    _sum_whole_cells(out, cells, levels, 1.0 / 3.0 if sub_cell else 0.5)


@njit(cache=True)
def _stretch(depth, y, first, stop, level, levels, sub_cell, cells, out, origin):
    """Walk from a point at depth y to the points first ... stop - 1.

    `origin` is the index whose place on the walk is zero, `level` the number of levels that leave
    the point before the first out of contact; returns that of the last one.
    """
    k = levels.size
    cross = 1.0 if sub_cell else 0.0
    lower = levels[level - 1] if level > 0 else -np.inf
    upper = levels[level] if level < k else np.inf
    count = total = square = 0.0  # of the whole cells since the last crossing
    for i in range(first, stop):
        z = depth[i]
        if z < lower or z >= upper:
            opens = z < lower
            if opens:
                count += 1.0
                total += y + z
                square += y * (y + cross * z) + z * z
            cells[0, level] += count
            cells[1, level] += total
            cells[2, level] += square
            count = total = square = 0.0
            if opens:
                while level > 0 and levels[level - 1] > z:
                    level -= 1
                    cells[3, level] = i - origin
                    cells[4, level] = _edge_cell(out, level, levels[level] - z, y - z, sub_cell)
            else:
                while level < k and levels[level] <= z:
                    part = _edge_cell(out, level, levels[level] - y, z - y, sub_cell)
                    inner = i - 1 - origin - cells[3, level]
                    _close(out, level, inner + cells[4, level] + part)
                    level += 1
            lower = levels[level - 1] if level > 0 else -np.inf
            upper = levels[level] if level < k else np.inf
            if opens:
                y = z
                continue
        count += 1.0
        total += y + z
        square += y * (y + cross * z) + z * z
        y = z
    cells[0, level] += count
    cells[1, level] += total
    cells[2, level] += square
    return level


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
def _sum_whole_cells(out, cells, levels, third):
    """Force and energy of the whole cells, summed from the shallowest level down."""
    count = depth = square = 0.0
    for j in range(levels.size):
        count += cells[0, j]
        depth += 0.5 * cells[1, j]
        square += third * cells[2, j]
        d = levels[j]
        out[FORCE, j] += count * d - depth
        out[ENERGY, j] += 0.5 * (d * (count * d - 2.0 * depth) + square)
