r"""The pressure of a flat punch as a lower bound of the force, for any shape.

Of all sets S the true contact area carries the largest force at a given penetration d (Barber 1974,
Int. J. Eng. Sci. 12, 813), and what S carries is the mean of d - g under the pressure of a flat
punch on S times the punch's stiffness:

    F >= k_S (d - <g>_S).

It is the dual of F = min {int q : q >= 0, K q >= d - g}. The pressure of an elliptic punch is the
shadow of a uniform sphere, 1/(2 pi a b sqrt(1 - x^2/a^2 - y^2/b^2)), so <g> is the mean of g over
that sphere: no mesh, no solver.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar

from reference.bounds.interval import EPSILON
from reference.bounds.profiles import Profile

# Rings of the chords that stay above a convex profile: their excess is of second order.
_RINGS = 4000


class Circle(NamedTuple):
    """Radius of the best circle, and the force that it proves."""

    radius: float
    force: float


def best_circle(profile: Profile, penetration: float) -> Circle:
    """Largest of the lower bounds of the force that flat circular punches give, for E* = 1."""
    reach = profile.reach(penetration)
    search = minimize_scalar(
        lambda a: -force_of_circle(profile, penetration, a),
        bounds=(0.0, reach),
        method="bounded",
        options={"xatol": 1e-7 * reach},
    )
    radius = float(search.x)
    return Circle(radius, force_of_circle(profile, penetration, radius))


def force_of_circle(profile: Profile, penetration: float, radius: float) -> float:
    """Lower bound 2 E* a (d - <g>) of the force, for E* = 1.

    Chords of a convex profile are above it, so the mean of the chords is not below <g>; rounding
    is added.
    """
    # r = a sin(angle): the mean over the sphere's shadow has the measure sin(angle) d angle
    angle = np.linspace(0.0, 0.5 * np.pi, _RINGS + 1)
    r = radius * np.sin(angle)
    gap, slope = profile.gap(r), np.diff(profile.gap(r)) / np.diff(r)
    weight = -np.diff(np.cos(angle))
    lever = radius * 0.5 * np.diff(angle - np.sin(angle) * np.cos(angle))
    mean = ((gap[:-1] - slope * r[:-1]) * weight + slope * lever).sum()
    # differences of angles: an epsilon over the width of a ring, in each of the rings
    rounding = 16 * _RINGS * EPSILON * (gap[-1] + radius * slope.max())
    return float(2 * radius * (penetration - mean - rounding) * (1 - 8 * EPSILON))
