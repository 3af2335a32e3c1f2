r"""Means of gaps under the pressure of elliptic punches: faces, convex bodies, sums of waves.

The pressure is the shadow of a uniform sphere over the ellipse. What stands here is exact, or not
below the mean: a bound of the force needs no more (`reference.bounds.ellipses`).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.bounds.ellipses import Ellipse
from reference.bounds.heights import Waves
from reference.bounds.interval import EPSILON

Array = NDArray[np.float64]

# Places per side of a face's box from which the roomiest are told, and how many of these.
_LOOKS, _STARTS = 15, 4


class Face:
    """A flat face with the outline of a simple polygon, whichever way it goes round.

    Parameters
    ----------
    vertices : (n, 2)
    """

    def __init__(self, vertices: ArrayLike) -> None:
        self.corners = np.asarray(vertices, dtype=float)

    def within(self, ellipse: Ellipse) -> Ellipse:
        """Return the largest ellipse of these axes about this middle; of no size if it is outside.

        Mapped to the unit circle: the nearest side is as far away as the ellipse may grow.
        """
        seen = np.linalg.solve(ellipse.axes, (self.corners - [ellipse.x, ellipse.y]).T).T
        if not _inside(seen):
            return ellipse.scaled(0.0)
        side = np.roll(seen, -1, axis=0) - seen
        along = np.clip(-(seen * side).sum(axis=1) / (side**2).sum(axis=1), 0.0, 1.0)
        nearest = float(np.hypot(*(seen + along[:, None] * side).T).min())
        # rounding of the map, in the corners that lie farthest
        loss = 64 * EPSILON * float(np.abs(seen).max()) * max(ellipse.a, ellipse.b)
        room = nearest - loss / min(ellipse.a, ellipse.b)
        return ellipse.scaled(max(room, 0.0))

    def starts(self) -> list[Ellipse]:
        """Return ellipses on the roomiest places of the face, in three directions each."""
        low, high = self.corners.min(axis=0), self.corners.max(axis=0)
        steps = (np.arange(_LOOKS) + 0.5) / _LOOKS
        size = float((high - low).max())
        places = [low + (high - low) * [u, v] for u in steps for v in steps]
        circles = [self.within(Ellipse(float(x), float(y), size, size)) for x, y in places]
        starts: list[Ellipse] = []
        for circle in sorted(circles, key=lambda ellipse: -ellipse.a)[: _LOOKS**2 // 2]:
            apart = [math.hypot(circle.x - e.x, circle.y - e.y) > e.a for e in starts]
            if all(apart) and circle.a > 0 and len(starts) < _STARTS:
                starts.append(circle)
        turns = (0.0, math.pi / 3, 2 * math.pi / 3)
        return [replace(e, b=0.6 * e.a, angle=turn) for e in starts for turn in turns]

    def above(self, ellipse: Ellipse) -> float:
        """Return zero."""
        return 0.0


def _inside(corners: Array) -> bool:
    """Whether the origin lies inside a polygon: sides that cross the ray along x (even and odd)."""
    after = np.roll(corners, -1, axis=0)
    straddles = (corners[:, 1] > 0) != (after[:, 1] > 0)
    turn = corners[:, 0] * after[:, 1] - corners[:, 1] * after[:, 0]
    right = (turn > 0) == (after[:, 1] > corners[:, 1])
    return bool((straddles & right).sum() % 2)


class ConvexGap:
    r"""A convex gap, by its values.

    Around a circle on the sphere's shadow, of radius r, the points of an arc between two tangents
    are means of the points of contact and of the corner where the tangents meet; the mean over the
    arc of a convex function is not above that of its values there, with the weights that place
    the arc's middle. These means M(r) are convex again, and not above their chords over rings.

    Parameters
    ----------
    gap : callable
        ``gap(x, y)``, convex, on arrays.
    rings, arcs : int
        The excess is of second order in both.
    """

    def __init__(self, gap: Callable[[Array, Array], Array], rings: int = 64, arcs: int = 48):
        self._gap = gap
        turn = np.linspace(0, 0.5 * np.pi, rings + 1)
        r, half = np.sin(turn), np.pi / arcs
        weight = -np.diff(np.cos(turn))
        lever = 0.5 * np.diff(turn - np.sin(turn) * np.cos(turn))
        # of the chord's two ends in the integral over a ring
        outer = (lever - r[:-1] * weight) / np.diff(r)
        self._weights = np.append(weight - outer, 0.0) + np.insert(outer, 0, 0.0)
        touching: Array = np.arange(float(arcs)) * 2 * half
        corner = (math.sin(half) / half - math.cos(half)) / (1 / math.cos(half) - math.cos(half))
        self._parts = (
            (_polar(r, touching), (1 - corner) / arcs),
            (_polar(r / math.cos(half), touching + half), corner / arcs),
        )
        self._rounding = 64 * (rings + arcs) * EPSILON

    def within(self, ellipse: Ellipse) -> Ellipse:
        """Return the ellipse: the gap has no end."""
        return ellipse

    def above(self, ellipse: Ellipse) -> float:
        """Return the mean of the chords."""
        total = size = 0.0
        for places, share in self._parts:
            x, y = np.moveaxis(places @ ellipse.axes.T, -1, 0)
            around = self._gap(ellipse.x + x, ellipse.y + y)
            total += share * float(self._weights @ around.sum(axis=1))
            size += share * float(np.abs(around).max()) * around.shape[1]
        return total + self._rounding * size


def _polar(r: Array, angle: Array) -> Array:
    """Points (rings, arcs, 2)."""
    return r[:, None, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)


class WavyGap:
    r"""Gap of a band-limited surface over a rectangle: every wave times sin(s)/s, exact.

    The mean of exp(i q . x) over the shadow of a sphere of semi-axes a, b is exp(i q . c) sin(s)/s
    with s^2 = (a q_1)^2 + (b q_2)^2, as a plane cuts a sphere in equal heights.

    Parameters
    ----------
    waves : Waves
    top : float
        Height from which the gap is counted.
    corners : ((float, float), (float, float))
        Two opposite corners of the rectangle, from the first point of the map.
    """

    def __init__(
        self, waves: Waves, top: float, corners: tuple[tuple[float, float], tuple[float, float]]
    ) -> None:
        self._waves, self._top = waves, top
        (x0, y0), (x1, y1) = corners
        self._face = Face([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])

    def within(self, ellipse: Ellipse) -> Ellipse:
        """Return the ellipse, made smaller if it would leave the rectangle."""
        largest = self._face.within(ellipse)
        return largest if largest.a < ellipse.a else ellipse

    def above(self, ellipse: Ellipse) -> float:
        """Return the mean, with rounding."""
        mean = self._waves.mean_under(np.array([ellipse.x, ellipse.y]), ellipse.axes)
        return self._top - mean + 4 * self._waves.rounding + 4 * EPSILON * abs(self._top)
