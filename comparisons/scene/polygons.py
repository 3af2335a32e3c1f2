"""Plane polygons: area, sides, crossings, distance from the outline, offsets, shares of cells."""

from __future__ import annotations

import numpy as np


def distance_to_outline(x: np.ndarray, y: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Return the distance of points from the sides of a closed polygon with corners (n, 2).

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

    def side(p: np.ndarray, q: np.ndarray, s: np.ndarray) -> np.ndarray:
        edge, to = q - p, s - p
        return np.sign(edge[..., 0] * to[..., 1] - edge[..., 1] * to[..., 0])

    start, end = corners, np.roll(corners, -1, axis=0)
    if np.any(np.all(start == end, axis=1)):
        return True
    n = len(corners)
    for i in range(n - 2):
        beyond = np.arange(i + 2, n - 1 if i == 0 else n)
        a, b, c, d = start[i], end[i], start[beyond], end[beyond]
        straddled = (side(a, b, c) * side(a, b, d) <= 0) & (side(c, d, a) * side(c, d, b) <= 0)
        boxes = (np.minimum(a, b) <= np.maximum(c, d)) & (np.minimum(c, d) <= np.maximum(a, b))
        if np.any(straddled & np.all(boxes, axis=-1)):
            return True
    return False


def offset_outline(corners: np.ndarray, distance: float) -> np.ndarray:
    """Return the outline with every side moved outwards by a distance, sides still meeting.

    Counter-clockwise corners (n, 2). A corner sharper than 25 degrees moves as one of 25 degrees.

    >>> square = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])
    >>> offset_outline(square, 0.5).tolist()
    [[-0.5, -0.5], [2.5, -0.5], [2.5, 2.5], [-0.5, 2.5]]
    """
    along = np.roll(corners, -1, axis=0) - corners
    along = along / np.linalg.norm(along, axis=1)[:, None]
    outwards = np.stack([along[:, 1], -along[:, 0]], axis=1)
    before = np.roll(outwards, 1, axis=0)
    bend = np.maximum(1 + (outwards * before).sum(axis=1), 1 - np.cos(np.radians(25)))
    return np.asarray(corners + distance * (outwards + before) / bend[:, None])


def area_fractions(
    corners: np.ndarray,
    shape: tuple[int, int],
    spacing: tuple[float, float],
    origin: tuple[float, float],
) -> np.ndarray:
    """Return the share of each grid cell inside a simple polygon, exact to round-off.

    Every side is cut where it crosses a grid line; a piece inside one cell adds what lies between
    it and the right side of its cell, and its height to all cells further right in that row (the
    coverage sums of scan-line rasterisers). The corners (n, 2) come in order, either way round, all
    inside the grid, whose lower left corner is the origin.

    >>> triangle = np.array([[0.0, 0.0], [2.0, 0.0], [0.0, 2.0]])
    >>> area_fractions(triangle, (2, 2), (1.0, 1.0), (0.0, 0.0)).tolist()
    [[1.0, 0.5], [0.5, 0.0]]
    """
    start = (np.asarray(corners, dtype=float) - origin) / spacing
    side = np.roll(start, -1, axis=0) - start
    # where each side crosses grid lines, as shares of its length, with its ends twice
    parts = []
    for axis in (0, 1):
        z, dz = start[:, axis], side[:, axis]
        first = np.ceil(np.minimum(z, z + dz))
        lines = first[:, None] + np.arange(int(np.max(np.abs(dz))) + 2)
        with np.errstate(divide="ignore", invalid="ignore"):
            crossings = (lines - z[:, None]) / dz[:, None]
        crossings = np.clip(np.where(np.isfinite(crossings), crossings, 1.0), 0.0, 1.0)
        parts += [np.broadcast_to([0.0, 1.0], (len(z), 2)), crossings]
    share = np.sort(np.concatenate(parts, axis=1), axis=1)
    points = start[:, None] + share[..., None] * side[:, None]
    middle = (points[:, 1:] + points[:, :-1]) / 2
    cells = [np.clip(np.floor(middle[..., k]).astype(int), 0, shape[k] - 1) for k in (0, 1)]
    rise = np.diff(points[..., 1], axis=1)
    shares = np.zeros((shape[0] + 1, shape[1]))
    np.add.at(shares, (cells[0], cells[1]), rise * (cells[0] + 1 - middle[..., 0]))
    further = np.zeros_like(shares)
    np.add.at(further, (cells[0] + 1, cells[1]), rise)
    # Counter-clockwise, what lies right of the right side is taken away from minus everything.
    inside = -np.sign(signed_area(corners)) * (shares + np.cumsum(further, axis=0))[:-1]
    # A cell outside comes out as round-off.
    return np.where(inside < 1e-12, 0.0, np.minimum(inside, 1.0))
