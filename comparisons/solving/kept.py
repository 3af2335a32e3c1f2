"""Plans solved in memory: for single solves, claims and checks that keep no folder."""

from __future__ import annotations

import contextlib
from dataclasses import replace
from pathlib import Path

from comparisons.errors import ResultsError
from comparisons.solving.execution import REPEATS, execute
from comparisons.solving.planning import Plan
from comparisons.tasks.archive import load_solution, save_solution
from comparisons.tasks.solution import REALISATIONS, Solution, Solved
from comparisons.tasks.task import Task


def solve_plan(
    plan: Plan,
    repeats: int = REPEATS,
    *,
    known: Solved | None = None,
    bodies: bool = True,
    kept: Path | None = None,
) -> Solved:
    """Solve every method and resolution of a plan; blocks of realisations are joined.

    Nothing raises for physics: a step without an answer is NaN, with its reason.

    Parameters
    ----------
    plan : Plan
    repeats : int
        Of short solves, for their times; one is enough where times do not matter.
    known : dict, optional
        What of it is solved already; it is not changed, and part of the answer.
    bodies : bool
        Compute the fields in the body, where the plan asks for them.
    kept : Path, optional
        Folder of solved tasks: what is there is taken, what is new is added.

    Examples
    --------
    >>> from comparisons.solving.planning import plan_scene
    >>> from comparisons.scene.scene import load_scene
    >>> scene = load_scene("paraboloid", {"compare.methods": ["closed_form", "reduced"]})
    >>> solved = solve_plan(plan_scene(scene)[0])
    >>> sorted(solved)
    [('closed_form', 1), ('reduced', 10), ('reduced', 20), ('reduced', 40)]
    """
    blocks: dict[tuple[str, int], list[Task]] = {}
    for task in plan.tasks:
        wanted = task if bodies else replace(task, with_body=False)
        blocks.setdefault((task.method, task.resolution), []).append(wanted)
    solved = dict(known or {})
    for key, tasks in blocks.items():
        if key not in solved:
            solved[key] = solve_blocks(tasks, repeats, kept)
    return solved


def solve_blocks(tasks: list[Task], repeats: int = REPEATS, kept: Path | None = None) -> Solution:
    """Solve the blocks of realisations of one method at one resolution as one solution."""
    return Solution.concat([_solved(task, repeats, kept) for task in tasks], axis=REALISATIONS)


def _solved(task: Task, repeats: int, kept: Path | None) -> Solution:
    """Take a solution from the folder if a whole one with an answer is there."""
    path = None if kept is None else kept / f"{task.key}.npz"
    if path is not None and path.exists():
        with contextlib.suppress(ResultsError):
            known = load_solution(path)
            if known.converged.any():
                return known
    solution = execute(task, repeats)
    if path is not None:
        save_solution(path, solution)
    return solution
