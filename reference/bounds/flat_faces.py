r"""Stiffness of flat punches with a polygon's outline, between proved bounds.

A flat punch has k = 2 U/d^2, so both bounds of the energy are bounds of the stiffness. On the way
lies Polya & Szego's inequality (Isoperimetric Inequalities, 1951; k is the capacity of the flat
disc): k >= 2 E* sqrt(A/pi), so that a circle of the same area always errs to the soft side.
"""

import math
from collections.abc import Sequence

import numpy as np
from scipy.optimize import linprog
from scipy.spatial import ConvexHull

from reference.bounds.dirichlet import Prisms, fan, shells_about
from reference.bounds.duality import Fan, energy_above, energy_below
from reference.bounds.ellipses import Face, best_ellipse, force_of_ellipses
from reference.bounds.interval import Interval, below
from reference.bounds.outlines import Outline, polygon, slack, towards_edge
from reference.errors import count_faults, refuse

# Exponents of the spacing towards the edge, and of displacements towards the corners.
PRESSURE_EXPONENT, DISPLACEMENT_EXPONENT, DISPLACEMENT_AROUND = 4.0, 3.0, 2.0


def stiffness_below(outline: Outline, cells: int) -> float:
    """Lower bound of the stiffness for E* = 1, from pressures on cells graded to the edge.

    The outline's points are spaced best by `polygon` with `PRESSURE_EXPONENT`.
    """
    pressures = Fan(outline, towards_edge(cells, PRESSURE_EXPONENT))
    return 2 * energy_below(pressures, pressures.areas, pressures.areas)


def stiffness_above(outline: Outline, cells: int) -> float:
    """Upper bound of the stiffness for E* = 1, from finite elements below the surface.

    The outline's points are spaced best by `polygon` with `DISPLACEMENT_AROUND`.
    """
    shells, depths = shells_about(outline, cells, DISPLACEMENT_EXPONENT)
    section, shell = fan(shells, closed=outline.closed)
    on_face = shell <= cells
    elements = Prisms(section, depths, np.flatnonzero(on_face))
    floor = np.where(on_face, 1.0, -np.inf)
    return 2 * len(outline.images) * energy_above(elements, floor)


def equal_area_stiffness(area: float) -> float:
    """Stiffness of the circle of the same area, never above the true one (Polya & Szego 1951)."""
    return below(2 * math.sqrt(area / math.pi), 4)


def bounded(vertices: Sequence[tuple[float, float]], cells: tuple[int, int]) -> Interval:
    """Stiffness of a flat polygon for E* = 1 between proved bounds.

    The vertices go counterclockwise about an origin from which all of the outline is seen; from
    there to the edge there are so many elements of the upper and cells of the lower bound, from 2.

    >>> square = bounded([(1, -1), (1, 1), (-1, 1), (-1, -1)], (5, 6))
    >>> 2 * 1.1523 in square, square.width < 0.005
    (True, True)
    """
    upper, lower = cells
    refuse(count_faults(2, elements=upper, cells=lower))
    # where more than one half of a side is left, each gets less
    halves = len(polygon(vertices, 1, 1.0).points) - 1
    share = min(1.0, math.sqrt(2 / halves))
    fine = polygon(vertices, max(3, round(share * lower)), PRESSURE_EXPONENT)
    coarse = polygon(vertices, max(3, round(0.6 * share * upper)), DISPLACEMENT_AROUND)
    room = slack(vertices)
    return Interval(
        stiffness_below(fine, lower) * (1 - room), stiffness_above(coarse, upper) * (1 + room)
    )


def enclosed(vertices: Sequence[tuple[float, float]], cells: tuple[int, int]) -> Interval:
    """Stiffness of a flat face with any simple outline for E* = 1 between proved bounds.

    Where a place sees the whole outline, as `bounded` about the origin or else that place. Of other
    faces by the order of sets: not above that of the convex hull, which holds the face, and not
    below ellipses that press together on it, nor the circle of its area.

    >>> u_shape = [(0, 0), (3, 0), (3, 3), (2, 3), (2, 1), (1, 1), (1, 3), (0, 3)]
    >>> stiffness = enclosed(u_shape, (5, 6))
    >>> square = bounded([(1.5, -1.5), (1.5, 1.5), (-1.5, 1.5), (-1.5, -1.5)], (5, 6))
    >>> stiffness.upper <= 1.0001 * square.upper, stiffness.width < 0.2
    (True, True)
    """
    corners = np.asarray(vertices, dtype=float)
    # as far as possible to the inner side of every line that a side lies on: a linear programme
    side = np.roll(corners, -1, axis=0) - corners
    length = np.hypot(*side.T)
    inwards = np.stack([-side[:, 1], side[:, 0]], axis=1) / length[:, None]
    offset = (inwards * corners).sum(axis=1)
    if (offset < 0).all():  # the origin sees all
        return bounded(corners.tolist(), cells)
    farthest = linprog(
        [0, 0, -1],
        A_ub=np.column_stack([-inwards, np.ones(len(corners))]),
        b_ub=-offset,
        bounds=[(None, None), (None, None), (0, None)],
    ).x
    if farthest is not None and farthest[2] > 1e-3 * length.max():
        return bounded((corners - farthest[:2]).tolist(), cells)

    hull = corners[ConvexHull(corners).vertices]
    upper = bounded((hull - hull.mean(axis=0)).tolist(), cells).upper
    x, y = (corners - corners.mean(axis=0)).T
    area = 0.5 * abs(float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum()))
    face = Face(corners)
    ellipses = [best_ellipse(face, 1.0, [start])[0] for start in face.starts()]
    together = force_of_ellipses(face, ellipses, 1.0)
    return Interval(max(equal_area_stiffness(below(area, 4 * len(corners))), together), upper)
