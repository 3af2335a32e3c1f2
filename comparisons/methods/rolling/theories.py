"""FASTSIM and Kalker's linear theory: what rolling is computed with where time is short."""

from __future__ import annotations

import numpy as np

from comparisons.geometry.prepare import IndenterGeometry
from comparisons.methods.friction.path import normal_load
from comparisons.methods.rolling.creeps import PHYSICS, quantities, tables_of
from comparisons.methods.solver import Refused, Solver, needed
from comparisons.scene.scene import Scene
from comparisons.tasks.solution import Solution
from comparisons.tasks.task import Task
from reference.closed_form import ClosedForm, ellipsoid
from reference.rolling.creep_theories import EllipticContact, Rolled, fastsim, kalker, linear

EXACT = (1,)


class Theory(Solver[IndenterGeometry]):
    """A theory of elliptic contacts; normal and tangential loads do not act on each other."""

    physics = PHYSICS

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.rolling, friction = tables_of(scene)
        self.friction = friction.coefficient
        self.form = _hertz(scene)
        half_x, half_y = self.form.semi_axes(1.0)
        try:
            kalker(float(half_x / half_y), scene.poisson_ratio)
        except ValueError as error:
            raise Refused(f"Kalker's table: {error}") from error

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        """Roll at every creep."""
        control, load = normal_load(task)
        depth = load if control == "penetration" else float(self.form.penetration(load))
        force, area = float(self.form.force(depth)), float(self.form.contact_area(depth))
        a, b = (float(axis) for axis in self.form.semi_axes(depth))
        nu = self.scene.poisson_ratio
        contact = EllipticContact((a, b), self.scene.shear_modulus, nu, self.friction * force)
        solution = Solution.empty(task, unknowns=4 * task.resolution**2)
        for step, value in enumerate(task.loads.values):
            creep = *self.rolling.both(float(value)), self.rolling.spin
            rolled = self.rolled(contact, creep, task.resolution)
            forces = rolled.tangential_force, rolled.lateral_force
            solution.put(
                (0, step),
                quantities(self.rolling, float(value), forces, contact.limit)
                | {
                    "friction_coefficient": forces[0] / force,
                    "stick_area": rolled.stick_area,
                    "penetration": depth,
                    "force": force,
                    "contact_area": area,
                },
            )
        return solution

    def rolled(
        self, contact: EllipticContact, creep: tuple[float, float, float], resolution: int
    ) -> Rolled:
        """Return the forces at a creep: along, across, and spin."""
        raise NotImplementedError


class Fastsim(Theory):
    """FASTSIM (Kalker 1982): strips of independent springs under a parabolic bound."""

    name = "fastsim"

    def resolutions(self, geometry: IndenterGeometry) -> tuple[int, ...]:
        """Return strips across half of the contact, as many steps along half a strip."""
        finest = int(np.clip(40 * np.sqrt(0.01 / self.scene.compare.tolerance), 40, 400))
        return finest // 4, finest // 2, finest

    def warm_up(self, task: Task[IndenterGeometry]) -> None:
        """Compile the strips."""
        fastsim(EllipticContact((1.0, 1.0), 1.0, 0.25, 1.0), 0.1, cells=2)

    def rolled(
        self, contact: EllipticContact, creep: tuple[float, float, float], resolution: int
    ) -> Rolled:
        """Follow the strips."""
        return fastsim(contact, *creep, cells=resolution)


class Kalker(Theory):
    """Kalker's linear theory (1967): all of the contact sticks, whatever the friction."""

    name = "kalker"

    def resolutions(self, geometry: IndenterGeometry) -> tuple[int, ...]:
        """Return one: a formula."""
        return EXACT

    def rolled(
        self, contact: EllipticContact, creep: tuple[float, float, float], resolution: int
    ) -> Rolled:
        """Multiply by the coefficients."""
        return linear(contact, *creep)


def _hertz(scene: Scene) -> ClosedForm:
    """Return Hertz's contact of the indenter, or refuse."""
    reason = "for elliptic contacts of paraboloids and ellipsoids only"
    indenter = needed(scene.indenter, reason)
    keys = {"paraboloid": ("radius", "radius"), "ellipsoid": ("radius_x", "radius_y")}
    if indenter.shape not in keys:
        raise Refused(reason)
    radius_x, radius_y = (float(indenter.parameters[key]) for key in keys[indenter.shape])
    return ellipsoid(radius_x, radius_y, scene.effective_modulus)
