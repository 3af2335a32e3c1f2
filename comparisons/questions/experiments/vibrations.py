"""A mass on a contact: vibrations and flight, and its impact with radiated waves.

m x'' = F0 + P cos(W t) - c x' - F(x), F the static force of the contact, zero in flight (x < 0),
F0 the constant load with F(d0) = F0. An impact radiates; a share of that is Rayleigh waves.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

from reference.arrays import Array
from reference.closed_form.form import ClosedForm, require_positive
from reference.dynamics.collision import (
    HERTZ_DURATION,
    radiation_number,
    speed_ratio,
    through_touches,
    work,
)
from reference.errors import ConvergenceError, finite_faults, positive_faults, refuse


def contact_resonance(form: ClosedForm, mass: float, load: float) -> float:
    """Return w0 = sqrt(k/m) of small vibrations under a load, k = dF/dd = 2 E* a for a circle.

    For Hertz k^3 = 6 E*^2 R F0 (Johnson 1985, section 4.2; the contact resonance of atomic force
    microscopy).

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
    """Return the period of an undamped vibration between x = `deepest` > d0 and its return.

    By energy: T = 2 int dx/w between the turning points, m w^2/2 = V(deepest) - V(x), V = U - F0 x;
    beyond `deepest_without_flight` the mass flies for 2 m v/F0.

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

    def released(low: float, high: float) -> float:
        # V(high) - V(low)
        return float(work(form.force, form.energy, low, high)) - load * (high - low)

    if deepest <= deepest_without_flight(form, load):
        highest = brentq(lambda x: released(x, deepest), 0, static, xtol=1e-15 * static)
        flight, jump = 0.0, 0.0
    else:
        highest, jump = 0.0, released(0.0, deepest)
        flight = 2 * math.sqrt(2 * mass * jump) / load

    # Time between the turning points by x = highest + way sin^2(t), with the energy difference from
    # the nearer end: regular there, without cancellation.
    way = deepest - highest

    def rate(t: float) -> float:
        x, approach = highest + way * math.sin(t) ** 2, way * math.cos(t) ** 2
        if approach < 0.5 * way:
            kinetic = released(deepest - approach, deepest)
        else:
            kinetic = jump - released(highest, x)
        return way * math.sin(2 * t) / math.sqrt(2 / mass * kinetic)

    halves = ((0, math.pi / 4), (math.pi / 4, math.pi / 2))
    passage = sum(quad(rate, *half, epsabs=0, epsrel=1e-10, limit=400)[0] for half in halves)
    return flight + 2 * passage


@dataclass(frozen=True)
class Forced:
    """Steady motion under a harmonic force, over its last period.

    Half the difference, and the mean, of the largest and the smallest x; fraction of the period out
    of contact; relative `change` of the amplitude from the period before; the state at the end.
    """

    amplitude: float
    mean: float
    flight: float
    change: float
    position: float
    velocity: float


def forced_vibration(
    form: ClosedForm,
    mass: float,
    damping: float,
    load: float,
    amplitude: float,
    frequency: float,
    *,
    start: tuple[float, float] | None = None,
    periods: int = 60,
    tolerance: float = 1e-10,
) -> Forced:
    """Return the steady vibration by integration: Runge-Kutta 8(5,3), stopped at every touch.

    m, c, F0, P and W; `start` is x and x' at t = 0 (phase 0 of the force), by default at rest under
    the load: from the state of a neighbouring frequency the motion follows a branch.
    """
    faults = positive_faults(mass=mass, load=load, frequency=frequency)
    refuse(faults + finite_faults(damping=damping, amplitude=amplitude))
    # in units of d0, 1/w0 and m d0 w0^2, so that the absolute tolerance is meaningful
    static = float(form.penetration(load))
    w0 = contact_resonance(form, mass, load)
    unit = mass * static * w0**2
    omega, loss = frequency / w0, damping / (mass * w0)

    def rates(t: float, y: Array) -> list[float]:
        pushed = (load + amplitude * math.cos(omega * t)) / unit
        reaction = float(form.force(y[0] * static)) / unit if y[0] > 0 else 0.0
        return [y[1], pushed - loss * y[1] - reaction]

    position, velocity = (static, 0.0) if start is None else start
    state = np.array([position / static, velocity / (static * w0)])
    time, period = 0.0, 2 * math.pi / omega
    cycles: list[Array] = []
    for number in range(periods):
        end, states = (number + 1) * period, np.empty((2, 2001))
        # from `time`: by rounding, end - period may lie before it, where nothing is sampled
        instants = np.linspace(time, end, 2001)
        state = through_touches(rates, (time, end), state, tolerance, instants, states)
        cycles, time = [*cycles[-1:], states[0]], end
    before, x = cycles
    swing = 0.5 * float(x.max() - x.min())
    return Forced(
        amplitude=static * swing,
        mean=static * 0.5 * float(x.max() + x.min()),
        flight=float((x < 0).mean()),
        change=abs(0.5 * float(before.max() - before.min()) / swing - 1),
        position=static * state[0],
        velocity=static * w0 * state[1],
    )


def rayleigh_share(poisson_ratio: float) -> float:
    """Return the fraction of the radiated power in Rayleigh waves.

    It is the residue of Lamb's integrand at the Rayleigh pole over `radiation_number`.

    >>> round(rayleigh_share(0.25), 3)
    0.674
    """
    g2 = speed_ratio(poisson_ratio)

    def rayleigh(k: float) -> float:
        return (2 * k * k - 1) ** 2 - 4 * k * k * math.sqrt((k * k - g2) * (k * k - 1))

    pole = brentq(rayleigh, 1 + 1e-9, 2.0, xtol=1e-15)
    step = 1e-6 * pole
    slope = (rayleigh(pole + step) - rayleigh(pole - step)) / (2 * step)
    residue = math.pi * pole * math.sqrt(pole * pole - g2) / abs(slope)
    return residue / radiation_number(poisson_ratio)


@dataclass(frozen=True)
class WaveImpact:
    """Impact with radiation relative to Hertz's impact without (Johnson 1985, 11.4).

    `radiation` is e = beta F_max v/delta_max^2, with values of Hertz's impact: the only parameter.
    `energy_lost` is the radiated fraction of the kinetic energy; duration and largest force are
    over those of Hertz's impact. `slowness`, the largest contact radius over the path of a shear
    wave in the time delta_max/v, is the relative order of the neglected terms.
    """

    radiation: float
    energy_lost: float
    restitution: float
    duration: float
    force: float
    slowness: float


def wave_impact(
    speed: float,
    poisson_ratio: float = 0.3,
    density_ratio: float = 1.0,
    elastic_sphere: bool = False,
) -> WaveImpact:
    """Return the impact of a sphere on an elastic half-space.

    x'' = -(5/4) f, f = (x + e d(x^(3/2))/dt)^(3/2), until the rebound, in units of Hertz's largest
    depth, force and the time delta_max/v. The rate of the force is expressed by x, to the order of
    the expansion, because x = f^(2/3) - e f' has runaway solutions, like every radiation reaction.

    The speed is v/c0, over c0 = sqrt(E/rho) of the half-space, in (0, 0.2]; nu in [0, 1/2];
    `density_ratio` is that of the sphere over the half-space. An elastic sphere has the moduli of
    the half-space; its vibrations are neglected (Rayleigh 1906: they take little energy).

    >>> slow, fast = wave_impact(1e-4), wave_impact(1e-2)
    >>> round(math.log(fast.energy_lost / slow.energy_lost) / math.log(100), 2)  # Hunter: 3/5
    0.58
    """
    number = radiation_number(poisson_ratio)
    if not (0 < speed <= 0.2 and density_ratio > 0 and math.isfinite(density_ratio)):
        raise ValueError(
            "expected 0 < speed <= 0.2 and a positive density_ratio, "
            f"got {speed!r} and {density_ratio!r}"
        )
    # Hertz's impact, in units R = E = rho = 1, so that c0 = 1
    modulus = 1 / (1 - poisson_ratio**2) / (2 if elastic_sphere else 1)
    shear = 0.5 / (1 + poisson_ratio)
    mass = 4 / 3 * math.pi * density_ratio
    depth = (15 / 16 * mass * speed**2 / modulus) ** 0.4
    largest = 4 / 3 * modulus * depth**1.5
    wave = math.sqrt(shear)
    radiation = number / (2 * math.pi * shear * wave) * largest * speed / depth**2

    def force(x: float, velocity: float) -> float:
        root = math.sqrt(max(x, 0.0))
        return max(root * (root + 1.5 * radiation * velocity), 0.0) ** 1.5

    def rates(_: float, state: Array) -> list[float]:
        return [state[1], -1.25 * force(*state)]

    def parting(_: float, state: Array) -> float:
        return math.sqrt(max(state[0], 0.0)) + 1.5 * radiation * state[1]

    event: Any = parting  # SciPy reads these attributes of the function
    event.terminal, event.direction = True, -1.0
    solution = solve_ivp(
        *(rates, (0.0, 50.0), [0.0, 1.0]),
        method="DOP853",
        rtol=1e-10,
        atol=1e-12,
        max_step=0.05,
        events=parting,
    )
    if solution.status != 1:
        raise ConvergenceError(f"the sphere stayed in contact: {solution.message}")
    rebound = -float(solution.y[1, -1])
    return WaveImpact(
        radiation=radiation,
        energy_lost=1 - rebound**2,
        restitution=rebound,
        duration=float(solution.t[-1]) / HERTZ_DURATION,
        force=float(max(force(*state) for state in solution.y.T)),
        slowness=math.sqrt(depth) * speed / (wave * depth),
    )
