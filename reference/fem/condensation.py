"""From element matrices to the stiffness of a few unknowns: numbering, then nested dissection.

The elements are bisected recursively; on return, pairs of neighbouring groups are merged, and
unknowns without elements outside the merged group are eliminated by a dense Cholesky factorisation
(the multifrontal method: Duff & Reid 1983; George 1973 for the ordering). The result is the Schur
complement on the retained unknowns. The work is done by BLAS, so plain NumPy wheels reach the speed
of a compiled sparse solver on these problems, and the Schur complement needs no right-hand sides.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numba import njit
from scipy.linalg import cholesky, solve_triangular
from skfem import MeshHex, MeshTet

from reference.arrays import Array, Integers, Mask
from reference.fem.element_stiffness import STRESSES

# Unknowns of a group of elements, ascending, and the stiffness of the group on them.
Group = tuple[Integers, Array]

LEAF_UNKNOWNS = 600
SMALLEST_PIVOT = 1e-9  # relative pivot of a determined mean stress, against rounding of 1e-16


@dataclass(frozen=True, eq=False, kw_only=True)
class LinearSystem:
    """Element matrices with their unknowns.

    Free unknowns come first. Of those at the boundary the displacement follows far-field unknowns
    q, which are numbered last: ``u[first + i] = boundary[i] @ q``; `exterior` is the stiffness of
    what is not meshed on these, without which they are retained, too, after the others.
    """

    matrices: Array  # (elements, size, size); none where the stiffness is applied without them
    unknowns: Integers  # (elements, size), number of the unknown of every row; -1: held
    # (boundary unknowns, far-field unknowns)
    boundary: Array = field(default_factory=lambda: np.zeros((0, 0)))
    first: int  # number of free unknowns
    retained: Integers  # (r,), the retained free unknowns
    centres: Array  # (elements, 3), of the elements, for the bisection
    exterior: Array | None = None  # (k, k)
    # (elements, 4) free unknowns that make the system indefinite: the mean stresses of elements (a
    # constant and three slopes) in a mixed form, among the unknowns of their element only
    mean_stresses: Integers = field(default_factory=lambda: np.zeros((0, STRESSES), np.int64))


def linear_system(
    mesh: MeshHex | MeshTet,
    matrices: Array,  # displacements component fastest, then the mean stresses of a mixed form
    held: Mask,  # (n, 3): zero displacements
    retained: Integers,  # (r,): free displacements, each as 3 node + component
    *,
    outer: Integers | None = None,  # (m,): nodes that follow the far field
    fields: Sequence[Array] = (),  # (m, 3): theirs for a unit of each far-field unknown
    exterior: Array | None = None,  # (k, k): as of `LinearSystem`
    stretch: tuple[float, float] = (1.0, 1.0),
) -> LinearSystem:
    """Return the system with unknowns numbered: free displacements, mean stresses, far field.

    Centres are those before the mesh was stretched: bisected along its ellipses, an elongated one
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
        exterior=exterior,
        mean_stresses=stresses,
    )


@dataclass(frozen=True, eq=False)
class Front:
    """One elimination: ``u[eliminated] = -sign L^-T W u[remaining]``; sign -1 for mean stresses."""

    eliminated: Integers
    remaining: Integers
    factor: Array
    coupling: Array
    sign: float


@dataclass(frozen=True, eq=False)
class Shift:
    """Change of unknowns: before it, `shifted` was the difference from the unknown `base`."""

    base: int
    shifted: Integers


def condense(system: LinearSystem, fronts: list[Front | Shift] | None = None) -> Array:
    """Return the stiffness (r, r) on the retained unknowns, in the order of `system.retained`.

    `fronts` collects the eliminations for `expand`; without it they are dropped, which limits the
    memory to that of the largest fronts. The body must be supported: a free rigid motion need not
    be seen, by rounding.
    """
    modes = system.boundary.shape[1]
    total = system.first + modes
    # how many elements use an unknown; the retained and those of the far field are used once more,
    # which no group completes
    free = system.unknowns[(system.unknowns >= 0) & (system.unknowns < system.first)]
    uses = np.full(total, np.iinfo(np.int64).max)
    uses[: system.first] = np.bincount(free, minlength=system.first)
    uses[system.retained] += 1
    x, y, z = system.centres.T
    keys = np.stack([z, np.hypot(x, y), np.arctan2(y, x), x, y])
    names, matrix = _reduced(system, np.arange(len(system.matrices)), uses, keys, fronts)
    retained = system.retained
    if system.exterior is None:
        retained = np.append(retained, np.arange(system.first, total))
    else:
        place = np.searchsorted(names, np.arange(system.first, total))
        matrix[np.ix_(place, place)] += system.exterior
        names, matrix = _eliminate((names, matrix), names >= system.first, fronts)
    names, matrix = _eliminate(
        (names, matrix), np.isin(names, system.mean_stresses), fronts, sign=-1.0
    )
    place = np.searchsorted(names, retained)
    return matrix[np.ix_(place, place)]


def _reduced(
    system: LinearSystem,
    elements: Integers,
    uses: Integers,
    keys: Array,
    fronts: list[Front | Shift] | None,
) -> Group:
    """Return the unknowns shared with other groups, and the stiffness of the group on them."""
    constants = system.mean_stresses[:, 0]
    if len(elements) <= max(2, LEAF_UNKNOWNS // system.matrices.shape[1]):
        # the sum of the elements; zero displacements (-1) go into the last row, which is dropped
        names = np.unique(system.unknowns[elements])
        names = names[names >= 0]
        matrix = np.zeros((len(names) + 1, len(names) + 1))
        for element in elements:
            rows = np.searchsorted(names, system.unknowns[element])
            rows[system.unknowns[element] < 0] = len(names)
            _add(matrix, rows, system.matrices[element])
        matrix = matrix[:-1, :-1]
        # far-field unknowns in place of the boundary's
        modes, free = system.boundary.shape[1], int(np.searchsorted(names, system.first))
        follow = system.boundary[names[free:] - system.first]
        if len(follow) and modes:
            across, outer = matrix[:free, free:] @ follow, follow.T @ matrix[free:, free:] @ follow
            inner, matrix = matrix[:free, :free], np.empty((free + modes, free + modes))
            matrix[:free, :free], matrix[free:, free:] = inner, outer
            matrix[:free, free:], matrix[free:, :free] = across, across.T
            names = np.append(names[:free], system.first + np.arange(modes))
        else:
            names, matrix = names[:free], matrix[:free, :free]
        parts, firsts = [(names, matrix)], elements
    else:
        halves = _bisected(system, keys, elements)
        parts = [_reduced(system, half, uses, keys, fronts) for half in halves]
        firsts = np.array([half[0] for half in halves])
        names = np.union1d(parts[0][0], parts[1][0])
    # unknowns without elements outside the group are complete
    unknowns = system.unknowns[elements].ravel()
    place = np.minimum(np.searchsorted(names, unknowns), len(names) - 1)
    inside = np.bincount(place[names[place] == unknowns], minlength=len(names))
    complete = inside == uses[names]
    if not len(constants):
        order = np.argsort(~complete, kind="stable")
        matrix = _sum(names, parts, order)
        return _eliminate((names[order], matrix), complete[order], fronts)
    # A mixed form: the mean stress of a part, the constant of its first element, becomes the
    # difference from that of the group. A group constrained on all sides carries any uniform
    # mean stress: its base is kept.
    matrix = _sum(names, parts, np.arange(len(names)))
    base = int(constants[elements[0]])
    shifted = np.setdiff1d(constants[firsts], base)
    if fronts is not None:
        fronts.append(Shift(base, shifted))
    at, places = int(np.searchsorted(names, base)), np.searchsorted(names, shifted)
    matrix[:, at] += matrix[:, places].sum(axis=1)
    matrix[at] += matrix[places].sum(axis=0)
    # displacements first, then slopes of mean stresses, then the differences of constants
    finished = names[complete & (names != base)]
    stresses = finished[np.isin(finished, system.mean_stresses)]
    group = names, matrix
    group = _eliminate(group, np.isin(names, np.setdiff1d(finished, stresses)), fronts)
    slopes = np.setdiff1d(stresses, constants)
    group = _eliminate(group, np.isin(group[0], slopes), fronts, sign=-1.0)
    waiting = np.isin(group[0], np.intersect1d(stresses, constants))
    try:
        return _eliminate(group, waiting, fronts, sign=-1.0)
    except np.linalg.LinAlgError:
        return group  # the parts are not connected yet: left to the next level


def expand(system: LinearSystem, fronts: list[Front | Shift], retained_values: Array) -> Array:
    """Return all displacements from those of the retained unknowns, without other loads.

    Returns the values of the free unknowns followed by those of the boundary unknowns.
    """
    values = np.zeros(system.first + system.boundary.shape[1])
    values[system.retained] = retained_values
    backward(fronts, values)
    return np.concatenate([values[: system.first], system.boundary @ values[system.first :]])


def forward(fronts: list[Front | Shift], loads: Array) -> None:
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


def backward(fronts: list[Front | Shift], values: Array) -> None:
    """Replace eliminated loads by displacements, where those of the retained unknowns are known."""
    for front in reversed(fronts):
        if isinstance(front, Shift):
            values[front.shifted] += values[front.base]
            continue
        coupled = front.coupling @ values[front.remaining]
        left = values[front.eliminated] - front.sign * coupled
        values[front.eliminated] = solve_triangular(
            front.factor, left, lower=True, trans="T", check_finite=False
        )


def _bisected(system: LinearSystem, keys: Array, elements: Integers) -> tuple[Integers, Integers]:
    """Return a split with the fewest shared unknowns and sizes within 1:2."""
    count = len(elements)
    best, halves = np.inf, (elements[: count // 2], elements[count // 2 :])
    for key in keys[:, elements]:
        # the cut between layers nearest to the median; the second term prevents cuts within a
        # layer, whose elements differ by rounding
        ordered = np.sort(key)
        least = 1e-6 * (ordered[-1] - ordered[0]) + 1e-9 * np.abs(ordered[[0, -1]]).max()
        places = np.flatnonzero(np.diff(ordered) > least) + 1
        places = places[(places >= count // 4) & (places <= count - count // 4)]
        if not len(places):
            continue
        place = places[np.argmin(np.abs(places - count / 2))]
        below = key < 0.5 * (ordered[place - 1] + ordered[place])
        left, right = elements[below], elements[~below]
        used = np.zeros((2, system.first + len(system.boundary) + 1), dtype=bool)
        used[0, system.unknowns[left]] = True
        used[1, system.unknowns[right]] = True
        shared = np.count_nonzero(used[0] & used[1])
        cost = shared * (1.0 + abs(len(left) - len(right)) / count)
        if cost < best:
            best, halves = cost, (left, right)
    return halves


def _eliminate(
    group: Group, complete: Mask, fronts: list[Front | Shift] | None, sign: float = 1.0
) -> Group:
    """Eliminate a definite block of the given sign; LinAlgError, with no change, if it is none."""
    names, matrix = group
    count = int(complete.sum())
    if count == 0:
        return group
    if not complete[:count].all():
        order = np.argsort(~complete, kind="stable")
        names, matrix = names[order], matrix[order[:, None], order]
    block = sign * matrix[:count, :count]
    factor = cholesky(block, lower=True, check_finite=False)
    if sign < 0.0 and np.diag(factor).min() ** 2 < SMALLEST_PIVOT * np.diag(block).max():
        raise np.linalg.LinAlgError("a mean stress is not determined yet")
    coupling = solve_triangular(factor, matrix[:count, count:], lower=True, check_finite=False)
    if fronts is not None:
        fronts.append(Front(names[:count], names[count:], factor, coupling, sign))
    return names[count:], matrix[count:, count:] - sign * (coupling.T @ coupling)


def _sum(names: Integers, parts: list[Group], order: Integers) -> Array:
    """Return the sum of the matrices of parts, in a given order of unknowns."""
    place = np.empty(len(names), dtype=np.int64)
    place[order] = np.arange(len(names))
    matrix = np.zeros((len(names), len(names)))
    for part, block in parts:
        _add(matrix, place[np.searchsorted(names, part)], block)
    return matrix


@njit(cache=True)
def _add(matrix: Array, rows: Integers, block: Array) -> None:
    """Add a block to the given rows and columns, several times faster than fancy indexing."""
    for i in range(len(rows)):
        for j in range(len(rows)):
            matrix[rows[i], rows[j]] += block[i, j]
