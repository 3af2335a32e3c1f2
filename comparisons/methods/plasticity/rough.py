"""Rough surfaces that yield: a grid with its pressure capped, lines with capped springs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from comparisons.geometry.prepare import Geometry, RoughGeometry
from comparisons.methods.normal.bem_fft import BemFft
from comparisons.methods.normal.grid import Grid, block_means, blocks_of, contact_step
from comparisons.methods.normal.reduced_lines import LineSolver, line_curves, line_fields
from comparisons.methods.plasticity.indentation import PHYSICS
from comparisons.methods.solver import Refused, needed
from comparisons.scene.physics.tables.plasticity import HARDNESS
from comparisons.scene.scene import Scene
from comparisons.tasks.shown_loads import Fields
from comparisons.tasks.solution import Solution, Stopwatch
from comparisons.tasks.steps import Step
from comparisons.tasks.task import Task
from reduced.loads import LoadPath
from reduced.plasticity import Yielding, walk
from reference import loads as reference_loads
from reference.contact.body import ElasticBody
from reference.halfspace.areas import located_area
from reference.plastic import capped


class GridPlasticity(BemFft):
    """The half-space below a rough surface, elastic up to a hardness, perfectly plastic there."""

    physics = PHYSICS

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.plasticity = needed(scene.plasticity, "no [plasticity]")
        if not scene.rough:
            raise Refused(
                "a pressure capped at a hardness is a model of rough surfaces; below one indenter "
                "the stress in the body says where it yields"
            )
        if self.plasticity.hardens:
            raise Refused("caps its pressure at one hardness: without hardening")
        self.beside = f"pressure capped at {HARDNESS} Y"

    def resolutions(self, geometry: Geometry) -> tuple[int, ...]:
        """Return two grids: what yields is searched for at every load."""
        return super().resolutions(geometry)[:2]

    def _steps(
        self, task: Task, operator: ElasticBody, grid: Grid, loads: np.ndarray
    ) -> Iterator[Step]:
        hardness, tolerance = self.plasticity.hardness, self.tolerance
        path = reference_loads.LoadPath(task.loads.control, loads)
        for dent in capped.along(operator, grid.gap, hardness, path, tolerance=tolerance):
            # first, as the step of the elastic contact may forget the displacement
            area = located_area(dent.contact, hardness, patch=True)
            elastic = contact_step(task, operator, dent.contact, grid)
            yielded = {
                "contact_area": area,
                "residual_depth": dent.residual_depth,
                "plastic_share": dent.plastic_share,
            }
            yield replace(
                elastic,
                quantities={**elastic.quantities, **yielded},
                fields=partial(_fields, elastic, dent),
            )


def _fields(elastic: Step, dent: capped.Dent) -> Fields:
    """Return the fields of the contact, and the depth to which the surface stays dented."""
    assert elastic.fields is not None
    fields, sunk = dict(elastic.fields()), dent.sunk
    dented = block_means(sunk, blocks_of(sunk.shape))
    if "gap" in fields:
        fields["gap"] = fields["gap"] + dented.ravel()
    return fields | {"dent": dented}


class LinePlasticity(LineSolver):
    """Rough lines whose springs are capped by the local stress rule, with memory."""

    name = "reduced"
    physics = PHYSICS

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        options = scene.methods.reduced
        plasticity = needed(scene.plasticity, "no [plasticity]")
        if plasticity.model == "zunker_kamrin":
            raise Refused("Zunker & Kamrin's springs are for a ball")
        local = options.stress == "local" or plasticity.model == "elastic_root"
        if local and options.stress == "one_radius":
            raise Refused("with the elastic part of deflections, springs need their own curvature")
        self.springs = Yielding(
            self.modulus,
            plasticity.hardness,
            plasticity.model,
            "own_curvature" if local else "one_radius",
            options.edges,
        )
        self.beside = " that stay elastic"
        if plasticity.model != "none":
            whose = "their own curvature" if local else "their contact"
            part = "the elastic part of " if plasticity.model == "elastic_root" else ""
            hardening = "; hardening is left out" if plasticity.hardens else ""
            self.beside = (
                f", capped where the stress (19.37) by {part}their deflection and the radius of "
                f"{whose} reaches {HARDNESS} Y{hardening}"
            )

    def block(self, resolution: int) -> int:
        """Return how many lines are one task: they are led one by one."""
        return min(25, super().block(resolution))

    def solve(self, task: Task[RoughGeometry]) -> Solution:
        with Stopwatch() as setup:
            lines = self.draw(task)
        yielded = walk(
            lines.rough, self.springs, LoadPath(task.loads.control, lines.loads(task.loads))
        )
        curves = line_curves(yielded.contact, lines) | {
            "residual_depth": yielded.residual_depth,
            "plastic_share": yielded.plastic_share,
        }
        solution = Solution.of(task, curves, unknowns=lines.points, setup_seconds=setup.seconds)
        solution.fields = line_fields(lines, float(yielded.contact.penetration[0, -1]))
        return solution
