r"""Energy, force and stiffness of convex bodies of revolution between proved bounds.

Rigid body without friction on an elastic half-space. From below: pressures uniform on rings, and
flat circular punches; from above: finite elements of Laplace's equation. The two sides share the
gap and nothing else.

Of all sets S the true contact area carries the largest force at a given penetration d (Barber 1974,
J. Strain Anal. 9, 230), and what S carries is the mean of d - g under the pressure of a flat
punch on S times the punch's stiffness, F >= k_S (d - <g>_S): the dual of
F = min {int q : q >= 0, K q >= d - g}.

The bodies are rising, convex profiles, a row each; others have none.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from reference.arrays import Array
from reference.bounds.dirichlet import Prisms, rings
from reference.bounds.duality import Rings, energy_above, energy_below
from reference.bounds.interval import EPSILON, Interval, above, below
from reference.bounds.outlines import towards_edge
from reference.errors import count_faults, positive_faults, refuse
from reference.fem.half_space_mesh import power_lines

Law = Callable[[Array], Array]

# Rings and elements per contact radius: widths fall with their third power and beyond.
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
# Rings of the chords that stay above a convex profile: their excess is of second order.
_CHORDS = 4000
# Steps of the sums between which the penetration of a contact radius lies: of first order.
_STEPS = 2**16


@dataclass(frozen=True, eq=False)
class ConvexGap:
    """Gap f(r) before contact: f(0) = 0, rising and convex, with a third derivative of one sign.

    All functions to a few units in the last place. Equal shapes are one object.
    """

    gap: Law  # f(r)
    slope: Law  # f'(r)
    moment: Law  # integral of f(s) s ds from 0 to r
    reach: Callable[[float], float]  # radius at which f is the penetration: contact stays inside
    degree: float | None = None  # n where f(s r) = s^n f(r); else the body has a length
    # radii at which a higher derivative jumps; between them f''' >= 0, or else <= 0
    corners: tuple[float, ...] = ()
    rising_curvature: bool = True
    deepest: float = math.inf  # penetrations are below this, where the gap ends


@lru_cache(maxsize=64)
def power_law(exponent: float, coefficient: float) -> ConvexGap:
    """f(r) = c r^n with n >= 1, which is convex; f''' has the sign of n - 2."""
    n, c = exponent, coefficient
    refuse(positive_faults(exponent=n, coefficient=c))
    if n < 1:
        raise ValueError(f"the bounds hold for convex bodies, r^n with n >= 1, not n = {n!r}")
    return ConvexGap(
        gap=lambda r: c * r**n,
        slope=lambda r: c * n * r ** (n - 1),
        moment=lambda r: c / (n + 2) * r ** (n + 2),
        reach=lambda d: (d / c) ** (1 / n),
        degree=float(n),
        rising_curvature=n >= 2 or n == 1,
    )


def paraboloid(radius: float) -> ConvexGap:
    """Paraboloid r^2/(2R)."""
    refuse(positive_faults(radius=radius))
    return power_law(2.0, 0.5 / radius)


def cone(slope: float) -> ConvexGap:
    """Cone s r."""
    return power_law(1.0, slope)


@lru_cache(maxsize=64)
def sphere(radius: float) -> ConvexGap:
    """Ball R - sqrt(R^2 - r^2) on r < R, within the linear theory of the half-space."""
    R = radius
    refuse(positive_faults(radius=R))

    def gap(r: Array) -> Array:
        return r**2 / (R + np.sqrt((R - r) * (R + r)))

    def moment(r: Array) -> Array:
        return gap(r) ** 2 * (R / 2 - gap(r) / 3)  # r dr = (R - f) df

    def reach(penetration: float) -> float:
        if penetration >= R:
            raise ValueError(
                f"a sphere of radius {R!r} is bounded for penetrations below its "
                f"radius, not for {penetration!r}"
            )
        return math.sqrt(penetration * (2 * R - penetration))

    return ConvexGap(gap, lambda r: r / np.sqrt((R - r) * (R + r)), moment, reach, deepest=R)


@lru_cache(maxsize=64)
def rounded_punch(flat_radius: float, edge_radius: float) -> ConvexGap:
    """Punch, flat up to r = b, then (r - b)^2/(2R)."""
    b, R = flat_radius, edge_radius
    refuse(positive_faults(flat_radius=b, edge_radius=R))

    def beyond(r: Array) -> Array:
        return np.maximum(r - b, 0.0)

    return ConvexGap(
        gap=lambda r: beyond(r) ** 2 / (2 * R),
        slope=lambda r: beyond(r) / R,
        moment=lambda r: beyond(r) ** 3 * (beyond(r) / 4 + b / 3) / (2 * R),
        reach=lambda d: b + math.sqrt(2 * R * d),
        corners=(b,),
    )


def minorant(profile: ConvexGap, radii: Array) -> Array:
    """Bernstein coefficients (2 n + 1,) of a continuous, piecewise parabolic function below f.

    A bound needs the gap everywhere, not at nodes. Where the third derivative of f keeps its sign,
    the parabola through f(r1) and f(r2) that has the slope of f at one of the two ends stays on one
    side of f, as its error is

        f(r) - q(r) = f'''(s)/6 (r - r1) (r - r2)^2    with the slope at r2,
        f(r) - q(r) = f'''(s)/6 (r - r1)^2 (r - r2)    with the slope at r1

    for some s between r1 and r2 (Davis, Interpolation and Approximation, 1963, section 3.5). The
    coefficients of a piece are f(r1), b, f(r2) with b = f(r2) - f'(r2) h/2 or f(r1) + f'(r1) h/2.
    Radii (n + 1,) increase; the profile's corners are among them.

    >>> minorant(paraboloid(0.5), np.array([0.0, 1.0, 2.0])).tolist()
    [0.0, 0.0, 1.0, 2.0, 4.0]
    """
    gap, slope, half = profile.gap(radii), profile.slope(radii), 0.5 * np.diff(radii)
    coefficients = np.empty(2 * len(radii) - 1)
    coefficients[::2] = gap
    if profile.rising_curvature:
        coefficients[1::2] = gap[1:] - slope[1:] * half
    else:
        coefficients[1::2] = gap[:-1] + slope[:-1] * half
    return coefficients


def energy(
    profile: ConvexGap, penetration: float, effective_modulus: float, *, cells: int = CELLS
) -> Interval:
    """Elastic energy, the integral of the force over the penetration, between proved bounds.

    >>> stored = energy(paraboloid(1.0), 0.01, 1.0, cells=12)
    >>> 8 / 15 * 0.01**2.5 in stored, stored.width < 3e-5
    (True, True)
    """
    _check(effective_modulus, cells, penetration=penetration)
    penetration = float(penetration)
    lower = _energy_below(profile, penetration, cells)
    return effective_modulus * Interval(lower, _energy_above(profile, penetration, cells))


def force(
    profile: ConvexGap, penetration: float, effective_modulus: float, *, cells: int = CELLS
) -> Interval:
    r"""Force at a penetration between proved bounds.

    A body of degree n has F = U (2n+1)/(n d), so its energy's bounds are those of the force. For
    others the lower bound is that of the best circle, and the upper one uses that the contact area
    grows with d (Barber 1974), so that dF/dd grows and F is convex, not above its mean over
    [d - h, d + h]:  F(d) <= [U(d + h) - U(d - h)]/(2 h).

    >>> pressed = force(sphere(1.0), 0.01, 1.0)
    >>> pressed.width < 1e-4
    True
    """
    _check(effective_modulus, cells, penetration=penetration)
    penetration = float(penetration)
    if profile.degree is not None:
        n = profile.degree
        return energy(profile, penetration, effective_modulus, cells=cells) * (
            (2 * n + 1) / (n * penetration)
        )
    circle = best_circle(profile, penetration)
    # the step h: the mean exceeds F by F'' h^2/6, and energies of the relative width w by
    # w U/(2 h). The sum is least where F'' h^3 = 3 w U/2; U is about F d/2.
    room = 0.5 * (profile.deepest - penetration)
    small = min(0.05 * penetration, room)
    less, here, more = (best_circle(profile, penetration + k * small).force for k in (-1, 0, 1))
    bend = max((more - 2 * here + less) / small**2, 1e-9 * here / penetration**2)
    best = (0.75 * _WIDTH / cells**3 * here * penetration / bend) ** (1 / 3)
    step = min(float(best), 0.5 * penetration, room)

    more, less = penetration + step, penetration - step
    upper, lower = _energy_above(profile, more, cells), _energy_below(profile, less, cells)
    mean = above((above(upper) - below(lower)) / (more - less), 4)
    return effective_modulus * Interval(circle.force, mean)


def stiffness(profile: ConvexGap, penetration: float, effective_modulus: float) -> Interval:
    r"""Stiffness dF/dd at a penetration: 2 E* a with the contact radius a between proved bounds.

    Flat punches of all radii x <= a, the one of radius x pushing by dG(x), with

        G(a) = integral of a f'(r)/sqrt(a^2 - r^2) over r < a = int_0^{pi/2} a f'(a sin t) dt,

    displace the surface by G(a) - f(r) inside a and by less than that outside. As f' grows, so does
    G, and no pressure is negative: they are the contact's at d = G(a), and there is no other one
    (Sneddon 1965, Int. J. Eng. Sci. 3, 47). As f' grows the integral lies between its sums from the
    left and from the right. And as the gap at the contact's edge is zero, a small step moves all of
    it by the same: it is a flat punch.

    >>> k = stiffness(paraboloid(1.0), 0.01, 1.0)
    >>> 2 * 0.1 in k, k.width < 1e-4
    (True, True)
    """
    refuse(positive_faults(penetration=penetration, effective_modulus=effective_modulus))

    def sums(radius: float) -> tuple[float, float]:
        """G(a) from the left and the right, rounded out."""
        places = radius * np.sin(np.linspace(0.0, 0.5 * np.pi, _STEPS + 1))
        step = radius * 0.5 * np.pi / _STEPS
        # places that err inwards in the one sum and outwards in the other; half a unit per addition
        left = step * profile.slope(places[:-1] * (1 - 16 * EPSILON)).sum()
        right = step * profile.slope(places[1:] * (1 + 16 * EPSILON)).sum()
        return below(float(left), _STEPS + 64), above(float(right), _STEPS + 64)

    last = profile.reach(penetration)
    share = brentq(lambda s: sum(sums(s * last)) - 2 * penetration, 1e-9, 1.0)
    inner = outer = float(share * last)
    share = 1.0 / _STEPS
    while sums(inner)[1] > penetration:
        inner, share = inner * (1 - share), 1.5 * share
    share = 1.0 / _STEPS
    while sums(outer)[0] < penetration and outer < last:
        outer, share = min(outer * (1 + share), last), 1.5 * share
    return (2 * effective_modulus) * Interval(inner, outer)


def penetration(
    profile: ConvexGap, load: float, effective_modulus: float, *, cells: int = CELLS
) -> Interval:
    """Penetration at a force between proved bounds; beyond `heaviest` a ValueError.

    Not above any d whose best circle carries the force. And as F is convex and starts at zero,
    F(t d) <= t F(d) for t < 1: not below t d where t is the force over the upper bound of F(d).

    >>> hertz = (0.75 * 1e-6) ** (2 / 3)
    >>> depth = penetration(sphere(1.0), 1e-6, 1.0)
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


def deepest(profile: ConvexGap) -> float:
    """Penetration up to which force and energy are enclosed: just before the gap ends."""
    return profile.deepest * (1 - _SHORT)


def heaviest(profile: ConvexGap, effective_modulus: float) -> float:
    """Force up to which `penetration` encloses it: that of the best circle at `deepest`."""
    if math.isinf(profile.deepest):
        return math.inf
    return effective_modulus * best_circle(profile, deepest(profile)).force * (1 - _SHORT)


def disc_stiffness(radius: float, effective_modulus: float, *, cells: int = CELLS) -> Interval:
    """Stiffness of a flat circular punch, 2 E* a, between proved bounds; k = 2 U/d^2.

    >>> stiffness = disc_stiffness(1.0, 1.0)
    >>> 2.0 in stiffness, stiffness.width < 1e-4
    (True, True)
    """
    _check(effective_modulus, cells, radius=radius)
    pressures = Rings(towards_edge(cells, _SHARP_RINGS)[1:])
    area = np.pi * pressures.radii**2
    radii, depths = _mesh(cells, _SHARP_ELEMENTS, ())
    elements = Prisms(rings(radii), depths, np.arange(2 * cells + 1))
    floor = np.full(2 * len(radii) - 1, -np.inf)
    floor[elements.retained] = 1.0
    unit = Interval(energy_below(pressures, area, area), energy_above(elements, floor))
    return (2 * radius * effective_modulus) * unit


class Circle(NamedTuple):
    """Radius of the best circle, and the force that it proves."""

    radius: float
    force: float


@lru_cache(maxsize=64)
def best_circle(profile: ConvexGap, penetration: float) -> Circle:
    """Largest of the lower bounds 2 a (d - <g>) of the force that circles give, for E* = 1.

    The pressure of a circular punch is the shadow of a uniform sphere, so <g> is the mean of g over
    that sphere: no mesh, no solver. Chords of a convex profile are above it, so the mean of the
    chords is not below <g>; rounding is added.
    """

    def force_of(radius: float) -> float:
        # r = a sin(angle): the mean over the sphere's shadow has the measure sin(angle) d angle
        angle = np.linspace(0.0, 0.5 * np.pi, _CHORDS + 1)
        r = radius * np.sin(angle)
        gap, slope = profile.gap(r), np.diff(profile.gap(r)) / np.diff(r)
        weight = -np.diff(np.cos(angle))
        lever = radius * 0.5 * np.diff(angle - np.sin(angle) * np.cos(angle))
        mean = ((gap[:-1] - slope * r[:-1]) * weight + slope * lever).sum()
        # differences of angles: an epsilon over the width of a ring, in each of the rings
        rounding = 16 * _CHORDS * EPSILON * (gap[-1] + radius * slope.max())
        return float(2 * radius * (penetration - mean - rounding) * (1 - 8 * EPSILON))

    reach = profile.reach(penetration)
    search = minimize_scalar(
        lambda a: -force_of(a),
        bounds=(0.0, reach),
        method="bounded",
        options={"xatol": 1e-7 * reach},
    )
    return Circle(float(search.x), force_of(float(search.x)))


def _check(effective_modulus: float, cells: int, **sizes: float) -> None:
    faults = positive_faults(**sizes, effective_modulus=effective_modulus)
    refuse(faults + count_faults(4, cells=cells))


def _energy_below(profile: ConvexGap, penetration: float, cells: int) -> float:
    """Lower bound of the energy for E* = 1."""
    best, radius = 0.0, best_circle(profile, penetration).radius
    for exponent in (_SMOOTH_RINGS, _CORNER_RINGS) if profile.corners else (_SMOOTH_RINGS,):
        pressures = Rings(radius * towards_edge(cells, exponent)[1:])
        base = np.pi * penetration * pressures.radii**2
        missing = 2 * np.pi * profile.moment(pressures.radii)
        best = max(best, energy_below(pressures, base - missing, base + missing))
    return best


def _energy_above(profile: ConvexGap, penetration: float, cells: int) -> float:
    """Upper bound of the energy for E* = 1, computed in units of the contact radius."""
    radius = best_circle(profile, penetration).radius
    # halfway from the contact to where d = g the gap goes on along its tangent: a convex gap is not
    # below that, and the contact is the same; a ball's slope is infinite where it ends
    straight = 0.5 * (radius + profile.reach(penetration))
    (left,), (slope,) = (f(np.array([straight])) for f in (profile.gap, profile.slope))
    reach = straight + (penetration - left) / slope
    marks = [corner / radius for corner in profile.corners if corner < radius]
    exponent = _CORNER_ELEMENTS if marks else _SMOOTH_ELEMENTS
    radii, depths = _mesh(cells, exponent, (*marks, straight / radius, reach / radius))
    bend, end = np.searchsorted(radii, [straight / radius, reach / radius])

    # coefficients above d - g in units of d: v is above d - g wherever it is above these. Beyond
    # the reach any v >= 0 is.
    curved, rest = radius * radii[: bend + 1], radius * radii[bend : end + 1]
    gap, slopes = minorant(profile, curved), profile.slope(curved)
    halves = np.interp(np.arange(1, 2 * len(rest) - 1) / 2, np.arange(len(rest)), rest - rest[0])
    gap = np.concatenate([gap, gap[-1] + slopes[-1] * halves]) / penetration
    # the places of the elements are rounded, too: what that changes goes with the slope
    steepest = float((curved * slopes).max() + rest[-1] * slopes[-1]) / penetration
    floor = np.zeros(2 * len(radii) - 1)
    floor[: len(gap)] = 1 - gap + 8 * EPSILON * (1 + np.abs(gap) + steepest)

    elements = Prisms(rings(radii), depths, np.arange(len(gap)))
    energy = energy_above(elements, floor, elements.retained <= 2 * cells)
    return radius * penetration**2 * above(energy, 4)


def _mesh(cells: int, exponent: float, marks: tuple[float, ...]) -> tuple[Array, Array]:
    """Radii and depths of elements, finer towards r = 1 and the surface; marks are vertices."""
    t = np.arange(cells + 1) / cells
    outwards = power_lines(cells, exponent, max(_OUTSKIRTS * math.sqrt(cells), *marks, 2.0) - 1)
    radii = np.concatenate([1 - t[::-1] ** exponent, 1 + outwards[1:]])
    kept = [0.0, 1.0, float(radii[-1])]
    for mark in marks:
        if mark not in radii:
            # the vertex nearest to the mark moves onto it, but for those that are kept
            distance = np.where(np.isin(radii, kept), np.inf, np.abs(radii - mark))
            radii[int(np.argmin(distance))] = mark
            radii = np.sort(radii)
        kept.append(mark)
    return radii, outwards
