"""Errors of this package: solvers that do not converge, and arguments that cannot be.

Every check of arguments returns a list of messages; `refuse` raises them as one ValueError.
"""

from collections.abc import Collection, Sequence
from typing import Any

import numpy as np


class ConvergenceError(RuntimeError):
    """A solver stopped without a reliable answer.

    Parameters
    ----------
    reason : str
        The cause, in words that help the user.
    history : sequence of float, optional
        The convergence measure by iteration, for reports.
    """

    def __init__(self, reason: str, history: Sequence[float] = ()) -> None:
        super().__init__(reason)
        self.reason = reason
        self.history = list(history)


class NoEquilibriumError(ConvergenceError):
    """No state carries a load, whatever solves it: that is the answer."""


def positive_faults(**values: Any) -> list[str]:
    """Return a message for every number that is not positive and finite.

    >>> positive_faults(mass=-1.0, load=2.0)
    ['mass must be positive and finite, not -1.0']
    """
    return [
        f"{name} must be positive and finite, not {value!r}"
        for name, value in values.items()
        if not (
            np.ndim(value) == 0 and np.asarray(value).dtype.kind in "iuf" and 0 < value < np.inf
        )
    ]


def finite_faults(**values: float) -> list[str]:
    """Return a message for every number that is not finite."""
    return [
        f"{name} must be finite, not {value!r}"
        for name, value in values.items()
        if not np.isfinite(value)
    ]


def poisson_faults(poisson_ratio: float) -> list[str]:
    """Return a message if Poisson's ratio is not that of a stable isotropic solid."""
    stable = -1 < poisson_ratio <= 0.5
    return [] if stable else [f"poisson_ratio must lie in (-1, 0.5], not {poisson_ratio!r}"]


def spacing_faults(spacing: tuple[float, float]) -> list[str]:
    """Return a message if cell sides are not two positive lengths."""
    good = np.shape(spacing) == (2,) and all(np.isfinite(side) and side > 0 for side in spacing)
    return [] if good else [f"spacing must be two positive lengths (dx, dy), not {spacing!r}"]


def count_faults(least: int, **values: float) -> list[str]:
    """Return a message for every number that is not an integer of at least `least`."""
    return [
        f"{name} must be an integer of at least {least}, not {value!r}"
        for name, value in values.items()
        if not (np.isfinite(value) and int(value) == value and value >= least)
    ]


def choice_faults(name: str, value: object, known: Collection[object]) -> list[str]:
    """Return a message if a value is not among the choices.

    >>> choice_faults("order", 3, (1, 2))
    ['order must be 1 or 2, not 3']
    """
    *most, last = map(repr, known)
    return [] if value in known else [f"{name} must be {', '.join(most)} or {last}, not {value!r}"]


def refuse(faults: list[str]) -> None:
    """Raise one ValueError with all faults, if there are any."""
    if faults:
        raise ValueError("; ".join(faults))
