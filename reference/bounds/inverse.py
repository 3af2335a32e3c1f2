"""Where a growing function that is only known between bounds takes a value."""

from __future__ import annotations

import math
from collections.abc import Callable

from reference.bounds.interval import Interval

Side = Callable[[float], float]

# Steps of the search on each side; what any of them proves counts.
_STEPS = 8
# What a step goes beyond the place that the last one points to, and how near the value is enough.
_BEYOND, _NEAR = 2e-3, 1e-2
# Between these the exponent of the function is looked for.
_SLOPES = 0.5, 4.0


def inverse(value: float, below: Side, above: Side, start: float, power: float = 1.0) -> Interval:
    """Enclose the argument x > 0 at which a growing function f with f(0) = 0 takes a value.

    Where the upper bound of f is not above the value, x lies further on; where the lower bound is
    not below it, x does not. Arguments are tried from a guess on, by secants on double-logarithmic
    paper: any number of them may fail, and only what they prove is taken.

    Parameters
    ----------
    value : float
        Positive.
    below, above : callable
        Bounds of f.
    start, power : float
        Guesses of x, and of the exponent with which f grows.

    Raises
    ------
    ArithmeticError
        If no upper end is reached: then the lower bound proves nothing.

    Examples
    --------
    >>> x = inverse(8.0, lambda x: 0.99 * x**3, lambda x: 1.01 * x**3, 1.0)
    >>> 2.0 in x, round(x.width, 3)
    (True, 0.011)
    """
    lower = max((x for x, f in _tried(above, value, (start, power), -1) if f <= value), default=0.0)
    beyond = [x for x, f in _tried(below, value, (start, power), 1) if f >= value]
    if not beyond:
        raise ArithmeticError(f"nothing is proved that reaches {value:.4g}")
    return Interval(lower, min(beyond))


def _tried(
    side: Side, value: float, guess: tuple[float, float], ahead: int
) -> list[tuple[float, float]]:
    """Return arguments and values of one bound, up to one that is on the good side and near."""
    tried: list[tuple[float, float]] = []
    x, power = guess
    for _ in range(_STEPS):
        f = side(x)
        if tried and min(f, tried[-1][1]) > 0 and x != tried[-1][0]:
            slope = math.log(f / tried[-1][1]) / math.log(x / tried[-1][0])
            power = min(max(slope, _SLOPES[0]), _SLOPES[1])
        tried.append((x, f))
        if 0 <= ahead * (f / value - 1) < _NEAR:
            break
        x *= 2.0 if f <= 0 else (value / f) ** (1 / power) * (1 + ahead * _BEYOND)
    return tried
