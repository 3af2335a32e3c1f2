"""The depth at which a contact has a prescribed quantity, by bracketed secant steps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from reference.errors import ConvergenceError

if TYPE_CHECKING:
    from reference.contact.press import Contact

Field = NDArray[np.float64]


def search_depth(
    at: Callable[[float, Field | None], Contact],
    missing: Callable[[Contact], float],
    allowed: Callable[[Contact], float],
    *,
    touch: tuple[float, float],
    depth: float,
    start: Field | None,
    name: str,
) -> Contact:
    """Return the contact that misses no more than is allowed, with the history of all on the way.

    Parameters
    ----------
    at : callable
        The contact at a depth, from a pressure to start with.
    missing, allowed : callable
        The prescribed quantity less that of a contact, which decreases with the depth, and what it
        may be.
    touch : (float, float)
        Depth of first touch, and what is missing there.
    depth, start
        First depth, and the pressure to start from.
    name : str
        The quantity, for the error message.

    Raises
    ------
    ConvergenceError
        If no depth is found in 60 contacts, or a contact fails.
    """
    previous, low, high = touch, touch[0], np.inf
    history: list[float] = []
    for _ in range(60):
        contact = at(depth, start)
        error = missing(contact)
        history += contact.history
        if abs(error) <= allowed(contact):
            return replace(contact, iterations=len(history), history=history)
        low, high = (depth, high) if error > 0 else (low, depth)
        run, rise = depth - previous[0], error - previous[1]
        slow = abs(error) > abs(previous[1]) / 2 and np.isfinite(high)
        previous, start = (depth, error), contact.pressure
        depth = np.inf if slow or not run * rise < 0 else depth - error * run / rise
        if not low < depth < high:
            depth = (low + high) / 2 if np.isfinite(high) else 2 * low
    raise ConvergenceError(f"no penetration reached the prescribed {name}", history)
