"""Overlaps of the faces of two meshes: convex polygons divided into triangles."""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

# The intersection of two convex quadrilaterals has at most eight corners.
MOST_CORNERS = 8
# Slivers below this fraction of a face are rounding at shared edges and are dropped.
SLIVER = 1e-12


def overlap_triangles(
    first: NDArray[np.float64], second: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return the intersections of the faces of two plane meshes (Puso & Laursen 2004).

    Parameters
    ----------
    first, second : (m, 4, 2), (n, 4, 2)
        Corners of convex quadrilaterals in cyclic order of either sense.

    Returns
    -------
    triangles : (t, 3, 2)
        Disjoint triangles that cover the common area.
    owners : (t, 2)
        The faces of `first` and `second` that contain the triangles.

    Examples
    --------
    >>> square = np.array([[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]])
    >>> triangles, owners = overlap_triangles(square, square + 0.5)
    >>> edges = triangles[:, 1:] - triangles[:, :1]
    >>> float(abs(np.linalg.det(edges)).sum() / 2)
    0.25
    """
    first, second = _turned(first), _turned(second)
    pairs = _close_pairs(first, second)
    return _cut(first, second, np.ascontiguousarray(pairs))


def _turned(faces: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the faces counter-clockwise."""
    across = faces[:, 2] - faces[:, 0], faces[:, 3] - faces[:, 1]
    clockwise = across[0][:, 0] * across[1][:, 1] - across[0][:, 1] * across[1][:, 0] < 0.0
    return np.where(clockwise[:, None, None], faces[:, ::-1], faces)


def _close_pairs(first: NDArray[np.float64], second: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return pairs with overlapping bounding boxes."""
    low = np.maximum(first.min(axis=1)[:, None], second.min(axis=1))
    high = np.minimum(first.max(axis=1)[:, None], second.max(axis=1))
    return np.argwhere((high > low).all(axis=-1))


@numba.njit(cache=True)
def _cut(first, second, pairs):
    triangles = np.empty((len(pairs) * MOST_CORNERS, 3, 2))
    owners = np.empty((len(pairs) * MOST_CORNERS, 2), dtype=np.int64)
    count = 0
    polygon, spare = np.empty((2 * MOST_CORNERS, 2)), np.empty((2 * MOST_CORNERS, 2))
    for first_cell, second_cell in pairs:
        corners = first.shape[1]
        for k in range(corners):
            _put(polygon, k, first[first_cell, k])
        for side in range(4):
            a, b = second[second_cell, side], second[second_cell, (side + 1) % 4]
            corners = _half_plane(polygon, corners, a, b, spare)
            polygon, spare = spare, polygon
        area = _double_area(first[first_cell], 4)
        if corners < 3 or _double_area(polygon, corners) < SLIVER * area:
            continue
        for k in range(1, corners - 1):
            _put(triangles[count], 0, polygon[0])
            _put(triangles[count], 1, polygon[k])
            _put(triangles[count], 2, polygon[k + 1])
            owners[count, 0], owners[count, 1] = first_cell, second_cell
            count += 1
    return triangles[:count], owners[:count]


@numba.njit(cache=True)
def _half_plane(polygon, corners, a, b, result):
    """Clip polygons to the left of the line from a to b (Sutherland & Hodgman 1974)."""
    count = 0
    for k in range(corners):
        p, q = polygon[k], polygon[(k + 1) % corners]
        side = (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
        next_side = (b[0] - a[0]) * (q[1] - a[1]) - (b[1] - a[1]) * (q[0] - a[0])
        if side >= 0.0:
            _put(result, count, p)
            count += 1
        if (side > 0.0 and next_side < 0.0) or (side < 0.0 and next_side > 0.0):
            share = side / (side - next_side)
            result[count, 0] = p[0] + share * (q[0] - p[0])
            result[count, 1] = p[1] + share * (q[1] - p[1])
            count += 1
    return count


@numba.njit(cache=True)
def _put(points, k, point):
    """Store a point in a list; a row assigned as a whole takes a second to compile."""
    points[k, 0], points[k, 1] = point[0], point[1]


@numba.njit(cache=True)
def _double_area(polygon, corners):
    total = 0.0
    for k in range(corners):
        p, q = polygon[k], polygon[(k + 1) % corners]
        total += p[0] * q[1] - p[1] * q[0]
    return total
