"""The stiffness matrix of a body as one sparse matrix."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from reference.fem.nested_dissection import LinearSystem


def stiffness_matrix(system: LinearSystem, exterior: NDArray[np.float64]) -> sparse.csr_array:
    """Return the symmetric matrix on the free unknowns, followed by the far-field unknowns.

    Boundary displacements are replaced by the far-field unknowns that they follow.

    Parameters
    ----------
    system : LinearSystem
    exterior : (k, k)
        Stiffness of the unmeshed exterior on the far-field unknowns.
    """
    unknowns = system.unknowns
    size = unknowns.shape[1]
    rows = np.repeat(unknowns, size, axis=1).ravel()
    columns = np.tile(unknowns, (1, size)).ravel()
    inside = (rows >= 0) & (columns >= 0)
    total = system.first + len(system.boundary)
    entries = (system.matrices.ravel()[inside], (rows[inside], columns[inside]))
    matrix = sparse.coo_array(entries, shape=(total, total)).tocsr()
    if len(exterior):
        follow = sparse.block_diag([sparse.eye_array(system.first), system.boundary], format="csr")
        matrix = follow.T @ matrix @ follow
        zero = sparse.csr_array((system.first, system.first))
        matrix = matrix + sparse.block_diag([zero, exterior], format="csr")
    matrix = sparse.csr_array(matrix)
    matrix.sort_indices()
    return matrix
