"""Films on the half-space below a grid: Reynolds' equation with mass-conserving cavitation."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from comparisons.geometry.prepare import IndenterGeometry
from comparisons.methods.lubrication.films import PHYSICS, LubricatedBall
from comparisons.methods.solver import Refused, Solver
from comparisons.scene.scene import Scene
from comparisons.tasks.steps import Row, Step
from comparisons.tasks.task import Task
from reference.lubrication.point import FEWEST_PER_WAVE, Ball, PointFilm, approach, entrain

# Cells per l: 2 GB of factors.
_MOST = 128


class GridFilm(Solver[IndenterGeometry]):
    """Newton's method on pressure, vapour and the separation, all at once."""

    name = "bem_fft"
    physics = PHYSICS

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.contact = LubricatedBall.of(scene)
        waves = self.contact.waves
        self.per_wave = 0
        if waves is not None:
            waves_of_length = self.contact.longest(scene) / waves.shortest
            self.per_wave = int(np.ceil(FEWEST_PER_WAVE * waves_of_length))
        if 2 * self.per_wave > _MOST:
            raise Refused(
                f"waves so short need {2 * self.per_wave} cells, and {_MOST} are the most"
            )
        self.note = "resolution: cells per Hertz radius and reach of a rigid film together"

    def resolutions(self, geometry: IndenterGeometry) -> tuple[int, ...]:
        """Films are of second order, known to a few percent on 8 cells per l."""
        finest = int(np.clip(24 * np.sqrt(0.01 / self.scene.compare.tolerance), 24, 64))
        # the coarsest of the three has the fewest cells per wave that are solved
        finest = max(finest, 2 * self.per_wave + 3)
        finest -= finest % 4
        return finest // 2, 3 * finest // 4, finest

    def model(self, geometry: IndenterGeometry) -> str:
        """Name the domain."""
        return (
            "the film over equal cells where the half-space is bent, over wider and wider ones as "
            "far as the ball reaches; Elrod-Adams cavitation"
        )

    def memory(self, task: Task) -> float:
        """Bytes of the factorisation and the directions of GMRES."""
        return 8.0 * 24 * task.resolution**2 * 600

    def warm_up(self, task: Task) -> None:
        """Solve a rigid ball on a handful of cells."""
        entrain(Ball(0.01, 1e6, 1.0, 0.2), 1e-2, 8)

    def rows(self, task: Task) -> Iterator[Row]:
        """Yield the films."""
        yield Row(partial(self._films, task))

    def _films(self, task: Task, values: np.ndarray) -> Iterator[Step]:
        table, modulus = self.contact.table, self.scene.effective_modulus
        meniscus = np.inf if table.meniscus is None else table.meniscus
        solve = entrain if self.contact.squeeze_speed is None else approach
        for value in values:
            load, speed = self.contact.step(task, float(value))
            ball = Ball(
                self.contact.radius, modulus, table.viscosity, load, meniscus, self.contact.waves
            )
            film = solve(ball, speed, task.resolution)
            yield Step(
                self.contact.quantities(film),
                iterations=film.rounds,
                violation=film.error,
                unknowns=film.pressure.size + 1,
                pressure=partial(_fields, film),
                fields=partial(_fields, film),
            )


def _fields(film: PointFilm) -> dict[str, np.ndarray]:
    """Return the film where it matters: as far out as a third more than bent."""
    rows, columns = film.core
    x, y = np.meshgrid(film.x[rows], film.y[columns], indexing="ij")
    return {
        "penetration": np.array(film.penetration),
        "pressure_x": x.ravel(),
        "pressure_y": y.ravel(),
        "pressure": film.pressure[film.core].ravel(),
        "pressure_weight": film.area[film.core].ravel(),
        "pressure_shape": np.array(x.shape),
        "film": film.thickness[film.core].ravel(),
        "vapour": film.vapour[film.core].ravel(),
    }
