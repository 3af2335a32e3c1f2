"""Execution of a solver: derived quantities are added, failures affect only their own steps."""

from __future__ import annotations

import traceback
from collections.abc import Callable
from typing import Any

from comparisons.facts.quantities import derived
from comparisons.geometry.bodies import BodyGeometry
from comparisons.geometry.prepare import IndenterGeometry
from comparisons.methods.decades import solve_in_decades
from comparisons.methods.solver import Solver
from comparisons.reasons import in_kind
from comparisons.tasks.solution import MalformedError, Solution
from comparisons.tasks.steps import NO_ANSWER
from comparisons.tasks.task import Task

# Of a body that is dragged the contact is not round.
_DRAGGED = frozenset({"friction", "sliding"})


def in_words(error: Exception) -> str:
    """Return an exception that a method should not raise, with the function that raised it."""
    if isinstance(error, MalformedError):
        return str(error)
    where = traceback.extract_tb(error.__traceback__)[-1]
    name = type(error).__name__
    return f"{name}: {error} (in {where.name})" if str(error) else f"{name} in {where.name}"


def run(
    solver: Solver[Any],
    task: Task,
    *,
    span: float | None = None,
    reason: Callable[[Exception], str] = in_words,
) -> Solution:
    """Solve a task, whatever its loads and whatever happens.

    Loads over many decades are solved span by span (`comparisons.methods.decades`). A step without
    an answer, or with a quantity that is no number, is NaN in all quantities, with its reason.

    Parameters
    ----------
    solver : Solver
    task : Task
    span : float, optional
        Largest ratio of contact radii on one grid, in place of the solver's own.
    reason : callable
        Puts an exception that is none of the numerics' own into words.
    """
    largest = solver.span if span is None else span
    solution = solve_in_decades(task, largest, lambda part: _answer(solver, part), reason)
    solution.refuse_nan()
    return solution


def _answer(solver: Solver[Any], task: Task) -> Solution:
    try:
        solution = solver.solve(task)
        if not isinstance(solution, Solution):
            raise MalformedError(f"solve: expected a Solution, got {in_kind(solution)}")
    except NO_ANSWER as error:
        return Solution.lost(task, error.reason)
    # What the method has not computed itself.
    solution.quantities.update(derived(solution.quantities, task.scene, is_round=_is_round(task)))
    return solution


def _is_round(task: Task) -> bool:
    """Whether the contact is a circle: a body of revolution pressed onto a plane."""
    geometry = task.geometry
    if not isinstance(geometry, IndenterGeometry) or _DRAGGED & set(task.scene.physics):
        return False
    flat = not isinstance(geometry, BodyGeometry) or geometry.flat_surface
    return geometry.indenter.axisymmetric and flat
