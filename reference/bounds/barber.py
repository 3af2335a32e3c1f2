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
from scipy.optimize import brentq, minimize_scalar

from reference.bounds.interval import EPSILON, Interval, above, below
from reference.bounds.profiles import Profile

# Rings of the chords that stay above a convex profile: their excess is of second order.
_RINGS = 4000
# Steps of the sums between which the penetration of a contact radius lies: of first order.
_STEPS = 2**16


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


def contact_radius(profile: Profile, penetration: float) -> Interval:
    r"""Radius of contact of a convex body of revolution between proved bounds.

    Flat punches of all radii x <= a, the one of radius x pushing by dG(x), with

        G(a) = integral of a f'(r)/sqrt(a^2 - r^2) over r < a = int_0^{pi/2} a f'(a sin t) dt,

    displace the surface by G(a) - f(r) inside a and by less than that outside. As f' grows, so does
    G, and no pressure is negative: they are the contact's at d = G(a), and there is no other one
    (Sneddon 1965, Int. J. Eng. Sci. 3, 47). As f' grows the integral lies between its sums from the
    left and from the right.
    """
    last = profile.reach(penetration)
    share = brentq(lambda s: sum(_sums(profile, s * last)) - 2 * penetration, 1e-9, 1.0)
    inner = outer = float(share * last)
    share = 1.0 / _STEPS
    while _sums(profile, inner)[1] > penetration:
        inner, share = inner * (1 - share), 1.5 * share
    share = 1.0 / _STEPS
    while _sums(profile, outer)[0] < penetration and outer < last:
        outer, share = min(outer * (1 + share), last), 1.5 * share
    return Interval(inner, outer)


def _sums(profile: Profile, radius: float) -> tuple[float, float]:
    """Return sums from the left and the right of the integral of a f'(a sin t), rounded out."""
    places = radius * np.sin(np.linspace(0.0, 0.5 * np.pi, _STEPS + 1))
    step = radius * 0.5 * np.pi / _STEPS
    # places that err inwards in the one sum and outwards in the other; half a unit per addition
    left = step * profile.slope(places[:-1] * (1 - 16 * EPSILON)).sum()
    right = step * profile.slope(places[1:] * (1 + 16 * EPSILON)).sum()
    return below(float(left), _STEPS + 64), above(float(right), _STEPS + 64)
