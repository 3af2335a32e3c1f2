"""The two discrete spring lines: a smooth one with sub-cell edges, and the printed nodal sums."""

from __future__ import annotations

import numpy as np

from reduced.profiles.section import Profile
from reduced.springs.cubics import moments, respond

_MARGIN = 4  # springs beyond the largest contact radius, for inverted loads
_WALL_STEPS = 80


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

    The two halves of the line see the springs at different places. Each is a tuple of knots from
    x = 0 outwards, heights, end slopes of the cubics and running integrals, see `cubics`.
    """

    def __init__(self, profile: Profile, spacing: float, offset: float, largest: float) -> None:
        self.springs = [_springs(spacing, o, largest) for o in (offset, 1 - offset)]
        self.halves = [
            (x, g, *moments(x, g, slope)) for x, g, slope in _knots(profile, self.springs, largest)
        ]

    def respond(self, d: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Contact length, F/E* and energy/E* at penetrations d."""
        out = np.zeros((3, d.size))
        for half in self.halves:
            respond(*half, d, out)
        return out[0], out[1], out[2]

    def deep_start(self, goal: np.ndarray) -> np.ndarray:
        """Penetrations on or beyond those that carry F/E* = goal."""
        knots = np.unique(np.concatenate([half[1] for half in self.halves]))
        knots = knots[knots > 0]
        if knots.size == 0:
            return goal / sum(half[0][-1] for half in self.halves)
        length, force, _ = self.respond(knots)
        index = np.searchsorted(force, goal, side="left")
        beyond = index == knots.size
        last = np.minimum(index, knots.size - 1)
        return np.where(beyond, knots[-1] + (goal - force[-1]) / length[-1], knots[last])

    def count_springs(self, d: float) -> int:
        """Springs in contact at penetration d."""
        count = 0
        for half, springs in zip(self.halves, self.springs, strict=True):
            out = np.zeros((3, 1))
            respond(*half, np.array([d]), out)
            count += int(np.searchsorted(springs, out[0, 0]))
        return count


def _springs(spacing: float, offset: float, largest: float) -> np.ndarray:
    """Positions (i + offset) dx from the axis outwards, some beyond the largest contact."""
    count = round(largest / spacing) + _MARGIN
    return (np.arange(count) + offset) * spacing


def _knots(
    profile: Profile, springs: list[np.ndarray], largest: float
) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Knots of both half lines with heights and slopes: axis, springs, breakpoints, sharp edge."""
    places = [_places(profile, half) for half in springs]
    both = np.concatenate(places)
    heights = profile.height(both)
    if not np.isfinite(heights).all():
        wall = both[~np.isfinite(heights)].min()
        places = [_stop_before_wall(profile, x[x < wall], largest) for x in places]
        both = np.concatenate(places)
        heights = profile.height(both)
    slopes = profile.slope(both)
    cut = places[0].size
    parts = (slice(0, cut), slice(cut, None))
    return [(both[part], heights[part], slopes[part]) for part in parts]


def _places(profile: Profile, springs: np.ndarray) -> np.ndarray:
    """Knots of a half line."""
    x = springs if springs[0] == 0 else np.concatenate([[0.0], springs])
    marks = [b for b in profile.breakpoints if b < springs[-1]]
    if profile.edge <= springs[-1]:
        x = np.append(x[x < profile.edge], profile.edge)
    return np.unique(np.concatenate([x, marks])) if marks else x


def _stop_before_wall(profile: Profile, x: np.ndarray, largest: float) -> np.ndarray:
    """Knots up to one beyond the largest contact, for a height that becomes infinite (a sphere)."""
    beyond = max(largest, x[-1])
    step = largest
    for _ in range(_WALL_STEPS):
        step /= 2
        if np.isfinite(profile.height(np.array([beyond + step])))[0]:
            return np.append(x, beyond + step)
    return x
