"""Dense equations of the contact cells, with tabulated coefficients and a reused factor.

The matrix of (19.7) contains only the contact cells, few of which change per round of the contact
iteration. Its Cholesky factor is kept for a base set B; added cells A and removed cells R form a
border,

    [ K_BB  K_BA  E_R ] [p_B]   [b_B]
    [ K_AB  K_AA   0  ] [p_A] = [b_A]        (the last rows mean p_R = 0)
    [ E_R'   0     0  ] [ f ]   [ 0 ]

of which only the Schur complement, |A| + |R| equations, is new in a round.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.linalg import LinAlgError, cholesky, solve, solve_triangular

from reference.contact.body import ElasticBody, power_of_two
from reference.errors import ConvergenceError

Field = NDArray[np.float64]
Mask = NDArray[np.bool_]
Indices = NDArray[np.intp]

# A dense Cholesky factor of this many cells takes 200 MB and seconds: beyond it use descent.
CELL_LIMIT = 5000

# A border costs 2 n^2 operations per changed cell, a new factor n^3/3.
_WIDEST_BORDER = 1 / 6


@dataclass
class BorderedCholesky:
    """The candidate cells: their grid indices, gaps, and the table of coefficients.

    The table is divided by `unit`, a power of two, so that the square roots of the factorisation
    round equally in all units; pressures are multiplied by it.
    """

    rows: Indices
    columns: Indices
    gaps: Field
    table: Field
    unit: float
    reach: float
    _base: Indices = field(default_factory=lambda: np.zeros(0, dtype=np.intp))
    _factor: Field = field(default_factory=lambda: np.zeros((0, 0)))

    @classmethod
    def of(cls, body: ElasticBody, gap: Field, reach: float) -> BorderedCholesky:
        """Return the cells with a gap below `reach`; beyond the penetration there is no contact."""
        rows, columns = np.nonzero(np.isfinite(gap) & (gap < reach))
        table = body.coefficients((int(np.ptp(rows)) + 1, int(np.ptp(columns)) + 1))
        unit = power_of_two(float(table[0, 0]))
        return cls(rows, columns, gap[rows, columns], table / unit, unit, reach)

    def overlapping(self, depth: float) -> Mask:
        """Return the overlapping cells, or the deepest of them if too many for a factorisation.

        About half of a geometric overlap stays in contact, so the final number may be below the
        limit.
        """
        active = self.gaps < depth
        if np.count_nonzero(active) > CELL_LIMIT:
            active[np.argsort(self.gaps, kind="stable")[CELL_LIMIT:]] = False
        return active

    def respond(self, inside: Indices, right: Field) -> tuple[Field, Field]:
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

    def _coefficients(self, loaded: Indices, targets: Indices) -> Field:
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
