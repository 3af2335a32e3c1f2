"""Quadrature with singular end points: the double-exponential rule on many panels at once.

`scipy.integrate.tanhsinh` implements the same rule with the same accuracy, but its overhead of a
millisecond per call made solves of a sphere or a power law take two to three times as long.
"""

from collections.abc import Callable
from functools import cache

import numpy as np

from reduced.errors import ConvergenceError

_COARSEST, _FINEST = 4, 8
_CHANGE = float(np.sqrt(1e-13))  # from step to step, relative
_RANGE = 4.0  # the first node is 5e-38 from the end: enough for an inverse square root


@cache
def double_exponential(level: int) -> tuple[np.ndarray, np.ndarray]:
    """Return nodes and weights of the tanh-sinh rule on (0, 1) with step 2^-level.

    Nodes cluster at both ends fast enough for any integrable algebraic or logarithmic singularity
    there (Takahasi & Mori 1974). The even nodes are those of the previous level.
    """
    count = int(_RANGE * 2**level)
    u = np.arange(-count, count + 1) / 2**level
    nodes = 1 / (1 + np.exp(-np.pi * np.sinh(u)))
    weights = np.pi * np.cosh(u) / (4 * np.cosh(np.pi / 2 * np.sinh(u)) ** 2) * 2.0**-level
    return nodes, weights / weights.sum()


@cache
def gauss_legendre(order: int) -> tuple[np.ndarray, np.ndarray]:
    """Return nodes and weights of the Gauss-Legendre rule on (0, 1)."""
    nodes, weights = np.polynomial.legendre.leggauss(order)
    return (nodes + 1) / 2, weights / 2


def integrate_panels(
    function: Callable[[np.ndarray, np.ndarray], np.ndarray], lower: np.ndarray, upper: np.ndarray
) -> np.ndarray:
    """Integrate a function over adjacent panels, with possible singularities at panel ends.

    `function` takes t (k, panels, nodes) and the row numbers (k, 1, 1); the panels (k, panels) with
    upper <= lower contribute nothing. Halving the step squares the error of the rule, so a step is
    accepted if it changes the result by less than the root of 1e-13 of the integral of the absolute
    value; ConvergenceError if the finest one does not (an unmarked breakpoint).
    """
    width = np.maximum(upper - lower, 0.0)[..., None]
    row = np.arange(lower.shape[0])[:, None, None]
    history: list[float] = []
    for level in range(_COARSEST, _FINEST + 1):
        nodes, weights = double_exponential(level)
        values = np.where(width > 0, function(lower[..., None] + width * nodes, row), 0.0) * width
        fine = (values * weights).sum(axis=(1, 2))
        middle = nodes.size // 2
        even = slice(middle % 2, None, 2)
        coarse = (values[..., even] * (weights[even] / weights[even].sum())).sum(axis=(1, 2))
        scale = (np.abs(values) * weights).sum(axis=(1, 2))
        change = np.abs(fine - coarse)
        history.append(float(np.max(change / np.where(scale > 0, scale, 1.0), initial=0.0)))
        if history[-1] <= _CHANGE:
            return fine
    raise ConvergenceError("quadrature does not converge: pass the kinks as breakpoints", history)
