"""The chapter's contact iteration (19.5-19.8) with dense matrices: the oracle for small contacts.

Solve inside the contact, drop cells in tension, add cells that overlap, repeat. The matrix of the
contact cells alone is built, by looking Love's coefficients up in a table of offsets, and
factorised (Cholesky): residuals are near rounding. For some thousand contact cells use `fft`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import cho_factor, cho_solve

from reference.errors import ConvergenceError
from reference.halfspace import kernels
from reference.halfspace.operators import FreeOperator
from reference.halfspace.overlap import overlap_depth
from reference.halfspace.solution import Contact, assemble, check_gap, check_load

Field = NDArray[np.float64]

# A dense Cholesky factor of this many cells takes 200 MB and seconds: beyond it `fft` is the tool.
CELL_LIMIT = 5000

# Overlap or tension below this fraction of the penetration or mean pressure is rounding of the
# factorisation, and a set that differs only by it is the same set.
_ROUNDING = 1e-13

# Rounds without fewer wrong cells before single changes take over (Judice and Pires use 10); from
# the geometric overlap the count falls in every round, and seven rounds were the most ever seen.
_PATIENCE = 10


def solve(
    operator: FreeOperator,
    gap: ArrayLike,
    *,
    penetration: float | None = None,
    force: float | None = None,
    start: Contact | None = None,
    max_iterations: int = 1000,
) -> Contact:
    """Press a rigid shape on a free half-space by the active-set iteration of the chapter.

    (19.7) is solved for the pressures in contact, (19.8) gives the displacements outside; the
    iteration starts from the geometric overlap, or from the contact of `start`. Under force control
    the pressures are linear in d on a fixed contact set, and d follows from the force. If block
    changes fail to reduce the number of wrong cells, single changes of the last wrong cell take
    over, which at given d cannot cycle because the matrix is positive definite (K. G. Murty 1974;
    J. J. Judice and F. M. Pires, Comput. Oper. Res. 21 (1994) 587).

    Parameters
    ----------
    operator : FreeOperator
        Grid and modulus; its FFT is used only to evaluate the final displacement and violation.
    gap : array_like, shape (nx, ny)
        Initial gap g >= 0 of the rigid shape; +inf where it can never touch.
    penetration, force : float
        Exactly one of them, positive.
    start : Contact, optional
        A solution at a nearby load.
    max_iterations : int
        Limit of rounds.

    Raises
    ------
    ValueError
        If the arguments make no problem, or more than 5000 cells come into contact.
    ConvergenceError
        If the contact set is not found within `max_iterations`; history: wrong cells per round.

    Examples
    --------
    >>> import numpy as np
    >>> K = FreeOperator((3, 3), (1.0, 1.0), 1.0)
    >>> gap = np.full((3, 3), 10.0)
    >>> gap[1, 1] = 0.0
    >>> contact = solve(K, gap, penetration=1.0)
    >>> int(contact.mask.sum()), bool(np.isclose(contact.force, np.pi / 4 / np.log(1 + np.sqrt(2))))
    (1, True)
    """
    kind, values = check_load(penetration=penetration, force=force)
    if values.size != 1:
        raise ValueError(f"{kind} must be one number; use sweep for a list")
    gap = _checked(operator, gap)
    mask = None if start is None else start.mask
    return _solve(operator, gap, kind, float(values[0]), mask, max_iterations)


def sweep(
    operator: FreeOperator,
    gap: ArrayLike,
    *,
    penetration: Sequence[float] | None = None,
    force: Sequence[float] | None = None,
    max_iterations: int = 1000,
) -> Iterator[Contact]:
    """Solve a strictly increasing list of loads, each from the contact set before; see `solve`."""
    kind, values = check_load(penetration=penetration, force=force)
    return _sweep(operator, _checked(operator, gap), kind, values, max_iterations)


def _sweep(
    operator: FreeOperator,
    gap: Field,
    kind: str,
    values: NDArray[np.float64],
    max_iterations: int,
) -> Iterator[Contact]:
    mask = None
    for value in values:
        contact = _solve(operator, gap, kind, float(value), mask, max_iterations)
        mask = contact.mask
        yield contact


def _checked(operator: FreeOperator, gap: ArrayLike) -> Field:
    if operator.periodic:
        raise ValueError("the dense solver is for the free half-space; use fft for periodic ones")
    return check_gap(operator, gap)


@dataclass
class _Cells:
    """The candidate cells: their places on the grid, gaps, and the table of coefficients.

    The table is divided by `unit`, a power of two, so that the square roots of the factorisation
    round alike in all units; pressures are multiplied by it.
    """

    rows: NDArray[np.intp]
    columns: NDArray[np.intp]
    gaps: Field
    table: Field
    unit: float

    @classmethod
    def of(cls, operator: FreeOperator, gap: Field, reach: float) -> _Cells:
        """Cells with a finite gap up to `reach`: beyond the penetration nothing can touch."""
        rows, columns = np.nonzero(np.isfinite(gap) & (gap < reach))
        spans = [np.arange(np.ptp(places) + 1) for places in (rows, columns)]
        table = kernels.love(
            spans[0][:, None], spans[1][None, :], operator.spacing, operator.effective_modulus
        )
        unit = 2.0 ** np.round(np.log2(table[0, 0]))
        return cls(rows, columns, gap[rows, columns], table / unit, unit)

    def matrix(self, contact: NDArray[np.intp]) -> Field:
        """Coefficients among the contact cells."""
        return _matrix(self.rows[contact], self.columns[contact], self.table)

    def overlapping(self) -> NDArray[np.bool_]:
        """All candidates, or the deepest of them if they are more than can be factorised.

        About half of a geometric overlap stays in contact, so this may still end below the limit.
        """
        active = np.zeros(self.gaps.size, dtype=bool)
        active[np.argsort(self.gaps, kind="stable")[:CELL_LIMIT]] = True
        return active

    def displacement(self, contact: NDArray[np.intp], pressures: Field) -> Field:
        """Displacement of every candidate cell, (19.8)."""
        rows, columns = self.rows[contact], self.columns[contact]
        return _displacement(self.rows, self.columns, rows, columns, pressures, self.table)


@njit(cache=True)
def _matrix(rows, columns, table):
    """Look the coefficients of all pairs of cells up by their offsets."""
    result = np.empty((rows.size, rows.size))
    for i in range(rows.size):
        for k in range(rows.size):
            result[i, k] = table[abs(rows[i] - rows[k]), abs(columns[i] - columns[k])]
    return result


@njit(cache=True)
def _displacement(rows, columns, loaded_rows, loaded_columns, pressures, table):
    """Direct sum over the loaded cells, (19.2)."""
    result = np.zeros(rows.size)
    for i in range(rows.size):
        total = 0.0
        for k in range(loaded_rows.size):
            row, column = abs(rows[i] - loaded_rows[k]), abs(columns[i] - loaded_columns[k])
            total += table[row, column] * pressures[k]
        result[i] = total
    return result


def _solve(
    operator: FreeOperator,
    gap: Field,
    kind: str,
    value: float,
    start: NDArray[np.bool_] | None,
    max_iterations: int,
) -> Contact:
    if kind == "penetration" and gap.min() >= value:
        return assemble(operator, gap, np.zeros(operator.shape), value, 0, [0.0])
    reach = value if kind == "penetration" else 1.5 * overlap_depth(operator, gap, value)
    while True:
        cells = _Cells.of(operator, gap, reach)
        active = cells.overlapping()
        if start is not None and start[cells.rows, cells.columns].any():
            active = start[cells.rows, cells.columns]
        total = None if kind == "penetration" else value / operator.cell_area * cells.unit
        pressures, depth, history = _pivot(cells, active, value, total, max_iterations)
        pressure = np.zeros(operator.shape)
        pressure[cells.rows, cells.columns] = pressures / cells.unit
        if depth <= reach:
            return assemble(operator, gap, pressure, depth, len(history), history)
        # the depth was only estimated: start again with all cells below the one found
        reach, start = 1.2 * depth, pressure > 0


def _pivot(
    cells: _Cells,
    active: NDArray[np.bool_],
    depth: float,
    total: float | None,
    max_iterations: int,
) -> tuple[Field, float, list[float]]:
    """Change the contact set until no cell is in tension and none overlaps."""
    history: list[float] = []
    fewest, patience = cells.gaps.size + 1, _PATIENCE
    for _ in range(max_iterations):
        pressures, depth = _equilibrium(cells, active, depth, total)
        contact = np.flatnonzero(active)
        clearance = cells.displacement(contact, pressures[contact]) + cells.gaps - depth
        tension = pressures < -_ROUNDING * np.abs(pressures).max()
        wrong = tension | (~active & (clearance < -_ROUNDING * depth))
        count = int(wrong.sum())
        history.append(float(count))
        if count == 0:
            return np.maximum(pressures, 0.0), depth, history
        if count < fewest:
            fewest, patience = count, _PATIENCE
        else:
            patience -= 1
        if patience < 0:
            wrong[: np.flatnonzero(wrong)[-1]] = False
        active = active ^ wrong
        if not active.any():
            active[np.argmin(cells.gaps)] = True
    raise ConvergenceError(f"contact set not found in {max_iterations} rounds", history)


def _equilibrium(
    cells: _Cells, active: NDArray[np.bool_], depth: float, total: float | None
) -> tuple[Field, float]:
    """Pressures on a fixed contact set, (19.7), and the depth that carries the total."""
    contact = np.flatnonzero(active)
    if contact.size > CELL_LIMIT:
        raise ValueError(
            f"{contact.size} cells in contact exceed the dense solver's limit of {CELL_LIMIT}: "
            "use reference.halfspace.fft, or a coarser grid"
        )
    factor = cho_factor(cells.matrix(contact), lower=True, overwrite_a=True, check_finite=False)
    sides = np.stack([np.ones(contact.size), cells.gaps[contact]], axis=1)
    unit, shape = cho_solve(factor, sides, check_finite=False).T
    if total is not None:
        depth = float((total + shape.sum()) / unit.sum())
    pressures = np.zeros(cells.gaps.size)
    pressures[contact] = depth * unit - shape
    return pressures, depth
