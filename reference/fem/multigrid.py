"""Bodies from files by conjugate gradients: their compliance, column by column.

A column is found when a contact set reaches its candidate, preconditioned by a V-cycle of smoothed
aggregation with the rigid motions as near-null space (P. Vanek, J. Mandel & M. Brezina, Computing
56 (1996) 179; the hierarchy is PyAMG's). Memory and time of a column grow with the unknowns, those
of a factorisation with their powers 4/3 and 2.
"""

import numpy as np
from scipy import sparse
from scipy.linalg import cho_factor, cho_solve, pinvh

from reference.arrays import Array, Integers, Mask
from reference.fem.matrix_free import conjugate_gradients

COLUMN_TOLERANCE = 1e-8  # relative residual in the norm of the preconditioner
AT_ONCE = 32  # right-hand sides: matrices are read once for all of them
DAMPED = 1.5  # Jacobi's step over the inverse of the largest eigenvalue: converges below 2
COARSEST = 300  # unknowns that are solved at once


class MultigridFlexibility:
    """Response of a supported body, as `DenseFlexibility`, by columns found as they are needed.

    `iterations` are the steps of conjugate gradients by block of right-hand sides.
    """

    def __init__(
        self,
        matrices: Array,  # (elements, 3 n, 3 n), component fastest
        elements: Integers,  # (elements, n), nodes
        points: Array,  # (nodes, 3)
        free: Mask,  # (nodes, 3), not held; no rigid motion is left
        candidates: Integers,  # (c,), nodes that carry normal forces
    ) -> None:
        self.free = free.ravel()
        self.candidates = 3 * candidates + 2
        self.known = np.zeros(len(candidates), dtype=bool)
        self.compliance = np.zeros((len(candidates), len(candidates)))
        self.iterations: list[int] = []

        # the stiffness in 3 x 3 blocks of nodes; held components are left alone, on the diagonal
        count, nodes = elements.shape[1], len(points)
        numbers = elements.astype(np.int64)
        pairs = (numbers[:, :, None] * nodes + numbers[:, None, :]).ravel()
        places, sums = np.unique(pairs, return_inverse=True)
        rows, columns = np.divmod(places, nodes)
        blocks = np.empty((len(places), 3, 3))
        split = matrices.reshape(-1, count, 3, count, 3)
        for i, j in np.ndindex(3, 3):
            values = np.bincount(sums.ravel(), split[:, :, i, :, j].ravel(), len(places))
            blocks[:, i, j] = values * free[rows, i] * free[columns, j]
        diagonal = np.flatnonzero(rows == columns)
        scale = blocks[diagonal].max()
        blocks[diagonal] += scale * np.eye(3) * ~free[:, None, :]
        stiffness = sparse.bsr_matrix(
            (blocks, columns, np.searchsorted(rows, np.arange(nodes + 1))),
            shape=(3 * nodes, 3 * nodes),
        )

        # rigid motions of the free components: three shifts, three turns about the centre
        modes = np.zeros((nodes, 3, 6))
        modes[:, range(3), range(3)] = 1.0
        modes[:, :, 3:] = np.cross(np.eye(3)[:, None], points - points.mean(axis=0)).transpose(
            1, 2, 0
        )
        modes[~free] = 0.0
        import pyamg  # a tenth of a second, for those alone who come here

        hierarchy = pyamg.smoothed_aggregation_solver(
            stiffness,
            B=modes.reshape(-1, 6),
            strength=("symmetric", {"theta": 0.0}),
            smooth=("jacobi", {"omega": 4.0 / 3.0, "weighting": "local"}),
            presmoother=None,
            postsmoother=None,
            improve_candidates=None,
            max_coarse=COARSEST,
        )
        self.stiffness = stiffness.tocsr()
        # The preconditioner is in single precision: half of the memory to read.
        self.levels = []
        rng = np.random.default_rng(0)
        for level in hierarchy.levels[:-1]:
            matrix = level.A.tocsr()
            diagonal = matrix.diagonal()[:, None]
            inverse = 1.0 / np.where(diagonal > 0.0, diagonal, 1.0)
            vector = rng.standard_normal((len(inverse), 1))
            for _ in range(15):  # power iteration for the largest eigenvalue
                vector /= np.linalg.norm(vector)
                vector = inverse * (matrix @ vector)
            jacobi = DAMPED / np.linalg.norm(vector) * inverse
            parts = matrix, jacobi, level.P.tocsr(), level.P.T.tocsr()
            self.levels.append(tuple(part.astype(np.float32) for part in parts))
        self.coarsest = pinvh(hierarchy.levels[-1].A.toarray()).astype(np.float32)

    def respond(
        self, inside: Integers, right: Array, softness: Array | None = None
    ) -> tuple[Array, Array]:
        """Solve as `DenseFlexibility` does; new points of the contact set take a column each."""
        missing = inside[~self.known[inside]]
        for start in range(0, len(missing), AT_ONCE):
            block = missing[start : start + AT_ONCE]
            loads = np.zeros((len(self.free), len(block)))
            loads[self.candidates[block], np.arange(len(block))] = 1.0
            self.compliance[:, block] = self.solve(loads)[self.candidates]
            self.known[block] = True
            # symmetric between known points, not to the tolerance but to the bit
            among, across = np.ix_(self.known, block), np.ix_(block, self.known)
            mean = 0.5 * (self.compliance[among] + self.compliance[across].T)
            self.compliance[among], self.compliance[across] = mean, mean.T
        columns = self.compliance[:, inside]
        matrix = columns[inside]
        if softness is not None:
            matrix[np.diag_indices(len(inside))] += softness[inside]
        forces = cho_solve(cho_factor(matrix, lower=True, overwrite_a=True), right)
        return forces, columns @ forces

    def interior(self, reactions: Array) -> Array:
        """Solve as `DenseFlexibility` does, with one more solve."""
        loads = np.zeros((len(self.free), 1))
        loads[self.candidates, 0] = reactions
        return self.solve(loads)[self.free, 0]

    def solve(self, loads: Array) -> Array:
        """Return the displacements (3 nodes, k) under loads, by `conjugate_gradients`."""

        def cycle(residual: Array) -> Array:
            """Return the correction of a V-cycle: one step of damped Jacobi before, one after."""
            right, below = residual.astype(np.float32), []
            for matrix, jacobi, prolongation, restriction in self.levels:
                values = jacobi * right
                below.append((matrix, jacobi, prolongation, values, right))
                right = restriction @ (right - matrix @ values)
            correction = self.coarsest @ right
            for matrix, jacobi, prolongation, values, right in reversed(below):
                values += prolongation @ correction
                correction = values + jacobi * (right - matrix @ values)
            return correction.astype(float)

        solved, steps = conjugate_gradients(
            self.stiffness.__matmul__, cycle, loads, COLUMN_TOLERANCE
        )
        self.iterations.append(steps)
        return solved
