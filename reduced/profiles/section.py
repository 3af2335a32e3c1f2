"""Sections and profiles of the reduced model: height, slope, curvature, sharp edge."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from reduced.errors import ConvergenceError

Curve = Callable[[np.ndarray], np.ndarray]
_EPSILON = np.finfo(float).eps
_ITERATIONS = 200


@dataclass(frozen=True)
class Section:
    """Cross-section f(r) of an axisymmetric rigid body, r >= 0, f(0) = 0, nondecreasing.

    Height, slope and curvature are f, f', f'' on arrays (None: unknown); `length` is typical of the
    body and only starts searches; a derivative of f jumps at the `breakpoints` r > 0; at `edge` the
    body ends in a sharp edge (inf: none).
    """

    name: str
    height: Curve
    slope: Curve
    curvature: Curve | None
    length: float
    breakpoints: tuple[float, ...] = ()
    edge: float = np.inf


@dataclass(frozen=True)
class Profile(Section):
    """Equivalent one-dimensional profile g(x), x >= 0, of a three-dimensional body.

    With springs of stiffness E* dx (19.14) it has the contact radius and force of the body, d =
    g(a) and F = 2 E* int_0^a (d - g(x)) dx (Popov & Hess 2015, ch. 3; Sneddon 1965). Closed forms,
    if known: `inverse` of a(d) with g(a) = d, without the limit by a sharp edge, and
    `abel_integral` of int_r^a g'(x)/sqrt(x^2 - r^2) dx as a function (r, a). `section` is the f(r)
    of the body, if known.
    """

    inverse: Curve | None = None
    abel_integral: Callable[[np.ndarray, float], np.ndarray] | None = None
    section: Section | None = None

    def contact_radius(self, penetration: float | np.ndarray) -> np.ndarray:
        """Return a(d), the x at which g(x) = d, at most the sharp edge; shape of d >= 0."""
        d = np.asarray(penetration, dtype=float)
        if not (np.all(np.isfinite(d)) and np.all(d >= 0)):
            raise ValueError(f"penetration must be finite and >= 0, got {penetration!r}")
        if self.inverse is not None:
            radius = self.inverse(d)
        else:
            radius = invert(self.height, self.slope, d.ravel(), self.length, self.edge)
            radius = radius.reshape(d.shape)
        return np.where(d > 0, np.minimum(radius, self.edge), 0.0)


def invert(
    function: Curve, derivative: Curve, value: np.ndarray, length: float, end: float = np.inf
) -> np.ndarray:
    """Solve function(x) = value >= 0 for nondecreasing `function` with function(0) = 0, shape (k,).

    Newton's method in logarithms (exact for a power law) inside a shrinking bracket; if a step
    leaves the bracket or is more than half of the previous step, the interval is bisected. The
    roots are good to about two units in the last place, and at most `end`.
    """
    # bracket the roots, by doubling or halving from `length`
    upper = np.full(value.shape, float(min(length, end)))
    for _ in range(_ITERATIONS):
        short = (function(upper) < value) & (upper < end)
        if not short.any():
            break
        upper[short] = np.minimum(4 * upper[short], end)
    lower = upper.copy()
    for _ in range(_ITERATIONS):
        above = (function(lower) >= value) & (value > 0)
        if not above.any():
            break
        upper[above] = lower[above]
        lower[above] /= 4
    lower = np.where(value > 0, lower, 0.0)
    x = upper.copy()
    active = np.flatnonzero((value > 0) & (function(upper) > value))
    history = []
    last = np.inf
    for _ in range(_ITERATIONS):
        if active.size == 0:
            return x
        at, goal = x[active], value[active]
        f = function(at)
        below = f < goal
        lower[active[below]] = at[below]
        upper[active[~below]] = at[~below]
        low, high = lower[active], upper[active]
        # Newton's step for log f against log x; nan if it does not exist
        slope = derivative(at)
        good = (f > 0) & (slope > 0) & np.isfinite(slope) & np.isfinite(f)
        safe_f, safe_slope = np.where(good, f, 1.0), np.where(good, slope, 1.0)
        rise = np.clip(np.log(goal / safe_f) * (safe_f / (at * safe_slope)), -50, 50)
        step = np.where(good, at * np.exp(rise), np.nan)
        moved = np.abs(step - at)
        # Two units in the last place without further decrease are the limit of rounding.
        settled = (moved <= _EPSILON * at) | ((moved <= 8 * _EPSILON * at) & (moved > 0.5 * last))
        halve = ~((step >= low) & (step <= high)) | ((moved > 0.5 * last) & ~settled)
        step = np.where(halve, 0.5 * (low + high), step)
        done = settled | (high - low <= 2 * _EPSILON * high) | (f == goal)
        x[active] = np.where(f == goal, at, step)
        history.append(float(np.max((high - low) / high)))
        active, last = active[~done], np.abs(step - at)[~done]
    raise ConvergenceError("no contact radius found: the profile is not monotone", history)


def bisect(reached: Callable[[float], bool], low: float, high: float) -> float:
    """Return the least number from which on a statement holds that is false at `low`.

    The interval to `high` is doubled until it holds there; ConvergenceError if it never does.

    >>> bisect(lambda x: x * x >= 2, 0.0, 1.0)
    1.4142135623730951
    """
    while not reached(high):
        low, high = high, high + 2 * (high - low)
        if not np.isfinite(high):
            raise ConvergenceError("nothing carries this force, however deep")
    for _ in range(_ITERATIONS):
        middle = 0.5 * (low + high)
        if not low < middle < high:
            break
        low, high = (low, middle) if reached(middle) else (middle, high)
    return high
