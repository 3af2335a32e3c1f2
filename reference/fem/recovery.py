"""Displacements and stresses inside the body, for plots and files."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from skfem import MeshHex, MeshTet
from skfem.element import ElementHex1, ElementHex2

from reference.elasticity import lame_parameters, largest_shear, von_mises
from reference.fem.body import CondensedBody
from reference.fem.element_stiffness import (
    element_order,
    gauss_points,
    shape_gradients,
    simplex_points,
)
from reference.fem.mixed import mean_stress_modes

# corners of a hexahedron in the order of VTK (and meshio), as lattice offsets
VTK_CORNERS = np.array(
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
)


@dataclass(frozen=True, eq=False)
class Fields:
    """Nodal fields of the meshed part, in consistent units.

    Attributes
    ----------
    points : (m, 3)
        z points into the half-space.
    cells : (k, 8) or (k, 4)
        Corner numbers in VTK order of hexahedra (a 27-node element gives eight) or tetrahedra.
    displacement : (m, 3)
    stress : (m, 6)
        xx, yy, zz, yz, xz, xy; tension positive.
    von_mises : (m,)
    largest_shear : (m,)
        Half the difference of the extreme principal stresses.
    """

    points: NDArray[np.float64]
    cells: NDArray[np.int64]
    displacement: NDArray[np.float64]
    stress: NDArray[np.float64]
    von_mises: NDArray[np.float64]
    largest_shear: NDArray[np.float64]


def recover(body: CondensedBody, reactions: ArrayLike) -> Fields:
    """Return displacement and stress at all mesh nodes for given nodal contact forces.

    The elimination is repeated, keeping its factors (at the cost of the first condensation, and the
    memory of the factors). Stresses are evaluated at the reduced Gauss points, where they are most
    accurate (Barlow 1976), extrapolated to the nodes and averaged by volume.

    Parameters
    ----------
    body : CondensedBody
    reactions : (n,)
        `Contact.reactions`.

    Raises
    ------
    ValueError
        If `reactions` does not have one finite value per candidate.
    """
    body, reactions = body.at_nodes(reactions)
    unit = body.youngs_modulus * body.length * body.length
    values = body.flexibility.interior(reactions / unit)
    displacement = _displacement(body, values)
    stress = _nodal_stress(body, displacement, values) * body.youngs_modulus
    points = body.grid.mesh.p.T.copy()
    points[:, :2] += body.offset
    return Fields(
        points=points * body.length,
        cells=_cells(body.grid.mesh),
        displacement=displacement * body.length,
        stress=stress,
        von_mises=von_mises(stress),
        largest_shear=largest_shear(stress),
    )


def _displacement(body: CondensedBody, values: NDArray[np.float64]) -> NDArray[np.float64]:
    numbers = np.full((body.grid.mesh.p.shape[1], 3), -1, dtype=np.int64)
    elements = body.grid.mesh.dofs.element_dofs.T
    unknowns = body.system.unknowns[:, : 3 * elements.shape[1]]
    numbers[elements] = unknowns.reshape(*elements.shape, 3)
    return np.where(numbers >= 0, values[numbers], 0.0)


def _nodal_stress(
    body: CondensedBody, displacement: NDArray[np.float64], values: NDArray[np.float64]
) -> NDArray[np.float64]:
    mesh = body.grid.mesh
    per_direction = element_order(mesh) + isinstance(mesh, MeshTet)
    elements = mesh.dofs.element_dofs.T
    gradients, volumes = shape_gradients(mesh, per_direction)
    gradient = np.einsum("eqaj,eai->eqij", gradients, displacement[elements], optimize=True)
    strain = 0.5 * (gradient + np.swapaxes(gradient, -1, -2))
    if len(body.system.mean_stresses):
        shear = 0.5 / (1.0 + body.poisson_ratio)
        modes = mean_stress_modes(mesh, per_direction)
        mean = np.einsum("eqj,ej->eq", modes, values[body.system.mean_stresses])
    else:
        lame, shear = lame_parameters(body.poisson_ratio)
        mean = lame * np.trace(strain, axis1=-2, axis2=-1)
    stress = 2.0 * shear * strain + mean[..., None, None] * np.eye(3)
    at_points = stress[..., [0, 1, 2, 1, 0, 0], [0, 1, 2, 2, 2, 1]]
    at_nodes = np.einsum("nq,eqs->ens", _extrapolation(mesh), at_points)
    weights = np.broadcast_to(volumes.sum(axis=1)[:, None], elements.shape).ravel()
    total = np.bincount(elements.ravel(), weights)
    columns = [
        np.bincount(elements.ravel(), weights * at_nodes[..., s].ravel()) / total for s in range(6)
    ]
    return np.stack(columns, axis=1)


def _extrapolation(mesh: MeshHex | MeshTet) -> NDArray[np.float64]:
    """Return values at element nodes from those at Gauss points (tensor Lagrange, or linear)."""
    locations = mesh.elem.doflocs
    if element_order(mesh) == 1:
        return np.ones((len(locations), 1))
    if isinstance(mesh, MeshTet):
        points = _barycentric(simplex_points(2)[0].T)
        return np.asarray(np.linalg.solve(points.T, _barycentric(locations).T).T, dtype=float)
    line = np.unique(gauss_points(2)[0][0])
    toward = (locations - line[0]) / (line[1] - line[0])
    factors = np.stack([1.0 - toward, toward], axis=1)
    return np.einsum("ni,nj,nk->nijk", factors[..., 0], factors[..., 1], factors[..., 2]).reshape(
        len(locations), -1
    )


def _barycentric(points: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.column_stack([1.0 - points.sum(axis=1), points])


def _cells(mesh: MeshHex | MeshTet) -> NDArray[np.int64]:
    """Return elements, or the eight sub-cells of 27-node ones, as VTK cells of positive volume."""
    if isinstance(mesh, MeshTet):
        cells, swapped = np.asarray(mesh.dofs.element_dofs[:4].T), [0, 2, 1, 3]
    else:
        cells, swapped = _hexahedra(mesh), [4, 5, 6, 7, 0, 1, 2, 3]
    corners = mesh.p.T[cells]
    edges = corners[:, [1, 2, 3] if isinstance(mesh, MeshTet) else [1, 3, 4]] - corners[:, [0]]
    inverted = np.linalg.det(edges) < 0.0
    cells[inverted] = cells[inverted][:, swapped]
    return cells


def _hexahedra(mesh: MeshHex) -> NDArray[np.int64]:
    order = element_order(mesh)
    element = ElementHex2 if order == 2 else ElementHex1
    lattice = np.empty((mesh.t.shape[1],) + (order + 1,) * 3, dtype=np.int64)
    i, j, k = np.round(order * element.doflocs.T).astype(int)
    lattice[:, i, j, k] = mesh.dofs.element_dofs.T
    cells = []
    for start in np.ndindex(order, order, order):
        i, j, k = (np.array(start) + VTK_CORNERS).T
        cells.append(lattice[:, i, j, k])
    return np.concatenate(cells)
