"""Quadrature, root finding and cancellation-free differences shared by the closed forms."""

from collections.abc import Callable
from functools import cache

import numpy as np

from reference.arrays import Array
from reference.errors import ConvergenceError


@cache
def gauss_rule(nodes: int) -> tuple[Array, Array]:
    """Return places in (-1, 1) and weights of Gauss's rule, made once and not to be written to."""
    rule: tuple[Array, Array] = np.polynomial.legendre.leggauss(nodes)
    for part in rule:
        part.setflags(write=False)
    return rule


def gauss(
    integrand: Callable[[Array], Array],
    lower: Array,
    upper: Array,
    *,
    nodes: int = 32,
    panels: int = 1,
) -> Array:
    """Integrate by Gauss-Legendre on equal panels, for arrays of limits.

    Nodes are processed one by one, so that a map of pressures needs memory for a few maps only.
    """
    abscissae, weights = gauss_rule(nodes)
    half = (upper - lower) / (2 * panels)
    total = np.zeros_like(half)
    for panel in range(panels):
        centre = lower + (2 * panel + 1) * half
        for abscissa, weight in zip(abscissae, weights, strict=True):
            total += weight * integrand(centre + half * abscissa)
    return total * half


def solve_increasing(
    function: Callable[[Array], tuple[Array, Array]], target: Array, guess: Array
) -> Array:
    """Solve function(t) = target for t >= 0 by Newton's method in logarithms, elementwise.

    ``function`` returns value and derivative of a law that increases like a power of t with slowly
    varying exponent: in logarithms it is nearly straight, so that steps are accurate over hundreds
    of orders of magnitude, and the last step loses no digits. A target of 0 gives 0. A
    ConvergenceError after 60 steps has the largest relative change of every step.
    """
    root = np.where(target > 0, guess, 1.0)
    aim = np.where(target > 0, target, function(np.ones(()))[0])
    history = []
    for _ in range(60):
        value, derivative = function(root)
        step = value / (root * derivative) * np.log1p((aim - value) / value)
        root = root * np.exp(step)
        history.append(float(np.max(np.abs(step), initial=0.0)))
        # Quadratic convergence: after a step of 1e-9 only rounding remains.
        if history[-1] < 1e-9:
            return np.where(target > 0, root, 0.0)
    raise ConvergenceError("Newton's method for the contact radius did not settle", history)


def _odd_tail(t: Array, sign: float) -> Array:
    """Return t^3/3 + sign t^5/5 + t^7/7 + ..., for |t| <= 1/2."""
    square = sign * t * t
    total = np.zeros_like(t)
    for k in range(30, 0, -1):
        total = total * square + 1.0 / (2 * k + 1)
    return total * t**3


def minus_arctan(t: Array) -> Array:
    """Return t - arctan(t) for t >= 0 without cancellation."""
    small = t < 0.5
    return np.where(small, _odd_tail(np.where(small, t, 0.0), -1.0), t - np.arctan(t))


def minus_tanh(t: Array) -> Array:
    """Return t - tanh(t) for t >= 0 without cancellation."""
    tanh = np.tanh(t)
    small = tanh < 0.5
    # With s = tanh(t), t - s = artanh(s) - s, whose series has positive terms only.
    return np.where(small, _odd_tail(np.where(small, tanh, 0.0), 1.0), t - tanh)
