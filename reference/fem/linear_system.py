"""From element matrices to a system of equations: which unknown every row of an element is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from skfem import MeshHex, MeshTet

from reference.fem.element_stiffness import STRESSES

Array = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class LinearSystem:
    """Element matrices with their unknowns.

    Attributes
    ----------
    matrices : (elements, size, size)
        None (0, size, size) where the stiffness is applied without them.
    unknowns : (elements, size)
        Number of the unknown of every row; -1 for zero displacements.
    boundary : (boundary unknowns, far-field unknowns)
        The displacement ``u[first + i] = boundary[i] @ q`` of the unknowns that follow far-field
        unknowns q, numbered last, from `first`.
    first : int
        Number of free unknowns.
    retained : (r,)
        The retained free unknowns.
    centres : (elements, 3)
        Element centres, for the bisection.
    mean_stresses : (elements, 4) or (0, 4)
        Free unknowns that make the system indefinite: the mean stresses of elements (a constant and
        three slopes) in a mixed form, which are among the `unknowns` of their element only.
    """

    matrices: Array
    unknowns: Integers
    boundary: Array
    first: int
    retained: Integers
    centres: Array
    mean_stresses: Integers = field(default_factory=lambda: np.zeros((0, STRESSES), np.int64))


def linear_system(
    mesh: MeshHex | MeshTet,
    matrices: Array,
    held: NDArray[np.bool_],
    retained: Integers,
    *,
    outer: Integers | None = None,
    fields: Sequence[Array] = (),
    stretch: tuple[float, float] = (1.0, 1.0),
) -> LinearSystem:
    """Return the system with unknowns numbered: free displacements, mean stresses, far field.

    Parameters
    ----------
    mesh
        With n nodes.
    matrices : (elements, size, size)
        Displacements component fastest, then the mean stresses of a mixed form.
    held : (n, 3) bool
        Zero displacements.
    retained : (r,)
        Free displacements, each as 3 node + component.
    outer : (m,), optional
        Nodes that follow the far field.
    fields : sequence of (m, 3)
        Their displacements for a unit of each far-field unknown.
    stretch : (float, float)
        Of the mesh. Centres are those before it: bisected along its ellipses, an elongated mesh
        takes a quarter less time and memory.
    """
    outer = np.zeros(0, dtype=np.int64) if outer is None else outer
    follows = np.zeros_like(held)
    follows[outer] = True
    follows &= ~held
    free = ~held & ~follows
    elements = mesh.dofs.element_dofs.T
    displacements = int(free.sum())
    # in a mixed form the element matrices also have rows for the mean stress
    mixed = matrices.shape[1] > 3 * elements.shape[1]
    stresses = np.arange(len(elements) * STRESSES * mixed).reshape(-1, STRESSES) + displacements
    first = displacements + stresses.size
    number = np.full(held.shape, -1, dtype=np.int64)
    number[free] = np.arange(displacements)
    number[follows] = first + np.arange(follows.sum())
    boundary = np.zeros((int(follows.sum()), len(fields)))
    for column, values in zip(boundary.T, fields, strict=True):
        everywhere = np.zeros(held.shape)
        everywhere[outer] = values
        column[:] = everywhere[follows]
    unknowns = number[elements].reshape(len(elements), -1)
    return LinearSystem(
        matrices=matrices,
        unknowns=np.hstack([unknowns, stresses]) if mixed else unknowns,
        boundary=boundary,
        first=first,
        retained=number.ravel()[retained],
        centres=mesh.p[:, mesh.t].mean(axis=1).T / np.append(stretch, 1.0),
        mean_stresses=stresses,
    )


def stiffness_matrix(system: LinearSystem, exterior: Array) -> sparse.csr_array:
    """Return the sparse symmetric matrix on the free unknowns, followed by the far-field unknowns.

    Boundary displacements are replaced by the far-field unknowns that they follow; `exterior`
    (k, k) is the stiffness of the unmeshed exterior on these.
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
        zero = sparse.csr_array((system.first, system.first))
        matrix = follow.T @ matrix @ follow
        matrix = sparse.csr_array(matrix + sparse.block_diag([zero, exterior], format="csr"))
    matrix.sort_indices()
    return matrix
