"""Friction on finite elements: a second opinion where pressing and shearing act on each other."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from comparisons.geometry.prepare import Geometry, IndenterGeometry
from comparisons.methods.base import Solution, Support, Task
from comparisons.methods.fem import LARGEST_POISSON, Fem
from comparisons.methods.friction_path import finer_path
from comparisons.scene.options import FftOptions
from comparisons.scene.scene import Scene
from reference.errors import ConvergenceError
from reference.fem.friction import FrictionStep, follow
from reference.fem.frictional_body import FrictionalBody, frictional_body

# The nodes that may touch reach this far, in contact radii: within it the shape must have a gap.
_REACH = 1.25
# Steps of the path are as fine as on a grid of so many cells per element: they are cheap here, and
# must grow finer with the mesh, so that the bar of three meshes covers them.
_CELLS_PER_ELEMENT = 8


class FemTangential(Fem):
    """Half of a half-space of 27-node elements, forces node after node (Jourdan et al. 1998)."""

    physics = frozenset({"friction"})

    def supports(self, scene: Scene) -> Support:
        """Round smooth shapes; pressing and shearing always act on each other here."""
        indenter = scene.indenter
        if indenter is None or not indenter.axisymmetric or indenter.flat:
            return Support(False, "elements with friction are meshed for round smooth contacts")
        if scene.poisson_ratio > LARGEST_POISSON:
            return Support(
                False, f"nu = {scene.poisson_ratio:g}: elements with friction go to 0.4999"
            )
        options = scene.methods.bem_fft
        assert isinstance(options, FftOptions)
        if options.coupling != "full":
            return Support(False, "the scene leaves out the coupling, which elements always have")
        return Support(True)

    def resolutions(self, scene: Scene, geometry: Geometry) -> tuple[int, ...]:
        """Elements per contact radius; the mesh takes even numbers."""
        return (2, 4, 6)

    def refused(self, task: Task) -> str:
        """Refuse meshes that take minutes, and contacts near a sharp edge."""
        if task.resolution % 2 or task.resolution > 6:
            return "elements with friction take 2, 4 or 6 per contact radius"
        geometry = task.geometry
        assert isinstance(geometry, IndenterGeometry)
        beyond = geometry.indenter.gap(np.array(_REACH * geometry.contact_radius), np.array(0.0))
        return "" if np.isfinite(beyond) else "the shape ends near the edge of the contact"

    def memory(self, task: Task) -> float:
        """Bytes of the elimination: 23 000 unknowns of 6 elements per contact radius took 1 GB."""
        return 5e6 * task.resolution**3

    def model(self, scene: Scene, geometry: Geometry) -> str:
        """Name the mesh, and what acts on what."""
        return (
            "half of a half-space of 27-node hexahedra around the contact; outside it the fields "
            "of Boussinesq and Cerruti; friction node after node, pressing and shearing coupled"
        )

    def warm_up(self, task: Task) -> None:
        """Compile the sweeps on the coarsest mesh."""
        body = frictional_body(1.0, 1.0, 0.3, elements=2)
        gap = (body.points**2).sum(axis=1) / 2
        list(follow(body, gap, 0.3, penetration=[0.5], tangential_displacement=[0.05]))

    def solve(self, task: Task) -> Solution:
        """Follow the path."""
        solution = Solution.empty(task)
        with solution.setup():
            body = _body(task)
            solution.unknowns = body.unknowns
        try:
            for step, found in enumerate(_path(task, body)):
                solution.put((0, step), _quantities(found))
                solution.iterations[0, step] = found.sweeps
                solution.violation[0, step] = found.error
        except ConvergenceError as error:
            for late in np.flatnonzero(~solution.converged[0]):
                solution.fail((0, int(late)), error.reason)
        return solution


def _body(task: Task) -> FrictionalBody:
    """Return the half-space, meshed for the contact at the normal load."""
    nu = task.scene.poisson_ratio
    modulus = task.scene.effective_modulus * (1 - nu**2)
    return frictional_body(task.geometry.contact_radius, modulus, nu, elements=task.resolution)


def _path(task: Task, body: FrictionalBody) -> Iterator[FrictionStep]:
    """Yield the steps at the scene's own loads."""
    scene = task.scene
    assert isinstance(task.geometry, IndenterGeometry)
    assert scene.friction is not None
    way = finer_path(task, _CELLS_PER_ELEMENT * task.resolution, coupled=True)
    gap = task.geometry.indenter.gap(*body.points.T)
    return way.asked(follow(body, gap, scene.friction.coefficient, **way.loads))


def _quantities(step: FrictionStep) -> dict[str, float]:
    """Return loads; nodes in contact tell an area to a spacing only, so that none is given."""
    return {
        "tangential_force": step.tangential_force,
        "tangential_displacement": step.tangential_displacement,
        "friction_coefficient": step.tangential_force / step.force,
        "penetration": step.penetration,
        "force": step.force,
    }


WIRINGS = (FemTangential(),)
