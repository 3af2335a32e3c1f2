"""Rolling step by step, from any state: every step is one problem of friction.

The grid rolls on by one cell per step, dx. The surface below it carries its displacement along,

    slip of a step = dx c + u(x + dx) before - u(x) now,

and Coulomb's law in the step is the convex problem of `halfspace.stick_slip`. Where the steps come
to rest they obey the equations of `tractions`; nothing else is shared with that solver. Rollers
whose shape changes as they roll (roughness that travels with the surface) have no steady state, and
this is the way to solve them.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from reference.errors import ConvergenceError
from reference.halfspace import fft, stick_slip
from reference.halfspace.solution import Press
from reference.halfspace.traction import NormalAndTangential
from reference.loads import Load
from reference.rolling.contact import Creep, rigid_slip

Field = NDArray[np.float64]
Fields = NDArray[np.float64]

# Slip of a step that is none, relative to the displacement of full sliding.
_TOLERANCE = 1e-7


@dataclass(frozen=True)
class Moment:
    """The state after a step of one cell.

    Attributes
    ----------
    force, tangential_force, lateral_force : float
    contact_cells : int
    traction : ndarray, shape (2, nx, ny)
    """

    force: float
    tangential_force: float
    lateral_force: float
    contact_cells: int
    traction: Fields = field(repr=False)


def roll_on(
    body: NormalAndTangential,
    pressures: Iterable[Field],
    friction: float,
    creep: Creep,
    start: Fields | None = None,
) -> Iterator[Moment]:
    """Roll by one cell per pressure, without coupling to normal displacements.

    Parameters
    ----------
    body : NormalAndTangential
        The free half-space.
    pressures : iterable of ndarray, shape (nx, ny)
        In every step: the same one for a smooth roller, `pressed` for a rough one.
    friction : float
    creep : Creep
    start : ndarray, shape (2, nx, ny), optional
        Tractions before the first step, such as Cattaneo's; default: none.

    Yields
    ------
    Moment

    Raises
    ------
    ConvergenceError
        If a step does not converge.

    Examples
    --------
    >>> from reference.halfspace.cerruti import Compliance
    >>> body = NormalAndTangential((9, 8), (0.25, 0.25), Compliance.of(1.0, 0.0))
    >>> x, y = (np.arange(9) - 4) / 4, (np.arange(8) - 3.5) / 4
    >>> p = np.sqrt(np.maximum(0.8 - x[:, None] ** 2 - y**2, 0))
    >>> *_, last = roll_on(body, [p] * 12, 0.3, Creep(0.05))
    >>> 0.1 < last.tangential_force / (0.3 * last.force) < 0.9
    True
    """
    traction = np.zeros((2, *body.shape)) if start is None else start.copy()
    displacement = body.shear(traction)
    rigid = body.spacing[0] * rigid_slip(creep, body.shape, body.spacing)
    for pressure in pressures:
        bound = friction * pressure
        if (bound[-1] > 0).any():
            raise ConvergenceError("the contact reaches the leading edge of the grid")
        carried = np.zeros_like(displacement)
        carried[:, :-1] = displacement[:, 1:]
        scale = float(np.abs(carried + rigid)[:, bound > 0].max(initial=0.0))
        if scale > 0:
            problem = stick_slip.Shear(body, bound, carried + rigid)
            solved = stick_slip.minimise(problem, traction, _TOLERANCE * scale)
            traction, displacement = solved.traction, solved.displacement
        along, across = traction.sum(axis=(1, 2)) * body.cell_area
        yield Moment(
            force=float(pressure.sum() * body.cell_area),
            tangential_force=float(along),
            lateral_force=float(across),
            contact_cells=int(np.count_nonzero(bound)),
            traction=traction,
        )


def pressed(
    body: NormalAndTangential, gap: Field, roughness: Field, load: Load, tolerance: float = 1e-7
) -> Iterator[Field]:
    """Yield the pressures of a roller whose roughness travels through the contact with the surface.

    Parameters
    ----------
    body : NormalAndTangential
    gap : ndarray, shape (nx, ny)
        Of the smooth roller.
    roughness : ndarray, shape (mx, ny), mx >= nx
        Heights, peaks towards the half-space; the first nx rows lie in the grid at first, and the
        next ones enter at its end of largest x.
    load : Load
        One value, the same in every step.
    """
    rows, contact = body.shape[0], None
    for first in range(roughness.shape[0] - rows + 1):
        rough = gap - roughness[first : first + rows]
        lowest = float(rough.min())
        applied = load.single() - (lowest if load.control == "penetration" else 0.0)
        press = Press(body.normal, rough - lowest)
        contact = fft.solve(press, Load(load.control, applied), tolerance=tolerance, start=contact)
        yield contact.pressure
