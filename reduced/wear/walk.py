"""Archard's law along a sliding distance, or cycle after cycle of a small oscillation.

The depth that a place loses is k times its pressure times the distance that it slips (Archard
1953, locally). Steps are explicit (Heun's), as long as springs allow: the wear of one step changes
the pressure of the shortest waves, k E* ds/dx, by a part of itself.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from reduced.arguments import increasing_faults, positive_faults, refuse
from reduced.errors import ConvergenceError
from reduced.loads import Load
from reduced.rough.press import LineContact, press
from reduced.wear.bodies import Rate, WearingBody

# k E* ds/dx of a step; twice the one at which steps begin to swing.
_STEP = 0.5
MOST_STEPS = 200_000
CONTROLS = ("penetration", "force")


@dataclass(frozen=True)
class Oscillation:
    """A small tangential oscillation under constant normal load, with Coulomb's friction.

    Springs slip where g(x) > d - lag, by amplitude (g - d + lag)/lag, four times a cycle: in
    proportion to the gap that pressing by d - lag would leave (Ciavarella 1998, Jaeger 1998).

    Parameters
    ----------
    amplitude : float
        U, of the displacement.
    lag : float
        G* U/(mu E*), what a spring is pressed in where friction just holds it.
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

    Attributes
    ----------
    penetration : float
        Approach since first touch of the unworn body.
    contact : LineContact
        Of the worn line at this penetration, its edges between springs.
    force : float
        What the springs carry.
    worn : ndarray
        Depths lost at the springs' places.
    volume : float
        Volume lost.
    stick_length : float
        Of the springs that do not slip; zero in sliding.
    steps : int
        From the start on.
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
    """Wear a body under a constant load.

    Parameters
    ----------
    effective_modulus : float
        E*.
    load : Load
        Penetration or force, one value.
    coefficient : float
        k, volume lost per force and distance.
    distances : ndarray
        Sliding distances, strictly increasing; with an oscillation, numbers of cycles.
    oscillation : Oscillation, optional

    Yields
    ------
    WornLine
        One per distance.

    Raises
    ------
    ConvergenceError
        If the pressure is lost, or the distance takes too many steps.
    """
    faults = positive_faults(effective_modulus=effective_modulus, coefficient=coefficient)
    refuse(faults + increasing_faults(distances=distances))
    load.one_of(*CONTROLS)
    load.single()
    return _Walk(body, effective_modulus, load, oscillation).along(coefficient, distances)


@dataclass
class _Walk:
    body: WearingBody
    modulus: float
    load: Load
    oscillation: Oscillation | None

    def along(self, coefficient: float, distances: np.ndarray) -> Iterator[WornLine]:
        """Yield the states at the distances."""
        farthest = 1.0 if self.oscillation is None else 4 * self.oscillation.amplitude
        longest = _STEP * self.body.spacing / (coefficient * self.modulus * farthest)
        needed = float(distances[-1]) / longest
        if not needed <= MOST_STEPS:
            raise ConvergenceError(f"the wear takes {needed:.3g} steps, more than {MOST_STEPS}")
        worn, volume, at, steps = np.zeros(self.body.places), 0.0, 0.0, 0
        for distance in distances:
            count = int(np.ceil((distance - at) / longest))
            k = coefficient * (distance - at) / count
            for _ in range(count):
                first = self._rate(worn)
                second = self._rate(worn + k * first.depth)
                worn = worn + 0.5 * k * (first.depth + second.depth)
                volume += 0.5 * k * (first.volume + second.volume)
            at, steps = float(distance), steps + count
            depth, force = self._press(worn)
            contact, stuck = self._contact(worn, depth), self._stuck(worn, depth)
            yield WornLine(depth, contact, force, worn, volume, stuck, steps)

    def _press(self, worn: np.ndarray) -> tuple[float, float]:
        """Return the penetration since first touch of the unworn body, and the springs' force."""
        line = self.body.line(worn)
        touch = -float(line.single().max())
        if self.load.control == "force":
            contact = press(line, self.modulus, self.load, edges="nodal")
            return touch + float(contact.penetration[0, 0]), self.load.single()
        depth = self.load.single()
        if depth <= touch:
            raise ConvergenceError("worn so far that nothing touches any more")
        contact = press(line, self.modulus, Load("penetration", depth - touch), edges="nodal")
        return depth, float(contact.force[0, 0])

    def _contact(self, worn: np.ndarray, depth: float) -> LineContact:
        line = self.body.line(worn)
        over = depth + float(line.single().max())
        return press(line, self.modulus, Load("penetration", over))

    def _rate(self, worn: np.ndarray) -> Rate:
        depth, _ = self._press(worn)
        if self.oscillation is None:
            return self.body.rate(worn, self.modulus, depth, None)
        rate = self.body.rate(worn, self.modulus, depth, depth - self.oscillation.lag)
        return Rate(self.oscillation.slip * rate.depth, self.oscillation.slip * rate.volume)

    def _stuck(self, worn: np.ndarray, depth: float) -> float:
        """Return the length of the springs with g < d - lag."""
        if self.oscillation is None:
            return 0.0
        inner = depth - self.oscillation.lag
        if inner <= -float(self.body.line(worn).single().max()):
            return 0.0
        return float(self._contact(worn, inner).contact_length[0, 0])
