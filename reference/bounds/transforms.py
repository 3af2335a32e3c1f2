r"""Bound of the rounding of fast Fourier transforms.

A transform of n = r_1 r_2 ... points is a product of passes, of butterflies of r points each and of
factors of modulus one. A butterfly that is summed up directly errs, in the Euclidean norm, by at
most r^(1/2) gamma_(r+2) of its result, gamma_k = k u/(1 - k u), a factor that is known to mu and
multiplied adds mu + 2^(1/2) gamma_2, and over the passes

    |y - y^|/|y| <= sum over the passes of  mu + r^(1/2) gamma_(r+4),

which for r = 2 is not below Higham's  mu + gamma_4 (2^(1/2) + mu)  (Accuracy and Stability of
Numerical Algorithms, 2002, theorem 24.2). Of a prime factor above 50 the transform may be taken
by a convolution with n factors of modulus one (Bluestein), padded to less than 4 n points of small
factors: three transforms, whose errors the convolution, of norm n^(1/2), multiplies by less than
2 n over that.

Trusted: arithmetic as of IEEE 754; that scipy's transforms (pocketfft) are such passes; and that
their factors are known to mu = 4 u, which tests hold against 30 digits.
"""

from __future__ import annotations

import math

from reference.bounds.interval import EPSILON

_UNIT = 0.5 * EPSILON
_FACTORS = 4 * _UNIT
# A prime factor from which on the transform may be a convolution.
_CONVOLVED = 50


def transform_rounding(*counts: int) -> float:
    """Largest error of a transform, or of its inverse, over these numbers of points along axes.

    Relative, in Euclidean norms over all points. Real transforms do the same on half of the values.

    Examples
    --------
    >>> transform_rounding(1024, 1024) < 4e-14
    True
    """
    return 1.01 * sum(_along(count) for count in counts)


def _along(count: int) -> float:
    factors = _prime_factors(count)
    error = sum(_FACTORS + math.sqrt(r) * (r + 4) * _UNIT for r in factors)
    if max(factors, default=1) >= _CONVOLVED:
        padded = 16 * math.sqrt(2) * _UNIT * math.log2(4 * count)
        error += 3 * padded * 2 * math.sqrt(count)
    return error


def _prime_factors(count: int) -> list[int]:
    factors, r = [], 2
    while count > 1:
        if count % r:
            r += 1
        else:
            factors.append(r)
            count //= r
    return factors
