"""An enclosure: a number that theorems put between two computed ones.

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

    Examples
    --------
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
        """Scale by a positive number, itself of some operations, powers up to 1e60 among them."""
        if not (factor > 0 and math.isfinite(factor)):
            raise ValueError(f"an interval is scaled by a positive number, not by {factor!r}")
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

    Examples
    --------
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
