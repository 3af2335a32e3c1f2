"""The method `bem_dense`: the half-space solver of the chapter, (19.2)-(19.8)."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from comparisons.geometry.prepare import Geometry, RoughGeometry
from comparisons.methods.normal.grid import GridSolver, cells, contact_cells, rough_resolutions
from comparisons.methods.normal.grid_punches import Respond
from comparisons.methods.solver import Refused
from comparisons.scene.scene import Scene
from comparisons.tasks.task import Task
from reference.halfspace import Contact, FreeOperator, dense
from reference.halfspace.edge_cells import respond_dense
from reference.halfspace.solution import Press
from reference.loads import Load


class BemDense(GridSolver[FreeOperator]):
    """Exact to round-off on its grid, with work that grows as the cube of the contact cells."""

    name = "bem_dense"
    options_read = frozenset({"max_cells"})

    @property
    def face(self) -> Respond:
        """The dense solver, with the same cells at the edge."""
        return respond_dense

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        if scene.surface is not None and scene.surface.periodic:
            raise Refused("the kernel (19.3) is for a free half-space")
        if scene.loading.control == "mean_gap":
            raise Refused("no mean-gap control: use bem_fft or fem, or prescribe the force")
        self.most_cells = scene.methods.bem_dense.max_cells

    def resolutions(self, geometry: Geometry) -> tuple[int, ...]:
        """Up to some 1000 contact cells: beyond it the FFT gives the same answer sooner."""
        if isinstance(geometry, RoughGeometry):
            return rough_resolutions(geometry)
        return (5, 10, 20)

    def refusal(self, task: Task) -> str:
        """Refuse contacts of more cells than a dense matrix should hold."""
        elongated = super().refusal(task)
        if elongated:
            return elongated
        number, limit = contact_cells(task), self.most_cells
        if number <= limit:
            return ""
        return f"about {number:.0f} contact cells, more than {limit}: use bem_fft"

    def memory(self, task: Task) -> float:
        """Bytes of the contact block and its factor."""
        # The iteration starts from the whole geometric overlap.
        return 24.0 * min(2.5 * contact_cells(task), cells(task.geometry, task.resolution)) ** 2

    def model(self, geometry: Geometry) -> str:
        """Name the matrix."""
        return (
            "only the contact cells enter the matrix; the contact set is found by removing cells "
            "in tension and adding overlapping cells"
        )

    def operator(
        self, task: Task, shape: tuple[int, int], spacing: tuple[float, float]
    ) -> FreeOperator:
        """Return the free operator."""
        return FreeOperator(shape, spacing, task.scene.effective_modulus)

    def sweep(
        self, task: Task, operator: FreeOperator, gap: np.ndarray
    ) -> Callable[[np.ndarray], Iterator[Contact]]:
        """Return the active-set sweep."""

        def run(loads: np.ndarray) -> Iterator[Contact]:
            return dense.sweep(Press(operator, gap), Load(task.loads.control, loads))

        return run
