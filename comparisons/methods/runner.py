"""Execution of a solver: derived quantities are added, failures affect only their own steps.

Grids and lines of springs are laid out for one contact radius, so that a load whose contact is a
thousand times smaller would fall into a single cell and come out wrong without a sign of it.
A task is therefore cut into spans whose contact radii differ by no more than the method's
`span`. A span that raises is cut again, so that one absurd load costs its own step only.
"""

from __future__ import annotations

import traceback
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from typing import Any

from comparisons.errors import is_interrupt
from comparisons.facts.quantities import derived
from comparisons.geometry.bodies import BodyGeometry
from comparisons.geometry.prepare import IndenterGeometry
from comparisons.methods import Solver, Task
from comparisons.reasons import in_kind
from comparisons.tasks.solution import STEPS, MalformedError, Solution
from comparisons.tasks.steps import NO_ANSWER

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

    Loads over many decades are solved span by span (ratios of contact radii on one grid), and
    joined again. A step without an answer, or with a quantity that is no number, is NaN in all
    quantities, with its reason; `reason` puts an exception that is none of the numerics' own into
    words.
    """
    span = solver.span if span is None else span
    # the load steps at which a new span begins, from the last; and their number
    steps, geometry = len(task.loads.values), task.geometry
    cuts = [steps]
    if isinstance(geometry, IndenterGeometry) and len(geometry.contact_radii) == steps:
        radii = geometry.contact_radii
        largest = radii[-1]
        for step in range(steps - 2, -1, -1):
            # A load without an estimate (NaN) is a span of its own.
            if not radii[step] * span >= largest:
                cuts.append(step + 1)
                largest = radii[step]
    cuts = [0, *reversed(cuts)]
    parts = [_contained(solver, _part(task, *cut), reason) for cut in pairwise(cuts)]
    solution = Solution.concat(parts, axis=STEPS)
    solution.refuse_nan()
    return solution


def _part(task: Task, start: int, end: int) -> Task:
    """Return the task of some of the loads, laid out for the largest of them."""
    steps = len(task.loads.values)
    if (start, end) == (0, steps) and end == 1:
        return task
    geometry = task.geometry
    if isinstance(geometry, IndenterGeometry) and len(geometry.contact_radii) == steps:
        inside = slice(start, end)
        geometry = replace(
            geometry,
            penetration=geometry.penetrations[end - 1],
            contact_radius=geometry.contact_radii[end - 1],
            penetrations=geometry.penetrations[inside],
            contact_radii=geometry.contact_radii[inside],
            unreached={
                s - start: reason for s, reason in geometry.unreached.items() if start <= s < end
            },
        )
    loads = replace(task.loads, values=task.loads.values[start:end])
    body = task.with_body and end == steps
    return replace(task, geometry=geometry, loads=loads, with_body=body)


def _contained(solver: Solver[Any], task: Task, reason: Callable[[Exception], str]) -> Solution:
    """Solve one span, and derive what the method has not computed itself.

    Where it raises its halves are solved, as long as the smaller loads succeed.
    """
    steps = len(task.loads.values)
    unreached = task.geometry.unreached if isinstance(task.geometry, IndenterGeometry) else {}
    if unreached:
        return Solution.lost(task, f"no contact can be estimated: {unreached[0]}")
    try:
        try:
            solution = solver.solve(task)
            if not isinstance(solution, Solution):
                raise MalformedError(f"solve: expected a Solution, got {in_kind(solution)}")
        except NO_ANSWER as error:  # of the solve alone: what is derived has no such words
            return Solution.lost(task, error.reason)
        # a body of revolution pressed onto a plane touches it in a circle
        geometry, dragged = task.geometry, _DRAGGED & set(task.scene.physics)
        is_round = isinstance(geometry, IndenterGeometry) and geometry.indenter.axisymmetric
        on_plane = not isinstance(geometry, BodyGeometry) or geometry.flat_surface
        is_round = is_round and on_plane and not dragged
        solution.quantities.update(derived(solution.quantities, task.scene, is_round=is_round))
        return solution
    except Exception as error:  # the other loads carry on
        if is_interrupt(error):
            raise KeyboardInterrupt from error
        message = reason(error)
    if steps == 1 or task.loads.is_path:  # the rest of a path cannot begin anew
        return Solution.lost(task, message)
    half = steps // 2
    below = _contained(solver, _part(task, 0, half), reason)
    if not below.converged.any():
        return Solution.lost(task, message)
    above = _contained(solver, _part(task, half, steps), reason)
    return Solution.concat([below, above], axis=STEPS)
