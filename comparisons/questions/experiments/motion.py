"""Motion in time: the law of friction (19.1) and Coulomb's; impacts and vibrations on a contact.

Section 19.1.1 has the continuous law in place of Coulomb's; 19.3 (a), Fig. 19.4 quasi-static
impacts.
"""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from comparisons.questions.experiments import coulomb
from comparisons.questions.experiments.coulomb import (
    dry_oscillator_amplitude,
    follow,
    march,
    stick_slip,
    stopping,
)
from comparisons.questions.experiments.experiment import (
    Finding,
    Fraction,
    Positive,
    Share,
    experiment,
)
from comparisons.questions.experiments.vibrations import (
    contact_resonance,
    deepest_without_flight,
    forced_vibration,
    free_period,
    linear_amplitude,
    rayleigh_share,
    wave_impact,
)
from reduced.motion.blocks import (
    Blocks,
    creep_speed,
    friction,
    integrate,
    missing_friction,
    stable_step,
)
from reduced.motion.course import Mass, Push, Stepping, move
from reduced.motion.elastic_impact import SpringContact
from reduced.profiles import equivalents
from reduced.springs.line import Springs
from reference.closed_form import paraboloid
from reference.dynamics.collision import weak_loss

EXACT = 1e-12  # rounding of formulas, and of the event-driven motion
# The oscillator with m = k = P = 1 that sticks twice per period of its force, and its friction.
_LIMIT = 0.9
_DRIVEN = {"stiffness": 1.0, "amplitude": 1.0, "frequency": 0.4}
_PERIODS = 4


@experiment("regularised-block", "sliding speed over characteristic speed V/v0")
def regularised_block(
    effort: str,
    *,
    speed_ratio: Positive = 100.0,
    load: Annotated[float, Field(ge=0, lt=1)] = 0.5,
    quantity: Literal["rest", "force", "kinetic", "way"] = "rest",
) -> Finding | Share:
    """One block under the law (19.1) against Coulomb's: at rest, sliding, stopping.

    Measure a block of mass 1 and friction limit 1, pulled by `load`, with sliding speed V = 1.
    ``"rest"``: creep speed over V. ``"force"``: the friction after the time of 1000 stops from V,
    relative to the load. ``"kinetic"``: the friction at V. ``"way"``: the stopping distance from V
    without load.
    """
    v0 = 1 / speed_ratio
    creep = float(creep_speed(load, 1.0, v0))
    details = {"creep over v0": creep / v0, "v0 over V": v0}
    if quantity == "rest":
        return Share(creep, EXACT * creep, details)
    if quantity == "kinetic":
        return Finding(1 - float(missing_friction(1.0, v0)), 1.0, EXACT, details)
    if quantity == "force":
        run = integrate(Blocks(1.0, 1.0, load=load), v0, Stepping(1.0, 1000, stride=1000))
        friction_force = float(friction(run.velocity[-1, 0], 1.0, v0))
        return Finding(friction_force, float(load), EXACT, details)
    # the stopping distance, to 10 v0, with twice as many steps for the bar
    way = stopping(1.0, 1.0, 1.0)[1]
    ways = []
    for steps in (20_000, 40_000) if effort == "full" else (5000, 10_000):
        run = integrate(
            Blocks(1.0, 1.0),
            v0,
            Stepping((2 + 20 * v0) / steps, steps, stride=steps),
            scheme="implicit_midpoint",
            velocity=1.0,
        )
        ways.append(float(run.position[-1, 0]))
    details["4/pi v0/V"] = 4 / np.pi * v0
    return Finding(ways[1], way, abs(ways[1] - ways[0]) / way + EXACT, details)


@experiment("regularised-stick-slip", "largest sliding speed over characteristic speed V/v0")
def regularised_stick_slip(effort: str, *, speed_ratio: Positive = 1e3) -> Share:
    """An oscillator that sticks and slips under (19.1) against Coulomb's law, event by event.

    Den Hartog's oscillator with stops: the largest error of the position over four periods.
    Relative to the largest position; V is the largest speed of the true motion.
    """
    end = _PERIODS * 2 * np.pi / _DRIVEN["frequency"]
    instants = np.linspace(0, end, 1001)
    motion = follow(coulomb.Blocks(1.0, _LIMIT, **_DRIVEN), end)
    position, velocity = (component[:, 0] for component in motion.at(instants))
    v0 = float(np.abs(velocity).max()) / speed_ratio
    errors = []
    for steps in (40_000, 80_000) if effort == "full" else (20_000, 40_000):
        run = integrate(
            Blocks(1.0, _LIMIT, **_DRIVEN),
            v0,
            Stepping(end / steps, steps, stride=steps // 1000),
            scheme="implicit_midpoint",
        )
        deviation = run.position[:, 0] - position
        errors.append(float(np.abs(deviation).max() / np.abs(position).max()))
    details = {
        "error over (v0/V)^(2/3)": errors[1] * speed_ratio ** (2 / 3),
        "stops": float(sum(phase.direction[0] == 0 for phase in motion.phases)),
    }
    return Share(errors[1], abs(errors[1] - errors[0]) + EXACT, details, "deviation")


@experiment("regularised-belt", "static over kinetic friction")
def regularised_belt(
    effort: str,
    *,
    static: Annotated[float, Field(gt=0.999999)] = 1.2,
    speed_ratio: Positive = 1e3,
    cycles: Annotated[int, Field(strict=False, ge=1, le=1000)] = 10,
) -> Finding:
    """A mass on a belt: (19.1) against static friction above the kinetic one.

    Measure the amplitude of a mass on a belt after `cycles`; V = m = k = kinetic friction = 1. The
    reference is the closed stick-slip cycle; the law contains only kinetic friction.
    """
    v0 = 1 / speed_ratio
    cycle = stick_slip(1.0, 1.0, 1.0, static, 1.0)
    true = 0.5 * (cycle.largest - cycle.smallest)
    swings = []
    per_cycle = 5000 if effort == "full" else 1000
    for steps in ((cycles + 2) * per_cycle, 2 * (cycles + 2) * per_cycle):
        run = integrate(
            Blocks(1.0, 1.0, stiffness=1.0, belt=1.0),
            v0,
            Stepping((cycles + 2) * cycle.period / steps, steps),
            scheme="implicit_midpoint",
            position=static,
            velocity=1.0,
        )
        late = run.position[steps * cycles // (cycles + 2) :, 0]
        swings.append(0.5 * float(np.ptp(late)))
    return Finding(swings[1], true, abs(swings[1] - swings[0]) / true + EXACT, {})


@experiment("explicit-friction-step", "load over friction limit F/(mu F_N)")
def explicit_friction_step(
    effort: str,
    *,
    load: float = 0.0,
    scheme: Literal["explicit_euler", "semi_implicit_euler", "runge_kutta_4"] = "explicit_euler",
) -> Finding:
    """Largest stable explicit step under (19.1): theory against the step at which it breaks.

    Of a creeping block, by bisection.
    """
    v0 = 1e-3
    theory = stable_step(1.0, 1.0, v0, load, scheme)
    creep = float(creep_speed(load, 1.0, v0))
    start = creep + 1e-6 * v0

    def grows(step: float) -> bool:
        run = integrate(
            Blocks(1.0, 1.0, load=load),
            v0,
            Stepping(step, 4000, stride=4000),
            scheme=scheme,
            velocity=start,
        )
        return bool(abs(run.velocity[-1, 0] - creep) > abs(start - creep))

    low, high = 0.25 * theory, 4 * theory
    if grows(low) or not grows(high):
        raise ArithmeticError(f"no limit of {scheme} between a quarter and four times the theory's")
    for _ in range(16 if effort == "full" else 12):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if grows(middle) else (middle, high)
    limit = 0.5 * (low + high)
    details = {"limit over m v0/(mu F_N)": limit / v0}
    return Finding(theory, limit, (high - low) / limit, details)


_SETTLING = 100  # periods until the amplitude of an oscillator is steady that never stops


@experiment("set-valued-steps", "steps per period of the force")
def set_valued_steps(
    effort: str,
    *,
    steps: Annotated[float, Field(gt=2)] = 100.0,
    load: Fraction = 0.5,
    quantity: Literal["oscillator", "rest"] = "oscillator",
) -> Share:
    """Coulomb's law as a set in fixed steps (Moreau and Jean), against its motion by events.

    ``"oscillator"``: largest error of the position over four periods, over the largest position.
    ``"rest"``: the path of a block pulled by `load` < 1 against friction 1 in as many steps of unit
    length, over its path without friction.
    """
    count = int(steps)
    if quantity == "rest":
        motion = march(coulomb.Blocks(1.0, 1.0, load=load), step=1.0, steps=count)
        way = float(motion.position[-1, 0]) / (0.5 * load * count**2)
        return Share(way, EXACT, {"law evaluations": float(motion.evaluations)})
    end = _PERIODS * 2 * np.pi / _DRIVEN["frequency"]
    system = coulomb.Blocks(1.0, _LIMIT, **_DRIVEN)
    exact = follow(system, end)
    stepped = march(system, step=end / (_PERIODS * count), steps=_PERIODS * count)
    position = exact.at(np.minimum(stepped.time, end))[0][:, 0]
    deviation = np.abs(stepped.position[:, 0] - position).max()
    largest = np.abs(exact.at(np.linspace(0, end, 2001))[0]).max()
    details = {
        "law evaluations": float(stepped.evaluations),
        "share of the time at rest": exact.time_sticking() / end,
    }
    return Share(float(deviation / largest), EXACT, details, "deviation")


@experiment("regularised-amplitude", "largest sliding speed over characteristic speed V/v0")
def regularised_amplitude(effort: str, *, speed_ratio: Positive = 100.0) -> Finding:
    """Amplitude of a dry oscillator under (19.1) against Den Hartog's closed form.

    For m = k = P = 1 without stops, friction 0.6, a force of 1.2 times the natural frequency; V is
    the largest speed of a sinusoid of the true amplitude. Sources of the bar: twice as many steps,
    and the change over the last periods.
    """
    limit, ratio = 0.6, 1.2
    true = dry_oscillator_amplitude(1.0, limit, 1.0, ratio)
    v0 = true * ratio / speed_ratio
    system = Blocks(1.0, limit, stiffness=1.0, amplitude=1.0, frequency=ratio)
    swings = []
    for steps in (800, 1600) if effort == "quick" else (3200, 6400):
        run = integrate(
            *(system, v0),
            Stepping(2 * np.pi / ratio / steps, _SETTLING * steps),
            scheme="implicit_midpoint",
        )
        last = run.position[-2 * steps :, 0].reshape(2, steps)
        swings.append(0.5 * np.ptp(last, axis=1))
    (coarse, fine), before = (swing[1] for swing in swings), swings[1][0]
    bar = abs(fine - coarse) + abs(fine - before)
    details = {"amplitude, Den Hartog": true, "by the law": float(fine)}
    return Finding(float(fine), true, float(bar / true) + EXACT, details)


@experiment("quasi-static-impact", "speed over that of sound v/c0")
def quasi_static_impact(
    effort: str, *, speed: float = 0.01, quantity: Literal["energy", "duration", "force"] = "energy"
) -> Finding | Share:
    """Hertz's quasi-static impact of a sphere against the impact with waves.

    A rigid sphere at v/c0, nu = 0.3. ``"energy"``: the share of the kinetic energy that is
    radiated; Hertz's theory loses none. The bar is the effect of the next order of the expansion in
    contact radius over wavelength.
    """
    collision = wave_impact(speed, 0.3)
    # the larger of the expansion parameter and the difference of its two forms
    orders = max(collision.slowness, weak_loss(collision.radiation) / collision.energy_lost - 1)
    lost = collision.energy_lost
    details = {
        "energy radiated": lost,
        "to first order": weak_loss(collision.radiation),
        "energy radiated over (v/c0)^(3/5)": lost / speed**0.6,
        "share of surface waves in it": rayleigh_share(0.3),
        "restitution": collision.restitution,
        "duration over Hertz's": collision.duration,
        "force over Hertz's": collision.force,
    }
    if quantity == "energy":
        return Share(lost, lost * orders, details)
    true = float(getattr(collision, quantity))
    return Finding(1.0, true, abs(1 / true - 1) * orders, details)


_SOLVED = 1e-9  # tolerance of quadratures and Runge-Kutta steps
# A ball with R = E* = m = 1 under F0 = 1/6: d0 = 1/4, k = 1, w0 = 1.
_BALL, _LOAD, _STATIC = paraboloid(1.0, 1.0), 1 / 6, 0.25
_DAMPING, _SWINGS = 0.1, 80


def _one_more(effort: str, coarse: int, fine: int) -> tuple[int, int]:
    """Return numbers of steps by factors of four, more at full effort."""
    steps = fine if effort == "full" else coarse
    return steps, 4 * steps


@experiment("free-vibration", "deepest point over static penetration")
def free_vibration(
    effort: str,
    *,
    deepest: Annotated[float, Field(gt=1)] = 1.5,
    model: Literal["springs", "linear"] = "springs",
) -> Finding:
    """Frequency of a ball that vibrates on its contact, up to flight, against its energy.

    Measure a ball's free vibration with deepest point `deepest` times the static penetration. The
    ball loses contact beyond 1.842. ``"springs"``: half a period of time stepping, from the deepest
    point to the highest; ``"linear"``: the resonance of small vibrations.
    """
    period = free_period(_BALL, 1.0, _LOAD, deepest * _STATIC)
    small = 2 * np.pi / contact_resonance(_BALL, 1.0, _LOAD)
    flies = deepest * _STATIC > deepest_without_flight(_BALL, _LOAD)
    details = {
        "frequency over that of small vibrations": small / period,
        "the ball": "flies" if flies else "stays in contact",
    }
    if model == "linear":
        return Finding(1 / small, 1 / period, _SOLVED, details)
    contact = SpringContact(Springs(equivalents.paraboloid(1.0), 1.0), deepest * _STATIC)
    halves = []  # time from the deepest point to the highest one
    for steps in _one_more(effort, 1000, 4000):
        step = 0.6 * period / steps
        mass = Mass(1.0, position=deepest * _STATIC)
        run = move(contact, mass, Stepping(step, steps), Push(_LOAD))
        v = run.velocity
        k = int(np.flatnonzero((v[1:-1] < 0) & (v[2:] >= 0))[0]) + 1
        halves.append(float(run.time[k] + step * v[k] / (v[k] - v[k + 1])))
    few, many = (0.5 / half for half in halves)
    return Finding(many, 1 / period, abs(many - few) * period + _SOLVED, details)


@experiment("forced-vibration", "amplitude of the force over the load P/F0")
def forced(
    effort: str, *, push: Positive = 0.1, model: Literal["springs", "linear"] = "springs"
) -> Finding:
    """Amplitude of a ball driven at its contact resonance, against Runge-Kutta's.

    Measure a ball's amplitude at its contact resonance, with 5 % of critical damping. `push`:
    amplitude of the force over the load. The reference is Runge-Kutta on the closed form.
    """
    frequency = contact_resonance(_BALL, 1.0, _LOAD)
    exact = forced_vibration(
        *(_BALL, 1.0, _DAMPING, _LOAD, push * _LOAD, frequency), periods=_SWINGS, tolerance=1e-9
    )
    details = {
        "amplitude over static depth": exact.amplitude / _STATIC,
        "share of the period in flight": exact.flight,
    }
    steady = exact.change + _SOLVED
    if model == "linear":
        stated = linear_amplitude(1.0, frequency**2, _DAMPING, push * _LOAD, frequency)
        return Finding(stated, exact.amplitude, steady, details)
    contact = SpringContact(Springs(equivalents.paraboloid(1.0), 1.0), 4 * _STATIC)
    swings = []
    for steps in _one_more(effort, 100, 400):
        run = move(
            contact,
            Mass(1.0, _DAMPING, position=_STATIC),
            Stepping(2 * np.pi / frequency / steps, _SWINGS * steps),
            Push(_LOAD, push * _LOAD, frequency),
            scheme="verlet",
        )
        swings.append(0.5 * float(np.ptp(run.position[-steps:])))
    bar = abs(swings[1] - swings[0]) / exact.amplitude + steady
    return Finding(swings[1], exact.amplitude, bar, details)
