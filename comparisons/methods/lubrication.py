"""Lubricating films: entrained steadily, or squeezed.

Springs, the half-space on a grid, the closed form of a squeezed rigid ball, and Hamrock & Dowson's
fit, each where it is meant to hold.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from comparisons.formatting import number
from comparisons.geometry.prepare import IndenterGeometry
from comparisons.methods import OutOfRangeError, Refused, Scene, Solver, Step, Task, needed
from comparisons.methods.friction import normal_load
from comparisons.scene.loading import loads_of
from comparisons.tasks.shown_loads import grid_pressure
from reduced import film as line_film
from reference.lubrication.formulas import (
    LOADS,
    SPEEDS,
    SoftFit,
    contact_length,
    sphere_film,
    squeezed_film,
)
from reference.lubrication.point import (
    FEWEST_PER_WAVE,
    Ball,
    PointFilm,
    SurfaceWaves,
    approach,
    entrain,
    self_affine,
    waviness,
)

PHYSICS = frozenset({"lubrication"})


class FilmSolver(Solver[IndenterGeometry]):
    """The ball and the oil of a scene, whatever solves the film: what all methods share."""

    physics = PHYSICS

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.table = needed(scene.lubrication, "no [lubrication]")
        reason = "films below round paraboloids only"
        indenter = needed(scene.indenter, reason)
        if indenter.shape != "paraboloid":
            raise Refused(reason)
        self.radius = float(indenter.parameters["radius"])
        self.squeeze_speed = scene.loading.squeeze_speed
        self.modulus = scene.effective_modulus
        # l = a + c of the thickest film and the widest contact
        loads, lengths = loads_of(scene), []
        for value in (loads.values[0], loads.values[-1]):
            if self.squeeze_speed is None:
                normal = needed(loads.normal, "no load")
                load, speed, rigid_film = float(normal.values[-1]), float(value), sphere_film
            else:
                load, speed, rigid_film = float(value), self.squeeze_speed, squeezed_film
            film = rigid_film(self.radius, self.table.viscosity, speed, load)
            try:
                lengths.append(contact_length(self.radius, self.modulus, load, film))
            except ValueError as error:
                raise Refused(str(error)) from error
        self.longest = max(lengths)
        # what makes the ball rough
        wavy, rough = self.table.waviness, self.table.roughness
        self.waves: SurfaceWaves | None = None
        if wavy is not None:
            self.waves = waviness(wavy.amplitude, wavy.wavelength, wavy.crests)
        elif rough is not None:
            self.waves = self_affine(**rough.model_dump())

    def step(self, task: Task, value: float) -> tuple[float, float]:
        """Return load and speed of a step."""
        if self.squeeze_speed is not None:
            return value, self.squeeze_speed
        return normal_load(task)[1], value

    def quantities(self, film: line_film.LineFilm | PointFilm) -> dict[str, float]:
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


WIDTHS = {
    "local": "P = sqrt Q: the film's pressure is the stress of the local rule (19.37)",
    "hertz": "P = Q: springs share the film's pressure over pi a/2",
    "rigid": "P = Q: springs share the film's pressure over 4 sqrt(R h0) when squeezed, "
    "5.33 sqrt(R h0) when entrained, with which a rigid ball is right",
}


class ReducedFilm(FilmSolver):
    """Reynolds' equation along the line, with mass-conserving cavitation, over springs."""

    name = "reduced"
    levels = (64, 128, 256)  # cells of the line per Hertz radius and reach of a rigid film together

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        if self.table.meniscus is not None:
            raise Refused("the line is flooded")
        self.film = scene.methods.reduced.film
        self.note = f"the width of the film on a line is free; here {WIDTHS[self.film]}"

    def steps(self, task: Task, values: np.ndarray) -> Iterator[Step]:
        solve = line_film.entrain if self.squeeze_speed is None else line_film.approach
        section, waves = None, self.waves
        if waves is not None:  # the section y = 0 of a rough ball
            section = lambda x: waves.at(x[:, None], np.zeros((1, 1)))[:, 0]  # noqa: E731
        for value in values:
            load, speed = self.step(task, float(value))
            given = self.radius, self.modulus, self.table.viscosity, load
            film = solve(line_film.Ball(*given, self.film, section), speed, task.resolution)
            yield Step(self.quantities(film), violation=film.error, unknowns=film.x.size + 1)


# Cells per l: 2 GB of factors.
_MOST = 128


class GridFilm(FilmSolver):
    """Newton's method on pressure, vapour and the separation, all at once."""

    name = "bem_fft"

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.per_wave = 0
        if self.waves is not None:
            self.per_wave = int(np.ceil(FEWEST_PER_WAVE * self.longest / self.waves.shortest))
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
        return (
            "the film over equal cells where the half-space is bent, over wider and wider ones as "
            "far as the ball reaches; Elrod-Adams cavitation"
        )

    def memory(self, task: Task) -> float:
        """Bytes of the factorisation and the directions of GMRES."""
        return 8.0 * 24 * task.resolution**2 * 600

    def warm_up(self, task: Task) -> None:
        entrain(Ball(0.01, 1e6, 1.0, 0.2), 1e-2, 8)

    def steps(self, task: Task, values: np.ndarray) -> Iterator[Step]:
        meniscus = np.inf if self.table.meniscus is None else self.table.meniscus
        solve = entrain if self.squeeze_speed is None else approach
        for value in values:
            load, speed = self.step(task, float(value))
            ball = Ball(self.radius, self.modulus, self.table.viscosity, load, meniscus, self.waves)
            film = solve(ball, speed, task.resolution)
            yield Step(
                self.quantities(film),
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
    return grid_pressure(x, y, film.pressure[film.core]) | {
        "penetration": np.array(film.penetration),
        "pressure_weight": film.area[film.core].ravel(),
        "film": film.thickness[film.core].ravel(),
        "vapour": film.vapour[film.core].ravel(),
    }


class Formula(FilmSolver):
    """A formula for the film of a ball."""

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        if self.table.meniscus is not None:
            raise Refused("the formula is for a flooded inlet")
        if self.table.rough:
            raise Refused("the formula is for smooth balls")

    def steps(self, task: Task, values: np.ndarray) -> Iterator[Step]:
        for value in values:
            load, speed = self.step(task, float(value))
            force = {"lubrication_force": load, "force": load}
            yield Step(self.films(load, speed) | force, unknowns=1)

    def films(self, load: float, speed: float) -> dict[str, float]:
        """Return central and minimum film."""
        raise NotImplementedError


class ClosedFormFilm(Formula):
    """A rigid ball that is squeezed, h = 6 pi eta R^2 V/F."""

    name = "closed_form"

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        speed = self.squeeze_speed
        if speed is None:
            raise Refused("no closed form of an entrained film that conserves mass")
        load = float(loads_of(scene).values[-1])
        film = squeezed_film(self.radius, self.table.viscosity, speed, load)
        # the load over a reach sqrt(2 R h) bends the half-space by F/(pi E* r)
        bent = load / (np.pi * self.modulus * np.sqrt(2 * self.radius * film))
        if bent > 0.1 * scene.compare.tolerance * film:
            raise Refused("the film bends the half-space, and the formula is of rigid bodies")

    def films(self, load: float, speed: float) -> dict[str, float]:
        film = squeezed_film(self.radius, self.table.viscosity, speed, load)
        return {"film_central": film, "film_minimum": film}


class HamrockDowson(Formula):
    """Hamrock & Dowson's fit (1978) of films of soft, isoviscous balls."""

    name = "hamrock_dowson"

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        if self.squeeze_speed is not None:
            raise Refused("a fit of entrained films")
        loads = loads_of(scene)
        assert loads.normal is not None
        force = float(loads.normal.values[-1])
        self.fit = SoftFit(self.radius, self.modulus, self.table.viscosity, force)
        self.range = (
            f"made for ηU/(2E*R) from {' to '.join(number(end, 1) for end in SPEEDS)} and "
            f"F/(2E*R²) from {' to '.join(number(end, 1) for end in LOADS)}"
        )
        if not any(self.fit.covers(speed) for speed in loads.values):
            raise Refused(self.range)

    def films(self, load: float, speed: float) -> dict[str, float]:
        fit = self.fit
        if not fit.covers(speed):
            raise OutOfRangeError(self.range)
        return {"film_central": fit.central(speed), "film_minimum": fit.minimum(speed)}
