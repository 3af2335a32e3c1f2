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
    control, prescribed = load.one_of(*CONTROLS), load.single()
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

    def rate(worn: np.ndarray) -> Rate:
        depth, _ = pressed(worn)
        if oscillation is None:
            return body.rate(worn, modulus, depth, None)
        slipped = body.rate(worn, modulus, depth, depth - oscillation.lag)
        return Rate(oscillation.slip * slipped.depth, oscillation.slip * slipped.volume)

    def stuck(worn: np.ndarray, depth: float) -> float:
        """Return the length of the springs with g < d - lag."""
        inner = -np.inf if oscillation is None else depth - oscillation.lag
        if inner <= -float(body.line(worn).single().max()):
            return 0.0
        return float(contact_at(worn, inner).contact_length[0, 0])

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
                first = rate(worn)
                second = rate(worn + k * first.depth)
                worn = worn + 0.5 * k * (first.depth + second.depth)
                volume += 0.5 * k * (first.volume + second.volume)
            at, steps = float(distance), steps + count
            depth, force = pressed(worn)
            contact = contact_at(worn, depth)
            yield WornLine(depth, contact, force, worn, volume, stuck(worn, depth), steps)

    return along()
