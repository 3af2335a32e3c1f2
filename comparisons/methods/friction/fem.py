"""Friction with finite elements: an independent check of the coupled problem."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from comparisons.geometry.prepare import IndenterGeometry
from comparisons.methods.fem.indenter import LARGEST_POISSON, FemSolver
from comparisons.methods.friction.path import finer_path
from comparisons.methods.solver import Refused, Solver, needed
from comparisons.scene.scene import Scene
from comparisons.tasks.steps import Row, Step
from comparisons.tasks.task import Task
from reference.fem import Material
from reference.fem.friction import FrictionalBody, NodalStep, follow, frictional_body
from reference.loads import LoadPath

# The nodes that may touch reach this far, in contact radii: within it the shape must have a gap.
_REACH = 1.25
# Steps of the path are as fine as on a grid of so many cells per element: they are cheap here, and
# must grow finer with the mesh, so that the bar of three meshes covers them.
_CELLS_PER_ELEMENT = 8


class FemFriction(Solver[IndenterGeometry]):
    """Half of a half-space of 27-node elements, forces node after node (Jourdan et al. 1998)."""

    name = "fem"
    physics = frozenset({"friction"})
    span = FemSolver.span

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        reason = "finite elements with friction are for round smooth contacts only"
        self.indenter = needed(scene.indenter, reason)
        if not self.indenter.axisymmetric or self.indenter.flat:
            raise Refused(reason)
        nu = scene.poisson_ratio
        if nu > LARGEST_POISSON:
            raise Refused(f"finite elements with friction: nu up to {LARGEST_POISSON}, got {nu:g}")
        friction = needed(scene.friction, "no [friction]")
        if friction.coupling != "full":
            raise Refused("the scene leaves out the coupling, which finite elements always include")
        self.friction = friction.coefficient

    def resolutions(self, geometry: IndenterGeometry) -> tuple[int, ...]:
        """Elements per contact radius; the mesh takes even numbers."""
        return (2, 4, 6)

    def refusal(self, task: Task[IndenterGeometry]) -> str:
        """Refuse meshes that take minutes, and contacts near a sharp edge."""
        if task.resolution % 2 or task.resolution > 6:
            return "elements with friction take 2, 4 or 6 per contact radius"
        radius = np.array(_REACH * task.geometry.contact_radius)
        beyond = self.indenter.gap(radius, np.array(0.0))
        return "" if np.isfinite(beyond) else "the shape ends near the edge of the contact"

    def memory(self, task: Task[IndenterGeometry]) -> float:
        """Bytes of the elimination: 23 000 unknowns of 6 elements per contact radius took 1 GB."""
        return 5e6 * task.resolution**3

    def model(self, geometry: IndenterGeometry) -> str:
        """Name the mesh, and what acts on what."""
        return (
            "half of a half-space of 27-node hexahedra around the contact; outside it the fields "
            "of Boussinesq and Cerruti; friction node after node, pressing and shearing coupled"
        )

    def warm_up(self, task: Task[IndenterGeometry]) -> None:
        """Compile the sweeps on the coarsest mesh."""
        body = frictional_body(1.0, Material(1.0, 0.3), elements=2)
        gap = (body.points**2).sum(axis=1) / 2
        shifted = LoadPath("tangential_displacement", 0.05)
        list(follow(body, gap, 0.3, LoadPath("penetration", 0.5), shifted))

    def rows(self, task: Task[IndenterGeometry]) -> Iterator[Row]:
        """Mesh the half-space for the contact at the normal load."""
        nu, radius = self.scene.poisson_ratio, task.geometry.contact_radius
        modulus = self.scene.effective_modulus * (1 - nu**2)
        body = frictional_body(radius, Material(modulus, nu), elements=task.resolution)
        yield Row(partial(self._path, task, body), unknowns=body.unknowns)

    def _path(
        self, task: Task[IndenterGeometry], body: FrictionalBody, loads: np.ndarray
    ) -> Iterator[Step]:
        """Yield the steps at the scene's own loads."""
        way = finer_path(task, _CELLS_PER_ELEMENT * task.resolution, coupled=True)
        gap = self.indenter.gap(*body.points.T)
        for step in way.scene_steps(follow(body, gap, self.friction, *way.loads)):
            yield Step(_quantities(step), iterations=step.sweeps, violation=step.error)


def _quantities(step: NodalStep) -> dict[str, float]:
    """Return loads; nodes in contact tell an area to a spacing only, so that none is given."""
    return {
        "tangential_force": step.tangential_force,
        "tangential_displacement": step.tangential_displacement,
        "friction_coefficient": step.tangential_force / step.force,
        "penetration": step.penetration,
        "force": step.force,
    }
