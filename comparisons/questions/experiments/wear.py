"""Fretting for so long that nothing wears any more (19.6): springs and cells against its limit."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np

from comparisons.questions.experiments.experiment import Above, Effort, Finding, experiment
from reduced.loads import Load
from reduced.profiles import equivalents
from reduced.wear import Oscillation, RoundBody, wear
from reference import closed_form
from reference.closed_form.worn import FrettingLimit
from reference.halfspace import FreeOperator
from reference.halfspace import wear as half_space
from reference.loads import Load as HalfSpaceLoad

# k E* and d of all bodies, whose stick circle is that of d - lag.
_DEPTH = 1.0
# Grids over the first contact radius: what touches in the end is at most pi/2 as wide (a cone).
_BEYOND = 1.6


@experiment(
    "fretting-limit",
    "Force after many cycles of fretting against that of the limit shape",
    "lag",
    "G* U/(mu E* d)",
)
def fretting_limit(
    effort: Effort,
    *,
    lag: float = 0.5,
    cycles: Annotated[float, Above(0)] = 6.0,
    shape: Literal["paraboloid", "cone"] = "paraboloid",
    model: Literal["springs", "half_space"] = "springs",
) -> Finding:
    """Compare the force after many cycles with that of the limit; coarser ones give the bar.

    `lag` is G* U/(mu E* d), `cycles` are k E* U n over the contact radius of a paraboloid.
    """
    limit = FrettingLimit(getattr(closed_form, shape)(1.0, 1.0), _DEPTH, lag)
    after = _springs if model == "springs" else _cells
    finest = 8 if effort == "quick" else 16
    fine, coarse = (after(shape, limit, cycles, n) for n in (finest, finest // 2))
    return Finding(fine, limit.force, abs(fine - coarse) / limit.force, {})


def _springs(shape: str, limit: FrettingLimit, cycles: float, number: int) -> float:
    """Return the force on springs, so many in the stick radius."""
    profile = getattr(equivalents, shape)(1.0)
    spacing = limit.stick_radius / number
    reach = float(profile.contact_radius(_DEPTH)) * _BEYOND
    count = int(np.ceil(reach / spacing))
    body = RoundBody(profile, count * spacing, count)
    swing = Oscillation(1.0, limit.lag)
    (state,) = wear(body, 1.0, Load("penetration", _DEPTH), 1.0, np.array([cycles]), swing)
    return state.force


def _cells(shape: str, limit: FrettingLimit, cycles: float, number: int) -> float:
    """Return the force on the half-space, so many cells to the contact radius."""
    assert limit.form.contact_radius is not None
    cell = float(limit.form.contact_radius(_DEPTH)) / number
    half = int(np.ceil(_BEYOND * number))
    x = (np.arange(2 * half) - half + 0.5) * cell
    r = np.hypot(x[:, None], x)
    gap = r**2 / 2 if shape == "paraboloid" else r
    body = FreeOperator(gap.shape, (cell, cell), 1.0)
    swing = half_space.Oscillation(1.0, limit.lag)
    load = HalfSpaceLoad("penetration", _DEPTH)
    (state,) = half_space.wear(body, gap, load, 1.0, np.array([cycles]), swing)
    return state.contact.force
