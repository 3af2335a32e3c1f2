"""What a plan is: all solves of a scene, how many of each, and what was left out."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal

from comparisons.geometry.measured_curve import MeasuredCurve
from comparisons.geometry.plausibility import doubtful
from comparisons.geometry.prepare import Geometry, RoughGeometry
from comparisons.methods.registry import solver_for
from comparisons.methods.solver import Refusal
from comparisons.scene.physics.absolute_loads import AbsoluteLoads
from comparisons.scene.scene import Scene
from comparisons.solving.surface_numbers import realisation_count
from comparisons.solving.surface_roughness import roughness_of
from comparisons.tasks.task import Task

Effort = Literal["quick", "full"]


@dataclass(frozen=True)
class MethodPlan:
    """The plan of one method for a scene, or the reason for a refusal.

    Attributes
    ----------
    numbers : tuple of int
        Surfaces or lines at each resolution, not increasing; empty: `Plan.realisations`.
    title : str
        What the method is called on this scene; "": as everywhere.
    """

    method: str
    supported: bool
    reason: str
    resolutions: tuple[int, ...] = ()
    modelled: str = ""
    numbers: tuple[int, ...] = ()
    title: str = ""

    def finer(self, resolution: int) -> MethodPlan:
        """Return it with one more resolution, on as many surfaces as the finest one so far."""
        numbers = (*self.numbers, self.numbers[-1]) if self.numbers else ()
        return replace(self, resolutions=(*self.resolutions, resolution), numbers=numbers)


@dataclass(frozen=True)
class Plan:
    """All solves of one scene, and what was left out."""

    scene: Scene
    geometry: Geometry
    loads: AbsoluteLoads
    methods: tuple[MethodPlan, ...]
    left_out: tuple[tuple[str, str], ...]
    notes: tuple[str, ...]
    realisations: int
    switched_on: tuple[tuple[str, str], ...] = ()
    measured: MeasuredCurve | None = None

    @cached_property
    def tasks(self) -> tuple[Task, ...]:
        """The independent solves, cheap methods first."""
        scene = self.scene
        pictured = "pressure" in scene.compare.quantities or not (scene.rough or scene.physics)
        return tuple(
            task_of(
                self,
                planned.method,
                resolution,
                block,
                with_body=pictured and block[0] == 0 and resolution == planned.resolutions[-1],
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

    def document(self) -> dict[str, Any]:
        """Return the plan as plain data for study.json."""
        data: dict[str, Any] = {}
        if self.measured is not None:
            data["measured"] = {
                "penetration": self.measured.penetration.tolist(),
                "force": self.measured.force.tolist(),
                "modulus": self.scene.effective_modulus,
                "fit_zero": self.scene.compare.fit_zero,
            }
        if self._roughness:
            data["roughness"] = self._roughness
        keys = ("method", "supported", "reason", "resolutions", "modelled", "numbers", "title")
        lists = {"resolutions", "numbers"}
        data["methods"] = [
            {k: list(getattr(m, k)) if k in lists else getattr(m, k) for k in keys}
            for m in self.methods
        ]
        data["switched_on"] = [{"what": effect, "how": model} for effect, model in self.switched_on]
        data["left_out"] = [{"what": effect, "why": reason} for effect, reason in self.left_out]
        data["notes"] = list(self.notes)
        return data

    @cached_property
    def _roughness(self) -> dict[str, Any]:
        return roughness_of(self.geometry) if isinstance(self.geometry, RoughGeometry) else {}


def task_of(
    plan: Plan,
    method: str,
    resolution: int,
    realisations: tuple[int, ...] = (0,),
    *,
    with_body: bool = False,
) -> Task:
    """Return the task of one method at one resolution."""
    return Task(
        scene=plan.scene,
        geometry=plan.geometry,
        loads=plan.loads,
        method=method,
        resolution=resolution,
        quantities=plan.scene.compare.quantities,
        realisations=realisations,
        with_body=with_body,
    )
