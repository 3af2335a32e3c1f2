"""Adhesive contact on springs: the edge-stretch rule along a path of loads, with its jumps.

The outermost springs hold to the stretch l(a) = sqrt(2 pi a w/E*) (Hess 2011; Popov & Hess 2015,
ch. 4): with the exact equivalent profile this is the theory of Johnson, Kendall & Roberts (1971)
for every axisymmetric body with a compact contact, and for the flat punch Kendall's (1971). The
rule stands for adhesion of a short range; nothing acts across a gap.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from reduced.adhesion.line import FORCE, PENETRATION
from reduced.adhesion.walk import Body, Event, walk
from reduced.arguments import choice_faults, count_faults, positive_faults, refuse
from reduced.profiles.section import Profile

_CONTROLS = {"penetration": PENETRATION, "force": FORCE}


@dataclass(frozen=True)
class Adhesion:
    """An adhesive contact along a path; arrays have shape (k,).

    Attributes
    ----------
    penetration, force, contact_radius, elastic_energy : ndarray
        d, F, a and the energy of the springs; F < 0 pulls. Energy U - pi w a^2 is the free one.
    dissipated : ndarray
        Energy lost in all jumps so far.
    holds : ndarray of bool
        False where nothing can be in equilibrium with the load: a pulling force after pull-off.
        Force and penetration are zero there.
    events : tuple of Event
        In the order of the path.
    spacing : float
        Distance dx of the springs.
    """

    penetration: np.ndarray
    force: np.ndarray
    contact_radius: np.ndarray
    elastic_energy: np.ndarray
    dissipated: np.ndarray
    holds: np.ndarray
    events: tuple[Event, ...]
    spacing: float


def adhere(
    profile: Profile,
    effective_modulus: float,
    work: float,
    *,
    penetration: Sequence[float] | np.ndarray | None = None,
    force: Sequence[float] | np.ndarray | None = None,
    springs: int = 40,
    offset: float = 0.5,
) -> Adhesion:
    """Lead an adhesive body along a path of penetrations or forces, starting out of contact.

    Springs of stiffness E* dx stand at x = +-(i + offset) dx; between them the profile is the
    monotone cubic of `springs.indent.indent`, and the contact ends at any a between springs where

        d = g(a) - l(a),   l = sqrt(2 pi a w/E*),   F = 2 E* int_0^a (d - g(x)) dx.

    The contact grows where its edge is stretched less than l(a), shrinks where more, and jumps
    where that equilibrium ends: at the extremes of d(a) under penetration control, of F(a) under
    force control. First touch is at d = 0, F = 0. On the cubics these are found to rounding, so
    that the error of events is that of the cubics: zero for parabola, cone, cubic and flat punch,
    dx^4 for other smooth profiles.

    Parameters
    ----------
    profile : Profile
        Equivalent profile g(x), see `profiles`.
    effective_modulus : float
        E*.
    work : float
        Work of adhesion w per area, energy/length^2.
    penetration, force : array_like, shape (k,)
        Exactly one of them: finite numbers of either sign in the order of the path.
    springs : int
        Springs per contact radius at the largest contact of the path.
    offset : float
        Place of the first spring in spacings, in [0, 1).

    Returns
    -------
    Adhesion

    Raises
    ------
    ValueError
        Listing every argument that is wrong.
    ConvergenceError
        If the profile is not monotone.

    Examples
    --------
    >>> from reduced.profiles.shapes import paraboloid
    >>> ball = adhere(paraboloid(1.0), 1.0, 0.1, force=[0.0, -1.0])
    >>> [event.kind for event in ball.events]
    ['snap_in', 'pull_off']
    >>> round(ball.events[-1].before.force / (np.pi * 0.1), 12)  # Johnson, Kendall & Roberts 1971
    -1.5
    """
    control, loads = _path(penetration=penetration, force=force)
    refuse(_faults(effective_modulus, work, springs, offset))
    body = Body(profile, effective_modulus, work, control)
    way = walk(body, loads, springs, offset)
    states, dissipated, holds = (np.array(part) for part in zip(*way.record, strict=True))
    return Adhesion(*states.T, dissipated, holds, tuple(way.events), way.spacing)


def pull_off(
    profile: Profile,
    effective_modulus: float,
    work: float,
    *,
    control: str = "force",
    springs: int = 40,
    offset: float = 0.5,
) -> Event:
    """Draw a body off that was laid down at zero load: the last event of the way.

    Parameters
    ----------
    profile, effective_modulus, work, offset
        As for `adhere`.
    control : {"force", "penetration"}
        What is prescribed.
    springs : int
        Springs per contact radius at zero load.

    Examples
    --------
    >>> from reduced.profiles.shapes import cylinder
    >>> event = pull_off(cylinder(2.0), 1.0, 0.1)
    >>> bool(abs(event.before.force + np.sqrt(8 * np.pi * 0.1 * 2.0**3)) < 1e-14)  # Kendall 1971
    True
    """
    wrong = _faults(effective_modulus, work, springs, offset)
    refuse(wrong + choice_faults("control", control, tuple(_CONTROLS)))
    body = Body(profile, effective_modulus, work, _CONTROLS[control])
    return walk(body, np.array([0.0, -np.inf]), springs, offset).events[-1]


def _path(**given: object) -> tuple[int, np.ndarray]:
    """Return control and loads of the only list given."""
    chosen = {name: values for name, values in given.items() if values is not None}
    if len(chosen) != 1:
        names = " and ".join(given)
        raise ValueError(f"give exactly one of {names}; got {', '.join(chosen) or 'none'}")
    ((name, values),) = chosen.items()
    loads = np.array(values, dtype=float, ndmin=1)
    if loads.ndim != 1 or loads.size == 0 or not np.isfinite(loads).all():
        raise ValueError(f"{name} must be a non-empty 1-D list of finite numbers, got {values!r}")
    return _CONTROLS[name], loads


def _faults(effective_modulus: float, work: float, springs: int, offset: float) -> list[str]:
    """Name what is wrong with the numbers."""
    wrong = positive_faults(effective_modulus=effective_modulus, work=work)
    wrong += count_faults(springs=springs)
    if not 0 <= offset < 1:
        wrong.append(f"offset must be in [0, 1), got {offset!r}")
    return wrong
