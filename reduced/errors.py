"""The error of solvers in this package that do not converge."""

from __future__ import annotations

from collections.abc import Sequence


class ConvergenceError(RuntimeError):
    """A solver stopped without a reliable answer: cause, and convergence measure by iteration."""

    def __init__(self, reason: str, history: Sequence[float] = ()) -> None:
        super().__init__(reason)
        self.reason = reason
        self.history = list(history)
