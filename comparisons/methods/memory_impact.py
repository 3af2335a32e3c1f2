"""Impact of a mass on a viscoelastic body: springs in time against an initial value problem."""

from __future__ import annotations

from comparisons.geometry.prepare import Geometry
from comparisons.methods.base import Solution, Support, Task
from comparisons.methods.closed_form import ClosedForm, form_of
from comparisons.methods.memory import circular, material_of, springs_of
from comparisons.methods.reduced import Reduced, profile_of
from comparisons.scene.options import ReducedOptions
from comparisons.scene.scene import Scene
from reduced import errors as reduced_errors
from reduced.memory.impact import Impact
from reduced.memory.impact import impact as strike
from reduced.memory.materials import prony
from reduced.profiles.shapes import paraboloid
from reference import viscoelastic as reference
from reference.errors import ConvergenceError

PHYSICS = frozenset({"viscoelastic", "dynamics"})
# Steps in the duration of an elastic impact for each spring per contact radius.
STEPS = 10


class ReducedImpact(Reduced):
    """A mass on springs with memory, step by step."""

    physics = PHYSICS

    def supports(self, scene: Scene) -> Support:
        """Every indenter; impacts only."""
        reason = _no_impact(scene)
        return Support(False, reason) if reason else super().supports(scene)

    def model(self, scene: Scene, geometry: Geometry) -> str:
        """Name the line, its springs and the mass."""
        return f"{super().model(scene, geometry)}; each with memory; the mass in implicit steps"

    def warm_up(self, task: Task) -> None:
        """Compile the springs on an impact that cannot fail."""
        strike(paraboloid(1.0), prony(1.0, [1.0], [1.0]), 1.0, 0.01, springs=4, steps=10)

    def solve(self, task: Task) -> Solution:
        """Let the mass strike at every velocity."""
        solution = Solution.empty(task)
        for step, velocity in enumerate(task.loads.values):
            try:
                hit = self._struck(task, float(velocity), springs=task.resolution)
            except reduced_errors.ConvergenceError as error:
                solution.fail((0, step), error.reason)
                continue
            values = {"velocity": float(velocity), "restitution": hit.restitution}
            values |= {"contact_duration": hit.duration, "force": float(hit.force.max())}
            solution.put((0, step), values | {"penetration": float(hit.penetration.max())})
        solution.unknowns = 2 * task.resolution
        return solution

    def _struck(self, task: Task, velocity: float, springs: int) -> Impact:
        scene, options = task.scene, task.options
        assert scene.dynamics is not None
        assert isinstance(options, ReducedOptions)
        return strike(
            *(profile_of(scene), springs_of(scene), scene.dynamics.mass, velocity),
            poisson_ratio=scene.poisson_ratio,
            springs=springs,
            steps=STEPS * springs,
            edges=options.edges,
        )


class ClosedFormImpact(ClosedForm):
    """The hereditary integrals as states of an initial value problem."""

    physics = PHYSICS

    def supports(self, scene: Scene) -> Support:
        """Bodies of revolution whose static contact is known."""
        reason = _no_impact(scene)
        support = super().supports(scene)
        if reason or not support.ok:
            return Support(False, reason) if reason else support
        if not circular(scene):
            return Support(False, "the integrals of Lee-Radok and Ting are for circular contacts")
        return Support(True, f"Lee & Radok 1960, Ting 1968; {support.reason}")

    def solve(self, task: Task) -> Solution:
        """Integrate each impact."""
        scene, solution = task.scene, Solution.empty(task)
        assert scene.indenter is not None
        assert scene.dynamics is not None
        modulus = scene.effective_modulus
        form = form_of(scene.indenter, modulus)
        assert form is not None
        for step, velocity in enumerate(task.loads.values):
            try:
                hit = reference.impact(
                    *(form, modulus, material_of(scene), scene.dynamics.mass, float(velocity)),
                    poisson_ratio=scene.poisson_ratio,
                )
            except ConvergenceError as error:
                solution.fail((0, step), error.reason)
                continue
            values = {"velocity": float(velocity), "restitution": hit.restitution}
            values |= {"contact_duration": hit.duration, "force": hit.force}
            solution.put((0, step), values | {"penetration": hit.penetration})
            solution.violation[0, step] = hit.error
        return solution


def _no_impact(scene: Scene) -> str:
    """Return why a scene is no single impact of a shape, "" where it is."""
    if scene.indenter is None:
        return "only single contacts strike here, no rough surfaces"
    return "gives impacts, not their course in time" if scene.loading.time is not None else ""


WIRINGS = (ReducedImpact(), ClosedFormImpact())
