"""Proved bounds of one rough surface, on few cells.

Free patches are bounded by a linear programme and its dual, periodic surfaces by energies at some
mean pressures. The rigid surface is the band-limited function through its points; grids only sample
it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from comparisons.geometry.prepare import RoughGeometry
from comparisons.methods.solver import Refused
from comparisons.scene.scene import Scene
from reference.bounds.interval import Interval, above, below
from reference.bounds.patches import Patch
from reference.bounds.periodic import PeriodicSurface

# Cells per side, but two to eight per point: intervals a few per cent wide in some seconds a load.
# With more points per side than the last number the bounds take minutes.
_CELLS = {"free": 64, "periodic": 256}
_LEAST, _MOST, _MOST_POINTS = 2, 8, 128
# Share of the mean gap beyond which a period is nearly full: its stiffness has no bound there.
_NEARLY_FULL = 0.9


@dataclass(frozen=True)
class RoughProof:
    """Intervals that theorems prove for one rough surface; penetrations from its highest point."""

    geometry: RoughGeometry
    modulus: float  # E*
    finer: float = 1.0  # cells per side relative to the default
    heaviest = math.inf  # any force has its bounds

    @cached_property
    def _heights(self) -> np.ndarray:
        return self.geometry.heights(0, self.geometry.points[0])

    @cached_property
    def _surface(self) -> Patch | PeriodicSurface:
        kind = "periodic" if self.geometry.periodic else "free"
        finer = round(_CELLS[kind] * self.finer) // max(self.geometry.points)
        finer = min(max(finer, _LEAST), _MOST)
        if self.geometry.periodic:
            return PeriodicSurface(self._heights, self.geometry.size, finer)
        return Patch(self._heights, self.geometry.size[0], finer)

    @cached_property
    def _higher(self) -> float:
        """Height of the highest point above the sample that the bounds count from."""
        return self._highest - self._surface.top

    @property
    def _highest(self) -> float:
        """Highest point of the surface, from its mean."""
        return float(self.geometry.top(0) - self._heights.mean())

    @property
    def deepest(self) -> float:
        """Largest penetration at which anything is proved."""
        if not self.geometry.periodic:
            return math.inf
        return _NEARLY_FULL * self._highest

    def force(self, penetration: float) -> Interval:
        """Force at a penetration."""
        depth = penetration - self._higher
        if depth <= 0:  # nothing is proved to touch, and it is less than what touches deeper
            return Interval(0.0, self._force(penetration).upper)
        return self._force(depth)

    def _force(self, depth: float) -> Interval:
        surface = self._surface
        if isinstance(surface, Patch):
            return surface.force(depth, self.modulus)
        return surface.mean_pressure(depth, self.modulus) * self.geometry.area

    def penetration(self, force: float) -> Interval:
        """Penetration at a force."""
        surface = self._surface
        if isinstance(surface, Patch):
            depth = surface.penetration(force, self.modulus)
        else:
            depth = surface.penetration(force / self.geometry.area, self.modulus)
        ends = depth.lower + self._higher, depth.upper + self._higher
        return Interval(below(ends[0], 4), above(ends[1], 4))

    def energy(self, penetration: Interval, force: Interval) -> Interval:
        """Energy where one of both is given and the other enclosed."""
        surface, depth = self._surface, self._from_samples(penetration)
        if isinstance(surface, Patch):
            return surface.energy(depth, self.modulus)
        mean = self._mean_pressure(force)
        return surface.stored(mean, depth, self.modulus) * self.geometry.area

    def stiffness(self, penetration: Interval, force: Interval) -> Interval:
        """Stiffness where one of both is given and the other enclosed."""
        surface, depth = self._surface, self._from_samples(penetration)
        if isinstance(surface, Patch):
            return surface.stiffness(depth, force, self.modulus)
        return surface.stiffness(self._mean_pressure(force), self.modulus) * self.geometry.area

    def _from_samples(self, penetration: Interval) -> Interval:
        """Count a depth from the sample of the bounds; what is short of it does not touch."""
        depth = Interval(
            below(penetration.lower, 2) - self._higher, above(penetration.upper, 2) - self._higher
        )
        if not depth.lower > 0:
            raise ArithmeticError("the highest sample is not proved to touch")
        return depth

    def _mean_pressure(self, force: Interval) -> Interval:
        area = self.geometry.area
        return Interval(below(force.lower / area, 4), above(force.upper / area, 4))


def proof_of_surface(scene: Scene, geometry: RoughGeometry, finer: float) -> RoughProof:
    """Return the enclosures of a rough scene; nothing is computed before it is asked for."""
    if geometry.random and scene.realisations > 1:
        raise Refused(
            f"the theorems enclose one surface, and the scene asks for the mean over "
            f"{scene.realisations}: surface.realisations = 1"
        )
    if not geometry.periodic and geometry.measured is not None:
        raise Refused(
            "the bounds are for surfaces that are sums of waves, synthetic or periodic, and a "
            "measured patch goes on between its points by splines"
        )
    square = geometry.points[0] == geometry.points[1] and geometry.size[0] == geometry.size[1]
    if not geometry.periodic and not square:
        raise Refused("the bounds of a free patch are for square ones")
    if max(geometry.points) > _MOST_POINTS:
        raise Refused(
            f"of more than {_MOST_POINTS} points a side the bounds take minutes a load, and there "
            f"are {max(geometry.points)}"
        )
    return RoughProof(geometry, scene.effective_modulus, finer)
