"""Archard's law along a sliding distance, or cycle after cycle of a small oscillation.

The depth that a place loses is k times its pressure times the distance that it slips (Archard
1953, locally). Steps are explicit (Heun's), as long as springs allow: the wear of one step changes
the pressure of the shortest waves, k E* ds/dx, by a part of itself.

What wears is a round body with its exact pressure, or a line by (19.37): both hold the heights g of
a line over its springs and say how fast these springs' places wear at a penetration, in units of k.

A body of revolution that loses w(r) changes its line by x int_0^x w'(r)/sqrt(x^2 - r^2) dr (Popov
& Hess 2015, ch. 3). Here w is straight between the outer rims of rings, one for each spring, flat
in the first, and a spring feels the mean of the line over its own width. The pressure is the one
whose work against a small wear is that of the springs: it has exactly their force. A ring acts on
its own spring and those further out, so springs that stick stay unworn.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from reduced.errors import ConvergenceError, count_faults, list_faults, positive_faults, refuse
from reduced.loads import Load
from reduced.profiles.section import Profile
from reduced.rough.press import LineContact, RoughLines, press
from reduced.rough.regions import RULES, line_stress

# k E* ds/dx of a step; twice the one at which steps begin to swing.
_STEP = 0.5
MOST_STEPS = 200_000
Wear = tuple[np.ndarray, float]
"""Of a body, per unit of k and of the path: depths (m Pa), and the volume (m N)."""
LineRule = Literal["own_curvature", "one_radius"]


@dataclass(frozen=True)
class Oscillation:
    """A small tangential oscillation of amplitude U under constant load, with Coulomb's friction.

    Springs slip where g(x) > d - lag, by amplitude (g - d + lag)/lag, four times a cycle: in
    proportion to the gap that pressing by d - lag would leave (Ciavarella 1998, Jaeger 1998). The
    lag is G* U/(mu E*), what a spring is pressed in where friction just holds it.
    """

    amplitude: float
    lag: float

    def __post_init__(self) -> None:
        refuse(positive_faults(amplitude=self.amplitude, lag=self.lag))

    @property
    def slip(self) -> float:
        """Distance slipped in a cycle per height of g above d - lag."""
        return 4 * self.amplitude / self.lag


@dataclass(frozen=True)
class WornLine:
    """A worn body in contact.

    Penetration is the approach since first touch of the unworn body, `contact` that of the worn
    line, its edges between springs. `worn` are the depths lost at the springs' places; the stick
    length is that of the springs that do not slip, zero in sliding; steps count from the start.
    """

    penetration: float
    contact: LineContact
    force: float
    worn: np.ndarray
    volume: float
    stick_length: float
    steps: int


def wear(
    body: WearingBody,
    effective_modulus: float,
    load: Load,
    coefficient: float,
    distances: np.ndarray,
    oscillation: Oscillation | None = None,
) -> Iterator[WornLine]:
    """Wear a body under one constant penetration or force; yield a state per distance.

    `coefficient` is k, volume lost per force and distance; distances are numbers of cycles with an
    oscillation. ConvergenceError if the pressure is lost, or the distance takes too many steps.
    """
    faults = positive_faults(effective_modulus=effective_modulus, coefficient=coefficient)
    refuse(faults + list_faults(increasing=True, distances=distances))
    control, prescribed = load.one_of("penetration", "force"), load.single()
    modulus = effective_modulus

    def pressed(worn: np.ndarray) -> tuple[float, float]:
        """Return the penetration since first touch of the unworn body, and the springs' force."""
        line = body.line(worn)
        touch = -float(line.single().max())
        if control == "force":
            contact = press(line, modulus, load, edges="nodal")
            return touch + float(contact.penetration[0, 0]), prescribed
        if prescribed <= touch:
            raise ConvergenceError("worn so far that nothing touches any more")
        contact = press(line, modulus, Load("penetration", prescribed - touch), edges="nodal")
        return prescribed, float(contact.force[0, 0])

    def contact_at(worn: np.ndarray, depth: float) -> LineContact:
        line = body.line(worn)
        return press(line, modulus, Load("penetration", depth + float(line.single().max())))

    def rate(worn: np.ndarray) -> Wear:
        depth, _ = pressed(worn)
        if oscillation is None:
            return body.rate(worn, modulus, depth, None)
        depths, volume = body.rate(worn, modulus, depth, depth - oscillation.lag)
        return oscillation.slip * depths, oscillation.slip * volume

    def along() -> Iterator[WornLine]:
        farthest = 1.0 if oscillation is None else 4 * oscillation.amplitude
        longest = _STEP * body.spacing / (coefficient * modulus * farthest)
        needed = float(distances[-1]) / longest
        if not needed <= MOST_STEPS:
            raise ConvergenceError(f"the wear takes {needed:.3g} steps, more than {MOST_STEPS}")
        worn, volume, at, steps = np.zeros(body.places), 0.0, 0.0, 0
        for distance in distances:
            count = int(np.ceil((distance - at) / longest))
            k = coefficient * (distance - at) / count
            for _ in range(count):  # Heun
                first, first_volume = rate(worn)
                second, second_volume = rate(worn + k * first)
                worn = worn + 0.5 * k * (first + second)
                volume += 0.5 * k * (first_volume + second_volume)
            at, steps = float(distance), steps + count
            depth, force = pressed(worn)
            contact, stuck = contact_at(worn, depth), 0.0
            inner = -np.inf if oscillation is None else depth - oscillation.lag
            if inner > -float(body.line(worn).single().max()):  # springs with g < d - lag
                stuck = float(contact_at(worn, inner).contact_length[0, 0])
            yield WornLine(depth, contact, force, worn, volume, stuck, steps)

    return along()


class Rings:
    """Equal rings around an axis, two at least; `spacing` is their width and the springs' distance.

    Worn depths are given at `radii`, the outer rims; springs stand at the `middles`. Depths times
    the `areas` are volumes, `lowering` times them the change of the line over the springs.
    `raising` times a line is its body at the rims, (2/pi) int_0^r g(x)/sqrt(r^2 - x^2) dx.

    A parabola g = x^2 pressed by 1, below which Hertz's pressure is 2 sqrt(1 - r^2)/pi:

    >>> rings = Rings(0.01, 120)
    >>> pressure = rings.pressures(1 - rings.middles**2)
    >>> round(float(pressure @ rings.areas), 3), round(float(pressure[50]), 3)
    (1.333, 0.548)
    """

    def __init__(self, spacing: float, count: int) -> None:
        refuse(positive_faults(spacing=spacing) + count_faults(2, count=count))
        self.spacing, self.count = spacing, count
        bound = np.arange(count + 1)[:, None] * spacing
        self.radii, self.middles = bound[1:, 0], bound[1:, 0] - spacing / 2
        rim = count * spacing
        starts, ends = self.radii[:-1], self.radii[1:]  # between which w has its slopes
        turned = np.diff(_turned(bound, ends) - _turned(bound, starts), axis=0) / spacing
        self.lowering = self._of_slopes(turned)
        self.lowering[:, 0] += 1.0
        volumes = np.pi * (rim**2 * (ends - starts) - (ends**3 - starts**3) / 3)
        self.areas = self._of_slopes(volumes[None, :])[0]
        self.areas[0] += np.pi * rim**2
        turn = np.arcsin(np.minimum(bound.T / self.radii[:, None], 1.0))
        self.raising = 2 / np.pi * np.diff(turn, axis=1)

    def _of_slopes(self, rows: np.ndarray) -> np.ndarray:
        """Return rows that act on the depths of rings from rows that act on the slopes between."""
        rows = rows / self.spacing
        return np.pad(rows, ((0, 0), (1, 0))) - np.pad(rows, ((0, 0), (0, 1)))

    def pressures(self, deflection: np.ndarray) -> np.ndarray:
        """Return the pressure over E* at the rims from deflections of the springs.

        2 dx sum_i delta_i dg_i is their work over E* when the line rises by dg. Deflections out of
        contact are negative, and do none.
        """
        forces = 2 * self.spacing * (np.maximum(deflection, 0.0) @ self.lowering)
        return np.asarray(forces / self.areas)


def _turned(x: np.ndarray, radius: np.ndarray) -> np.ndarray:
    """Return int_0^x t arcsin(min(radius/t, 1)) dt."""
    beyond = np.maximum(x, radius)
    root = np.sqrt((beyond - radius) * (beyond + radius))
    return 0.5 * np.where(
        x > radius, beyond**2 * np.arcsin(radius / beyond) + radius * root, np.pi / 2 * x**2
    )


class RoundBody:
    """A body of revolution on rings: worn by its pressure, its line transformed anew.

    Exact while the contact is a full circle, but for the width of the rings. `springs` stand up to
    `reach`, the radius that the contact stays below; an edge of the body inside it ends the rings.
    """

    def __init__(self, profile: Profile, reach: float, springs: int) -> None:
        edge = min(profile.edge, np.inf if profile.section is None else profile.section.edge)
        self.ends = reach >= edge * (1 - 1e-9)
        reach = min(reach, edge)
        self.spacing = reach / springs
        self.rings = Rings(self.spacing, springs)
        self.places = springs
        self.unworn = np.asarray(profile.height(self.rings.middles), dtype=float)

    def heights(self, worn: np.ndarray) -> np.ndarray:
        """Return g over the springs of one half."""
        return self.unworn + self.rings.lowering @ worn

    def line(self, worn: np.ndarray) -> RoughLines:
        """Return both halves of the line."""
        half = self.heights(worn)
        return RoughLines(-np.concatenate([half[::-1], half]), self.spacing, periodic=False)

    def rate(self, worn: np.ndarray, modulus: float, depth: float, slip: float | None) -> Wear:
        """Return pressure times slip on every ring at a penetration.

        `slip` is the lower penetration that leaves the stick zone: springs slip by what g exceeds
        it, without it all by one.
        """
        heights = self.heights(worn)
        if depth > heights[-1] and not self.ends:
            raise ConvergenceError("worn so that the contact is wider than the rings")
        pressure = self.rings.pressures(depth - heights)
        if pressure.min() < -1e-9 * pressure.max():
            raise ConvergenceError("worn so that the contact is no full circle any more")
        wear = modulus * np.maximum(pressure, 0.0)
        if slip is not None:
            wear = wear * np.maximum(self.rings.raising @ np.maximum(heights - slip, 0.0), 0.0)
        return wear, float(wear @ self.rings.areas)


class WearingLine:
    """A line whose own heights wear by the stress that the chapter defines on springs, (19.37).

    Its worn volume is that of the round contacts that its regions stand for: a stress at the
    distance r from the middle of its region acts on half a ring there. The rule for the radius of
    curvature is that of `rough.regions.line_stress`.
    """

    def __init__(self, heights: RoughLines, rule: LineRule) -> None:
        self.unworn, self.rule = heights, rule
        self.spacing, self.places = heights.spacing, heights.single().size
        assert rule in RULES

    def line(self, worn: np.ndarray) -> RoughLines:
        """Return the worn line."""
        return RoughLines(self.unworn.single() - worn, self.spacing, self.unworn.periodic)

    def rate(self, worn: np.ndarray, modulus: float, depth: float, slip: float | None) -> Wear:
        """Return stress times slip at every spring, with `slip` as of `RoundBody`."""
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
        # a spring stands for half a ring around the middle of its region
        region = stress.regions.region
        number = np.arange(region.size)
        middle = np.bincount(region, number) / np.maximum(np.bincount(region), 1)
        areas = np.asarray(np.pi * self.spacing**2 * np.abs(number - middle[region]))
        return depths, float(wear @ areas)


WearingBody = RoundBody | WearingLine
"""A body above springs, after it has lost the depths `worn` at its places."""
