r"""Force of paraboloids with two radii and of pyramids between proved bounds.

Convex bodies that are no bodies of revolution, on one part of a symmetric whole. The gap has a
degree n, g(s x) = s^n g(x), so F = U (2n+1)/(n d): bounds of the energy are bounds of the force. A
penetration of 1 serves for all: F = E* d^(1+1/n) F(1).
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from reference.arrays import Array
from reference.bounds.dirichlet import Prisms, fan, shells_about
from reference.bounds.duality import Fan, energy_above, energy_below
from reference.bounds.interval import EPSILON, Interval, above, below
from reference.bounds.outlines import Outline, circle, dihedral, towards_edge
from reference.bounds.quadrangles import gauss_points
from reference.closed_form.shapes import ellipsoid
from reference.errors import count_faults, positive_faults, refuse

Gap = Callable[[Array, Array], Array]

# Exponents of the spacing towards the edge of contact, of pressures and displacements; of that of
# rays towards a pyramid's edge, along which the contact is drawn out.
_PRESSURE_EXPONENT, _DISPLACEMENT_EXPONENT, _POINTED = 2.0, 1.4, 2.0
# The search for an outline: sectors and shells of its pressures, and how far these go, in copies of
# the best circle and then of the first result.
_SECTORS, _SHELLS, _REACHES = 8, 20, (2.6, 1.5)


@dataclass(frozen=True, eq=False)
class Body:
    """A body of a degree, g(s x) = s^n g(x), at a penetration of 1. Equal shapes are one object."""

    degree: int
    gap: Gap  # on the part that is computed
    punch: Callable[[int], Outline]  # a guess of the contact, with so many sectors, of that part
    gap_anywhere: Gap


@lru_cache(maxsize=32)
def paraboloid(radius_x: float, radius_y: float) -> Body:
    """Paraboloid g = x^2/(2 R_x) + y^2/(2 R_y), of which a quarter is computed.

    The best ellipse of Barber is the contact area itself.
    """
    refuse(positive_faults(radius_x=radius_x, radius_y=radius_y))

    def gap(x: Array, y: Array) -> Array:
        return 0.5 * (x**2 / radius_x + y**2 / radius_y)

    a, b = (float(half) for half in ellipsoid(radius_x, radius_y, 1.0).semi_axes(1.0))

    def punch(cells: int) -> Outline:
        return circle(cells, dihedral(2), 0.5 * np.pi).stretched(a, b)

    return Body(2, gap, punch, gap)


@lru_cache(maxsize=32)
def pyramid(faces: int, slope: float) -> Body:
    """Regular pyramid, g = s max(x . n_i) over the normals n_i of its faces' base lines.

    Four faces make Vickers's indenter, three Berkovich's. The part that is computed lies between
    the middle of a face, along x, and its edge. Of the best circle k (1 - <g>) is largest where
    <g> = 1/2, and k = 2 a.
    """
    whole = faces >= 3 and float(faces).is_integer()
    if not (whole and slope > 0 and math.isfinite(slope)):
        raise ValueError(
            "a pyramid has at least three faces of a positive slope, got "
            f"faces = {faces!r}, slope = {slope!r}"
        )
    half = np.pi / faces
    # of radius 1: <r> = pi/4 under the shadow of a sphere, and cos over half a face's angle
    radius = 0.5 / (slope * 0.25 * np.pi * math.sin(half) / half)

    def punch(cells: int) -> Outline:
        return circle(cells, dihedral(faces), half, _POINTED).stretched(radius, radius)

    def anywhere(x: Array, y: Array) -> Array:
        turns = 2 * np.pi * np.arange(faces) / faces
        return slope * np.max([np.cos(t) * x + np.sin(t) * y for t in turns], axis=0)

    return Body(1, lambda x, y: slope * x + 0 * y, punch, anywhere)


def force(
    body: Body, penetration: float, effective_modulus: float, *, cells: tuple[int, int] = (10, 16)
) -> Interval:
    """Force at a penetration between proved bounds.

    The cells from the origin to the contact's edge are elements of the upper and cells of the lower
    bound, at least 2.
    """
    faults = positive_faults(penetration=penetration, effective_modulus=effective_modulus)
    refuse(faults + count_faults(2, elements=cells[0], cells=cells[1]))
    n = body.degree
    scale = (2 * n + 1) / n * penetration ** (1 + 1 / n) * effective_modulus

    # dual: pressures on cells graded to the edge
    factors = towards_edge(cells[1], _PRESSURE_EXPONENT)
    lower = energy_below(*_work(body, contact_outline(body, cells[1]), factors))

    # primal: the gap is quadratic on every triangle, so its coefficients in Bernstein's polynomials
    # are exact, and a displacement with coefficients not below those of d - g is nowhere below it
    outline = contact_outline(body, cells[0])
    shells, depths = shells_about(outline, cells[0], _DISPLACEMENT_EXPONENT)
    section, shell = fan(shells, closed=outline.closed)
    gap = body.gap(*section.points.T)
    floor = 1 - section.bernstein(gap)
    floor += 16 * EPSILON * (1 + np.abs(gap).max())
    # retained up to where the body is out of reach, never the outermost: v >= 0 > d - g beyond
    wide = body.gap(shells[..., 0], shells[..., 1]).min(axis=1) > 1
    near = shell <= min(int(np.argmax(wide)) + 2, len(shells) - 1)
    floor[~near] = np.maximum(floor[~near], 0.0)
    elements = Prisms(section, depths, np.flatnonzero(near))
    upper = len(outline.images) * energy_above(elements, floor, shell[near] <= cells[0])
    return Interval(below(scale * lower, 16), above(scale * upper, 16))


def contact_outline(body: Body, cells: int) -> Outline:
    """Outline of the contact at a penetration of 1, with that many sectors.

    A guess: whatever it is, the bounds hold. Paraboloids have an exact first outline.
    """
    first = body.punch(cells)
    if body.degree == 2:
        return first
    rays, points = first.points, _coarse_outline(body).points
    length = np.interp(_angles(rays), _angles(points), np.hypot(points[:, 0], points[:, 1]))
    return replace(first, points=rays * (length / np.hypot(rays[:, 0], rays[:, 1]))[:, None])


@lru_cache(maxsize=32)
def _coarse_outline(body: Body) -> Outline:
    """Outline of the contact as pressures on a larger fan show it, and on one fitted to these."""
    outline = body.punch(_SECTORS)
    for reach in _REACHES:
        factors = np.linspace(0.0, reach, _SHELLS + 1)
        pressures, work, _ = _work(body, outline, factors)
        between = 0.5 * (factors[1:] + factors[:-1])
        edge = []
        for row in pressures.best(work).reshape(_SECTORS, -1):
            # where the square of the pressure, linear near the edge, falls to zero
            last = int(np.flatnonzero(row > 0)[-1])
            inner, outer = row[last - 2] ** 2, row[last - 1] ** 2
            ahead = outer / (inner - outer) if inner > outer else 1.0
            step = between[last - 1] - between[last - 2]
            edge.append(between[last - 1] + min(ahead, 2.0) * step)
        angles = _angles(outline.points)
        middles = 0.5 * (angles[1:] + angles[:-1])
        # beyond the last sector's middle the contact goes on as it did
        slope = (edge[-1] - edge[-2]) / (middles[-1] - middles[-2])
        factor = np.interp(angles, middles, edge) + np.maximum(angles - middles[-1], 0.0) * slope
        outline = replace(outline, points=outline.points * factor[:, None])
    return outline


def _angles(points: Array) -> Array:
    return np.arctan2(points[:, 1], points[:, 0])


def _work(body: Body, outline: Outline, factors: Array) -> tuple[Fan, Array, Array]:
    """Pressures on a fan, and the integrals of 1 - g and of 1 + g over its cells."""
    pressures = Fan(outline, factors)
    places, weights = gauss_points(pressures.cells)
    gap = (weights * body.gap(places[..., 0], places[..., 1])).sum(axis=1)
    return pressures, pressures.areas - gap, pressures.areas + gap
