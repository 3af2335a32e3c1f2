"""Time steps of a rough line under Kelvin-Voigt springs.

A spring is w = z - Z0 long and never shorter than free relaxation leaves it: w is the running
maximum of the line's height above the level, each value forgotten as exp(-t/tau). Between two
points of the line contacts begin and end at places that are found exactly, so that a step may be
of any length. Times are lengths v t, the relaxation length is l = v tau, and forces are per
4 G dx; then a spring in contact carries g + l dg/ds, g = h - Z0.

Most springs are free and stay so: one sweep relaxes all and sorts out the few that the line can
reach; only these take part in the search for the level.
"""

from __future__ import annotations

import numpy as np
from numba import njit

IMPULSE, SLOPE, WORK, LOSS, LENGTH, COUNT = range(6)
SUMS = 6
_NEWTON = 100
_BALANCE = 1e-12  # relative residual of the force; rounding leaves some 1e-14
_FINEST = 2.0**-50  # a level, relative to the range of the line: heights are rounded to this
_ROUNDING = 1e-14  # error of a meeting place, relative to the step


@njit(cache=True)
def march(line, lengths, goal, level, springs, rows):
    """Take all steps of one line; returns how many met the force.

    Parameters
    ----------
    line : ndarray, shape (2 n + 1,)
        Heights of a periodic line, twice over.
    lengths : tuple of float
        dx, length of a step, and l.
    goal, level : float
        Impulse of each step, and level to start from.
    springs : ndarray, shape (n,)
        Their deflections w in the beginning, changed.
    rows : ndarray, shape (8, steps)
        Takes the sums of each step, its level, and what the springs store in the end.
    """
    n, (spacing, way, memory) = springs.size, lengths
    moved, sums, cells = np.empty(n), np.empty(SUMS), way / spacing
    upper = np.maximum(line[:-1], line[1:])
    finest = _FINEST * (np.max(line) - np.min(line))
    mask, chosen = np.zeros(n + 8 - n % 8, np.uint8), np.empty(n, np.int64)
    last, stored, decay = level, _squares(springs) / 2, np.exp(-2 * way / memory)
    for step in range(rows.shape[1]):
        guess, last = 2 * level - last, level
        place = (line, upper, spacing, step * cells, way, memory)
        room = (mask, chosen, sums)
        level, count = _balance(place, goal, guess, finest, (springs, moved), room)
        if count < 0:
            return step
        if count < n:
            sums[LOSS] += (1 - decay) * (stored - _squares(springs[chosen[:count]]) / 2)
        springs, moved = moved, springs
        stored = _squares(springs) / 2
        rows[:SUMS, step] = sums
        rows[SUMS, step] = level
        rows[SUMS + 1, step] = stored
    return rows.shape[1]


@njit(cache=True)
def _balance(place, goal, level, finest, state, room):
    """Find the level at which the springs carry the goal over a step, and move them.

    The impulse of a step is convex and decreasing in the level: w is a maximum of functions linear
    in it, and the impulse a sum of values of w with positive weights. Newton's steps from where it
    exceeds the goal therefore end on the root; one from where it falls short leads there. Without
    a contact in the whole step the highest point is set on the surface first.

    `state` are the springs before and after, `room` is for mask, chosen springs and sums.

    Returns the level and how many springs were moved for it (those the line could reach), -1 if
    the force was not met.
    """
    line, _, spacing, begin, way, memory = place
    (springs, moved), (mask, chosen, sums) = state, room
    floor, count, reach = np.inf, 0, 0.0
    for _ in range(_NEWTON):
        if level < floor:
            floor = level - 2 * reach
            count = _choose(place, floor, springs, moved, mask, chosen)
        _advance(place, level, springs, moved, chosen[:count], sums)
        excess = sums[IMPULSE] - goal
        if abs(excess) <= _BALANCE * goal:
            return level, count
        if sums[SLOPE] == 0.0:
            following = _touch(line, begin + way / spacing, way / memory, springs) - goal / memory
        else:
            following = level + excess / sums[SLOPE]
        reach = abs(following - level)
        if reach <= finest:
            return level, count
        level = following
    return level, -1


@njit(cache=True, fastmath={"reassoc"})
def _squares(springs):
    total = 0.0
    for w in springs:
        total += w * w
    return total


@njit(cache=True)
def _choose(place, floor, springs, moved, mask, chosen):
    """Relax all springs freely and list those that a line above the floor can reach.

    A step beyond one cell may reach any.
    """
    _, upper, spacing, begin, way, memory = place
    n = springs.size
    cell = int(np.floor(begin))
    if begin + way / spacing > cell + 1:
        chosen[:] = np.arange(n)
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
def _advance(place, level, springs, moved, chosen, sums):
    """Move the line one step under the chosen springs at a level; all others stay free.

    The level is set at the start of the step: springs in contact follow it (their dashpots take an
    impulse l per shift), free ones are carried along, unless the line reaches them.
    """
    line, _, spacing, begin, way, memory = place
    sums[:] = 0.0
    at, end, now = begin, begin + way / spacing, springs
    while at < end:
        cell = np.floor(at)
        until = min(cell + 1.0, end)
        first = int(cell) % springs.size
        cut = (at - cell, until - cell, spacing, memory)
        _cell(line[first:], cut, level, (now, moved), chosen, sums)
        at, now = until, moved


@njit(cache=True)
def _cell(line, cut, level, state, chosen, sums):
    """Move the chosen springs within a cell of the line.

    `cut` are the places in the cell from and to which, dx and l; `state` the springs before and
    after.
    """
    (start, stop, spacing, memory), (springs, moved) = cut, state
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
            at = _meeting(w, (low, high, rate), way, memory, decay)
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
    """Way in contact from a height `low` above the level on, and the deflection in the end."""
    if low + memory * rate <= 0.0:
        return 0.0, low * np.exp(-way / memory)
    if high + memory * rate >= 0.0:
        return way, high
    release = -memory * rate
    part = min((release - low) / rate, way)
    return part, release * np.exp(-(way - part) / memory)


@njit(cache=True)
def _meeting(w, ramp, way, memory, decay):
    """Way to where a free spring is met by the line, or more than there is.

    `ramp` are the heights of the line above the level before and after, and its slope.

    The clearance w exp(-s/l) - low - rate s is convex: Newton's steps from before its first zero
    stay before it.
    """
    low, high, rate = ramp
    if high <= w * decay and not _grazes(w, low, high, rate, memory):
        return 2 * way
    at = -low / rate if low < 0.0 < rate else 0.0
    for _ in range(_NEWTON):
        place = w * np.exp(-at / memory) if at > 0.0 else w
        fall = place / memory + rate
        if fall <= 0.0:
            return at
        step = (place - low - rate * at) / fall
        # the step is exact but for the curvature of the exponential, place/l^2
        if not step > 0.0 or place * step * step <= _ROUNDING * way * memory * memory * fall:
            return at + step
        at += step
    return at


@njit(cache=True)
def _grazes(w, low, high, rate, memory):
    """Whether the line meets a spring inside the cell and lets it go again.

    The largest value of g exp(s/l) is where the force would be zero.
    """
    if low + memory * rate <= 0.0 or high + memory * rate >= 0.0:
        return False
    peak = -memory * rate
    return peak * np.exp((peak - low) / (rate * memory)) > w


@njit(cache=True)
def _touch(line, end, relaxation, springs):
    """Level at which the line, after a step that ends at `end`, first reaches a spring."""
    decay, highest = np.exp(-relaxation), -np.inf
    n, cell = springs.size, int(np.floor(end))
    first, part = cell % n, end - cell
    for i in range(n):
        height = line[first + i] * (1 - part) + line[first + i + 1] * part
        highest = max(highest, height - springs[i] * decay)
    return highest
