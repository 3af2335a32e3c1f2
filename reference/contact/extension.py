"""Extension of a field from the contact to all cells, and its transpose: the preconditioner's half.

The stiffness of a contact C against displacements r of its cells, the inverse of the compliance
restricted to C, is the least elastic energy of all continuations w of r to the whole grid,

    r . K_CC^-1 r = min { w . K^-1 w : w = r on C },

because the pressure of the minimum vanishes outside C. So E^T |q| E approximates K_CC^-1 from
above, within a factor that bounds the energy of the continuation E r: the number of iterations then
depends neither on the grid nor on the shape of the contact (theory of extension operators, J. Xu,
SIAM Review 34 (1992) 581, section 5). Zeros outside C are a poor continuation: their jump makes
waves between contacts as stiff as the contacts themselves.

E takes means over the contact cells of blocks of 2, 4, 8, ... cells, and fills every open cell by
bilinear interpolation from the smallest blocks around it that are full enough. It costs a few
passes through memory. All is linear for a given contact, and `restrict` is the exact transpose of
`extend`.
"""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from numba import njit
from numpy.typing import DTypeLike, NDArray

from reference.arrays import Floats
from reference.contact import pieces

Map = Floats | NDArray[np.uint8]

# A block counts as full if this fraction of its cells is in contact. From 1 to 1/2, iterations
# differ by a tenth; where any cell fills a block they are two to four times as many.
_FULL = 0.5

_REORDER = {"reassoc", "contract", "nsz"}


class Extension:
    """Continuation of fields known on some cells of a grid to a period that contains it.

    A constant remains one, and the transpose conserves sums:

    >>> extension = Extension((5, 6), np.float64)
    >>> contact = np.zeros((4, 6), np.uint8)
    >>> contact[1:3, 2] = 1
    >>> np.unique(extension.extend(2.0 * contact, contact, np.empty((5, 6)))).tolist()
    [2.0]
    >>> float(extension.restrict(np.ones((5, 6)), contact, np.empty((4, 6))).sum())
    30.0
    """

    def __init__(self, period: tuple[int, int], dtype: DTypeLike) -> None:
        # sums over the contact in blocks of all sizes, and the share of a block in contact
        self._levels: list[tuple[Floats, Floats]] = []
        sides = period
        while not self._levels or max(sides) > 1:
            sides = (sides[0] + 1) // 2, (sides[1] + 1) // 2
            self._levels.append((np.empty(sides, dtype), np.empty(sides, dtype)))

    def extend(self, values: Floats, contact: NDArray[np.uint8], out: Floats) -> Floats:
        """Fill `out` (padded) with `values` on the contact cells, zero elsewhere, continued.

        At least one cell is in contact; `out` may be `values`.
        """
        self.cover(values, contact)
        self._over(_spread, self._levels[0][0], values, contact, out)
        return out

    def restrict(self, field: Floats, contact: NDArray[np.uint8], out: Floats) -> Floats:
        """Fill `out` with the transpose of `extend` applied to a field (padded).

        `contact` has the cells of the last `extend` or `cover`; `out` may be the field.
        """
        levels = self._levels
        self._over(_collect, levels[0][0], field, contact)
        for (values, weights), (coarse, _) in pairwise(levels):
            self._over(_collect, coarse, values, weights)
        np.divide(*levels[-1], out=levels[-1][0])
        for (values, weights), (coarse, _) in reversed(list(pairwise(levels))):
            self._over(_return, coarse, values, weights, values)
        self._over(_return, levels[0][0], field, contact, out)
        return out

    def cover(self, field: Map, contact: NDArray[np.uint8]) -> None:
        """Fill the blocks of all sizes with continued means, and the shares of cells in contact.

        That sets the contact of the next `restrict`.
        """
        levels = self._levels
        self._over(_gather, *levels[0], field, contact)
        for fine, above in pairwise(levels):
            self._over(_gather, *above, *fine)
        np.divide(*levels[-1], out=levels[-1][0])
        for (values, weights), (coarse, _) in reversed(list(pairwise(levels))):
            self._over(_spread, coarse, values, weights, values)

    def _over(self, work: Callable[..., None], coarse: Map, *maps: Map) -> None:
        rows, columns = coarse.shape
        if 4 * rows * columns <= pieces.SIZE:
            work(coarse, *maps, 0, rows)
            return
        step = pieces.rows_of(4 * columns)
        pieces.over(rows, step, lambda part: work(coarse, *maps, part.start, part.stop))


@njit(cache=True, nogil=True, error_model="numpy", fastmath=_REORDER)
def _gather(sums, shares, values, weights, first, stop):
    """Fill sums and shares of blocks from first to stop with quarters of their four cells'."""
    rows, columns = values.shape
    number = sums.dtype.type
    quarter, pairs = number(0.25), columns // 2
    for row in range(first, stop):
        sums[row] = number(0)
        shares[row] = number(0)
        for i in range(2 * row, min(2 * row + 2, rows)):
            for j in range(pairs):
                weight = number(weights[i, 2 * j]) + number(weights[i, 2 * j + 1])
                sums[row, j] += quarter * (number(values[i, 2 * j]) + number(values[i, 2 * j + 1]))
                shares[row, j] += quarter * weight
            if columns % 2:
                sums[row, pairs] += quarter * number(values[i, columns - 1])
                shares[row, pairs] += quarter * number(weights[i, columns - 1])


@njit(cache=True, nogil=True, error_model="numpy", fastmath=_REORDER)
def _spread(coarse, values, weights, out, first, stop):
    """Fill the cells of blocks from first to stop: their own means as far as full, else between."""
    rows, columns = weights.shape
    period, width = out.shape[1], coarse.shape[1]
    number = coarse.dtype.type
    near, far, unit, full = number(0.75), number(0.25), number(1), number(1 / _FULL)
    between, line = np.empty(width + 2, coarse.dtype), np.empty(2 * width, coarse.dtype)
    for i in range(2 * first, min(2 * stop, len(out))):
        row, beside = i // 2, (i // 2 + 2 * (i % 2) - 1) % len(coarse)
        for j in range(width):
            between[j + 1] = near * coarse[row, j] + far * coarse[beside, j]
        between[0], between[width + 1] = between[width], between[1]
        for j in range(width):
            line[2 * j] = near * between[j + 1] + far * between[j]
            line[2 * j + 1] = near * between[j + 1] + far * between[j + 2]
        inside = columns if i < rows else 0
        for j in range(inside):
            weight = number(weights[i, j])
            own = values[i, j] * min(unit / weight, full)
            out[i, j] = own + max(unit - full * weight, number(0)) * line[j]
        for j in range(inside, period):
            out[i, j] = line[j]


@njit(cache=True, nogil=True, error_model="numpy", fastmath=_REORDER)
def _collect(sums, field, weights, first, stop):
    """Fill blocks from first to stop with what `_spread` took from them, transposed."""
    (period, length), width = field.shape, sums.shape[1]
    number = sums.dtype.type
    near, far = number(0.75), number(0.25)
    line = np.zeros(2 * width + 2, sums.dtype)
    for row in range(first, stop):
        line[:] = number(0)
        _add_open(line, field, weights, 2 * row, near)
        if 2 * row + 1 < period:
            _add_open(line, field, weights, 2 * row + 1, near)
        _add_open(line, field, weights, 2 * row + 2 if row + 1 < len(sums) else 0, far)
        if row > 0 or period % 2 == 0:
            _add_open(line, field, weights, (2 * row - 1) % period, far)
        # the line begins with its last cell and ends with its first
        line[0] = line[length] if length % 2 == 0 else number(0)
        line[2 * width + 1] = line[1]
        for j in range(width):
            nearest = line[2 * j + 1] + line[2 * j + 2]
            sums[row, j] = near * nearest + far * (line[2 * j] + line[2 * j + 3])


# inlined: by its own choice LLVM does so where it compiles, but not where `_collect` calls cached
# code, and last digits then differ from process to process
@njit(inline="always", nogil=True, error_model="numpy", fastmath=_REORDER)
def _add_open(line, field, weights, i, factor):
    """Add a row of a field, as far as its cells are open, times a factor."""
    rows, columns = weights.shape
    number = line.dtype.type
    unit, full = number(1), number(1 / _FULL)
    inside = columns if i < rows else 0
    for j in range(inside):
        open_share = max(unit - full * number(weights[i, j]), number(0))
        line[j + 1] += factor * open_share * field[i, j]
    for j in range(inside, field.shape[1]):
        line[j + 1] += factor * field[i, j]


@njit(cache=True, nogil=True, error_model="numpy", fastmath=_REORDER)
def _return(coarse, field, weights, out, first, stop):
    """Fill the cells of blocks from first to stop with their own and a quarter of their block's."""
    rows, columns = weights.shape
    number = coarse.dtype.type
    zero, unit, quarter, full = number(0), number(1), number(0.25), number(1 / _FULL)
    line = np.empty(columns + 1, coarse.dtype)
    for i in range(2 * first, min(2 * stop, rows)):
        for j in range((columns + 1) // 2):
            line[2 * j] = line[2 * j + 1] = quarter * coarse[i // 2, j]
        for j in range(columns):
            weight = number(weights[i, j])
            value = field[i, j] * min(unit / weight, full) + line[j]
            out[i, j] = value if weight > zero else zero
