"""Section 19.3 (a), Fig. 19.4: quasi-static impacts; a rigid mass on contact springs in time."""

from __future__ import annotations

from functools import lru_cache
from typing import Annotated, Literal

import numpy as np

from comparisons.questions.experiments.experiment import Above, Finding, OneOf, Share, experiment
from reduced.motion.course import Mass, Push, move
from reduced.motion.elastic_impact import spring_contact
from reduced.motion.stepping import Stepping
from reduced.profiles import equivalents
from reduced.springs.line import Springs
from reference.closed_form import paraboloid
from reference.dynamics.collision import (
    power_law_collision,
    power_law_motion,
    rayleigh_share,
    wave_impact,
    weak_loss,
)
from reference.dynamics.vibration import (
    Forced,
    contact_resonance,
    deepest_without_flight,
    forced_vibration,
    free_period,
    linear_amplitude,
    power_backbone,
)

QUANTITIES = ("energy", "restitution", "duration", "force")


@experiment(
    "quasi-static-impact",
    "Hertz's quasi-static impact of a sphere against the impact with waves",
    "speed",
    "speed over that of sound v/c0",
)
def quasi_static_impact(
    effort: str,
    *,
    speed: float = 0.01,
    quantity: Annotated[str, OneOf(*QUANTITIES)] = "energy",
    poisson_ratio: float = 0.3,
    density_ratio: Annotated[float, Above(0)] = 1.0,
    elastic_sphere: bool = False,
) -> Finding | Share:
    """Compare Hertz's quasi-static impact of a sphere at v/c0 with an impact that radiates waves.

    ``"energy"``: the share of the kinetic energy that is radiated; Hertz's theory loses none. The
    bar is the effect of the next order of the expansion in contact radius over wavelength.
    """
    collision = wave_impact(speed, poisson_ratio, density_ratio, bool(elastic_sphere))
    # the larger of the expansion parameter and the difference of its two forms
    orders = max(collision.slowness, weak_loss(collision.radiation) / collision.energy_lost - 1)
    lost = collision.energy_lost
    details: dict[str, float | str] = {
        "energy radiated": lost,
        "to first order": weak_loss(collision.radiation),
        "energy radiated over (v/c0)^(3/5)": lost / speed**0.6,
        "share of surface waves in it": rayleigh_share(poisson_ratio),
        "restitution": collision.restitution,
        "duration over Hertz's": collision.duration,
        "force over Hertz's": collision.force,
    }
    if quantity == "energy":
        return Share(lost, lost * orders, details)
    true = {
        "restitution": collision.restitution,
        "duration": collision.duration,
        "force": collision.force,
    }[quantity]
    return Finding(1.0, true, abs(1 / true - 1) * orders, details)


EXACT = 1e-9  # tolerance of quadratures and Runge-Kutta steps
MODELS = ("springs", "linear", "second_order")
# A ball with R = E* = m = 1 under F0 = 1/6: d0 = 1/4, k = 1, w0 = 1.
_BALL, _LOAD, _STATIC = paraboloid(1.0, 1.0), 1 / 6, 0.25
_DAMPING, _PERIODS = 0.1, 80


def _one_more(effort: str, coarse: int, fine: int) -> tuple[int, int]:
    """Return numbers of steps by factors of four, more at full effort."""
    steps = fine if effort == "full" else coarse
    return steps, 4 * steps


@experiment(
    "free-vibration",
    "Frequency of a ball that vibrates on its contact, up to flight, against its energy",
    "deepest",
    "deepest point over static penetration",
)
def free_vibration(
    effort: str,
    *,
    deepest: Annotated[float, Above(1)] = 1.5,
    model: Annotated[str, OneOf(*MODELS)] = "springs",
) -> Finding:
    """Measure a ball's free vibration with deepest point `deepest` times the static penetration.

    The ball loses contact beyond 1.842. ``"springs"``: half a period of time stepping, from the
    deepest point to the highest; ``"linear"``: the resonance of small vibrations;
    ``"second_order"``: its softening with the square of the amplitude (Nayak 1972).
    """
    period = free_period(_BALL, 1.0, _LOAD, deepest * _STATIC)
    small = 2 * np.pi / contact_resonance(_BALL, 1.0, _LOAD)
    flies = deepest * _STATIC > deepest_without_flight(_BALL, _LOAD)
    details: dict[str, float | str] = {
        "frequency over that of small vibrations": small / period,
        "the ball": "flies" if flies else "stays in contact",
    }
    if model == "linear":
        return Finding(1 / small, 1 / period, EXACT, details)
    contact = spring_contact(Springs(equivalents.paraboloid(1.0), 1.0), deepest * _STATIC)
    halves, highest = [], []  # time from the deepest point to the highest one, and its position
    for steps in _one_more(effort, 1000, 4000):
        step = 0.6 * period / steps
        mass = Mass(1.0, position=deepest * _STATIC)
        run = move(contact, mass, Stepping(step, steps), Push(_LOAD))
        v = run.velocity
        k = int(np.flatnonzero((v[1:-1] < 0) & (v[2:] >= 0))[0]) + 1
        halves.append(float(run.time[k] + step * v[k] / (v[k] - v[k + 1])))
        highest.append(float(run.position.min()))
    if model == "second_order":
        softened = power_backbone(2, 0.5 * (deepest - highest[1] / _STATIC))
        return Finding(softened / small, 1 / period, EXACT, details)
    few, many = (0.5 / half for half in halves)
    return Finding(many, 1 / period, abs(many - few) * period + EXACT, details)


@experiment(
    "forced-vibration",
    "Amplitude of a ball driven at its contact resonance, against Runge-Kutta's",
    "push",
    "amplitude of the force over the load P/F0",
)
def forced(
    effort: str,
    *,
    push: Annotated[float, Above(0)] = 0.1,
    model: Literal["springs", "linear"] = "springs",
) -> Finding:
    """Measure a ball's amplitude at its contact resonance, with 5 % of critical damping.

    `push`: amplitude of the force over the load. The reference is Runge-Kutta on the closed form.
    """
    frequency = contact_resonance(_BALL, 1.0, _LOAD)
    exact = _steady(push)
    details: dict[str, float | str] = {
        "amplitude over static depth": exact.amplitude / _STATIC,
        "share of the period in flight": exact.flight,
    }
    steady = exact.change + EXACT
    if model == "linear":
        stated = linear_amplitude(1.0, frequency**2, _DAMPING, push * _LOAD, frequency)
        return Finding(stated, exact.amplitude, steady, details)
    contact = spring_contact(Springs(equivalents.paraboloid(1.0), 1.0), 4 * _STATIC)
    swings = []
    for steps in _one_more(effort, 100, 400):
        run = move(
            contact,
            Mass(1.0, _DAMPING, position=_STATIC),
            Stepping(2 * np.pi / frequency / steps, _PERIODS * steps),
            Push(_LOAD, push * _LOAD, frequency),
            scheme="verlet",
        )
        swings.append(0.5 * float(np.ptp(run.position[-steps:])))
    bar = abs(swings[1] - swings[0]) / exact.amplitude + steady
    return Finding(swings[1], exact.amplitude, bar, details)


@lru_cache(maxsize=64)
def _steady(push: float) -> Forced:
    """Return the steady vibration on the closed form."""
    frequency = contact_resonance(_BALL, 1.0, _LOAD)
    return forced_vibration(
        *(_BALL, 1.0, _DAMPING, _LOAD, push * _LOAD, frequency),
        periods=_PERIODS,
        tolerance=1e-9,
    )


@experiment(
    "impact-in-time",
    "Course of an impact in time on springs, against the inverted integral of Deresiewicz",
    "exponent",
    "exponent n of f = c r^n",
)
def impact_in_time(effort: str, *, exponent: Annotated[float, Above(0)] = 2.0) -> Share:
    """Measure an impact of f = r^n on springs: largest error of depth over the largest depth.

    The reference is the inverted integral of Hertz and Deresiewicz for every n.
    """
    speed = 0.01
    exact = power_law_collision(exponent, 1.0, 1.0, 1.0, speed)
    profile = equivalents.power_law(exponent, 1.0)
    errors = []
    for springs, steps in zip((40, 80), _one_more(effort, 250, 1000), strict=True):
        contact = spring_contact(Springs(profile, 1.0, springs), 1.01 * exact.penetration)
        run = move(contact, Mass(1.0, velocity=speed), Stepping(exact.duration / steps, steps))
        true = power_law_motion(exponent, exact, np.minimum(run.time, exact.duration))
        errors.append(float(np.abs(run.position - true).max()) / exact.penetration)
    details: dict[str, float | str] = {
        "duration times v over depth": exact.duration * speed / exact.penetration
    }
    return Share(errors[1], abs(errors[1] - errors[0]) + EXACT, details, "deviation")
