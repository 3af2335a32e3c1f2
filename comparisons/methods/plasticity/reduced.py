"""Springs that yield: the readings of the chapter's rule, and Zunker & Kamrin's."""

from __future__ import annotations

import numpy as np

from comparisons.geometry.prepare import IndenterGeometry
from comparisons.methods.normal.reduced import ReducedProfile, line_picture
from comparisons.methods.plasticity.indentation import PHYSICS, radius_of, tables_of
from comparisons.methods.solver import Refused
from comparisons.scene.physics.tables.plasticity import HARDNESS
from comparisons.scene.scene import Scene
from comparisons.tasks.solution import Solution
from comparisons.tasks.task import Task
from reduced.errors import ConvergenceError
from reduced.loads import LoadPath
from reduced.plasticity.caps import Yielded, YieldingSprings, first_yield
from reduced.plasticity.zunker_kamrin import ZunkerKamrin
from reference.plastic import yield_pressure

# How often a line grows by a third until it holds the contact under a force.
_WIDENINGS = 60
_WORDS = {
    "stress": f"capped where their stress (19.37) reaches {HARDNESS} Y",
    "elastic_root": f"capped where the stress of their elastic part reaches {HARDNESS} Y",
    "zunker_kamrin": "under the uniform pressure of Zunker & Kamrin (2024)",
    "none": "that stay elastic",
}


class ReducedPlasticity(ReducedProfile):
    """Springs with a memory of how far they have yielded."""

    physics = PHYSICS
    options_read = frozenset({"rule"})

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.options_read = frozenset({"rule"})
        indenter, self.plasticity = tables_of(scene)
        self.ball = None
        if self.plasticity.model == "zunker_kamrin":
            self.ball = ZunkerKamrin(
                radius_of(indenter),
                self.modulus,
                self.plasticity.yield_stress,
                sphere=indenter.shape == "sphere",
            )
        self.yields_at = self._yields_at()
        if self.plasticity.model not in ("none", "zunker_kamrin") and self.yields_at is None:
            raise Refused(
                "the stress rule (19.37) needs a profile that is curved at its tip and beyond"
            )

    def _yields_at(self) -> float | None:
        """Return the penetration of first yield by the local rule, if it has one."""
        pressure = yield_pressure(self.scene.poisson_ratio) * self.plasticity.yield_stress
        try:
            return first_yield(self.profile, self.modulus, pressure)
        except ValueError:
            return None

    def model(self, geometry: IndenterGeometry) -> str:
        """Name the line, and how it yields."""
        hardening = "; hardening is left out" if self.plasticity.hardens else ""
        return f"{super().model(geometry)}; {_WORDS[self.plasticity.model]}{hardening}"

    def warm_up(self, task: Task[IndenterGeometry]) -> None:
        """Nothing is compiled."""

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        """Walk the whole path."""
        line = self._walked(task)
        curves = {
            "penetration": line.penetration,
            "force": line.force,
            "equivalent_radius": line.contact_radius,
            "contact_length": 2 * line.contact_radius,
            "residual_depth": line.residual_depth,
        }
        if self.yields_at is not None:
            curves["first_yield"] = np.full(line.force.shape, self.yields_at)
        solution = Solution.of(task, curves, unknowns=2 * task.resolution)
        widest = float(line.contact_radius.max())
        depth = float(line.penetration[-1])
        solution.fields = line_picture(self.profile, depth, widest, widest / task.resolution)
        return solution

    def _walked(self, task: Task[IndenterGeometry]) -> Yielded:
        path = LoadPath(task.loads.control, task.loads.values)
        if self.ball is not None:
            return self.ball.walk(path)
        reach = task.geometry.penetration
        for _ in range(_WIDENINGS):
            line = self._springs(task.resolution, reach).walk(path)
            if line.penetration.max() <= reach * (1 + 1e-9):
                return line
            # Springs that yield go deeper under a force than elastic ones, from which this came.
            reach *= 1.3
        raise ConvergenceError("the springs never carry this force")

    def _springs(self, count: int, reach: float) -> YieldingSprings:
        reading = self.plasticity.model
        assert reading != "zunker_kamrin"
        hardness = self.plasticity.hardness
        return YieldingSprings(
            self.profile, self.modulus, hardness, reading, reach=reach, springs=count
        )
