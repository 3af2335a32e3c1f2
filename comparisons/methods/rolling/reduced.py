"""Rolling on the springs of the reduced model."""

from __future__ import annotations

import numpy as np

from comparisons.geometry.prepare import IndenterGeometry
from comparisons.methods.friction.path import normal_load
from comparisons.methods.normal.reduced import ReducedProfile, line_picture
from comparisons.methods.rolling.creeps import PHYSICS, acting, pairs, quantities, tables_of
from comparisons.methods.solver import Refused
from comparisons.scene.scene import Scene
from comparisons.tasks.solution import Solution
from comparisons.tasks.task import Task
from reduced.friction.roll import matched_modulus, roll
from reduced.friction.slide import Friction
from reduced.loads import Load
from reduced.springs.line import Springs
from reference.rolling.creep_theories import kalker


class ReducedRolling(ReducedProfile):
    """Springs that enter the contact unstretched and slip at mu times their normal force."""

    physics = PHYSICS
    options_read = frozenset({"rule", "edges", "rolling"})

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.rolling, friction = tables_of(scene)
        if self.rolling.spin:
            raise Refused("spin: a line has no width to turn on")
        self.friction = Friction(self._tangential_modulus(scene), friction.coefficient)

    def _tangential_modulus(self, scene: Scene) -> float:
        """Return G* of the springs: the chapter's, or that of the half-space's first slope."""
        if self.options.rolling == "springs":
            return scene.tangential_modulus
        creep, lateral = acting(self.rolling)
        if creep and lateral:
            raise Refused("springs of one stiffness cannot match the slopes of both creeps")
        nu = scene.poisson_ratio
        if nu < 0:
            raise Refused("Kalker's coefficients begin at nu = 0")
        return matched_modulus(scene.shear_modulus, kalker(1.0, nu)[lateral])

    def model(self, geometry: IndenterGeometry) -> str:
        """Name the line, and the tangential springs."""
        stiffness = "4G/(2 - nu) dx"
        if self.options.rolling == "matched":
            stiffness = "C G dx, C Kalker's coefficient of a circle"
        springs = f"tangential springs of {stiffness} that enter unstretched"
        return f"{super().model(geometry)}; {springs}"

    def warm_up(self, task: Task[IndenterGeometry]) -> None:
        """Compile the springs of a profile."""
        line = Springs(self.profile, self.modulus, 4, edges=self.options.edges)
        roll(line, self.friction, Load(*normal_load(task)), 0.1)

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        """Roll at all creeps at once."""
        line = Springs(self.profile, self.modulus, task.resolution, edges=self.options.edges)
        along, across = np.array(pairs(self.rolling, task.loads.values)).T
        answer = roll(line, self.friction, Load(*normal_load(task)), along, across)
        steady = {
            "penetration": answer.penetration,
            "force": answer.force,
            "equivalent_radius": answer.contact_radius,
            "contact_length": 2 * answer.contact_radius,
        }
        limit = self.friction.coefficient * answer.force
        solution = Solution.empty(task, unknowns=2 * task.resolution)
        for step, value in enumerate(task.loads.values):
            forces = float(answer.tangential_force[step]), float(answer.lateral_force[step])
            stick = {"stick_area": np.pi * (answer.stick_length[step] / 2) ** 2}
            rolled = quantities(self.rolling, float(value), forces, limit)
            friction = {"friction_coefficient": forces[0] / answer.force}
            solution.put((0, step), steady | stick | rolled | friction)
        spacing = answer.contact_radius / task.resolution
        solution.fields = line_picture(
            self.profile, answer.penetration, answer.contact_radius, spacing
        )
        return solution
