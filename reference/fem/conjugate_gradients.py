"""Contact without a factorisation: conjugate gradients on the whole body, nothing condensed.

A contact set is a set of prescribed displacements, and the few necessary fields are solved one by
one; loads in the span of previous right-hand sides need no solve. On a mesh fitted to the contact
edge the set never changes, and all depths of a paraboloid take two solves (1 and r^2).

The stiffness is never assembled (`extruded`), and the preconditioner knows the contact
(`separated`): two million unknowns take 2 GB.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from reference.errors import ConvergenceError
from reference.fem.extruded import ExtrudedStiffness, Lattice
from reference.fem.mesh import GradedMesh
from reference.fem.nested_dissection import LinearSystem
from reference.fem.separated import SeparatedInverse

Array = NDArray[np.float64]

# Relative residual in the norm of the preconditioner. The force is stationary: its error is of the
# order of the square of that of the fields.
TOLERANCE = 1e-7
LARGEST_COUNT = 1000
IN_SPAN = 1e-7  # a right-hand side this close to a combination of solved ones is not solved again


class _Span(NamedTuple):
    """Prescribed displacements (k, m) that are solved, and their fields and forces (size, m)."""

    basis: Array
    fields: Array
    images: Array


class IterativeFlexibility:
    """Response of a half-space by preconditioned conjugate gradients.

    Vectors are the displacements of all nodes (3, n, levels), flat and zero where nothing is free,
    followed by the far-field unknowns, whose block is inverted exactly.

    Parameters
    ----------
    system : LinearSystem
        Its matrices are not used.
    exterior : (k, k)
        Stiffness of the unmeshed exterior on the far-field unknowns.
    grid : GradedMesh
    stiffness : ExtrudedStiffness
    lattice : Lattice
        Of the grid.
    """

    def __init__(
        self,
        system: LinearSystem,
        exterior: Array,
        grid: GradedMesh,
        stiffness: ExtrudedStiffness,
        lattice: Lattice,
    ) -> None:
        self.system, self.exterior, self.stiffness = system, exterior, stiffness
        elements = grid.mesh.dofs.element_dofs.T
        numbers = np.empty((grid.mesh.p.shape[1], 3), dtype=np.int64)
        numbers[elements] = system.unknowns.reshape(*elements.shape, 3)
        self.numbers = np.moveaxis(numbers[lattice.nodes], 2, 0)
        unknowns = self.numbers.ravel()
        free = (unknowns >= 0) & (unknowns < system.first)
        self.free = np.append(free, np.ones(len(exterior), dtype=bool))
        self.following = np.flatnonzero(unknowns >= system.first)
        self.boundary = system.boundary[unknowns[self.following] - system.first]
        place = np.empty(system.first, dtype=np.int64)
        place[unknowns[free]] = np.flatnonzero(free)
        self.candidates = place[system.retained]
        self.inverse = SeparatedInverse(stiffness, free.reshape(self.numbers.shape))
        modes = np.eye(len(self.free), len(exterior), k=-len(free))
        self.far = np.zeros_like(exterior)
        if len(exterior):
            self.far[:] = np.linalg.inv([self._image(mode)[len(free) :] for mode in modes.T])
        self.iterations: list[int] = []
        self.solved: dict[bytes, _Span] = {}

    def respond(
        self, inside: NDArray[np.int64], right: NDArray[np.float64], softness: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Solve as in `Flexibility`, for rigid contact only.

        Raises
        ------
        ConvergenceError
            If conjugate gradients break down, or need more than a thousand steps.
        """
        if np.any(softness):
            raise ValueError("conjugate gradients solve contact = 'active_set' only")
        nothing = np.zeros((len(self.free), 0))
        span = self.solved.get(inside.tobytes())
        span = span or _Span(np.zeros((len(inside), 0)), nothing, nothing)
        for column in right.T:
            span = self._with(inside, span, column)
        self.solved = {inside.tobytes(): span}  # contact sets rarely recur
        basis, fields, images = span
        weights = np.linalg.lstsq(basis, right, rcond=None)[0]
        forces = images[self.candidates[inside]]
        # with the work of the residual on the fields, the components of the forces in the basis,
        # including the total, have only the square of the error of the fields
        forces = forces + basis @ (fields.T @ images - basis.T @ forces)
        return forces @ weights, fields[self.candidates] @ weights

    def interior(self, reactions: NDArray[np.float64]) -> NDArray[np.float64]:
        """Solve as in `Flexibility`, with one more solve."""
        load = np.zeros(len(self.free))
        load[self.candidates] = reactions
        whole = self._whole(self._solve(load, self.free)).ravel()
        numbers = self.numbers.ravel()
        values = np.empty(self.system.first + len(self.boundary))
        values[numbers[numbers >= 0]] = whole[numbers >= 0]
        return values

    def _with(self, inside: NDArray[np.int64], span: _Span, column: Array) -> _Span:
        """Add the field of a prescribed displacement, unless it is a combination of known ones."""
        basis, fields, images = span
        column = column / _unit(column)
        remainder = column - basis @ np.linalg.lstsq(basis, column, rcond=None)[0]
        size = np.linalg.norm(remainder)
        if size <= IN_SPAN * np.linalg.norm(column):
            return span
        remainder /= size
        field = np.zeros(len(self.free))
        place = self.candidates[inside]
        field[place] = remainder
        free = self.free.copy()
        free[place] = False
        field += self._solve(-self._image(field), free)
        columns = (basis, remainder), (fields, field), (images, self._image(field))
        return _Span(*(np.column_stack(pair) for pair in columns))

    def _whole(self, values: Array) -> Array:
        """Return the displacements (3, n, levels) of all nodes, those at the boundary included."""
        size = self.numbers.size
        field = values[:size].copy()
        field[self.following] = self.boundary @ values[size:]
        return field.reshape(self.numbers.shape)

    def _image(self, values: Array) -> Array:
        """Return the stiffness times displacements."""
        forces = (self.stiffness @ self._whole(values)).ravel()
        far = values[len(forces) :]
        followed = self.boundary.T @ forces[self.following] + self.exterior @ far
        return np.where(self.free, np.concatenate([forces, followed]), 0.0)

    def _precondition(self, residual: Array, free: NDArray[np.bool_]) -> Array:
        size = self.numbers.size
        load = residual[:size].reshape(self.numbers.shape)
        touching = (self.free & ~free)[:size].reshape(load.shape)[2, :, 0]
        moved = self.inverse(load, touching).ravel()
        return np.concatenate([moved, self.far @ residual[size:]])

    def _solve(self, load: Array, free: NDArray[np.bool_]) -> Array:
        """Solve for the free unknowns by conjugate gradients, others zero (Saad 2003, alg. 9.1)."""
        values = np.zeros_like(load)
        residual = np.where(free, load, 0.0)
        unit = _unit(residual)
        residual /= unit
        direction = upward = self._precondition(residual, free)
        size = start = float(residual @ upward)
        history = [1.0]
        while residual.any() and not history[-1] <= TOLERANCE:
            if not size > 0.0:  # NaN, or a preconditioner that rounding made indefinite
                raise ConvergenceError("conjugate gradients broke down", history)
            if len(history) > LARGEST_COUNT:
                raise ConvergenceError("conjugate gradients did not converge", history)
            image = np.where(free, self._image(direction), 0.0)
            step = size / (direction @ image)
            values += step * direction
            residual -= step * image
            upward = self._precondition(residual, free)
            size, last = float(residual @ upward), size
            direction = upward + (size / last) * direction
            history.append(float(np.sqrt(size / start)) if size > 0.0 else np.nan)
        self.iterations.append(len(history) - 1)
        return values * unit


def _unit(values: Array) -> float:
    """Return the power of two of the largest value, 1 of none: units that round nothing.

    The preconditioner is in single precision, which has no numbers below 1e-45.
    """
    largest = np.abs(values).max(initial=0.0)
    return float(np.ldexp(1.0, np.frexp(largest)[1] - 1)) if 0.0 < largest < np.inf else 1.0
