"""Errors of this package: solvers that do not converge, and arguments that cannot be.

Every check of arguments returns a list of messages; `refuse` raises them as one ValueError.
"""

from collections.abc import Collection, Sequence
from typing import TypeGuard

import numpy as np
from numpy.typing import ArrayLike


class ConvergenceError(RuntimeError):
    """A solver stopped without a reliable answer: cause, and convergence measure by iteration."""

    def __init__(self, reason: str, history: Sequence[float] = ()) -> None:
        super().__init__(reason)
        self.reason = reason
        self.history = list(history)


def positive_faults(**values: object) -> list[str]:
    """Return a message for every value that is not finite and positive.

    >>> positive_faults(radius=2.0, spacing=-1.0)
    ['spacing must be finite and positive, got -1.0']
    """
    return [
        f"{name} must be finite and positive, got {value!r}"
        for name, value in values.items()
        if not (_is_finite(value) and value > 0)
    ]


def nonnegative_faults(**values: object) -> list[str]:
    """Return a message for every value that is not finite and >= 0."""
    return [
        f"{name} must be finite and >= 0, got {value!r}"
        for name, value in values.items()
        if not (_is_finite(value) and value >= 0)
    ]


def finite_faults(**values: object) -> list[str]:
    """Return a message for every value that is not finite."""
    return [
        f"{name} must be finite, got {value!r}"
        for name, value in values.items()
        if not _is_finite(value)
    ]


def list_faults(*, increasing: bool = False, **lists: ArrayLike) -> list[str]:
    """Return a message for every list that is not finite, or positive and strictly increasing."""
    wrong, more = [], ", positive and strictly increasing" if increasing else ""
    for name, values in lists.items():
        numbers = np.array(values, dtype=float, ndmin=1)
        if numbers.ndim != 1 or numbers.size == 0:
            wrong.append(f"{name} must be a non-empty 1-D list, got shape {numbers.shape}")
            continue
        rises = not increasing or (numbers[0] > 0 and np.all(np.diff(numbers) > 0))
        if not (np.isfinite(numbers).all() and rises):
            wrong.append(f"{name} must be finite{more}, got {values!r}")
    return wrong


def poisson_faults(poisson_ratio: object) -> list[str]:
    """Return a message if Poisson's ratio is not that of a stable isotropic solid."""
    good = _is_finite(poisson_ratio) and -1 < poisson_ratio <= 0.5
    return [] if good else [f"poisson_ratio must lie in (-1, 0.5], got {poisson_ratio!r}"]


def count_faults(least: int = 1, **values: object) -> list[str]:
    """Return a message for every value that is not an integer >= `least`."""
    return [
        f"{name} must be an integer >= {least}, got {value!r}"
        for name, value in values.items()
        if not (_is_finite(value) and value == int(value) >= least)
    ]


def choice_faults(name: str, value: object, choices: Collection[str]) -> list[str]:
    """Return a message if a value is not among the choices.

    >>> choice_faults("edges", "cell", ("sub_cell", "nodal"))
    ["edges must be one of 'sub_cell', 'nodal', got 'cell'"]
    """
    names = ", ".join(map(repr, choices))
    return [] if value in choices else [f"{name} must be one of {names}, got {value!r}"]


def refuse(wrong: list[str]) -> None:
    """Raise one ValueError with all messages, if there are any."""
    if wrong:
        raise ValueError("; ".join(wrong))


def _is_finite(value: object) -> TypeGuard[float]:
    array = np.asarray(value)
    return array.ndim == 0 and array.dtype.kind in "iuf" and bool(np.isfinite(array))
