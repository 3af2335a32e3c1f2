"""What wears on springs: a round body with its exact pressure, or the line itself by (19.37).

Both hold the heights g of a line over its springs and say how fast these springs' places wear at a
penetration, in units of k: pressure times slip, and the volume that it costs.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np

from reduced.errors import ConvergenceError
from reduced.profiles.section import Profile
from reduced.rough.lines import RoughLines
from reduced.rough.regions import RULES, LineStress, line_stress
from reduced.wear.rings import Rings

LineRule = Literal["own_curvature", "one_radius"]


@dataclass(frozen=True)
class Rate:
    """Wear per unit of k and of the path: depths (m Pa), and the volume (m N)."""

    depth: np.ndarray
    volume: float


class WearingBody(Protocol):
    """A body above springs, after it has lost the depths `worn`."""

    spacing: float

    @property
    def places(self) -> int:
        """Number of depths."""

    def line(self, worn: np.ndarray) -> RoughLines:
        """Return the line of springs, heights -g positive towards them."""

    def rate(self, worn: np.ndarray, modulus: float, depth: float, slip: float | None) -> Rate:
        """Return the wear at a penetration; `slip`: the lower one that leaves the stick zone.

        Without it all springs slip by one; with it by what g exceeds it.
        """


class RoundBody:
    """A body of revolution on rings: worn by its pressure, its line transformed anew.

    Exact while the contact is a full circle, but for the width of the rings.

    Parameters
    ----------
    profile : Profile
        Equivalent profile g of the unworn body.
    reach : float
        Radius that the contact stays below; an edge of the body inside it ends the rings.
    springs : int
        Springs up to there.
    """

    def __init__(self, profile: Profile, reach: float, springs: int) -> None:
        edge = min(profile.edge, np.inf if profile.section is None else profile.section.edge)
        self.ends = reach >= edge * (1 - 1e-9)
        reach = min(reach, edge)
        self.spacing = reach / springs
        self.rings = Rings(self.spacing, springs)
        self.unworn = np.asarray(profile.height(self.rings.middles), dtype=float)

    @property
    def places(self) -> int:
        """Number of rings."""
        return self.rings.count

    def heights(self, worn: np.ndarray) -> np.ndarray:
        """Return g over the springs of one half."""
        return self.unworn + self.rings.lowered(worn)

    def line(self, worn: np.ndarray) -> RoughLines:
        """Return both halves of the line."""
        half = self.heights(worn)
        return RoughLines(-np.concatenate([half[::-1], half]), self.spacing, periodic=False)

    def rate(self, worn: np.ndarray, modulus: float, depth: float, slip: float | None) -> Rate:
        """Return pressure times slip on every ring.

        Raises
        ------
        ConvergenceError
            If the pressure is a tension somewhere: the contact has opened inside; or if the contact
            reaches the last ring of a body that goes on.
        """
        heights = self.heights(worn)
        if depth > heights[-1] and not self.ends:
            raise ConvergenceError("worn so that the contact is wider than the rings")
        pressure = self.rings.pressures(depth - heights)
        if pressure.min() < -1e-9 * pressure.max():
            raise ConvergenceError("worn so that the contact is no full circle any more")
        wear = modulus * np.maximum(pressure, 0.0)
        if slip is not None:
            wear = wear * np.maximum(self.rings.raised(np.maximum(heights - slip, 0.0)), 0.0)
        return Rate(wear, float(wear @ self.rings.areas))


class WearingLine:
    """A line whose own heights wear by the stress that the chapter defines on springs, (19.37).

    Its worn volume is that of the round contacts that its regions stand for: a stress at the
    distance r from the middle of its region acts on half a ring there.

    Parameters
    ----------
    heights : RoughLines
        One line, unworn.
    rule : {"own_curvature", "one_radius"}
        The radius of curvature in (19.37), as of `rough.regions.line_stress`.
    """

    def __init__(self, heights: RoughLines, rule: LineRule) -> None:
        self.unworn, self.rule = heights, rule
        self.spacing = heights.spacing
        assert rule in RULES

    @property
    def places(self) -> int:
        """Number of springs."""
        return self.unworn.single().size

    def line(self, worn: np.ndarray) -> RoughLines:
        """Return the worn line."""
        return RoughLines(self.unworn.single() - worn, self.spacing, self.unworn.periodic)

    def rate(self, worn: np.ndarray, modulus: float, depth: float, slip: float | None) -> Rate:
        """Return stress times slip at every spring.

        Raises
        ------
        ConvergenceError
            If the rule has no real value at a spring in contact.
        """
        line = self.line(worn)
        stress = line_stress(line, modulus, depth + float(line.single().max()), rule=self.rule)
        if not stress.valid.all():
            raise ConvergenceError(
                f"the stress (19.37) has no real value at {100 * stress.undefined_share:.0f} % of "
                "the springs in contact: worn springs lie on a straight or hollow line"
            )
        points = stress.regions.points
        wear = stress.pressure
        if slip is not None:
            wear = wear * np.maximum(-line.single()[points] - slip, 0.0)
        depths = np.zeros(self.places)
        depths[points] = wear
        return Rate(depths, float(wear @ self._half_rings(stress)))

    def _half_rings(self, stress: LineStress) -> np.ndarray:
        """Return the areas that the springs in contact stand for."""
        region = stress.regions.region
        number = np.arange(region.size)
        count = np.maximum(np.bincount(region), 1)
        middle = np.bincount(region, number) / count
        return np.asarray(np.pi * self.spacing**2 * np.abs(number - middle[region]))
