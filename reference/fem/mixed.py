"""Incompressible bodies: 27-node displacements with element-wise linear mean stress.

``int 2 mu eps(u) : eps(v) + s div v = f(v)`` and ``int t (div u - s / lambda) = 0`` for the mean
stress s = lambda div u, discontinuous and element-wise linear (Q2/P1; Boffi, Brezzi & Fortin
2013, *Mixed Finite Element Methods and Applications*, sec. 8.6.3: inf-sup stable, fourth order in
the force like the compressible element). With 1/lambda = 0 the body is exactly incompressible.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from skfem import MeshHex2

from reference.fem.element_stiffness import gauss_points, shape_gradients

STRESSES = 4  # mean-stress unknowns of an element: a constant, and three slopes
GAUSS = 3


def mixed_matrices(mesh: MeshHex2, poisson_ratio: float) -> NDArray[np.float64]:
    """Return symmetric indefinite matrices (elements, 81 + 4, 81 + 4) for unit Young's modulus.

    The displacements come first, component fastest, then the mean stresses.
    """
    shear = 0.5 / (1.0 + poisson_ratio)
    inverse_lame = (1.0 + poisson_ratio) * (1.0 - 2.0 * poisson_ratio) / poisson_ratio
    gradients, volumes = shape_gradients(mesh, GAUSS)
    count, _, nodes, _ = gradients.shape
    flat = gradients.reshape(count, -1, 3 * nodes)
    products = np.matmul((flat * volumes[..., None]).transpose(0, 2, 1), flat)
    split = products.reshape(count, nodes, 3, nodes, 3)
    size = 3 * nodes
    result = np.zeros((count, size + STRESSES, size + STRESSES))
    stiffness = shear * split.transpose(0, 1, 4, 3, 2)
    laplacian = shear * np.einsum("eakbk->eab", split)
    for component in range(3):
        stiffness[:, :, component, :, component] += laplacian
    result[:, :size, :size] = stiffness.reshape(count, size, size)
    modes = mean_stress_modes(mesh, GAUSS)
    coupling = np.einsum("eqi,eq,eqj->eij", flat, volumes, modes, optimize=True)
    result[:, :size, size:] = coupling
    result[:, size:, :size] = coupling.transpose(0, 2, 1)
    result[:, size:, size:] = -inverse_lame * np.einsum("eqi,eq,eqj->eij", modes, volumes, modes)
    return result


def mean_stress_modes(mesh: MeshHex2, per_direction: int) -> NDArray[np.float64]:
    """Return 1 and the coordinates relative to centre and size of the element at the Gauss points.

    Linear in space, not in local coordinates, which preserves the order on distorted cells.

    Returns
    -------
    (elements, points, 4)
    """
    points, _ = gauss_points(per_direction)
    element = mesh.elem()
    nodes = mesh.dofs.element_dofs
    shapes = np.array([element.lbasis(points, i)[0] for i in range(len(nodes))])
    corners = mesh.doflocs[:, nodes].transpose(2, 1, 0)
    places = np.matmul(shapes.T, corners)
    size = np.ptp(corners, axis=1)
    local = (places - corners.mean(axis=1)[:, None, :]) / size[:, None, :]
    return np.concatenate([np.ones((*local.shape[:2], 1)), local], axis=2)
