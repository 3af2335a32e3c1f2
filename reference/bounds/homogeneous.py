r"""Force of paraboloids with two radii and of pyramids between proved bounds.

The gap has a degree n, so F = U (2n+1)/(n d): bounds of the energy are bounds of the force. A
penetration of 1 serves for all: F = E* d^(1+1/n) F(1).
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from reference.arguments import count_faults, positive_faults, refuse
from reference.bounds.bodies import Body
from reference.bounds.cells import gauss_points
from reference.bounds.extension import Extension
from reference.bounds.interval import EPSILON, Interval, above, below
from reference.bounds.lines import graded
from reference.bounds.obstacle import least_above
from reference.bounds.outlines import Outline
from reference.bounds.pressures import FanPressures
from reference.bounds.sections import fan

Array = NDArray[np.float64]

_PRESSURE_EXPONENT, _DISPLACEMENT_EXPONENT = 2.0, 1.4
# The search for an outline: sectors and shells of its pressures, and how far these go, in copies of
# the best circle and then of the first result.
_SECTORS, _SHELLS, _REACHES = 8, 20, (2.6, 1.5)
# Radius and depth of the elements, in half the length of the contact.
_OUTSKIRTS = 6.0


def force(
    body: Body, penetration: float, effective_modulus: float, *, cells: tuple[int, int] = (10, 16)
) -> Interval:
    """Force at a penetration between proved bounds.

    Parameters
    ----------
    body : Body
    penetration, effective_modulus : float
        d and E*, positive.
    cells : (int, int)
        From the origin to the contact's edge: elements of the upper and cells of the lower bound.

    Raises
    ------
    ValueError
        For a penetration or modulus that is not positive and finite, or cells that are no whole
        numbers from 2.
    """
    faults = positive_faults(penetration=penetration, effective_modulus=effective_modulus)
    refuse(faults + count_faults(2, elements=cells[0], cells=cells[1]))
    n = body.degree
    scale = (2 * n + 1) / n * penetration ** (1 + 1 / n) * effective_modulus
    unit = Interval(energy_below(body, cells[1]), energy_above(body, cells[0]))
    return Interval(below(scale * unit.lower, 16), above(scale * unit.upper, 16))


def energy_below(body: Body, cells: int) -> float:
    """Lower bound of the energy at a penetration of 1 for E* = 1, from pressures on cells."""
    outline = contact_outline(body, cells)
    factors = 1 - (1 - np.arange(cells + 1) / cells) ** _PRESSURE_EXPONENT
    pressures, work, magnitude = _work(body, outline, factors)
    return pressures.energy_below(pressures.best(work), work, magnitude)


def contact_outline(body: Body, cells: int) -> Outline:
    """Outline of the contact at a penetration of 1, with that many sectors.

    A guess: whatever it is, the bounds hold. Paraboloids have an exact first outline.
    """
    first = body.punch(cells)
    return first if body.degree == 2 else replace(first, points=_resampled(body, first.points))


def _resampled(body: Body, rays: Array) -> Array:
    """Points of the contact's outline at the angles of others."""
    points = _coarse_outline(body).points
    length = np.interp(_angles(rays), _angles(points), np.hypot(points[:, 0], points[:, 1]))
    return rays * (length / np.hypot(rays[:, 0], rays[:, 1]))[:, None]


@lru_cache(maxsize=32)
def _coarse_outline(body: Body) -> Outline:
    """Outline of the contact as pressures on a larger fan show it, and on one fitted to these."""
    outline = body.punch(_SECTORS)
    for reach in _REACHES:
        factors = np.linspace(0.0, reach, _SHELLS + 1)
        pressures, work, _ = _work(body, outline, factors)
        pressure = pressures.best(work).reshape(_SECTORS, -1)
        edge = np.array([_edge(row, factors) for row in pressure])
        outline = replace(outline, points=_moved(outline.points, edge))
    return outline


def _moved(points: Array, edge: Array) -> Array:
    """Points of an outline times factors that are known in the middles of its sectors."""
    angles = _angles(points)
    middles = 0.5 * (angles[1:] + angles[:-1])
    factor = np.interp(angles, middles, edge)
    # beyond the last sector's middle the contact goes on as it did
    slope = (edge[-1] - edge[-2]) / (middles[-1] - middles[-2])
    factor += np.maximum(angles - middles[-1], 0.0) * slope
    return points * factor[:, None]


def _angles(points: Array) -> Array:
    return np.arctan2(points[:, 1], points[:, 0])


def _edge(pressure: Array, factors: Array) -> float:
    """Factor at which the square of the pressure, linear near the edge, falls to zero."""
    last = int(np.flatnonzero(pressure > 0)[-1])
    middles = 0.5 * (factors[1:] + factors[:-1])
    inner, outer = pressure[last - 2] ** 2, pressure[last - 1] ** 2
    reach = outer / (inner - outer) if inner > outer else 1.0
    return float(middles[last - 1] + min(reach, 2.0) * (middles[last - 1] - middles[last - 2]))


def _work(body: Body, outline: Outline, factors: Array) -> tuple[FanPressures, Array, Array]:
    pressures = FanPressures(outline, factors)
    places, weights = gauss_points(pressures.cells)
    gap = (weights * body.gap(places[..., 0], places[..., 1])).sum(axis=1)
    return pressures, pressures.areas - gap, pressures.areas + gap


def energy_above(body: Body, cells: int) -> float:
    """Upper bound of the energy at a penetration of 1 for E* = 1, from finite elements.

    The gap is quadratic on every triangle, so its coefficients in Bernstein's polynomials are
    exact, and a displacement with coefficients not below those of d - g is nowhere below d - g.
    """
    outline = contact_outline(body, cells)
    t = np.arange(cells + 1) / cells
    end = _OUTSKIRTS * max(outline.extents) / outline.size
    outwards = graded(cells, _DISPLACEMENT_EXPONENT, end)
    shells = outline.shells(1 - t[-2::-1] ** _DISPLACEMENT_EXPONENT, outwards[1:])
    section, shell = fan(shells, closed=outline.closed)
    x, y = section.points.T
    gap = body.gap(x, y)
    floor = 1 - section.bernstein(gap)
    floor += 16 * EPSILON * (1 + np.abs(gap).max())
    wide = body.gap(shells[..., 0], shells[..., 1]).min(axis=1) > 1
    retained = np.flatnonzero(shell <= np.argmax(wide) + 2)
    elements = Extension(section, outline.size * outwards, retained)
    start = shell[retained] <= cells
    v = least_above(elements.stiffness, 0 * floor[retained], floor[retained], start)
    values = elements.extend(v)
    surface = elements.on_surface(values)
    if (np.delete(surface - floor, retained) < 0).any() or surface.min() < 0:
        raise ArithmeticError("the displacement falls below the body beyond the contact")
    return len(outline.images) * elements.energy_above(values)
