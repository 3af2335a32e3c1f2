"""A rigid mass on a contact: small and large vibrations, flight, forced motion.

m x'' = F0 + P cos(W t) - c x' - F(x), F the static force of the contact, zero in flight (x < 0),
F0 the constant load with F(d0) = F0.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq

from reference.arguments import finite_faults, positive_faults, refuse
from reference.closed_form.form import ClosedForm, require_positive
from reference.dynamics.collision import work
from reference.dynamics.course import Pieces, sample, through_touches


def contact_resonance(form: ClosedForm, mass: float, load: float) -> float:
    """Return w0 = sqrt(k/m) of small vibrations under a load, k = dF/dd = 2 E* a for a circle.

    For Hertz k^3 = 6 E*^2 R F0 (Johnson 1985, section 4.2; the contact resonance of atomic force
    microscopy).

    Examples
    --------
    >>> from reference.closed_form import paraboloid
    >>> round(contact_resonance(paraboloid(1.0, 1.0), 1.0, 1 / 6), 12)
    1.0
    """
    require_positive("resonance", mass=mass, load=load)
    return math.sqrt(float(form.stiffness(form.penetration(load))) / mass)


def linear_amplitude(
    mass: float, stiffness: float, damping: float, force: float, frequency: float
) -> float:
    """Return the amplitude of the linear oscillator, P/sqrt((k - m W^2)^2 + (c W)^2)."""
    return force / math.hypot(stiffness - mass * frequency**2, damping * frequency)


def power_backbone(exponent: float, relative_amplitude: float) -> float:
    """Return w/w0 of free vibrations of amplitude A on a body f = c r^n, to second order in A/d0.

    F ~ x^q with q = (n+1)/n: by Lindstedt's method w/w0 = 1 - (q-1)(2q+1)/48 (A/d0)^2, that is
    1 - (A/d0)^2/24 for Hertz (Nayak, J. Sound Vib. 22 (1972) 297): the contact softens.
    """
    q = 1 + 1 / exponent
    return 1 - (q - 1) * (2 * q + 1) / 48 * relative_amplitude**2


def deepest_without_flight(form: ClosedForm, load: float) -> float:
    """Return the largest turning depth of an undamped mass without loss of contact.

    U(d) = F0 d, from rest at first touch under its weight. 2.5^(2/3) d0 = 1.842 d0 for Hertz.
    """
    require_positive("load", load=load)
    static = float(form.penetration(load))
    return static * brentq(
        lambda r: float(form.energy(r * static)) / (load * r * static) - 1, 1, 16, xtol=1e-15
    )


def free_period(form: ClosedForm, mass: float, load: float, deepest: float) -> float:
    """Return the period of an undamped vibration whose largest penetration is `deepest`.

    By energy: T = 2 int dx/w between the turning points, m w^2/2 = V(deepest) - V(x), V = U - F0 x;
    beyond `deepest_without_flight` the mass flies for 2 m v/F0.

    Parameters
    ----------
    form : ClosedForm
    mass, load : float
        m and F0.
    deepest : float
        Largest penetration, above the static one d0.

    Examples
    --------
    >>> from reference.closed_form import paraboloid
    >>> ball = paraboloid(1.0, 1.0)
    >>> small = free_period(ball, 1.0, 1 / 6, 0.25 * (1 + 1e-3)) / (2 * math.pi)
    >>> round(1 / small, 9), round(power_backbone(2, 1e-3), 9)
    (0.999999958, 0.999999958)
    """
    require_positive("period", mass=mass, load=load, deepest=deepest)
    static = float(form.penetration(load))
    if not deepest > static:
        raise ValueError(f"deepest must be above the static {static!r}, not {deepest!r}")
    if deepest <= deepest_without_flight(form, load):
        highest = brentq(
            lambda x: _released(form, load, x, deepest), 0, static, xtol=1e-15 * static
        )
        flight = 0.0
    else:
        highest = 0.0
        flight = 2 * math.sqrt(2 * mass * _released(form, load, 0.0, deepest)) / load
    return flight + 2 * _passage(form, mass, load, highest, deepest)


def _released(form: ClosedForm, load: float, x: float, deepest: float) -> float:
    """Return V(deepest) - V(x)."""
    return float(work(form.force, form.energy, x, deepest)) - load * (deepest - x)


def _passage(form: ClosedForm, mass: float, load: float, highest: float, deepest: float) -> float:
    """Return the time from one turning point to the other.

    x = highest + way sin^2(t) in both halves, with the energy difference from the nearer end:
    regular at the turning points, without cancellation.
    """
    way = deepest - highest
    jump = _released(form, load, highest, deepest)  # 0 without flight

    def kinetic(low: float, high: float) -> float:
        return float(work(form.force, form.energy, low, high)) - load * (high - low)

    def rate(t: float) -> float:
        x, approach = highest + way * math.sin(t) ** 2, way * math.cos(t) ** 2
        if approach < 0.5 * way:
            released = kinetic(deepest - approach, deepest)
        else:
            released = (jump if highest == 0 else 0.0) - kinetic(highest, x)
        return way * math.sin(2 * t) / math.sqrt(2 / mass * released)

    middle = math.pi / 4
    first = quad(rate, 0, middle, epsabs=0, epsrel=1e-10, limit=400)[0]
    return first + quad(rate, middle, math.pi / 2, epsabs=0, epsrel=1e-10, limit=400)[0]


@dataclass(frozen=True)
class Mass:
    """A rigid mass m and its viscous damping c."""

    mass: float
    damping: float = 0.0

    def __post_init__(self) -> None:
        refuse(positive_faults(mass=self.mass) + finite_faults(damping=self.damping))


@dataclass(frozen=True)
class Push:
    """The force F0 + P cos(W t) on a mass: load, amplitude and frequency."""

    load: float
    amplitude: float
    frequency: float

    def __post_init__(self) -> None:
        faults = positive_faults(load=self.load, frequency=self.frequency)
        refuse(faults + finite_faults(amplitude=self.amplitude))


@dataclass(frozen=True)
class Forced:
    """Steady motion under a harmonic force.

    Attributes
    ----------
    amplitude : float
        Half the distance between the largest and the smallest x over a period.
    mean : float
        Mean of the largest and the smallest x.
    flight : float
        Fraction of the period out of contact.
    change : float
        Relative change of the amplitude over the last periods, a measure of steadiness.
    """

    amplitude: float
    mean: float
    flight: float
    change: float
    position: float
    velocity: float


def forced_vibration(
    form: ClosedForm,
    mass: Mass,
    push: Push,
    *,
    start: tuple[float, float] | None = None,
    periods: int = 60,
    tolerance: float = 1e-10,
) -> Forced:
    """Return the steady vibration by integration: Runge-Kutta 8(5,3), stopped at every touch.

    Parameters
    ----------
    form : ClosedForm
    mass : Mass
    push : Push
    start : tuple of float, optional
        x and x' at t = 0 (phase 0 of the force); default: at rest under the load. Starting from the
        state of a neighbouring frequency follows a branch.
    periods : int
        Periods of the force; the last is measured and compared with the previous one.
    tolerance : float
        Relative tolerance of the integrator.

    Raises
    ------
    ConvergenceError
        If the integration fails.
    """
    # in units of d0, 1/w0 and m d0 w0^2, so that the absolute tolerance is meaningful
    static = float(form.penetration(push.load))
    w0 = contact_resonance(form, mass.mass, push.load)
    unit = mass.mass * static * w0**2
    omega, loss = push.frequency / w0, mass.damping / (mass.mass * w0)

    def contact(x: float) -> float:
        return float(form.force(x * static)) / unit if x > 0 else 0.0

    def rates(t: float, y: np.ndarray) -> list[float]:
        pushed = (push.load + push.amplitude * math.cos(omega * t)) / unit
        return [y[1], pushed - loss * y[1] - contact(y[0])]

    position, velocity = (static, 0.0) if start is None else start
    state = np.array([position / static, velocity / (static * w0)])
    time, period = 0.0, 2 * math.pi / omega
    cycles: list[Any] = []
    for number in range(periods):
        end = (number + 1) * period
        dense, state = through_touches(rates, time, end, state, tolerance)
        time = end
        cycles = [*cycles[-1:], _extremes(dense, time - period, time)]
    (low, high, _), (lowest, highest, flight) = cycles
    amplitude = 0.5 * (highest - lowest)
    return Forced(
        amplitude=static * amplitude,
        mean=static * 0.5 * (highest + lowest),
        flight=flight,
        change=abs(0.5 * (high - low) / amplitude - 1),
        position=static * state[0],
        velocity=static * w0 * state[1],
    )


def _extremes(pieces: Pieces, start: float, end: float) -> tuple[float, float, float]:
    """Return the minimum and maximum of x and the fraction of x < 0, from 2000 points."""
    x = sample(pieces, np.linspace(start, end, 2001))[0]
    return float(x.min()), float(x.max()), float((x < 0).mean())
