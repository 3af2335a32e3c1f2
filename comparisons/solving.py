"""Plans solved in memory: for single solves, claims and checks that keep no folder."""

from __future__ import annotations

from comparisons.archive import joined
from comparisons.execution import REPEATS, execute
from comparisons.methods import Solution, Task
from comparisons.planning import Plan
from comparisons.reference import Solved


def solve_plan(plan: Plan, repeats: int = REPEATS) -> Solved:
    """Solve every method and resolution of a plan; blocks of realisations are joined.

    Nothing raises for physics: a step without an answer is NaN, with its reason. One repeat is
    enough where times do not matter.

    Examples
    --------
    >>> from comparisons.planning import plan_scene
    >>> from comparisons.scene import load_scene
    >>> scene = load_scene("paraboloid", {"compare.methods": ["closed_form", "reduced"]})
    >>> solved = solve_plan(plan_scene(scene)[0])
    >>> sorted(solved)
    [('closed_form', 1), ('reduced', 10), ('reduced', 20), ('reduced', 40)]
    """
    blocks: dict[tuple[str, int], list[Task]] = {}
    for task in plan.tasks:
        blocks.setdefault((task.method, task.resolution), []).append(task)
    return {key: solve_blocks(tasks, repeats) for key, tasks in blocks.items()}


def solve_blocks(tasks: list[Task], repeats: int = REPEATS) -> Solution:
    """Solve the blocks of realisations of one method at one resolution as one solution."""
    return joined([execute(task, repeats) for task in tasks])
