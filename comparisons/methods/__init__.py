"""Solvers: rooms by physics, one small file per method in them, with a common interface.

This module exports what a method file needs; `comparisons.methods.registry` lists all solvers.
"""

from __future__ import annotations

from typing import Any

from comparisons.methods.solver import Refused, Solver, needed
from comparisons.methods.user.function import method
from comparisons.tasks.solution import Solution
from comparisons.tasks.steps import NoAnswerError, Row, Step
from comparisons.tasks.task import Task

__all__ = [
    "NoAnswerError",
    "Refused",
    "Row",
    "Solution",
    "Solver",
    "Step",
    "Task",
    "method",
    "needed",
]


def __getattr__(name: str) -> Any:
    """Tell a method file of the earlier contract what has changed."""
    if name in ("Method", "Support"):
        raise ImportError(
            f"{name} is gone: a method is a class derived from Solver, made for a scene, whose "
            "constructor raises Refused where it cannot do it (docs/adding-a-method.md)"
        )
    raise AttributeError(name)
