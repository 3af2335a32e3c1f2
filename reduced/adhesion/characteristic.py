"""An adhesive half line: monotone pieces of load over contact radius, and motion along them.

Springs up to a adhere; the outermost detaches at the stretch l(a) = sqrt(t a), t = 2 pi w/E*.
With G(a) = int_0^a g dx the contact is in equilibrium at

    d = g(a) - l(a)             (penetration control),
    F/(2 E*) = a d - G(a)       (force control),

and grows if the given load is above this *characteristic load* of its radius, shrinks if it is
below: for both controls the derivative of the free energy, E* (d - g)^2 - 2 pi w a, has that sign.
Folds of the characteristic are where a g'(a)^2 = t/4 and 9 t/4. On cubics the folds and the extrema
of a g'^2 between them are computed to rounding, which divides the half line into pieces with
monotone characteristic; no event between springs is missed.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numba import njit

from reduced.profiles.section import Profile
from reduced.springs.line import Half, SmoothLine, part_moments, rise_and_slope

PENETRATION, FORCE = 0, 1
FOLD_LEVEL = (0.25, 2.25)
"""a g'(a)^2/t where the characteristic load turns, by control."""

_STEPS = 100
_GRADES = 40
_EPSILON = float(np.finfo(float).eps)


class Pieces(NamedTuple):
    """Pieces of a half line with monotone characteristic load, from the axis outwards.

    `cell`, `begin`, `stop` (n,): the cubic of every piece, and its ends on the cubic in [0, 1];
    `radius`, `load` (n + 1,): contact radius and characteristic load at the ends.
    """

    cell: np.ndarray
    begin: np.ndarray
    stop: np.ndarray
    radius: np.ndarray
    load: np.ndarray


def half_line(profile: Profile, spacing: float, offset: float, largest: float) -> Half:
    """Return springs at (i + offset) dx to beyond `largest`; the other half is the mirror image.

    Beyond the tip and every breakpoint b the profile may rise as a fractional power of x - b, which
    cubics approximate poorly near folds: knots at b + 4 dx/2^(k/2) are added there.
    """
    steps = 4 * spacing * 0.5 ** (np.arange(_GRADES) / 2)
    marks = np.array([0.0, *(b for b in profile.breakpoints if b < largest)])
    graded = np.concatenate([marks[1:], (marks[:, None] + steps).ravel()])
    graded = graded[graded < min(profile.edge, largest + spacing)]
    dense = replace(profile, breakpoints=tuple(map(float, graded)))
    return SmoothLine(dense, spacing, offset, largest).halves[0]


@njit(cache=True)
def evaluate(half, cell, s):
    """Return a, g, int_0^a g dx, int_0^a g^2 dx and g' at position s in a cell."""
    width = half.x[cell + 1] - half.x[cell]
    base, height = half.heights[cell], half.heights[cell + 1] - half.heights[cell]
    value, slope = rise_and_slope(half.start[cell], half.end[cell], s)
    area, squares = part_moments(base, height, width, half.start[cell], half.end[cell], s)
    g = base + height * value
    first, second = half.first[cell] + area, half.second[cell] + squares
    return half.x[cell] + s * width, g, first, second, slope * height / width


@njit(cache=True)
def characteristic(half, stretch, control, cell, s):
    """Return d or F/(2 E*) at which the contact ends at s, and its derivative in a.

    On the axis, where l(a) begins as a square root, the infinite derivative is replaced by zero.
    """
    a, g, first, _, slope = evaluate(half, cell, s)
    edge = np.sqrt(stretch * a)
    rate = edge / (2.0 * a) if a > 0.0 else 0.0
    if control == PENETRATION:
        return g - edge, slope - rate
    return a * (g - edge) - first, a * (slope - 3.0 * rate)


@njit(cache=True)
def _fold_function(half, cell, s):
    """Return a g'(a)^2."""
    width = half.x[cell + 1] - half.x[cell]
    height = half.heights[cell + 1] - half.heights[cell]
    _, slope = rise_and_slope(half.start[cell], half.end[cell], s)
    return (half.x[cell] + s * width) * (slope * height / width) ** 2


@njit(cache=True)
def cut(half, stretch, control):
    """Return the half line divided into `Pieces` at the extrema of the characteristic load."""
    cells = half.x.size - 1
    level = FOLD_LEVEL[control] * stretch
    cell, begin, stop = [0], [0.0], [0.0]  # typed lists for numba: first entry dropped below
    for i in range(cells):
        # between the extrema of a g'^2, ordered roots of 2 a g'' + g' = 0, it is monotone
        m0, m1 = half.start[i], half.end[i]
        c2, c3 = 3.0 - 2.0 * m0 - m1, m0 + m1 - 2.0
        away = half.x[i] / (half.x[i + 1] - half.x[i])
        a, b, c = 15.0 * c3, 6.0 * c2 + 12.0 * c3 * away, 4.0 * c2 * away + m0
        first = second = 2.0
        square = b * b - 4.0 * a * c
        if square >= 0.0:
            q = -0.5 * (b + np.sqrt(square)) if b >= 0.0 else -0.5 * (b - np.sqrt(square))
            if a != 0.0:
                first = q / a
            if q != 0.0:
                second = c / q
        marks = [0.0]
        for place in (min(first, second), max(first, second)):
            if marks[-1] < place < 1.0:
                marks.append(place)
        marks.append(1.0)
        last = 0.0
        for j in range(len(marks) - 1):
            low, high = marks[j], marks[j + 1]
            rising = _fold_function(half, i, high) > level
            if (_fold_function(half, i, low) > level) == rising:
                continue
            for _ in range(_STEPS):  # bisection for the fold
                middle = 0.5 * (low + high)
                if middle in (low, high):
                    break
                if (_fold_function(half, i, middle) > level) == rising:
                    high = middle
                else:
                    low = middle
            place = 0.5 * (low + high)
            if last < place < 1.0:
                cell.append(i)
                begin.append(last)
                stop.append(place)
                last = place
        cell.append(i)
        begin.append(last)
        stop.append(1.0)
    radius, load = np.zeros(len(cell)), np.zeros(len(cell))
    for k in range(1, len(cell)):
        radius[k] = evaluate(half, cell[k], stop[k])[0]
        load[k] = characteristic(half, stretch, control, cell[k], stop[k])[0]
    load[0] = characteristic(half, stretch, control, 0, 0.0)[0]
    return Pieces(np.array(cell)[1:], np.array(begin)[1:], np.array(stop)[1:], radius, load)


@njit(cache=True)
def place_on(half, stretch, control, pieces, k, load):
    """Return the position on piece k with characteristic `load`, by bracketed Newton steps."""
    cell, low, high = pieces.cell[k], pieces.begin[k], pieces.stop[k]
    width = half.x[cell + 1] - half.x[cell]
    rising = pieces.load[k + 1] > pieces.load[k]
    s = 0.5 * (low + high)
    for _ in range(_STEPS):
        value, slope = characteristic(half, stretch, control, cell, s)
        if (value < load) == rising:
            low = s
        else:
            high = s
        last = s
        s = s - (value - load) / (slope * width) if slope != 0.0 else -1.0
        if not low <= s <= high:
            s = 0.5 * (low + high)
        if abs(s - last) <= _EPSILON * s:
            break
    return s


@njit(cache=True)
def advance(pieces, k, load):
    """Return the next stop of a growing contact from piece k: (piece, whether it is a fold).

    It stops on the piece where the characteristic reaches the load, or at the end of a piece with a
    fold below the load; the number of pieces is returned if the line ends first.
    """
    count = pieces.cell.size
    while k < count:
        if pieces.load[k + 1] >= load:
            return k, False
        rises = pieces.load[k + 1] > pieces.load[k]
        if rises and k + 1 < count and pieces.load[k + 2] < pieces.load[k + 1]:
            return k, True
        k += 1
    return count, False


@njit(cache=True)
def retreat(pieces, k, load):
    """Return the next stop of a shrinking contact from node k: (piece, whether it is a fold).

    The piece begins at a load of at most `load`, or in a fold; -1 if there is none up to the axis.
    """
    while k >= 0:
        if pieces.load[k] <= load:
            return k, False
        if k > 0 and pieces.load[k - 1] > pieces.load[k]:
            return k, True
        k -= 1
    return -1, False


@njit(cache=True)
def next_stable(pieces, k, load):
    """Return the first piece from k on that ends at `load` or above, or the number of pieces."""
    while k < pieces.cell.size and pieces.load[k + 1] < load:
        k += 1
    return k


@njit(cache=True)
def last_stable(pieces, k, load):
    """Return the last piece before node k that begins at a load of at most `load`, or -1."""
    k -= 1
    while k >= 0 and pieces.load[k] > load:
        k -= 1
    return k
