"""Pivoting between contact sets: pressures and clearances that exclude each other, exactly.

Find p >= 0 with clearance c = A p + g - d >= 0 and p c = 0, where A gives the displacement of an
elastic body under pressures at its points, g is the gap and d the depth. On a given contact set
c = 0 are linear equations; points of it in tension leave, free points that overlap join.

All wrong points change at once (primal-dual active set: M. Hintermueller, K. Ito & K. Kunisch, SIAM
J. Optim. 13 (2002) 865), which takes few rounds but may cycle. If a contact set recurs, or blocks
stop to reduce the number of wrong points, the last wrong point alone changes from then on (K. G.
Murty, 1974): finite if A is a P-matrix, as every positive definite matrix is, symmetric or not
(J. J. Judice & F. M. Pires, Comput. Oper. Res. 21 (1994) 587).

The matrix of (19.7) contains only the points in contact, few of which change per round. Its factor
is kept for a base set B (`bordered`); added points A and removed points R form a border,

    [ K_BB  K_BA  E_R ] [p_B]   [b_B]
    [ K_AB  K_AA   0  ] [p_A] = [b_A]        (the last rows mean p_R = 0)
    [ E_R'   0     0  ] [ f ]   [ 0 ]

of which only the Schur complement, |A| + |R| equations, is new in a round. Below grids
(`tabulated`) coefficients are tabulated.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from numba import njit
from scipy.linalg import LinAlgError, cho_factor, cho_solve, lu_factor, lu_solve

from reference.arrays import Array, Indices, Mask
from reference.contact.body import ElasticBody, power_of_two
from reference.errors import ConvergenceError

Respond = Callable[[Indices, Array], tuple[Array, Array]]

# A dense Cholesky factor of this many cells takes 200 MB and seconds: beyond it use descent.
CELL_LIMIT = 5000

_PRECISION = 1e-12  # of the displacements on a contact set


@dataclass(frozen=True, eq=False)
class Pivoted:
    """The contact of n points."""

    depth: float
    # p >= 0 and A p
    pressures: Array
    displacement: Array
    active: Mask  # the contact set
    slope: float  # increase of sum p with the depth on this contact set
    history: list[int]  # number of wrong points by round


def pivot(
    respond: Respond,
    gap: Array,
    active: Mask,
    value: float,
    *,
    per_depth: float = 1.0,
    per_pressure: float = 0.0,
    changes: Callable[[Mask, Mask], Mask] = np.logical_or,
    patience: float = 10,
    rounding: float = 1e-13,
    max_rounds: int = 1000,
) -> Pivoted:
    """Return the contact at a prescribed depth, force, or combination of both.

    ``per_depth d + per_pressure sum p = value`` closes the equations: by default a depth is given;
    with (0, 1) a force, over the cell area. On a fixed contact set the pressures are linear in d,
    p = d p_1 - p_g with A p_1 = 1 and A p_g = g.

    Parameters
    ----------
    respond : callable
        ``respond(inside, right)`` solves A x = right (k, 2) on the points `inside` (k,), and
        returns x (k, 2) and the displacements A x of all points (n, 2).
    gap : (n,)
        +inf where contact is impossible.
    active : (n,) bool
        The contact set to start from.
    changes : callable
        Which of the points in tension and of those that overlap change in a block; by default all.
    patience : float
        Blocks that may fail to lower the number of wrong points before single points change; 10 as
        in Judice & Pires.
    rounding : float
        Tension and overlap below this fraction of the largest terms of pressure and displacement
        are rounding: 1e-13 suits the well-conditioned bodies below grids and elements.
    max_rounds : int
        Limit of contact sets; where single points change, of ten more for each point. Beyond it,
        or where numbers overflow, a ConvergenceError has the number of wrong points by round.

    Examples
    --------
    Two springs of compliance 1 that do not feel each other, with gaps 0 and 3:

    >>> both = pivot(compliance(np.eye(2)), np.array([0.0, 3.0]), np.ones(2, bool), 5.0)
    >>> both.pressures, both.history
    (array([5., 2.]), [0])
    >>> one = pivot(compliance(np.eye(2)), np.array([0.0, 3.0]), np.ones(2, bool), 2.0)
    >>> one.pressures, one.history
    (array([2., 0.]), [1, 0])
    """
    active = active.copy()
    history: list[int] = []
    visited: set[bytes] = set()
    fewest, patient, singly, depth = gap.size + 1, patience, False, np.nan
    while len(history) < max_rounds + (10 * gap.size if singly else 0):
        if per_pressure and not active.any():  # something carries the force
            active[np.argmin(gap)] = True
        inside = np.flatnonzero(active)
        right = np.stack([np.ones(inside.size), gap[inside]], axis=1)
        with np.errstate(over="ignore", invalid="ignore"):
            response = respond(inside, right) if inside.size else (right, np.zeros((gap.size, 2)))
            (unit, shape), displaced = (part.T for part in response)
            slope = float(unit.sum())
            balance = (value + per_pressure * shape.sum()) / (per_pressure * slope + per_depth)
            if not singly:
                depth = float(balance)
            pressures = np.zeros(gap.size)
            pressures[inside] = depth * unit - shape
            displacement = depth * displaced[0] - displaced[1]
        if not (np.isfinite(pressures.sum()) and np.isfinite(displacement).all()):
            raise ConvergenceError(f"pressures overflow at depth {depth:.6g}", history)
        terms = np.abs(depth * unit) + np.abs(shape)
        tension = pressures < -rounding * terms.max(initial=0.0)
        terms = np.abs(depth * displaced[0]) + np.abs(displaced[1])
        overlap = ~active & (displacement + gap - depth < -rounding * terms.max())
        count = int(np.count_nonzero(tension | overlap))
        history.append(count)
        if count == 0:
            if not singly or abs(balance - depth) <= rounding * abs(depth):
                pressures = np.maximum(pressures, 0.0)
                return Pivoted(depth, pressures, displacement, active, slope, history)
            depth = float(balance)  # Newton: the total is convex and piecewise linear in the depth
            continue
        if not singly:
            patient = patience if count < fewest else patient - 1
            fewest = min(fewest, count)
            key = np.packbits(active).tobytes()
            singly = patient < 0 or key in visited
            visited.add(key)
        if singly:  # Murty: the last wrong point only, at this depth
            active[np.flatnonzero(tension | overlap)[-1]] ^= True
        else:
            active ^= changes(tension, overlap)
    raise ConvergenceError(f"contact set not found in {len(history)} rounds", history)


def compliance(matrix: Array) -> Respond:
    """Return the response of a body by its matrix (n, n), which need not be symmetric."""

    def respond(inside: Indices, right: Array) -> tuple[Array, Array]:
        factor = lu_factor(matrix[np.ix_(inside, inside)], check_finite=False)
        solved = lu_solve(factor, right, check_finite=False)
        return solved, matrix[:, inside] @ solved

    return respond


def bordered(
    coefficients: Callable[[Indices, Indices], Array],
    factorised: Callable[[Indices], Callable[[Array], Array]],
    displacement: Callable[[Indices, Array], Array],
    widest_border: float,
) -> Respond:
    """Return the response of a body whose factor is kept from one contact set to the next.

    `coefficients` are displacements of points (k,) under unit pressures on points (m,); what
    `factorised` returns solves the equations of a base set; `displacement` is that of all points
    (n, 2) under pressures (k, 2) on some (k,). Columns of the border serve until the next
    factorisation, when more than a share `widest_border` of the base has changed. Solutions are
    refined, at most twice, where their displacements show that a border has cost digits.
    """
    base = np.zeros(0, dtype=np.intp)
    solve: Callable[[Array], Array] | None = None
    columns_of: dict[int, Array] = {}

    def respond(inside: Indices, right: Array) -> tuple[Array, Array]:
        nonlocal base, solve, columns_of
        joined = np.setdiff1d(inside, base, assume_unique=True)
        left = np.setdiff1d(base, inside, assume_unique=True)
        if solve is None or joined.size + left.size > widest_border * base.size:
            solve = None  # not beside its successor
            solve = factorised(inside)
            base, columns_of, joined, left = inside, {}, inside[:0], inside[:0]

        # new columns of the border: of points that joined, and of forces that free the others
        border = np.concatenate([joined, left])
        new = np.array([point for point in border if point not in columns_of], dtype=np.intp)
        if new.size:
            columns = coefficients(base, new)
            inner = np.flatnonzero(np.isin(new, base, assume_unique=True))
            columns[:, inner] = 0.0
            columns[np.searchsorted(base, new[inner]), inner] = 1.0
            columns_of |= dict(zip(new.tolist(), solve(columns).T, strict=True))
        columns = np.reshape([columns_of[point] for point in border.tolist()], (-1, base.size)).T
        below = coefficients(joined, base)
        freed, added = np.searchsorted(base, left), np.searchsorted(inside, joined)
        schur = np.concatenate([below @ columns, columns[freed]])
        schur[: joined.size, : joined.size] -= coefficients(joined, joined)
        small = lu_factor(schur, check_finite=False) if border.size else None

        _, kept, places = np.intersect1d(base, inside, True, True)
        pressures, remaining = np.zeros(right.shape), right
        for _ in range(3):
            solved = np.zeros((base.size, right.shape[1]))
            solved[kept] = remaining[places]
            solved = solve(solved)
            if small is not None:
                sides = np.concatenate([below @ solved, solved[freed]])
                sides[: joined.size] -= remaining[added]
                changes = lu_solve(small, sides, check_finite=False)
                solved -= columns @ changes
                pressures[added] += changes[: joined.size]
            pressures[places] += solved[kept]
            displaced = displacement(inside, pressures)
            remaining = right - displaced[inside]
            if (np.abs(remaining).max(0) <= _PRECISION * np.abs(right).max(0)).all():
                break
        return pressures, displaced

    return respond


def tabulated(
    body: ElasticBody, gap: Array, reach: float
) -> tuple[Indices, Indices, Array, float, Respond]:
    """Return rows, columns and gaps of the cells below `reach`, a unit, and their response.

    Beyond the penetration there is no contact. Coefficients are divided by the unit, a power of
    two, so that the square roots of the factorisation round equally in all units; pressures are
    multiplied by it.
    """
    rows, columns = np.nonzero(np.isfinite(gap) & (gap < reach))
    table = body.coefficients((int(np.ptp(rows)) + 1, int(np.ptp(columns)) + 1))
    unit = power_of_two(float(table[0, 0]))
    table = table / unit

    def coefficients(points: Indices, loaded: Indices) -> Array:
        return pairs(rows[points], columns[points], rows[loaded], columns[loaded], table)

    def factorised(inside: Indices) -> Callable[[Array], Array]:
        if inside.size > CELL_LIMIT:
            raise ValueError(
                f"{inside.size} cells in contact exceed the dense solver's limit of "
                f"{CELL_LIMIT}: use descent, or a coarser grid"
            )
        matrix = coefficients(inside, inside)
        try:
            # transposed, the symmetric matrix has LAPACK's order and is overwritten, not copied
            factor = cho_factor(matrix.T, lower=True, overwrite_a=True, check_finite=False)
        except LinAlgError:
            raise ConvergenceError("the matrix of the contact cells is not definite") from None
        return partial(cho_solve, factor, check_finite=False)

    def displacement(inside: Indices, pressures: Array) -> Array:
        return _summed(rows, columns, rows[inside], columns[inside], pressures, table)

    # a border costs 2 n^2 operations per changed cell, a new factor n^3/3
    respond = bordered(coefficients, factorised, displacement, 1 / 6)
    return rows, columns, gap[rows, columns], unit, respond


@njit(cache=True)
def pairs(rows, columns, other_rows, other_columns, table):
    """Return the coefficients of all pairs of cells, looked up by offset: one matrix, no copies."""
    result = np.empty((rows.size, other_rows.size))
    for i in range(rows.size):
        for k in range(other_rows.size):
            result[i, k] = table[abs(rows[i] - other_rows[k]), abs(columns[i] - other_columns[k])]
    return result


@njit(cache=True)
def _summed(rows, columns, loaded_rows, loaded_columns, pressures, table):
    """Return the direct sums over the loaded cells, (19.2), for two pressures (k, 2)."""
    result = np.empty((rows.size, 2))
    for i in range(rows.size):
        first = second = 0.0
        for k in range(loaded_rows.size):
            row, column = abs(rows[i] - loaded_rows[k]), abs(columns[i] - loaded_columns[k])
            first += table[row, column] * pressures[k, 0]
            second += table[row, column] * pressures[k, 1]
        result[i, 0], result[i, 1] = first, second
    return result
