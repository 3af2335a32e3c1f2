r"""Displacement under pressures uniform on a grid's cells, bounded everywhere on small squares.

On a square about a point c the displacement is u(c) + u'(c) (x - c) + rest. What one loaded cell
adds to the rest is bounded

- near the cell by halving the square further: the displacement k(x, y) of a loaded cell falls with
  |x| and with |y|, so on a small square it lies between its values at two of the corners, and the
  linear part lies between its values at the corners, too;
- far from the cell by half the second derivatives of 1/r, whose norm is 2/r^3 (the largest
  eigenvalue of the Hessian of 1/r), integrated over the cell.

Far cells add up as the displacements do, in one more convolution. Near a cell the block of its
neighbours is taken under one pressure first, whose rest is that of one large cell, and then what
the pressures differ: nothing is sampled. The rounding of the transforms is bounded by a theorem
(`transform_rounding`), that of logarithms as `interval` says.
"""

import math
from collections.abc import Iterator
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numba import njit
from scipy import fft

from reference.arrays import Array, Modes
from reference.bounds.interval import EPSILON
from reference.bounds.trigonometric import transform_rounding
from reference.halfspace.kernels import love

# Offsets up to which the rest is bounded on parts of a square, and how many parts there are.
_NEAR, _PARTS = 6, 32
# Shares of a cell's own pressure that its neighbours' block is tried with: 0, 1/3, 2/3, 1.
_SHARES = 4
# Padded cells up to which the kernels of all squares are kept: 0.3 GB.
_KEPT = 2**19
# Of a distance times the logarithm of a ratio of sums of roots: ten operations or so.
_TERM = 16 * EPSILON
# Relative rounding of a displacement by `love`, in sides of the square cell. Its closed form has
# four terms, none above 1 (|a| ln[...] is the integral of |a|/(a^2 + y^2)^(1/2) over a side), and
# the integral of 1/r is not below 1/24 up to 16 sides away along either axis. Beyond, the rest of
# 4 x 4 Gauss points is at most 2 (4!)^4/(9 (8!)^2) r^-8 = 5e-5/15.5^8 = 2e-14 (the eighth
# derivatives of 1/r are not above 8!/r^9), and nothing cancels.
_LOVE = 4 * 24 * _TERM
# Rounding of a rest near a cell of side 1: three displacements, each of four antiderivatives that
# are not above 12 at offsets up to 6.5.
_REST = 3 * 4 * 12 * _TERM
# Relative, of a difference of logarithms.
_LOGARITHM = 64 * EPSILON


class Expansion(NamedTuple):
    """Displacement on one square of every cell: value and slopes at its middle, and the rest.

    The displacement lies between value + slope_x dx + slope_y dy - `under` and the same + `over`.
    """

    value: Array
    slope_x: Array
    slope_y: Array
    under: Array
    over: Array


class GridPotential:
    """Bounds of the displacement under pressures on n x m square cells of a free half-space.

    For E* = 1, on `squares` by `squares` squares per cell, with their middles at `places` from the
    cell's middle, in cells, and sides of twice `half`.
    """

    def __init__(self, shape: tuple[int, int], spacing: float, squares: int) -> None:
        self.shape, self.spacing, self.squares = shape, spacing, squares
        self.half = 0.5 * spacing / squares
        steps = (np.arange(squares) + 0.5) / squares - 0.5
        self.places = tuple((float(x), float(y)) for x in steps for y in steps)
        self._padded = tuple(fft.next_fast_len(2 * n, real=True) for n in shape)
        self._kept: dict[int, tuple[list[Modes], float]] = {}

    def expansions(self, pressure: Array) -> Iterator[Expansion]:
        """Yield the displacement on each square of every cell, in the order of `places`."""
        modes = fft.rfft2(pressure, self._padded)
        noise = 1.1 * transform_rounding(*self._padded) + 8 * EPSILON
        # offsets of the padded grid in cells, negative ones at its end
        rows, columns = (np.rint(n * fft.fftfreq(n)) for n in self._padded)
        near = (np.abs(rows[:, None]) <= _NEAR) & (np.abs(columns) <= _NEAR)
        for place, (x, y) in enumerate(self.places):
            if place in self._kept:
                kernels, size = self._kept[place]
            else:
                # what a unit pressure on a cell does on one square, over all offsets: value, slopes
                # along x and y, and the bound of the bend far from the cell
                step = self.spacing
                i, j = np.broadcast_arrays(rows[:, None] + x, columns + y)
                value = love(i, j, (step, step), 1.0)
                slope_x, slope_y = _slopes(i * step, j * step, step)
                # the nearest points of square and cell, or none of it near the cell
                reach = 0.5 * step + self.half
                apart = np.hypot(*(np.maximum(np.abs(o) * step - reach, 0.0) for o in (i, j)))
                far = np.where(near, np.inf, apart)
                # 1/r bends by 2/r^3 towards the cell, by -1/r^3 across; corners are 2^(1/2) half
                # away
                bend = step**2 * self.half**2 / far**3 / math.pi
                parts = [value, slope_x, slope_y, bend]
                kernels, size = [fft.rfft2(part) for part in parts], self._size(parts)
            if math.prod(self._padded) <= _KEPT:
                self._kept[place] = kernels, size
            results = [fft.irfft2(modes * kernel, self._padded) for kernel in kernels]
            value, slope_x, slope_y, bend = (
                result[: self.shape[0], : self.shape[1]] for result in results
            )
            under, over = np.zeros((2, *self.shape))
            deepest, highest, blocks = (rests[place] for rests in _near_rests(self.squares))
            _add_near(pressure, deepest, highest, blocks, under, over)
            # the rounding of two transforms, by Cauchy and Schwarz, of their product and of its
            # inverse
            slack = 2 * noise * float(np.linalg.norm(pressure)) * size
            slack += noise * self._size(results)
            slack += _LOVE * value + _LOGARITHM * self.half * math.fsum(pressure.flat)
            under = bend + self.spacing * under + slack
            over = 2 * bend + self.spacing * over + slack
            yield Expansion(value, slope_x, slope_y, under, over)

    def _size(self, parts: list[Array]) -> float:
        """Norm of the displacement on a square that value, slopes and bend make up."""
        value, slope_x, slope_y, bend = (float(np.linalg.norm(part)) for part in parts)
        return value + self.half * (slope_x + slope_y) + 2 * bend


@lru_cache(maxsize=4)
def _near_rests(squares: int) -> tuple[Array, Array, Array]:
    """Rests under and over the linear part near a cell of side 1, by square and offset.

    The cell and the offsets are their own images in both axes and in the diagonal, so squares on
    one side of these suffice. The third table is of a block of loaded cells, by square of the
    middle one: its rests are those of one loaded cell of the block's size.
    """
    steps = (np.arange(squares) + 0.5) / squares - 0.5
    offsets = np.arange(-_NEAR, _NEAR + 1.0)
    rests = np.empty((2, squares, squares, 2 * _NEAR + 1, 2 * _NEAR + 1))
    known: dict[tuple[float, float], tuple[Array, Array]] = {}
    for m, x in enumerate(steps):
        for n, y in enumerate(steps):
            square = max(abs(x), abs(y)), min(abs(x), abs(y))
            if square not in known:
                at_x, at_y = np.meshgrid(offsets + square[0], offsets + square[1], indexing="ij")
                known[square] = _bound_rests(at_x, at_y, 0.5 / squares)
            for rest, bound in zip(rests, known[square], strict=True):
                bound = bound.T if abs(y) > abs(x) else bound
                rest[m, n] = bound[:: -1 if x < 0 else 1, :: -1 if y < 0 else 1] + _REST
    under, over = rests.reshape(2, squares**2, *rests.shape[3:])
    size = 2 * _NEAR + 1
    x, y = (place.ravel() / size for place in np.meshgrid(steps, steps, indexing="ij"))
    blocks = size * (np.stack(_bound_rests(x, y, 0.5 / squares / size), axis=1) + _REST)
    return under, over, blocks


@njit(cache=True, error_model="numpy")
def _add_near(pressure, deepest, highest, block, under, over):
    """Add the rests of the cells about each cell: of a block under one pressure, and what differs.

    A smooth pressure bends the displacement far less than its cells do one by one; at the edge of
    a contact it is the other way round. The block's pressure is a share of the cell's own, and the
    sharpest of the bounds counts.
    """
    rows, columns = pressure.shape
    for k in range(rows):
        for m in range(columns):
            least_under = least_over = np.inf
            for share in range(_SHARES):
                base = pressure[k, m] * share / (_SHARES - 1)
                below, above = base * block[0], base * block[1]
                for i in range(-_NEAR, _NEAR + 1):
                    for j in range(-_NEAR, _NEAR + 1):
                        row, column = k - i, m - j
                        inside = 0 <= row < rows and 0 <= column < columns
                        more = (pressure[row, column] if inside else 0.0) - base
                        deep, high = deepest[i + _NEAR, j + _NEAR], highest[i + _NEAR, j + _NEAR]
                        below += more * deep if more > 0 else -more * high
                        above += more * high if more > 0 else -more * deep
                least_under, least_over = min(least_under, below), min(least_over, above)
                if pressure[k, m] == 0.0:
                    break
            under[k, m], over[k, m] = least_under, least_over


def _bound_rests(x: Array, y: Array, half: float) -> tuple[Array, Array]:
    """Largest distances under and over the linear part on squares about places, each in parts."""
    side = 2 * half / _PARTS
    value = _potential(x, y)[..., None, None]
    slope_x, slope_y = (slope[..., None, None] for slope in _slopes(x, y, 1.0))
    sway = 0.5 * side * (np.abs(slope_x) + np.abs(slope_y))
    near, far = [], []
    for at in (x, y):
        low = at[..., None] - half + np.arange(_PARTS) * side
        ends = np.abs(low), np.abs(low + side)
        near.append(np.where((low < 0) & (low + side > 0), 0.0, np.minimum(*ends)))
        far.append(np.maximum(*ends))
    middles = (np.arange(_PARTS) + 0.5) * side - half
    linear = value + slope_x * middles[:, None] + slope_y * middles
    # the displacement falls with |x| and with |y|: a part's lies between those of two corners
    over = _potential(near[0][..., :, None], near[1][..., None, :]) - linear + sway
    under = linear + sway - _potential(far[0][..., :, None], far[1][..., None, :])
    deepest, highest = (np.maximum(rest.max(axis=(-2, -1)), 0.0) for rest in (under, over))
    return deepest, highest


def _potential(x: Array, y: Array) -> Array:
    """Displacement under unit pressure on a cell of side 1, E* = 1."""
    total = _antiderivative(x + 0.5, y + 0.5) - _antiderivative(x - 0.5, y + 0.5)
    total += _antiderivative(x - 0.5, y - 0.5) - _antiderivative(x + 0.5, y - 0.5)
    return total / math.pi


def _antiderivative(x: Array, y: Array) -> Array:
    first, second = np.abs(x), np.abs(y)
    with np.errstate(divide="ignore", invalid="ignore"):
        inner = first * np.arcsinh(second / first) + second * np.arcsinh(first / second)
    return np.sign(x) * np.sign(y) * np.where((first > 0) & (second > 0), inner, 0.0)


def _slopes(x: Array, y: Array, side: float) -> tuple[Array, Array]:
    """Slopes along x and y of the displacement under a cell; infinite on its edges."""
    slopes = []
    for along, across in ((x, y), (y, x)):
        right, left = np.abs(along + side / 2), np.abs(along - side / 2)
        upper, lower = across + side / 2, across - side / 2
        total = np.arcsinh(upper / right) - np.arcsinh(upper / left)
        total += np.arcsinh(lower / left) - np.arcsinh(lower / right)
        slopes.append(total / math.pi)
    return slopes[0], slopes[1]
