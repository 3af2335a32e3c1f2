"""The method `bem_dense`: the chapter's own half-space solver, (19.2)-(19.8)."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from comparisons.geometry.prepare import Geometry, RoughGeometry
from comparisons.methods.base import Support, Task
from comparisons.methods.grid import (
    GridMethod,
    Operator,
    cells,
    contact_cells,
    rough_resolutions,
)
from comparisons.scene.method_names import METHOD_NAMES
from comparisons.scene.options import DenseOptions
from comparisons.scene.scene import Scene
from reference.halfspace import Contact, FreeOperator, dense
from reference.halfspace.edge_cells import respond_dense


class BemDense(GridMethod):
    """Exact to round-off on its grid, with work that grows as the cube of the contact cells."""

    name = "bem_dense"
    title = METHOD_NAMES[name].title
    face = staticmethod(respond_dense)

    def supports(self, scene: Scene) -> Support:
        """Free half-space under force or penetration control."""
        if scene.surface is not None and scene.surface.periodic:
            return Support(False, "the chapter's kernel (19.3) is that of a free half-space")
        if scene.loading.control == "mean_gap":
            return Support(False, "no mean-gap control on a free half-space with few contacts")
        return Support(True)

    def resolutions(self, scene: Scene, geometry: Geometry) -> tuple[int, ...]:
        """Up to some 1000 contact cells: beyond it the FFT gives the same answer sooner."""
        if isinstance(geometry, RoughGeometry):
            return rough_resolutions(geometry)
        return (5, 10, 20)

    def refused(self, task: Task) -> str:
        """Refuse contacts of more cells than a dense matrix should hold."""
        assert isinstance(task.options, DenseOptions)
        if super().refused(task):
            return super().refused(task)
        number, limit = contact_cells(task), task.options.max_cells
        if number <= limit:
            return ""
        return f"about {number:.0f} contact cells, more than {limit}: use bem_fft"

    def memory(self, task: Task) -> float:
        """Bytes of the contact block and its factor."""
        # The iteration starts from the whole geometric overlap.
        return 24.0 * min(2.5 * contact_cells(task), cells(task.geometry, task.resolution)) ** 2

    def model(self, scene: Scene, geometry: Geometry) -> str:
        """Name the matrix."""
        return (
            "the contact cells alone enter the matrix; the contact set is found by dropping "
            "tension and adding overlap"
        )

    def operator(
        self, task: Task, shape: tuple[int, int], spacing: tuple[float, float]
    ) -> Operator:
        """Return the free operator."""
        return FreeOperator(shape, spacing, task.scene.effective_modulus)

    def sweep(
        self, task: Task, operator: Operator, gap: np.ndarray
    ) -> Callable[[np.ndarray], Iterator[Contact]]:
        """Return the active-set sweep."""

        def run(loads: np.ndarray) -> Iterator[Contact]:
            return dense.sweep(operator, gap, **{task.loads.control: loads})

        return run
