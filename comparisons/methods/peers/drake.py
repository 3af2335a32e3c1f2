"""The method `drake`: hydroelastic contact under test."""

from __future__ import annotations

import numpy as np

from comparisons.geometry.prepare import IndenterGeometry
from comparisons.methods.peers.live import LiveCode
from comparisons.methods.solver import Refused
from comparisons.scene.physics.absolute_loads import loads_of
from comparisons.tasks.solution import Solution
from comparisons.tasks.task import Task


class Drake(LiveCode):
    """Drake's hydroelastic contact, a pressure that goes as the overlap: Hertz's at the last load.

    The force is (E_h/H) pi d^2 (R - d/3) under a slab of thickness H. Its modulus is a parameter
    without a rule: the one that gives Hertz's force at d* is E_h = (4/(3 pi)) E* H/sqrt(R d*).
    """

    name = "drake"
    code = "Drake"
    releases = {"drake": ""}  # noqa: RUF012 - read only
    install = "pip install drake"
    wants = "Drake is told where the ball is: prescribe penetrations"

    def _refuse_unfit(self) -> None:
        if float(loads_of(self.scene).values.max()) >= self.radius:
            raise Refused("its mesh is the lower half of the ball: press less deep than the radius")

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        """Place the ball at all penetrations in one process."""
        depths = task.loads.values / self.radius
        modulus = 4 / (3 * np.pi * np.sqrt(depths.max()))
        outcome = self.ask({"modulus": float(modulus), "depths": depths.tolist()})
        if not outcome.ok:
            return self.lost(task, outcome)
        answer = outcome.answer
        curves = {
            "penetration": task.loads.values,
            "force": self.scene.effective_modulus * self.radius**2 * answer["force"],
            "contact_area": self.radius**2 * answer["contact_area"],
        }
        solution = Solution.of(
            task, curves, unknowns=answer["faces"], setup_seconds=answer["setup_seconds"]
        )
        solution.seconds = answer["seconds"]
        return solution
