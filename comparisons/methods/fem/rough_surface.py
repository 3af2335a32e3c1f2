"""The method `fem` on grids: elements below every cell, wave by wave.

It takes rough surfaces, and indenters on bodies that depend on depth.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from comparisons.facts.methods import REPEATING_ELEMENTS
from comparisons.geometry.elastic_body import elastic_body
from comparisons.geometry.prepare import Geometry, IndenterGeometry, RoughGeometry
from comparisons.methods.fem.indenter import enforcement_of, options_problem
from comparisons.methods.fem.stress_below import below
from comparisons.methods.normal.grid import (
    Grid,
    GridSolver,
    Sweep,
    as_far_as_possible,
    cells,
    indenter_resolutions,
    rough_resolutions,
)
from comparisons.methods.solver import Refused
from comparisons.scene.scene import Scene
from comparisons.tasks.steps import Step
from comparisons.tasks.task import Task
from reference import fem
from reference.fem import grid_body
from reference.fem.grid_body import LONGEST, FreeBody, PeriodicBody
from reference.halfspace import Contact
from reference.layered.layered_grid import Body
from reference.loads import Load

# Double arrays of one grid that a solve holds at once: those of `bem_fft`, and some kernels.
ARRAYS_PERIODIC, ARRAYS_FREE = 36, 62
# Matrices of the columns that are made at once, and compliances that are kept.
BYTES_OF_COLUMNS = 1.5e8
_IN_PLANE = {
    "linear": "bilinear in the plane, quadratic in depth",
    "splines": "quadratic splines in the plane, quadratic in depth",
    "quadratic": "27 nodes, pressures of a mixed method",
}

_IMPEDANCE = "the impedance of a half-space eight cells down (theory shared with bem_fft)"


class FemRough(GridSolver[FreeBody | PeriodicBody]):
    """A rough surface on finite elements that repeat from cell to cell."""

    name = "fem"
    title = REPEATING_ELEMENTS
    depths = True
    shared_cells = 25 * 256**2

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        unfit = options_problem(scene)
        if unfit:
            raise Refused(unfit)
        self.enforcement = enforcement_of(scene)
        self.element, self.bottom = scene.methods.fem.element, scene.methods.fem.bottom
        table = scene.half_space
        if self.bottom != "clamped" and (table.thickness is not None or table.grading is not None):
            raise Refused(
                "an impedance bottom is a half-space of one modulus, which does not lie below"
            )

    @classmethod
    def takes(cls, scene: Scene) -> bool:
        """Rough surfaces, free and periodic."""
        return scene.rough and scene.methods.fem.mesh == "repeating"

    def resolutions(self, geometry: Geometry) -> tuple[int, ...]:
        """Return the grids of the half-space solver; of an ensemble all but the finest.

        Two grids tell a mesh's error in a mean; the third would cost as much as the whole truth.
        """
        assert isinstance(geometry, RoughGeometry)
        planned = rough_resolutions(geometry)
        ensemble = self.scene.random and self.scene.realisations > 1
        return planned[:2] if ensemble else planned

    def refusal(self, task: Task) -> str:
        """Refuse free patches of needle-shaped cells."""
        geometry = task.geometry
        if not isinstance(geometry, RoughGeometry):
            return super().refusal(task)
        sides = [side / n for side, n in zip(geometry.size, geometry.points, strict=True)]
        if geometry.periodic or max(sides) <= LONGEST * min(sides):
            return super().refusal(task)
        return f"a free patch of cells longer than {LONGEST} times their width"

    def memory(self, task: Task) -> float:
        """Bytes of the arrays and transforms of one grid, and of the columns."""
        arrays = ARRAYS_PERIODIC if _periodic(task.geometry) else ARRAYS_FREE
        stored = 4 * len(task.realisations)
        grid = 8.0 * (arrays + stored) * cells(task.geometry, task.resolution)
        return grid + BYTES_OF_COLUMNS

    def model(self, geometry: Geometry) -> str:
        """Name the mesh and what ends it."""
        mesh = f"hexahedra ({_IN_PLANE[self.element]}) below every cell"
        table = self.scene.half_space
        if table.thickness is not None:
            base = ", down to the rigid base"
        elif self.bottom == "impedance":
            base = f", down to {_IMPEDANCE}"
        else:
            base = ", down to a clamp two periods down"
        if _periodic(geometry):
            return mesh + base
        far = "Boussinesq fields" if table.uniform else "the continuum of the same body"
        shared = base if self.bottom == "impedance" else ""
        return f"{mesh}{shared}, free of their surroundings; further away than some cells {far}"

    def operator(
        self, task: Task, shape: tuple[int, int], spacing: tuple[float, float]
    ) -> FreeBody | PeriodicBody:
        """Return the condensed body below the surface."""
        body: fem.Material | Body = fem.Material(*self.scene.elastic_constants)
        if not self.scene.half_space.uniform:
            body = elastic_body(self.scene)
        kind = PeriodicBody if _periodic(task.geometry) else FreeBody
        return kind(shape, spacing, body, self.element, bottom=self.bottom)

    def step(
        self, task: Task, operator: FreeBody | PeriodicBody, contact: Contact, grid: Grid
    ) -> Step:
        """Return the step with the stress below the contact."""
        step = super().step(task, operator, contact, grid)
        return replace(step, body_fields=partial(below, self.scene, contact, grid))

    def sweep(self, task: Task, operator: FreeBody | PeriodicBody, gap: np.ndarray) -> Sweep:
        """Return the solver of contact, as the scene's options enforce it."""

        def run(loads: np.ndarray) -> Iterator[Contact]:
            load = Load(task.loads.control, loads)
            yield from grid_body.sweep(operator, gap, load, self.enforcement)

        pressed = grid_body.body_under(operator, self.enforcement)
        return as_far_as_possible(task, pressed, gap, run)


class FemDepths(FemRough):
    """An indenter on layers or a graded body of finite elements that repeat from cell to cell."""

    name = "fem"

    @classmethod
    def takes(cls, scene: Scene) -> bool:
        """Indenters where the half-space depends on depth."""
        return not scene.rough and not scene.half_space.uniform

    def resolutions(self, geometry: Geometry) -> tuple[int, ...]:
        """Cells per contact radius: those of `bem_fft`."""
        assert isinstance(geometry, IndenterGeometry)
        return indenter_resolutions(self.scene, geometry)


def _periodic(geometry: Geometry) -> bool:
    return isinstance(geometry, RoughGeometry) and geometry.periodic
