"""The cells of a sliding contact: equations on a contact set, solved directly.

Travelling kernels are far from symmetric if the material is slow, and Krylov methods need hundreds
of convolutions (in trials 60 to 500 per contact set, growing with the grid). Contact sets are
small, so the equations are factorised; while few cells change, the old factor is a preconditioner
with which a few products suffice.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import lu_factor, lu_solve
from scipy.sparse.linalg import LinearOperator, gmres

from reference.errors import ConvergenceError
from reference.sliding.operators import Travelling

Array = NDArray[np.float64]

LIMIT = 9000
"""Largest number of contact cells for a factorisation: 650 MB and about 20 s."""

_FEW = 1 / 8  # fraction of a contact set that may change before a new factorisation
_PRODUCTS = 40
_PRECISION = 1e-13


class Cells:
    """All cells of a grid, or one half of them if grid and gap are mirror images in y.

    Parameters
    ----------
    operator : Travelling
    gap : ndarray, shape (nx, ny)
    """

    def __init__(self, operator: Travelling, gap: Array) -> None:
        self.operator = operator
        self.mirrored = gap.shape[1] % 2 == 0 and bool(np.array_equal(gap, gap[:, ::-1]))
        self.copies = 2 if self.mirrored else 1
        self.width = gap.shape[1] // self.copies
        self.gaps = np.ascontiguousarray(gap[:, : self.width]).ravel()
        self._base = np.zeros(0, dtype=np.intp)
        self._factor: tuple[Array, NDArray[np.int32]] | None = None

    def of_grid(self, values: ArrayLike) -> NDArray:
        """Return the values of the cells from those of the grid."""
        return np.asarray(values)[:, : self.width].ravel().copy()

    def on_grid(self, values: Array) -> Array:
        """Return the values on the whole grid."""
        half = values.reshape(-1, self.width)
        return np.hstack([half, half[:, ::-1]]) if self.mirrored else half

    def displacement(self, pressures: Array) -> Array:
        """Return A p of all cells, `Travelling.datum` included, which makes A definite."""
        pressure = self.on_grid(pressures)
        lift = self.operator.datum * float(pressure.mean())
        return self.of_grid(self.operator.apply(pressure)) + lift

    def respond(self, inside: NDArray[np.intp], right: Array) -> tuple[Array, Array]:
        """Solve A p = right on the cells `inside`, and return A p of all: see `pivot`.

        While few cells change, by the old factor.
        """
        changed = np.setxor1d(inside, self._base, assume_unique=True).size
        several: list[Array | None] = [None]
        if self._factor is not None and changed <= _FEW * inside.size:
            several = [self._by_old_factor(inside, side) for side in right.T]
        solved = [pressures for pressures in several if pressures is not None]
        if len(solved) < len(several):
            self._factorise(inside)
            solved = list(lu_solve(self._factor, right, check_finite=False).T)
        whole = np.zeros((len(solved), self.gaps.size))
        whole[:, inside] = solved
        return np.stack(solved, axis=1), np.stack([self.displacement(p) for p in whole], axis=1)

    def _factorise(self, places: NDArray[np.intp]) -> None:
        if places.size > LIMIT:
            raise ConvergenceError(
                f"{places.size} cells in contact exceed the limit of {LIMIT}: use a coarser grid"
            )
        rows, columns = np.divmod(places, self.width)
        matrix = _matrix(rows, columns, self.operator.table, self.mirrored, self.operator.shape[1])
        self._factor = lu_factor(matrix, overwrite_a=True, check_finite=False)
        self._base = places

    def _by_old_factor(self, places: NDArray[np.intp], side: Array) -> Array | None:
        """Solve by GMRES with the old factor; return None if it does not converge."""
        _, new_places, old_places = np.intersect1d(places, self._base, True, True)
        cell_stiffness = 1 / self.operator.table[0, 0]

        def product(values: Array) -> Array:
            pressures = np.zeros(self.gaps.size)
            pressures[places] = values
            return self.displacement(pressures)[places]

        def guess(values: Array) -> Array:
            base_side = np.zeros(self._base.size)
            base_side[old_places] = values[new_places]
            guessed = cell_stiffness * values
            guessed[new_places] = lu_solve(self._factor, base_side, check_finite=False)[old_places]
            return guessed

        size = (places.size, places.size)
        solution, status = gmres(
            LinearOperator(size, product),
            side,
            M=LinearOperator(size, guess),
            rtol=_PRECISION,
            restart=_PRODUCTS,
            maxiter=1,
        )
        return None if status else solution


@njit(cache=True)
def _matrix(rows, columns, table, mirrored, width):
    """Return the displacements of cells under unit pressure on cells (and their mirror images)."""
    nx, ny = table.shape
    matrix = np.empty((rows.size, rows.size))
    for a in range(rows.size):
        for b in range(rows.size):
            i, j = (rows[a] - rows[b]) % nx, (columns[a] - columns[b]) % ny
            value = table[i, j]
            if mirrored:
                value += table[i, (columns[a] + columns[b] - width + 1) % ny]
            matrix[a, b] = value
    return matrix
