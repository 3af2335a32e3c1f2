"""The method `slippy`: boundary elements of others under test."""

from __future__ import annotations

from comparisons.geometry.prepare import IndenterGeometry
from comparisons.methods.peers.live import LiveCode
from comparisons.tasks.solution import Solution
from comparisons.tasks.task import Task


class Slippy(LiveCode):
    """slippy's boundary elements, 128 x 128 cells over six contact radii for each load."""

    name = "slippy"
    code = "slippy"
    releases = {"slippy": "0.2.0"}  # noqa: RUF012 - read only
    install = "see docs/live-codes.md"
    wants = "slippy is told the depth: prescribe penetrations"

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        """Press the ball at all penetrations in one process."""
        outcome = self.ask({"depths": (task.loads.values / self.radius).tolist()})
        if not outcome.ok:
            return self.lost(task, outcome)
        answer = outcome.answer
        curves = {
            "penetration": task.loads.values,
            "force": self.scene.effective_modulus * self.radius**2 * answer["force"],
            "contact_area": self.radius**2 * answer["contact_area"],
        }
        solution = Solution.of(task, curves, unknowns=128**2)
        solution.seconds = answer["seconds"]
        for step, converged in enumerate(answer["converged"]):
            if not converged:
                solution.fail((0, step), "slippy did not converge")
        return solution
