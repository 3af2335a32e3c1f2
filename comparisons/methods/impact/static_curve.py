"""Impacts from the static load curve, for methods that compute forces but not energies.

The slow contact is solved at a ladder of penetrations, deeper than any of the impacts; energy and
time follow from the curve (`reference.dynamics.collision.collide_curve`), whose own error from the
ladder's steps is part of the bar.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, ClassVar

import numpy as np

from comparisons.geometry.prepare import (
    IndenterGeometry,
    equivalent_profile,
    indenter_geometry,
)
from comparisons.methods.runner import run
from comparisons.methods.solver import Refused, Solver, needed
from comparisons.scene.physics.absolute_loads import loads_of
from comparisons.scene.scene import Scene, validated
from comparisons.tasks.solution import Solution
from comparisons.tasks.task import Task
from reduced.motion.elastic_impact import impact_depth
from reference.dynamics.collision import collide_curve

# The ladder: from this share of the shallowest impact to this multiple of the deepest estimate.
_SHALLOWEST, _DEEPEST = 0.05, 1.2
_PER_DECADE, _FEWEST = 10, 12


ONLY_INDENTERS = "impacts are for single contacts only, not for rough surfaces"


def static_scene(scene: Scene, penetration: np.ndarray) -> Scene:
    """Return the same contact without a mass, pressed slowly to the given penetrations."""
    data = scene.model_dump(exclude_defaults=True, by_alias=True)
    data["directory"] = scene.directory
    data["loading"] = {"penetration": {"values": penetration.tolist()}}
    data["compare"] = data.get("compare", {}) | {"quantities": ["force"]}
    del data["dynamics"]
    return validated(data)


class CurveImpact(Solver[IndenterGeometry]):
    """A 3-D method that strikes along its own static load curve.

    `static` is the solver that presses. `ladder_span` is the largest ratio of contact radii on one
    of its grids: energy sums up the curve from its beginning, so that contacts differ less than
    where each load stands for itself.
    """

    physics = frozenset({"dynamics"})
    static: ClassVar[type[Solver[Any]]]
    ladder_span = 3.0

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.indenter = needed(scene.indenter, ONLY_INDENTERS)
        if scene.loading.time is not None:
            raise Refused("computes impacts, not their time history")
        self.dynamics = needed(scene.dynamics, "no [dynamics]")
        # Any depth will do: only the kind of load matters here.
        self.slow = self.static(static_scene(scene, np.array([1e-9])))
        self.note = self.slow.note
        self.options_read = self.slow.options_read

    def resolutions(self, geometry: IndenterGeometry) -> tuple[int, ...]:
        """Those of the slow contact."""
        return self.slow.resolutions(geometry)

    def refusal(self, task: Task[IndenterGeometry]) -> str:
        """Refuse what the slow contact refuses."""
        return self.slow.refusal(task)

    def memory(self, task: Task[IndenterGeometry]) -> float:
        """Bytes of the slow contact."""
        return self.slow.memory(task)

    def model(self, geometry: IndenterGeometry) -> str:
        """Name the static model and what is done with it."""
        return f"{self.slow.model(geometry)}; the impact by energy along its load curve"

    def warm_up(self, task: Task[IndenterGeometry]) -> None:
        """Compile what the slow contact needs."""
        self.slow.warm_up(self._pressed(task))

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        """Press slowly, then strike at each velocity."""
        slow = self._pressed(task)
        pressed = run(self.static(slow.scene), slow, span=self.ladder_span, reason=str)
        answered = pressed.converged[0]
        solution = Solution.empty(task, unknowns=pressed.unknowns)
        solution.setup_seconds = pressed.setup_seconds
        solution.exact = ("restitution",)
        curve = (slow.loads.values[answered], pressed.quantities["force"][0, answered])
        mass = self.dynamics.mass
        for step, velocity in enumerate(task.loads.values):
            try:
                hit = collide_curve(*curve, mass, float(velocity), bar=pressed.truncation)
            except (ValueError, RuntimeError) as error:
                solution.fail((0, step), str(error))
                continue
            values = {"velocity": float(velocity), "restitution": 1.0, "force": hit.force}
            values |= {"penetration": hit.penetration, "contact_duration": hit.duration}
            solution.put((0, step), values)
            solution.truncation = max(solution.truncation, hit.bar)
        solution.iterations[:] = pressed.iterations.sum()
        solution.violation[:] = float(np.nanmax(pressed.violation, initial=0.0))
        return solution

    def _pressed(self, task: Task[IndenterGeometry]) -> Task[IndenterGeometry]:
        """Return the task of the slow contact, on a ladder of penetrations."""
        slowest = 0.5 * self.dynamics.mass * float(task.loads.values[0]) ** 2
        profile = equivalent_profile(self.indenter)
        low = _SHALLOWEST * impact_depth(profile, self.scene.effective_modulus, slowest)
        high = _DEEPEST * task.geometry.penetration
        count = max(_FEWEST, round(_PER_DECADE * np.log10(high / low)) + 1)
        slow = static_scene(self.scene, np.geomspace(low, high, count))
        loads = loads_of(slow)
        pressed = indenter_geometry(slow, loads)
        return replace(
            task, scene=slow, geometry=pressed, loads=loads, quantities=("force",), with_body=False
        )
