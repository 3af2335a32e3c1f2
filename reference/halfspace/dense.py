"""The chapter's contact iteration (19.5-19.8) with dense matrices, a reference for small contacts.

Solve inside the contact, remove cells in tension, add overlapping cells, repeat
(`reference.contact.pivot`). The equations of the contact cells are solved by Cholesky factors
(`contact_block`): residuals are near rounding. For several thousand contact cells use `fft`.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from reference.contact.pivot import pivot
from reference.halfspace.contact_block import Cells
from reference.halfspace.operators import FreeOperator, HalfSpace
from reference.halfspace.overlap import overlap_depth
from reference.halfspace.solution import (
    Contact,
    Press,
    assemble,
    from_first_touch,
)
from reference.loads import Load

Field = NDArray[np.float64]
Mask = NDArray[np.bool_]

CONTROLS = ("penetration", "force")


def solve(
    press: Press, load: Load, *, start: Contact | None = None, max_iterations: int = 1000
) -> Contact:
    """Return the contact of a rigid shape by the chapter's active-set iteration.

    (19.7) is solved for the pressures in contact, (19.8) gives the displacements outside; the
    iteration starts from the geometric overlap, or from the contact of `start`. Under force control
    the pressures are linear in d on a fixed contact set, and d follows from the force.

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
    return _solve(press, kind, value, None if start is None else start.mask, max_iterations)


def sweep(press: Press, load: Load, *, max_iterations: int = 1000) -> Iterator[Contact]:
    """Solve a strictly increasing list of loads, from the previous contact sets; see `solve`."""
    load.one_of(*CONTROLS)
    _free(press)
    return _sweep(press, load, max_iterations)


def _sweep(press: Press, load: Load, max_iterations: int) -> Iterator[Contact]:
    mask, cells, kind = None, None, load.control
    largest = float(load.values[-1]) - (press.lowest if kind == "penetration" else 0.0)
    if largest > 0.0:
        # all loads use the cells of the largest one, and therefore the same factor
        lifted = press.touching()
        cells = Cells.of(_free(lifted), lifted.gap, _reach(lifted, kind, largest))
    for value in load.values:
        contact = _solve(press, kind, float(value), mask, max_iterations, cells)
        mask = contact.mask
        yield contact


def _solve(
    press: Press,
    kind: str,
    value: float,
    start: Mask | None,
    max_iterations: int,
    cells: Cells | None = None,
) -> Contact:
    """Pivot on the cells that the body can reach, with depths relative to first touch."""
    if kind == "penetration" and press.lowest >= value:
        return assemble(press, np.zeros(press.operator.shape), value, 0, [0.0])
    touching, operator = press.touching(), _free(press)
    value -= press.lowest if kind == "penetration" else 0.0
    reach = _reach(touching, kind, value)
    while True:
        if cells is None or cells.reach < reach:
            cells = Cells.of(operator, touching.gap, reach)
        active = cells.overlapping(reach)
        if start is not None and start[cells.rows, cells.columns].any():
            active = start[cells.rows, cells.columns]
        force = kind == "force"
        settled = pivot(
            cells.respond,
            cells.gaps,
            active,
            value / operator.cell_area * cells.unit if force else value,
            per_depth=0.0 if force else 1.0,
            per_pressure=1.0 if force else 0.0,
            max_rounds=max_iterations,
        )
        pressure = np.zeros(operator.shape)
        pressure[cells.rows, cells.columns] = settled.pressures / cells.unit
        if settled.depth <= cells.reach:
            contact = assemble(
                touching, pressure, settled.depth, len(settled.history), settled.history
            )
            return from_first_touch(contact, press.gap) if press.lowest > 0.0 else contact
        # the depth was only an estimate: restart with all cells below the actual one
        reach, start = 1.2 * settled.depth, pressure > 0


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
