"""Plane polygons: area, sides, crossings, distance from the outline."""

from __future__ import annotations

import numpy as np


def distance_to_outline(x: np.ndarray, y: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Return the distance of points from the sides of a closed polygon with corners (n, 2).

    Examples
    --------
    >>> square = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])
    >>> [float(d) for d in distance_to_outline(np.array([1.0, 3.0]), np.array([0.5, 3.0]), square)]
    [0.5, 1.4142135623730951]
    """
    points = np.stack([x, y], axis=-1)
    nearest = np.full(np.shape(x), np.inf)
    for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        side = end - start
        share = np.clip((points - start) @ side / (side @ side), 0, 1)
        foot = start + share[..., None] * side
        nearest = np.minimum(nearest, np.linalg.norm(points - foot, axis=-1))
    return nearest


def signed_area(corners: np.ndarray) -> float:
    """Return the area by the shoelace formula, positive for counter-clockwise corners (n, 2)."""
    x, y = (corners - corners[0]).T
    return float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) / 2)


def sides(corners: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return the sides as pairs of corners, the last one back to the first."""
    return list(zip(corners, np.roll(corners, -1, axis=0), strict=True))


def crosses_itself(corners: np.ndarray) -> bool:
    """Whether two sides that are not neighbours meet, or a side has no length."""
    start, end = corners, np.roll(corners, -1, axis=0)
    if np.any(np.all(start == end, axis=1)):
        return True
    n = len(corners)
    for i in range(n - 2):
        others = np.arange(i + 2, n - 1 if i == 0 else n)
        if len(others) and np.any(_meet(start[i], end[i], start[others], end[others])):
            return True
    return False


def _meet(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray) -> np.ndarray:
    """Whether the segment ab meets each of the segments cd."""

    def side(p: np.ndarray, q: np.ndarray, s: np.ndarray) -> np.ndarray:
        edge, to = q - p, s - p
        return np.sign(edge[..., 0] * to[..., 1] - edge[..., 1] * to[..., 0])

    straddled = (side(a, b, c) * side(a, b, d) <= 0) & (side(c, d, a) * side(c, d, b) <= 0)
    boxes = np.all(
        (np.minimum(a, b) <= np.maximum(c, d)) & (np.minimum(c, d) <= np.maximum(a, b)), axis=-1
    )
    return straddled & boxes
