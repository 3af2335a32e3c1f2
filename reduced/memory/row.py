"""A row of viscoelastic springs under an equivalent profile: positions, force, growth.

Springs stand at x = 0, dx, 2 dx, ..., at the breakpoints of the profile and at its sharp edge; the
line is symmetric and only its right half is kept. Between neighbours the force per length is
assumed linear in the height g, as for elastic springs: the force of the whole line is then exact
for elastic springs under a paraboloid or a cone at any spacing, and has an error of dx^2 for
others.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from reduced.arguments import poisson_faults, positive_faults, refuse
from reduced.memory.kernel import SpringLaw, advance, fresh_row, law_of
from reduced.memory.materials import Prony, contact_modulus
from reduced.profiles.section import Profile
from reduced.springs.line import row_faults

_LEAST, _MOST = 0.25, 0.75  # relative middle heights of cells for which the parabola is monotone


@njit(cache=True)
def _along(middle, level):
    """Return the fraction of a cell's width at which its height has risen by the fraction `level`.

    Within a cell the height is the parabola through both ends and the middle, if it is monotone,
    else a power of the distance from the flatter end (exact at the tip of c x^n).
    """
    if level <= 0 or level >= 1:
        return min(max(level, 0.0), 1.0)
    if middle < _LEAST:
        return level ** (-1 / np.log2(middle)) if middle > 0 else 1.0
    if middle > _MOST:
        return 1 - (1 - level) ** (-1 / np.log2(1 - middle)) if middle < 1 else 0.0
    slope, bend = 4 * middle - 1, 2 - 4 * middle
    return 2 * level / (slope + np.sqrt(slope * slope + 4 * bend * level))


@njit(cache=True)
def _risen(middle, share):
    """Return integrals of relative height and its square over a part of a cell, see `_along`."""
    if middle <= 0:
        return 0.0, 0.0
    if middle >= 1:
        return share, share
    if middle < _LEAST:
        power = -np.log2(middle)
        return share ** (power + 1) / (power + 1), share ** (2 * power + 1) / (2 * power + 1)
    if middle > _MOST:
        power = -np.log2(1 - middle)
        once = (1 - (1 - share) ** (power + 1)) / (power + 1)
        twice = (1 - (1 - share) ** (2 * power + 1)) / (2 * power + 1)
        return share - once, share - 2 * once + twice
    slope, bend = 4 * middle - 1, 2 - 4 * middle
    first = share * share * (slope / 2 + bend * share / 3)
    second = slope * slope / 3 + share * slope * bend / 2 + share * share * bend * bend / 5
    return first, share**3 * second


@njit(cache=True)
def _bend(heights, force, i, j, k):
    """Return the second divided difference of the force over the height; 0 for equal heights."""
    low, high = heights[j] - heights[i], heights[k] - heights[j]
    if low == 0 or high == 0:
        return 0.0
    steeper = (force[k] - force[j]) / high - (force[j] - force[i]) / low
    return steeper / (heights[k] - heights[i])


@njit(cache=True)
def _sub_cell(places, heights, middles, row, rim):
    """Return force, contact length and outermost contact edge of the right half."""
    touching, force = row.touching, row.force
    total, length, radius = 0.0, 0.0, 0.0
    for i in range(places.size - 1):
        if not (touching[i] or touching[i + 1]):
            continue
        width, middle = places[i + 1] - places[i], middles[i]
        if touching[i] and touching[i + 1]:
            # the linear value less the curvature from the neighbours (mean of both sides)
            once, twice = _risen(middle, 1.0)
            before = i > 0 and touching[i - 1]
            after = i + 2 < heights.size and touching[i + 2]
            bend, share = 0.0, 1.0
            if before:
                bend += _bend(heights, force, i - 1, i, i + 1)
            if after:
                bend += _bend(heights, force, i, i + 1, i + 2)
            if before and after:
                bend /= 2
            rise = heights[i + 1] - heights[i]
            mean = force[i] * (1 - once) + force[i + 1] * once - bend * rise * rise * (once - twice)
        else:
            # linear in the height to the edge
            inward, edge = touching[i], row.edge[i]
            pressed_force = force[i] if inward else force[i + 1]
            share = _along(middle, edge if inward else 1 - edge)
            once = _risen(middle, share)[0]
            if not inward:
                share, once = 1 - share, (1 - share) - (_risen(middle, 1.0)[0] - once)
            ramp = once / edge if edge > 0 else 0.0
            mean = pressed_force * share + (rim - pressed_force) * ramp
        total += width * mean
        length += width * share
        radius = places[i + 1] if touching[i + 1] else places[i] + width * share
    return total, length, radius


@dataclass(frozen=True)
class RelaxingSprings:
    """Viscoelastic springs E*(t) dx under a profile (19.30).

    Parameters
    ----------
    profile : Profile
        Equivalent profile g(x), see `profiles`.
    material : Prony
        Shear modulus in time.
    poisson_ratio : float
        Constant in time; 1/2 for rubber.
    per_radius : int
        Springs per contact radius at the largest depth.
    spacing : float, optional
        dx, instead of `per_radius`.
    edges : {"sub_cell", "nodal"}
        Contact edges inside cells, or whole springs at (i + 1/2) dx as printed.
    """

    profile: Profile
    material: Prony
    poisson_ratio: float = 0.5
    per_radius: int = 40
    spacing: float | None = None
    edges: str = "sub_cell"

    def __post_init__(self) -> None:
        wrong = poisson_faults(self.poisson_ratio)
        refuse(wrong + row_faults(self.per_radius, self.spacing, self.edges))

    @property
    def modulus(self) -> Prony:
        """The contact modulus E*(t)."""
        return contact_modulus(self.material, self.poisson_ratio)

    def lay(self, depth: float) -> SpringRow:
        """Return a row of springs for a largest depth; at larger depths springs are added."""
        spacing = self.spacing
        if spacing is None:
            spacing = float(self.profile.contact_radius(max(depth, 0.0))) / self.per_radius
            refuse(positive_faults(largest_contact_radius=spacing))
        return SpringRow(self.profile, law_of(self.modulus), spacing, self.edges)


class SpringRow:
    """Springs of spacing dx under a profile, with their history.

    Parameters
    ----------
    law : SpringLaw
        Law per length, with moduli E*(t) (19.30).
    spacing : float
        dx.
    edges : {"sub_cell", "nodal"}
        Contact edges inside a cell, or sums over whole springs at (i + 1/2) dx.
    """

    def __init__(self, profile: Profile, law: SpringLaw, spacing: float, edges: str) -> None:
        self._profile, self._law, self._edges = profile, law, edges
        self._spacing = self.spacing = float(spacing)
        self._places = np.zeros(0)
        self.time, self.depth = 0.0, 0.0
        self._place(4 * spacing)
        self._row = fresh_row(self._places.size, law)
        self._trial = fresh_row(self._places.size, law)

    def trial(self, depth: float, duration: float) -> tuple[float, float, float]:
        """Return force, contact length and contact radius of a trial step to a depth.

        The velocity is constant; a duration of 0 is a jump. The state is not changed.
        """
        self._grow(depth)
        way = float(self.depth), float(depth), float(duration)
        advance(self._law, self._heights, self._row, self._trial, *way)
        if self._edges == "nodal":
            touching = int(self._trial.touching.sum())
            radius = touching * self._spacing
            return 2 * self._spacing * float(self._trial.force.sum()), 2 * radius, radius
        speed = (depth - self.depth) / duration if duration > 0 else 0.0
        rim = self._law.viscosity * max(speed, 0.0)
        line = self._places, self._heights, self._middles
        total, length, radius = _sub_cell(*line, self._trial, rim)
        return 2 * total, 2 * length, radius

    def go(self, depth: float, duration: float) -> tuple[float, float, float]:
        """Take a step; return the same as `trial`."""
        answer = self.trial(depth, duration)
        self._row, self._trial = self._trial, self._row
        self.depth, self.time = depth, self.time + duration
        return answer

    def _grow(self, depth: float) -> None:
        """Add springs until the profile rises above a depth."""
        if depth < self._heights[-1] or self._places[-1] >= self._profile.edge:
            return
        old_rows = self._row
        reach = float(self._profile.contact_radius(depth)) + self._spacing
        self._place(2 * max(reach, self._places[-1]))
        self._row, self._trial = (fresh_row(self._places.size, self._law) for _ in range(2))
        for new, old in zip(self._row, old_rows, strict=True):
            new[: old.shape[0]] = old

    def _place(self, reach: float) -> None:
        """Place springs from the axis to `reach` or the profile's edge; they remain fixed."""
        count = int(np.ceil(reach / self._spacing)) + 1
        nodal = self._edges == "nodal"
        places = self._spacing * (np.arange(count) + 0.5 * nodal)
        if not nodal:
            marks = np.array([*self._profile.breakpoints, self._profile.edge])
            places = np.union1d(places, marks[marks < places[-1]])
        places = places[places <= self._profile.edge]
        heights = np.asarray(self._profile.height(places), dtype=float)
        defined = np.isfinite(heights)
        self._places, self._heights = places[defined], heights[defined]
        rise = np.diff(self._heights)
        middle = self._profile.height((self._places[:-1] + self._places[1:]) / 2)
        steep = rise > 0
        share = (middle - self._heights[:-1]) / np.where(steep, rise, 1.0)
        self._middles = np.where(steep, share, 0.5)
