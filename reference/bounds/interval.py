"""An enclosure: a number that theorems put between two computed ones; elliptic integrals in one.

What the proofs of this package trust: sums, products, quotients and square roots are rounded
correctly (IEEE 754); the C library's logarithms, sines, powers and the like are within four units
in the last place of theirs, which tests hold against more digits, and each allowance for them is
several times that; and Fourier transforms as `trigonometric.transform_rounding` says. No solver is
trusted: whatever it finds is an admissible pressure or displacement, whose bound is added up with
its rounding.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from reference.arrays import Array

# One operation in double precision errs by at most half of this, relative to its result.
EPSILON = 2.0**-52
# Operations that a factor is taken for: x^y errs by half an epsilon times y ln x.
POWER = 256

Side = Callable[[float], float]

# Of `inverse`: steps on each side; what a step goes beyond the place that the last one points to,
# and how near the value is enough; between what the exponent of the function is looked for.
_STEPS = 8
_BEYOND, _NEAR = 2e-3, 1e-2
_SLOPES = 0.5, 4.0


@dataclass(frozen=True)
class Interval:
    """A number that is not below `lower` and not above `upper`, rounding included.

    Sides in the wrong order, or that are no numbers, raise ValueError: then one of the two
    computations that they come from is wrong.

    >>> hertz = Interval(1.33332, 1.33334)
    >>> 4 / 3 in hertz, round(hertz.width, 7)
    (True, 1.5e-05)
    """

    lower: float
    upper: float

    def __post_init__(self) -> None:
        if not self.lower <= self.upper:
            raise ValueError(
                f"the lower bound {self.lower!r} is not below the upper bound {self.upper!r}"
            )

    def __contains__(self, value: float) -> bool:
        return self.lower <= value <= self.upper

    def __mul__(self, factor: float) -> Interval:
        """Scale by a positive number, itself of some operations, powers up to 1e60 among them.

        ArithmeticError where it has underflowed or overflowed.
        """
        if not (factor > 0 and math.isfinite(factor)):
            raise ArithmeticError(f"an interval is scaled by a positive number, not by {factor!r}")
        return Interval(below(self.lower * factor, POWER), above(self.upper * factor, POWER))

    __rmul__ = __mul__

    @property
    def width(self) -> float:
        """Width over the middle."""
        return (self.upper - self.lower) / self.middle if self.upper > self.lower else 0.0

    @property
    def middle(self) -> float:
        """Half-way between the sides."""
        return self.lower + 0.5 * (self.upper - self.lower)


def below(value: float, operations: int = 1) -> float:
    """Return a number that a result of so many correctly rounded operations cannot undercut.

    For results without cancellation only: every operation moves them by half an epsilon.
    """
    return value - operations * EPSILON * abs(value)


def above(value: float, operations: int = 1) -> float:
    """Return a number that such a result cannot exceed."""
    return value + operations * EPSILON * abs(value)


def inverse(value: float, below: Side, above: Side, start: float, power: float = 1.0) -> Interval:
    """Enclose the argument x > 0 at which a growing function f with f(0) = 0 takes a value > 0.

    Where the upper bound of f is not above the value, x lies further on; where the lower bound is
    not below it, x does not. Arguments are tried by secants on double-logarithmic paper, from a
    guess `start` of x and `power` of the exponent with which f grows: any number of them may fail,
    and only what they prove is taken. If no upper end is reached, the lower bound proves nothing:
    ArithmeticError.

    >>> x = inverse(8.0, lambda x: 0.99 * x**3, lambda x: 1.01 * x**3, 1.0)
    >>> 2.0 in x, round(x.width, 3)
    (True, 0.011)
    """

    def tried(side: Side, ahead: int) -> list[tuple[float, float]]:
        """Arguments and values of one bound, up to one that is on the good side and near."""
        pairs: list[tuple[float, float]] = []
        x, exponent = start, power
        for _ in range(_STEPS):
            f = side(x)
            if pairs and min(f, pairs[-1][1]) > 0 and x != pairs[-1][0]:
                slope = math.log(f / pairs[-1][1]) / math.log(x / pairs[-1][0])
                exponent = min(max(slope, _SLOPES[0]), _SLOPES[1])
            pairs.append((x, f))
            if 0 <= ahead * (f / value - 1) < _NEAR:
                break
            x *= 2.0 if f <= 0 else (value / f) ** (1 / exponent) * (1 + ahead * _BEYOND)
        return pairs

    lower = max((x for x, f in tried(above, -1) if f <= value), default=0.0)
    beyond = [x for x, f in tried(below, 1) if f >= value]
    if not beyond:
        raise ArithmeticError(f"nothing is proved that reaches {value:.4g}")
    return Interval(lower, min(beyond))


# Steps after which even of 1 - k^2 = 1e-300 nothing is left but rounding.
_GAUSS_STEPS, _HALVINGS = 16, 64


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
    """
    a: Array | float = cosine
    b: Array | float = sine
    m: Array | float = 1.0
    q: Array | float = np.sqrt(complement)
    # roundings, halves of an epsilon, in m and q and in a and b
    of_means, of_terms = 4.0, 6.0
    for step in range(_GAUSS_STEPS):
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
