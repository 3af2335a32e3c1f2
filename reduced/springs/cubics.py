"""A half line of monotone cubics on springs: contact edge, force and energy, exact per cell.

On a cell of width w and rise v, with the position s from 0 to 1, the height is
g = g_0 + v s (m_0 + s (3 - 2 m_0 - m_1 + s (m_0 + m_1 - 2))), m_0 and m_1 the slopes at its ends in
units of v/w, at most 3: then the cubic is monotone (Fritsch & Carlson 1980).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from reduced.profiles.quadrature import gauss_legendre

# Exact for the square of a cubic.
_NODES, _WEIGHTS = (tuple(map(float, part)) for part in gauss_legendre(4))
_EDGE_STEPS = 80
_EPSILON = float(np.finfo(float).eps)


class Half(NamedTuple):
    """Cubics of a half line from the axis outwards: n knots x with heights g, n - 1 cells.

    `start` and `end` are the slopes m_0, m_1 of the cells, `first` and `second` int g dx and
    int g^2 dx from 0 to every knot.
    """

    x: np.ndarray
    heights: np.ndarray
    start: np.ndarray
    end: np.ndarray
    first: np.ndarray
    second: np.ndarray


@njit(cache=True)
def half_line(x: np.ndarray, heights: np.ndarray, slopes: np.ndarray) -> Half:
    """Return cubics through knots x, from x = 0 outwards, with g and g' there, all (n,)."""
    n = x.size
    start, end = np.zeros(n - 1), np.zeros(n - 1)
    first, second = np.zeros(n), np.zeros(n)
    for i in range(n - 1):
        rise, width = heights[i + 1] - heights[i], x[i + 1] - x[i]
        if rise > 0.0:
            start[i] = min(max(slopes[i] * (width / rise), 0.0), 3.0)
            end[i] = min(max(slopes[i + 1] * (width / rise), 0.0), 3.0)
        area, squares = part_moments(heights[i], rise, width, start[i], end[i], 1.0)
        first[i + 1] = first[i] + area
        second[i + 1] = second[i] + squares
    return Half(x, heights, start, end, first, second)


@njit(cache=True)
def respond(half: Half, d: np.ndarray, out: np.ndarray) -> None:
    """Add contact length, F/E* and energy/E* of the half line at d > 0 (k,) to `out` (3, k)."""
    x, heights, starts, ends, first, second = half  # read once, not for every load
    last = starts.size - 1
    for k in range(d.size):
        cell = min(np.searchsorted(heights, d[k]) - 1, last)
        base, rise = heights[cell], heights[cell + 1] - heights[cell]
        start, end, width, part = starts[cell], ends[cell], x[cell + 1] - x[cell], 1.0
        if d[k] <= heights[-1]:  # the contact edge in the cell, by bracketed Newton steps
            goal, low, high = (d[k] - base) / rise, 0.0, 1.0
            part = goal
            for _ in range(_EDGE_STEPS):
                value, slope = rise_and_slope(start, end, part)
                if value < goal:
                    low = part
                else:
                    high = part
                step = part - (value - goal) / slope if slope > 0.0 else -1.0
                last_part = part
                part = step if low <= step <= high else 0.5 * (low + high)
                if abs(part - last_part) <= _EPSILON * part:
                    break
        area, squares = part_moments(base, rise, width, start, end, part)
        area, squares = area + first[cell], squares + second[cell]
        length = x[cell] + part * width
        out[0, k] += length
        out[1, k] += length * d[k] - area
        out[2, k] += (length * d[k] * d[k] - 2.0 * d[k] * area + squares) / 2.0


@njit(cache=True)
def rise_and_slope(m0, m1, s):
    """Return the relative rise in the cell and its derivative at s."""
    c2, c3 = 3.0 - 2.0 * m0 - m1, m0 + m1 - 2.0
    return s * (m0 + s * (c2 + s * c3)), m0 + s * (2.0 * c2 + s * 3.0 * c3)


@njit(cache=True)
def part_moments(base, rise, width, m0, m1, part):
    """Return exact integrals of height and its square over the first part of a cell."""
    area = squares = 0.0
    for k in range(len(_NODES)):
        value, _ = rise_and_slope(m0, m1, part * _NODES[k])
        height = base + rise * value
        area += _WEIGHTS[k] * height
        squares += _WEIGHTS[k] * (height * height)
    return part * width * area, part * width * squares
