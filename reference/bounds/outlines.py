"""Outlines of contacts that are star-shaped about the origin, cut down by their symmetries."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Outline:
    """One part of an outline, of which the whole consists of images.

    Attributes
    ----------
    points : (m + 1, 2)
        In the order of their angle; straight lines between them.
    images : (g, 2, 2)
        Rotations and reflections, the identity among them.
    closed : bool
        Whether the last point is followed by the first (then there is one image).
    extents : (float, float)
        Largest |x| and |y| of an outline whose images are the mirrors of these axes, or of no
        symmetry; twice the same for others.
    """

    points: Array
    images: Array
    closed: bool = False
    extents: tuple[float, float] = (1.0, 1.0)

    @property
    def size(self) -> float:
        """Length of the outline's narrow direction, a half of it."""
        return min(self.extents)

    def scaled(self, size: float) -> Outline:
        """Return the outline times a length."""
        a, b = self.extents
        return replace(self, points=size * self.points, extents=(size * a, size * b))

    def stretched(self, x: float, y: float) -> Outline:
        """Stretch along the axes; only for outlines whose images are the mirrors of these."""
        a, b = self.extents
        return replace(self, points=self.points * [x, y], extents=(x * a, y * b))

    def shells(self, inner: Array, outer: Array) -> Array:
        """Points on copies of the outline, shape (n, m + 1, 2).

        Inside by factors of the outline up to 1, outside confocal with it: an outline that is
        longer than wide gets rounder, as its far field does.

        Parameters
        ----------
        inner : (k,)
            Increasing to 1.
        outer : (l,)
            Growing distances from the outline, in units of `size`.
        """
        extents = np.array(self.extents)
        square = extents**2 - self.size**2
        grown = np.sqrt(square + ((self.size * (1 + outer)) ** 2)[:, None]) / extents
        factors = np.concatenate([np.repeat(inner[:, None], 2, axis=1), grown])
        return factors[:, None, :] * self.points[None]


def regular_polygon(sides: int, cells: int, exponent: float) -> Outline:
    """Polygon of apothem 1, its first side's middle on the x axis.

    Parameters
    ----------
    sides : int
    cells : int
        Points on half a side, finer towards the corner.
    exponent : float
        Of that refinement.
    """
    half = math.tan(math.pi / sides)
    across = half * (1 - (1 - np.arange(cells + 1) / cells) ** exponent)
    return Outline(np.stack([np.ones(cells + 1), across], axis=1), dihedral(sides))


def rectangle(length: float, width: float, cells: int, exponent: float) -> Outline:
    """Rectangle about the origin, by its quarter."""
    a, b = 0.5 * length, 0.5 * width
    path = [(a, 0.0), (a, b), (0.0, b)]
    points = _path(path, [False, True, False], cells, exponent)
    return Outline(points, dihedral(2), extents=(a, b))


def polygon(vertices: Sequence[tuple[float, float]], cells: int, exponent: float) -> Outline:
    """Polygon without symmetry, counterclockwise and star-shaped about the origin.

    Raises
    ------
    ValueError
        If a side is not seen from the origin in the positive sense of turning.
    """
    corners = np.asarray([*vertices, vertices[0]], dtype=float)
    turns = corners[:-1, 0] * corners[1:, 1] - corners[:-1, 1] * corners[1:, 0]
    if not (turns > 0).all():
        raise ValueError(
            "the polygon must be given counterclockwise and be star-shaped about the origin: "
            f"sides {np.flatnonzero(~(turns > 0)).tolist()} are not seen from there"
        )
    points = _path([tuple(c) for c in corners], [True] * len(corners), cells, exponent)
    return Outline(points[:-1], np.eye(2)[None], closed=True, extents=_extents(points))


def mirrored_polygon(path: Sequence[tuple[float, float]], cells: int, exponent: float) -> Outline:
    """Polygon with a mirror line through the origin, by the half from that line back to it.

    The mirror line is the x axis; the first and the last point of the path lie on it.
    """
    if path[0][1] != 0 or path[-1][1] != 0:
        raise ValueError("the path of a mirrored polygon starts and ends on the x axis")
    points = _path(path, [True] * len(path), cells, exponent)
    return Outline(points, np.array([np.eye(2), np.diag([1.0, -1.0])]), extents=_extents(points))


def circle(cells: int, images: Array, angle: float, exponent: float = 1.0) -> Outline:
    """Part of the unit circle from the x axis to an angle, in chords that get finer to there."""
    turn = angle * (1 - (1 - np.arange(cells + 1) / cells) ** exponent)
    return Outline(np.stack([np.cos(turn), np.sin(turn)], axis=1), images)


def dihedral(sides: int) -> Array:
    """Rotations by 2 pi/n and reflections at the x axis: the symmetries of a regular polygon."""
    angles = 2 * np.pi * np.arange(sides) / sides
    turns = np.array([[[math.cos(a), -math.sin(a)], [math.sin(a), math.cos(a)]] for a in angles])
    if sides in (1, 2, 4):
        turns = np.round(turns)
    return np.concatenate([turns, turns @ np.diag([1.0, -1.0])])


def _extents(points: Array) -> tuple[float, float]:
    x, y = np.abs(points).max(axis=0)
    return float(x), float(y)


def _path(
    corners: Sequence[tuple[float, float]], sharp: Sequence[bool], cells: int, exponent: float
) -> Array:
    """Points along straight lines, finer towards those ends that are sharp corners."""
    pieces = []
    for k, (start, end) in enumerate(pairwise(corners)):
        t = np.arange(cells + 1) / cells
        if sharp[k] and sharp[k + 1]:
            t = np.arange(2 * cells + 1) / cells
            fraction = np.where(t <= 1, 0.5 * t**exponent, 1 - 0.5 * np.abs(2 - t) ** exponent)
        elif sharp[k]:
            fraction = t**exponent
        elif sharp[k + 1]:
            fraction = 1 - (1 - t) ** exponent
        else:
            fraction = t
        line = np.asarray(start) + fraction[:, None] * (np.asarray(end) - np.asarray(start))
        pieces.append(line if k == 0 else line[1:])
    return np.concatenate(pieces)
