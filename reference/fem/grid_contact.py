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
    pressed = body_under(body, enforcement)
    if enforcement.method != "augmented_lagrangian":
        yield from fft.sweep(Press(pressed, gap), load, tolerance=tolerance)
        return
    contact = None
    for value in load.values:
        step = Load(load.control, value)
        contact = _augmented(Press(body, gap), step, enforcement, tolerance, contact)
        yield contact


def body_under(body: FreeBody | PeriodicBody, enforcement: Enforcement) -> FreeBody | PeriodicBody:
    """Return what the shape is pressed on: with a penalty, the body with its springs on it."""
    return _soft(body, enforcement) if enforcement.method == "penalty" else body


def _soft(body: FreeBody | PeriodicBody, enforcement: Enforcement) -> FreeBody | PeriodicBody:
    return body.softened(min(body.spacing) / (enforcement.penalty * body.effective_modulus))


def _augmented(
    press: Press, load: Load, enforcement: Enforcement, tolerance: float, start: Contact | None
) -> Contact:
    """Return the contact whose overlap the multipliers have taken away.

    They begin with the pressure of the last load. What needs no multipliers, or has no answer, is
    the exact solver's.
    """
    value, lowest = load.single(), press.lowest
    body = press.operator
    assert isinstance(body, FreeBody | PeriodicBody)
    closed = body.periodic and load.control == "penetration" and value >= press.gap.mean()
    if closed or not press.gap.any() or (load.control == "penetration" and value <= lowest):
        return fft.solve(press, load, tolerance=tolerance)
    soft = _soft(body, enforcement)
    multipliers = np.zeros(soft.shape) if start is None else start.pressure
    contact, history = None, []
    for _ in range(enforcement.max_iterations):
        lifted = press.gap - soft.contact_compliance * multipliers
        shift = float(lifted.min())
        moved = value - shift if load.control == "penetration" else value
        shape, aim = Press(soft, lifted - shift), Load(load.control, moved)
        contact = fft.solve(shape, aim, tolerance=tolerance / 4, start=contact)
        depth = contact.penetration + shift
        overlap = soft.contact_compliance * float(np.abs(contact.pressure - multipliers).max())
        history += [*contact.history, overlap / depth if depth > 0 else np.inf]
        if overlap <= tolerance / 2 * depth:
            return assemble(press, contact.pressure, depth, len(history), history)
        multipliers = contact.pressure
    raise ConvergenceError(
        f"the overlap did not vanish in {enforcement.max_iterations} updates of the multipliers "
        f"with a penalty of {enforcement.penalty:g} E*/h: a larger one needs fewer",
        history,
    )
