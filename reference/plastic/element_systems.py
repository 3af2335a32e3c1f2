"""Systems of element matrices that change from one step of Newton's method to the next."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import cho_factor, cho_solve
from scipy.sparse.linalg import SuperLU, splu

from reference.fem.condensation import Front, LinearSystem, Shift, backward, condense, forward

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

# When elements beyond the core change, it grows to this multiple of their distance.
_BEYOND = 1.25


class OrderedSystem:
    """A system whose pattern and order of elimination are found once for all matrices.

    `unknowns` (elements, n) are those of each element.
    """

    def __init__(self, unknowns: Integers) -> None:
        self.size = int(unknowns.max()) + 1
        _, rows, starts = self._places(unknowns)
        columns = np.repeat(np.arange(self.size), np.diff(starts))
        # of any matrix with these places: one that needs no pivots
        factor = self._factors(
            1.0 + (rows == columns) * rows.size, rows, starts, order="MMD_AT_PLUS_A"
        )
        self._rank = np.asarray(factor.perm_c, dtype=np.int64)
        self._pattern = self._places(self._rank[unknowns])

    def factorised(self, matrices: Array, spring: float) -> Callable[[Array], Array]:
        """Return what solves element matrices (elements, n, n), the last unknown on a spring."""
        rank, (place, rows, starts) = self._rank, self._pattern
        data = np.asarray(np.bincount(place, matrices.ravel(), rows.size), dtype=np.float64)
        last = slice(starts[rank[-1]], starts[rank[-1] + 1])
        data[last] += spring * (rows[last] == rank[-1])
        factor = self._factors(data, rows, starts, order="NATURAL")

        def solve(right: Array) -> Array:
            ranked = np.empty_like(right)
            ranked[rank] = right
            return np.asarray(factor.solve(ranked)[rank])

        return solve

    def _places(self, unknowns: Integers) -> tuple[Integers, Integers, Integers]:
        """Return where entries of element matrices go, rows of those places, starts of columns."""
        count = unknowns.shape[1]
        rows = np.repeat(unknowns, count, axis=1).ravel()
        columns = np.tile(unknowns, (1, count)).ravel()
        keys, place = np.unique(columns * self.size + rows, return_inverse=True)
        starts = np.searchsorted(keys, np.arange(self.size + 1) * self.size)
        return place, keys % self.size, starts

    def _factors(self, data: Array, rows: Integers, starts: Integers, *, order: str) -> SuperLU:
        return splu(
            sparse.csc_matrix((data, rows, starts), shape=(self.size, self.size)),
            permc_spec=order,
            relax=1,
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )


class CoredSystem:
    """A positive definite system of which only a core around the origin changes.

    The rest is condensed once, by nested dissection. `unknowns` (elements, n) are those of each
    element, `centres` (elements, 3) its place. Elements within `radius` are expected to change; it
    grows when others do.
    """

    def __init__(self, unknowns: Integers, centres: Array, radius: float) -> None:
        self.unknowns, self.centres = unknowns, centres
        self.size = int(unknowns.max()) + 1
        self._distance = np.linalg.norm(centres, axis=1)
        self._radius = radius
        self._outside = np.zeros(0)  # matrices beyond the core
        self._rest: tuple[Array, list[Front | Shift]] | None = None

    def factorised(self, matrices: Array, spring: float) -> Callable[[Array], Array]:
        """Return what solves element matrices (elements, n, n), the last unknown on a spring.

        The spring is added to them.

        Raises
        ------
        numpy.linalg.LinAlgError
            If it is not positive definite.
        """
        element, slot = np.argwhere(self.unknowns == self.size - 1)[0]
        matrices[element, slot, slot] += spring
        beyond = self._distance > self._radius
        changed = np.ones(np.count_nonzero(beyond), dtype=bool)
        if self._rest is not None:
            changed = (matrices[beyond] != self._outside).any(axis=(1, 2))
            if changed.any():
                furthest = float(self._distance[beyond][changed].max())
                self._radius = min(_BEYOND * furthest, 0.9 * float(self._distance.max()))
                beyond = self._distance > self._radius
        if self._rest is None or changed.any():
            self._rim = np.intersect1d(self.unknowns[~beyond], self.unknowns[beyond])
            self._outside = matrices[beyond]
            self._rest = self._condensed(matrices, beyond)
        core, fronts = self._condensed(matrices, ~beyond)
        outside, outer_fronts = self._rest
        top = cho_factor(core + outside, check_finite=False)
        rim = self._rim

        def solve(loads: Array) -> Array:
            values = np.array(loads)
            forward(fronts, values)
            forward(outer_fronts, values)
            values[rim] = cho_solve(top, values[rim], check_finite=False)
            backward(fronts, values)
            backward(outer_fronts, values)
            return values

        return solve

    def _condensed(
        self, matrices: Array, part: NDArray[np.bool_]
    ) -> tuple[Array, list[Front | Shift]]:
        """Return the stiffness of some elements on the rim, and their eliminations."""
        nothing, fronts = np.zeros((0, 0)), list[Front | Shift]()
        system = LinearSystem(
            matrices[part], self.unknowns[part], nothing, self.size, self._rim, self.centres[part]
        )
        return condense(system, fronts), fronts
