"""Adhesive contact on springs: the edge-stretch rule along a path of loads, with its jumps.

The outermost springs adhere up to the stretch l(a) = sqrt(2 pi a w/E*) (Hess 2011; Popov & Hess
2015, ch. 4): with the exact equivalent profile this is the theory of Johnson, Kendall & Roberts
(1971) for every axisymmetric body with a compact contact, and for the flat punch Kendall's (1971).
The rule describes short-range adhesion; nothing acts across a gap.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reduced.adhesion.line import FORCE, PENETRATION
from reduced.adhesion.walk import Body, Event, walk
from reduced.arguments import choice_faults, positive_faults, refuse
from reduced.loads import LoadPath
from reduced.springs.line import Springs

_CONTROLS = {"penetration": PENETRATION, "force": FORCE}


@dataclass(frozen=True)
class Adhesion:
    """An adhesive contact along a path; arrays have shape (k,).

    Attributes
    ----------
    penetration, force, contact_radius, elastic_energy : ndarray
        d, F, a and the energy of the springs; F < 0 pulls. The free energy is U - pi w a^2.
    dissipated : ndarray
        Energy lost in all jumps so far.
    holds : ndarray of bool
        False if no equilibrium with the load exists: a tensile force after pull-off. Force and
        penetration are then zero.
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


def adhere(springs: Springs, work: float, path: LoadPath) -> Adhesion:
    """Solve an adhesive contact along a path of penetrations or forces, starting out of contact.

    Springs of stiffness E* dx stand at x = +-(i + offset) dx; between them the profile is the
    monotone cubic of `springs.indent.indent`, and the contact ends at any a between springs where

        d = g(a) - l(a),   l = sqrt(2 pi a w/E*),   F = 2 E* int_0^a (d - g(x)) dx.

    The contact grows if the stretch at its edge is below l(a), shrinks if it is above, and jumps
    where this equilibrium ends: at the extrema of d(a) under penetration control, of F(a) under
    force control. First touch is at d = 0, F = 0. The extrema of the cubics are computed to
    rounding, so that the error of events is that of the cubics: zero for parabola, cone, cubic and
    flat punch, dx^4 for other smooth profiles.

    Parameters
    ----------
    springs : Springs
        The profile and its springs, with ``edges="sub_cell"``; `per_radius` refers to the largest
        contact of the path.
    work : float
        Work of adhesion w per area, energy/length^2.
    path : LoadPath
        ``"penetration"`` or ``"force"``, of either sign in the order of the path.

    Returns
    -------
    Adhesion

    Raises
    ------
    ValueError
        Lists all invalid arguments.
    ConvergenceError
        If the profile is not monotone.

    Examples
    --------
    >>> from reduced.profiles.equivalents import paraboloid
    >>> ball = adhere(Springs(paraboloid(1.0), 1.0), 0.1, LoadPath("force", [0.0, -1.0]))
    >>> [event.kind for event in ball.events]
    ['snap_in', 'pull_off']
    >>> round(ball.events[-1].before.force / (np.pi * 0.1), 12)  # Johnson, Kendall & Roberts 1971
    -1.5
    """
    way = walk(_body(springs, work, path.control), path.values, springs)
    states, dissipated, holds = (np.array(part) for part in zip(*way.record, strict=True))
    penetration, force, radius, energy = states.T
    return Adhesion(
        *(penetration, force, radius, energy, dissipated, holds), tuple(way.events), way.spacing
    )


def pull_off(springs: Springs, work: float, control: str = "force") -> Event:
    """Return the pull-off event of a body placed on the surface at zero load.

    Parameters
    ----------
    springs, work
        As for `adhere`; `per_radius` refers to the contact radius at zero load.
    control : {"force", "penetration"}
        What is prescribed.

    Examples
    --------
    >>> from reduced.profiles.equivalents import cylinder
    >>> event = pull_off(Springs(cylinder(2.0), 1.0), 0.1)
    >>> bool(abs(event.before.force + np.sqrt(8 * np.pi * 0.1 * 2.0**3)) < 1e-14)  # Kendall 1971
    True
    """
    body = _body(springs, work, control)
    return walk(body, np.array([0.0, -np.inf]), springs).events[-1]


def _body(springs: Springs, work: float, control: str) -> Body:
    """Return the body, or raise one ValueError for all invalid arguments."""
    wrong = positive_faults(work=work) + choice_faults("control", control, tuple(_CONTROLS))
    if springs.edges != "sub_cell":
        wrong.append(f"edges must be 'sub_cell' for adhesive springs, got {springs.edges!r}")
    refuse(wrong)
    return Body(springs.profile, springs.effective_modulus, work, _CONTROLS[control])
