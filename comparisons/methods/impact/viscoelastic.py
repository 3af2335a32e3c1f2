"""Impact of a mass on a viscoelastic body: springs in time against an initial value problem."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from comparisons.geometry.prepare import IndenterGeometry
from comparisons.methods.impact.static_curve import ONLY_INDENTERS
from comparisons.methods.normal.closed_form import ClosedForm
from comparisons.methods.normal.reduced import ReducedProfile
from comparisons.methods.solver import Refused, needed
from comparisons.methods.viscoelastic.indentation import (
    SOURCES,
    body_of,
    circular,
    material_of,
    springs_of,
)
from comparisons.scene.physics.tables.dynamics import Dynamics
from comparisons.scene.scene import Scene
from comparisons.tasks.solution import Solution
from comparisons.tasks.steps import Row, Step, solve_rows
from comparisons.tasks.task import Task
from reduced.memory.materials import prony
from reduced.memory.row import RelaxingSprings
from reduced.memory.viscoelastic_impact import impact as strike
from reduced.profiles.equivalents import paraboloid
from reference import viscoelastic as reference

PHYSICS = frozenset({"viscoelastic", "dynamics"})
# Steps in the duration of an elastic impact for each spring per contact radius.
STEPS = 10


def _striking(scene: Scene) -> Dynamics:
    """Return the mass that strikes once.

    Raises
    ------
    Refused
        If the course of the impact is asked for.
    """
    if scene.loading.time is not None:
        raise Refused("computes impacts, not their time history")
    return needed(scene.dynamics, "no [dynamics]")


class ReducedImpact(ReducedProfile):
    """A mass on springs with memory, step by step."""

    physics = PHYSICS
    only_indenters = ONLY_INDENTERS
    options_read = frozenset({"rule", "edges"})

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.mass = _striking(scene).mass
        self.material = springs_of(body_of(scene))

    def model(self, geometry: IndenterGeometry) -> str:
        """Name the line, its springs and the mass."""
        return f"{super().model(geometry)}; each with memory; the mass in implicit steps"

    def warm_up(self, task: Task[IndenterGeometry]) -> None:
        """Compile the springs on an impact that cannot fail."""
        strike(
            RelaxingSprings(paraboloid(1.0), prony(1.0, [1.0], [1.0]), per_radius=4),
            1.0,
            0.01,
            steps=10,
        )

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        """Let the mass strike at every velocity."""
        return solve_rows(task, self.rows(task))

    def rows(self, task: Task[IndenterGeometry]) -> Iterator[Row]:
        """Nothing is set up."""
        yield Row(partial(self._steps, task.resolution), unknowns=2 * task.resolution)

    def _steps(self, springs: int, loads: np.ndarray) -> Iterator[Step]:
        ratio, edges = self.scene.poisson_ratio, self.options.edges
        row = RelaxingSprings(self.profile, self.material, ratio, springs, edges=edges)
        for velocity in loads:
            hit = strike(row, self.mass, float(velocity), steps=STEPS * springs)
            values = {"velocity": float(velocity), "restitution": hit.restitution}
            values |= {"contact_duration": hit.duration, "force": float(hit.force.max())}
            yield Step(values | {"penetration": float(hit.penetration.max())})


class ClosedFormImpact(ClosedForm):
    """The hereditary integrals as states of an initial value problem."""

    physics = PHYSICS
    only_indenters = ONLY_INDENTERS

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.mass = _striking(scene).mass
        self.form = circular(self.form)
        self.material = material_of(body_of(scene))
        self.note = f"{SOURCES}; {self.note}"

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        """Integrate each impact."""
        return solve_rows(task, self.rows(task))

    def rows(self, task: Task[IndenterGeometry]) -> Iterator[Row]:
        """Nothing is set up."""
        yield Row(self._steps)

    def _steps(self, loads: np.ndarray) -> Iterator[Step]:
        for velocity in loads:
            hit = reference.impact(
                *(self.form, self.modulus, self.material, self.mass, float(velocity)),
                poisson_ratio=self.scene.poisson_ratio,
            )
            values = {"velocity": float(velocity), "restitution": hit.restitution}
            values |= {"contact_duration": hit.duration, "force": hit.force}
            yield Step(values | {"penetration": hit.penetration}, violation=hit.error)
