"""Flat elliptic punches on the summits of a rough surface: what they prove of its force at once."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from reference.bounds.ellipses import (
    Ellipse,
    best_ellipse,
    deepest,
    force_of_ellipses,
    shares,
)
from reference.bounds.heights import Waves
from reference.bounds.mean_gaps import WavyGap
from reference.closed_form.elliptic import ellipsoid

Array = NDArray[np.float64]

# Summits that are taken, from the highest, and rounds in which they make room for each other.
_SUMMITS, _ROUNDS = 40, 3
# Samples per point of the map on which summits are told from slopes.
_FINER = 4


def ellipses_below(
    waves: Waves,
    top: float,
    corners: tuple[tuple[float, float], tuple[float, float]],
    penetration: float,
) -> float:
    """Lower bound of the force on a rectangle of a rough surface, for E* = 1.

    Parameters
    ----------
    waves : Waves
    top : float
        Height from which the penetration is counted.
    corners : ((float, float), (float, float))
        Two opposite corners of the rectangle, from the first point of the map.
    penetration : float
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
    gap: WavyGap,
    waves: Waves,
    top: float,
    corners: tuple[tuple[float, float], tuple[float, float]],
    penetration: float,
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
    highest = np.argsort(-heights[rows, columns])[:_SUMMITS]
    step = min((x1 - x0) / waves.points[0], (y1 - y0) / waves.points[1])
    places = [_climbed(gap, waves, float(x[rows[k]]), float(y[columns[k]]), step) for k in highest]
    ellipses = [_hertz(waves, top, place, penetration, step) for place in places]
    return [ellipse for ellipse in ellipses if ellipse is not None]


def _climbed(gap: WavyGap, waves: Waves, x: float, y: float, step: float) -> tuple[float, float]:
    """Place of the summit next to a sample, by Newton's method; the sample if it runs away."""
    place = np.array([x, y])
    for _ in range(4):
        slope, bend = _derivatives(waves, place)
        if np.linalg.eigvalsh(bend)[0] <= 0:
            break
        place = place + np.linalg.solve(bend, slope)
        # a rim is no summit, but what is highest there may carry as one
        if np.abs(place - [x, y]).max() > step or _off_the_patch(gap, place, step):
            return x, y
    return float(place[0]), float(place[1])


def _off_the_patch(gap: WavyGap, place: Array, step: float) -> bool:
    return gap.within(Ellipse(float(place[0]), float(place[1]), step, step)).a == 0


def _derivatives(waves: Waves, place: Array) -> tuple[Array, Array]:
    """Slope of the height, and its curvatures with the sign of the gap's."""
    x, y = place[:1], place[1:]
    dx, dy, xx, xy, yy = (
        float(waves.on(x, y, order)[0, 0]) for order in ((1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
    )
    return np.array([dx, dy]), -np.array([[xx, xy], [xy, yy]])


def _hertz(
    waves: Waves, top: float, place: tuple[float, float], penetration: float, step: float
) -> Ellipse | None:
    """Contact ellipse of the paraboloid at a summit, if it is reached; no longer than some points.

    Of a plane part of the surface curvatures are taken as a hundredth of the other one.
    """
    at = np.array(place)
    depth = penetration - top + float(waves.on(at[:1], at[1:])[0, 0])
    if depth <= 0:
        return None
    bends, turn = np.linalg.eigh(_derivatives(waves, at)[1])
    bends = np.maximum(bends, max(float(np.abs(bends).max()) * 1e-2, depth / (8 * step) ** 2))
    a, b = ellipsoid(1 / bends[0], 1 / bends[1], 1.0).semi_axes(depth)
    return Ellipse(*place, float(a), float(b), math.atan2(turn[1, 0], turn[0, 0]))
