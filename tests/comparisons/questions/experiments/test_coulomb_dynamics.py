"""Coulomb's set-valued law: motion by events against closed forms, energy and fixed steps."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from comparisons.questions.experiments import coulomb
from comparisons.questions.experiments.coulomb import (
    Blocks,
    dry_oscillator_amplitude,
    follow,
    march,
    stick_slip,
    stopping,
)

CHAIN = np.array([[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])


@given(friction=st.floats(0.01, 10), load=st.floats(-0.99, 0.99), speed=st.floats(1e-3, 1e3))
@settings(max_examples=30, deadline=None)
def test_a_block_slides_down_a_slope_and_rests(friction, load, speed):
    """Time and distance of `stopping`, then rest, whatever the slope below the friction angle."""
    time, way = stopping(2.0, friction, speed, load * friction)
    motion = follow(Blocks(2.0, friction, load=load * friction), 3 * time, velocity=speed)
    assert motion.events == pytest.approx([time], rel=1e-12)
    x, v = motion.at([2 * time, 3 * time])
    np.testing.assert_allclose(x, way, rtol=1e-12)
    np.testing.assert_array_equal(v, 0.0)


@pytest.mark.parametrize("static", [1.05, 1.5, 4.0])
def test_stick_slip_on_a_belt_repeats_the_closed_cycle(static):
    """All but the first stick; 1e-10, for a root of a speed that starts with zero slope."""
    cycle = stick_slip(1.3, 4.0, 0.7, static, 1.0)
    system = Blocks(1.3, 1.0, static=static, stiffness=4.0, belt=0.7)
    motion = follow(system, 10 * cycle.period, velocity=0.7)
    lengths = np.diff(motion.events)
    np.testing.assert_allclose(lengths[0::2], cycle.slipping, rtol=1e-10)
    np.testing.assert_allclose(lengths[1::2], cycle.sticking, rtol=1e-10)
    x = motion.at(np.linspace(5 * cycle.period, 7 * cycle.period, 4001))[0]
    assert x.max() == pytest.approx(cycle.largest, rel=1e-5)  # sampled 2000 times per period
    assert x.min() == pytest.approx(cycle.smallest, rel=1e-5, abs=1e-5)


def cycles_lost(rng: np.random.Generator, number: int, accuracy: float = 1e-11) -> list[tuple]:
    """Return the belts, of some at random, on which an event is missing or not at its time.

    Ratios of static to kinetic friction are integers, quarters, near 1 and any. Times are good to
    the rounding of a speed over its slope (F_s - F_k)/m where the block comes to rest. Where the
    speed dips below that of the belt by less than 1e-9 of it, rounding may hide the stick.
    """
    lost = []
    while number:
        mass, stiffness, belt, kinetic = 10.0 ** rng.uniform(-2, 2, 4)
        ratio = rng.choice(
            [rng.integers(2, 12), rng.integers(5, 25) / 4, 1 + 10.0 ** rng.uniform(-5, 0)]
        )
        static, frequency = ratio * kinetic, math.sqrt(stiffness / mass)
        drop = (static - kinetic) / stiffness * frequency / belt
        if drop**2 < 2e-9:
            continue
        number -= 1
        cycle = stick_slip(mass, stiffness, belt, static, kinetic)
        system = Blocks(mass, kinetic, static=static, stiffness=stiffness, belt=belt)
        first = static / stiffness / belt
        motion = follow(system, first + 2 * cycle.period + 0.5 * cycle.slipping, velocity=belt)
        times = first + np.cumsum([0, *[cycle.slipping, cycle.sticking] * 2])
        error = accuracy + 1e-14 * (1 + 1 / drop) / frequency / cycle.period
        if motion.events.size != 5 or np.abs(motion.events - times).max() > error * times[-1]:
            lost.append((mass, stiffness, belt, kinetic, ratio, motion.events, times))
    return lost


def rounded_otherwise(monkeypatch: pytest.MonkeyPatch, rng: np.random.Generator) -> None:
    """Let exponentials end in other last digits, as on another processor, zeros included."""
    exact = coulomb.expm

    def other(A):
        result, seed = exact(A), np.frombuffer(np.asarray(A).tobytes(), np.uint32)
        noise = np.random.default_rng([*seed, shift]).uniform(-1, 1, result.shape)
        return result + 2.0**-53 * np.abs(result).max(axis=-1, keepdims=True) * noise

    shift = int(rng.integers(2**31))
    monkeypatch.setattr(coulomb, "expm", other)


@pytest.mark.parametrize("number", [24, pytest.param(2000, marks=pytest.mark.slow)])
def test_no_belt_loses_a_slip_or_a_stick(number):
    """A quarter of them did, where the processor gave a sticking block a speed of a rounding."""
    assert cycles_lost(np.random.default_rng(number), number) == []


@pytest.mark.parametrize("number", [12, pytest.param(1000, marks=pytest.mark.slow)])
def test_what_the_last_digits_are_decides_no_event(number, monkeypatch):
    """Times to 1e-9: the error of the changed digits grows with a stick, of up to 1e5 units."""
    rng = np.random.default_rng(number)
    rounded_otherwise(monkeypatch, rng)
    assert cycles_lost(rng, number, accuracy=1e-9) == []


def test_blocks_that_act_at_the_same_time_act_once(monkeypatch):
    """Two equal blocks on one belt, a spring between: the events of one, each of them twice."""
    rounded_otherwise(monkeypatch, np.random.default_rng(0))
    cycle = stick_slip(1.3, 4.0, 0.7, 3.0, 1.0)
    spring = np.array([[6.0, -2.0], [-2.0, 6.0]])
    system = Blocks([1.3, 1.3], 1.0, static=3.0, stiffness=spring, belt=0.7)
    events = follow(system, 3.0 / 4.0 / 0.7 + 3.5 * cycle.period, velocity=0.7).events
    assert events.size == 2 * 7
    np.testing.assert_allclose(events[0::2], events[1::2], rtol=1e-12)


def test_a_block_that_only_touches_rest_slides_on():
    """Static friction as the kinetic one: nothing sticks, the speed touches that of the belt."""
    motion = follow(Blocks(1.3, 1.0, stiffness=4.0, belt=0.7), 40.0, velocity=0.7)
    assert motion.events == pytest.approx([1 / 4 / 0.7])
    assert motion.time_sticking() == pytest.approx(1 / 4 / 0.7)


def test_a_force_that_only_touches_the_limit_tears_nothing_off():
    """A harmonic load as large as the static friction: at rest for good; a little more is not."""
    held = Blocks(1.0, 0.5, static=1.0, stiffness=1.0, amplitude=1.0, frequency=0.7)
    assert follow(held, 60.0).events.size == 0
    torn = Blocks(1.0, 0.5, static=1.0, stiffness=1.0, amplitude=1.0 + 1e-9, frequency=0.7)
    assert follow(torn, 60.0).events.size > 0


@pytest.mark.parametrize(("ratio", "friction"), [(0.8, 0.3), (1.5, 0.3), (1.2, 0.6)])
def test_the_dry_oscillator_swings_as_den_hartog_found(ratio, friction):
    """After 100 periods of the force; the transient decays, 1e-5 of it is left at r = 1.5."""
    end = 200 * math.pi / ratio
    system = Blocks(1.0, friction, stiffness=1.0, amplitude=1.0, frequency=ratio)
    motion = follow(system, end)
    x = motion.at(np.linspace(end - 2 * math.pi / ratio, end, 4001))[0][:, 0]
    assert all(phase.direction[0] for phase in motion.phases[-6:])  # three periods without a stop
    expected = dry_oscillator_amplitude(1.0, friction, 1.0, ratio)
    assert 0.5 * (x.max() - x.min()) == pytest.approx(expected, rel=1e-4)


@pytest.mark.slow
@given(
    mass=st.tuples(*[st.floats(0.2, 5)] * 3),
    friction=st.tuples(*[st.floats(0.05, 1)] * 3),
    start=st.tuples(*[st.floats(-3, 3)] * 3),
)
@settings(max_examples=25, deadline=None)
def test_three_blocks_lose_what_friction_took(mass, friction, start):
    """Energy before less after = sum of mu_k F_N times the way slid, to 1e-9."""
    friction, K = np.array(friction), CHAIN
    motion = follow(
        Blocks(mass, friction, static=1.3 * friction, stiffness=K), 20.0, velocity=start
    )
    times = np.array([0.0, *motion.events, 20.0])
    x, v = motion.at(times)
    energy = 0.5 * (v**2 @ np.array(mass)) + 0.5 * np.einsum("ki,ij,kj->k", x, K, x)
    # between events a block does not turn back
    lost = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(x, axis=0)) @ friction)])
    np.testing.assert_allclose(energy + lost, energy[0], rtol=1e-9)


def forced(static: float):
    system = Blocks([1.0, 2.0, 1.0], [0.3, 0.5, 0.2], static=np.array([0.3, 0.5, 0.2]) * static,
                    stiffness=CHAIN, belt=0.1)  # fmt: skip
    return system, follow(system, 30.0)


@pytest.mark.parametrize(("static", "order"), [(1.0, 1.6), (1.3, 0.8)])
def test_fixed_steps_converge_to_the_events(static, order):
    """Moreau-Jean, theta = 1/2: near 2 where the friction is continuous at every event, else 1.

    The place of an event inside its step is arbitrary, so the errors scatter: orders are fitted
    over a factor of 32 in the step, and the fit is good for some tenths.
    """
    system, exact = forced(static)
    steps = 2000 * 2 ** np.arange(6)
    errors = []
    for n in steps:
        motion = march(system, step=30.0 / n, steps=int(n))
        errors.append(
            np.abs(motion.position[:: n // 1000] - exact.at(motion.time[:: n // 1000])[0]).max()
        )
    assert -np.polyfit(np.log(steps), np.log(errors), 1)[0] > order
    assert errors[-1] < 5e-4


@pytest.mark.parametrize("theta", [0.5, 1.0])
def test_fixed_steps_rest_exactly(theta):
    slope = Blocks(2.0, 3.0, load=2.9)
    motion = march(slope, step=10.0, steps=100, theta=theta)
    np.testing.assert_array_equal(motion.position, 0.0)


def test_units_change_no_digit():
    """Length, mass and time scaled by powers of two: bit-identical, events included."""
    length, mass, time = 2.0**-30, 2.0**10, 2.0**-12
    force, stiff = mass * length / time**2, mass / time**2
    plain = follow(Blocks([1.0, 2.0], 0.4, static=0.5, stiffness=CHAIN[:2, :2], belt=0.3), 20.0)
    system = Blocks([mass, 2 * mass], 0.4 * force, static=0.5 * force,
                    stiffness=CHAIN[:2, :2] * stiff, belt=0.3 * length / time)  # fmt: skip
    scaled = follow(system, 20.0 * time)
    np.testing.assert_array_equal(scaled.events / time, plain.events)
    asked = np.linspace(0, 20, 7)
    np.testing.assert_array_equal(scaled.at(asked * time)[0] / length, plain.at(asked)[0])
