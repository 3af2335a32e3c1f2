"""Impact of a rigid mass on an elastic contact: springs, closed forms, and static load curves."""

from __future__ import annotations

from comparisons.geometry.prepare import Geometry
from comparisons.methods.base import Solution, Support, Task
from comparisons.methods.bem_dense import BemDense
from comparisons.methods.bem_fft import BemFft
from comparisons.methods.closed_form import ClosedForm, form_of
from comparisons.methods.fem import Fem
from comparisons.methods.impact_course import closed_course, spring_course
from comparisons.methods.impacts import CurveImpact, no_impact
from comparisons.methods.reduced import Reduced, profile_of
from comparisons.scene.scene import Scene
from reduced.errors import ConvergenceError
from reduced.motion.impact import Impact, strike
from reference.dynamics.collision import collide
from reference.errors import ConvergenceError as ClosedFormError

PHYSICS = frozenset({"dynamics"})


class ReducedImpact(Reduced):
    """The mass on the springs of its equivalent profile: by energy, or in steps of time."""

    physics = PHYSICS

    def supports(self, scene: Scene) -> Support:
        """Every shape with an equivalent profile."""
        reason = no_impact(scene)
        if scene.loading.time is not None and scene.methods.reduced.edges == "nodal":
            reason = "steps in time need contact edges inside the cells (edges = 'sub_cell')"
        return Support(False, reason) if reason else super().supports(scene)

    def model(self, scene: Scene, geometry: Geometry) -> str:
        """Name the line and what is done with it."""
        how = "by its energy, without time steps"
        if scene.loading.time is not None:
            how = "in steps of time that keep the energy, refined with the springs"
        return f"{super().model(scene, geometry)}; the impact {how}"

    def warm_up(self, task: Task) -> None:
        """Compile the springs, and the steps where there are any."""
        if task.loads.times is None:
            _struck(task, springs=4)
        else:
            spring_course(task, 1)

    def solve(self, task: Task) -> Solution:
        """Let the mass strike at all velocities, or follow it in time."""
        if task.loads.times is not None:
            return spring_course(task, task.resolution)
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
    """The static closed form: integrated over the impact to round-off, or in time."""

    physics = PHYSICS

    def supports(self, scene: Scene) -> Support:
        """Shapes whose static contact is known."""
        reason = no_impact(scene)
        return Support(False, reason) if reason else super().supports(scene)

    def solve(self, task: Task) -> Solution:
        """Integrate each impact; elastic bodies give back all of the energy."""
        if task.loads.times is not None:
            return closed_course(task)
        scene, solution = task.scene, Solution.empty(task)
        assert scene.indenter is not None
        assert scene.dynamics is not None
        form = form_of(scene.indenter, scene.effective_modulus)
        assert form is not None
        for step, velocity in enumerate(task.loads.values):
            try:
                hit = collide(form, scene.dynamics.mass, float(velocity))
            except ClosedFormError as error:
                solution.fail((0, step), error.reason)
                continue
            values = {"velocity": float(velocity), "restitution": 1.0}
            values |= {"penetration": hit.penetration, "force": hit.force}
            solution.put((0, step), values | {"contact_duration": hit.duration})
        solution.violation[:] = 0.0
        return solution


class FftImpact(CurveImpact, BemFft):
    """Along the load curve of the half-space on a grid."""

    static = BemFft()


class DenseImpact(CurveImpact, BemDense):
    """Along the load curve of the dense half-space solver."""

    static = BemDense()


class FemImpact(CurveImpact, Fem):
    """Along the load curve of the finite-element body."""

    static = Fem()
    ladder_span = Fem.span  # each load scales the mesh onto its own contact


WIRINGS = (ReducedImpact(), ClosedFormImpact(), FftImpact(), DenseImpact(), FemImpact())
