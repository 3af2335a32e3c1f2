"""Contact of rough lines at given penetrations, forces or mean gaps, line by line.

In units of E* dx and of dx the force Phi(d) of a line is convex with slope l(d), the contact
length. A prescribed force requires Phi(d) = F. A prescribed mean gap is a prescribed force on the
line turned upside down, whose contacts are the open parts: n times the mean gap is its force, and
no digits are lost near full contact. Short lines are sorted: between two neighbouring depths the
force is quadratic in d, linear for nodal sums, and one pass gives the roots for all loads
(`_roots`). Longer lines start from sums on two ladders of levels, a coarse one and a fine one
around the roots, and continue with Newton's method; these passes add pieces of a long line whole
that cross no level. One walk along the line then measures the contacts.
"""

import numpy as np
from numba import njit

from reduced.rough import walk as line_walk
from reduced.rough.walk import Ends, walk

PENETRATION, FORCE, MEAN_GAP = range(3)
DEPTH, GAP, FOUND = 5, 6, 7  # beside the measures of `walk`
CONVERGED = 1e-12  # relative step, limited by rounding of Phi
_FINISHED, _AGREED = 5e-14, 1e-13
# Steps after which the next would be negligible: third order with cut cells, else second. The walk
# verifies this.
_PROMISING_CUT, _PROMISING_WHOLE = 1e-5, 1e-7
_COARSE, _LADDER = 16, 64
_PIECE = 64  # points
_LOWEST, _HIGHEST, _SUM = range(3)  # of a piece
_PHI, _LENGTH, _RATE, _CELLS, _TOTAL = range(5)  # of `_add_up`
_BOLD = 8  # steps that also use the rate of the contact length; plain Newton steps always converge


@njit(cache=True, nogil=True, error_model="numpy")
def press_lines(
    heights: np.ndarray,
    orders: np.ndarray,
    first: int,
    control: int,
    goals: np.ndarray,
    ends: Ends,
    found: np.ndarray,
) -> np.ndarray:
    """Solve m lines from the one with index `first` on; return the last steps of the inversions.

    The steps are relative; `heights` (all, n) are those of all lines. `orders` (m, n) has indices
    that sort the heights of these in increasing order, or is (m, 0) for inversion without sorting.
    `goals` (k,) are increasing penetrations, forces over E* dx, or mean gaps, by `control`. Of
    `found` (FOUND, all, k) the rows of the m lines are filled: the measures of `walk`, penetrations
    and mean gaps.
    """
    lines, n, k = orders.shape[0], heights.shape[1], goals.size
    steps = np.zeros(lines)
    depth, d = np.empty(n), goals.copy()
    contact = np.empty((k + 1, line_walk.ROOM))
    ordered, turned = orders.shape[1] > 0, control == MEAN_GAP
    pieces = np.empty((0 if ordered else n // _PIECE, 3))
    forces = n * goals if turned else goals
    promising = _PROMISING_CUT if ends.sub_cell else _PROMISING_WHOLE
    for index in range(lines):
        row = first + index
        line = heights[row]
        (lowest, highest), mean = _extremes(line), 0.0
        for begin in range(0, n, 512):  # summed in blocks to limit rounding
            mean += _sum(line[begin : begin + 512])
        mean /= n
        mean_depth = mean - lowest if turned else highest - mean
        if control != PENETRATION:
            for i in range(n):
                depth[i] = line[i] - lowest if turned else highest - line[i]
            if ordered:
                _roots(depth, orders[index], turned, forces, ends, d)
            else:
                for i in range(len(pieces)):
                    piece = depth[i * _PIECE : (i + 1) * _PIECE]
                    pieces[i, _LOWEST], pieces[i, _HIGHEST] = _extremes(piece)
                    pieces[i, _SUM] = _sum(piece)
                _first_guess(depth, pieces, forces, mean_depth, ends, d)
                enough = _FINISHED if turned else promising
                steps[index] = _refine(depth, pieces, forces, mean_depth, ends, enough, d)
            _settle(d, highest - lowest, turned)
        if control != FORCE:
            for i in range(n):
                depth[i] = highest - line[i]
        start = 0
        while ends.periodic and line[start] != lowest:
            start += 1
        walk(depth, start, d, ends, contact)
        if control == FORCE:
            # the largest further relative step of Newton's method, by the force of the walk
            largest = 0.0
            for j in range(k):
                excess = abs(contact[j, line_walk.FORCE] - forces[j])
                largest = max(largest, excess / (contact[j, line_walk.LENGTH] * d[j]))
            steps[index] = largest
            if not steps[index] <= _AGREED:
                steps[index] = _refine(depth, pieces, forces, mean_depth, ends, _FINISHED, d)
                _settle(d, 0.0, turned)
                walk(depth, start, d, ends, contact)
        for j in range(k):  # mean gaps in reverse order
            to = k - 1 - j if turned else j
            for i in range(DEPTH):
                found[i, row, to] = contact[j, i]
            force, length = contact[j, line_walk.FORCE], contact[j, line_walk.LENGTH]
            # In full contact only rounding would remain.
            gap = 0.0 if length >= n else max(highest - mean - d[j] + force / n, 0.0)
            found[DEPTH, row, to], found[GAP, row, to] = d[j], gap
    return steps


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


@njit(cache=True, fastmath={"nnan", "nsz"})  # vectors on every processor
def _extremes(points):
    """Return minimum and maximum of numbers."""
    low = high = points[0]
    for y in points:
        low, high = min(low, y), max(high, y)
    return low, high


@njit(cache=True)
def _sum(points):
    """Return the sum by four partial ones, in the same order on every processor."""
    quads = points.size // 4 * 4
    sum_0 = sum_1 = sum_2 = sum_3 = 0.0
    for i in range(0, quads, 4):
        sum_0 += points[i]
        sum_1 += points[i + 1]
        sum_2 += points[i + 2]
        sum_3 += points[i + 3]
    for y in points[quads:]:
        sum_0 += y
    return (sum_0 + sum_1) + (sum_2 + sum_3)


@njit(cache=True, error_model="numpy")
def _refine(depth, pieces, goals, mean, ends, enough, d):
    """Refine penetrations d by Newton's method until the relative steps are `enough`.

    The first steps assume a quadratic force, as between two knots, the others a linear one.
    `mean` is the mean depth: Phi lies between n (d - mean) and n d. Returns the largest last step.
    """
    n, k = depth.size, goals.size
    sums = np.empty((k + 1, 5))
    levels, last, loads = np.empty(k), np.full(k, np.inf), np.arange(k)
    for iteration in range(100):
        for i in range(1, loads.size):  # by insertion: nearly ordered
            load, j = loads[i], i
            while j > 0 and d[loads[j - 1]] > d[load]:
                loads[j] = loads[j - 1]
                j -= 1
            loads[j] = load
        for i in range(loads.size):
            levels[i] = d[loads[i]]
        _add_up(depth, pieces, levels[: loads.size], ends, sums)
        left = 0
        for i in range(loads.size):
            load = loads[i]
            excess = sums[i, _PHI] - goals[load]
            slope, rate = sums[i, _LENGTH], sums[i, _RATE]
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


@njit(cache=True, error_model="numpy")
def _first_guess(depth, pieces, goals, mean, ends, guess):
    """Return penetrations near the roots, interpolated between the levels of a ladder.

    With a cubic through force and slope at two levels, in logarithms because the force is nearly a
    power of d, Newton's method needs two or three steps.
    """
    n = depth.size
    sums = np.empty((max(_COARSE, _LADDER) + 1, 5))
    rungs = _rungs(goals[0] / n, goals[-1] / n + mean, _COARSE)
    _add_up(depth, pieces, rungs, ends, sums)
    # A finer ladder around the roots.
    first, last = 0, _COARSE - 1
    while first < _COARSE - 2 and sums[first + 1, _PHI] < goals[0]:
        first += 1
    while last > first + 1 and sums[last - 1, _PHI] >= goals[-1]:
        last -= 1
    rungs = _rungs(rungs[first], rungs[last], _LADDER)
    _add_up(depth, pieces, rungs, ends, sums)
    j = 1
    for i in range(goals.size):
        while j < _LADDER - 1 and sums[j, _PHI] < goals[i]:
            j += 1
        a, b = rungs[j - 1], rungs[j]
        below, above = sums[j - 1, _PHI], sums[j, _PHI]
        span, width = np.log(above / below), np.log(b / a)
        part = np.log(goals[i] / below) / span if span > 0.0 else 0.0
        begin = sums[j - 1, _LENGTH] * a / below
        end = sums[j, _LENGTH] * b / above
        if not width > 0.0:
            guess[i] = b
            continue
        # inverse slopes are limited to three times the mean, to keep the cubic monotone
        start, stop = min(span / width / begin, 3.0), min(span / width / end, 3.0)
        t = min(max(part, 0.0), 1.0)
        rise = t * (start + t * (3.0 - 2.0 * start - stop + t * (start + stop - 2.0)))
        guess[i] = a * np.exp(width * rise)


@njit(cache=True)
def _rungs(bottom, top, count):
    """Return levels in geometric progression."""
    # Logarithms are of ratios only, so the digits are independent of the unit of length.
    rungs, span = np.empty(count), np.log(top / bottom)
    for i in range(count - 1):
        rungs[i] = bottom * np.exp(span * i / (count - 1))
    rungs[-1] = top
    return rungs


@njit(cache=True, error_model="numpy")
def _roots(depth, order, rising, goals, ends, depths):
    """Compute the penetrations at increasing forces over E* dx from sorted depths.

    `order` sorts the depths in increasing order, or in decreasing order if not `rising`. Rates of
    cells with very different slopes are added and subtracted in a compensated sum; all other sums
    only increase.
    """
    n = depth.size
    sub_cell, periodic = ends
    # inverse rises of the cells before the points and of the last cell, inf if flat; zero if cells
    # are never cut: with whole springs, and beyond free ends
    rises = np.zeros(n + 1)
    if sub_cell:
        for i in range(1, n):
            rises[i] = 1.0 / (depth[i] - depth[i - 1])
        rises[0] = rises[n] = 1.0 / (depth[0] - depth[n - 1]) if periodic else 0.0
        for i in range(n + 1):
            if rises[i] == -np.inf:
                rises[i] = np.inf
    outer = 0.5 if sub_cell and not periodic else 0.0
    force = length = rate = carry = y = 0.0
    j = 0
    for i in range(goals.size):
        while j < n:
            point = order[j] if rising else order[n - 1 - j]
            t = depth[point] - y
            grown = t * (rate + carry)
            next_force = force + t * (length + 0.5 * grown)
            if next_force >= goals[i] and t > 0.0:
                break
            force, y = next_force, depth[point]
            length += grown
            before, after = rises[point], rises[point + 1]
            if not sub_cell or after == np.inf:  # a whole spring, or the flat cell behind a point
                length, after = length + 1.0, 0.0
            if before == np.inf:
                before = 0.0
            if point == 0 or point == n - 1:
                length += outer
            rate, carry = _add(rate, carry, after)
            rate, carry = _add(rate, carry, -before)
            j += 1
        missing = goals[i] - force
        slope_rate = max(rate + carry, 0.0)
        root = np.sqrt(length * length + 2.0 * slope_rate * missing)
        depths[i] = y + 2.0 * missing / (length + root)


@njit(cache=True)
def _add(total, carry, term):
    """Return the sum and its rounding error (Knuth's two-sum)."""
    result = total + term
    back = result - total
    return result, carry + ((total - (result - back)) + (term - back))


@njit(cache=True, error_model="numpy")
def _add_up(depth, pieces, levels, ends, out):
    """Compute force, contact length and its rate of growth at every level, in the first k rows.

    Contacts need not be distinguished: every cell, or whole spring, is added to the shallowest
    level fully in contact, in the last columns of `out` (k + 1, 5), and to all that cut it. Pieces
    (m, 3) have the lowest and highest depth, and the sum, of the first m.
    """
    n, k = depth.size, levels.size
    out[: k + 1] = 0.0
    # The walk starts with the cell across the seam, or half a flat cell at a free end.
    first, y = 0, depth[n - 1]
    if ends.sub_cell and not ends.periodic:
        for y in (depth[n - 1], depth[0]):
            level = np.searchsorted(levels, y, side="right")
            out[level, _CELLS] += 0.5
            out[level, _TOTAL] += 0.5 * y
        first = 1
    level = np.searchsorted(levels, y, side="right")
    lower = levels[level - 1] if level > 0 else -np.inf
    upper = levels[level] if level < k else np.inf
    count = total = 0.0
    for begin in range(0, n, _PIECE):
        piece, end = begin // _PIECE, min(begin + _PIECE, n)
        # the first one is walked: the point before it may be none
        whole = 0 < piece < len(pieces)
        if whole and pieces[piece, _LOWEST] >= lower and pieces[piece, _HIGHEST] < upper:
            z = depth[end - 1]
            count += _PIECE
            # half a cell is shared with each neighbour
            total += pieces[piece, _SUM] + (0.5 * (y - z) if ends.sub_cell else 0.0)
            y = z
            continue
        for i in range(max(begin, first), end):
            z = depth[i]
            if z < lower or z >= upper:
                out[level, _CELLS] += count
                out[level, _TOTAL] += total
                count = total = 0.0
                old = level
                while level > 0 and levels[level - 1] > z:
                    level -= 1
                while level < k and levels[level] <= z:
                    level += 1
                if ends.sub_cell:
                    top, inverse = min(y, z), 1.0 / abs(z - y)
                    for j in range(min(old, level), max(old, level)):
                        deflection = levels[j] - top
                        part = deflection * inverse
                        out[j, _PHI] += 0.5 * deflection * part
                        out[j, _LENGTH] += part
                        out[j, _RATE] += inverse
                    out[max(old, level), _CELLS] += 1.0
                    out[max(old, level), _TOTAL] += 0.5 * (y + z)
                lower = levels[level - 1] if level > 0 else -np.inf
                upper = levels[level] if level < k else np.inf
                if ends.sub_cell:
                    y = z
                    continue
            count += 1.0
            total += 0.5 * (y + z) if ends.sub_cell else z
            y = z
    out[level, _CELLS] += count
    out[level, _TOTAL] += total
    count = total = 0.0
    for j in range(k):
        count += out[j, _CELLS]
        total += out[j, _TOTAL]
        out[j, _PHI] += count * levels[j] - total
        out[j, _LENGTH] += count
