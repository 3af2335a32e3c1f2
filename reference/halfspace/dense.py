"""The chapter's contact iteration (19.5-19.8) with dense matrices, a reference for small contacts.

Solve inside the contact, remove cells in tension, add overlapping cells, repeat. The equations of
the contact cells are solved by Cholesky factors (`contact_block`): residuals are near rounding. For
several thousand contact cells use `fft`.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from reference.errors import ConvergenceError
from reference.halfspace.contact_block import Cells
from reference.halfspace.operators import FreeOperator, HalfSpace
from reference.halfspace.overlap import overlap_depth
from reference.halfspace.solution import (
    Contact,
    Effort,
    Press,
    assemble,
    from_first_touch,
)
from reference.loads import Load

Field = NDArray[np.float64]
Mask = NDArray[np.bool_]

CONTROLS = ("penetration", "force")

# Overlap or tension below this fraction of the penetration or mean pressure is rounding of the
# factorisation; sets that differ only by it are equal.
_ROUNDING = 1e-13

# Rounds without fewer wrong cells before single changes take over (Judice and Pires use 10); from
# the geometric overlap the count decreases in every round, with at most seven rounds in practice.
_PATIENCE = 10


def solve(
    press: Press, load: Load, *, start: Contact | None = None, max_iterations: int = 1000
) -> Contact:
    """Return the contact of a rigid shape by the chapter's active-set iteration.

    (19.7) is solved for the pressures in contact, (19.8) gives the displacements outside; the
    iteration starts from the geometric overlap, or from the contact of `start`. Under force control
    the pressures are linear in d on a fixed contact set, and d follows from the force.

    If a contact set recurs, or block changes fail to reduce the number of wrong cells, single
    changes of the last wrong cell are used. At given d they cannot cycle because the matrix is
    positive definite (K. G. Murty 1974; J. J. Judice and F. M. Pires, Comput. Oper. Res. 21 (1994)
    587). Under force control they run inside a Newton iteration for d: the force is convex and
    piecewise linear in d, so the iteration ends after finitely many steps from above.

    Parameters
    ----------
    press : Press
        The shape over a free half-space, whose FFT is used only to evaluate the final displacement
        and violation.
    load : Load
        Penetration or force, one value.
    start : Contact, optional
        A solution at a nearby load.
    max_iterations : int
        Limit of rounds.

    Raises
    ------
    ValueError
        If the arguments are invalid, or more than 5000 cells come into contact.
    ConvergenceError
        Without convergence within `max_iterations`; the history has the wrong cells per round.

    Examples
    --------
    >>> import numpy as np
    >>> K = FreeOperator((3, 3), (1.0, 1.0), 1.0)
    >>> gap = np.full((3, 3), 10.0)
    >>> gap[1, 1] = 0.0
    >>> contact = solve(Press(K, gap), Load("penetration", 1.0))
    >>> int(contact.mask.sum()), bool(np.isclose(contact.force, np.pi / 4 / np.log(1 + np.sqrt(2))))
    (1, True)
    """
    kind, value = load.one_of(*CONTROLS), load.single()
    _free(press)
    effort = Effort(_ROUNDING, max_iterations)
    mask = None if start is None else start.mask
    return _from_touch(press, kind, value, mask, effort)


def sweep(press: Press, load: Load, *, max_iterations: int = 1000) -> Iterator[Contact]:
    """Solve a strictly increasing list of loads, from the previous contact sets; see `solve`."""
    load.one_of(*CONTROLS)
    _free(press)
    return _sweep(press, load, Effort(_ROUNDING, max_iterations))


def _sweep(press: Press, load: Load, effort: Effort) -> Iterator[Contact]:
    mask, cells, kind = None, None, load.control
    largest = float(load.values[-1]) - (press.lowest if kind == "penetration" else 0.0)
    if largest > 0.0:
        # all loads use the cells of the largest one, and therefore the same factor
        lifted = press.touching()
        cells = Cells.of(_free(lifted), lifted.gap, _reach(lifted, kind, largest))
    for value in load.values:
        contact = _from_touch(press, kind, float(value), mask, effort, cells)
        mask = contact.mask
        yield contact


def _from_touch(
    press: Press,
    kind: str,
    value: float,
    start: Mask | None,
    effort: Effort,
    cells: Cells | None = None,
) -> Contact:
    """Solve with depths relative to the first touch of a cell."""
    lowest = press.lowest
    if kind == "penetration":
        if lowest >= value:
            return assemble(press, np.zeros(press.operator.shape), value, 0, [0.0])
        value -= lowest
    contact = _solve(press.touching(), kind, value, start, effort, cells)
    return from_first_touch(contact, press.gap) if lowest > 0.0 else contact


def _free(press: Press) -> FreeOperator:
    """Return the half-space, or raise an error if it is not a free one, or yields."""
    if not isinstance(press.operator, FreeOperator):
        raise ValueError("the dense solver is for the free half-space; use fft for periodic ones")
    if press.hardness < np.inf:
        raise ValueError("the dense solver is for elastic half-spaces; use fft below a hardness")
    return press.operator


def _reach(press: Press, kind: str, value: float) -> float:
    """Return the largest gap of contact cells: the penetration, or an estimate with a margin."""
    if kind == "penetration":
        return value
    return started_from(press.operator, press.gap, value)


def started_from(operator: HalfSpace, gap: Field, force: float) -> float:
    """Return the depth whose overlap the iteration starts from under a force, with a margin."""
    return 1.5 * overlap_depth(operator, gap, force)


def _solve(
    press: Press,
    kind: str,
    value: float,
    start: Mask | None,
    effort: Effort,
    cells: Cells | None = None,
) -> Contact:
    operator, reach = _free(press), _reach(press, kind, value)
    while True:
        if cells is None or cells.reach < reach:
            cells = Cells.of(operator, press.gap, reach)
        active = cells.overlapping(reach)
        if start is not None and start[cells.rows, cells.columns].any():
            active = start[cells.rows, cells.columns]
        total = None if kind == "penetration" else value / operator.cell_area * cells.unit
        pressures, depth, history = _pivot(cells, active, value, total, effort.max_iterations)
        pressure = np.zeros(operator.shape)
        pressure[cells.rows, cells.columns] = pressures / cells.unit
        if depth <= cells.reach:
            return assemble(press, pressure, depth, len(history), history)
        # the depth was only an estimate: restart with all cells below the actual one
        reach, start = 1.2 * depth, pressure > 0


def _pivot(
    cells: Cells,
    active: Mask,
    depth: float,
    total: float | None,
    max_iterations: int,
) -> tuple[Field, float, list[float]]:
    """Change the contact set until no cell is in tension or overlaps."""
    history: list[float] = []
    visited: set[bytes] = set()
    fewest, patience = cells.gaps.size + 1, _PATIENCE
    while patience >= 0 and active.tobytes() not in visited:
        visited.add(active.tobytes())
        pressures, depth = cells.equilibrium(active, depth, total)
        wrong = _wrong(cells, active, pressures, depth)
        count = _count(wrong, history, max_iterations)
        if count == 0:
            return np.maximum(pressures, 0.0), depth, history
        patience = _PATIENCE if count < fewest else patience - 1
        fewest = min(fewest, count)
        active = _changed(cells, active, wrong)
    return _pivot_singly(cells, active, depth, total, max_iterations, history)


def _pivot_singly(
    cells: Cells,
    active: Mask,
    depth: float,
    total: float | None,
    max_iterations: int,
    history: list[float],
) -> tuple[Field, float, list[float]]:
    """Change one cell at a time at fixed depth, inside a Newton iteration for the depth."""
    while True:
        pressures, _ = cells.equilibrium(active, depth, None)
        wrong = _wrong(cells, active, pressures, depth)
        if _count(wrong, history, max_iterations):
            wrong[: np.flatnonzero(wrong)[-1]] = False
            active = _changed(cells, active, wrong)
            continue
        if total is None:
            return np.maximum(pressures, 0.0), depth, history
        _, estimate = cells.equilibrium(active, depth, total)
        if abs(estimate - depth) <= _ROUNDING * depth:
            return np.maximum(pressures, 0.0), depth, history
        depth = estimate


def _wrong(cells: Cells, active: Mask, pressures: Field, depth: float) -> Mask:
    """Return contact cells in tension and overlapping free cells."""
    clearance = cells.displacement(pressures) + cells.gaps - depth
    tension = pressures < -_ROUNDING * np.abs(pressures).max()
    return tension | (~active & (clearance < -_ROUNDING * abs(depth)))


def _count(wrong: Mask, history: list[float], max_iterations: int) -> int:
    """Record the number of wrong cells; raise if the limit of rounds is exceeded."""
    count = int(np.count_nonzero(wrong))
    history.append(float(count))
    if count and len(history) >= max_iterations:
        raise ConvergenceError(f"contact set not found in {max_iterations} rounds", history)
    return count


def _changed(cells: Cells, active: Mask, wrong: Mask) -> Mask:
    """Return the contact set with the wrong cells changed; never empty."""
    active = active ^ wrong
    if not active.any():
        active[np.argmin(cells.gaps)] = True
    return active
