"""The method `fem` for a user's body: its own mesh and supports.

Resolution N divides every edge of the user's cells into N parts; 1 is the original mesh.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from comparisons.geometry.bodies import BodyGeometry
from comparisons.methods import NoAnswerError, Row, Scene, Step, Task
from comparisons.methods.fem.indenter import FemSolver, enforcement_of
from comparisons.methods.fem.step import (
    bytes_of_fronts,
    bytes_of_multigrid,
    contact_step,
    recovered,
    round_area,
)
from reference.elasticity import LARGEST_POISSON_RATIO
from reference.fem import Material, press
from reference.fem.condensed_body import LARGEST_POISSON_LINEAR_TETRAHEDRA, supported_body
from reference.fem.solid_mesh import SolidMesh, SupportedMesh, contact_nodes
from reference.loads import LoadPath

# Unknowns times nodes in contact, whose compliance conjugate gradients find in some ten minutes at
# most (docs/finite-elements.md has the measurement).
MOST_ITERATED = 2e8
# Refinement that the plan chooses by itself stays within some ten seconds.
PLANNED_UNKNOWNS = 30_000
LEVELS = (1, 2, 4)
# Nodes that may touch: their dense compliance costs the cube.
MOST_CANDIDATES = 3_000


def unknowns(geometry: BodyGeometry, resolution: int) -> int:
    """Return about how many unknowns the mesh has."""
    return 3 * len(geometry.solid.points) * resolution**3


class FemBody(FemSolver[BodyGeometry]):
    """The body of a file on its own mesh, with the boundary conditions of its supports."""

    name = "fem"
    bodies = True
    most_factorised = 200_000  # a minute of elimination on one core; memory is asked for apart
    # A column takes twice the steps at 0.45, four times at 0.49 and ten times at 0.499.
    largest_poisson = 0.49
    iteration = "conjugate gradients with algebraic multigrid"

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.enforcement, self.solver = enforcement_of(scene), scene.methods.fem.solver

    @classmethod
    def takes(cls, scene: Scene) -> bool:
        return scene.body is not None

    def resolutions(self, geometry: BodyGeometry) -> tuple[int, ...]:
        """Return the mesh as it is, and its refinements as far as they stay small."""
        return tuple(n for n in LEVELS if n == 1 or unknowns(geometry, n) <= PLANNED_UNKNOWNS)

    def refusal(self, task: Task[BodyGeometry]) -> str:
        nu, kind = self.scene.elastic_constants[1], task.geometry.solid.kind
        linear = kind.simplex and kind.order == 1
        largest = LARGEST_POISSON_LINEAR_TETRAHEDRA if linear else LARGEST_POISSON_RATIO
        if nu > largest:
            cells = "linear tetrahedra, which lock," if linear else "a user's cells"
            return f"nu = {nu:g}: {cells} go to {largest}"
        n, count = task.resolution, unknowns(task.geometry, task.resolution)
        if n & (n - 1):
            return f"every cell is halved again and again: N must be 1, 2, 4, ..., got {n}"
        if self.linear_solver(count) == "nested_dissection":
            most = self.most_factorised
            return f"about {count} unknowns, more than {most}" if count > most else ""
        geometry = task.geometry
        nodes = contact_nodes(geometry.solid, geometry.surface)
        # about: the nodes of the file's mesh that overlap at most
        overlap = _gap(geometry, geometry.solid, nodes) <= geometry.penetration
        touching = n**2 * int(np.count_nonzero(overlap))
        if count * touching > MOST_ITERATED:
            return f"about {count} unknowns, and {touching} nodes in contact: hours"
        return ""

    def memory(self, task: Task[BodyGeometry]) -> float:
        """Bytes of element matrices, and of the elimination or of multigrid."""
        solid, finer = task.geometry.solid, task.resolution**3
        elements = 72.0 * solid.cells.shape[1] ** 2 * len(solid.cells) * finer
        if self.linear_solver(unknowns(task.geometry, task.resolution)) == "conjugate_gradients":
            return elements + bytes_of_multigrid(solid.kind.name, len(solid.points) * finer)
        return elements + bytes_of_fronts(3.0 * (len(solid.points) * finer) ** (2 / 3))

    def model(self, geometry: BodyGeometry) -> str:
        cells = f"{len(geometry.solid.cells)} {geometry.solid.kind.name} cells"
        parts = geometry.symmetric_parts
        share = f", one of {parts} equal parts" if parts > 1 else ""
        body = f"the body of the file, {cells}{share}, held by its supports; no far field"
        return f"{body}; {self.solved()}"

    def rows(self, task: Task[BodyGeometry]) -> Iterator[Row]:
        """Condense the body once; penetration counts from first touch."""
        solver = self.linear_solver(unknowns(task.geometry, task.resolution))
        geometry = task.geometry
        resolution = task.resolution
        mesh, numbers = geometry.solid, np.arange(len(geometry.solid.points))
        faces = [geometry.surface, *(support.faces for support in geometry.supports)]
        while resolution > 1:
            mesh, renumbered, faces = mesh.refined(*faces)
            numbers, resolution = renumbered[numbers], resolution // 2
        surface, *held = faces
        fixed = geometry.fixed_components(mesh, numbers, held)
        nodes = contact_nodes(mesh, surface)
        gap = _gap(geometry, mesh, nodes)
        edge = np.inf  # the gap at the nearest node left out
        if len(nodes) > MOST_CANDIDATES:
            order = np.argsort(gap, kind="stable")
            edge = float(gap[order[MOST_CANDIDATES]])
            nearest = np.sort(order[:MOST_CANDIDATES])
            nodes, gap = nodes[nearest], gap[nearest]
        modulus, nu = task.scene.half_space.elastic_constants
        body = supported_body(
            SupportedMesh(mesh, surface, fixed),
            Material(modulus, nu),
            symmetry=geometry.symmetric_parts,
            nodes=nodes,
            solver=solver,
        )
        # the fields are in the frame of the contact; the VTU is in that of the file
        frame = {"mesh_axes": geometry.axes, "mesh_origin": geometry.origin}

        def steps(loads: np.ndarray) -> Iterator[Step]:
            start = None
            if body.iterative is not None and task.loads.control == "force":
                # every node that a contact set passes takes a column: begin near the answer
                start = gap <= geometry.penetrations[len(task.loads.values) - len(loads)]
            load = LoadPath(task.loads.control, loads)
            for contact in press(body, gap, load, self.enforcement, start=start):
                if contact.active.any() and gap[contact.active].max() > edge:
                    raise NoAnswerError("the contact is larger than the nodes that may touch")
                area, indenter = contact.contact_area, geometry.indenter
                if indenter.axisymmetric and geometry.flat_surface:
                    face = indenter.face_area
                    area = round_area(body, contact) if face is None else face
                inside = partial(recovered, body, contact.reactions, frame)
                yield contact_step(task, body, gap, contact, area, body_fields=inside)

        yield Row(steps, unknowns=body.unknowns)


def _gap(geometry: BodyGeometry, mesh: SolidMesh, nodes: np.ndarray) -> np.ndarray:
    """Return the gap of the indenter plus what the surface lies below its highest point."""
    x, y, depth = mesh.points[nodes].T
    gap = geometry.indenter.gap(x * (1 - 1e-9), y * (1 - 1e-9))  # a node on a sharp edge belongs
    if not geometry.flat_surface:
        gap = gap + depth
        gap = gap - gap.min()
    return gap
