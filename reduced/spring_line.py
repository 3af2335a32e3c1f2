"""The two discrete spring lines: a smooth one with sub-cell edges, and the printed nodal sums."""

from __future__ import annotations

import numpy as np

from .quadrature import gauss_legendre
from .section import Profile

_MARGIN = 4  # springs beyond the largest contact radius, for inverted loads
_EDGE_STEPS = 80


class NodalLine:
    """Springs at (i + offset) dx and nothing between them: the chapter's sums.

    A spring counts as in contact when g(x_i) < d, not when it is merely touched.

    Parameters
    ----------
    profile : Profile
        Equivalent profile.
    spacing, offset : float
        dx, and the place of the first spring right of the axis in units of dx.
    largest : float
        Contact radius at the largest load; a few springs more are kept.
    """

    def __init__(self, profile: Profile, spacing: float, offset: float, largest: float) -> None:
        x = np.concatenate(
            [_springs(spacing, offset, largest), _springs(spacing, 1 - offset, largest)]
        )
        heights = profile.height(x)
        self.heights = np.sort(heights[np.isfinite(heights) & (x < profile.edge)])
        self.spacing = spacing
        zero = np.zeros(1)
        self.sums = np.concatenate([zero, np.cumsum(self.heights)])
        self.squares = np.concatenate([zero, np.cumsum(self.heights**2)])

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

    def count_springs(self, d: float) -> int:
        """Springs in contact at penetration d."""
        return int(np.searchsorted(self.heights, d, side="left"))


class SmoothLine:
    """Springs joined by the monotone cubic through heights and slopes: edges inside the cells.

    The two halves of the line see the springs at different places; each is a `_Half`.
    """

    def __init__(self, profile: Profile, spacing: float, offset: float, largest: float) -> None:
        self.halves = [
            _Half(profile, _springs(spacing, o, largest), largest) for o in (offset, 1 - offset)
        ]

    def respond(self, d: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Contact length, F/E* and energy/E* at penetrations d."""
        right, left = (half.respond(d) for half in self.halves)
        return tuple(a + b for a, b in zip(right, left, strict=True))

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

    def count_springs(self, d: float) -> int:
        """Springs in contact at penetration d."""
        return sum(
            int(np.searchsorted(half.springs, half.respond(np.array([d]))[0][0]))
            for half in self.halves
        )


class _Half:
    """One half of a smooth line: knots from x = 0 outwards, cubic cells, running integrals."""

    def __init__(self, profile: Profile, springs: np.ndarray, largest: float) -> None:
        self.springs = springs
        self.sharp = np.isfinite(profile.edge)
        self.x, self.heights, slopes = _knots(profile, springs, largest)
        self.width = np.diff(self.x)
        self.rise = np.diff(self.heights)
        safe = np.where(self.rise > 0, self.rise, 1.0)
        # Slopes in units of the secant, at most 3: then the cubic is monotone (Fritsch & Carlson).
        self.start = np.where(self.rise > 0, np.clip(slopes[:-1] * (self.width / safe), 0, 3), 0.0)
        self.end = np.where(self.rise > 0, np.clip(slopes[1:] * (self.width / safe), 0, 3), 0.0)
        cell = np.arange(self.width.size)
        first, second = self._moments(cell, np.ones(cell.size))
        self.first = np.concatenate([[0.0], np.cumsum(first)])
        self.second = np.concatenate([[0.0], np.cumsum(second)])

    def respond(self, d: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Contact length, F/E* and energy/E* of this half at penetrations d > 0."""
        cell = np.searchsorted(self.heights, d, side="left") - 1
        inside = cell < self.width.size
        cell = np.minimum(cell, self.width.size - 1)
        part = np.where(inside, self._locate(cell, d), 1.0)
        first, second = self._moments(cell, part)
        first, second = first + self.first[cell], second + self.second[cell]
        length = self.x[cell] + part * self.width[cell]
        return length, length * d - first, (length * d * d - 2 * d * first + second) / 2

    def _cubic(self, cell: np.ndarray, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rise above the cell's start in units of its full rise, and its derivative, at s."""
        m0, m1 = self.start[cell], self.end[cell]
        c2, c3 = 3 - 2 * m0 - m1, m0 + m1 - 2
        return s * (m0 + s * (c2 + s * c3)), m0 + s * (2 * c2 + s * 3 * c3)

    def _locate(self, cell: np.ndarray, d: np.ndarray) -> np.ndarray:
        """Place of the contact edge inside the cell, in [0, 1], by Newton inside a bracket."""
        rise = np.where(self.rise[cell] > 0, self.rise[cell], 1.0)
        goal = np.clip((d - self.heights[cell]) / rise, 0, 1)
        low, high, s = np.zeros_like(goal), np.ones_like(goal), goal.copy()
        for _ in range(_EDGE_STEPS):
            value, slope = self._cubic(cell, s)
            low, high = np.where(value < goal, s, low), np.where(value < goal, high, s)
            step = s - (value - goal) / np.where(slope > 0, slope, 1.0)
            good = (slope > 0) & (step >= low) & (step <= high)
            last, s = s, np.where(good, step, (low + high) / 2)
            if np.all(np.abs(s - last) <= np.finfo(float).eps * s):
                break
        return s

    def _moments(self, cell: np.ndarray, part: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Integrals of height and height squared over the first part of each cell; exact."""
        nodes, weights = gauss_legendre(4)
        rise, _ = self._cubic(cell[:, None], part[:, None] * nodes)
        height = self.heights[cell][:, None] + self.rise[cell][:, None] * rise
        scale = part * self.width[cell]
        return scale * (height @ weights), scale * (height**2 @ weights)


def _springs(spacing: float, offset: float, largest: float) -> np.ndarray:
    """Positions (i + offset) dx from the axis outwards, some beyond the largest contact."""
    count = round(largest / spacing) + _MARGIN
    return (np.arange(count) + offset) * spacing


def _knots(
    profile: Profile, springs: np.ndarray, largest: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Knots of a half line with heights and slopes: axis, springs, breakpoints and sharp edge."""
    marks = np.array([b for b in profile.breakpoints if b < springs[-1]])
    x = np.concatenate([[0.0], springs, marks])
    if profile.edge <= springs[-1]:
        x = np.append(x[x < profile.edge], profile.edge)
    x = np.unique(x)
    heights = profile.height(x)
    if not np.isfinite(heights[-1]):
        x = _stop_before_wall(profile, x[np.isfinite(heights)], largest)
        heights = profile.height(x)
    return x, heights, profile.slope(x)


def _stop_before_wall(profile: Profile, x: np.ndarray, largest: float) -> np.ndarray:
    """Knots up to one beyond the largest contact, for a height that becomes infinite (a sphere)."""
    beyond = max(largest, x[-1])
    step = largest
    for _ in range(_EDGE_STEPS):
        step /= 2
        if np.isfinite(profile.height(np.array([beyond + step])))[0]:
            return np.append(x, beyond + step)
    return x
