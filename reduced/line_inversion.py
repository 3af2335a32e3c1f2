"""Penetrations of one rough line at prescribed forces or mean gaps.

In units of E* dx and of dx the force Phi(d) of a line is convex with slope l(d), the contact
length. A prescribed force asks for Phi(d) = F; a prescribed mean gap g, with the mean depth ybar
below the highest peak and n cells, for Phi(d) = n (g - ybar) + n d. Both are zeros of a convex
function Phi(d) - t - s d with s = 0 or n, to which Newton's method comes monotonically from the
side where it is positive. A walk over a ladder of levels brackets all roots first.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from .line_walk import FORCE, LENGTH, MEASURES, walk

PENETRATION, FORCE_CONTROL, GAP_CONTROL = range(3)
CONVERGED = (
    1e-12  # relative step; rounding of Phi keeps it from reaching one unit in the last place
)
_FINISHED = 4 * np.finfo(float).eps
_LADDER = 64
_NEWTON = 100


@njit(cache=True)
def press_line(
    heights: np.ndarray, goals: np.ndarray, control: int, sub_cell: bool, periodic: bool
) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """Penetrations, measures, mean gaps of one line, and the last relative step of the inversion.

    Parameters
    ----------
    heights : ndarray, shape (n,)
        Heights.
    goals : ndarray, shape (k,)
        Increasing penetrations, forces over E* dx, or mean gaps, as `control` says.
    control : int
        PENETRATION, FORCE_CONTROL or GAP_CONTROL.
    sub_cell, periodic : bool
        As for `line_walk.walk`.

    Returns
    -------
    tuple
        d (k,), measures (6, k), mean gap (k,), residual (float).
    """
    n, k = heights.size, goals.size
    depth, deepest, mean = _depths(heights)
    start = deepest if periodic else 0
    residual = 0.0
    if control == PENETRATION:
        d = goals.copy()
        measures = walk(depth, start, d, sub_cell, periodic)
    elif control == FORCE_CONTROL:
        low, high = goals / n, mean + goals / n
        d, measures, residual = _invert(depth, start, goals, 0.0, low, high, sub_cell, periodic)
    else:
        d = mean - goals
        measures = np.zeros((MEASURES, k))
        # Deeper for smaller gaps: turn the order, and leave out what does not touch.
        touching = np.flatnonzero(goals < mean)[::-1]
        if touching.size > 0:
            gap = goals[touching]
            low = mean - gap
            found, part, residual = _invert(
                depth, start, -n * low, float(n), low, low + depth.max(), sub_cell, periodic
            )
            d[touching] = found
            for row in range(MEASURES):
                measures[row][touching] = part[row]
    gaps = np.maximum(mean - d + measures[FORCE] / n, 0.0)
    return d, measures, gaps, residual


@njit(cache=True)
def _depths(heights):
    """Depths below the highest peak, the place of the deepest and the mean, in two passes."""
    top = heights[0]
    for h in heights:
        top = max(top, h)
    depth = np.empty_like(heights)
    deepest, total = 0, 0.0
    for i in range(heights.size):
        depth[i] = top - heights[i]
        total += depth[i]
        if depth[i] > depth[deepest]:
            deepest = i
    return depth, deepest, total / heights.size


@njit(cache=True)
def _invert(depth, start, offset, slope, low, high, sub_cell, periodic):
    """Zeros of Phi(d) - offset - slope d between low and high, with the measures there."""
    k = offset.size
    d = _first_guess(depth, start, offset, slope, low, high, sub_cell, periodic)
    measures = np.zeros((MEASURES, k))
    last = np.full(k, np.inf)
    open_loads = np.arange(k)
    for _ in range(_NEWTON):
        open_loads = open_loads[np.argsort(d[open_loads])]
        at = d[open_loads]
        now = walk(depth, start, at, sub_cell, periodic)
        unfinished = np.ones(open_loads.size, np.bool_)
        for i, load in enumerate(open_loads):
            excess = now[FORCE, i] - offset[load] - slope * at[i]
            tilt = now[LENGTH, i] - slope
            # A level in full contact says nothing about a gap: back to the open side then.
            step = excess / tilt if tilt != 0.0 else at[i] - low[load]
            size = abs(step) / at[i]
            if size <= _FINISHED or (size <= CONVERGED and size >= 0.5 * last[load]):
                measures[:, load] = now[:, i]
                unfinished[i] = False
            else:
                d[load] = min(max(at[i] - step, low[load]), high[load])
            last[load] = size
        open_loads = open_loads[unfinished]
        if open_loads.size == 0:
            break
    return d, measures, last.max()


@njit(cache=True)
def _first_guess(depth, start, offset, slope, low, high, sub_cell, periodic):
    """Penetrations near the zeros, interpolated between the rungs of a ladder of levels.

    The walk gives Phi and its slope on every rung: a cubic through both (in logarithms for a force,
    which is nearly a power of d) leaves Newton's method two or three steps.
    """
    # Only ratios enter logarithms, so that other units of length give the same digits.
    bottom, top = low.min(), high.max()
    rungs = bottom * np.exp(np.log(top / bottom) * np.arange(_LADDER) / (_LADDER - 1))
    rungs[-1] = top
    ladder = walk(depth, start, rungs, sub_cell, periodic)
    value, rate = ladder[FORCE] - slope * rungs, ladder[LENGTH] - slope
    guess = np.empty(offset.size)
    for i in range(offset.size):
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
    return guess


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
