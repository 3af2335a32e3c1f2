"""Contact without a factorisation: conjugate gradients and smoothed aggregation (pyamg).

There is no condensation. A contact set is a set of prescribed displacements, and the few necessary
fields are solved one by one; loads in the span of previous right-hand sides need no solve. On a
mesh fitted to the contact edge the set never changes, and all depths of a paraboloid take two
solves (1 and r^2), so load curves are possible for bodies too large to factorise.
"""

from __future__ import annotations

import numpy as np
import pyamg
from numpy.typing import NDArray
from scipy.sparse import csr_array, csr_matrix

from reference.errors import ConvergenceError
from reference.fem.nested_dissection import LinearSystem
from reference.fem.sparse import stiffness_matrix

# Relative residual in the norm of the preconditioner. The force is stationary: its error is of the
# order of the square of that of the fields.
TOLERANCE = 2e-6
LARGEST_COUNT = 1000
IN_SPAN = 1e-7  # a right-hand side this close to a combination of solved ones is not solved again


class MultigridFlexibility:
    """Response of a body by preconditioned conjugate gradients.

    The preconditioner is one V-cycle of smoothed aggregation with the six rigid motions as
    near-null space (Vaněk, Mandel & Brezina 1996), with all connections strong, because the
    standard measure fails for the stretched cells near the edge, and the exact inverse on the few
    far-field unknowns.

    Parameters
    ----------
    system, exterior
        As for `condense`.
    positions : (first, 3)
        Positions of the free unknowns.
    components : (first,)
        Their directions, 0 to 2.
    """

    def __init__(
        self,
        system: LinearSystem,
        exterior: NDArray[np.float64],
        positions: NDArray[np.float64],
        components: NDArray[np.int64],
    ) -> None:
        self.system = system
        self.matrix: csr_array = stiffness_matrix(system, exterior)
        first = system.first
        body = csr_matrix(self.matrix[:first][:, :first])
        smoother = [("gauss_seidel", {"sweep": sweep}) for sweep in ("forward", "backward")]
        self.hierarchy = pyamg.smoothed_aggregation_solver(
            body,
            B=rigid_motions(positions, components),
            strength=("symmetric", {"theta": 0.0}),
            presmoother=smoother[0],
            postsmoother=smoother[1],
            max_coarse=300,
        )
        self.cycle = self.hierarchy.aspreconditioner(cycle="V")
        self.far = np.linalg.inv(self.matrix[first:][:, first:].toarray())
        self.iterations: list[int] = []
        self.solved: dict[bytes, tuple[NDArray[np.float64], NDArray[np.float64]]] = {}

    def respond(
        self, inside: NDArray[np.int64], right: NDArray[np.float64], softness: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Solve as in `Flexibility`, for rigid contact only.

        Raises
        ------
        ConvergenceError
            If conjugate gradients need more than a thousand steps.
        """
        if np.any(softness):
            raise ValueError("the multigrid path solves contact = 'active_set' only")
        nothing = np.zeros((len(inside), 0)), np.zeros((self.matrix.shape[0], 0))
        space = self.solved.get(inside.tobytes(), nothing)
        for column in right.T:
            space = self._with(inside, space, column)
        self.solved = {inside.tobytes(): space}  # contact sets rarely recur
        basis, fields = space
        weights = np.linalg.lstsq(basis, right, rcond=None)[0]
        images = self.matrix @ fields
        forces = images[self.system.retained[inside]]
        # with the work of the residual on the fields, the components of the forces in the basis,
        # including the total, have only the square of the error of the fields
        forces = forces + basis @ (fields.T @ images - basis.T @ forces)
        return forces @ weights, fields[self.system.retained] @ weights

    def interior(self, reactions: NDArray[np.float64]) -> NDArray[np.float64]:
        """Solve as in `Flexibility`, with one more solve."""
        load = np.zeros(self.matrix.shape[0])
        load[self.system.retained] = reactions
        values = self._solve(load, np.ones(len(load), dtype=bool))
        first = self.system.first
        return np.concatenate([values[:first], self.system.boundary @ values[first:]])

    def _with(
        self,
        inside: NDArray[np.int64],
        space: tuple[NDArray[np.float64], NDArray[np.float64]],
        column: NDArray[np.float64],
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Add the field of a prescribed displacement, unless it is a combination of known ones."""
        basis, fields = space
        remainder = column - basis @ np.linalg.lstsq(basis, column, rcond=None)[0]
        size = np.linalg.norm(remainder)
        if fields.shape[1] and size <= IN_SPAN * np.linalg.norm(column):
            return basis, fields
        remainder /= size
        field = np.zeros(self.matrix.shape[0])
        place = self.system.retained[inside]
        field[place] = remainder
        free = np.ones(len(field), dtype=bool)
        free[place] = False
        field += self._solve(-(self.matrix @ field), free)
        return np.column_stack([basis, remainder]), np.column_stack([fields, field])

    def _precondition(self, residual: NDArray[np.float64]) -> NDArray[np.float64]:
        first = self.system.first
        return np.concatenate([self.cycle @ residual[:first], self.far @ residual[first:]])

    def _solve(self, load: NDArray[np.float64], free: NDArray[np.bool_]) -> NDArray[np.float64]:
        """Solve for the free unknowns by conjugate gradients, others zero (Saad 2003, alg. 9.1)."""
        values = np.zeros_like(load)
        residual = np.where(free, load, 0.0)
        upward = np.where(free, self._precondition(residual), 0.0)
        direction, size = upward, residual @ upward
        history = [1.0]
        start = size
        while history[-1] > TOLERANCE and size > 0.0:
            if len(history) > LARGEST_COUNT:
                raise ConvergenceError("conjugate gradients did not converge", history)
            image = np.where(free, self.matrix @ direction, 0.0)
            step = size / (direction @ image)
            values += step * direction
            residual -= step * image
            upward = np.where(free, self._precondition(residual), 0.0)
            size, last = residual @ upward, size
            direction = upward + (size / last) * direction
            history.append(float(np.sqrt(max(size, 0.0) / start)))
        self.iterations.append(len(history) - 1)
        return values


def rigid_motions(
    positions: NDArray[np.float64], components: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Return three translations and rotations at unknowns of given positions and directions."""
    result = np.zeros((len(components), 6))
    result[np.arange(len(components)), components] = 1.0
    rotations = np.cross(np.eye(3)[:, None, :], positions[None])
    result[:, 3:] = np.take_along_axis(rotations, components[None, :, None], axis=2)[..., 0].T
    return result
