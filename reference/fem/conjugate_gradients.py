"""Preconditioned conjugate gradients, for one right-hand side or several at once."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray

from reference.errors import ConvergenceError

Array = NDArray[np.float64]

MOST_STEPS = 1000


def conjugate_gradients(
    act: Callable[[Array], Array],
    precondition: Callable[[Array], Array],
    loads: Array,
    tolerance: float,
) -> tuple[Array, int]:
    """Return the solution of a positive definite system for loads (n,) or (n, k), and the steps.

    The tolerance is that of the residual in the norm of the preconditioner, over the load's. Raises
    ConvergenceError after a thousand steps, or if the preconditioner is not definite; the history
    has the largest relative residual by step.

    >>> matrix = np.array([[2.0, 1.0], [1.0, 2.0]])
    >>> conjugate_gradients(matrix.__matmul__, np.copy, np.array([4.0, 5.0]), 1e-12)
    (array([1., 2.]), 2)
    """
    # Saad 2003, alg. 9.1, for every column alone. Units of powers of two change no digit, and
    # preconditioners in single precision have no numbers below 1e-45.
    units = power_of_two(loads)
    residual = loads / units
    values = np.zeros_like(residual)
    dot = np.dot if loads.ndim == 1 else partial(np.einsum, "ik,ik->k")
    direction = precondition(residual)
    size = start = dot(residual, direction)
    history = [1.0]
    while residual.any() and not history[-1] <= tolerance:
        if not (
            np.max(size) > 0.0 <= np.min(size)
        ):  # NaN, or a preconditioner that is not definite
            raise ConvergenceError("conjugate gradients broke down", history)
        if len(history) > MOST_STEPS:
            raise ConvergenceError("conjugate gradients did not converge", history)
        image = act(direction)
        work = dot(direction, image)
        step = np.divide(size, work, out=np.zeros_like(size), where=size > 0.0)
        values += step * direction
        residual -= step * image
        upward = precondition(residual)
        last, size = size, dot(residual, upward)
        turn = np.divide(size, last, out=np.zeros_like(size), where=last > 0.0)
        direction = upward + turn * direction
        largest = np.max(np.divide(size, start, out=np.zeros_like(size), where=start > 0.0))
        history.append(float(np.sqrt(largest)) if np.min(size) >= 0.0 else np.nan)
    return values * units, len(history) - 1


def power_of_two(values: Array) -> Array:
    """Return a power of two of the size of the largest value of each column, 1 of none."""
    largest = np.abs(values).max(axis=0, initial=0.0)
    good = (largest > 0.0) & (largest < np.inf)
    return np.asarray(np.ldexp(1.0, np.frexp(np.where(good, largest, 1.0))[1] - 1))
