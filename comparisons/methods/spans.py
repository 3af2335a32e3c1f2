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

import numpy as np

from comparisons.geometry.prepare import IndenterGeometry
from comparisons.methods.base import Solution, Task

Solve = Callable[[Task], Solution]


def solve_in_spans(
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
    parts = [_contained(_part(task, *each), solve, reason) for each in pairwise(cuts)]
    return parts[0] if len(parts) == 1 else _one_after_another(parts)


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
            unreached={s - start: why for s, why in geometry.unreached.items() if start <= s < end},
        )
    loads = replace(task.loads, values=task.loads.values[start:end])
    body = task.with_body and end == steps
    return replace(task, geometry=geometry, loads=loads, with_body=body)


def _contained(task: Task, solve: Solve, reason: Callable[[Exception], str]) -> Solution:
    """Solve one span; where it raises, its halves, as long as the smaller loads succeed."""
    steps = len(task.loads.values)
    unreached = task.geometry.unreached if isinstance(task.geometry, IndenterGeometry) else {}
    if unreached:
        return lost(task, f"no contact can be estimated: {unreached[0]}")
    try:
        return solve(task)
    except Exception as error:  # the other loads carry on
        why = reason(error)
    if steps == 1 or task.loads.is_path:  # the rest of a path cannot begin anew
        return lost(task, why)
    half = steps // 2
    below = _contained(_part(task, 0, half), solve, reason)
    if not below.converged.any():
        return lost(task, why)
    return _one_after_another([below, _contained(_part(task, half, steps), solve, reason)])


def lost(task: Task, reason: str) -> Solution:
    """Return a solution without answers, for a task that could not be solved at all."""
    solution = Solution.empty(task)
    for row in range(len(task.realisations)):
        for step in range(len(task.loads.values)):
            solution.fail((row, step), reason)
    return solution


def _one_after_another(parts: list[Solution]) -> Solution:
    """Join solutions of the same realisations along the load steps; fields are the last one's."""
    starts = np.cumsum([0, *(part.converged.shape[1] for part in parts)])
    names = dict.fromkeys(name for part in parts for name in part.quantities)
    quantities = {
        name: np.concatenate(
            [p.quantities.get(name, np.full(p.converged.shape, np.nan)) for p in parts], axis=1
        )
        for name in names
    }
    return replace(
        parts[-1],
        quantities=quantities,
        converged=np.concatenate([p.converged for p in parts], axis=1),
        iterations=np.concatenate([p.iterations for p in parts], axis=1),
        violation=np.concatenate([p.violation for p in parts], axis=1),
        unknowns=max(p.unknowns for p in parts),
        reasons={
            (row, step + int(start)): why
            for part, start in zip(parts, starts, strict=False)
            for (row, step), why in part.reasons.items()
        },
        step_fields={
            step + int(start): build
            for part, start in zip(parts, starts, strict=False)
            for step, build in part.step_fields.items()
        },
        # Of methods that take their own time; a span without an answer has none.
        seconds=float(np.nansum([p.seconds for p in parts])),
        setup_seconds=sum(p.setup_seconds for p in parts),
        compile_seconds=sum(p.compile_seconds for p in parts),
        memory=max(p.memory for p in parts),
    )
