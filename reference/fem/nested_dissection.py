"""Condensation onto a few unknowns by nested dissection with dense fronts.

The elements are bisected recursively; on return, pairs of neighbouring groups are merged, and
unknowns without elements outside the merged group are eliminated by a dense Cholesky factorisation
(the multifrontal method: Duff & Reid 1983; George 1973 for the ordering). The result is the Schur
complement on the retained unknowns. The work is done by BLAS, so plain NumPy wheels reach the speed
of a compiled sparse solver on these problems, and the Schur complement needs no right-hand sides.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.linalg import cholesky, solve_triangular

LEAF_UNKNOWNS = 600
SMALLEST_PIVOT = 1e-9  # relative pivot of a determined mean stress, against rounding of 1e-16


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

    matrices: NDArray[np.float64]
    unknowns: NDArray[np.int64]
    boundary: NDArray[np.float64]
    first: int
    retained: NDArray[np.int64]
    centres: NDArray[np.float64]
    mean_stresses: NDArray[np.int64] = field(default_factory=lambda: np.zeros((0, 4), np.int64))


@dataclass(frozen=True, eq=False)
class Front:
    """One elimination: ``u[eliminated] = -sign L^-T W u[remaining]``; sign -1 for mean stresses."""

    eliminated: NDArray[np.int64]
    remaining: NDArray[np.int64]
    factor: NDArray[np.float64]
    coupling: NDArray[np.float64]
    sign: float


@dataclass(frozen=True, eq=False)
class Shift:
    """Change of unknowns: before it, `shifted` was the difference from the unknown `base`."""

    base: int
    shifted: NDArray[np.int64]


def condense(
    system: LinearSystem, exterior: NDArray[np.float64], fronts: list[Front | Shift] | None = None
) -> NDArray[np.float64]:
    """Return the stiffness (r, r) on the retained unknowns, in the order of `system.retained`.

    Parameters
    ----------
    system : LinearSystem
    exterior : (k, k)
        Stiffness of the unmeshed exterior on the far-field unknowns.
    fronts : list, optional
        Collects the eliminations for `expand`; by default they are dropped, which limits the memory
        to that of the largest fronts.

    Raises
    ------
    numpy.linalg.LinAlgError
        If the body is not supported (a rigid motion is free).
    """
    dissection = _Dissection(system, fronts)
    remaining, matrix = dissection.reduce(np.arange(len(system.matrices)))
    size = system.first + len(exterior)
    position = np.full(size, -1)
    position[remaining] = np.arange(len(remaining))
    modes = position[system.first :]
    matrix[np.ix_(modes, modes)] += exterior
    left, matrix = dissection.eliminate(remaining, matrix, remaining >= system.first)
    left, matrix = dissection.eliminate(left, matrix, dissection.indefinite[left], sign=-1.0)
    place = np.searchsorted(left, system.retained)
    return matrix[np.ix_(place, place)]


def expand(
    system: LinearSystem, fronts: list[Front | Shift], retained_values: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return all displacements from those of the retained unknowns, without other loads.

    Returns the values of the free unknowns followed by those of the boundary unknowns.
    """
    modes = system.boundary.shape[1]
    values = np.zeros(system.first + modes)
    values[system.retained] = retained_values
    for front in reversed(fronts):
        if isinstance(front, Shift):
            values[front.shifted] += values[front.base]
            continue
        coupled = front.coupling @ values[front.remaining]
        values[front.eliminated] = -front.sign * solve_triangular(
            front.factor, coupled, lower=True, trans="T", check_finite=False
        )
    return np.concatenate([values[: system.first], system.boundary @ values[system.first :]])


def forward(fronts: list[Front | Shift], loads: NDArray[np.float64]) -> None:
    """Eliminate the loads on eliminated unknowns of a definite system, in place.

    What is left on the retained ones is theirs to be solved for; `backward` does the rest.
    """
    for front in fronts:
        assert isinstance(front, Front)
        reduced = solve_triangular(
            front.factor, loads[front.eliminated], lower=True, check_finite=False
        )
        loads[front.eliminated] = reduced
        loads[front.remaining] -= front.coupling.T @ reduced


def backward(fronts: list[Front | Shift], values: NDArray[np.float64]) -> None:
    """Replace eliminated loads by displacements, where those of the retained unknowns are known."""
    for front in reversed(fronts):
        assert isinstance(front, Front)
        left = values[front.eliminated] - front.coupling @ values[front.remaining]
        values[front.eliminated] = solve_triangular(
            front.factor, left, lower=True, trans="T", check_finite=False
        )


class _Dissection:
    """The recursion with its common data."""

    def __init__(self, system: LinearSystem, fronts: list[Front | Shift] | None) -> None:
        self.system = system
        self.fronts = fronts
        total = system.first + system.boundary.shape[1]
        self.multiplicity = np.zeros(total, dtype=np.int64)
        free = system.unknowns[(system.unknowns >= 0) & (system.unknowns < system.first)]
        self.multiplicity[: system.first] = np.bincount(free, minlength=system.first)
        # one extra use, never completed by a group, keeps these unknowns to the top
        self.multiplicity[system.retained] += 1
        self.multiplicity[system.first :] = np.iinfo(np.int64).max
        self.indefinite = np.zeros(total, dtype=bool)
        self.indefinite[system.mean_stresses] = True
        self.constants = system.mean_stresses[:, 0]
        x, y, z = system.centres.T
        radius = np.hypot(x, y)
        self.keys = np.stack([z, radius, np.arctan2(y, x), x, y])
        size = system.matrices.shape[1]
        self.leaf_elements = max(2, LEAF_UNKNOWNS // size)

    def reduce(self, elements: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Return the unknowns shared with other groups, and the stiffness of the group on them."""
        if len(elements) <= self.leaf_elements:
            return self._leaf(elements)
        left, right = self._bisect(elements)
        first, second = self.reduce(left), self.reduce(right)
        names = np.union1d(first[0], second[0])
        return self._merge(names, [first, second], elements, [left[0], right[0]])

    def _uses(self, elements: NDArray[np.int64], names: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the numbers of elements of the group that use the given unknowns."""
        unknowns = self.system.unknowns[elements].ravel()
        place = np.minimum(np.searchsorted(names, unknowns), len(names) - 1)
        return np.bincount(place[names[place] == unknowns], minlength=len(names))

    def _merge(
        self,
        names: NDArray[np.int64],
        parts: list[tuple[NDArray[np.int64], NDArray[np.float64]]],
        elements: NDArray[np.int64],
        firsts: list[int] | NDArray[np.int64],
    ) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Add the parts of a group, and eliminate unknowns without elements outside it.

        `firsts` are the first elements of the parts, whose constants represent the mean stress of
        their part.
        """
        complete = self._uses(elements, names) == self.multiplicity[names]
        if not len(self.constants):
            order = np.argsort(~complete, kind="stable")
            matrix = _sum(names, parts, order)
            return self._eliminate_first(names[order], matrix, int(complete.sum()), 1.0)
        matrix = _sum(names, parts, np.arange(len(names)))
        base = int(self.constants[elements[0]])
        constants = np.setdiff1d(self.constants[firsts], base)
        self._shift(names, matrix, base, constants)
        # a group constrained on all sides carries any uniform mean stress: its base is kept
        finished = names[complete & (names != base)]
        kind = self.indefinite[finished]
        names, matrix = self.eliminate(names, matrix, np.isin(names, finished[~kind]))
        slopes = np.setdiff1d(finished[kind], self.constants)
        names, matrix = self.eliminate(names, matrix, np.isin(names, slopes), sign=-1.0)
        waiting = np.intersect1d(finished[kind], self.constants)
        try:
            return self.eliminate(names, matrix, np.isin(names, waiting), sign=-1.0)
        except np.linalg.LinAlgError:
            return names, matrix  # the parts are not connected yet: left to the next level

    def _shift(
        self,
        names: NDArray[np.int64],
        matrix: NDArray[np.float64],
        base: int,
        shifted: NDArray[np.int64],
    ) -> None:
        """Replace the constants of the parts by their differences from that of the group."""
        if self.fronts is not None:
            self.fronts.append(Shift(base, shifted))
        place, places = np.searchsorted(names, base), np.searchsorted(names, shifted)
        matrix[:, place] += matrix[:, places].sum(axis=1)
        matrix[place] += matrix[places].sum(axis=0)

    def eliminate(
        self,
        names: NDArray[np.int64],
        matrix: NDArray[np.float64],
        complete: NDArray[np.bool_],
        sign: float = 1.0,
    ) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Return the Schur complement after elimination of a definite block of the given sign.

        Raises
        ------
        numpy.linalg.LinAlgError
            If it is not definite; nothing is changed then.
        """
        count = int(complete.sum())
        if count == 0:
            return names, matrix
        order = np.argsort(~complete, kind="stable")
        return self._eliminate_first(names[order], matrix[order[:, None], order], count, sign)

    def _eliminate_first(
        self, names: NDArray[np.int64], matrix: NDArray[np.float64], count: int, sign: float
    ) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        if count == 0:
            return names, matrix
        block = sign * matrix[:count, :count]
        factor = cholesky(block, lower=True, check_finite=False)
        pivots = np.diag(factor) ** 2
        if sign < 0.0 and pivots.min() < SMALLEST_PIVOT * np.diag(block).max():
            raise np.linalg.LinAlgError("a mean stress is not determined yet")
        coupling = solve_triangular(factor, matrix[:count, count:], lower=True, check_finite=False)
        if self.fronts is not None:
            self.fronts.append(Front(names[:count], names[count:], factor, coupling, sign))
        return names[count:], matrix[count:, count:] - sign * (coupling.T @ coupling)

    def _leaf(self, elements: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        system = self.system
        names = np.unique(system.unknowns[elements])
        names = names[names >= 0]
        matrix = np.zeros((len(names) + 1, len(names) + 1))
        for element in elements:
            # zero displacements (-1) are summed in the last row, which is dropped
            rows = np.searchsorted(names, system.unknowns[element])
            rows[system.unknowns[element] < 0] = len(names)
            _add(matrix, rows, system.matrices[element])
        names, matrix = self._follow_far_field(names, matrix[:-1, :-1])
        return self._merge(names, [(names, matrix)], elements, elements)

    def _follow_far_field(
        self, names: NDArray[np.int64], matrix: NDArray[np.float64]
    ) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Replace boundary unknowns by the far-field unknowns that they follow."""
        first, boundary = self.system.first, self.system.boundary
        free = int(np.searchsorted(names, first))
        if free == len(names) or boundary.shape[1] == 0:
            return names[:free], matrix[:free, :free]
        shape = boundary[names[free:] - first]
        modes = boundary.shape[1]
        size = free + modes
        result = np.empty((size, size))
        result[:free, :free] = matrix[:free, :free]
        result[:free, free:] = matrix[:free, free:] @ shape
        result[free:, :free] = result[:free, free:].T
        result[free:, free:] = shape.T @ matrix[free:, free:] @ shape
        return np.concatenate([names[:free], first + np.arange(modes)]), result

    def _bisect(self, elements: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Return a split with the fewest shared unknowns and sizes within 1:2."""
        best, halves = np.inf, None
        for key in self.keys:
            for part in self._cuts(key[elements]):
                left, right = elements[part], elements[~part]
                shared = self._shared(left, right)
                cost = shared * (1.0 + abs(len(left) - len(right)) / len(elements))
                if cost < best:
                    best, halves = cost, (left, right)
        if halves is None:
            middle = len(elements) // 2
            return elements[:middle], elements[middle:]
        return halves

    def _cuts(self, key: NDArray[np.float64]) -> Iterator[NDArray[np.bool_]]:
        """Return the cut between layers nearest to the median."""
        ordered = np.sort(key)
        # the second term prevents cuts within a layer, whose elements differ by rounding
        least = 1e-6 * (ordered[-1] - ordered[0]) + 1e-9 * np.abs(ordered[[0, -1]]).max()
        steps = np.diff(ordered) > least
        places = np.flatnonzero(steps) + 1
        count = len(key)
        places = places[(places >= count // 4) & (places <= count - count // 4)]
        if len(places):
            place = places[np.argmin(np.abs(places - count / 2))]
            yield key < 0.5 * (ordered[place - 1] + ordered[place])

    def _shared(self, left: NDArray[np.int64], right: NDArray[np.int64]) -> int:
        marked = np.zeros(self.system.first + len(self.system.boundary) + 1, dtype=bool)
        marked[self.system.unknowns[left]] = True
        marked_right = np.zeros_like(marked)
        marked_right[self.system.unknowns[right]] = True
        return int(np.count_nonzero(marked & marked_right))


def _sum(
    names: NDArray[np.int64],
    parts: list[tuple[NDArray[np.int64], NDArray[np.float64]]],
    order: NDArray[np.int64],
) -> NDArray[np.float64]:
    """Return the sum of the matrices of parts, in a given order of unknowns."""
    place = np.empty(len(names), dtype=np.int64)
    place[order] = np.arange(len(names))
    matrix = np.zeros((len(names), len(names)))
    for part, block in parts:
        _add(matrix, place[np.searchsorted(names, part)], block)
    return matrix


@njit(cache=True)
def _add(matrix: NDArray[np.float64], rows: NDArray[np.int64], block: NDArray[np.float64]) -> None:
    """Add a block to the given rows and columns, several times faster than fancy indexing."""
    for i in range(len(rows)):
        for j in range(len(rows)):
            matrix[rows[i], rows[j]] += block[i, j]
