"""Refinement of a tangential path for 3-D solvers: normal loading first, then tangential."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import TypeVar

import numpy as np

from comparisons.methods.solver import needed
from comparisons.tasks.task import Task
from reference.loads import LoadPath

# The contact is pressed in this many geometric steps from a share of its load, for the slip that
# pressing itself causes; per unit of resolution, at least.
PRESSING, LEAST_PRESSES, FIRST_SHARE = 0.5, 6, 0.02
# A stretch of the path is cut into one more step for each so many cells per contact radius.
CELLS_PER_PART = 16

Step = TypeVar("Step")


@dataclass(frozen=True)
class FinerPath:
    """Normal and tangential loads of all steps, and which of them the scene asked for."""

    loads: tuple[LoadPath, LoadPath]
    presses: int
    parts: int

    def scene_steps(self, steps: Iterable[Step]) -> Iterator[Step]:
        """Yield the steps at the scene's own loads."""
        for number, step in enumerate(steps, 1 - self.presses):
            if number > 0 and number % self.parts == 0:
                yield step


def normal_load(task: Task) -> tuple[str, float]:
    """Return the control and the normal load that is held."""
    normal = needed(task.loads.normal, "no normal load is held")
    return normal.control, float(normal.values[-1])


def held_steps(task: Task, friction: float, force: float) -> int:
    """Return how many steps of the path come before the contact slides as a whole."""
    if task.loads.control != "tangential_force":
        return len(task.loads.values)
    above = np.abs(task.loads.values) > friction * force
    return int(np.argmax(above)) if above.any() else len(above)


def finer_path(task: Task, per_radius: int, coupled: bool) -> FinerPath:
    """Cut a path into steps for a grid of so many cells, or spacings of nodes, per contact radius.

    Steps grow finer with the grid, as the answer is of first order in both: then the bar that
    three resolutions give covers either. Without coupling pressing causes no slip: one step.
    """
    control, load = normal_load(task)
    presses = max(LEAST_PRESSES, round(PRESSING * per_radius)) if coupled else 1
    parts = 1 + per_radius // CELLS_PER_PART
    knots = np.concatenate([[0.0], task.loads.values])
    ways = [a + (b - a) * np.arange(1, parts + 1) / parts for a, b in pairwise(knots)]
    path = np.concatenate([np.zeros(presses), *ways])
    pressing = np.geomspace(FIRST_SHARE, 1.0, presses) if coupled else np.ones(1)
    normal = load * np.concatenate([pressing, np.ones(path.size - presses)])
    loads = LoadPath(control, normal), LoadPath(task.loads.control, path)
    return FinerPath(loads, presses, parts)
