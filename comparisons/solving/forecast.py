"""How long a study still takes, from what like tasks have cost so far - not from their count."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field

from comparisons.facts.methods import growth
from comparisons.tasks.task import Task


@dataclass(frozen=True)
class Remaining:
    """Seconds that are left, and whether that is all: False where no like task was done yet."""

    seconds: float
    complete: bool


@dataclass
class Forecast:
    """Measured costs of tasks: seconds per realisation, by scene, method and resolution.

    A task is as dear as others of its scene, method and resolution; else as those of the scene and
    method at the nearest resolution, scaled by the method's growth of work; else as the method's
    mean task. Where the method is new, nothing is known.
    """

    _costs: dict[tuple[str, str], dict[int, tuple[float, int]]] = field(default_factory=dict)

    def learn(self, task: Task, seconds: float) -> None:
        """Remember what a task has cost, compilation apart."""
        if not math.isfinite(seconds):
            return
        own = self._costs.setdefault((task.scene.name, task.method), {})
        spent, count = own.get(task.resolution, (0.0, 0))
        own[task.resolution] = (spent + max(seconds, 0.0), count + len(task.realisations))

    def cost(self, task: Task) -> float | None:
        """Return the seconds that a task will take, None where nothing is known."""
        own = self._costs.get((task.scene.name, task.method))
        if own is None:
            return self._of_method(task)
        nearest = min(own, key=lambda n: abs(math.log(n / task.resolution)))
        spent, count = own[nearest]
        doublings = math.log2(task.resolution / nearest)
        more = growth(task.method) ** doublings
        return spent / count * len(task.realisations) * more

    def _of_method(self, task: Task) -> float | None:
        found = [
            each
            for (_, method), own in self._costs.items()
            if method == task.method
            for each in own.values()
        ]
        if not found:
            return None
        spent, count = (sum(each) for each in zip(*found, strict=True))
        return spent / count * len(task.realisations)

    def remaining(self, tasks: Iterable[Task], workers: int) -> Remaining:
        """Return how long the tasks take, spread over the workers."""
        costs = [self.cost(task) for task in tasks]
        known = [each for each in costs if each is not None]
        # However many workers there are, the dearest task is one worker's.
        seconds = max(sum(known) / workers, max(known, default=0.0))
        return Remaining(seconds, len(known) == len(costs))
