"""Quadrature between singular ends: SciPy's tanh-sinh rule on the panels between breakpoints."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
from scipy.integrate import tanhsinh

from .errors import ConvergenceError

# Levels of the rule: from 130 nodes, enough for the profiles of this package, to 2050, which do
# not help a missed kink.
_COARSEST, _FINEST = 3, 7
# Error asked of each panel, relative to the integral or to the size of the integrand, and the one
# at which the result is refused: a slope by differences is known to some 1e-11 only.
_ASKED, _REFUSED = 1e-13, 1e-8


@cache
def gauss_legendre(order: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights of the Gauss-Legendre rule on (0, 1)."""
    nodes, weights = np.polynomial.legendre.leggauss(order)
    return (nodes + 1) / 2, weights / 2


def integrate_panels(
    function: Callable[[np.ndarray, np.ndarray], np.ndarray],
    lower: np.ndarray,
    upper: np.ndarray,
    parameter: np.ndarray,
) -> np.ndarray:
    """Integrate a function over adjoining panels, with singularities at panel ends allowed.

    Parameters
    ----------
    function : callable
        function(t, parameter), elementwise on arrays that broadcast.
    lower, upper : ndarray, shape (k, panels)
        Ends of the panels; a panel with upper <= lower contributes nothing.
    parameter : ndarray, shape (k,)
        What the integrand of each row depends on.

    Returns
    -------
    ndarray, shape (k,)

    Raises
    ------
    ConvergenceError
        With the error of every row, if the finest rule leaves one: an unmarked breakpoint.

    Examples
    --------
    >>> lower, upper = np.array([[0.0, 0.5]] * 2), np.array([[0.5, 1.0]] * 2)
    >>> areas = integrate_panels(np.power, lower, upper, np.array([-0.5, 1.0]))
    >>> bool(np.allclose(areas, [2, 0.5], rtol=1e-13))
    True
    """
    wide = upper > lower
    start, stop = lower[wide], upper[wide]
    of_row = np.broadcast_to(parameter[:, None], lower.shape)[wide]
    # in units of its size an integral that cancels, or is zero, needs no tolerance of its own
    nodes, weights = gauss_legendre(5)
    samples = function(start[:, None] + (stop - start)[:, None] * nodes, of_row[:, None])
    size = (stop - start) * (np.abs(samples) @ weights)
    size = np.where(size > 0, size, 1.0)
    result = tanhsinh(
        lambda t, value, unit: function(t, value) / unit,
        *(start, stop),
        args=(of_row, size),
        rtol=_ASKED,
        atol=_ASKED,
        minlevel=_COARSEST,
        maxlevel=_FINEST,
    )
    parts, errors, sizes = np.zeros((3, *lower.shape))
    parts[wide], errors[wide], sizes[wide] = result.integral * size, result.error * size, size
    error, scale = errors.sum(axis=1), np.maximum(sizes, np.abs(parts)).sum(axis=1)
    if not (error <= _REFUSED * scale).all():
        raise ConvergenceError(
            "quadrature does not converge: pass the kinks as breakpoints",
            (error / np.where(scale > 0, scale, 1.0)).tolist(),
        )
    return parts.sum(axis=1)
