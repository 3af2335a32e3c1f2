"""Impact of a rigid mass on an elastic contact: springs against closed forms and quadrature."""

from __future__ import annotations

from comparisons.geometry import Geometry
from comparisons.methods.base import Solution, Support, Task
from comparisons.methods.closed_form import ClosedForm, form_of
from comparisons.methods.reduced import Reduced, line_picture, profile_of
from comparisons.scene import Scene
from reduced.errors import ConvergenceError
from reduced.impact import Impact, strike
from reference.dynamics.collision import collide

PHYSICS = frozenset({"dynamics"})


def _refused(scene: Scene) -> str:
    """Return why a scene is no single impact of a shape, "" where it is."""
    if scene.indenter is None:
        return "only single contacts strike here, no rough surfaces"
    return "gives impacts, not their course in time" if scene.loading.time is not None else ""


class ReducedImpact(Reduced):
    """The mass on the springs of its equivalent profile, by energy."""

    physics = PHYSICS

    def supports(self, scene: Scene) -> Support:
        """Every shape with an equivalent profile."""
        reason = _refused(scene)
        return Support(False, reason) if reason else super().supports(scene)

    def model(self, scene: Scene, geometry: Geometry) -> str:
        """Name the line and what is done with it."""
        return f"{super().model(scene, geometry)}; the impact by its energy, without time steps"

    def warm_up(self, task: Task) -> None:
        """Compile the springs."""
        _struck(task, springs=4)

    def solve(self, task: Task) -> Solution:
        """Let the mass strike at all velocities."""
        solution = Solution.empty(task)
        try:
            found = _struck(task, springs=task.resolution)
        except ConvergenceError as error:
            for step in range(len(task.loads.values)):
                solution.fail((0, step), error.reason)
            return solution
        curves = {
            "velocity": found.velocity,
            "penetration": found.penetration,
            "force": found.force,
            "restitution": found.restitution,
            "contact_duration": found.duration,
        }
        solution.quantities = {name: values[None, :] for name, values in curves.items()}
        solution.converged[:] = True
        solution.unknowns = 2 * task.resolution
        profile, depth = profile_of(task.scene), float(found.penetration[-1])
        radius = float(profile.contact_radius(depth))
        solution.fields = line_picture(profile, depth, radius, radius / task.resolution)
        return solution


def _struck(task: Task, springs: int) -> Impact:
    scene = task.scene
    assert scene.indenter is not None
    assert scene.dynamics is not None
    return strike(
        profile_of(scene),
        scene.effective_modulus,
        scene.dynamics.mass,
        task.loads.values,
        springs=springs,
        edges=scene.methods.reduced.edges,
    )


class ClosedFormImpact(ClosedForm):
    """The static closed form, integrated over the impact to round-off."""

    physics = PHYSICS

    def supports(self, scene: Scene) -> Support:
        """Shapes whose static contact is known."""
        reason = _refused(scene)
        return Support(False, reason) if reason else super().supports(scene)

    def solve(self, task: Task) -> Solution:
        """Integrate each impact; elastic bodies give back all of the energy."""
        scene, solution = task.scene, Solution.empty(task)
        assert scene.indenter is not None
        assert scene.dynamics is not None
        form = form_of(scene.indenter, scene.effective_modulus)
        assert form is not None
        for step, velocity in enumerate(task.loads.values):
            hit = collide(form, scene.dynamics.mass, float(velocity))
            values = {"velocity": float(velocity), "restitution": 1.0}
            values |= {"penetration": hit.penetration, "force": hit.force}
            solution.put((0, step), values | {"contact_duration": hit.duration})
        solution.violation[:] = 0.0
        return solution


WIRINGS = (ReducedImpact(), ClosedFormImpact())
