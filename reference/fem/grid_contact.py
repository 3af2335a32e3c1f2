"""Contact on a grid of finite elements: exact, by the penalty method, or by multipliers with it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from reference.contact import press as unilateral
from reference.contact.press import Contact, assemble, check_gap
from reference.errors import ConvergenceError
from reference.fem.contact import EXACT, Enforcement
from reference.fem.grid_body import FreeBody, PeriodicBody
from reference.loads import Load


def sweep(
    body: FreeBody | PeriodicBody,
    gap: NDArray[np.float64],
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
    gap : ndarray, shape (nx, ny)
        Initial gap; +inf where the shape can never touch.
    load : Load
        Penetrations, forces or mean gaps, strictly increasing.
    enforcement : Enforcement
        `penalty` is eps h/E* with h the smaller side of the cells.
    tolerance : float
        Largest overlap and gap of what should touch, relative to the penetration.

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
    if enforcement.method != "augmented_lagrangian":
        yield from unilateral.sweep(body_under(body, enforcement), gap, load, tolerance=tolerance)
        return
    gap = check_gap(body, gap)
    soft = body_under(body, replace(enforcement, method="penalty"))
    compliance, by_depth = soft.contact_compliance, load.control == "penetration"
    answer = None
    for value in load.values:
        # What needs no multipliers, or has no answer, is the exact solver's.
        closed = body.periodic and by_depth and value >= gap.mean()
        if closed or not gap.any() or (by_depth and value <= gap.min()):
            answer = unilateral.press(body, gap, Load(load.control, value), tolerance=tolerance)
            yield answer
            continue
        multipliers = np.zeros(soft.shape) if answer is None else answer.pressure
        contact, history = None, []
        for _ in range(enforcement.max_iterations):
            lifted = gap - compliance * multipliers
            shift = float(lifted.min())
            aim = Load(load.control, value - shift if by_depth else value)
            contact = unilateral.press(
                soft, lifted - shift, aim, tolerance=tolerance / 4, start=contact
            )
            depth = contact.penetration + shift
            overlap = compliance * float(np.abs(contact.pressure - multipliers).max())
            history += [*contact.history, overlap / depth if depth > 0 else np.inf]
            if overlap <= tolerance / 2 * depth:
                break
            multipliers = contact.pressure
        else:
            raise ConvergenceError(
                f"the overlap did not vanish in {enforcement.max_iterations} updates of the "
                f"multipliers with a penalty of {enforcement.penalty:g} E*/h: a larger one needs "
                "fewer",
                history,
            )
        answer = assemble(body, gap, contact.pressure, depth, len(history), history)
        yield answer


def body_under(body: FreeBody | PeriodicBody, enforcement: Enforcement) -> FreeBody | PeriodicBody:
    """Return what the shape is pressed on: with a penalty, the body with its springs on it."""
    if enforcement.method != "penalty":
        return body
    return body.softened(min(body.spacing) / (enforcement.penalty * body.effective_modulus))
