"""Solvers: packages by physics, one small file per method in them, with a common interface.

This module exports what a method file needs; `comparisons.methods.registry` lists all solvers.
"""

from __future__ import annotations

from comparisons.methods.solver import Refused, Solver, method, needed
from comparisons.scene.scene import Scene
from comparisons.tasks.solution import Solution
from comparisons.tasks.steps import NoAnswerError, OutOfRangeError, Row, Step
from comparisons.tasks.task import Task
from reference.errors import NoEquilibriumError

__all__ = [
    "NoAnswerError",
    "NoEquilibriumError",
    "OutOfRangeError",
    "Refused",
    "Row",
    "Scene",
    "Solution",
    "Solver",
    "Step",
    "Task",
    "method",
    "needed",
]
