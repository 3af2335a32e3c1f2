"""The method `fem` for two elastic bodies: one mesh for each, coupled at the contact.

Two half-spaces in quarter symmetry, with the shape of the indenter as initial gap. The grids do not
match. Neither body has a length scale, so both are scaled to the contact of each load.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from comparisons.geometry.prepare import IndenterGeometry
from comparisons.methods.fem.indenter import FemSolver, contact_stretch, elongated, meshes_both
from comparisons.methods.fem.step import (
    bytes_of_elements,
    bytes_of_elimination,
    contact_step,
    recovered,
    round_area,
)
from comparisons.methods.solver import needed
from comparisons.scene.scene import Scene
from comparisons.tasks.solution import Solution
from comparisons.tasks.steps import NoAnswerError, Row, Step
from comparisons.tasks.task import Task
from reference import fem
from reference.fem.two_bodies import couple
from reference.loads import Load

# Cells of the grid per element along a contact radius: it covers the geometric overlap.
COVERED = 1.45
# Gaps beyond so many penetrations count as these: none of them closes, and the pressure functions
# of quadratic elements have both signs, so that an edge that rises steeply within an element would
# be a negative gap on the flat face beside it.
WIDEST = 2.0


class FemPair(FemSolver[IndenterGeometry]):
    """Two elastic half-spaces in quarter symmetry, pressed together load by load."""

    name = "fem"

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.indenter = needed(scene.indenter, "an indenter and its counter body only")
        self.stretch = contact_stretch(self.indenter)
        self.coupling = scene.methods.fem.coupling
        self.counter_body = needed(scene.counter_body, "no [counter_body]")

    @classmethod
    def takes(cls, scene: Scene) -> bool:
        return meshes_both(scene)

    def resolutions(self, geometry: IndenterGeometry) -> tuple[int, ...]:
        """Elements per contact radius."""
        return (3, 4, 6) if self.scene.compare.tolerance < 0.003 else (2, 3, 4)

    def refusal(self, task: Task[IndenterGeometry]) -> str:
        return elongated(self.stretch)

    def memory(self, task: Task[IndenterGeometry]) -> float:
        """Bytes of the elements of one body, and of the elimination of the other, the larger."""
        first, second = (_mesh(task, cells) for cells in _cells(task))
        return bytes_of_elements(first) + bytes_of_elimination(second)

    def model(self, geometry: IndenterGeometry) -> str:
        coupling = self.coupling.replace("_", "-")
        return (
            f"a quarter of both bodies, on grids that do not match, {coupling} contact between "
            "them, scaled to each load; outside them Boussinesq fields"
        )

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        """Solve as others do; its meshes are not fitted to the contact."""
        solution = super().solve(task)
        return replace(solution, contact="pair") if solution.contact == "single" else solution

    def rows(self, task: Task[IndenterGeometry]) -> Iterator[Row]:
        tables = self.scene.half_space, self.counter_body
        bodies = [
            fem.half_space_body(_mesh(task, cells), fem.Material(*table.elastic_constants))
            for cells, table in zip(_cells(task), tables, strict=True)
        ]
        pair = couple(*bodies, coupling=self.coupling)
        geometry, steps = task.geometry, len(task.loads.values)

        def press(loads: np.ndarray) -> Iterator[Step]:
            for step in range(steps - len(loads), steps):
                size = geometry.contact_radii[step] / geometry.contact_radius
                if not size > 0.0:
                    raise NoAnswerError(geometry.unreached.get(step, "no estimate of its contact"))
                scaled = pair.scaled(size)
                load = Load(task.loads.control, task.loads.values[step])
                deep = WIDEST * geometry.penetrations[step]

                def below(x: np.ndarray, y: np.ndarray, deep: float = deep) -> np.ndarray:
                    return np.minimum(self.indenter.gap(x, y), deep)

                (contact,) = scaled.press(below, load)
                body, area = scaled.combined, contact.contact_area
                if self.indenter.axisymmetric:
                    area = round_area(body, contact)
                gap = self.indenter.gap(*body.points.T)
                # The fields in the half-space of the scene, on which the pressures live.
                inside = partial(recovered, scaled.slave, scaled.forces(contact)[0])
                yield contact_step(task, body, gap, contact, area, body_fields=inside)

        yield Row(press, unknowns=pair.combined.unknowns)


def _cells(task: Task[IndenterGeometry]) -> tuple[int, int]:
    """Return elements per contact radius of both bodies, whose grids do not match."""
    return task.resolution, task.resolution + 1


def _mesh(task: Task[IndenterGeometry], cells: int) -> fem.TensorMesh:
    share = np.linspace(0.0, 1.0, round(COVERED * cells) + 1)
    half_x, half_y = task.geometry.reach
    return fem.TensorMesh(half_x * share, half_y * share, symmetry="quarter", order=2)
