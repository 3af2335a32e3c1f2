"""The method `fem`: the 3-D finite-element body under a rigid shape."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import TypeVar

import numpy as np

from comparisons.geometry.prepare import Geometry, IndenterGeometry
from comparisons.methods.fem import punch_mesh
from comparisons.methods.fem.step import (
    bytes_of_elimination,
    bytes_of_iteration,
    contact_step,
    recovered,
)
from comparisons.methods.normal.grid import half_axes
from comparisons.methods.solver import Refused, Solver, needed
from comparisons.scene.indenters.indenter import Indenter
from comparisons.scene.indenters.not_round import Ellipsoid
from comparisons.scene.indenters.punches import EllipticPunch
from comparisons.scene.scene import Scene
from comparisons.tasks.steps import Row, Step
from comparisons.tasks.task import Task
from reference import fem
from reference.closed_form import ellipsoid
from reference.loads import LoadPath

G = TypeVar("G", bound=Geometry)

LARGEST_POISSON = 0.4999
# A factorisation of more takes more than 4 GB and a minute: conjugate gradients take its place.
MOST_CONDENSED = 300_000
# Steps of conjugate gradients grow as (1/2 - nu)^(-1/2): 250 here, 700 of at most 1000 at 0.4999.
LARGEST_POISSON_ITERATED = 0.499
LARGEST_ASPECT = 50
# What the far field beyond the mesh leaves out, measured by doubling the extent of the mesh and
# rounded up: it falls with the cube of the elements where the mesh is fitted to the contact, smooth
# or sharp (`tests/reference` has the measurement), and is constant on grids of straight lines.
TRUNCATION_SMOOTH, TRUNCATION_SHARP, TRUNCATION_SQUARE, TRUNCATION_GRID = 6e-3, 4e-2, 7e-4, 5e-3
# Meshes of fitted contacts for tolerances down to these. Largest measured errors of the force over
# smooth shapes (and of the stiffness of a cylinder) at 4, 6, 8 and 10 elements per contact radius:
# 1e-4 (1.1e-3), 2e-5 (2.7e-4), 1e-5 (9e-5), and below; a fifth of the tolerance is the aim.
FITTED_LEVELS = ((3e-3, (2, 3, 4)), (3e-4, (3, 4, 6)), (5e-5, (4, 6, 8)))
FINEST = (6, 8, 10)
# What is meshed with no, one and two planes of symmetry.
PARTS = ("", "half of ", "a quarter of ")
FAR = "outside it Boussinesq fields"


class FemSolver(Solver[G]):
    """Elastic bodies of hexahedra with a Boussinesq far field, condensed onto the surface."""

    span = 1e6  # each load scales the mesh onto its own contact

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        bodies = [table for table in (scene.half_space, scene.counter_body) if table is not None]
        nu = max(table.elastic_constants[1] for table in bodies)
        if nu > LARGEST_POISSON and not _quadratic(scene):
            raise Refused(
                f"nu = {nu:g} is incompressible and needs mixed 27-node elements, which this scene "
                "does not use; 8-node elements are limited to 0.4999"
            )
        if scene.loading.control == "mean_gap":
            raise Refused("no mean-gap control on this mesh: use bem_fft, or prescribe the force")
        unfit = options_problem(scene)
        if unfit:
            raise Refused(unfit)
        if scene.surface is not None and scene.surface.periodic:
            raise Refused("models a free patch, not a periodic half-space")


def meshes_both(scene: Scene) -> bool:
    """Whether both bodies get a mesh: an indenter with a counter body, and a coupling."""
    pair = scene.counter_body is not None and scene.indenter is not None
    return pair and scene.methods.fem.coupling != "effective_modulus"


class Fem(FemSolver[IndenterGeometry]):
    """Single contacts: a mesh around the contact, fitted to its edge or along straight sides."""

    name = "fem"

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.enforcement = enforcement_of(scene)
        self.points, self.solver = scene.methods.fem.points, scene.methods.fem.solver
        self.indenter = needed(scene.indenter, "single contacts only")
        self.straight = self.indenter.outline is not None
        self.stiff = scene.half_space.elastic_constants[1] > LARGEST_POISSON_ITERATED
        self.stretch = contact_stretch(self.indenter)

    @classmethod
    def takes(cls, scene: Scene) -> bool:
        """Rigid indenters on a half-space, and two elastic bodies put into one."""
        mesh_fits = scene.half_space.uniform and not meshes_both(scene)
        return mesh_fits and not scene.rough and scene.body is None

    def resolutions(self, geometry: IndenterGeometry) -> tuple[int, ...]:
        """Elements per contact radius."""
        tolerance = self.scene.compare.tolerance
        if self.straight:
            return punch_mesh.resolutions(self.indenter, fine=tolerance < 0.003)
        return next((levels for least, levels in FITTED_LEVELS if tolerance >= least), FINEST)

    def refusal(self, task: Task[IndenterGeometry]) -> str:
        if self.straight:
            number = punch_mesh.face_grid(task.geometry, task.resolution).unknowns
            most = punch_mesh.MOST_UNKNOWNS
            return f"about {number} unknowns, more than {most}" if number > most else ""
        return elongated(self.stretch)

    def memory(self, task: Task[IndenterGeometry]) -> float:
        """Bytes of the elimination, or of the factors in conjugate gradients."""
        mesh = self._mesh(task)
        if isinstance(mesh, fem.RingMesh) and self._linear_solver(mesh) == "conjugate_gradients":
            return bytes_of_iteration(mesh)
        return bytes_of_elimination(mesh)

    def model(self, geometry: IndenterGeometry) -> str:
        part = PARTS[sum(self.indenter.even)]
        fitted = "" if self.straight else ", scaled to each load"
        block = f"{part}a block of graded hexahedra around the contact{fitted}"
        chosen = self.solver
        solved = "condensed by nested dissection"
        if chosen == "conjugate_gradients":
            solved = "solved by conjugate gradients"
        elif chosen == "automatic" and not solver_problem(self.scene, "conjugate_gradients"):
            if self.stiff:
                stiff = f"nu above {LARGEST_POISSON_ITERATED:g}: many steps for conjugate gradients"
                solved += f" ({stiff})"
            else:
                most = f"{MOST_CONDENSED // 1000} 000 unknowns"
                solved += f" (above {most} solved by conjugate gradients)"
        return f"{block}; {FAR}; {solved}"

    def _linear_solver(self, mesh: fem.RingMesh | fem.TensorMesh) -> str:
        """Return the solver of a mesh: a factorisation where it fits into some gigabytes."""
        if self.solver != "automatic":
            return self.solver
        large = mesh.unknowns > MOST_CONDENSED and not self.stiff
        if large and not solver_problem(self.scene, "conjugate_gradients"):
            return "conjugate_gradients"
        return "nested_dissection"

    def rows(self, task: Task[IndenterGeometry]) -> Iterator[Row]:
        body = self.body(task)
        truncation = (
            TRUNCATION_SQUARE if punch_mesh.second_order(self.indenter) else TRUNCATION_GRID
        )
        if body.ring is not None:
            largest = TRUNCATION_SHARP if self._sharp(task.geometry) else TRUNCATION_SMOOTH
            truncation = largest / task.resolution**3

        def steps(loads: np.ndarray) -> Iterator[Step]:
            """Scale the mesh onto the edge of the contact at each load; a face has a fixed mesh."""
            points, shape = self.points, self.indenter.gap
            contacts: Iterator[tuple[fem.CondensedBody, fem.NodalContact]]
            load = LoadPath(task.loads.control, loads)
            if body.ring is None:
                pressed = body if points == "nodes" else fem.at_quadrature_points(body)
                gap = punch_mesh.face_gap(task.geometry, pressed.points)
                found = fem.press(pressed, gap, load, self.enforcement)
                contacts = ((pressed, contact) for contact in found)
            else:
                contacts = fem.indent(body, shape, load, self.enforcement, points=points)
            for scaled, contact in contacts:
                if body.ring is not None:
                    gap = shape(*scaled.points.T)
                # The face of a flat punch is known.
                face = self.indenter.face_area
                area = contact.contact_area if face is None else face
                inside = partial(recovered, scaled, contact.reactions)
                x, y = scaled.points.T
                axes = half_axes(task, x, y, contact.reactions)
                yield contact_step(
                    *(task, scaled, gap, contact, area), body_fields=inside, quantities=axes
                )

        yield Row(steps, unknowns=body.unknowns, truncation=truncation)

    def body(self, task: Task[IndenterGeometry]) -> fem.CondensedBody:
        """Return the half-space that fits the scene's contact."""
        mesh, material = self._mesh(task), fem.Material(*self.scene.elastic_constants)
        return fem.half_space_body(mesh, material, solver=self._linear_solver(mesh))

    def _mesh(self, task: Task[IndenterGeometry]) -> fem.RingMesh | fem.TensorMesh:
        geometry = task.geometry
        if self.straight:
            return punch_mesh.face_grid(geometry, task.resolution)
        # The size is arbitrary: a half-space has no length, and each load scales the mesh.
        return fem.RingMesh(
            geometry.contact_radius,
            elements=task.resolution,
            edge=geometry.contact_radius,
            sharp=self._sharp(geometry),
            stretch=self.stretch,
        )

    def _sharp(self, geometry: IndenterGeometry) -> bool:
        """Whether the pressure is singular at the edge of the contact, or nearly so."""
        return self.indenter.flat or self.indenter.flat_within > 0.3 * geometry.contact_radius


def enforcement_of(scene: Scene) -> fem.Enforcement:
    """Return how contact is enforced; an active set has no use for a penalty, which is not read."""
    options = scene.methods.fem
    if options.contact == "active_set":
        return fem.Enforcement(options.contact)
    return fem.Enforcement(options.contact, options.penalty)


def options_problem(scene: Scene) -> str:
    """Return why points or solver that a scene asks for cannot be had, or an empty text."""
    changes = scene.methods.fem.changes
    if "points" not in changes:
        return solver_problem(scene, changes.get("solver", "automatic"))
    if changes.get("contact") != "penalty":
        return 'points = "quadrature" takes contact = "penalty" only: there are more than nodes'
    if scene.indenter is None or scene.body is not None or scene.counter_body is not None:
        return 'points = "quadrature" is for a rigid indenter on a half-space'
    if changes.get("solver") == "conjugate_gradients":
        return 'points = "quadrature" needs a condensed body, no conjugate gradients'
    return solver_problem(scene, changes.get("solver", "automatic"))


def solver_problem(scene: Scene, solver: str) -> str:
    """Return why a linear solver cannot do the scene, or an empty text."""
    if scene.body is not None or solver != "conjugate_gradients":
        return ""
    if not _quadratic(scene) or (scene.indenter and scene.indenter.outline is not None):
        return f"solver {solver} is for single contacts on a mesh that is fitted to them"
    if scene.half_space.elastic_constants[1] > LARGEST_POISSON:
        return f"solver {solver} needs a definite matrix: nu up to {LARGEST_POISSON}"
    if "contact" in scene.methods.fem.changes:
        return "solver conjugate_gradients takes contact = active_set only"
    return ""


def _quadratic(scene: Scene) -> bool:
    """Whether the body is a half-space of 27-node elements, which have a mixed form."""
    if scene.indenter is None or scene.counter_body is not None or scene.body is not None:
        return False
    if scene.indenter.outline is not None:
        return punch_mesh.second_order(scene.indenter)
    return scene.indenter.quarter_symmetric


def contact_stretch(indenter: Indenter) -> tuple[float, float]:
    """Return how the contact ellipse deviates from the circle of equal area."""
    if isinstance(indenter, Ellipsoid):
        half_x, half_y = ellipsoid(indenter.radius_x, indenter.radius_y, 1.0).semi_axes(1.0)
    elif isinstance(indenter, EllipticPunch):
        half_x, half_y = indenter.semi_axes
    elif indenter.axisymmetric or indenter.outline is not None:
        return 1.0, 1.0
    else:
        raise Refused(f"no mesh is fitted to the contact of a {indenter.in_words}")
    ratio = float(np.sqrt(half_x / half_y))
    return ratio, 1 / ratio


def elongated(stretch: tuple[float, float]) -> str:
    """Return why a very elongated contact is out of reach, or an empty text."""
    longer = max(stretch) ** 2
    if longer <= LARGEST_ASPECT:
        return ""
    return f"a contact {longer:.0f} times as long as wide: elements are tested to {LARGEST_ASPECT}"
