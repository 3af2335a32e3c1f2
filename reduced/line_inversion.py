"""Penetrations of one rough line at prescribed forces or mean gaps.

In units of E* dx and of dx the force Phi(d) of a line is convex with slope l(d), the contact length.
A prescribed force asks for Phi(d) = F; a prescribed mean gap g, with the mean depth ybar below the
highest peak and n cells, for Phi(d) = n (g - ybar) + n d. Both are zeros of a convex function
Phi(d) - t - s d with s = 0 or n, to which Newton's method comes monotonically from the side where the
function is positive. A walk over a ladder of levels brackets all roots first.
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
def press_line(heights, goals, control, sub_cell, periodic):
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
    depth = heights.max() - heights
    start = np.argmax(depth) if periodic else 0
    mean = depth.mean()
    residual = 0.0
    if control == PENETRATION:
        d = goals.copy()
        measures = walk(depth, start, d, sub_cell, periodic)
    elif control == FORCE_CONTROL:
        low, high = goals / n, mean + goals / n
        d, measures, residual = _invert(
            depth, start, goals, 0.0, low, high, sub_cell, periodic
        )
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
            step = excess / tilt if tilt != 0.0 else 0.0
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
    """Penetrations near the zeros, by a power law between the rungs of a ladder of levels.

    Where the lower rung carries nothing yet, the rung on the positive side, from which Newton's
    method comes down.
    """
    bottom, top = np.log(low.min()), np.log(high.max())
    rungs = np.exp(bottom + (top - bottom) * np.arange(_LADDER) / (_LADDER - 1))
    rungs[0], rungs[-1] = low.min(), high.max()
    ladder = walk(depth, start, rungs, sub_cell, periodic)[FORCE]
    d = np.empty(offset.size)
    for i in range(d.size):
        j = 1
        while j < _LADDER - 1:
            excess = ladder[j] - offset[i] - slope * rungs[j]
            if (excess >= 0.0) if slope == 0.0 else (excess <= 0.0):
                break
            j += 1
        if slope == 0.0 and ladder[j - 1] > 0.0:
            power = np.log(rungs[j] / rungs[j - 1]) / np.log(ladder[j] / ladder[j - 1])
            guess = rungs[j - 1] * (offset[i] / ladder[j - 1]) ** power
        elif slope == 0.0:
            guess = rungs[j]
        else:
            guess = rungs[j - 1]
        d[i] = min(max(guess, low[i]), high[i])
    return d
