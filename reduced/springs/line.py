"""A row of springs under a profile: smooth with sub-cell edges, or with nodal sums as printed.

A smooth row is two half lines of monotone cubics; contact edge, force and energy are exact on them.
On a cell of width w and rise v, with the position s from 0 to 1, the height is
g = g_0 + v s (m_0 + s (3 - 2 m_0 - m_1 + s (m_0 + m_1 - 2))), m_0 and m_1 the slopes at its ends in
units of v/w, at most 3: then the cubic is monotone (Fritsch & Carlson 1980).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit

from reduced.errors import choice_faults, count_faults, positive_faults, refuse
from reduced.loads import EDGES
from reduced.profiles.quadrature import gauss_legendre
from reduced.profiles.section import Profile

_MARGIN = 4  # extra springs beyond the largest contact radius, for inverted loads
# Exact for the square of a cubic.
_NODES, _WEIGHTS = (tuple(map(float, part)) for part in gauss_legendre(4))
_EPSILON = float(np.finfo(float).eps)


@dataclass(frozen=True)
class Springs:
    """Springs of stiffness E* dx (19.14) under a profile, at x_i = (i + offset) dx, all i.

    dx is the contact radius at the largest load over `per_radius`, or `spacing`. Two discrete laws:

    - ``"sub_cell"``: between springs the profile is the monotone cubic through the heights and
      slopes at the springs, at x = 0 and at the profile's breakpoints, and the contact ends where
      that curve meets the surface, inside a cell. Interior springs have the stiffness E* dx, as
      printed; only edge cells are corrected. Force and radius converge as dx^4 for smooth profiles;
      parabola, cone and flat punch are exact for any alignment of the springs. (A profile ~ x^n
      near its tip or behind a breakpoint limits the order to n + 1.)
    - ``"nodal"``: the chapter's sums, F = E* dx sum (d - g_i) over springs with g_i < d, and
      a = dx/2 times their number: dx^2 in F and dx in a.

    E*, the effective modulus, is 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2.
    """

    profile: Profile
    effective_modulus: float
    per_radius: int = 40
    spacing: float | None = None
    edges: str = "sub_cell"
    offset: float = 0.5

    def __post_init__(self) -> None:
        wrong = positive_faults(effective_modulus=self.effective_modulus)
        wrong += row_faults(self.per_radius, self.spacing, self.edges, self.offset)
        refuse(wrong)

    def lay(self, largest: float) -> NodalLine | SmoothLine:
        """Return springs up to a contact radius, and some beyond."""
        spacing = largest / self.per_radius if self.spacing is None else self.spacing
        if spacing > largest:
            raise ValueError(
                f"spacing must be at most the contact radius {largest!r}, got {spacing!r}"
            )
        kind = SmoothLine if self.edges == "sub_cell" else NodalLine
        return kind(self.profile, spacing, self.offset, largest)


def row_faults(
    per_radius: int, spacing: float | None = None, edges: str = "sub_cell", offset: float = 0.5
) -> list[str]:
    """Return messages for invalid parameters of a row of springs."""
    wrong = [] if spacing is None else positive_faults(spacing=spacing)
    wrong += count_faults(per_radius=per_radius) + choice_faults("edges", edges, EDGES)
    return wrong if 0 <= offset < 1 else [*wrong, f"offset must be in [0, 1), got {offset!r}"]


class NodalLine:
    """Springs at (i + offset) dx without interpolation, for the chapter's sums.

    Springs reach a few beyond `largest`, the contact radius at the largest load.
    """

    def __init__(self, profile: Profile, spacing: float, offset: float, largest: float) -> None:
        x = np.concatenate(
            [_springs(spacing, offset, largest), _springs(spacing, 1 - offset, largest)]
        )
        heights = profile.height(x)
        self.heights = np.sort(heights[np.isfinite(heights) & (x < profile.edge)])
        self.spacing = spacing
        self.sums = np.append(0.0, np.cumsum(self.heights))
        self.squares = np.append(0.0, np.cumsum(self.heights**2))

    def respond(self, d: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Contact length, F/E* and energy/E* at penetrations d."""
        count = np.searchsorted(self.heights, d, side="left")
        force = count * d - self.sums[count]
        energy = (count * d * d - 2 * d * self.sums[count] + self.squares[count]) / 2
        return count * self.spacing, force * self.spacing, energy * self.spacing

    def deep_start(self, goal: np.ndarray) -> np.ndarray:
        """Penetrations on or beyond those that carry F/E* = goal."""
        count = np.arange(1, self.heights.size)
        force = self.spacing * (count * self.heights[1:] - self.sums[1:-1])
        index = np.minimum(np.searchsorted(force, goal, side="left") + 1, self.heights.size)
        return (goal / self.spacing + self.sums[index]) / index


class SmoothLine:
    """Springs joined by the monotone cubic through heights and slopes, with edges inside cells."""

    def __init__(self, profile: Profile, spacing: float, offset: float, largest: float) -> None:
        self.spacing = spacing
        places = []
        for place in (offset, 1 - offset):
            springs = _springs(spacing, place, largest)
            # knots: springs, the axis, breakpoints, a sharp edge
            x = springs if springs[0] == 0 else np.concatenate([[0.0], springs])
            marks = [b for b in profile.breakpoints if b < springs[-1]]
            if profile.edge <= springs[-1]:
                x = np.append(x[x < profile.edge], profile.edge)
            places.append(np.unique(np.concatenate([x, marks])) if marks else x)
        heights = profile.height(np.concatenate(places))
        if not np.isfinite(heights).all():
            # unbounded heights (a sphere): knots to one beyond the largest contact
            both = np.concatenate(places)
            wall = both[~np.isfinite(heights)].min()
            places = [x[x < wall] for x in places]
            for half, x in enumerate(places):
                beyond, step = max(largest, x[-1]), largest
                for _ in range(80):
                    step /= 2
                    if np.isfinite(profile.height(np.array([beyond + step])))[0]:
                        places[half] = np.append(x, beyond + step)
                        break
            heights = profile.height(np.concatenate(places))
        slopes = profile.slope(np.concatenate(places))
        cut = places[0].size
        self.halves: list[Half] = [
            half_line(places[0], heights[:cut], slopes[:cut]),
            half_line(places[1], heights[cut:], slopes[cut:]),
        ]

    def respond(self, d: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Contact length, F/E* and energy/E* at penetrations d."""
        out = np.zeros((3, d.size))
        for half in self.halves:
            respond(half, d, out)
        return out[0], out[1], out[2]

    def deep_start(self, goal: np.ndarray) -> np.ndarray:
        """Penetrations on or beyond those that carry F/E* = goal."""
        knots = np.unique(np.concatenate([half.heights for half in self.halves]))
        knots = knots[knots > 0]
        if knots.size == 0:
            return goal / sum(half.x[-1] for half in self.halves)
        length, force, _ = self.respond(knots)
        index = np.searchsorted(force, goal, side="left")
        beyond = index == knots.size
        last = np.minimum(index, knots.size - 1)
        return np.where(beyond, knots[-1] + (goal - force[-1]) / length[-1], knots[last])


def _springs(spacing: float, offset: float, largest: float) -> np.ndarray:
    """Return positions (i + offset) dx from the axis outwards to beyond the largest contact."""
    count = round(largest / spacing) + _MARGIN
    return (np.arange(count) + offset) * spacing


class Half(NamedTuple):
    """Cubics of a half line from the axis outwards: n knots x with heights g, n - 1 cells.

    `start` and `end` are the slopes m_0, m_1 of the cells, `first` and `second` int g dx and
    int g^2 dx from 0 to every knot.
    """

    x: np.ndarray
    heights: np.ndarray
    start: np.ndarray
    end: np.ndarray
    first: np.ndarray
    second: np.ndarray


@njit(cache=True)
def half_line(x: np.ndarray, heights: np.ndarray, slopes: np.ndarray) -> Half:
    """Return cubics through knots x, from x = 0 outwards, with g and g' there, all (n,)."""
    n = x.size
    start, end = np.zeros(n - 1), np.zeros(n - 1)
    first, second = np.zeros(n), np.zeros(n)
    for i in range(n - 1):
        rise, width = heights[i + 1] - heights[i], x[i + 1] - x[i]
        if rise > 0.0:
            start[i] = min(max(slopes[i] * (width / rise), 0.0), 3.0)
            end[i] = min(max(slopes[i + 1] * (width / rise), 0.0), 3.0)
        area, squares = part_moments(heights[i], rise, width, start[i], end[i], 1.0)
        first[i + 1] = first[i] + area
        second[i + 1] = second[i] + squares
    return Half(x, heights, start, end, first, second)


@njit(cache=True)
def respond(half: Half, d: np.ndarray, out: np.ndarray) -> None:
    """Add contact length, F/E* and energy/E* of the half line at d > 0 (k,) to `out` (3, k)."""
    x, heights, starts, ends, first, second = half  # read once, not for every load
    last = starts.size - 1
    for k in range(d.size):
        cell = min(np.searchsorted(heights, d[k]) - 1, last)
        base, rise = heights[cell], heights[cell + 1] - heights[cell]
        start, end, width, part = starts[cell], ends[cell], x[cell + 1] - x[cell], 1.0
        if d[k] <= heights[-1]:  # the contact edge in the cell, by bracketed Newton steps
            goal, low, high = (d[k] - base) / rise, 0.0, 1.0
            part = goal
            for _ in range(80):
                value, slope = rise_and_slope(start, end, part)
                if value < goal:
                    low = part
                else:
                    high = part
                step = part - (value - goal) / slope if slope > 0.0 else -1.0
                last_part = part
                part = step if low <= step <= high else 0.5 * (low + high)
                if abs(part - last_part) <= _EPSILON * part:
                    break
        area, squares = part_moments(base, rise, width, start, end, part)
        area, squares = area + first[cell], squares + second[cell]
        length = x[cell] + part * width
        out[0, k] += length
        out[1, k] += length * d[k] - area
        out[2, k] += (length * d[k] * d[k] - 2.0 * d[k] * area + squares) / 2.0


@njit(cache=True)
def rise_and_slope(m0, m1, s):
    """Return the relative rise in the cell and its derivative at s."""
    c2, c3 = 3.0 - 2.0 * m0 - m1, m0 + m1 - 2.0
    return s * (m0 + s * (c2 + s * c3)), m0 + s * (2.0 * c2 + s * 3.0 * c3)


@njit(cache=True)
def part_moments(base, rise, width, m0, m1, part):
    """Return exact integrals of height and its square over the first part of a cell."""
    area = squares = 0.0
    for k in range(len(_NODES)):
        value, _ = rise_and_slope(m0, m1, part * _NODES[k])
        height = base + rise * value
        area += _WEIGHTS[k] * height
        squares += _WEIGHTS[k] * (height * height)
    return part * width * area, part * width * squares
