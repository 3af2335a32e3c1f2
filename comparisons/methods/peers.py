"""The methods `tamaas` and `contactmechanics`: solvers of other people on the same grids."""

from __future__ import annotations

import statistics

import numpy as np

from comparisons.geometry.prepare import Geometry, RoughGeometry
from comparisons.machine import MEMORY_SHARE, free_memory
from comparisons.methods.base import Method, Solution, Support, Task
from comparisons.methods.grid import (
    cells,
    contact_fields,
    contact_quantities,
    keep_pressure,
    make_grid,
)
from comparisons.peers import press
from comparisons.scene.method_names import METHOD_NAMES
from comparisons.scene.options import PeerOptions
from comparisons.scene.scene import Scene
from reference.halfspace import FreeOperator, PeriodicOperator

# Double arrays of one grid that a peer's process holds, twice padded, beside ours.
ARRAYS = 100


class PeerMethod(Method):
    """The same prepared heights and loads as `bem_fft`, solved in the peer's own process.

    Times are taken there, around the solve; the violation is measured here, and the peer's
    tolerance changed until it is within the option `tolerance` (`comparisons.peers.press`).
    """

    isolated = True
    peer = True

    def supports(self, scene: Scene) -> Support:
        """Where it is installed, and its control can be translated."""
        if not press.installed(self.name):
            return Support(False, "not installed: pip install 'roughline[peers]'")
        if scene.indenter is not None and scene.indenter.flat:
            return Support(False, "sharp edges between cells: it has whole cells only")
        if scene.loading.control == "mean_gap" and not self._periodic(scene):
            return Support(False, "no mean-gap control on a free half-space")
        return Support(True, f"{press.versions(self.name)}, in its own process")

    @staticmethod
    def _periodic(scene: Scene) -> bool:
        return scene.surface is not None and scene.surface.periodic

    def resolutions(self, scene: Scene, geometry: Geometry) -> tuple[int, ...]:
        """Return the surface's own points; for indenters one grid: it checks, not leads."""
        return geometry.points[:1] if isinstance(geometry, RoughGeometry) else (32,)

    def memory(self, task: Task) -> float:
        """Bytes of both processes."""
        pressures = len(task.realisations) * (len(task.loads.values) + 2)
        return 8.0 * (ARRAYS + 3 * pressures) * cells(task.geometry, task.resolution)

    def model(self, scene: Scene, geometry: Geometry) -> str:
        """Name the solver."""
        text = f"{self.title}, a public code, on the same cells as bem_fft"
        return text + (self._search if self._searches(scene) else "")

    _search = ""

    def _searches(self, scene: Scene) -> bool:
        return scene.loading.control == "penetration" and not self._periodic(scene)

    def solve(self, task: Task) -> Solution:
        """Solve all realisations in one process of the peer."""
        assert isinstance(task.options, PeerOptions)
        solution = Solution.empty(task)
        grids = [make_grid(task.geometry, task.resolution, each) for each in task.realisations]
        solution.unknowns = int(np.isfinite(grids[0].gap).sum())
        periodic = isinstance(task.geometry, RoughGeometry) and task.geometry.periodic
        kind = PeriodicOperator if periodic else FreeOperator
        operator = kind(grids[0].gap.shape, grids[0].spacing, task.scene.effective_modulus)
        gaps = np.array([grid.gap for grid in grids])
        result = press.press(
            self.name,
            press.Problem(operator, gaps, task.loads.control, task.loads.values),
            task.options.tolerance,
            seconds=task.options.seconds,
            memory=MEMORY_SHARE * free_memory(),
        )
        for index, reason in result.reasons.items():
            solution.fail(index, reason)
        for (row, step), contact in result.contacts.items():
            solution.put((row, step), contact_quantities(task, operator, contact, grids[row]))
            solution.iterations[row, step] = contact.iterations
            solution.violation[row, step] = contact.violation
            keep_pressure(task, solution, (row, step), contact, grids[row])
            if row == 0 and step == len(task.loads.values) - 1:
                solution.fields = contact_fields(task, contact, grids[row])
        if result.seconds:
            solution.seconds = statistics.median(result.seconds)
        solution.setup_seconds = result.setup_seconds
        solution.compile_seconds = result.compile_seconds
        solution.memory = result.memory
        return solution


class Tamaas(PeerMethod):
    """Tamaas (Frérot, Anciaux, Rey, Pham-Ba & Molinari, J. Open Source Softw. 5 (2020) 2121)."""

    name = "tamaas"
    title = METHOD_NAMES[name].title
    _search = "; it controls the force, and the penetration is searched for"


class ContactMechanics(PeerMethod):
    """ContactMechanics (Pastewka and others, github.com/ContactEngineering)."""

    name = "contactmechanics"
    title = METHOD_NAMES[name].title
