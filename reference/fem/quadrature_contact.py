"""Contact at the Gauss points of the surface elements instead of their nodes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from reference.fem.body import CondensedBody
from reference.fem.flexibility import DenseFlexibility
from reference.fem.mesh import facet_quadrature


def at_quadrature_points(body: CondensedBody, per_direction: int = 3) -> CondensedBody:
    """Return the body with the Gauss points of its candidate surface as candidates.

    With a penalty eps the pressure at a point is ``eps <d - g - u>`` and the nodal forces are its
    moments ``int N_i p dA`` (Wriggers 2006, *Computational Contact Mechanics*, sec. 9.1): in the
    terms of the points, ``(N C N^T + 1/(eps w)) R = d - g``, the problem that `press` solves. A
    uniform pressure then gives exactly the consistent nodal forces, and gaps inside the elements
    are considered. There are more points than nodes, so rigid contact ("active_set") is undefined:
    `press` accepts "penalty" only, with the gap at the `points` of the result. Interior fields and
    energies follow as for nodal contact (`recover`).

    Parameters
    ----------
    body : CondensedBody
        A body with condensed compliance, not of conjugate gradients.
    per_direction : int
        Gauss points per direction of a surface element.

    Raises
    ------
    ValueError
        For a body without condensation, or fewer than one point.
    """
    if body.nodal is not None:
        raise ValueError("contact at quadrature points needs a body with nodes as candidates")
    if not isinstance(body.flexibility, DenseFlexibility):
        raise ValueError(
            "contact at quadrature points needs a condensed body, got solver conjugate_gradients"
        )
    if int(per_direction) != per_direction or per_direction < 1:
        raise ValueError(f"per_direction must be a positive integer, got {per_direction!r}")
    mesh = body.grid.mesh
    place = np.full(mesh.doflocs.shape[1], -1)
    place[body.nodes] = np.arange(len(body.nodes))
    nodes, shapes, points, areas = facet_quadrature(mesh, body.grid.surface, per_direction)
    covered = (place[nodes] >= 0).all(axis=1)
    count = int(covered.sum()) * shapes.shape[1]
    interpolation = np.zeros((count, len(body.nodes)))
    columns = np.repeat(place[nodes[covered]], shapes.shape[1], axis=0)
    values = np.tile(shapes.T, (int(covered.sum()), 1))
    interpolation[np.arange(count)[:, None], columns] = values
    return replace(
        body,
        scaled_points=points[covered, :, :2].reshape(-1, 2) + body.offset,
        scaled_weights=np.abs(areas[covered, :, 2]).ravel(),
        scaled_compliance=interpolation @ body.scaled_compliance @ interpolation.T,
        ring=None,
        nodal=body,
        interpolation=interpolation,
    )
