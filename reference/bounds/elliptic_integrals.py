r"""Elliptic integrals between proved bounds: means of two numbers that close in on each other."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from reference.bounds.interval import EPSILON

Array = NDArray[np.float64]

# Steps after which even of 1 - k^2 = 1e-300 nothing is left but rounding.
_STEPS, _HALVINGS = 16, 64


def complete(complement: Array | float, cosine: float, sine: Array | float) -> tuple[Array, Array]:
    """Enclose the integral of (A cos^2 t + B sin^2 t)/(1 - k^2 sin^2 t)^(1/2) from 0 to pi/2.

    A = B = 1 is K, A = 1 and B = 1 - k^2 is E, A = 0 and B = 1 is D = (K - E)/k^2. By Gauss's
    transformation (Bulirsch 1969, Numer. Math. 13, 305): with

        m' = m + q,    q' = 2 sqrt(m q),    a' = a + b/m,    b' = 2 (b + a q)

    the integral

        V = int_0^(pi/2) (a m cos^2 t + b sin^2 t) / (m sqrt(m^2 cos^2 t + q^2 sin^2 t)) dt

    keeps its value. As the root lies between q and m, after any number of steps

        (pi/4) (a m + b)/m^2 <= V <= (pi/4) (a m + b)/(m q),

    and q/m tends to one quadratically: the arithmetic and the geometric mean. All terms are
    positive, nothing cancels, and a step errs by a few roundings, which are counted.

    A and B, the `cosine` and `sine`, are nowhere negative; B and 1 - k^2, in (0, 1], may err by
    six roundings.

    Examples
    --------
    >>> lower, upper = complete(1.0, 1.0, 1.0)
    >>> bool(lower <= np.pi / 2 <= upper), bool(upper - lower < 1e-13)
    (True, True)
    """
    a: Array | float = cosine
    b: Array | float = sine
    m: Array | float = 1.0
    q: Array | float = np.sqrt(complement)
    # roundings, halves of an epsilon, in m and q and in a and b
    of_means, of_terms = 4.0, 6.0
    for step in range(_STEPS):
        a, b, m, q = a + b / m, 2 * (b + a * q), m + q, 2 * np.sqrt(m * q)
        of_terms += of_means + 2
        of_means += 1.5
        if step > 2 and np.all(m - q <= 4 * EPSILON * m):
            break
    total = np.asarray(0.25 * np.pi * (a * m + b) / m)
    # and the second order
    doubt = (of_terms + 3 * of_means + 8) * 0.5 * EPSILON * 1.01
    return total / m * (1 - doubt), total / q * (1 + doubt)


def first_kind_above(x: Array, y: Array, z: Array) -> Array:
    """Upper bound of R_F = (1/2) int_0^inf ((t + x)(t + y)(t + z))^(-1/2) dt, x, y, z > 0.

    Carlson's integral is unchanged if l/4 with l = sqrt(x y) + sqrt(y z) + sqrt(z x) joins a
    quarter of each argument (DLMF 19.26.18); as it falls with each of them, it is not above the
    inverse root of the least. The arguments may err by eight roundings.

    Examples
    --------
    >>> float(first_kind_above(np.array(4.0), np.array(4.0), np.array(4.0)).round(12))
    0.5
    """
    steps = 0
    for steps in range(_HALVINGS):  # noqa: B007
        least = np.minimum(np.minimum(x, y), z)
        if np.all(np.maximum(np.maximum(x, y), z) - least <= 1e-10 * least):
            break
        joined = np.sqrt(x * y) + np.sqrt(y * z) + np.sqrt(z * x)
        x, y, z = (0.25 * (part + joined) for part in (x, y, z))
    return (1 + (5 * steps + 12) * EPSILON) / np.sqrt(np.minimum(np.minimum(x, y), z))
