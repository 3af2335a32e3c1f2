r"""Trigonometric polynomials: surfaces through maps of heights, and what they are at most anywhere.

A map of n points per side stands for the trigonometric polynomial of least degree through them
(`reference.surfaces.refine`): the one of the modes that are computed, and proofs are of this one;
it passes the points at a distance of rounding. Sampled M times finer than its degree asks for, its
largest modulus exceeds the largest sample by a factor of 1/cos(pi/(2M)) per direction at most
(Ehlich & Zeller 1964, Math. Z. 86, 41).
"""

import math
from math import comb, factorial

import numpy as np
from numpy.typing import ArrayLike
from scipy import fft

from reference.arrays import Array, Modes
from reference.bounds.interval import EPSILON
from reference.halfspace.kernels import wavenumbers

# Of `transform_rounding`: u; mu; a prime factor from which on a transform may be a convolution.
_UNIT = 0.5 * EPSILON
_FACTORS = 4 * _UNIT
_CONVOLVED = 50

# Of `least_on_cells`: middles of the four squares of a cell, in cells, and half a square's side.
_PLACES = ((-0.25, -0.25), (-0.25, 0.25), (0.25, -0.25), (0.25, 0.25))
_HALF = 0.25
_DEGREE = 5
_ORDERS = tuple((m, n) for m in range(_DEGREE + 2) for n in range(_DEGREE + 2 - m))
# How far a polynomial may exceed the largest of such samples (M = 2): cos(pi/4)^-2.
_BEYOND = 2.0
# Sizes of the terms' factors, (pi/4)^(m + n)/(m! n!), added up over all m and n.
_TERMS = math.exp(math.pi / 2)


def transform_rounding(*counts: int) -> float:
    r"""Largest relative error of a fast Fourier transform over these numbers of points along axes.

    In Euclidean norms over all points; of its inverse, and of real transforms, the same. A
    transform of n = r_1 r_2 ... points is a product of passes, of butterflies of r points each and
    of factors of modulus one. A butterfly that is summed up directly errs, in the Euclidean norm,
    by at most r^(1/2) gamma_(r+2) of its result, gamma_k = k u/(1 - k u), a factor that is known to
    mu and multiplied adds mu + 2^(1/2) gamma_2, and over the passes

        |y - y^|/|y| <= sum over the passes of  mu + r^(1/2) gamma_(r+4),

    which for r = 2 is not below Higham's  mu + gamma_4 (2^(1/2) + mu)  (Accuracy and Stability of
    Numerical Algorithms, 2002, theorem 24.2). Of a prime factor above 50 the transform may be taken
    by a convolution with n factors of modulus one (Bluestein), padded to less than 4 n points of
    small factors: three transforms, whose errors the convolution, of norm n^(1/2), multiplies by
    less than 2 n over that.

    Trusted: that scipy's transforms (pocketfft) are such passes, and that their factors are known
    to mu = 4 u, which tests hold against 30 digits.
    """
    total = 0.0
    for count in counts:
        factors, left, r = [], count, 2
        while left > 1:
            if left % r:
                r += 1
            else:
                factors.append(r)
                left //= r
        error = sum(_FACTORS + math.sqrt(r) * (r + 4) * _UNIT for r in factors)
        if max(factors, default=1) >= _CONVOLVED:
            padded = 16 * math.sqrt(2) * _UNIT * math.log2(4 * count)
            error += 3 * padded * 2 * math.sqrt(count)
        total += error
    return 1.01 * total


def levelled(heights: ArrayLike) -> Array:
    """Return heights counted from their mean: of a map that lies far from zero no digits are lost.

    Heights that are no finite map raise ValueError.
    """
    heights = np.asarray(heights, dtype=float)
    if heights.ndim != 2 or not heights.size or not np.isfinite(heights).all():
        raise ValueError(f"heights must be a finite map, not of shape {heights.shape}")
    return heights - heights.mean()


class Waves:
    """The band-limited surface through a periodic map of heights (n, m), of sides `size`."""

    def __init__(self, heights: Array, size: tuple[float, float]) -> None:
        self.points = heights.shape
        modes = fft.fft2(heights, norm="forward")
        orders = []
        for axis, count in enumerate(self.points):
            order = fft.fftfreq(count, 1 / count)
            if count % 2 == 0:
                # a mode at half the sampling frequency is shared by its two signs, appended here: a
                # product of cosines
                moved = np.moveaxis(modes, axis, 0)
                half = moved[count // 2 : count // 2 + 1] / 2
                moved = np.concatenate([moved[: count // 2], half, moved[count // 2 + 1 :], half])
                modes, order = np.moveaxis(moved, 0, axis), np.append(order, count // 2)
            orders.append(order)
        self._modes, self._orders, self._size = modes, orders, size

    def at(
        self, grid: tuple[int, int], shift: tuple[float, float], order: tuple[int, int] = (0, 0)
    ) -> Array:
        """Values or derivatives at the points of a grid, shifted by parts of its steps."""
        x, y = (
            np.array([part * side / n])
            for part, side, n in zip(shift, self._size, grid, strict=True)
        )
        along_x, along_y = self._factors(x, y, order)
        modes = self._modes * along_x.T * along_y
        whole = np.zeros(grid, dtype=complex)
        rows, columns = (
            np.round(o).astype(int) % n for o, n in zip(self._orders, grid, strict=True)
        )
        np.add.at(whole, (rows[:, None], columns[None, :]), modes)
        return fft.ifft2(whole, norm="forward").real

    def on(self, x: Array, y: Array, order: tuple[int, int] = (0, 0)) -> Array:
        """Values or derivatives at the places (x_i, y_j), lengths from the first point on."""
        along_x, along_y = self._factors(x, y, order)
        return np.asarray((along_x @ self._modes @ along_y.T).real)

    def _factors(self, x: Array, y: Array, order: tuple[int, int]) -> list[Modes]:
        """Values or derivatives of the waves of either direction (places, modes)."""
        factors = []
        for axis, places in enumerate((x, y)):
            wave = 2 * np.pi * self._orders[axis] / self._size[axis]
            factors.append((1j * wave) ** order[axis] * np.exp(1j * np.outer(places, wave)))
        return factors

    def mean_under(self, middle: Array, axes: Array) -> float:
        """Mean under a flat elliptic punch with its semi-axes as columns, see `WavyGap`."""
        qx, qy = (2 * np.pi * o / s for o, s in zip(self._orders, self._size, strict=True))
        along = [axis[0] * qx[:, None] + axis[1] * qy for axis in axes.T]
        factor = np.sinc(np.hypot(*along) / np.pi)
        phases = np.exp(1j * middle[0] * qx), np.exp(1j * middle[1] * qy)
        return float((phases[0] @ (self._modes * factor) @ phases[1]).real)

    @property
    def rounding(self) -> float:
        """Bound of the rounding of a value, from `on` or `mean_under`.

        Phases up to pi n err by as many epsilons, sums of n terms by not more.
        """
        return 8 * EPSILON * sum(self.points) * float(np.abs(self._modes).sum())

    def rounding_on(self, grid: tuple[int, int]) -> float:
        """Bound of the rounding of a value on a grid, from `at`: the norm over all of them."""
        return _rounding_on(grid) * float(np.linalg.norm(self._modes))

    def curvatures(self, finer: int = 8) -> tuple[float, float, float]:
        """Bounds of |h_xx|, |h_xy|, |h_yy| everywhere, from samples so many times finer."""
        grid = (finer * self.points[0], finer * self.points[1])
        # the largest of the values is not below their rms, the norm over the root of their number
        beyond = math.cos(math.pi / (2 * finer)) ** -2 * (1 + 2 * _rounding_on(grid))
        xx, xy, yy = (
            float(np.abs(self.at(grid, (0, 0), order)).max()) * beyond
            for order in ((2, 0), (1, 1), (0, 2))
        )
        return xx, xy, yy

    def highest(self, finer: int = 8) -> tuple[float, float]:
        """Bounds of the greatest height: that of a sample, and one that no point exceeds."""
        grid = (finer * self.points[0], finer * self.points[1])
        top = float(self.at(grid, (0, 0)).max())
        xx, xy, yy = self.curvatures(finer)
        # at the highest point the slope is zero, and the nearest sample half a step away
        step_x, step_y = (0.5 * s / n for s, n in zip(self._size, grid, strict=True))
        return top, top + 0.5 * (xx * step_x**2 + 2 * xy * step_x * step_y + yy * step_y**2)


def _rounding_on(grid: tuple[int, int]) -> float:
    """Bound of the rounding of a value on a grid, over the norm of the modes."""
    return (transform_rounding(*grid) + 16 * EPSILON) * math.sqrt(grid[0] * grid[1])


# From coefficients of powers of x in [-1, 1] to those of Bernstein's form: with x = 2 t - 1 the
# coefficient i of t^k is C(i, k)/C(N, k) for i >= k, and (2 t - 1)^m is multiplied out.
_UP_TO = range(_DEGREE + 1)
_BERNSTEIN = np.array([[comb(i, k) / comb(_DEGREE, k) for k in _UP_TO] for i in _UP_TO]) @ np.array(
    [[comb(m, k) * 2**k * (-1) ** (m + k) for m in _UP_TO] for k in _UP_TO]
)
# By how much coefficients of Bernstein's form in two variables may exceed those of the powers.
_GREATEST = float(np.abs(_BERNSTEIN).sum(axis=1).max()) ** 2


def least_on_cells(
    modes: Modes, spacing: tuple[float, float], grid: tuple[int, int], ceiling: float
) -> Array:
    """Lower bound of a trigonometric polynomial everywhere on each cell about a grid's points.

    About the middle of a square, four of which are a cell, the polynomial is its Taylor polynomial
    of the fifth degree and a rest. The Taylor polynomial is nowhere below the least of its
    coefficients in Bernstein's form (Farouki 2012, Comput. Aided Geom. Design 29, 379). The rest is
    bounded by the largest sixth derivatives; these are trigonometric polynomials, too, and the
    middles of the squares samples of them with M = 2.

    Modes (n, m // 2 + 1) are those of the real transform over the number of points, with none at
    half the sampling frequency. Where the bound lies above the ceiling, it is a rougher one.
    """
    both = np.abs(modes[:, 1:]) ** 2
    norm = math.sqrt(grid[0] * grid[1] * (2 * both.sum() + (np.abs(modes[:, 0]) ** 2).sum()))
    # of transforms, in the norm over all points; of factors, and products with Bernstein's matrix
    noise = transform_rounding(*grid) + 128 * EPSILON
    rounding = noise * _TERMS * (_GREATEST + _BEYOND) * norm
    least = np.full(grid, np.inf)
    largest = dict.fromkeys((order for order in _ORDERS if sum(order) > _DEGREE), 0.0)
    for place in _PLACES:
        # the coefficients of x^m y^n, x and y from -1 to 1 on the square
        terms = {}
        for order in _ORDERS:
            factors = [
                (1j * _HALF * step * q) ** n / factorial(n) * np.exp(1j * q * step * at)
                for q, step, at, n in zip(
                    wavenumbers(grid, spacing), spacing, place, order, strict=True
                )
            ]
            terms[order] = fft.irfft2(modes * factors[0] * factors[1], grid, norm="forward")
        largest = {o: max(size, float(np.abs(terms[o]).max())) for o, size in largest.items()}
        # by the sizes of the terms, and sharply where that is below the ceiling
        sway = sum(np.abs(t) for order, t in terms.items() if 0 < sum(order) <= _DEGREE)
        lowest = terms[0, 0] - sway
        low = np.nonzero(lowest < ceiling)
        powers = np.zeros((len(low[0]), _DEGREE + 1, _DEGREE + 1))
        for (m, n), term in terms.items():
            if m + n <= _DEGREE:
                powers[:, m, n] = term[low]
        lowest[low] = (_BERNSTEIN @ powers @ _BERNSTEIN.T).min(axis=(1, 2))
        least = np.minimum(least, lowest)
    return least - _BEYOND * sum(largest.values()) - rounding
