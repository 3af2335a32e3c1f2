"""Films on the springs of the reduced model."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from comparisons.geometry.prepare import IndenterGeometry
from comparisons.methods.lubrication.films import PHYSICS, LubricatedBall
from comparisons.methods.solver import Refused, Solver
from comparisons.scene.scene import Scene
from comparisons.tasks.steps import Row, Step
from comparisons.tasks.task import Task
from reduced.film.reynolds import Ball, approach, entrain

WIDTHS = {
    "local": "P = sqrt Q: the film's pressure is the stress of the local rule (19.37)",
    "hertz": "P = Q: springs share the film's pressure over pi a/2",
    "rigid": "P = Q: springs share the film's pressure over 4 sqrt(R h0) when squeezed, "
    "5.33 sqrt(R h0) when entrained, with which a rigid ball is right",
}


class ReducedFilm(Solver[IndenterGeometry]):
    """Reynolds' equation along the line, with mass-conserving cavitation, over springs."""

    name = "reduced"
    physics = PHYSICS
    options_read = frozenset({"film"})

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.contact = LubricatedBall.of(scene)
        if self.contact.table.meniscus is not None:
            raise Refused("the line is flooded")
        self.waves = self.contact.waves
        self.film = scene.methods.reduced.film
        self.note = f"the width of the film on a line is free; here {WIDTHS[self.film]}"

    def resolutions(self, geometry: IndenterGeometry) -> tuple[int, ...]:
        """Cells of the line per Hertz radius and reach of a rigid film together."""
        return 64, 128, 256

    def rows(self, task: Task) -> Iterator[Row]:
        """Yield the films."""
        yield Row(partial(self._films, task))

    def _films(self, task: Task, values: np.ndarray) -> Iterator[Step]:
        solve = entrain if self.contact.squeeze_speed is None else approach
        for value in values:
            load, speed = self.contact.step(task, float(value))
            viscosity, modulus = self.contact.table.viscosity, self.scene.effective_modulus
            ball = Ball(self.contact.radius, modulus, viscosity, load, self.film, self._heights)
            film = solve(ball, speed, task.resolution)
            yield Step(
                self.contact.quantities(film), violation=film.error, unknowns=film.x.size + 1
            )

    @property
    def _heights(self) -> Callable[[np.ndarray], np.ndarray] | None:
        """The section y = 0 of a rough ball."""
        waves = self.waves
        if waves is None:
            return None
        return lambda x: waves.at(x[:, None], np.zeros((1, 1)))[:, 0]
