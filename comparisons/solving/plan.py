"""What a plan is: all solves of a scene, how many of each, what was left out, what is kept."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np

from comparisons.facts.methods import GRID, METHODS, MODEL, growth
from comparisons.geometry.plausibility import doubtful
from comparisons.geometry.prepare import Geometry, RoughGeometry
from comparisons.methods.normal.reduced_lines import whole_spectrum
from comparisons.methods.registry import solver_for
from comparisons.methods.solver import Refusal, Solver
from comparisons.scene.loading import AbsoluteLoads
from comparisons.scene.scene import Scene
from comparisons.scene.surface import SelfAffine
from comparisons.tasks.task import Task


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


@dataclass(frozen=True, kw_only=True)
class PlanRecord:
    """What a plan says: kept with the results."""

    methods: tuple[MethodPlan, ...] = ()
    left_out: tuple[tuple[str, str], ...] = ()  # effects that are not modelled, with the reason
    notes: tuple[str, ...] = ()
    switched_on: tuple[tuple[str, str], ...] = ()  # physics, with its model
    measured: Measured | None = None
    roughness: Roughness | None = None  # of a rough surface, where its results are recorded


Effort = Literal["quick", "full"]
QUICK_REALISATIONS = 10
# Surfaces of methods that are compared with the leading grid surface by surface.
PAIRED_REALISATIONS = 4
# Surfaces on each grid, coarse to fine, that a plan begins with: their scatter says how many are
# needed (`judging.refinement`). Of large surfaces, on which a solve costs more than DEAR of those
# on 64 x 64 points, as few as tell a scatter.
PILOTS, FEW_PILOTS = (50, 8, 4, 3), (8, 4, 3)
DEAR = 20.0


@dataclass(frozen=True, kw_only=True)
class Plan(PlanRecord):
    """All solves of one scene, and what was left out."""

    scene: Scene
    geometry: Geometry
    loads: AbsoluteLoads
    realisations: int

    @cached_property
    def tasks(self) -> tuple[Task, ...]:
        """The independent solves, cheap methods first."""
        scene = self.scene
        pictured = "pressure" in scene.compare.quantities or not scene.physics
        return tuple(
            task_of(
                self,
                planned.method,
                resolution,
                block,
                # on every grid: which one is the finest changes as grids are added, keys must not
                with_body=pictured and block[0] == 0,
            )
            for planned in self.methods
            for resolution in planned.resolutions
            for block in self.blocks(planned.method, resolution)
        )

    @property
    def settings(self) -> dict[tuple[str, int], list[Task]]:
        """The tasks of each method at each resolution: its blocks of realisations."""
        settings: dict[tuple[str, int], list[Task]] = {}
        for task in self.tasks:
            settings.setdefault((task.method, task.resolution), []).append(task)
        return settings

    @property
    def compared(self) -> tuple[str, ...]:
        """The quantities that are compared: all that are asked for, but what is prescribed.

        Force and penetration can each be compared at the other; along a path, in time or over
        speeds the prescribed load is the same for all.
        """
        quantities = self.scene.compare.quantities
        return tuple(
            q for q in quantities if self.loads.compares_itself or q not in self.loads.columns
        )

    def blocks(self, method: str, resolution: int = 1) -> list[tuple[int, ...]]:
        """Return the realisations of a method in blocks of one task each, smaller on fine grids."""
        count, size = self.number(method, resolution), self.block(method, resolution)
        return [tuple(range(k, min(k + size, count))) for k in range(0, count, size)]

    def number(self, method: str, resolution: int) -> int:
        """Return how many surfaces or lines a method solves at a resolution."""
        for planned in self.methods:
            if planned.method == method and planned.numbers and resolution in planned.resolutions:
                return planned.numbers[planned.resolutions.index(resolution)]
        return realisation_count(self.scene, method, self.realisations)

    @property
    def doubts(self) -> list[str]:
        """The notes that question the scene itself: its units, its slopes."""
        return doubtful(self.notes)

    def block(self, method: str, resolution: int) -> int:
        """Return how many surfaces or lines are one task: the same whatever their number."""
        solver = solver_for(method, self.scene)
        return 1 if isinstance(solver, Refusal) else solver.block(resolution)

    @cached_property
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
        # where contacts are few, lines agree by chance (`results.scene_record.chance`); without
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


def pilots(solver: Solver[Any], resolutions: tuple[int, ...]) -> tuple[int, ...]:
    """Return how many surfaces or lines are solved before their scatter is known, whole tasks.

    Empty where the number is not a matter of scatter: single contacts, single surfaces, physics
    with ensembles of their own, methods that are compared with the leading grid in pairs.
    """
    scene = solver.scene
    if scene.surface is None or scene.physics or solver.name not in (GRID, MODEL):
        return ()
    blocks = [solver.block(n) for n in resolutions]
    if solver.name == MODEL:
        return tuple(blocks)
    if not scene.random or scene.realisations == 1:
        return ()
    random = [face for face in scene.surfaces if isinstance(face, SelfAffine)]
    dear = surface_cost(GRID, max(random[0].points)) > DEAR
    first = FEW_PILOTS if dear else PILOTS
    numbers = (*first, *(first[-1:] * len(blocks)))
    whole = (-(-n // block) * block for n, block in zip(numbers, blocks, strict=False))
    return tuple(min(n, scene.realisations) for n in whole)


def surface_cost(method: str, resolution: int) -> float:
    """Return the cost of a surface, in solves of 64 x 64 points; measured once (`facts`).

    Times measured in a run would give other numbers of surfaces, and other digits, in the next.
    """
    return float(growth(method) ** np.log2(resolution / 64))


MOST_RINGS = 100


def roughness_of(geometry: RoughGeometry) -> Roughness:
    """Return spectrum and statistics of a surface.

    The isotropic spectrum C2D(q) is the mean over circles (19.23), thinned to equal steps in log q.
    Nayak's parameter is m0 m4/m2^2 = (3/2) <h^2> <(lap h)^2>/<|grad h|^2>^2, at least 1.5. Skewness
    and kurtosis are of the heights of a map; a Gaussian surface has 0 and 3. The spectrum of a free
    map is taken under a Hann window, because its opposite sides do not match.
    """
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
