"""Impacts by the static load curve: what a method needs that knows forces, not energies.

The slow contact is solved at a ladder of penetrations, deeper than any of the impacts; energy and
time follow from the curve (`reference.dynamics.collision.collide_curve`), whose own error from the
ladder's steps is part of the bar.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from comparisons.geometry.prepare import Geometry, IndenterGeometry, equivalent_profile, prepare
from comparisons.methods.base import Method, Solution, Support, Task
from comparisons.methods.spans import solve_in_spans
from comparisons.scene.scene import Scene, validated
from reduced.motion.contact import impact_depth
from reference.dynamics.collision import collide_curve

# The ladder: from this share of the shallowest impact to this multiple of the deepest estimate.
_SHALLOWEST, _DEEPEST = 0.05, 1.2
_PER_DECADE, _FEWEST = 10, 12


def no_impact(scene: Scene) -> str:
    """Return why a scene is no single impact of a shape, "" where it is."""
    if scene.indenter is None:
        return "only single contacts strike here, no rough surfaces"
    return ""


def static_scene(scene: Scene, penetration: np.ndarray) -> Scene:
    """Return the same contact without a mass, pressed slowly to the given penetrations."""
    data = scene.model_dump(exclude_defaults=True, by_alias=True)
    data["directory"] = scene.directory
    data["loading"] = {"penetration": {"values": penetration.tolist()}}
    data["compare"] = data.get("compare", {}) | {"quantities": ["force"]}
    del data["dynamics"]
    return validated(data)


class CurveImpact(Method):
    """A 3-D method that strikes along its own static load curve.

    `static` is the method that presses; a subclass inherits from its class too. `ladder_span` is
    the largest ratio of contact radii on one of its grids: energy sums up the curve from its
    beginning, so that contacts differ less than where each load stands for itself.
    """

    physics = frozenset({"dynamics"})
    static: Method
    ladder_span = 3.0

    def supports(self, scene: Scene) -> Support:
        """Whatever the slow contact supports; no courses in time."""
        reason = no_impact(scene)
        if scene.loading.time is not None:
            reason = "gives impacts, not their course in time"
        if reason:
            return Support(False, reason)
        # Any depth will do: only the kind of load matters here.
        return self.static.supports(static_scene(scene, np.array([1e-9])))

    def model(self, scene: Scene, geometry: Geometry) -> str:
        """Name the static model and what is done with it."""
        return f"{super().model(scene, geometry)}; the impact by energy along its load curve"

    def warm_up(self, task: Task) -> None:
        """Compile what the slow contact needs."""
        self.static.warm_up(_pressed(task))

    def solve(self, task: Task) -> Solution:
        """Press slowly, then strike at each velocity."""
        dynamics = task.scene.dynamics
        assert dynamics is not None
        slow = _pressed(task)
        pressed = solve_in_spans(slow, self.ladder_span, self.static.solve, str)
        found = pressed.converged[0]
        solution = Solution.empty(task, unknowns=pressed.unknowns)
        solution.setup_seconds = pressed.setup_seconds
        solution.exact = ("restitution",)
        violation = float(np.nanmax(pressed.violation, initial=0.0))
        curve = (slow.loads.values[found], pressed.quantities["force"][0, found])
        for step, velocity in enumerate(task.loads.values):
            try:
                hit = collide_curve(*curve, dynamics.mass, float(velocity), bar=pressed.truncation)
            except (ValueError, RuntimeError) as error:
                solution.fail((0, step), str(error))
                continue
            values = {"velocity": float(velocity), "restitution": 1.0, "force": hit.force}
            values |= {"penetration": hit.penetration, "contact_duration": hit.duration}
            solution.put((0, step), values)
            solution.truncation = max(solution.truncation, hit.bar)
        solution.iterations[:] = pressed.iterations.sum()
        solution.violation[:] = violation
        return solution


def _pressed(task: Task) -> Task:
    """Return the task of the slow contact, on a ladder of penetrations."""
    scene, geometry = task.scene, task.geometry
    assert scene.dynamics is not None
    assert scene.indenter is not None
    assert isinstance(geometry, IndenterGeometry)
    slowest = 0.5 * scene.dynamics.mass * float(task.loads.values[0]) ** 2
    profile = equivalent_profile(scene.indenter)
    low = _SHALLOWEST * impact_depth(profile, scene.effective_modulus, slowest)
    high = _DEEPEST * geometry.penetration
    count = max(_FEWEST, round(_PER_DECADE * np.log10(high / low)) + 1)
    slow = static_scene(scene, np.geomspace(low, high, count))
    pressed, loads = prepare(slow)
    return replace(
        task, scene=slow, geometry=pressed, loads=loads, quantities=("force",), with_body=False
    )
