"""Closed forms with Coulomb friction: sliding to rest, stick-slip on a belt, a dry oscillator."""

from __future__ import annotations

import math
from dataclasses import dataclass


def _positive(**values: float) -> None:
    wrong = [
        f"{k} must be finite and positive, not {v!r}"
        for k, v in values.items()
        if not (math.isfinite(v) and v > 0)
    ]
    if wrong:
        raise ValueError("; ".join(wrong))


def stopping(mass: float, friction: float, speed: float, load: float = 0.0) -> tuple[float, float]:
    """Return time and distance to rest of a sliding body: m v/(R - F), v t/2.

    Parameters
    ----------
    mass, friction, speed : float
        m, R = mu F_N and v, positive.
    load : float
        Force F in the direction of motion, below R (on a slope m g sin a).

    Raises
    ------
    ValueError
        If an argument is not positive, or the load exceeds the friction and the body never stops.

    Examples
    --------
    >>> stopping(1.0, 0.5, 2.0)
    (4.0, 4.0)
    """
    _positive(mass=mass, friction=friction, speed=speed)
    if not load < friction:
        raise ValueError(f"the body does not stop: load {load!r}, friction {friction!r}")
    time = mass * speed / (friction - load)
    return time, 0.5 * speed * time


@dataclass(frozen=True)
class StickSlip:
    """One cycle of an oscillator on a belt.

    Attributes
    ----------
    sticking, slipping : float
        Times; their sum is the period.
    jump : float
        Difference between the largest and the smallest elongation of the spring during stick.
    largest, smallest : float
        Largest and smallest elongation in the cycle, including the overshoot after the onset of
        slip.
    """

    sticking: float
    slipping: float
    jump: float
    largest: float
    smallest: float

    @property
    def period(self) -> float:
        """Period, sticking plus slipping time."""
        return self.sticking + self.slipping


def stick_slip(
    mass: float, stiffness: float, belt_speed: float, static: float, kinetic: float
) -> StickSlip:
    """Return the limit cycle of a mass held by a spring on a belt moving at V.

    With D = (F_s - F_k)/k, the block sticks while the spring elongates by 2 D, then oscillates
    about F_k/k with amplitude sqrt(D^2 + (V/w)^2) for the time (2 pi - 2 arctan(D w/V))/w, then it
    moves with the belt again (Popov, Contact Mechanics and Friction, ch. 12; Den Hartog, Mechanical
    Vibrations, ch. 7). For F_s = F_k there is no stick.

    Parameters
    ----------
    mass, stiffness, belt_speed, static, kinetic : float
        m, k, V, F_s, F_k: positive, F_s >= F_k.

    Examples
    --------
    >>> round(stick_slip(1.0, 1.0, 1.0, 2.0, 1.0).period - 2 - 1.5 * math.pi, 12)
    0.0
    """
    _positive(mass=mass, stiffness=stiffness, belt_speed=belt_speed, static=static, kinetic=kinetic)
    if static < kinetic:
        raise ValueError(f"static friction {static!r} is below the kinetic one {kinetic!r}")
    frequency = math.sqrt(stiffness / mass)
    half = (static - kinetic) / stiffness
    swing = math.hypot(half, belt_speed / frequency)
    angle = math.atan2(half * frequency, belt_speed)
    return StickSlip(
        sticking=2 * half / belt_speed,
        slipping=2 * (math.pi - angle) / frequency,
        jump=2 * half,
        largest=kinetic / stiffness + swing,
        smallest=kinetic / stiffness - swing,
    )


def dry_oscillator_amplitude(
    stiffness: float, friction: float, force: float, frequency_ratio: float
) -> float:
    """Return the amplitude of an oscillator under P cos(W t) and Coulomb friction R, without stops.

    x0 = (P/k) sqrt(A^2 - (R/P)^2 B^2), A = 1/(1 - r^2), B = sin(pi/r)/(r (1 + cos(pi/r))), r the
    ratio of W to the natural frequency (Den Hartog, Trans. ASME 53 (1931) APM-107). Valid if the
    block does not stop within a half-period, which the caller checks.

    Raises
    ------
    ValueError
        At resonance, and if the root is not real, because friction stops the block for part of a
        period.

    Examples
    --------
    >>> round(dry_oscillator_amplitude(1.0, 0.0, 1.0, 0.5), 12)  # no friction: 1/(1 - r^2)
    1.333333333333
    """
    _positive(stiffness=stiffness, force=force, frequency_ratio=frequency_ratio)
    r = frequency_ratio
    if r == 1 or not friction >= 0:
        raise ValueError(f"no amplitude at resonance or below no friction: {r!r}, {friction!r}")
    response = 1 / (1 - r * r)
    loss = math.sin(math.pi / r) / (r * (1 + math.cos(math.pi / r)))
    square = response**2 - (friction / force * loss) ** 2
    if not square > 0:
        raise ValueError(f"friction {friction!r} stops the block within each half-period")
    return force / stiffness * math.sqrt(square)
