"""Flat elliptic punches on the summits of a rough surface: what they prove of its force at once."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from reference.bounds.ellipses import (
    Ellipse,
    Face,
    best_ellipse,
    deepest,
    force_of_ellipses,
    shares,
)
from reference.bounds.interval import EPSILON
from reference.bounds.trigonometric import Waves
from reference.closed_form.shapes import ellipsoid

Array = NDArray[np.float64]
# Two opposite corners of a rectangle, from the first point of a map.
Corners = tuple[tuple[float, float], tuple[float, float]]

# Summits that are taken, from the highest, and rounds in which they make room for each other.
_SUMMITS, _ROUNDS = 40, 3
# Samples per point of the map on which summits are told from slopes.
_FINER = 4


class WavyGap:
    r"""Gap of a band-limited surface, counted from the height `top`, over a rectangle: exact.

    The mean of exp(i q . x) over the shadow of a sphere of semi-axes a, b is exp(i q . c) sin(s)/s
    with s^2 = (a q_1)^2 + (b q_2)^2, as a plane cuts a sphere in equal heights.
    """

    def __init__(self, waves: Waves, top: float, corners: Corners) -> None:
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


def ellipses_below(waves: Waves, top: float, corners: Corners, penetration: float) -> float:
    """Lower bound of the force on a rectangle of a rough surface, for E* = 1.

    The penetration is counted from the height `top`.
    """
    gap = WavyGap(waves, top, corners)
    ellipses = _on_summits(gap, waves, top, corners, penetration)
    (x0, y0), (x1, y1) = corners
    whole = gap.within(Ellipse(0.5 * (x0 + x1), 0.5 * (y0 + y1), 0.4 * (x1 - x0), 0.4 * (y1 - y0)))
    large, best = best_ellipse(gap, penetration, [whole])
    depths = np.full(len(ellipses), penetration)
    for _ in range(_ROUNDS):
        fitted = [
            best_ellipse(gap, depth, [start]) for start, depth in zip(ellipses, depths, strict=True)
        ]
        ellipses = [ellipse for ellipse, force in fitted if force > 0]
        if not ellipses:
            break
        best = max(best, force_of_ellipses(gap, ellipses, penetration))
        best = max(best, force_of_ellipses(gap, [*ellipses, large], penetration))
        # what the others leave of the penetration
        forces = shares(gap, ellipses, penetration) * penetration
        sunk = deepest(ellipses)
        np.fill_diagonal(sunk, 0.0)
        depths = np.maximum(penetration - sunk @ forces, 0.05 * penetration)
    return best


def _on_summits(
    gap: WavyGap, waves: Waves, top: float, corners: Corners, penetration: float
) -> list[Ellipse]:
    """Ellipses of Hertz's theory on the highest summits: from where a search begins."""
    (x0, y0), (x1, y1) = corners
    count = [_FINER * n for n in waves.points]
    x, y = (
        low + (np.arange(float(n)) + 0.5) * (high - low) / n
        for low, high, n in zip((x0, y0), (x1, y1), count, strict=True)
    )
    heights = waves.on(x, y)
    around = np.pad(heights, 1, constant_values=-math.inf)
    summit = np.ones(heights.shape, dtype=bool)
    for i, j in ((0, 1), (2, 1), (1, 0), (1, 2), (0, 0), (0, 2), (2, 0), (2, 2)):
        summit &= heights >= around[i : i + count[0], j : j + count[1]]
    rows, columns = np.nonzero(summit)
    step = min((x1 - x0) / waves.points[0], (y1 - y0) / waves.points[1])

    ellipses = []
    for k in np.argsort(-heights[rows, columns])[:_SUMMITS]:
        sample = np.array([x[rows[k]], y[columns[k]]])
        # from the sample to the summit next to it by Newton's method; not if it runs away: a rim is
        # no summit, but what is highest there may carry as one
        place = sample
        for _ in range(4):
            slope, bend = _derivatives(waves, place)
            if np.linalg.eigvalsh(bend)[0] <= 0:
                break
            place = place + np.linalg.solve(bend, slope)
            far = np.abs(place - sample).max() > step
            if far or gap.within(Ellipse(float(place[0]), float(place[1]), step, step)).a == 0:
                place = sample
                break
        depth = penetration - top + float(waves.on(place[:1], place[1:])[0, 0])
        if depth <= 0:
            continue
        # the contact of the paraboloid there, no longer than some points; of a plane part of the
        # surface curvatures are taken as a hundredth of the other one
        bends, turn = np.linalg.eigh(_derivatives(waves, place)[1])
        bends = np.maximum(bends, max(float(np.abs(bends).max()) * 1e-2, depth / (8 * step) ** 2))
        a, b = ellipsoid(1 / bends[0], 1 / bends[1], 1.0).semi_axes(depth)
        angle = math.atan2(turn[1, 0], turn[0, 0])
        ellipses.append(Ellipse(float(place[0]), float(place[1]), float(a), float(b), angle))
    return ellipses


def _derivatives(waves: Waves, place: Array) -> tuple[Array, Array]:
    """Slope of the height, and its curvatures with the sign of the gap's."""
    x, y = place[:1], place[1:]
    dx, dy, xx, xy, yy = (
        float(waves.on(x, y, order)[0, 0]) for order in ((1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
    )
    return np.array([dx, dy]), -np.array([[xx, xy], [xy, yy]])
