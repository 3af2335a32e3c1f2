"""One walk along a rough line for all contact levels at once.

The line is given by its depths y_i >= 0 below its highest peak, the levels by increasing
penetrations d_k: point i is in contact at level k if y_i < d_k. From point to point, the number of
levels without contact changes only where the line crosses a level, and every crossing is an edge of
a contact. A walk therefore costs one step per point and one per contact edge, and needs no sorting;
cells fully inside a contact are added once, at the shallowest level that contains them, and summed
over levels at the end. Sums are never subtracted, so no digits are lost.

Lengths are in units of the spacing. Free lines end half a cell beyond their outer points.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

FORCE, LENGTH, SQUARES, COUNT, ENERGY = range(5)
# Per level: the beginning of the current contact, its extent beyond that point, and the number,
# heights and squares of the whole cells counted at this level.
_BEGIN, _REACH, _CELLS, _TOTAL, _SQUARE = range(5, 10)
ROOM = 10


class Ends(NamedTuple):
    """Ends of contacts and of lines.

    With `sub_cell` the line is linear between points and contacts end inside cells, else they are
    whole springs; with `periodic` the last point is a neighbour of the first.
    """

    sub_cell: bool
    periodic: bool


@njit(cache=True, error_model="numpy")
def walk(depth: np.ndarray, start: int, levels: np.ndarray, ends: Ends, out: np.ndarray) -> None:
    """Compute the measures of the contact at every level.

    `depth` (n,) are those below the highest peak, >= 0, `levels` (k,) non-decreasing penetrations.
    `start` is the deepest point of a periodic line (in contact only at full contact), 0 for a free
    one. The first five numbers of the first k rows of `out` (k + 1, ROOM) are force over E* dx,
    contact length, sum of squared contact lengths, number of contacts (lengths in dx) and energy
    over E* dx; the rest is workspace.
    """
    n, k = depth.size, levels.size
    sub_cell, periodic = ends
    out[: k + 1] = 0.0
    y = depth[start]
    level = np.searchsorted(levels, y, side="right")
    if not periodic:
        for j in range(level, k):
            out[j, _REACH] = _end_half_cell(out, j, levels[j] - y)
    level = _stretch(depth, start + 1, n, start, level, levels, sub_cell, out)
    if periodic:
        # of a plain zero Numba would compile it once more
        level = _stretch(depth, np.int64(0), start + 1, start - n, level, levels, sub_cell, out)
    for j in range(level, k):
        if periodic:
            _close(out, j, float(n))
        else:
            part = _end_half_cell(out, j, levels[j] - depth[n - 1])
            _close(out, j, (n - 1 - out[j, _BEGIN]) + out[j, _REACH] + part)
    # whole cells are summed from the shallowest level down
    third = 1.0 / 3.0 if sub_cell else 0.5
    count = total = square = 0.0
    for j in range(k):
        count += out[j, _CELLS]
        total += 0.5 * out[j, _TOTAL]
        square += third * out[j, _SQUARE]
        d = levels[j]
        out[j, FORCE] += count * d - total
        out[j, ENERGY] += 0.5 * (d * (count * d - 2.0 * total) + square)


@njit(cache=True, error_model="numpy")
def _stretch(depth, first, stop, origin, level, levels, sub_cell, out):
    """Walk from the point before the first over the points first ... stop - 1.

    `origin` is the index at the start of the walk, `level` the number of levels without contact at
    the point before the first; returns that of the last one.
    """
    k, y = levels.size, depth[first - 1]
    cross = 1.0 if sub_cell else 0.0
    lower = levels[level - 1] if level > 0 else -np.inf
    upper = levels[level] if level < k else np.inf
    count = total = square = 0.0  # sums of the whole cells since the last crossing
    for i in range(first, stop):
        z = depth[i]
        if z < lower or z >= upper:
            opens = z < lower
            if opens:
                count += 1.0
                total += y + z
                square += y * (y + cross * z) + z * z
            out[level, _CELLS] += count
            out[level, _TOTAL] += total
            out[level, _SQUARE] += square
            count = total = square = 0.0
            if opens:
                while level > 0 and levels[level - 1] > z:
                    level -= 1
                    out[level, _BEGIN] = i - origin
                    out[level, _REACH] = _edge_cell(out, level, levels[level] - z, y - z, sub_cell)
            else:
                while level < k and levels[level] <= z:
                    part = _edge_cell(out, level, levels[level] - y, z - y, sub_cell)
                    inner = i - 1 - origin - out[level, _BEGIN]
                    _close(out, level, inner + out[level, _REACH] + part)
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
    out[level, _CELLS] += count
    out[level, _TOTAL] += total
    out[level, _SQUARE] += square
    return level


@njit(cache=True, error_model="numpy")
def _edge_cell(out, level, deflection, drop, sub_cell):
    """Add the cell with a contact edge; return the extent of the contact in it.

    `deflection` is that of the point in contact, `drop` the height difference in the cell.
    """
    if not sub_cell:
        return _end_half_cell(out, level, deflection)
    part = deflection / drop
    out[level, FORCE] += 0.5 * deflection * part
    out[level, ENERGY] += deflection * deflection * part / 6.0
    return part


@njit(cache=True)
def _end_half_cell(out, level, deflection):
    """Add the outer half of a whole spring: nodal edges, and the ends of a free line."""
    out[level, FORCE] += 0.5 * deflection
    out[level, ENERGY] += 0.25 * deflection * deflection
    return 0.5


@njit(cache=True)
def _close(out, level, length):
    """Register a complete contact."""
    out[level, LENGTH] += length
    out[level, SQUARES] += length * length
    out[level, COUNT] += 1.0
