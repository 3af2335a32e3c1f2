"""The method `bem_dense`: the half-space solver of the chapter, (19.2)-(19.8)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from comparisons.geometry.prepare import Geometry, IndenterGeometry, RoughGeometry
from comparisons.methods.normal.grid import (
    GridSolver,
    cells,
    contact_cells,
    make_grid,
    rough_resolutions,
)
from comparisons.methods.normal.grid_punches import RIM, punch_grid
from comparisons.methods.solver import Refused
from comparisons.scene.scene import Scene
from comparisons.tasks.task import Task
from reference.contact.pivot import CELL_LIMIT
from reference.contact.press import Contact, started_from, sweep
from reference.halfspace import FreeOperator
from reference.halfspace.punches import respond_dense
from reference.loads import Load

# Later loads start from the contact of the last one: of the cells that overlap beside the contact,
# this power of one less the ratio of both overlaps (measured on a paraboloid).
_LATER = 3.7
# Of the fields and transforms on the grid.
_BYTES_OF_CELL = 250.0
# Of the matrix of a flat face: a number, and whether it is finite.
_BYTES_OF_ENTRY = 9.0


class BemDense(GridSolver[FreeOperator]):
    """Exact to round-off on its grid, with work that grows as the cube of the contact cells."""

    name = "bem_dense"

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        if scene.surface is not None and scene.surface.periodic:
            raise Refused("the kernel (19.3) is for a free half-space")
        if scene.loading.control == "mean_gap":
            raise Refused("no mean-gap control: use bem_fft or fem, or prescribe the force")
        self.face = respond_dense
        self.most_cells = scene.methods.bem_dense.max_cells

    def resolutions(self, geometry: Geometry) -> tuple[int, ...]:
        """Up to some 1000 contact cells: beyond it the FFT gives the same answer sooner."""
        if isinstance(geometry, RoughGeometry):
            return rough_resolutions(geometry)
        return (5, 10, 20)

    def refusal(self, task: Task) -> str:
        elongated = super().refusal(task)
        if elongated:
            return elongated
        number, limit = contact_cells(task), self.most_cells
        if number <= limit:
            return ""
        return f"about {number:.0f} contact cells, more than {limit}: use bem_fft"

    def memory(self, task: Task) -> float:
        """Bytes of the factor of the contact cells, the largest of all loads, and of the grid."""
        geometry = task.geometry
        if isinstance(geometry, IndenterGeometry) and geometry.indenter.face_area is not None:
            modulus = task.scene.effective_modulus
            area = geometry.indenter.face_area
            _, fractions, _ = punch_grid(geometry, area, task.resolution, modulus)
            entries = np.count_nonzero(fractions) ** 2
            return float(_BYTES_OF_ENTRY * entries + _BYTES_OF_CELL * fractions.size)
        rough = isinstance(geometry, RoughGeometry)
        grid = make_grid(geometry, geometry.points[0] if rough else task.resolution)
        total = cells(geometry, task.resolution)
        # cells that overlap at each load, from which the iteration starts: at least one
        gap, reached = grid.gap, list(task.loads.values)
        if task.loads.control == "force":
            operator = self.operator(task, gap.shape, grid.spacing)
            lowest = gap[np.isfinite(gap)].min()
            reached = [lowest + started_from(operator, gap - lowest, float(f)) for f in reached]
        overlapping = np.maximum(np.searchsorted(np.sort(gap, axis=None), reached), 1)
        overlap = overlapping * total / gap.size
        # of a rough surface they are counted twice, with what overlaps beside them
        share = min(1.0, contact_cells(task) / (2 if rough else 1) / overlap[-1])
        last = np.append(0.0, overlap[:-1]) / overlap
        factor = np.minimum(overlap * (share + (1 - share) * (1 - last) ** _LATER), CELL_LIMIT)
        return float(8.0 * factor.max() ** 2 + _BYTES_OF_CELL * total)

    def model(self, geometry: Geometry) -> str:
        if isinstance(geometry, IndenterGeometry) and geometry.indenter.flat:
            return f"only the cells of the face enter the matrix; {RIM}"
        return (
            "only the contact cells enter the matrix; the contact set is found by removing cells "
            "in tension and adding overlapping cells"
        )

    def operator(
        self, task: Task, shape: tuple[int, int], spacing: tuple[float, float]
    ) -> FreeOperator:
        return FreeOperator(shape, spacing, task.scene.effective_modulus)

    def sweep(
        self, task: Task, operator: FreeOperator, gap: np.ndarray, loads: np.ndarray
    ) -> Iterator[Contact]:
        return sweep(operator, gap, Load(task.loads.control, loads), by="pivot")
