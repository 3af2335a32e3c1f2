"""Contact of rough lines at given penetrations, forces or mean gaps, line by line.

In units of E* dx and of dx the force Phi(d) of a line is convex with slope l(d), the contact
length. A prescribed force requires Phi(d) = F. A prescribed mean gap is a prescribed force on the
line turned upside down, whose contacts are the open parts: n times the mean gap is its force, and
no digits are lost near full contact. Short lines are sorted, which gives the roots directly. Long
lines start from sums on two ladders of levels, a coarse one and a fine one around the roots, and
continue with Newton's method, which converges monotonically on a convex function. One walk along
the line then measures the contacts.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from reduced.rough import sums as line_sums
from reduced.rough import walk as line_walk
from reduced.rough.knots import roots
from reduced.rough.lines import Ends
from reduced.rough.sums import add_up
from reduced.rough.walk import walk

PENETRATION, FORCE, MEAN_GAP = range(3)
PENETRATIONS, FORCES, AREAS, LENGTHS, LONGESTS, GAPS, ENERGIES, STIFFNESSES = range(8)
FIELDS = 8
CONVERGED = 1e-12  # relative step, limited by rounding of Phi
_FINISHED, _AGREED = 5e-14, 1e-13
# Steps after which the next would be negligible: third order with cut cells, else second. The walk
# verifies this.
_PROMISING_CUT, _PROMISING_WHOLE = 1e-5, 1e-7
_COARSE, _LADDER = 16, 64
_NEWTON = 100
_BOLD = 8  # steps that also use the rate of the contact length; plain Newton steps always converge


class Target(NamedTuple):
    """The prescribed loads of the lines.

    Attributes
    ----------
    control : int
        PENETRATION, FORCE or MEAN_GAP.
    goals : ndarray, shape (k,)
        Increasing penetrations, forces over E* dx, or mean gaps.
    """

    control: int
    goals: np.ndarray


class Results(NamedTuple):
    """Arrays for the results of all lines.

    Attributes
    ----------
    units : ndarray, shape (FIELDS,)
        Units of the fields.
    fields : ndarray, shape (FIELDS, all, k)
        Penetrations, forces (E* dx is their unit), sums of squared contact lengths, contact
        lengths, longest contacts, mean gaps, energies (E* dx) and contact lengths once more, for
        the stiffness.
    counts : ndarray of int, shape (all, k)
        Numbers of contacts.
    """

    units: np.ndarray
    fields: np.ndarray
    counts: np.ndarray


@njit(cache=True, nogil=True, error_model="numpy")
def press_lines(
    heights: np.ndarray,
    orders: np.ndarray,
    first: int,
    target: Target,
    ends: Ends,
    results: Results,
) -> np.ndarray:
    """Solve lines one by one; return the last relative steps of the inversions.

    Parameters
    ----------
    heights : ndarray, shape (all, n)
        Heights, positive towards the half-space.
    orders : ndarray, shape (m, n) or (m, 0)
        Indices that sort the heights of m lines in increasing order, or empty for inversion without
        sorting.
    first : int
        Index of the first of these m lines.
    results : Results
        The rows of the m lines are filled.
    """
    control, goals = target
    lines, n = orders.shape[0], heights.shape[1]
    steps = np.zeros(lines)
    depth, d = np.empty(n), goals.copy()
    contact = np.empty((goals.size + 1, line_walk.ROOM))
    ordered, turned = orders.shape[1] > 0, control == MEAN_GAP
    forces = n * goals if turned else goals
    promising = _PROMISING_CUT if ends.sub_cell else _PROMISING_WHOLE
    for index in range(lines):
        line = heights[first + index]
        lowest, highest, mean = _extremes_and_mean(line)
        mean_depth = mean - lowest if turned else highest - mean
        if control != PENETRATION:
            for i in range(n):
                depth[i] = line[i] - lowest if turned else highest - line[i]
            if ordered:
                roots(depth, orders[index], turned, forces, ends, d)
            else:
                first_guess(depth, forces, mean_depth, ends, d)
                enough = _FINISHED if turned else promising
                steps[index] = refine(depth, forces, mean_depth, ends, enough, d)
            _settle(d, highest - lowest, turned)
        if control != FORCE:
            for i in range(n):
                depth[i] = highest - line[i]
        start = 0
        while ends.periodic and line[start] != lowest:
            start += 1
        walk(depth, start, d, ends, contact)
        if control == FORCE:
            steps[index] = _mismatch(contact, forces, d)
            if not steps[index] <= _AGREED:
                steps[index] = refine(depth, forces, mean_depth, ends, _FINISHED, d)
                _settle(d, 0.0, turned)
                walk(depth, start, d, ends, contact)
        _write(first + index, d, contact, (n, highest - mean), turned, results)
    return steps


@njit(cache=True, error_model="numpy")
def _mismatch(contact, forces, d):
    """Return the largest further relative step of Newton's method, by the force of the walk."""
    largest = 0.0
    for j in range(d.size):
        excess = abs(contact[j, line_walk.FORCE] - forces[j])
        largest = max(largest, excess / (contact[j, line_walk.LENGTH] * d[j]))
    return largest


@njit(cache=True)
def _settle(d, range_of_heights, turned):
    """Turn an inverted line back; levels that swapped by rounding are merged."""
    k = d.size
    if turned:
        for j in range(k // 2):
            d[j], d[k - 1 - j] = d[k - 1 - j], d[j]
        for j in range(k):
            d[j] = range_of_heights - d[j]
    for j in range(1, k):
        d[j] = max(d[j], d[j - 1])


@njit(cache=True)
def _write(row, d, contact, line, turned, results):
    """Store the results of one line, in reverse order for mean gaps.

    `line` are its number of points and its mean depth.
    """
    n, mean = line
    units, fields, counts = results
    k = d.size
    for j in range(k):
        to = k - 1 - j if turned else j
        force, length = contact[j, line_walk.FORCE], contact[j, line_walk.LENGTH]
        # In full contact only rounding would remain.
        gap = 0.0 if length >= n else max(mean - d[j] + force / n, 0.0)
        fields[PENETRATIONS, row, to] = units[PENETRATIONS] * d[j]
        fields[FORCES, row, to] = units[FORCES] * force
        fields[AREAS, row, to] = units[AREAS] * contact[j, line_walk.SQUARES]
        fields[LENGTHS, row, to] = units[LENGTHS] * length
        fields[LONGESTS, row, to] = units[LONGESTS] * contact[j, line_walk.LONGEST]
        fields[GAPS, row, to] = units[GAPS] * gap
        fields[ENERGIES, row, to] = units[ENERGIES] * contact[j, line_walk.ENERGY]
        fields[STIFFNESSES, row, to] = units[STIFFNESSES] * length
        counts[row, to] = int(contact[j, line_walk.COUNT])


@njit(cache=True, fastmath={"nnan", "nsz"})  # heights are finite, so extrema can be vectorised
def _extremes_and_mean(line):
    """Return minimum, maximum and mean, summed in blocks to limit rounding."""
    lowest = highest = line[0]
    for h in line:
        lowest = h if h < lowest else lowest
        highest = h if h > highest else highest
    total = 0.0
    for begin in range(0, line.size, 512):
        end = min(begin + 512, line.size)
        quads = begin + (end - begin) // 4 * 4
        sums_0 = sums_1 = sums_2 = sums_3 = 0.0
        for i in range(begin, quads, 4):
            sums_0 += line[i]
            sums_1 += line[i + 1]
            sums_2 += line[i + 2]
            sums_3 += line[i + 3]
        for i in range(quads, end):
            sums_0 += line[i]
        total += (sums_0 + sums_1) + (sums_2 + sums_3)
    return lowest, highest, total / line.size


@njit(cache=True, error_model="numpy")
def refine(depth, goals, mean, ends, enough, d):
    """Refine penetrations d by Newton's method until the relative steps are `enough`.

    The first steps assume a quadratic force, as between two knots, the others a linear one.
    `mean` is the mean depth: Phi lies between n (d - mean) and n d. Returns the largest last step.
    """
    n, k = depth.size, goals.size
    sums = np.empty((k + 1, line_sums.ROOM))
    levels, last, loads = np.empty(k), np.full(k, np.inf), np.arange(k)
    for iteration in range(_NEWTON):
        _insertion_sort(loads, d)
        for i in range(loads.size):
            levels[i] = d[loads[i]]
        add_up(depth, levels[: loads.size], ends, sums)
        left = 0
        for i in range(loads.size):
            load = loads[i]
            excess = sums[i, line_sums.FORCE] - goals[load]
            slope, rate = sums[i, line_sums.LENGTH], sums[i, line_sums.RATE]
            square = slope * slope - 2.0 * rate * excess
            bold = iteration < _BOLD and square > 0.0
            step = 2.0 * excess / (slope + (np.sqrt(square) if bold else slope))
            size = abs(step) / levels[i]
            d[load] = min(max(levels[i] - step, goals[load] / n), goals[load] / n + mean)
            if not (size <= enough or (size <= CONVERGED and size >= 0.5 * last[load])):
                loads[left] = load
                left += 1
            last[load] = size
        loads = loads[:left]
        if left == 0:
            break
    largest = 0.0
    for step in last:
        largest = step if step > largest or np.isnan(step) else largest
    return largest


@njit(cache=True)
def _insertion_sort(loads, d):
    """Sort loads by penetration, in which they are nearly ordered."""
    for i in range(1, loads.size):
        load, j = loads[i], i
        while j > 0 and d[loads[j - 1]] > d[load]:
            loads[j] = loads[j - 1]
            j -= 1
        loads[j] = load


@njit(cache=True, error_model="numpy")
def first_guess(depth, goals, mean, ends, guess):
    """Return penetrations near the roots, interpolated between the levels of a ladder.

    With a cubic through force and slope at two levels, in logarithms because the force is nearly a
    power of d, Newton's method needs two or three steps.
    """
    n = depth.size
    sums = np.empty((max(_COARSE, _LADDER) + 1, line_sums.ROOM))
    rungs = _rungs(goals[0] / n, goals[-1] / n + mean, _COARSE)
    add_up(depth, rungs, ends, sums)
    # A finer ladder around the roots.
    first, last = 0, _COARSE - 1
    while first < _COARSE - 2 and sums[first + 1, line_sums.FORCE] < goals[0]:
        first += 1
    while last > first + 1 and sums[last - 1, line_sums.FORCE] >= goals[-1]:
        last -= 1
    rungs = _rungs(rungs[first], rungs[last], _LADDER)
    add_up(depth, rungs, ends, sums)
    j = 1
    for i in range(goals.size):
        while j < _LADDER - 1 and sums[j, line_sums.FORCE] < goals[i]:
            j += 1
        a, b = rungs[j - 1], rungs[j]
        below, above = sums[j - 1, line_sums.FORCE], sums[j, line_sums.FORCE]
        span, width = np.log(above / below), np.log(b / a)
        part = np.log(goals[i] / below) / span if span > 0.0 else 0.0
        begin = sums[j - 1, line_sums.LENGTH] * a / below
        end = sums[j, line_sums.LENGTH] * b / above
        guess[i] = a * np.exp(width * _cubic(part, span / width, begin, end)) if width > 0.0 else b


@njit(cache=True)
def _rungs(bottom, top, count):
    """Return levels in geometric progression."""
    # Logarithms are of ratios only, so the digits are independent of the unit of length.
    rungs = bottom * np.exp(np.log(top / bottom) * np.arange(count) / (count - 1))
    rungs[-1] = top
    return rungs


@njit(cache=True, error_model="numpy")
def _cubic(part, secant, begin, end):
    """Return the inverse of a monotone function on a unit cell, by a cubic Hermite polynomial.

    `part` is the fraction of the rise, `secant` the mean slope, `begin` and `end` the slopes at the
    ends; inverse slopes are limited to three times the mean to keep the cubic monotone.
    """
    start = min(secant / begin, 3.0)
    stop = min(secant / end, 3.0)
    t = min(max(part, 0.0), 1.0)
    return t * (start + t * (3.0 - 2.0 * start - stop + t * (start + stop - 2.0)))
