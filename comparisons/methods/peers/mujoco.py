"""The method `mujoco`: soft contact of a simulator of robots under test."""

from __future__ import annotations

from comparisons.geometry.prepare import IndenterGeometry
from comparisons.methods.peers.live import LiveCode
from comparisons.tasks.solution import Solution
from comparisons.tasks.task import Task

# 1 - the impedance of the script.
_YIELDS = 0.05


class MuJoCo(LiveCode):
    """MuJoCo's soft contact, a spring proportional to the mass: Hertz's depth at the largest force.

    At rest F = m k d/(1 - i). The parameter k follows for one mass: a ball twice as heavy is twice
    as stiff.
    """

    name = "mujoco"
    code = "MuJoCo"
    releases = {"mujoco": ""}  # noqa: RUF012 - read only
    install = "pip install mujoco"
    control = "force"
    wants = "MuJoCo is told the force on the ball: prescribe forces"

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        """Hold all forces in one process: the largest is 1, on a mass of 1."""
        largest = task.loads.values.max()
        hertz = (0.75 * largest / (self.scene.effective_modulus * self.radius**2)) ** (2 / 3)
        forces = task.loads.values / largest
        outcome = self.ask(
            {"stiffness": float(_YIELDS / hertz), "mass": 1.0, "forces": forces.tolist()}
        )
        if not outcome.ok:
            return self.lost(task, outcome)
        answer = outcome.answer
        curves = {
            "penetration": self.radius * answer["penetration"],
            "force": largest * answer["contact_force"],
        }
        solution = Solution.of(
            task,
            curves,
            unknowns=1,
            iterations=answer["steps"],
            setup_seconds=answer["setup_seconds"],
        )
        solution.seconds = answer["seconds"]
        return solution
