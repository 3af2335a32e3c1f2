"""Films in closed form and by Hamrock & Dowson's fit, each where it is meant to hold."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from comparisons.formatting import number
from comparisons.geometry.prepare import IndenterGeometry
from comparisons.methods.lubrication.films import PHYSICS, LubricatedBall
from comparisons.methods.solver import Refused, Solver
from comparisons.scene.physics.absolute_loads import loads_of
from comparisons.scene.scene import Scene
from comparisons.tasks.solution import Solution
from comparisons.tasks.task import Task
from reference.lubrication.formulas import LOADS, SPEEDS, SoftFit, squeezed_film

EXACT = (1,)


class Formula(Solver[IndenterGeometry]):
    """A formula for the film of a ball."""

    physics = PHYSICS

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.contact = LubricatedBall.of(scene)
        if self.contact.table.meniscus is not None:
            raise Refused("the formula is for a flooded inlet")
        if self.contact.table.rough:
            raise Refused("the formula is for smooth balls")

    def resolutions(self, geometry: IndenterGeometry) -> tuple[int, ...]:
        """Return one: a formula."""
        return EXACT

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        """Evaluate all steps."""
        solution = Solution.empty(task, unknowns=1)
        for step, value in enumerate(task.loads.values):
            load, speed = self.contact.step(task, float(value))
            films = self.films(load, speed)
            solution.put((0, step), films | {"lubrication_force": load, "force": load})
        return solution

    def films(self, load: float, speed: float) -> dict[str, float]:
        """Return central and minimum film."""
        raise NotImplementedError


class ClosedFormFilm(Formula):
    """A rigid ball that is squeezed, h = 6 pi eta R^2 V/F."""

    name = "closed_form"

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        speed = self.contact.squeeze_speed
        if speed is None:
            raise Refused("no closed form of an entrained film that conserves mass")
        load = float(loads_of(scene).values[-1])
        film = squeezed_film(self.contact.radius, self.contact.table.viscosity, speed, load)
        # the load over a reach sqrt(2 R h) bends the half-space by F/(pi E* r)
        bent = load / (np.pi * scene.effective_modulus * np.sqrt(2 * self.contact.radius * film))
        if bent > 0.1 * scene.compare.tolerance * film:
            raise Refused("the film bends the half-space, and the formula is of rigid bodies")

    def films(self, load: float, speed: float) -> dict[str, float]:
        """Return the film of a rigid ball."""
        film = squeezed_film(self.contact.radius, self.contact.table.viscosity, speed, load)
        return {"film_central": film, "film_minimum": film}


class HamrockDowson(Formula):
    """Hamrock & Dowson's fit (1978) of films of soft, isoviscous balls."""

    name = "hamrock_dowson"
    title: ClassVar[str] = "Hamrock-Dowson"
    dimension = 1

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        if self.contact.squeeze_speed is not None:
            raise Refused("a fit of entrained films")
        loads = loads_of(scene)
        assert loads.normal is not None
        force = float(loads.normal.values[-1])
        if not all(self._fit(force).covers(speed) for speed in loads.values):
            raise Refused(
                f"made for ηU/(2E*R) from {' to '.join(number(end, 1) for end in SPEEDS)} and "
                f"F/(2E*R²) from {' to '.join(number(end, 1) for end in LOADS)}"
            )

    def _fit(self, load: float) -> SoftFit:
        modulus, contact = self.scene.effective_modulus, self.contact
        return SoftFit(contact.radius, modulus, contact.table.viscosity, load)

    def films(self, load: float, speed: float) -> dict[str, float]:
        """Return the fitted films."""
        fit = self._fit(load)
        return {"film_central": fit.central(speed), "film_minimum": fit.minimum(speed)}
