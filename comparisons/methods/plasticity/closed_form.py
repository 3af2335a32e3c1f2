"""Hertz's contact, up to first yield (Johnson 1985)."""

from __future__ import annotations

import numpy as np

from comparisons.geometry.prepare import IndenterGeometry
from comparisons.methods.normal.closed_form import ClosedForm
from comparisons.methods.plasticity.indentation import (
    ONLY_INDENTERS,
    PHYSICS,
    depth_of_yield,
)
from comparisons.methods.solver import Refused
from comparisons.scene.physics.absolute_loads import loads_of
from comparisons.scene.scene import Scene
from comparisons.tasks.solution import Solution
from comparisons.tasks.task import Task


class ClosedFormPlasticity(ClosedForm):
    """What does not yet make the half-space yield, round or elliptic; the load at which it does."""

    physics = PHYSICS
    only_indenters = ONLY_INDENTERS

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.yields_at = depth_of_yield(scene)
        loads = loads_of(scene)
        largest = float(loads.values.max())
        if loads.control == "force":
            largest = float(self.form.penetration(np.array(largest)))
        if largest > self.yields_at * (1 + 1e-12):
            raise Refused(
                "exact up to first yield only, and the largest load is at "
                f"{largest / self.yields_at:.3g} times its penetration"
            )

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        """Evaluate Hertz's formulas; nothing remains."""
        loads = task.loads.values
        if task.loads.control == "penetration":
            depth = np.maximum(loads, 0.0)
        else:
            depth = np.array([float(self.form.penetration(f)) if f > 0 else 0.0 for f in loads])
        pressed = depth > 0
        safe = np.where(pressed, depth, self.yields_at)
        force, area = np.asarray(self.form.force(safe)), np.asarray(self.form.contact_area(safe))
        return Solution.of(
            task,
            {
                "penetration": loads if task.loads.control == "penetration" else depth,
                "force": np.where(pressed, force, 0.0),
                "contact_area": np.where(pressed, area, 0.0),
                "residual_depth": 0.0,
                "first_yield": self.yields_at,
            },
            violation=0.0,
        )
