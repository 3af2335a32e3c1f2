r"""Flat elliptic punches as a lower bound of the force, in closed form, for any shape.

An elliptic punch that sinks in by one, E* = 1, has the stiffness k = pi a/K(1 - b^2/a^2) and the
pressure k/(2 pi a b sqrt(1 - X^2/a^2 - Y^2/b^2)), the shadow of a uniform sphere; the surface sinks
by one everywhere on the ellipse and by less outside (Johnson 1985, section 3.5). So it is admitted
by the linear programme whose value is the force (Barber 1974, J. Strain Anal. 9, 230),

    F = max { int (d - g) dm : m >= 0, K m <= 1 where m > 0 }  >=  k (d - <g>),

with <g> the mean of the gap over the sphere: a bound for bodies that have no other formula. Several
ellipses carry more. Under the force f_j ellipse j sinks in by f_j/k_j, and a point outside by
f_j R_F(s, s + a_j^2, s + b_j^2)/pi, s the confocal coordinate of the point (R_F Carlson's
integral, `first_kind_above`). No point of another convex set with the support function h
lies within the confocal ellipse s if for any one direction n, c the vector between the middles,

    s <= (n . c - h(n))^2 - h_j(n)^2,    n . c > h(n),        h_j(n)^2 = a^2 n_1^2 + b^2 n_2^2,

which bounds the displacement on a whole ellipse, without a sample. The forces then follow from a
small linear programme, scaled so that every row of it holds. On rough surfaces they press on the
summits (`ellipses_below`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import linprog, minimize

from reference.arrays import Array
from reference.bounds.interval import EPSILON, Interval, above, below, complete, first_kind_above
from reference.bounds.trigonometric import Waves
from reference.closed_form.shapes import ellipsoid

# Two opposite corners of a rectangle, from the first point of a map.
Corners = tuple[tuple[float, float], tuple[float, float]]

# Searches in a row at most, each from the end of the last, while they improve the bound.
_SEARCHES = 5
# Directions in which two ellipses are separated: each gives a bound, and the best one counts.
_DIRECTIONS = 64
# Places per side of a face's box from which the roomiest are told, and how many of these.
_LOOKS, _STARTS = 15, 4
# Summits that are taken, from the highest, and rounds in which they make room for each other.
_SUMMITS, _ROUNDS = 40, 3
# Samples per point of the map on which summits are told from slopes.
_FINER = 4


def elliptic_stiffness(a: float, b: float) -> Interval:
    """Stiffness pi a/K(m) of an elliptic punch for E* = 1, m = 1 - (b/a)^2 (Johnson 1985, 3.5).

    Only rounding makes it an interval: its pressure displaces the whole face equally.
    """
    long, short = max(a, b), min(a, b)
    least, most = complete((short / long) ** 2, 1.0, 1.0)
    product = math.pi * long
    return Interval(below(product / float(most), 4), above(product / float(least), 4))


@dataclass(frozen=True)
class Ellipse:
    """Middle, semi-axes, and the angle of the first of them to the x axis."""

    x: float
    y: float
    a: float
    b: float
    angle: float = 0.0

    @property
    def stiffness(self) -> float:
        """Lower bound of the stiffness for E* = 1; zero for an empty ellipse."""
        if not min(self.a, self.b) > 0:
            return 0.0
        return elliptic_stiffness(self.a, self.b).lower

    @property
    def axes(self) -> Array:
        """Vectors of the semi-axes as columns: the ellipse is this matrix times the unit disc."""
        cosine, sine = math.cos(self.angle), math.sin(self.angle)
        return np.array([[self.a * cosine, -self.b * sine], [self.a * sine, self.b * cosine]])

    def scaled(self, factor: float) -> Ellipse:
        """Return the ellipse about the same middle, larger by a factor."""
        return replace(self, a=factor * self.a, b=factor * self.b)


def force_of_ellipse(gap: MeanGap, ellipse: Ellipse, penetration: float) -> float:
    """Lower bound k (d - <g>) of the force for E* = 1, with the ellipse as `within` returns it."""
    missing = penetration - above(gap.above(ellipse), 4)
    return below(ellipse.stiffness * missing, 8) if missing > 0 else 0.0


def best_ellipse(
    gap: MeanGap, penetration: float, starts: Sequence[Ellipse]
) -> tuple[Ellipse, float]:
    """Return the ellipse that proves most, over axes, place and angle, and the force for E* = 1.

    From each of the starts searches (Nelder & Mead) follow one another, each on a simplex about the
    end of the last: wherever they end, the bound holds.
    """

    def moved(ellipse: Ellipse, p: Array) -> Ellipse:
        # at most a factor of a million either way
        size = math.sqrt(ellipse.a * ellipse.b)
        a, b = (math.exp(float(np.clip(x, -14, 14))) for x in p[:2])
        x, y = ellipse.x + size * float(p[2]), ellipse.y + size * float(p[3])
        turned = Ellipse(x, y, ellipse.a * a, ellipse.b * b, ellipse.angle + float(p[4]))
        return gap.within(turned)

    def less(p: Array, about: Ellipse) -> float:
        ellipse = moved(about, p)
        # below zero, too, so that the search knows where to go
        return -ellipse.stiffness * (penetration - gap.above(ellipse))

    simplex = np.concatenate([np.zeros((1, 5)), np.diag([0.3, -0.3, 0.2, 0.2, 0.3])])
    options = {"initial_simplex": simplex, "xatol": 1e-4, "maxfev": 400}
    best, most = starts[0], 0.0
    for start in starts:
        ellipse, force = start, 0.0
        for _ in range(_SEARCHES):
            again = ellipse
            if min(ellipse.a, ellipse.b) > 0:
                options["fatol"] = 1e-7 * ellipse.stiffness * penetration
                zero = np.zeros(5)
                search = minimize(less, zero, ellipse, method="Nelder-Mead", options=options)
                again = moved(ellipse, search.x)
            gained = force_of_ellipse(gap, again, penetration)
            enough = gained <= force * (1 + 1e-5)
            if gained > force:
                ellipse, force = again, gained
            if enough:
                break
        if force > most:
            best, most = ellipse, force
    return best, most


def force_of_ellipses(gap: MeanGap, ellipses: Sequence[Ellipse], penetration: float) -> float:
    """Lower bound of the force by ellipses that press together, for E* = 1."""
    ellipses = [ellipse for ellipse in ellipses if ellipse.stiffness > 0]
    forces = shares(gap, ellipses, penetration)
    work = [penetration - above(gap.above(ellipse), 4) for ellipse in ellipses]
    return max(below(math.fsum(f * w for f, w in zip(forces, work, strict=True)), 16), 0.0)


def shares(gap: MeanGap, ellipses: Sequence[Ellipse], penetration: float) -> Array:
    """Return forces that push the surface nowhere they act deeper than one, for E* = 1."""
    work = np.array([penetration - gap.above(ellipse) for ellipse in ellipses])
    depths = deepest(ellipses)
    loaded = work > 0
    forces = np.zeros(len(ellipses))
    # ellipses that carry nothing need not be spared by the others
    while loaded.any():
        some = np.flatnonzero(loaded)
        part = depths[np.ix_(some, some)]
        # in units of each ellipse's own stiffness and of the best one: all of order one
        own = np.diag(part)
        gain = work[some] / own
        result = linprog(-gain / gain.max(), A_ub=part / own, b_ub=np.ones(len(some)))
        if result.x is None:
            break
        trial = np.zeros(len(ellipses))
        trial[some] = np.maximum(result.x, 0.0) / own
        pressed = trial[some] > 1e-9 / own
        trial[some[~pressed]] = 0.0
        under = depths[np.ix_(trial > 0, trial > 0)] @ trial[trial > 0]
        trial /= above(float(under.max(initial=1.0)), len(some) + 8)
        if trial @ work > forces @ work:
            forces = trial
        if pressed.all():
            break
        loaded = trial > 0
    return forces


def deepest(ellipses: Sequence[Ellipse]) -> Array:
    """Upper bounds (k, j) of the displacement on ellipse k under unit force on ellipse j."""
    count = len(ellipses)
    own = np.array([above(1 / ellipse.stiffness, 2) for ellipse in ellipses])
    axes = [ellipse.a for ellipse in ellipses], [ellipse.b for ellipse in ellipses]
    confocal = np.zeros((count, count))
    turns = np.linspace(0, 2 * np.pi, _DIRECTIONS, endpoint=False)
    for j, source in enumerate(ellipses):
        for k, target in enumerate(ellipses):
            away = math.atan2(target.y - source.y, target.x - source.x)
            n = np.stack([np.cos(away + turns), np.sin(away + turns)])
            wide, narrow = (np.hypot(*(e.axes.T @ n)) for e in (target, source))
            middle = (target.x - source.x) * n[0] + (target.y - source.y) * n[1]
            reach = np.maximum(middle - wide * (1 + 16 * EPSILON), 0.0) * (1 - 64 * EPSILON)
            confocal[k, j] = float((reach**2 - narrow**2 * (1 + 64 * EPSILON)).max())
    np.fill_diagonal(confocal, 0.0)
    depths = np.tile(own, (count, 1))
    apart = confocal > 0
    a, b = (np.tile(axis, (count, 1))[apart] for axis in axes)
    s = confocal[apart]
    integral = first_kind_above(s, s + a**2, s + b**2)
    depths[apart] = np.minimum(depths[apart], integral / np.pi * (1 + 4 * EPSILON))
    return depths


class Face:
    """A flat face with the outline of a simple polygon (n, 2), whichever way it goes round."""

    def __init__(self, vertices: ArrayLike) -> None:
        self.corners = np.asarray(vertices, dtype=float)

    def within(self, ellipse: Ellipse) -> Ellipse:
        """Return the largest ellipse of these axes about this middle; of no size if it is outside.

        Mapped to the unit circle: the nearest side is as far away as the ellipse may grow.
        """
        seen = np.linalg.solve(ellipse.axes, (self.corners - [ellipse.x, ellipse.y]).T).T
        # inside if an odd number of sides cross the ray along x
        after = np.roll(seen, -1, axis=0)
        straddles = (seen[:, 1] > 0) != (after[:, 1] > 0)
        turn = seen[:, 0] * after[:, 1] - seen[:, 1] * after[:, 0]
        right = (turn > 0) == (after[:, 1] > seen[:, 1])
        if (straddles & right).sum() % 2 == 0:
            return ellipse.scaled(0.0)
        side = after - seen
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


class ConvexGap:
    r"""A convex gap ``gap(x, y)`` on arrays, by its values.

    Around a circle on the sphere's shadow, of radius r, the points of an arc between two tangents
    are means of the points of contact and of the corner where the tangents meet; the mean over the
    arc of a convex function is not above that of its values there, with the weights that place
    the arc's middle. These means M(r) are convex again, and not above their chords over rings. The
    excess is of second order in the numbers of rings and arcs.
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
        # places (rings, arcs, 2) of contact and of corners, and what they count
        self._parts = [
            (radius[:, None, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1), share / arcs)
            for radius, angle, share in (
                (r, touching, 1 - corner),
                (r / math.cos(half), touching + half, corner),
            )
        ]
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


# What can be averaged over the pressure of an elliptic punch: `within` scales an ellipse to lie
# where there is material, to nothing if none; `above` is an upper bound of <g> on such a one.
MeanGap = Face | ConvexGap | WavyGap


def ellipses_below(waves: Waves, top: float, corners: Corners, penetration: float) -> float:
    """Lower bound of the force on a rectangle of a rough surface, for E* = 1.

    The penetration is counted from the height `top`.
    """
    gap = WavyGap(waves, top, corners)
    # the search begins from ellipses of Hertz's theory on the highest summits
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


def _derivatives(waves: Waves, place: Array) -> tuple[Array, Array]:
    """Slope of the height, and its curvatures with the sign of the gap's."""
    x, y = place[:1], place[1:]
    dx, dy, xx, xy, yy = (
        float(waves.on(x, y, order)[0, 0]) for order in ((1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
    )
    return np.array([dx, dy]), -np.array([[xx, xy], [xy, yy]])
