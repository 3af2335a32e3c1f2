"""Contact on a grid of finite elements: exact, by the penalty method, or by multipliers with it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from reference.errors import ConvergenceError
from reference.fem.contact import EXACT, Enforcement
from reference.fem.grid_body import FreeBody, PeriodicBody
from reference.halfspace import fft
from reference.halfspace.solution import Contact, Press, assemble
from reference.loads import Load

Array = NDArray[np.float64]


def sweep(
    body: FreeBody | PeriodicBody,
    gap: Array,
    load: Load,
    enforcement: Enforcement = EXACT,
    *,
    tolerance: float = 1e-8,
) -> Iterator[Contact]:
    """Press a rigid shape on the body, load by load.

    The contact conditions hold at the centres of the cells. With springs of stiffness eps per area
    between shape and body the compliance of every wave is C + 1/eps, exactly: the penalty method is
    a softer body. Multipliers take its overlap away: the shape is moved by what the last solution
    lets it overlap, and solved again.

    Parameters
    ----------
    body : FreeBody or PeriodicBody
    gap : ndarray, shape (nx, ny)
        Initial gap; +inf where the shape can never touch.
    load : Load
        Penetrations, forces or mean gaps, strictly increasing.
    enforcement : Enforcement
        `penalty` is eps h/E* with h the smaller side of the cells.
    tolerance : float
        Largest overlap and gap of what should touch, relative to the penetration.

    Yields
    ------
    Contact
        One per load.

    Raises
    ------
    ConvergenceError
        From the `next` of a load that fails.

    Examples
    --------
    >>> from reference.fem import Material
    >>> x = (np.arange(24) - 11.5) / 12
    >>> body = FreeBody((24, 24), (1 / 12, 1 / 12), Material(1 - 0.3**2, 0.3))
    >>> ball = (x[:, None] ** 2 + x**2) / 2
    >>> (hertz,) = sweep(body, ball, Load("penetration", 0.5))
    >>> bool(abs(hertz.force / (4 / 3 * 0.5**1.5) - 1) < 5e-3)
    True
    """
    compliance = min(body.spacing) / (enforcement.penalty * body.effective_modulus)
    press = Press(body, gap)
    if enforcement.method == "active_set":
        yield from fft.sweep(press, load, tolerance=tolerance)
        return
    soft = body.softened(compliance)
    if enforcement.method == "penalty":
        yield from fft.sweep(Press(soft, gap), load, tolerance=tolerance)
        return
    for value in load.values:
        yield _augmented(press, Load(load.control, value), soft, enforcement, tolerance)


def _augmented(
    press: Press,
    load: Load,
    soft: FreeBody | PeriodicBody,
    enforcement: Enforcement,
    tolerance: float,
) -> Contact:
    """Return the contact whose overlap the multipliers have taken away."""
    allowed = soft.contact_compliance
    multipliers, contact = np.zeros(soft.shape), None
    history: list[float] = []
    for _ in range(enforcement.max_iterations):
        lifted = press.gap - allowed * multipliers
        shift = float(lifted.min())
        moved = load.values - shift if load.control == "penetration" else load.values
        shape = Press(soft, lifted - shift)
        aim = Load(load.control, moved)
        contact = fft.solve(shape, aim, tolerance=tolerance / 4, start=contact)
        depth = contact.penetration + shift
        overlap = allowed * float(np.abs(contact.pressure - multipliers).max())
        history += [*contact.history, overlap / depth]
        if overlap <= tolerance / 2 * depth:
            return assemble(press, contact.pressure, depth, len(history), history)
        multipliers = contact.pressure
    raise ConvergenceError("the multipliers left an overlap", history)
