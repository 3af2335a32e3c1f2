"""A row of springs under a profile: smooth with sub-cell edges, or with nodal sums as printed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reduced.arguments import choice_faults, count_faults, positive_faults, refuse
from reduced.loads import EDGES
from reduced.profiles.section import Profile
from reduced.springs.cubics import Half, half_line, respond

_MARGIN = 4  # extra springs beyond the largest contact radius, for inverted loads
_WALL_STEPS = 80


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

    A spring is in contact if g(x_i) < d, not if it is only touched. Springs reach a few beyond
    `largest`, the contact radius at the largest load.
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
    """Springs joined by the monotone cubic through heights and slopes, with edges inside cells.

    The springs of the two halves of the line are at different positions.
    """

    def __init__(self, profile: Profile, spacing: float, offset: float, largest: float) -> None:
        self.spacing = spacing
        self.springs = [_springs(spacing, o, largest) for o in (offset, 1 - offset)]
        places = [_places(profile, half) for half in self.springs]
        heights = profile.height(np.concatenate(places))
        if not np.isfinite(heights).all():
            # unbounded heights (a sphere): knots to one beyond the largest contact
            both = np.concatenate(places)
            wall = both[~np.isfinite(heights)].min()
            places = [x[x < wall] for x in places]
            for half, x in enumerate(places):
                beyond, step = max(largest, x[-1]), largest
                for _ in range(_WALL_STEPS):
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

    def count_springs(self, d: float) -> int:
        """Springs in contact at penetration d."""
        count = 0
        for half, springs in zip(self.halves, self.springs, strict=True):
            out = np.zeros((3, 1))
            respond(half, np.array([d]), out)
            count += int(np.searchsorted(springs, out[0, 0]))
        return count


def _springs(spacing: float, offset: float, largest: float) -> np.ndarray:
    """Return positions (i + offset) dx from the axis outwards to beyond the largest contact."""
    count = round(largest / spacing) + _MARGIN
    return (np.arange(count) + offset) * spacing


def _places(profile: Profile, springs: np.ndarray) -> np.ndarray:
    """Return the knots of a half line."""
    x = springs if springs[0] == 0 else np.concatenate([[0.0], springs])
    marks = [b for b in profile.breakpoints if b < springs[-1]]
    if profile.edge <= springs[-1]:
        x = np.append(x[x < profile.edge], profile.edge)
    return np.unique(np.concatenate([x, marks])) if marks else x
