"""Loads over many decades: each span of contact sizes gets a grid of its own.

Grids and lines of springs are laid out for one contact radius, so that a load whose contact is a
thousand times smaller would fall into a single cell and come out wrong without a sign of it.
A task is therefore cut into spans whose contact radii differ by no more than the method's
`span`. A span that raises is cut again, so that one absurd load costs its own step only.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

from comparisons.geometry.prepare import IndenterGeometry
from comparisons.tasks.solution import STEPS, Solution
from comparisons.tasks.task import Task

Solve = Callable[[Task], Solution]


def solve_in_decades(
    task: Task, span: float, solve: Solve, reason: Callable[[Exception], str]
) -> Solution:
    """Solve a task span by span, and join the load steps again.

    Parameters
    ----------
    task : Task
    span : float
        Largest ratio of contact radii on one grid.
    solve : callable
        Solves a task whose contacts are of similar size.
    reason : callable
        Puts an exception into words.
    """
    cuts = _cuts(task, span)
    parts = [_contained(_part(task, *cut), solve, reason) for cut in pairwise(cuts)]
    return Solution.concat(parts, axis=STEPS)


def _cuts(task: Task, span: float) -> list[int]:
    """Return the load steps at which a new span begins, and their number at the end."""
    steps = len(task.loads.values)
    geometry = task.geometry
    if not isinstance(geometry, IndenterGeometry) or len(geometry.contact_radii) != steps:
        return [0, steps]
    radii, cuts = geometry.contact_radii, [steps]
    largest = radii[-1]
    for step in range(steps - 2, -1, -1):
        # A load without an estimate (NaN) is a span of its own.
        if not radii[step] * span >= largest:
            cuts.append(step + 1)
            largest = radii[step]
    return [0, *reversed(cuts)]


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


def _contained(task: Task, solve: Solve, reason: Callable[[Exception], str]) -> Solution:
    """Solve one span; where it raises, its halves, as long as the smaller loads succeed."""
    steps = len(task.loads.values)
    unreached = task.geometry.unreached if isinstance(task.geometry, IndenterGeometry) else {}
    if unreached:
        return Solution.lost(task, f"no contact can be estimated: {unreached[0]}")
    try:
        return solve(task)
    except Exception as error:  # the other loads carry on
        message = reason(error)
    if steps == 1 or task.loads.is_path:  # the rest of a path cannot begin anew
        return Solution.lost(task, message)
    half = steps // 2
    below = _contained(_part(task, 0, half), solve, reason)
    if not below.converged.any():
        return Solution.lost(task, message)
    above = _contained(_part(task, half, steps), solve, reason)
    return Solution.concat([below, above], axis=STEPS)
