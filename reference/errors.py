"""The error of solvers in this package that do not converge."""

from __future__ import annotations

from collections.abc import Sequence


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
