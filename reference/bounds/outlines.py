"""Outlines of contacts that are star-shaped about the origin, cut down by their symmetries."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from reference.arrays import Array

# Of a polygon's size: how far a corner may lie from the image of another one, and a corner or the
# middle of a side from the mirror line that goes through it.
_SYMMETRIC, _ON_AXIS = 1e-9, 4e-9


@dataclass(frozen=True, eq=False)
class Outline:
    """One part of an outline, of which the whole consists of images.

    Points (m + 1, 2) in the order of their angle, with straight lines between them; in a closed
    outline, which has one image, the last is followed by the first. The images (g, 2, 2) are
    rotations and reflections, the identity among them. The extents are the largest |x| and |y| of
    an outline whose images are the mirrors of these axes, or of no symmetry; twice the same for
    others.
    """

    points: Array
    images: Array
    closed: bool = False
    extents: tuple[float, float] = (1.0, 1.0)

    @property
    def size(self) -> float:
        """Length of the outline's narrow direction, a half of it."""
        return min(self.extents)

    def stretched(self, x: float, y: float) -> Outline:
        """Stretch along the axes, unequally only where the images are the mirrors of these."""
        a, b = self.extents
        return replace(self, points=self.points * [x, y], extents=(x * a, y * b))

    def shells(self, inner: Array, outer: Array) -> Array:
        """Points on copies of the outline, shape (n, m + 1, 2).

        Inside by factors that increase to 1, outside confocal with it at growing distances in units
        of `size`, if these do not cross: an outline that is longer than wide gets rounder, as its
        far field does.
        """
        extents = np.array(self.extents)
        square = extents**2 - self.size**2
        grown = np.sqrt(square + ((self.size * (1 + outer)) ** 2)[:, None]) / extents
        inside = np.repeat(inner[:, None], 2, axis=1)
        confocal = np.concatenate([inside, grown])[:, None, :] * self.points
        if nested(confocal, closed=self.closed):
            return confocal
        # a hollow outline, or one that is longest along no axis, would cross such copies
        similar = np.concatenate([inner, 1 + outer * self.size / max(self.extents)])
        return similar[:, None, None] * self.points


def nested(shells: Array, *, closed: bool) -> bool:
    """Whether the triangles of a fan between shells cover the plane once (see `dirichlet.fan`)."""
    after = np.roll(shells, -1, axis=1) if closed else shells[:, 1:]
    here = shells if closed else shells[:, :-1]
    core = _cross(here[0], after[0])
    outer = _cross(here[1:] - here[:-1], after[1:] - here[:-1])
    inner = _cross(after[1:] - here[:-1], after[:-1] - here[:-1])
    return all(bool((turn > 0).all()) for turn in (core, outer, inner))


def _cross(first: Array, second: Array) -> Array:
    return np.asarray(first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0])


def polygon(vertices: Sequence[tuple[float, float]], cells: int, exponent: float) -> Outline:
    """Polygon that is star-shaped about the origin, cut down by its mirror lines through there.

    The vertices go counterclockwise, once round the origin, which sees every side. Symmetric to
    1e-9 of the size counts as symmetric: `slack` says what that may change. The outline is turned
    so that the first mirror line is the x axis; half a side between corners has as many points as
    cells, finer towards each corner by the exponent.
    """
    corners = np.asarray(vertices, dtype=float)
    if corners.ndim != 2 or corners.shape[1] != 2 or len(corners) < 3:
        raise ValueError(f"a polygon has three or more corners (x, y), got shape {corners.shape}")
    after = np.roll(corners, -1, axis=0)
    turns = _cross(corners, after)
    if not (turns > 0).all():
        raise ValueError(
            "the polygon must be given counterclockwise and be star-shaped about the origin: "
            f"sides {np.flatnonzero(~(turns > 0)).tolist()} are not seen from there"
        )
    rounds = np.arctan2(turns, (corners * after).sum(axis=1)).sum() / (2 * math.pi)
    if round(rounds) != 1:
        raise ValueError(f"the polygon crosses itself: it goes {rounds:.0f} times round the origin")
    # angles in [0, pi) of the lines through the origin that mirror the polygon onto itself
    size, axes = np.abs(corners).max(), list[float]()
    for x, y in np.concatenate([0.5 * (corners + after), corners]):
        angle = math.atan2(y, x) % math.pi
        c, s = math.cos(2 * angle), math.sin(2 * angle)
        image = corners @ np.array([[c, s], [s, -c]])
        apart = np.abs(image[:, None] - corners[None]).max(axis=2).min(axis=1)
        again = any(abs(math.sin(angle - axis)) < 1e-6 for axis in axes)
        if apart.max() < _SYMMETRIC * size and not again:
            axes.append(angle)
    axes.sort()
    if not axes:
        path = _path([*corners, corners[0]], [True] * (len(corners) + 1), cells, exponent)
        return Outline(path[:-1], np.eye(2)[None], closed=True, extents=_extents(path))

    # the corners between two neighbouring mirror lines, turned to start at the x axis; the ends are
    # corners, or middles of sides, which are not sharp
    turn = np.array(
        [[math.cos(axes[0]), -math.sin(axes[0])], [math.sin(axes[0]), math.cos(axes[0])]]
    )
    turned, angle = corners @ turn, math.pi / len(axes)
    middles = 0.5 * (turned + np.roll(turned, -1, axis=0))
    places = [(*p, True) for p in turned] + [(*p, False) for p in middles]
    near = _ON_AXIS * np.abs(corners).max()
    part: dict[float, tuple[float, bool]] = {}
    for x, y, sharp in places:
        at, radius = math.atan2(y, x) % (2 * math.pi), math.hypot(x, y)
        ends = [end for end in (0.0, angle) if 2 * radius * abs(math.sin(0.5 * (at - end))) < near]
        if ends:
            # a corner counts where the middle of a short side is as near
            part[ends[0]] = part.get(ends[0], (radius, sharp))
        elif sharp and at < angle:
            part[at] = radius, True
    ends_and_corners, sharps = [], []
    for at in sorted(part):
        radius, sharp = part[at]
        # exactly on the x axis for half turns
        y = 0.0 if at in (0.0, math.pi) else radius * math.sin(at)
        ends_and_corners.append((radius * math.cos(at), y))
        sharps.append(sharp)
    points = _path(ends_and_corners, sharps, cells, exponent)
    images = dihedral(len(axes))
    if len(axes) > 2:
        apothem = float((turns / np.hypot(*(after - corners).T)).min())
        return Outline(points, images, extents=(apothem, apothem))
    return Outline(points, images, extents=_extents(points))


def slack(vertices: Sequence[tuple[float, float]]) -> float:
    """Relative change of size between a polygon and one that is exactly symmetric.

    A punch that holds another one is not softer, and one of twice the size twice as stiff: so by
    this share the stiffness may change, too.
    """
    corners = np.asarray(vertices, dtype=float)
    after = np.roll(corners, -1, axis=0)
    near = (_cross(corners, after) / np.hypot(*(after - corners).T)).min()
    return float(2 * _ON_AXIS * np.abs(corners).max() / near)


def towards_edge(cells: int, exponent: float) -> Array:
    """Return factors (n + 1,) from 0 to 1, spaced more finely towards 1."""
    return np.asarray(1 - (1 - np.arange(cells + 1) / cells) ** exponent)


def circle(cells: int, images: Array, angle: float, exponent: float = 1.0) -> Outline:
    """Part of the unit circle from the x axis to an angle, in chords that get finer to there."""
    turn = angle * towards_edge(cells, exponent)
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
