"""Time steps of a rough line under Kelvin-Voigt springs.

A spring has the length w = z - Z0, at least that of free relaxation: w is the running maximum of
the line's height above the level, with values decaying as exp(-t/tau). Contacts begin and end at
exactly computed positions between the points of the line, so a step may have any length. Times are
lengths v t, the relaxation length is l = v tau, and forces are per 4 G dx; then a spring in contact
carries g + l dg/ds, g = h - Z0.

Most springs remain free: one sweep relaxes all springs and selects the few within reach of the
line, which alone enter the search for the level.
"""

from __future__ import annotations

import numpy as np
from numba import njit

IMPULSE, SLOPE, WORK, LOSS, LENGTH, COUNT = range(6)
SUMS = 6
_NEWTON = 100
_BALANCE = 1e-12  # relative residual of the force; rounding is about 1e-14
_FINEST = 2.0**-50  # tolerance of the level over the line's range: rounding of heights
_ROUNDING = 1e-14  # error of a contact position, relative to the step


@njit(cache=True)
def march(line, lengths, goal, level, springs, rows):
    """Take all steps of one line; return the number of steps that met the force.

    Parameters
    ----------
    line : ndarray, shape (2 n + 1,)
        Heights of a periodic line, repeated once.
    lengths : tuple of float
        dx, length of a step, and l.
    goal, level : float
        Impulse per step, and initial level.
    springs : ndarray, shape (n,)
        Initial deflections w, overwritten.
    rows : ndarray, shape (8, steps)
        Output: sums of the steps, levels, and finally stored energy.
    """
    n, (spacing, way, memory) = springs.size, lengths
    moved, sums, cells = np.empty(n), np.empty(SUMS), way / spacing
    upper = np.maximum(line[:-1], line[1:])
    highest = lowest = line[0]
    for height in line:
        highest, lowest = max(highest, height), min(lowest, height)
    finest = _FINEST * (highest - lowest)
    mask, chosen = np.zeros(n + 8 - n % 8, np.uint8), np.empty(n, np.int64)
    last, stored, decay = level, _squares(springs) / 2, np.exp(-2 * way / memory)
    for step in range(rows.shape[1]):
        # The impulse of a step is convex and decreasing in the level: w is a maximum of functions
        # linear in it, and the impulse a sum of values of w with positive weights. Newton's method
        # from above the goal therefore reaches the root; from below, one step leads above. Without
        # contact in the whole step, the highest point is first placed on the surface.
        begin, guess = step * cells, 2 * level - last
        last, level = level, guess
        floor, count, reach = np.inf, 0, 0.0
        for _ in range(_NEWTON):
            if level < floor:
                floor = level - 2 * reach
                count = _choose(
                    upper, spacing, begin, way, memory, floor, springs, moved, mask, chosen
                )
            near = chosen[:count]
            _advance(line, spacing, begin, way, memory, level, springs, moved, near, sums)
            excess = sums[IMPULSE] - goal
            if abs(excess) <= _BALANCE * goal:
                break
            if sums[SLOPE] == 0.0:
                highest = _touch(line, begin + way / spacing, way / memory, springs)
                following = highest - goal / memory
            else:
                following = level + excess / sums[SLOPE]
            reach = abs(following - level)
            if reach <= finest:
                break
            level = following
        else:
            return step
        if count < n:
            sums[LOSS] += (1 - decay) * (stored - _squares(springs[chosen[:count]]) / 2)
        springs, moved = moved, springs
        stored = _squares(springs) / 2
        for k in range(SUMS):
            rows[k, step] = sums[k]
        rows[SUMS, step] = level
        rows[SUMS + 1, step] = stored
    return rows.shape[1]


@njit(cache=True, fastmath={"reassoc"})
def _squares(springs):
    total = 0.0
    for w in springs:
        total += w * w
    return total


@njit(cache=True)
def _choose(upper, spacing, begin, way, memory, floor, springs, moved, mask, chosen):
    """Relax all springs freely, and list those within reach of a line above the floor.

    A step longer than a cell may reach any spring.
    """
    n = springs.size
    cell = int(np.floor(begin))
    if begin + way / spacing > cell + 1:
        for i in range(n):
            chosen[i] = i
        return n
    decay, first = np.exp(-way / memory), cell % n
    _reached(upper[first : first + n], floor, decay, springs, moved, mask)
    count = 0
    for block, bits in enumerate(mask.view(np.uint64)):
        if bits:
            for i in range(8 * block, 8 * block + 8):
                chosen[count] = i
                count += mask[i]
    return count


@njit(cache=True)
def _reached(upper, floor, decay, springs, moved, mask):
    for i in range(springs.size):
        free = springs[i] * decay
        moved[i] = free
        mask[i] = upper[i] - floor >= free


@njit(cache=True)
def _advance(line, spacing, begin, way, memory, level, springs, moved, chosen, sums):
    """Move the line by one step under the selected springs at a level; all others stay free.

    The level is set at the start of the step: springs in contact follow it (with an impulse l per
    shift on their dashpots), free ones move along unless the line reaches them.
    """
    sums[:] = 0.0
    at, end, now = begin, begin + way / spacing, springs
    while at < end:
        cell = np.floor(at)
        until = min(cell + 1.0, end)
        first = int(cell) % springs.size
        ends = at - cell, until - cell
        _cell(line[first:], *ends, spacing, memory, level, now, moved, chosen, sums)
        at, now = until, moved


@njit(cache=True)
def _cell(line, start, stop, spacing, memory, level, springs, moved, chosen, sums):
    """Move the selected springs within a cell of the line, from a position in it to another."""
    fresh, way = springs is not moved, (stop - start) * spacing
    decay, inverse = np.exp(-way / memory), 1 / spacing
    impulse = slope = work = loss = length = 0.0
    count = 0
    for i in chosen:
        w, left, right = springs[i], line[i], line[i + 1]
        rate = (right - left) * inverse
        low = left * (1 - start) + right * start - level
        high = left * (1 - stop) + right * stop - level
        at = 0.0
        if w > low:
            at = _meeting(w, low, high, rate, way, memory, decay)
            if at >= way:
                moved[i] = w * decay
                loss += (w * w - moved[i] * moved[i]) / 2
                continue
            low += rate * at
            loss += (w * w - low * low) / 2
            slope += memory
        elif fresh:
            impulse += memory * (low - w)
            slope += memory
        part, after = _contact(low, high, rate, way - at, memory)
        pull = part * (low + rate * (part / 2 + memory))
        impulse += pull
        slope += part
        work += rate * pull
        length += part
        release = low + rate * part
        loss += memory * rate * rate * part + (release * release - after * after) / 2
        moved[i] = after
        count += after == high
    sums[IMPULSE] += impulse
    sums[SLOPE] += slope
    sums[WORK] += work
    sums[LOSS] += loss
    sums[LENGTH] += length
    sums[COUNT] = count


@njit(cache=True)
def _contact(low, high, rate, way, memory):
    """Return the contact distance from height `low` above the level, and the final deflection."""
    if low + memory * rate <= 0.0:
        return 0.0, low * np.exp(-way / memory)
    if high + memory * rate >= 0.0:
        return way, high
    release = -memory * rate
    part = min((release - low) / rate, way)
    return part, release * np.exp(-(way - part) / memory)


@njit(cache=True)
def _meeting(w, low, high, rate, way, memory, decay):
    """Return the distance to contact with a free spring, or more than available.

    The clearance w exp(-s/l) - low - rate s is convex: Newton iterates from before its first zero
    stay before it.
    """
    if high <= w * decay:
        # contact inside the cell only: the maximum of g exp(s/l) is at zero force
        if low + memory * rate <= 0.0 or high + memory * rate >= 0.0:
            return 2 * way
        peak = -memory * rate
        if not peak * np.exp((peak - low) / (rate * memory)) > w:
            return 2 * way
    at = -low / rate if low < 0.0 < rate else 0.0
    for _ in range(_NEWTON):
        place = w * np.exp(-at / memory) if at > 0.0 else w
        fall = place / memory + rate
        if fall <= 0.0:
            return at
        step = (place - low - rate * at) / fall
        # the step is exact up to the curvature of the exponential, place/l^2
        if not step > 0.0 or place * step * step <= _ROUNDING * way * memory * memory * fall:
            return at + step
        at += step
    return at


@njit(cache=True)
def _touch(line, end, relaxation, springs):
    """Return the level at which the line first reaches a spring in a step that ends at `end`."""
    decay, highest = np.exp(-relaxation), -np.inf
    n, cell = springs.size, int(np.floor(end))
    first, part = cell % n, end - cell
    for i in range(n):
        height = line[first + i] * (1 - part) + line[first + i + 1] * part
        highest = max(highest, height - springs[i] * decay)
    return highest
