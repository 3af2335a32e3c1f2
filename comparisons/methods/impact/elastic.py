"""Impact of a mass in elastic contact: springs, closed forms, and static load curves."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from comparisons.geometry.prepare import IndenterGeometry
from comparisons.methods.fem.indenter import Fem
from comparisons.methods.impact.course import closed_course, spring_course
from comparisons.methods.impact.static_curve import ONLY_INDENTERS, CurveImpact
from comparisons.methods.normal.bem_dense import BemDense
from comparisons.methods.normal.bem_fft import BemFft
from comparisons.methods.normal.closed_form import ClosedForm
from comparisons.methods.normal.reduced import ReducedProfile
from comparisons.methods.solver import Refused, needed
from comparisons.scene.scene import Scene
from comparisons.tasks.solution import Solution
from comparisons.tasks.steps import Row, Step, solve_rows
from comparisons.tasks.task import Task
from reduced.motion.elastic_impact import ElasticImpact, strike
from reduced.springs.line import Springs
from reference.dynamics.collision import collide

PHYSICS = frozenset({"dynamics"})
NO_TABLE = "no [dynamics]"


class ReducedImpact(ReducedProfile):
    """The mass on the springs of its equivalent profile: by energy, or in steps of time."""

    physics = PHYSICS
    only_indenters = ONLY_INDENTERS
    options_read = frozenset({"rule", "edges"})

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        if scene.loading.time is not None and self.options.edges == "nodal":
            raise Refused("time stepping needs sub-cell contact edges (edges = 'sub_cell')")
        self.dynamics = needed(scene.dynamics, NO_TABLE)

    def model(self, geometry: IndenterGeometry) -> str:
        """Name the line and what is done with it."""
        course = "by its energy, without time steps"
        if self.scene.loading.time is not None:
            course = "in steps of time that keep the energy, refined with the springs"
        return f"{super().model(geometry)}; the impact {course}"

    def warm_up(self, task: Task[IndenterGeometry]) -> None:
        """Compile the springs, and the steps where there are any."""
        if task.loads.times is None:
            self._struck(task, springs=4)
        else:
            spring_course(task, task.loads.times, self.profile, self.dynamics, 1)

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        """Let the mass strike at all velocities, or follow it in time."""
        if task.loads.times is not None:
            course = task.loads.times, self.profile, self.dynamics
            return spring_course(task, *course, task.resolution)
        hit = self._struck(task, springs=task.resolution)
        curves = {
            "velocity": hit.velocity,
            "penetration": hit.penetration,
            "force": hit.force,
            "restitution": hit.restitution,
            "contact_duration": hit.duration,
        }
        return Solution.of(task, curves, unknowns=2 * task.resolution)

    def _struck(self, task: Task[IndenterGeometry], springs: int) -> ElasticImpact:
        row = Springs(self.profile, self.modulus, springs, edges=self.options.edges)
        return strike(row, self.dynamics.mass, task.loads.values)


class ClosedFormImpact(ClosedForm):
    """The static closed form: integrated over the impact to round-off, or in time."""

    physics = PHYSICS
    only_indenters = ONLY_INDENTERS

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.dynamics = needed(scene.dynamics, NO_TABLE)

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        """Integrate each impact, or follow one in time."""
        if task.loads.times is not None:
            return closed_course(task, task.loads.times, self.form, self.dynamics)
        return solve_rows(task, self.rows(task))

    def rows(self, task: Task[IndenterGeometry]) -> Iterator[Row]:
        """Nothing is set up."""
        yield Row(partial(self._steps))

    def _steps(self, loads: np.ndarray) -> Iterator[Step]:
        """Integrate each impact; elastic bodies give back all of the energy."""
        for velocity in loads:
            hit = collide(self.form, self.dynamics.mass, float(velocity))
            values = {"velocity": float(velocity), "restitution": 1.0}
            values |= {"penetration": hit.penetration, "force": hit.force}
            yield Step(values | {"contact_duration": hit.duration}, violation=0.0)


class FftImpact(CurveImpact):
    """Along the load curve of the half-space on a grid."""

    name = "bem_fft"
    static = BemFft
    shared_cells = BemFft.shared_cells


class DenseImpact(CurveImpact):
    """Along the load curve of the dense half-space solver."""

    name = "bem_dense"
    static = BemDense


class FemImpact(CurveImpact):
    """Along the load curve of the finite-element body."""

    name = "fem"
    static = Fem
    span = Fem.span
    ladder_span = Fem.span  # each load scales the mesh onto its own contact
