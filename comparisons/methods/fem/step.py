"""One load step on condensed finite elements, for every mesh; and the memory that a solve takes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

import numpy as np

from comparisons.methods import Step, Task
from comparisons.tasks.shown_loads import Fields, point_pressure
from reference import fem
from reference.fem.contact import radius_from_moments


def contact_step(
    task: Task,
    body: fem.CondensedBody,
    gap: np.ndarray,
    contact: fem.NodalContact,
    area: float,
    *,
    body_fields: Callable[[], Fields],
    quantities: Mapping[str, float] | None = None,
    fields: Mapping[str, np.ndarray] | None = None,
) -> Step:
    """Return the step of a solved contact; `area` is the best estimate of its contact area.

    `quantities` and `fields` are what this kind of contact has beside the common ones.
    """

    def arrays() -> dict[str, np.ndarray]:
        """Return what plots and pictures use."""
        shown = {"penetration": np.array(contact.penetration), **(fields or {})}
        if not task.wants_pressure:
            return shown
        return shown | {
            "pressure_x": body.points[:, 0],
            "pressure_y": body.points[:, 1],
            "pressure": contact.pressure,
            # The symmetric parts count with the one that is meshed.
            "pressure_weight": body.symmetry * body.weights,
            # Of two bodies: what the indenter's own surface gives way counts, too.
            "displacement": contact.displacement,
            "gap": gap - contact.penetration + contact.displacement,
        }

    values = {
        "penetration": contact.penetration,
        "force": contact.force,
        "contact_area": area,
        "contact_area_raw": contact.contact_area_raw,
        "stiffness": contact.stiffness,
        "energy": contact.energy,
    }
    return Step(
        values | dict(quantities or {}),
        iterations=contact.iterations,
        violation=contact.violation,
        pressure=partial(point_pressure, body.points, contact.pressure),
        fields=arrays,
        body_fields=body_fields,
    )


def recovered(
    body: fem.CondensedBody, forces: np.ndarray, frame: Mapping[str, np.ndarray] | None = None
) -> dict[str, np.ndarray]:
    """Return displacement and von Mises stress in a body under the forces on its surface."""
    inside = fem.recover(body, forces)
    return {
        "mesh_points": inside.points,
        "mesh_cells": inside.cells,
        "mesh_displacement": inside.displacement,
        "mesh_von_mises": inside.von_mises,
        **(frame or {}),
    }


def round_area(body: fem.CondensedBody, contact: fem.NodalContact) -> float:
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


# Bytes of whatever else a solve holds.
_BESIDE = 14e6
# Fronts of the elimination: this many matrices of the unknowns on the smallest section of a body
# that is as long as it is wide, and more in proportion of an elongated one.
_FRONTS = 9.5
# Dense matrices of the surface: stiffness, compliance, their factors.
_DENSE = 4
# Conjugate gradients: mesh and vectors for each unknown, and four sets of band factors in single
# precision, each for one of three components; a band is so many nodes around the contact wide. A
# tenth more is kept by the C library.
_VECTORS, _FACTORS, _BAND, _KEPT = 240.0, 16.0 / 3.0, 2.6, 1.1
# Algebraic multigrid: 3 x 3 blocks of the stiffness for each pair of nodes in an element, in double
# and in single precision, and the vectors of a block of right-hand sides for each node.
_NEIGHBOURS = {"hexahedron": 27, "hexahedron27": 64, "tetra": 15, "tetra10": 28}
_BLOCK, _BLOCK_VECTORS = 300.0, 10_000.0


def bytes_of_elimination(mesh: fem.RingMesh | fem.TensorMesh) -> float:
    """Return bytes of element matrices and fronts."""
    narrow, wide, long = _free(mesh)
    return bytes_of_elements(mesh) + bytes_of_fronts(3.0 * narrow * wide, long / wide) + _BESIDE


def bytes_of_elements(mesh: fem.RingMesh | fem.TensorMesh) -> float:
    """Return bytes of the element matrices."""
    size = 3 * (mesh.order + 1) ** 3
    return float(8.0 * size**2 * np.prod(_free(mesh)) / mesh.order**3)


def bytes_of_fronts(section: float, elongation: float = 1.0) -> float:
    """Return bytes of fronts, from the number of unknowns on the smallest section."""
    return _FRONTS * 8.0 * section**2 * elongation


def _free(mesh: fem.RingMesh | fem.TensorMesh) -> list[int]:
    """Return the sorted numbers of nodes in each direction but for the last, which are fixed."""
    across, along, down = mesh.lattice
    straight = isinstance(mesh, fem.TensorMesh)
    return sorted((across - straight, along - 1, down - 1))


def bytes_of_surface(points: int) -> float:
    """Return bytes of the dense matrices of so many points that may touch."""
    return _DENSE * 8.0 * float(points) ** 2


def bytes_of_iteration(mesh: fem.RingMesh) -> float:
    """Return bytes of mesh, vectors and band factors of conjugate gradients."""
    band = _BAND * mesh.lattice[0] + 1.0
    return _KEPT * mesh.unknowns * (_VECTORS + _FACTORS * band)


def bytes_of_multigrid(kind: str, nodes: int) -> float:
    """Return bytes of the sparse stiffness in three forms, of its hierarchy and the vectors."""
    return nodes * (_NEIGHBOURS[kind] * _BLOCK + _BLOCK_VECTORS) + _BESIDE
