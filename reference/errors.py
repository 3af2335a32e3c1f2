"""How a solver of this package says that it did not converge."""

from __future__ import annotations

from collections.abc import Sequence


class ConvergenceError(RuntimeError):
    """A solver stopped without an answer it can stand by.

    Parameters
    ----------
    reason : str
        What happened, in words a user can act on.
    history : sequence of float, optional
        The convergence measure of each iteration, so that a report can show where it stalled.
    """

    def __init__(self, reason: str, history: Sequence[float] = ()) -> None:
        super().__init__(reason)
        self.reason = reason
        self.history = list(history)
