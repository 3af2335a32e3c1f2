"""Penetrations of rough lines at prescribed forces or mean gaps.

In units of E* dx and of dx the force Phi(d) of a line is convex with slope l(d), the contact
length. A prescribed force asks for Phi(d) = F; a prescribed mean gap g, with the mean depth ybar
below the highest peak and n cells, for Phi(d) = n (g - ybar) + n d. Both are zeros of a convex
function Phi(d) - t - s d with s = 0 or n, to which Newton's method comes monotonically from the
side where it is positive. It starts from the ordered heights of a short line, and on a long one
from walks over two ladders of levels, a coarse one and a fine one around the roots.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from .line_knots import roots
from .line_walk import FORCE, LENGTH, MEASURES, walk

PENETRATION, FORCE_CONTROL, GAP_CONTROL = range(3)
CONVERGED = (
    1e-12  # relative step; rounding of Phi keeps it from reaching one unit in the last place
)
_FINISHED = 5e-14  # so small a step is still taken, but the measures are those before it
_COARSE, _LADDER = 16, 64
_NEWTON = 100


@njit(cache=True, nogil=True)
def press_lines(
    depths: np.ndarray,
    starts: np.ndarray,
    means: np.ndarray,
    orders: np.ndarray,
    goals: np.ndarray,
    control: int,
    sub_cell: bool,
    periodic: bool,
    penetrations: np.ndarray,
    measures: np.ndarray,
    gaps: np.ndarray,
) -> np.ndarray:
    """Press lines one after the other; returns the last relative step of each inversion, (m,).

    Parameters
    ----------
    depths : ndarray, shape (m, n)
        Depths below each line's highest peak.
    starts, means : ndarray, shape (m,)
        Where each walk starts (see `line_walk.walk`), and the mean depths.
    orders : ndarray, shape (m, n) or (m, 0)
        Indices that order each line's depths, to be given for short lines; empty for long ones.
    goals : ndarray, shape (k,)
        Increasing penetrations, forces over E* dx, or mean gaps, as `control` says.
    control : int
        PENETRATION, FORCE_CONTROL or GAP_CONTROL.
    sub_cell, periodic : bool
        As for `line_walk.walk`.
    penetrations, gaps : ndarray, shape (m, k)
        Are filled with the penetrations and the mean gaps.
    measures : ndarray, shape (m, 6, k)
        Is filled with the measures of `line_walk.walk`.
    """
    residuals = np.zeros(depths.shape[0])
    room = _room(goals.size)
    for row in range(depths.shape[0]):
        depth, mean, d, order = depths[row], means[row], penetrations[row], orders[row]
        if control == PENETRATION:
            d[:] = goals
            walk(depth, starts[row], d, sub_cell, periodic, measures[row], room[0])
        elif control == FORCE_CONTROL:
            low = goals / depth.size
            residuals[row] = _invert(
                *(depth, starts[row], order, goals, 0.0, low, low + mean, sub_cell, periodic),
                *(d, measures[row], room),
            )
        else:
            residuals[row] = _press_to_gaps(
                depth, starts[row], order, mean, goals, sub_cell, periodic, d, measures[row], room
            )
        for j in range(goals.size):
            gap = mean - d[j] + measures[row, FORCE, j] / depth.size
            # In full contact only rounding would be left.
            full = measures[row, LENGTH, j] >= depth.size
            gaps[row, j] = 0.0 if full else max(gap, 0.0)
    return residuals


@njit(cache=True)
def _room(loads):
    """Arrays that all lines share: room for `walk`, measures, levels, last steps, open loads."""
    size = max(loads, _LADDER)
    numbers = np.empty(5 * (size + 1)), np.empty(MEASURES * size), np.empty(size), np.empty(size)
    return (*numbers, np.empty(size, np.int64))


@njit(cache=True)
def _press_to_gaps(depth, start, order, mean, goals, sub_cell, periodic, d, measures, room):
    """Penetrations and measures at mean gaps; gaps beyond first touch have no contact."""
    d[:] = mean - goals
    measures[:] = 0.0
    # Deeper for smaller gaps: turn the order, and leave out what does not touch.
    touching = np.searchsorted(goals, mean)
    if touching == 0:
        return 0.0
    low = mean - goals[:touching][::-1]
    found, part = np.empty(touching), np.empty((MEASURES, touching))
    n = float(depth.size)
    residual = _invert(
        *(depth, start, order, -n * low, n, low, low + depth.max()),
        *(sub_cell, periodic, found, part, room),
    )
    d[:touching] = found[::-1]
    measures[:, :touching] = part[:, ::-1]
    return residual


@njit(cache=True)
def _invert(depth, start, order, offset, slope, low, high, sub_cell, periodic, d, measures, room):
    """Zeros of Phi(d) - offset - slope d between low and high, with the measures there."""
    k = offset.size
    if order.size > 0:
        roots(depth, order, offset, slope, sub_cell, periodic, d)
        for i in range(k):
            d[i] = min(max(d[i], low[i]), high[i])
    else:
        _first_guess(depth, start, offset, slope, low, high, sub_cell, periodic, d, room[0])
    scratch, flat, levels, last, loads = room
    last[:k] = np.inf
    open_loads = loads[:k]
    open_loads[:] = np.arange(k)
    for _ in range(_NEWTON):
        count = open_loads.size
        _insertion_sort(open_loads, d)
        at, now = levels[:count], flat[: MEASURES * count].reshape(MEASURES, count)
        for i in range(count):
            at[i] = d[open_loads[i]]
        walk(depth, start, at, sub_cell, periodic, now, scratch)
        left = 0
        for i in range(count):
            load = open_loads[i]
            excess = now[FORCE, i] - offset[load] - slope * at[i]
            tilt = now[LENGTH, i] - slope
            # A level in full contact says nothing about a gap: back to the open side then.
            step = excess / tilt if tilt != 0.0 else at[i] - low[load]
            size = abs(step) / at[i]
            d[load] = min(max(at[i] - step, low[load]), high[load])
            if size <= _FINISHED or (size <= CONVERGED and size >= 0.5 * last[load]):
                for row in range(MEASURES):
                    measures[row, load] = now[row, i]
            else:
                open_loads[left] = load
                left += 1
            last[load] = size
        open_loads = open_loads[:left]
        if left == 0:
            break
    return last[:k].max()


@njit(cache=True)
def _insertion_sort(loads, d):
    """Order loads by penetration: they nearly are."""
    for i in range(1, loads.size):
        load, j = loads[i], i
        while j > 0 and d[loads[j - 1]] > d[load]:
            loads[j] = loads[j - 1]
            j -= 1
        loads[j] = load


@njit(cache=True)
def _first_guess(depth, start, offset, slope, low, high, sub_cell, periodic, guess, scratch):
    """Penetrations near the zeros, interpolated between the rungs of a ladder of levels.

    The walk gives Phi and its slope on every rung: a cubic through both (in logarithms for a force,
    which is nearly a power of d) leaves Newton's method two or three steps.
    """
    rungs, value, rate = _climb(
        depth, start, slope, low.min(), high.max(), _COARSE, sub_cell, periodic, scratch
    )
    # Closer rungs where the zeros are.
    first, last = 0, _COARSE - 1
    for j in range(1, _COARSE - 1):
        if (value[j] < offset[0]) == (slope == 0.0):
            first = j
    for j in range(_COARSE - 2, first, -1):
        if (value[j] < offset[-1]) != (slope == 0.0):
            last = j
    rungs, value, rate = _climb(
        depth, start, slope, rungs[first], rungs[last], _LADDER, sub_cell, periodic, scratch
    )
    j = 1
    for i in range(offset.size):
        if slope > 0.0:
            j = 1
        while j < _LADDER - 1 and (value[j] < offset[i]) == (slope == 0.0):
            j += 1
        a, b = rungs[j - 1], rungs[j]
        if slope > 0.0:
            span = value[j] - value[j - 1]
            part = (offset[i] - value[j - 1]) / span if span != 0.0 else 0.0
            guess[i] = a + (b - a) * _cubic(part, span / (b - a), rate[j - 1], rate[j])
        elif value[j - 1] > 0.0:
            span, width = np.log(value[j] / value[j - 1]), np.log(b / a)
            part = np.log(offset[i] / value[j - 1]) / span if span > 0.0 else 0.0
            begin, end = rate[j - 1] * a / value[j - 1], rate[j] * b / value[j]
            guess[i] = a * np.exp(width * _cubic(part, span / width, begin, end))
        else:
            guess[i] = b
        guess[i] = min(max(guess[i], low[i]), high[i])


@njit(cache=True)
def _climb(depth, start, slope, bottom, top, count, sub_cell, periodic, scratch):
    """Rungs in geometric progression, with the function Phi(d) - slope d and its rate on them."""
    ladder = np.empty((MEASURES, count))
    # Only ratios enter logarithms, so that other units of length give the same digits.
    rungs = bottom * np.exp(np.log(top / bottom) * np.arange(count) / (count - 1))
    rungs[-1] = top
    walk(depth, start, rungs, sub_cell, periodic, ladder, scratch)
    return rungs, ladder[FORCE] - slope * rungs, ladder[LENGTH] - slope


@njit(cache=True)
def _cubic(part, secant, begin, end):
    """Inverse of a monotone function across a cell of width 1, by a cubic Hermite polynomial.

    `part` is the share of the rise, `secant` the mean slope, `begin` and `end` the slopes at the
    ends; inverse slopes beyond three times the mean would let the cubic turn back.
    """
    start = min(secant / begin, 3.0) if begin != 0.0 else 3.0
    stop = min(secant / end, 3.0) if end != 0.0 else 3.0
    t = min(max(part, 0.0), 1.0)
    return t * (start + t * (3.0 - 2.0 * start - stop + t * (start + stop - 2.0)))
