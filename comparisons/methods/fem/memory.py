"""Memory that the plan expects of a finite-element solve, from the mesh lines alone.

`roughline bench fem` measures the same (rows "memory of").
"""

from __future__ import annotations

import numpy as np

from reference import fem

# Bytes of whatever else a solve holds.
_BESIDE = 14e6
# Fronts of the elimination: this many matrices of the unknowns on the smallest section of a body
# that is as long as it is wide, and more in proportion of an elongated one.
_FRONTS = 9.5
# Dense matrices of the surface: stiffness, compliance, their factors.
_DENSE = 4
# Conjugate gradients: mesh and vectors for each unknown, and four sets of band factors in single
# precision, each for one of three components; a band is so many nodes around the contact wide.
_VECTORS, _FACTORS, _BAND = 240.0, 16.0 / 3.0, 2.6
# Algebraic multigrid: 3 x 3 blocks of the stiffness for each pair of nodes in an element, in double
# and in single precision, and the vectors of a block of right-hand sides for each node.
_NEIGHBOURS = {"hexahedron": 27, "hexahedron27": 64, "tetra": 15, "tetra10": 28}
_BLOCK, _BLOCK_VECTORS = 300.0, 10_000.0


def of_elimination(mesh: fem.RingMesh | fem.TensorMesh) -> float:
    """Return bytes of element matrices and fronts."""
    narrow, wide, long = _free(mesh)
    return of_elements(mesh) + fronts(3.0 * narrow * wide, long / wide) + _BESIDE


def of_elements(mesh: fem.RingMesh | fem.TensorMesh) -> float:
    """Return bytes of the element matrices."""
    size = 3 * (mesh.order + 1) ** 3
    return float(8.0 * size**2 * np.prod(_free(mesh)) / mesh.order**3)


def fronts(section: float, elongation: float = 1.0) -> float:
    """Return bytes of fronts, from the number of unknowns on the smallest section."""
    return _FRONTS * 8.0 * section**2 * elongation


def _free(mesh: fem.RingMesh | fem.TensorMesh) -> list[int]:
    """Return the sorted numbers of nodes in each direction but for the last, which are fixed."""
    across, along, down = mesh.lattice
    straight = isinstance(mesh, fem.TensorMesh)
    return sorted((across - straight, along - 1, down - 1))


def of_surface(points: int) -> float:
    """Return bytes of the dense matrices of so many points that may touch."""
    return _DENSE * 8.0 * float(points) ** 2


def of_iteration(mesh: fem.RingMesh) -> float:
    """Return bytes of mesh, vectors and band factors of conjugate gradients."""
    band = _BAND * mesh.lattice[0] + 1.0
    return mesh.unknowns * (_VECTORS + _FACTORS * band)


def of_multigrid(kind: str, nodes: int) -> float:
    """Return bytes of the sparse stiffness in three forms, of its hierarchy and the vectors."""
    return nodes * (_NEIGHBOURS[kind] * _BLOCK + _BLOCK_VECTORS) + _BESIDE
