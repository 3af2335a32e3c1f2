"""Pivoting between contact sets: pressures and clearances that exclude each other, exactly.

Find p >= 0 with clearance c = A p + g - d >= 0 and p c = 0, where A gives the displacement of an
elastic body under pressures at its points, g is the gap and d the depth. On a given contact set
c = 0 are linear equations; points of it in tension leave, free points that overlap join.

All wrong points change at once (primal-dual active set: M. Hintermueller, K. Ito & K. Kunisch, SIAM
J. Optim. 13 (2002) 865), which takes few rounds but may cycle. If a contact set recurs, or blocks
stop to reduce the number of wrong points, the last wrong point alone changes from then on (K. G.
Murty, 1974): finite if A is a P-matrix, as every positive definite matrix is, symmetric or not
(J. J. Judice & F. M. Pires, Comput. Oper. Res. 21 (1994) 587).

Below grids (`BorderedCholesky`) coefficients are tabulated. The matrix of (19.7) contains only the
contact cells, few of which change per round. Its Cholesky factor is kept for a base set B; added
cells A and removed cells R form a border,

    [ K_BB  K_BA  E_R ] [p_B]   [b_B]
    [ K_AB  K_AA   0  ] [p_A] = [b_A]        (the last rows mean p_R = 0)
    [ E_R'   0     0  ] [ f ]   [ 0 ]

of which only the Schur complement, |A| + |R| equations, is new in a round.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.linalg import LinAlgError, cholesky, lu_factor, lu_solve, solve, solve_triangular

from reference.contact.body import ElasticBody, power_of_two
from reference.errors import ConvergenceError

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Indices = NDArray[np.intp]
Respond = Callable[[Indices, Array], tuple[Array, Array]]

# A dense Cholesky factor of this many cells takes 200 MB and seconds: beyond it use descent.
CELL_LIMIT = 5000

# A border costs 2 n^2 operations per changed cell, a new factor n^3/3.
_WIDEST_BORDER = 1 / 6


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
    with (0, cell area) a force. On a fixed contact set the pressures are linear in d,
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

    >>> import numpy as np
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


class BorderedCholesky:
    """The cells of a gap below `reach`: beyond the penetration there is no contact.

    The table of coefficients is divided by `unit`, a power of two, so that the square roots of the
    factorisation round equally in all units; pressures are multiplied by it.
    """

    def __init__(self, body: ElasticBody, gap: Array, reach: float) -> None:
        self.rows, self.columns = np.nonzero(np.isfinite(gap) & (gap < reach))
        self.gaps, self.reach = gap[self.rows, self.columns], reach
        table = body.coefficients((int(np.ptp(self.rows)) + 1, int(np.ptp(self.columns)) + 1))
        self.unit = power_of_two(float(table[0, 0]))
        self.table = table / self.unit
        self._base, self._factor = np.zeros(0, dtype=np.intp), np.zeros((0, 0))

    def overlapping(self, depth: float) -> Mask:
        """Return the overlapping cells, or the deepest of them if too many for a factorisation.

        About half of a geometric overlap stays in contact, so the final number may be below the
        limit.
        """
        active = self.gaps < depth
        if np.count_nonzero(active) > CELL_LIMIT:
            active[np.argsort(self.gaps, kind="stable")[CELL_LIMIT:]] = False
        return active

    def respond(self, inside: Indices, right: Array) -> tuple[Array, Array]:
        """Solve (19.7) on the cells `inside`, and return (19.8) on all: see `pivot`."""
        # a new factor where the border would be too wide
        changed = np.setxor1d(inside, self._base, assume_unique=True).size
        if changed > _WIDEST_BORDER * self._base.size:
            if inside.size > CELL_LIMIT:
                raise ValueError(
                    f"{inside.size} cells in contact exceed the dense solver's limit of "
                    f"{CELL_LIMIT}: use descent, or a coarser grid"
                )
            self._base, self._factor = inside[:0], np.zeros((0, 0))  # not beside its successor
            matrix = self._coefficients(inside, inside)
            try:
                # transposed, the symmetric matrix has LAPACK's order and is overwritten, not copied
                self._factor = cholesky(matrix.T, lower=True, overwrite_a=True, check_finite=False)
            except LinAlgError:
                raise ConvergenceError("the matrix of the contact cells is not definite") from None
            self._base = inside
        base, factor = self._base, self._factor
        joined = np.setdiff1d(inside, base, assume_unique=True)
        left = np.setdiff1d(base, inside, assume_unique=True)
        _, kept, positions = np.intersect1d(base, inside, True, True)
        in_joined = np.searchsorted(inside, joined)

        # forward substitution, the Schur complement of the border, back substitution
        forward = np.zeros((base.size, right.shape[1]))
        forward[kept] = right[positions]
        forward = solve_triangular(factor, forward, lower=True, check_finite=False)
        changes = right[in_joined]
        if joined.size + left.size:
            border = np.zeros((base.size, joined.size + left.size))
            border[:, : joined.size] = self._coefficients(base, joined)
            border[np.searchsorted(base, left), joined.size + np.arange(left.size)] = 1.0
            border = solve_triangular(factor, border, lower=True, check_finite=False)
            small = -border.T @ border
            small[: joined.size, : joined.size] += self._coefficients(joined, joined)
            prescribed = np.zeros((border.shape[1], right.shape[1]))
            prescribed[: joined.size] = changes
            prescribed -= border.T @ forward
            changes = solve(small, prescribed, assume_a="sym", check_finite=False)
            forward = forward - border @ changes
        back = solve_triangular(factor, forward, lower=True, trans="T", check_finite=False)
        pressures = np.empty_like(right)
        pressures[positions], pressures[in_joined] = back[kept], changes[: joined.size]
        places = self.rows, self.columns, self.rows[inside], self.columns[inside]
        return pressures, _displacement(*places, pressures, self.table)

    def _coefficients(self, loaded: Indices, targets: Indices) -> Array:
        places = self.rows[loaded], self.columns[loaded], self.rows[targets], self.columns[targets]
        return pairs(*places, self.table)


@njit(cache=True)
def pairs(rows, columns, other_rows, other_columns, table):
    """Return the coefficients of all pairs of cells, looked up by offset: one matrix, no copies."""
    result = np.empty((rows.size, other_rows.size))
    for i in range(rows.size):
        for k in range(other_rows.size):
            result[i, k] = table[abs(rows[i] - other_rows[k]), abs(columns[i] - other_columns[k])]
    return result


@njit(cache=True)
def _displacement(rows, columns, loaded_rows, loaded_columns, pressures, table):
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
