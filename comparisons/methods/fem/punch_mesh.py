"""Meshes of the method `fem` for flat faces with straight sides: grid lines along the sides.

Where all sides lie along x or y, as on a square or an L-shape, mesh lines follow every one of them
and crowd there, in elements of second order; needles take an even grid of first order. Oblique
sides are staircases on such a grid.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from comparisons.geometry.prepare import IndenterGeometry
from comparisons.scene.indenters.indenter import Indenter
from comparisons.scene.indenters.punches import PolygonPunch
from comparisons.scene.polygons import distance_to_outline
from reference import fem

# Twenty seconds of elimination on one core.
MOST_UNKNOWNS = 150_000
# Faces longer than this, in widths, take an even grid of first order: crowded lines along all of
# the length would be too many.
LONGEST_CROWDED = 8
SYMMETRIES = {planes: name for name, planes in fem.SYMMETRIES.items()}


def second_order(indenter: Indenter) -> bool:
    """Whether a face is meshed with crowded lines and elements of second order."""
    corners = indenter.outline
    if corners is None:
        return False
    sides = np.abs(np.roll(corners, -1, axis=0) - corners)
    right_angled = bool((sides.min(axis=1) <= 1e-9 * sides.max()).all())
    short, long = sorted(indenter.reach(0.0))
    return right_angled and long <= LONGEST_CROWDED * short


def resolutions(indenter: Indenter, *, fine: bool) -> tuple[int, ...]:
    """Return elements per radius of the circle of equal area."""
    if not second_order(indenter):
        return 5, 7, 9  # trilinear cells, and a staircase along oblique edges
    if isinstance(indenter, PolygonPunch):
        return 3, 4, 5
    return (4, 6, 8) if fine else (3, 4, 6)


def face_grid(geometry: IndenterGeometry, resolution: int) -> fem.TensorMesh:
    """Return the mesh lines of a face; on the positive side only, where it is its mirror image."""
    indenter = geometry.indenter
    assert indenter.outline is not None
    crowded = second_order(indenter)
    lines = []
    for marks, half, mirrored in zip(
        indenter.outline.T, geometry.reach, indenter.even, strict=True
    ):
        # On the short side of a long face no fewer cells than a square would have: else the series
        # of resolutions would refine the long side only, and tell nothing.
        square = round(np.sqrt(np.pi) / 2 * resolution)
        count = max(2, square, round(half * resolution / geometry.contact_radius))
        if mirrored:
            marks = np.append(np.abs(marks), 0.0)
        # through the marks, but for those too close to another
        step = half / count
        first, *inner, last = np.unique(marks)
        through = [first]
        for mark in inner:
            if min(mark - through[-1], last - mark) > 0.5 * step:
                through.append(mark)
        through.append(last)
        # Crowded, lines come closer to the marks with the square of their number; not to the first
        # one where that is a plane of symmetry and no edge.
        parts = []
        for low, high in pairwise(through):
            share = np.linspace(0.0, 1.0, 1 + max(2, round((high - low) / step)))[:-1]
            if crowded and (low > first or not mirrored):
                share = np.where(share < 0.5, 2.0 * share**2, 1.0 - 2.0 * (1.0 - share) ** 2)
            elif crowded:
                share = 1.0 - (1.0 - share) ** 2
            parts.append(low + (high - low) * share)
        lines.append(np.append(np.concatenate(parts), last))
    return fem.TensorMesh(lines[0], lines[1], SYMMETRIES[indenter.even], 2 if crowded else 1)


def face_gap(geometry: IndenterGeometry, points: np.ndarray) -> np.ndarray:
    """Return 0 at points on the face and inf beside; a node on a side belongs to the face."""
    indenter, (x, y) = geometry.indenter, points.T
    assert indenter.outline is not None
    near = distance_to_outline(x, y, indenter.outline) < 1e-9 * geometry.contact_radius
    return np.where(near, 0.0, indenter.gap(x, y))
