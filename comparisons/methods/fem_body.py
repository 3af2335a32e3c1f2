"""How the method `fem` solves a user's body: its own mesh, its own supports.

Resolution N: every edge of the user's cells is cut into N parts; 1 is the mesh as it came.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from comparisons.geometry.bodies import BodyGeometry
from comparisons.methods.base import Solution, Task
from comparisons.methods.sweeps import outcomes
from comparisons.scene.options import FemOptions
from comparisons.tasks.shown_loads import point_pressure
from reference import fem
from reference.errors import ConvergenceError
from reference.fem.contact_area import radius_from_moments
from reference.fem.elasticity import LARGEST_POISSON_RATIO
from reference.fem.solid_mesh import SolidMesh
from reference.fem.supported_body import (
    LARGEST_POISSON_LINEAR_TETRAHEDRA,
    contact_nodes,
    supported_body,
)

# A minute of elimination on one core; memory is asked for apart.
MOST_UNKNOWNS = 80_000
# Refinement that the plan chooses by itself stays within some ten seconds.
USUAL_UNKNOWNS = 30_000
LEVELS = (1, 2, 4)
# Nodes that may touch: their dense compliance costs the cube.
MOST_CANDIDATES = 3_000


def unknowns(geometry: BodyGeometry, resolution: int) -> int:
    """Return about how many unknowns the mesh has."""
    return 3 * len(geometry.solid.points) * resolution**3


def resolutions(geometry: BodyGeometry) -> tuple[int, ...]:
    """Return the mesh as it is, and its refinements as far as they stay small."""
    return tuple(n for n in LEVELS if n == 1 or unknowns(geometry, n) <= USUAL_UNKNOWNS)


def unsuited(geometry: BodyGeometry, poisson_ratio: float) -> str:
    """Return why the user's cells cannot have this Poisson ratio, or an empty text."""
    linear = geometry.solid.kind.simplex and geometry.solid.kind.order == 1
    largest = LARGEST_POISSON_LINEAR_TETRAHEDRA if linear else LARGEST_POISSON_RATIO
    if poisson_ratio <= largest:
        return ""
    cells = "linear tetrahedra, which lock," if linear else "a user's cells"
    return f"nu = {poisson_ratio:g}: {cells} go to {largest}"


def refused(geometry: BodyGeometry, resolution: int) -> str:
    """Return why a refinement is out of reach, or an empty text."""
    if resolution & (resolution - 1):
        return f"every cell is halved again and again: N must be 1, 2, 4, ..., got {resolution}"
    count = unknowns(geometry, resolution)
    if count > MOST_UNKNOWNS:
        return f"about {count} unknowns, more than {MOST_UNKNOWNS}"
    return ""


def model(geometry: BodyGeometry) -> str:
    """Say what is solved."""
    cells = f"{len(geometry.solid.cells)} {geometry.solid.kind.name} cells"
    parts = geometry.symmetric_parts
    share = f", one of {parts} equal parts" if parts > 1 else ""
    return f"the body of the file, {cells}{share}, held by its supports; no far field"


def solve(task: Task) -> Solution:
    """Condense the body once, then press it load by load."""
    solution = Solution.empty(task)
    with solution.setup():
        body, gap, edge = _body(task)
    solution.unknowns = body.unknowns
    options = task.options
    assert isinstance(options, FemOptions)

    def sweep(loads: np.ndarray) -> Iterator[fem.Contact]:
        how = {"contact": options.contact, "penalty": options.penalty}
        for contact in fem.press(body, gap, **{task.loads.control: loads}, **how):
            if contact.active.any() and gap[contact.active].max() > edge:
                raise ConvergenceError("the contact is larger than the nodes that may touch")
            yield contact

    last: fem.Contact | None = None
    for step, outcome in enumerate(outcomes(sweep, task.loads.values, ConvergenceError)):
        if isinstance(outcome, ConvergenceError):
            solution.fail((0, step), outcome.reason)
            continue
        solution.put((0, step), _quantities(task, body, outcome))
        solution.iterations[0, step] = outcome.iterations
        solution.violation[0, step] = outcome.violation
        if task.wants_pressure:
            build = partial(point_pressure, body.points, outcome.pressure)
            solution.keep((0, step), build)
        last = outcome if step == len(task.loads.values) - 1 else None
    if last is not None:
        solution.fields = _fields(task, body, gap, last)
        if task.with_body:
            solution.body_fields = partial(_body_fields, task, body, last)
    return solution


def _refined(geometry: BodyGeometry, resolution: int) -> tuple[SolidMesh, np.ndarray, np.ndarray]:
    """Return the mesh, the faces that may touch and the held components at a resolution."""
    mesh, numbers = geometry.solid, np.arange(len(geometry.solid.points))
    faces = [geometry.surface, *(each.faces for each in geometry.supports)]
    while resolution > 1:
        mesh, renumbered, faces = mesh.refined(*faces)
        numbers, resolution = renumbered[numbers], resolution // 2
    return mesh, faces[0], geometry.held(mesh, numbers, faces[1:])


def _body(task: Task) -> tuple[fem.CondensedBody, np.ndarray, float]:
    """Return the condensed body, the gap at its candidates, and that of the nearest node left out.

    The gap is that of the indenter plus what the surface itself lies below its highest point;
    penetration counts from first touch.
    """
    geometry = task.geometry
    assert isinstance(geometry, BodyGeometry)
    mesh, surface, held = _refined(geometry, task.resolution)
    nodes = contact_nodes(mesh, surface)
    x, y, depth = mesh.points[nodes].T
    gap = geometry.indenter.gap(x * (1 - 1e-9), y * (1 - 1e-9))  # a node on a sharp edge belongs
    if not geometry.flat_surface:
        gap = gap + depth
        gap = gap - gap.min()
    edge = np.inf
    if len(nodes) > MOST_CANDIDATES:
        order = np.argsort(gap, kind="stable")
        edge = float(gap[order[MOST_CANDIDATES]])
        kept = np.sort(order[:MOST_CANDIDATES])
        nodes, gap = nodes[kept], gap[kept]
    modulus, nu = task.scene.half_space.elastic_constants
    body = supported_body(
        mesh, surface, held, modulus, nu, symmetry=geometry.symmetric_parts, nodes=nodes
    )
    return body, gap, edge


def round_area(body: fem.CondensedBody, contact: fem.Contact) -> float:
    """Return the area of a round contact on a plane.

    From the radius that the moments of the pressure give, where it agrees with the nodes that
    touch; else their tributary area, uncertain by half a spacing all round.
    """
    if not contact.active.any():
        return contact.contact_area
    radii = np.hypot(*body.points.T)
    radius = radius_from_moments(radii, contact.reactions)
    spacing = np.sqrt(body.weights[contact.active].max())
    if radius is None or abs(radius - radii[contact.active].max()) > spacing:
        return contact.contact_area
    return float(np.pi * radius**2)


def _area(geometry: BodyGeometry, body: fem.CondensedBody, contact: fem.Contact) -> float:
    indenter = geometry.indenter
    if not (indenter.axisymmetric and geometry.flat_surface):
        return contact.contact_area
    return indenter.area if indenter.flat else round_area(body, contact)


def _quantities(task: Task, body: fem.CondensedBody, contact: fem.Contact) -> dict[str, float]:
    geometry = task.geometry
    assert isinstance(geometry, BodyGeometry)
    area = _area(geometry, body, contact)
    values = {
        "penetration": contact.penetration,
        "force": contact.force,
        "contact_area": area,
        "contact_area_raw": contact.contact_area_raw,
        "equivalent_radius": float(np.sqrt(area / np.pi)),
        "stiffness": contact.stiffness,
        "contact_length_stiffness": contact.stiffness / task.scene.effective_modulus,
        "energy": contact.energy,
    }
    if geometry.indenter.axisymmetric and geometry.flat_surface:
        values["contact_radius"] = values["equivalent_radius"]
    return values


def _fields(
    task: Task, body: fem.CondensedBody, gap: np.ndarray, contact: fem.Contact
) -> dict[str, np.ndarray]:
    fields = {"penetration": np.array(contact.penetration)}
    if not task.wants_pressure:
        return fields
    return fields | {
        "pressure_x": body.points[:, 0],
        "pressure_y": body.points[:, 1],
        "pressure": contact.pressure,
        "pressure_weight": body.symmetry * body.weights,
        "displacement": contact.displacement,
        "gap": gap - contact.penetration + contact.displacement,
    }


def _body_fields(task: Task, body: fem.CondensedBody, contact: fem.Contact) -> dict:
    """Return fields in the frame of the contact, and the frame of the file for the VTU."""
    recovered = fem.recover(body, contact.reactions)
    geometry = task.geometry
    assert isinstance(geometry, BodyGeometry)
    return {
        "mesh_points": recovered.points,
        "mesh_cells": recovered.cells,
        "mesh_displacement": recovered.displacement,
        "mesh_von_mises": recovered.von_mises,
        "mesh_axes": geometry.axes,
        "mesh_origin": geometry.origin,
    }
