"""Systems of elements of which only a core changes: the rest is condensed once."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from reference.fem.nested_dissection import (
    Front,
    LinearSystem,
    Shift,
    backward,
    condense,
    forward,
)

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
Condensed = tuple[Array, list[Front | Shift]]

# When elements beyond the core change, it grows to this multiple of their distance.
_BEYOND = 1.25


class Cored:
    """A positive definite system of elements around the origin.

    Parameters
    ----------
    unknowns : ndarray of int, shape (elements, n)
    centres : ndarray, shape (elements, 3)
    radius : float
        Radius within which elements are expected to change; it grows when others do.
    """

    def __init__(self, unknowns: Integers, centres: Array, radius: float) -> None:
        self.unknowns, self.centres = unknowns, centres
        self.size = int(unknowns.max()) + 1
        self._distance = np.linalg.norm(centres, axis=1)
        self._radius = radius
        self._rest: Condensed | None = None
        self._matrices = np.zeros(0)

    def factorised(self, matrices: Array) -> Callable[[Array], Array]:
        """Return what solves the system of element matrices.

        Raises
        ------
        numpy.linalg.LinAlgError
            If it is not positive definite.
        """
        self._condense_rest(matrices)
        assert self._rest is not None
        core = self._condensed(matrices, self._distance <= self._radius)
        top = cho_factor(core[0] + self._rest[0], check_finite=False)
        parts = core[1], self._rest[1]
        rim = self._rim

        def solve(loads: Array) -> Array:
            values = np.array(loads)
            for fronts in parts:
                forward(fronts, values)
            values[rim] = cho_solve(top, values[rim], check_finite=False)
            for fronts in parts:
                backward(fronts, values)
            return values

        return solve

    def _condense_rest(self, matrices: Array) -> None:
        """Condense all but the core, unless that is done; grow the core over what changed."""
        beyond = self._distance > self._radius
        if self._rest is not None:
            changed = (matrices[beyond] != self._matrices).any(axis=(1, 2))
            if not changed.any():
                return
            furthest = float(self._distance[beyond][changed].max())
            self._radius = min(_BEYOND * furthest, 0.9 * float(self._distance.max()))
            beyond = self._distance > self._radius
        self._rim = np.intersect1d(self.unknowns[~beyond], self.unknowns[beyond])
        self._matrices = matrices[beyond]
        self._rest = self._condensed(matrices, beyond)

    def _condensed(self, matrices: Array, part: NDArray[np.bool_]) -> Condensed:
        """Return the stiffness of some elements on the rim, and their eliminations."""
        nothing, fronts = np.zeros((0, 0)), list[Front | Shift]()
        system = LinearSystem(
            matrices[part],
            self.unknowns[part],
            nothing,
            self.size,
            self._rim,
            self.centres[part],
        )
        return condense(system, nothing, fronts), fronts
