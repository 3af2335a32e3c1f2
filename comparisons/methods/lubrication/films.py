"""What all methods share that solve films: the oil and the ball of a scene, and its quantities."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from comparisons.methods.friction.path import normal_load
from comparisons.methods.solver import Refused, needed
from comparisons.scene.physics.absolute_loads import loads_of
from comparisons.scene.physics.tables.lubrication import Lubrication
from comparisons.scene.scene import Scene
from comparisons.tasks.task import Task
from reference.lubrication.formulas import contact_length, sphere_film, squeezed_film
from reference.lubrication.point import SurfaceWaves, self_affine, waviness

PHYSICS = frozenset({"lubrication"})


class Film(Protocol):
    """What a film of either model tells."""

    @property
    def film_central(self) -> float:
        """In the middle."""

    @property
    def film_minimum(self) -> float:
        """Where it is thinnest."""

    @property
    def load(self) -> float:
        """What it carries."""

    @property
    def penetration(self) -> float:
        """How much closer the bodies are than at dry first touch."""

    @property
    def shear(self) -> float:
        """Friction at a speed difference equal to the speed."""

    @property
    def drag(self) -> float:
        """Friction of the pressure's flow."""


@dataclass(frozen=True)
class LubricatedBall:
    """The ball and the oil of a scene.

    Attributes
    ----------
    table : Lubrication
    radius : float
    squeeze_speed : float or None
    """

    table: Lubrication
    radius: float
    squeeze_speed: float | None

    @classmethod
    def of(cls, scene: Scene) -> LubricatedBall:
        """Return those of a scene.

        Raises
        ------
        Refused
            If no paraboloid is lubricated, or the ball is none as far as the film reaches.
        """
        table = needed(scene.lubrication, "no [lubrication]")
        reason = "films below round paraboloids only"
        indenter = needed(scene.indenter, reason)
        if indenter.shape != "paraboloid":
            raise Refused(reason)
        ball = cls(table, float(indenter.parameters["radius"]), scene.loading.squeeze_speed)
        ball.longest(scene)
        return ball

    def longest(self, scene: Scene) -> float:
        """Return l = a + c of the thickest film and the widest contact of a scene.

        Raises
        ------
        Refused
            If the ball is no paraboloid as far as that.
        """
        loads, lengths = loads_of(scene), []
        for value in (loads.values[0], loads.values[-1]):
            if self.squeeze_speed is None:
                normal = needed(loads.normal, "no load")
                load, speed, rigid_film = float(normal.values[-1]), float(value), sphere_film
            else:
                load, speed, rigid_film = float(value), self.squeeze_speed, squeezed_film
            film = rigid_film(self.radius, self.table.viscosity, speed, load)
            try:
                lengths.append(contact_length(self.radius, scene.effective_modulus, load, film))
            except ValueError as error:
                raise Refused(str(error)) from error
        return max(lengths)

    @property
    def waves(self) -> SurfaceWaves | None:
        """What makes the ball rough."""
        wavy, rough = self.table.waviness, self.table.roughness
        if wavy is not None:
            return waviness(wavy.amplitude, wavy.wavelength, wavy.crests)
        return None if rough is None else self_affine(**rough.model_dump())

    def step(self, task: Task, value: float) -> tuple[float, float]:
        """Return load and speed of a step."""
        if self.squeeze_speed is not None:
            return value, self.squeeze_speed
        return normal_load(task)[1], value

    def quantities(self, film: Film) -> dict[str, float]:
        """Return the quantities of a step."""
        values = {
            "film_central": film.film_central,
            "film_minimum": film.film_minimum,
            "lubrication_force": film.load,
            "force": film.load,
            "penetration": film.penetration,
        }
        if self.squeeze_speed is None:
            values["friction_force"] = self.table.slide_to_roll * film.shear + film.drag
        return values
