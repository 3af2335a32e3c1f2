"""Displacements and stresses inside the body, for plots and files."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from skfem import MeshHex, MeshTet
from skfem.element import ElementHex1, ElementHex2

from reference.elasticity import lame_parameters, largest_shear, von_mises
from reference.fem.condensed_body import CondensedBody
from reference.fem.element_stiffness import (
    element_order,
    gauss_rule,
    mean_stress_modes,
    shape_gradients,
    simplex_points,
)

Array = NDArray[np.float64]

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
    von_mises, largest_shear : (m,)
        The latter is half the difference of the extreme principal stresses.
    """

    points: Array
    cells: NDArray[np.int64]
    displacement: Array
    stress: Array
    von_mises: Array
    largest_shear: Array


def recover(body: CondensedBody, reactions: ArrayLike) -> Fields:
    """Return displacement and stress at all mesh nodes for given nodal contact forces (n,).

    The elimination is repeated, keeping its factors (at the cost of the first condensation, and the
    memory of the factors). Stresses are evaluated at the reduced Gauss points, where they are most
    accurate (Barlow 1976), extrapolated to the nodes and averaged by volume.
    """
    body, reactions = body.at_nodes(reactions)
    mesh, elements = body.grid.mesh, body.grid.mesh.dofs.element_dofs.T
    values = body.flexibility.interior(
        reactions / (body.youngs_modulus * body.length * body.length)
    )
    numbers = np.full((mesh.p.shape[1], 3), -1, dtype=np.int64)
    unknowns = body.system.unknowns[:, : 3 * elements.shape[1]]
    numbers[elements] = unknowns.reshape(*elements.shape, 3)
    displacement = np.where(numbers >= 0, values[numbers], 0.0)

    # stress at the Gauss points, over Young's modulus
    per_direction = element_order(mesh) + isinstance(mesh, MeshTet)
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
    tensor = 2.0 * shear * strain + mean[..., None, None] * np.eye(3)
    at_points = tensor[..., [0, 1, 2, 1, 0, 0], [0, 1, 2, 2, 2, 1]]

    # its mean, linear or tensor Lagrange interpolation at the nodes of the elements
    locations = mesh.elem.doflocs
    if element_order(mesh) == 1:
        extrapolation = np.ones((len(locations), 1))
    elif isinstance(mesh, MeshTet):
        at_gauss, at_all = (
            np.column_stack([1.0 - points.sum(axis=1), points])
            for points in (simplex_points(2)[0].T, locations)
        )
        extrapolation = np.linalg.solve(at_gauss.T, at_all.T).T
    else:
        line = gauss_rule(2, 1)[0][0]
        toward = (locations - line[0]) / (line[1] - line[0])
        x, y, z = np.stack([1.0 - toward, toward], axis=1).transpose(2, 0, 1)
        extrapolation = np.einsum("ni,nj,nk->nijk", x, y, z).reshape(len(locations), -1)
    at_nodes = np.einsum("nq,eqs->ens", extrapolation, at_points)
    weights = np.broadcast_to(volumes.sum(axis=1)[:, None], elements.shape).ravel()
    total = np.bincount(elements.ravel(), weights)
    columns = [
        np.bincount(elements.ravel(), weights * at_nodes[..., s].ravel()) / total for s in range(6)
    ]
    stress = np.stack(columns, axis=1) * body.youngs_modulus

    points = mesh.p.T.copy()
    points[:, :2] += body.offset
    return Fields(
        points=points * body.length,
        cells=_vtk_cells(mesh),
        displacement=displacement * body.length,
        stress=stress,
        von_mises=von_mises(stress),
        largest_shear=largest_shear(stress),
    )


def _vtk_cells(mesh: MeshHex | MeshTet) -> NDArray[np.int64]:
    """Return elements, or the eight sub-cells of 27-node ones, as VTK cells of positive volume."""
    order = element_order(mesh)
    if isinstance(mesh, MeshTet):
        cells, spanning, mirror = np.asarray(mesh.dofs.element_dofs[:4].T), [1, 2, 3], [0, 2, 1, 3]
    else:
        lattice = np.empty((mesh.t.shape[1],) + (order + 1,) * 3, dtype=np.int64)
        i, j, k = np.round(order * (ElementHex1, ElementHex2)[order - 1].doflocs.T).astype(int)
        lattice[:, i, j, k] = mesh.dofs.element_dofs.T
        blocks = []
        for start in np.ndindex(order, order, order):
            i, j, k = (np.array(start) + VTK_CORNERS).T
            blocks.append(lattice[:, i, j, k])
        cells, spanning, mirror = np.concatenate(blocks), [1, 3, 4], [4, 5, 6, 7, 0, 1, 2, 3]
    corners = mesh.p.T[cells]
    inverted = np.linalg.det(corners[:, spanning] - corners[:, [0]]) < 0.0
    cells[inverted] = cells[inverted][:, mirror]
    return cells
