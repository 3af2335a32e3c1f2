r"""Energy, force and stiffness of convex bodies of revolution between proved bounds.

Rigid body without friction on an elastic half-space. From below: pressures uniform on rings, and
flat circular punches; from above: finite elements of Laplace's equation. The two sides share the
gap and nothing else.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from reference.arguments import count_faults, positive_faults, refuse
from reference.bounds.barber import best_circle, contact_radius
from reference.bounds.discs import Discs
from reference.bounds.extension import Extension
from reference.bounds.interval import EPSILON, Interval, above, below
from reference.bounds.lines import graded
from reference.bounds.obstacle import least_above
from reference.bounds.profiles import Profile, minorant
from reference.bounds.sections import rings

Array = NDArray[np.float64]

CELLS = 32

# Exponents of the spacing towards the edge of contact: of the rings of a pressure that ends as
# s^(1/2) and as s^(-1/2) there, and of the elements of a displacement that leaves the body as
# s^(3/2) and as s^(1/2). Where a corner lies close inside, they are in between.
_SMOOTH_RINGS, _CORNER_RINGS, _SHARP_RINGS = 2.0, 3.0, 4.0
_SMOOTH_ELEMENTS, _CORNER_ELEMENTS, _SHARP_ELEMENTS = 1.4, 2.0, 3.5
# Radius and depth of the elements, in contact radii, over the root of the cells: what lies beyond
# costs the fifth power of it, so that the third order of the elements is kept.
_OUTSKIRTS = 2.0
# Width of the energies, relative, times the cube of the cells: from 0.03 (paraboloid) to 0.3 (a
# punch that is hardly rounded). It fixes a step of penetration, not a bound.
_WIDTH = 0.1
# How far, relative to them, the last penetration and force stay away from where a gap ends.
_SHORT = 1e-6


def energy(
    profile: Profile, penetration: float, effective_modulus: float, *, cells: int = CELLS
) -> Interval:
    """Elastic energy, the integral of the force over the penetration, between proved bounds.

    Parameters
    ----------
    profile : Profile
        From `reference.bounds.profiles`.
    penetration, effective_modulus : float
        d and E*, positive.
    cells : int
        Rings and elements per contact radius: the width falls with their third power and beyond.

    Examples
    --------
    >>> from reference.bounds.profiles import paraboloid
    >>> stored = energy(paraboloid(1.0), 0.01, 1.0, cells=12)
    >>> 8 / 15 * 0.01**2.5 in stored, stored.width < 3e-5
    (True, True)
    """
    _check(effective_modulus, cells, penetration=penetration)
    radius = best_circle(profile, penetration).radius
    lower = _energy_below(profile, penetration, radius, cells)
    upper = _energy_above(profile, penetration, radius, cells)
    return effective_modulus * Interval(lower, upper)


def force(
    profile: Profile, penetration: float, effective_modulus: float, *, cells: int = CELLS
) -> Interval:
    r"""Force at a penetration between proved bounds.

    A body of degree n has F = U (2n+1)/(n d), so its energy's bounds are those of the force. For
    others the lower bound is that of the best circle (`best_circle`), and the upper one uses that
    the contact area grows with d (Barber 1974), so that dF/dd grows and F is convex, not above
    its mean over [d - h, d + h]:  F(d) <= [U(d + h) - U(d - h)]/(2 h).

    Parameters, errors
        As in `energy`.

    Examples
    --------
    >>> from reference.bounds.profiles import Sphere
    >>> pressed = force(Sphere(1.0), 0.01, 1.0)
    >>> pressed.width < 1e-4
    True
    """
    _check(effective_modulus, cells, penetration=penetration)
    if profile.degree is not None:
        n = profile.degree
        return energy(profile, penetration, effective_modulus, cells=cells) * (
            (2 * n + 1) / (n * penetration)
        )
    circle = best_circle(profile, penetration)
    step = _step(profile, penetration, cells)
    more, less = penetration + step, penetration - step
    upper = _energy_above(profile, more, best_circle(profile, more).radius, cells)
    lower = _energy_below(profile, less, best_circle(profile, less).radius, cells)
    mean = above((above(upper) - below(lower)) / (more - less), 4)
    return effective_modulus * Interval(circle.force, mean)


def _step(profile: Profile, penetration: float, cells: int) -> float:
    """Step h of penetration: F'' h^2/6, the mean's excess, against w U/(2 h), w that of energies.

    Their sum is least where F'' h^3 = 3 w U/2; U is about F d/2.
    """
    small = min(0.05 * penetration, 0.5 * (profile.deepest - penetration))
    less, here, more = (best_circle(profile, penetration + k * small).force for k in (-1, 0, 1))
    bend = max((more - 2 * here + less) / small**2, 1e-9 * here / penetration**2)
    best = (0.75 * _WIDTH / cells**3 * here * penetration / bend) ** (1 / 3)
    return min(float(best), 0.5 * penetration, 0.5 * (profile.deepest - penetration))


def stiffness(profile: Profile, penetration: float, effective_modulus: float) -> Interval:
    """Stiffness dF/dd at a penetration: 2 E* a with the contact radius a between proved bounds.

    The contact of a convex body of revolution is a disc (`contact_radius`), and as the gap at its
    edge is zero a small step moves all of it by the same: it is a flat punch.

    Examples
    --------
    >>> from reference.bounds.profiles import paraboloid
    >>> k = stiffness(paraboloid(1.0), 0.01, 1.0)
    >>> 2 * 0.1 in k, k.width < 1e-4
    (True, True)
    """
    refuse(positive_faults(penetration=penetration, effective_modulus=effective_modulus))
    return (2 * effective_modulus) * contact_radius(profile, penetration)


def penetration(
    profile: Profile, load: float, effective_modulus: float, *, cells: int = CELLS
) -> Interval:
    """Penetration at a force between proved bounds.

    Not above any d whose best circle carries the force. And as F is convex and starts at zero,
    F(t d) <= t F(d) for t < 1: not below t d where t is the force over the upper bound of F(d).

    Raises
    ------
    ValueError
        For a force or modulus that is not positive and finite, or a force beyond `heaviest`.

    Examples
    --------
    >>> from reference.bounds.profiles import Sphere
    >>> hertz = (0.75 * 1e-6) ** (2 / 3)
    >>> depth = penetration(Sphere(1.0), 1e-6, 1.0)
    >>> round(depth.middle / hertz, 3), depth.width < 1e-4
    (1.0, True)
    """
    _check(effective_modulus, cells, load=load)
    area = load / effective_modulus

    def excess(log_depth: float) -> float:
        return best_circle(profile, math.exp(log_depth)).force / area - 1

    if load > heaviest(profile, effective_modulus):
        raise ValueError(
            f"no bound for a force of {load!r}: it may press deeper than {profile.deepest!r}, "
            "where the gap of this body ends"
        )
    last = math.log(deepest(profile))
    low = high = min(0.5 * math.log(area), last)
    while excess(low) > 0:
        low -= 1.0
    while excess(high) < 0:
        high = min(high + 1.0, last)
    deep = math.exp(brentq(excess, low, high, rtol=1e-10)) if low < high else math.exp(high)
    while best_circle(profile, deep).force < area:
        deep *= 1 + 1e-9
    share = area / force(profile, deep, 1.0, cells=cells).upper
    return Interval(below(min(share, 1.0) * deep, 8), deep)


def deepest(profile: Profile) -> float:
    """Penetration up to which force and energy are enclosed: just before the gap ends."""
    return profile.deepest * (1 - _SHORT)


def heaviest(profile: Profile, effective_modulus: float) -> float:
    """Force up to which `penetration` encloses it: that of the best circle at `deepest`."""
    if math.isinf(profile.deepest):
        return math.inf
    return effective_modulus * best_circle(profile, deepest(profile)).force * (1 - _SHORT)


def disc_stiffness(radius: float, effective_modulus: float, *, cells: int = CELLS) -> Interval:
    """Stiffness of a flat circular punch, 2 E* a, between proved bounds; k = 2 U/d^2.

    Examples
    --------
    >>> stiffness = disc_stiffness(1.0, 1.0)
    >>> 2.0 in stiffness, stiffness.width < 1e-4
    (True, True)
    """
    _check(effective_modulus, cells, radius=radius)
    outer = _rings(cells, _SHARP_RINGS)
    area = np.pi * outer**2
    lower = Discs(outer).energy_below(area, area)
    radii, depths = _mesh(cells, _SHARP_ELEMENTS, ())
    retained = np.arange(2 * cells + 1)
    body = Extension(rings(radii), depths, retained)
    upper = body.energy_above(body.extend(np.ones(len(retained))))
    return (2 * radius * effective_modulus) * Interval(lower, upper)


def _check(effective_modulus: float, cells: int, **sizes: float) -> None:
    faults = positive_faults(**sizes, effective_modulus=effective_modulus)
    refuse(faults + count_faults(4, cells=cells))


def _rings(cells: int, exponent: float) -> Array:
    """Outer radii of rings on the unit disc, finer towards its edge."""
    return 1 - (1 - np.arange(1, cells + 1) / cells) ** exponent


def _energy_below(profile: Profile, penetration: float, radius: float, cells: int) -> float:
    best = 0.0
    for exponent in (_SMOOTH_RINGS, _CORNER_RINGS) if profile.corners else (_SMOOTH_RINGS,):
        discs = Discs(radius * _rings(cells, exponent))
        base = np.pi * penetration * discs.radii**2
        missing = 2 * np.pi * profile.moment(discs.radii)
        best = max(best, discs.energy_below(base - missing, base + missing))
    return best


def _energy_above(profile: Profile, penetration: float, radius: float, cells: int) -> float:
    """Upper bound of the energy for E* = 1, computed in units of the contact radius.

    Halfway from the contact to where d = g the gap goes on along its tangent: a convex gap is not
    below that, and the contact is the same. A ball's slope is infinite where it ends.
    """
    straight = 0.5 * (radius + profile.reach(penetration))
    (left,), (slope,) = (f(np.array([straight])) for f in (profile.gap, profile.slope))
    reach = straight + (penetration - left) / slope
    marks = [corner / radius for corner in profile.corners if corner < radius]
    exponent = _CORNER_ELEMENTS if marks else _SMOOTH_ELEMENTS
    radii, depths = _mesh(cells, exponent, (*marks, straight / radius, reach / radius))
    bend, end = np.searchsorted(radii, [straight / radius, reach / radius])
    floor = _floor(profile, penetration, radius * radii[: end + 1], int(bend))
    retained = np.arange(len(floor))
    body = Extension(rings(radii), depths, retained)
    touching = retained <= 2 * cells
    v = least_above(body.stiffness, 0 * floor, floor, touching)
    values = body.extend(v)
    overlap = body.on_surface(values)[len(floor) :]
    if overlap.min() < 0:
        # beyond the reach of the body any v >= 0 is above d - g
        raise ArithmeticError("the displacement falls below zero beyond the body's reach")
    return radius * penetration**2 * above(body.energy_above(values), 4)


def _floor(profile: Profile, penetration: float, radii: Array, bend: int) -> Array:
    """Coefficients above d - g in units of d: v is above d - g wherever it is above these.

    From the vertex `bend` on g is its tangent there.
    """
    curved, rest = radii[: bend + 1], radii[bend:]
    gap, slope = minorant(profile, curved), profile.slope(curved)
    halves = np.interp(np.arange(1, 2 * len(rest) - 1) / 2, np.arange(len(rest)), rest - rest[0])
    gap = np.concatenate([gap, gap[-1] + slope[-1] * halves]) / penetration
    # the places of the elements are rounded, too: what that changes goes with the slope
    steepest = float((curved * slope).max() + radii[-1] * slope[-1]) / penetration
    return 1 - gap + 8 * EPSILON * (1 + np.abs(gap) + steepest)


def _mesh(cells: int, exponent: float, marks: tuple[float, ...]) -> tuple[Array, Array]:
    """Radii and depths of elements, finer towards r = 1 and the surface; marks are vertices."""
    t = np.arange(cells + 1) / cells
    outwards = graded(cells, exponent, max(_OUTSKIRTS * math.sqrt(cells), *marks, 2.0) - 1)
    radii = np.concatenate([1 - t[::-1] ** exponent, 1 + outwards[1:]])
    kept = [0.0, 1.0, float(radii[-1])]
    for mark in marks:
        radii = _with_vertex(radii, mark, kept)
        kept.append(mark)
    return radii, outwards


def _with_vertex(radii: Array, mark: float, kept: list[float]) -> Array:
    """Move the vertex nearest to the mark onto it, but for those that are kept."""
    if mark in radii:
        return radii
    distance = np.where(np.isin(radii, kept), np.inf, np.abs(radii - mark))
    moved = radii.copy()
    moved[int(np.argmin(distance))] = mark
    return np.sort(moved)
