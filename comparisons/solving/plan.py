"""A plan: all solves of a scene, what was left out, what to keep in mind, and its record."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from functools import cached_property
from math import pi
from statistics import median
from typing import Literal

import numpy as np

from comparisons.facts.methods import METHODS
from comparisons.geometry.prepare import Geometry, RoughGeometry
from comparisons.methods.solver import Refusal
from comparisons.reasons import CHECK, STRAINED, THICKENED
from comparisons.scene.loading import AbsoluteLoads
from comparisons.scene.scene import Scene
from comparisons.tasks.task import Task

Effort = Literal["quick", "full"]
QUICK_REALISATIONS = 10
# Surfaces of methods that are compared with the leading grid surface by surface.
PAIRED_REALISATIONS = 4
MOST_RINGS = 100  # of a spectrum


@dataclass(frozen=True)
class MethodPlan:
    """The plan of one method for a scene, or the reason for a refusal."""

    method: str
    supported: bool
    reason: str
    resolutions: tuple[int, ...] = ()
    modelled: str = ""
    # Surfaces or lines at each resolution, not increasing; empty: `Plan.realisations`.
    numbers: tuple[int, ...] = ()
    title: str = ""  # what the method is called on this scene; "": as everywhere
    dimension: int | None = None  # of a method from outside

    def finer(self, resolution: int) -> MethodPlan:
        """Return it with one more resolution, on as many surfaces as the finest one so far."""
        numbers = (*self.numbers, self.numbers[-1]) if self.numbers else ()
        return replace(self, resolutions=(*self.resolutions, resolution), numbers=numbers)


@dataclass(frozen=True)
class Measured:
    """A measured curve in SI units, the modulus that the scene states, and whether zero moves."""

    penetration: tuple[float, ...]
    force: tuple[float, ...]
    modulus: float
    fit_zero: bool

    def __post_init__(self) -> None:
        if len(self.penetration) != len(self.force) or not self.modulus > 0:
            raise ValueError("expected as many forces as penetrations, and a positive modulus")

    @property
    def curve(self) -> tuple[np.ndarray, np.ndarray]:
        """Its penetrations and forces."""
        return np.array(self.penetration), np.array(self.force)


@dataclass(frozen=True)
class Roughness:
    """Spectrum C2D(q) and statistics of a surface in SI units; skewness and kurtosis of maps.

    `area` is the apparent one, A0.
    """

    wavenumber: tuple[float, ...]
    density: tuple[float, ...]
    rms_height: float
    rms_slope: float
    rms_curvature: float
    nayak: float
    skewness: float | None = None
    kurtosis: float | None = None
    area: float | None = None

    def __post_init__(self) -> None:
        pairs = len(self.wavenumber) == len(self.density)
        if not pairs or min(*self.wavenumber, *self.density, self.rms_curvature) <= 0:
            raise ValueError("expected pairs of a wavenumber and a density, all positive")

    @property
    def noise_wavelength(self) -> float:
        """The wavelength below which the spectrum is flat, as that of white noise is; else 0.

        Over the last octave that of a surface, q^(-2 - 2H), falls to a quarter or less: flat is
        what falls to no less than half, by the medians of the octave's first and last third.
        """
        rings = list(zip(self.wavenumber, self.density, strict=True))
        octave = [density for q, density in rings if q > self.wavenumber[-1] / 2]
        third = len(octave) // 3
        if third < 2 or median(octave[:third]) > 2 ** (2 / 3) * median(octave[-third:]):
            return 0.0
        floor = median(octave)
        low = [density <= 2 * floor for _, density in rings]
        flat = next((k for k in range(len(rings) - 1) if low[k] and low[k + 1]), 0)
        return 2 * pi / self.wavenumber[flat] if flat else 0.0


@dataclass(frozen=True, kw_only=True)
class PlanRecord:
    """What a plan says: kept with the results."""

    methods: tuple[MethodPlan, ...] = ()
    left_out: tuple[tuple[str, str], ...] = ()  # effects that are not modelled, with the reason
    notes: tuple[str, ...] = ()
    switched_on: tuple[tuple[str, str], ...] = ()  # physics, with its model
    measured: Measured | None = None
    roughness: Roughness | None = None  # of a rough surface, where its results are recorded

    @property
    def doubts(self) -> list[str]:
        """The notes that question the scene (units, slopes, strains, oil): to be seen first."""
        return [note for note in self.notes if note.startswith((CHECK, STRAINED, THICKENED))]


@dataclass(frozen=True, kw_only=True)
class Plan(PlanRecord):
    """All solves of one scene, and what was left out."""

    scene: Scene
    geometry: Geometry
    loads: AbsoluteLoads
    realisations: int

    @cached_property
    def settings(self) -> dict[tuple[str, int], list[Task]]:
        """The tasks of each method at each resolution, cheap methods first."""
        scene = self.scene
        pictured = "pressure" in scene.compare.quantities or not scene.physics
        pictured |= scene.rough and scene.physics == ("plasticity",)
        # The key of a coarse grid says so, too: which grid is the finest changes as grids
        # are added, keys must not. `solve_task` leaves the body out on coarse grids.
        return {
            (planned.method, n): self.tasks_at(planned.method, n, with_body=pictured)
            for planned in self.methods
            for n in planned.resolutions
        }

    @property
    def tasks(self) -> tuple[Task, ...]:
        """The independent solves."""
        return tuple(task for tasks in self.settings.values() for task in tasks)

    def tasks_at(self, method: str, resolution: int, *, with_body: bool = False) -> list[Task]:
        """Return the tasks of a method at a resolution, a block of realisations each.

        The first has the body.
        """
        count = self.number(method, resolution)
        size = self.block(method, resolution) if count > 1 else 1
        return [
            task_of(
                *(self, method, resolution, tuple(range(k, min(k + size, count)))),
                with_body=with_body and k == 0,
            )
            for k in range(0, count, size)
        ]

    @property
    def compared(self) -> tuple[str, ...]:
        """The quantities that are compared: all that are asked for, but what is prescribed.

        Of several loads force and penetration can each be compared at the other. Asked for alone it
        stays, without a result.
        """
        quantities = self.scene.compare.quantities
        if self.loads.compares_itself:
            return quantities
        held = () if self.loads.normal is None else (self.loads.normal.control,)
        prescribed = {*self.loads.columns, *held}
        return tuple(q for q in quantities if q not in prescribed) or quantities

    def number(self, method: str, resolution: int) -> int:
        """Return how many surfaces or lines a method solves at a resolution."""
        for planned in self.methods:
            if planned.method == method and planned.numbers and resolution in planned.resolutions:
                return planned.numbers[planned.resolutions.index(resolution)]
        return realisation_count(self.scene, method, self.realisations)

    def block(self, method: str, resolution: int) -> int:
        """Return how many surfaces or lines are one task: the same whatever their number."""
        from comparisons.methods.registry import solver_for  # records are read without solvers

        solver = solver_for(method, self.scene)
        return 1 if isinstance(solver, Refusal) else solver.block(resolution)

    @property
    def record(self) -> PlanRecord:
        """The plan as it is kept with the results."""
        said = {part.name: getattr(self, part.name) for part in fields(PlanRecord)}
        if isinstance(self.geometry, RoughGeometry):
            said["roughness"] = roughness_of(self.geometry)
        return PlanRecord(**said)


def task_of(
    plan: Plan,
    method: str,
    resolution: int,
    realisations: tuple[int, ...] = (0,),
    *,
    with_body: bool = False,
) -> Task:
    """Return the task of one method at one resolution."""
    scene, quantities = plan.scene, plan.scene.compare.quantities
    if scene.rough and not scene.physics:
        # where contacts are few, lines agree by chance (`results.recording.chance`); without
        # lines, too: runs of one method each have the answers of a run of both
        quantities = (*quantities, "contact_count")
    return Task(
        scene=scene,
        geometry=plan.geometry,
        loads=plan.loads,
        method=method,
        resolution=resolution,
        quantities=quantities,
        realisations=realisations,
        with_body=with_body,
    )


def realisation_count(scene: Scene, method: str, limit: int) -> int:
    """Return how many realisations a method solves: on a measured map only lines are drawn."""
    if scene.surface is None or METHODS[method].dimension == 2:
        return 1
    if not scene.random and METHODS[method].dimension == 3:
        return 1
    # What is compared surface by surface needs few of them: differences scatter little.
    return min(scene.realisations, limit if scene.physics else PAIRED_REALISATIONS)


def surface_cost(method: str, resolution: int) -> float:
    """Return the cost of a surface, in solves of 64 x 64 points; measured once (`facts`).

    Times measured in a run would give other numbers of surfaces, and other digits, in the next.
    """
    return float(METHODS[method].growth ** np.log2(resolution / 64))


def roughness_of(geometry: RoughGeometry) -> Roughness:
    """Return spectrum and statistics of a surface.

    The isotropic spectrum C2D(q) is the mean over circles (19.23), thinned to equal steps in log q,
    of a free map under a Hann window. Nayak's parameter is m0 m4/m2^2 = (3/2) <h^2> <(lap
    h)^2>/<|grad h|^2>^2, at least 1.5. Skewness and kurtosis are of a map; a Gaussian surface has 0
    and 3.
    """
    from comparisons.methods.normal.reduced import whole_spectrum

    spectrum = whole_spectrum(geometry)
    rings = spectrum.radial_average()
    ends = np.unique(np.geomspace(1, len(rings.count) + 1, MOST_RINGS).astype(int)) - 1
    weight = np.add.reduceat(rings.count, ends[:-1])
    wavenumber, density = (
        np.add.reduceat(values * rings.count, ends[:-1]) / np.maximum(weight, 0.5)
        for values in (rings.wavenumber, rings.density)
    )
    held = density > 0
    height, slope, curvature = spectrum.rms_height, spectrum.rms_slope, spectrum.rms_curvature
    heights = geometry.measured
    scaled = None if heights is None else (heights - heights.mean()) / heights.std()
    return Roughness(
        tuple(wavenumber[held].tolist()),
        tuple(density[held].tolist()),
        float(geometry.rms_height),
        float(geometry.rms_slope),
        float(curvature),
        float(1.5 * (height * curvature / slope**2) ** 2),
        None if scaled is None else float(np.mean(scaled**3)),
        None if scaled is None else float(np.mean(scaled**4)),
        geometry.area,
    )
