r"""Lower bounds of a trigonometric polynomial, everywhere on small squares of a grid.

About the middle of a square the polynomial is its Taylor polynomial of the fifth degree and a rest.
The Taylor polynomial is nowhere below the least of its coefficients in Bernstein's form (Farouki
2012, Comput. Aided Geom. Design 29, 379). The rest is bounded by the largest sixth derivatives;
these are trigonometric polynomials, too, so none exceeds its largest sample by more than
1/cos(pi/(2M)) per direction if there are M times as many as the degree asks for (Ehlich & Zeller
1964, Math. Z. 86, 41). The middles of the squares are such samples, with M = 2.
"""

from __future__ import annotations

import math
from math import comb, factorial

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from reference.bounds.interval import EPSILON
from reference.bounds.transforms import transform_rounding
from reference.halfspace.kernels import wavenumbers

Array = NDArray[np.float64]

# Middles of the squares, relative to the middle of the cell, in cells; half a square's side.
_PLACES = ((-0.25, -0.25), (-0.25, 0.25), (0.25, -0.25), (0.25, 0.25))
_HALF = 0.25
_DEGREE = 5
_ORDERS = tuple((m, n) for m in range(_DEGREE + 2) for n in range(_DEGREE + 2 - m))
# How far a trigonometric polynomial may exceed the largest of such samples: cos(pi/4)^-2.
_BEYOND = 2.0
# Sizes of the terms' factors, (pi/4)^(m + n)/(m! n!), added up over all m and n.
_TERMS = math.exp(math.pi / 2)


def least_on_cells(
    modes: NDArray[np.complex128],
    spacing: tuple[float, float],
    grid: tuple[int, int],
    ceiling: float,
) -> Array:
    """Lower bound of a trigonometric polynomial on each cell.

    Parameters
    ----------
    modes : (n, m // 2 + 1)
        Of the real transform, divided by the number of points; none at half the sampling frequency.
    spacing : (float, float)
        Sides of a cell.
    grid : (int, int)
        The numbers n and m of cells, about the points of the transform.
    ceiling : float
        Where the bound lies above this value, it is a rougher one.
    """
    both = np.abs(modes[:, 1:]) ** 2
    norm = math.sqrt(grid[0] * grid[1] * (2 * both.sum() + (np.abs(modes[:, 0]) ** 2).sum()))
    # of transforms, in the norm over all points; of factors, and products with Bernstein's matrix
    noise = transform_rounding(*grid) + 128 * EPSILON
    rounding = noise * _TERMS * (_GREATEST + _BEYOND) * norm
    least = np.full(grid, np.inf)
    largest = dict.fromkeys((order for order in _ORDERS if sum(order) > _DEGREE), 0.0)
    for place in _PLACES:
        terms = {order: _term(modes, spacing, grid, place, order) for order in _ORDERS}
        largest = {o: max(size, float(np.abs(terms[o]).max())) for o, size in largest.items()}
        least = np.minimum(least, _least_of_taylor(terms, ceiling))
    return least - _BEYOND * sum(largest.values()) - rounding


def _term(
    modes: NDArray[np.complex128],
    spacing: tuple[float, float],
    grid: tuple[int, int],
    place: tuple[float, float],
    order: tuple[int, int],
) -> Array:
    """Coefficient of x^m y^n in Taylor's polynomial, x and y from -1 to 1 on the square."""
    factors = []
    for q, step, at, n in zip(wavenumbers(grid, spacing), spacing, place, order, strict=True):
        factors.append((1j * _HALF * step * q) ** n / factorial(n) * np.exp(1j * q * step * at))
    return fft.irfft2(modes * factors[0] * factors[1], grid, norm="forward")


def _least_of_taylor(terms: dict[tuple[int, int], Array], ceiling: float) -> Array:
    """Lower bound of Taylor's polynomials: by the sizes of the terms, and where needed sharply."""
    sway = sum(np.abs(t) for order, t in terms.items() if 0 < sum(order) <= _DEGREE)
    least = terms[0, 0] - sway
    low = np.nonzero(least < ceiling)
    powers = np.zeros((len(low[0]), _DEGREE + 1, _DEGREE + 1))
    for (m, n), term in terms.items():
        if m + n <= _DEGREE:
            powers[:, m, n] = term[low]
    least[low] = (_BERNSTEIN @ powers @ _BERNSTEIN.T).min(axis=(1, 2))
    return least


def _bernstein() -> Array:
    """Matrix from the coefficients of powers of x in [-1, 1] to those of Bernstein's form.

    With x = 2 t - 1, coefficient i of t^k is C(i, k)/C(N, k) for i >= k.
    """
    N = _DEGREE
    of_t = np.array([[comb(i, k) / comb(N, k) for k in range(N + 1)] for i in range(N + 1)])
    # (2 t - 1)^m, multiplied out
    to_t = np.array(
        [[comb(m, k) * 2**k * (-1) ** (m + k) for m in range(N + 1)] for k in range(N + 1)]
    )
    return of_t @ to_t


_BERNSTEIN = _bernstein()
# By how much coefficients of Bernstein's form in two variables may exceed those of the powers.
_GREATEST = float(np.abs(_BERNSTEIN).sum(axis=1).max()) ** 2
