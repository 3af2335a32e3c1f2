"""The methods `tamaas` and `contactmechanics`: third-party solvers on the same grids."""

from __future__ import annotations

import statistics

import numpy as np

from comparisons.facts.methods import METHODS
from comparisons.geometry.prepare import Geometry, RoughGeometry
from comparisons.isolation.parent import Limits
from comparisons.machine import MEMORY_SHARE, free_memory
from comparisons.methods.normal.grid import cells, contact_step, make_grid
from comparisons.methods.solver import Refused, Solver
from comparisons.scene.options import PeerOptions
from comparisons.scene.scene import Scene
from comparisons.tasks.solution import Solution
from comparisons.tasks.steps import record
from comparisons.tasks.task import Task
from reference.halfspace import FreeOperator, PeriodicOperator

# Double arrays of one grid that a peer's process holds, twice padded, beside ours.
ARRAYS = 100


class PeerSolver(Solver[Geometry]):
    """The same prepared heights and loads as `bem_fft`, solved in the peer's own process.

    Times are taken there, around the solve; the violation is measured here, and the peer's
    tolerance changed until it is within the option `tolerance` (`comparisons.peers.client`).
    """

    def __init__(self, scene: Scene, options: PeerOptions) -> None:
        super().__init__(scene)
        if scene.indenter is not None and scene.indenter.flat:
            raise Refused("sharp edges inside cells are not supported")
        self.periodic = scene.surface is not None and scene.surface.periodic
        if scene.loading.control == "mean_gap" and not self.periodic:
            raise Refused("no mean-gap control on a free half-space: use bem_fft")
        from comparisons.peers import client

        if not client.installed(self.name):  # last: installing helps only who can do the scene
            raise Refused("not installed: pip install 'roughline[peers]'", missing=True)
        self.tolerance, self.seconds = options.tolerance, options.seconds
        self.note = f"{client.versions(self.name)}, in its own process"

    def resolutions(self, geometry: Geometry) -> tuple[int, ...]:
        """Return the surface's own points; for indenters one grid: it checks, not leads."""
        return geometry.points[:1] if isinstance(geometry, RoughGeometry) else (32,)

    def memory(self, task: Task) -> float:
        pressures = len(task.realisations) * (len(task.loads.values) + 2)
        return 8.0 * (ARRAYS + 3 * pressures) * cells(task.geometry, task.resolution)

    def model(self, geometry: Geometry) -> str:
        return f"{METHODS[self.name].title}, a public code, on the same cells as bem_fft"

    def solve(self, task: Task) -> Solution:
        from comparisons.peers import client

        solution = Solution.empty(task)
        grids = [
            make_grid(task.geometry, task.resolution, realisation)
            for realisation in task.realisations
        ]
        solution.unknowns = int(np.isfinite(grids[0].gap).sum())
        kind = PeriodicOperator if self.periodic else FreeOperator
        operator = kind(grids[0].gap.shape, grids[0].spacing, self.scene.effective_modulus)
        gaps = np.array([grid.gap for grid in grids])
        result = client.press(
            self.name,
            client.Problem(operator, gaps, task.loads.control, task.loads.values),
            self.tolerance,
            limits=Limits(self.seconds, MEMORY_SHARE * free_memory()),
        )
        for index, reason in result.reasons.items():
            solution.fail(index, reason)
        for (row, step), contact in result.contacts.items():
            record(solution, (row, step), contact_step(task, operator, contact, grids[row]), task)
        if result.seconds:
            solution.seconds = statistics.median(result.seconds)
        solution.setup_seconds = result.setup_seconds
        solution.compile_seconds = result.compile_seconds
        solution.memory = result.memory
        return solution


class Tamaas(PeerSolver):
    """Tamaas (Frérot, Anciaux, Rey, Pham-Ba & Molinari, J. Open Source Softw. 5 (2020) 2121)."""

    name = "tamaas"

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene, scene.methods.tamaas)

    def model(self, geometry: Geometry) -> str:
        searches = self.scene.loading.control == "penetration" and not self.periodic
        search = "; it controls the force, and the penetration is searched for"
        return super().model(geometry) + (search if searches else "")


class ContactMechanics(PeerSolver):
    """ContactMechanics (Pastewka and others, github.com/ContactEngineering)."""

    name = "contactmechanics"

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene, scene.methods.contactmechanics)
