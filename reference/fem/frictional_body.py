"""A half-space of finite elements, reduced to the flexibility of all three displacements.

The counterpart of `body.CondensedBody` for contact with friction. The displacement of the total
force, Boussinesq's for its normal and Cerruti's for its tangential part, is prescribed on the outer
boundary; the error from higher moments decreases at least as (a/L)^2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import splu

from reference.arguments import count_faults, positive_faults, refuse
from reference.elasticity import LARGEST_POISSON_RATIO, Material
from reference.fem.element_stiffness import stiffness_matrices
from reference.fem.far_field import boussinesq
from reference.fem.mesh import GradedMesh, facet_nodes, growing_lines, ring_mesh

# Extent of contact candidates and fine rings, in contact radii.
_REACH = 1.25


@dataclass(frozen=True, eq=False)
class FrictionalBody:
    """Half of a half-space, y >= 0, under loads symmetric about y = 0.

    Attributes
    ----------
    points : (n, 2)
        Candidate contact points.
    compliance : (n, 3, n, 3)
        Displacement (x, y, z into the body) at the first point for a unit force at the second,
        including its far field; the mirrored half is loaded equally.
    held : (n,) bool
        Points on the plane of symmetry, which do not move normal to it.
    unknowns : int
    """

    points: NDArray[np.float64]
    compliance: NDArray[np.float64]
    fixed: NDArray[np.bool_]
    unknowns: int


def cerruti(points: NDArray[np.float64], poisson_ratio: float) -> NDArray[np.float64]:
    """Return the displacement for a unit force along x at the origin, unit Young's modulus.

    Cerruti 1882; Johnson 1985, eqs. (3.76).

    Parameters
    ----------
    points : (..., 3)
        Anywhere in the half-space z >= 0 except the origin.

    Examples
    --------
    On the surface, transverse to the force, ``u_x = (1 - nu)/(2 pi G r)`` with ``G = E/(2 (1 +
    nu))``:

    >>> u = cerruti(np.array([0.0, 2.0, 0.0]), 0.25)
    >>> round(float(u[0] * 2 * np.pi * 2.0), 12)
    1.875
    """
    x, y, z = np.moveaxis(np.asarray(points, dtype=float), -1, 0)
    r = np.sqrt(x * x + y * y + z * z)
    soft, beyond = 1 - 2 * poisson_ratio, r + z
    along = 1 / r + x * x / r**3 + soft * (1 / beyond - x * x / (r * beyond**2))
    across = x * y / r**3 - soft * x * y / (r * beyond**2)
    inwards = x * z / r**3 + soft * x / (r * beyond)
    return (1 + poisson_ratio) / (2 * np.pi) * np.stack([along, across, inwards], axis=-1)


def frictional_body(
    contact_radius: float, material: Material, *, elements: int = 4, extent: float = 5.0
) -> FrictionalBody:
    """Return a half-space for one round contact with friction.

    Parameters
    ----------
    contact_radius : float
        Largest contact radius; candidates extend a quarter further.
    material : Material
        nu <= 0.4999.
    elements : int
        27-node elements (two node spacings) per contact radius, at least 2.
    extent : float
        Radius and depth of the mesh in contact radii, at least 2.
    """
    faults = positive_faults(contact_radius=contact_radius) + count_faults(2, elements=elements)
    if material.incompressible:
        nu = material.poisson_ratio
        faults.append(f"poisson_ratio must be at most {LARGEST_POISSON_RATIO}, not {nu!r}")
    if not (np.isfinite(extent) and extent >= 2.0):
        faults.append(f"extent must be at least 2 contact radii, not {extent!r}")
    refuse(faults)
    grid = _mesh(elements, extent)
    mesh = grid.mesh
    nodes = facet_nodes(mesh, grid.surface)
    nodes = nodes[np.hypot(*mesh.p[:2, nodes]) <= _REACH * (1 + 1e-9)]
    compliance, unknowns = _condensed(grid, nodes, material.poisson_ratio)
    return FrictionalBody(
        points=mesh.p[:2, nodes].T * contact_radius,
        compliance=compliance / (material.youngs_modulus * contact_radius),
        fixed=mesh.p[1, nodes] == 0.0,
        unknowns=unknowns,
    )


def _mesh(elements: int, extent: float) -> GradedMesh:
    """Return a mesh with even rings up to the candidates' extent, growing beyond and with depth."""
    cells = max(1, round(0.5 * elements))
    size, growth = 0.5 / cells, 1.0 + 1.2 / np.sqrt(elements)
    inside = np.linspace(0.5, 1.0, cells + 1)
    further = 1.0 + size * np.arange(1, int(np.ceil((_REACH - 1.0) / size)) + 1)
    outer = growing_lines(further[-1], extent, growth * size, growth)[1:]
    rings = np.concatenate([inside, further, outer])
    depths = growing_lines(0.0, extent, 0.8 * size, growth)
    return ring_mesh(rings, depths, core_cells=cells, round_from=1.0, planes=(False, True))


def _condensed(
    grid: GradedMesh, nodes: NDArray[np.int64], poisson_ratio: float
) -> tuple[NDArray[np.float64], int]:
    """Return compliance (n, 3, n, 3) for unit modulus and lengths of the mesh, and the unknowns."""
    mesh = grid.mesh
    stiffness = _assembled(grid, poisson_ratio)
    outer = facet_nodes(mesh, grid.outer)
    kind = np.zeros((mesh.p.shape[1], 3), dtype=np.int64)  # 0 free, 1 prescribed, 2 held
    kind[outer] = 1
    kind[mesh.p[1] == 0.0, 1] = 2
    free, prescribed = (np.flatnonzero(kind.ravel() == code) for code in (0, 1))
    factor = splu(
        stiffness[free][:, free].tocsc(),
        permc_spec="MMD_AT_PLUS_A",  # the matrix is symmetric and positive definite
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
    place = np.full(kind.size, -1)
    place[free] = np.arange(len(free))
    contact = place[(3 * nodes[:, None] + np.arange(3)).ravel()]
    moves = contact >= 0
    loads = np.zeros((len(free), int(moves.sum())))
    loads[contact[moves], np.arange(loads.shape[1])] = 1.0
    compliance = np.zeros((contact.size, contact.size))
    compliance[np.ix_(moves, moves)] = factor.solve(loads)[contact[moves]]
    points = mesh.p.T[outer]
    for direction, field in (
        (0, cerruti(points, poisson_ratio)),
        (2, boussinesq(points, poisson_ratio)[0]),
    ):
        everywhere = np.zeros((mesh.p.shape[1], 3))
        everywhere[outer] = field
        response = factor.solve(-stiffness[free][:, prescribed] @ everywhere.ravel()[prescribed])
        far = np.zeros(contact.size)
        far[moves] = response[contact[moves]]
        # a force on this half and its mirror image: twice the total
        compliance[:, direction::3] += 2.0 * far[:, None]
    count = len(nodes)
    return compliance.reshape(count, 3, count, 3), len(free)


def _assembled(grid: GradedMesh, poisson_ratio: float) -> sparse.csr_array:
    """Return the stiffness matrix on all displacements, node by node."""
    matrices = stiffness_matrices(grid.mesh, poisson_ratio, reduced_integration=True)
    elements = grid.mesh.dofs.element_dofs.T
    dofs = (3 * elements[:, :, None] + np.arange(3)).reshape(len(elements), -1)
    size = dofs.shape[1]
    rows, columns = np.repeat(dofs, size, axis=1), np.tile(dofs, (1, size))
    total = 3 * grid.mesh.p.shape[1]
    entries = (matrices.ravel(), (rows.ravel(), columns.ravel()))
    return sparse.coo_array(entries, shape=(total, total)).tocsr()
