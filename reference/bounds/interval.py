"""An enclosure: a number that a theorem puts between two computed ones.

What the proofs of this package trust: sums, products, quotients and square roots are rounded
correctly (IEEE 754); the C library's logarithms, sines, powers and the like are within four units
in the last place of theirs, which tests hold against more digits, and each allowance for them is
several times that; and `transforms` of what it says. No solver is trusted: whatever it finds is an
admissible pressure or displacement, whose bound is added up with its rounding.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

# One operation in double precision errs by at most half of this, relative to its result.
EPSILON = 2.0**-52
# Operations that a factor is taken for: x^y errs by half an epsilon times y ln x.
POWER = 256


@dataclass(frozen=True)
class Interval:
    """A proved interval.

    Attributes
    ----------
    lower, upper : float
        The quantity is not below the one and not above the other, rounding included.

    Raises
    ------
    ValueError
        If a side is not a number or the sides are in the wrong order: then one of the two
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
        """Return the interval of the quantity times a positive number.

        The number may be the result of some operations itself, powers up to 1e60 among them.
        """
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
        """The number half-way between the sides."""
        return self.lower + 0.5 * (self.upper - self.lower)


def below(value: float, operations: int = 1) -> float:
    """Return a number that a result of so many correctly rounded operations cannot undercut.

    For results without cancellation only: every operation moves them by half an epsilon.
    """
    return value - operations * EPSILON * abs(value)


def above(value: float, operations: int = 1) -> float:
    """Return a number that a result of so many correctly rounded operations cannot exceed."""
    return value + operations * EPSILON * abs(value)
