"""The regularised friction law (19.1) on rigid blocks: creep, stability of steps, orders."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from reduced.motion.blocks import (
    SCHEMES,
    Blocks,
    creep_speed,
    friction,
    integrate,
    missing_friction,
    stable_step,
)
from reduced.motion.course import Stepping

EXPLICIT = ("explicit_euler", "semi_implicit_euler", "runge_kutta_4")
ORDERS = {
    "explicit_euler": 1,
    "semi_implicit_euler": 1,
    "runge_kutta_4": 4,
    "implicit_euler": 1,
    "implicit_midpoint": 2,
}


def run(blocks, v0, step, steps, **how):
    return integrate(blocks, v0, Stepping(step, steps), **how)


@given(load=st.floats(-0.99, 0.99), limit=st.floats(1e-6, 1e6), speed=st.floats(1e-9, 1e3))
def test_the_creep_carries_its_load(load, limit, speed):
    """The law at the creep speed is the load; tan near its pole loses the digits of 1 - |F|."""
    creep = creep_speed(load * limit, limit, speed)
    assert friction(creep, limit, speed) == pytest.approx(
        load * limit, rel=1e-12, abs=1e-15 * limit
    )


def test_the_law_lacks_friction_as_one_over_the_speed():
    """(2/pi) v0/v: 0.64 % at 100 v0; the arctan's next term is (v0/v)^2/3 of it."""
    v = np.array([1e2, 1e4])
    np.testing.assert_allclose(missing_friction(v, 1.0) * v, 2 / np.pi, rtol=1e-4)
    np.testing.assert_allclose(
        1 - friction(v, 3.0, 1.0) / 3.0, missing_friction(v, 1.0), rtol=1e-11
    )


@pytest.mark.parametrize("scheme", EXPLICIT)
@pytest.mark.parametrize("load", [0.0, 0.6])
def test_explicit_steps_are_stable_up_to_the_limit_of_theory(scheme, load):
    """A small deviation from the creep dies at 0.99 of `stable_step` and grows at 1.01 of it."""
    v0, limit = 1e-3, 2.0
    creep = float(creep_speed(load * limit, limit, v0))
    limit_step = stable_step(1.5, limit, v0, load * limit, scheme)
    start = creep + 1e-4 * v0
    for factor, grows in ((0.99, False), (1.01, True)):
        motion = run(
            Blocks(1.5, limit, load=load * limit),
            v0,
            factor * limit_step,
            200,
            scheme=scheme,
            velocity=start,
        )
        assert (abs(motion.velocity[-1, 0] - creep) > abs(start - creep)) == grows


@pytest.mark.parametrize("ratio", [1.5, 4.0, 100.0])
def test_beyond_the_limit_euler_chatters_at_a_known_amplitude(ratio):
    """The velocity flips at each step, (h L/m)(2/pi) arctan(v/v0) = 2 v: bounded, not at rest."""
    v0, limit, mass = 1e-3, 2.0, 1.0
    step = ratio * stable_step(mass, limit, v0)
    motion = run(Blocks(mass, limit), v0, step, 20000, scheme="explicit_euler", velocity=v0 / 7)
    v = abs(motion.velocity[-1, 0])
    assert motion.velocity[-1, 0] == pytest.approx(-motion.velocity[-2, 0], rel=1e-9)
    assert step * friction(v, limit, v0) / mass == pytest.approx(2 * v, rel=1e-9)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_orders_where_the_law_is_smooth(scheme):
    """Two coupled blocks, one on a belt, v0 of the order of the speeds: against Runge-Kutta 8.

    The observed order over one halving is within 0.15 of the scheme's.
    """
    K = np.array([[2.0, -1.0], [-1.0, 1.5]])
    system = Blocks(
        [1.0, 2.0],
        [0.4, 0.7],
        stiffness=K,
        damping=0.1,
        belt=[0.3, 0.0],
        load=0.2,
        amplitude=[0.5, 0.0],
        frequency=1.3,
    )

    def rates(t, y):
        x, v = y[:2], y[2:]
        push = 0.2 + np.array([0.5, 0.0]) * np.cos(1.3 * t) - K @ x - 0.1 * v
        law = 2 / np.pi * np.array([0.4, 0.7]) * np.arctan((v - np.array([0.3, 0])) / 0.5)
        return np.concatenate([v, (push - law) / np.array([1.0, 2.0])])

    exact = solve_ivp(rates, (0, 4), [1, 0, 0, 1], method="DOP853", rtol=1e-12, atol=1e-13).y[
        :2, -1
    ]
    errors = []
    for steps in (80, 160):
        motion = run(system, 0.5, 4 / steps, steps, scheme=scheme, position=[1, 0], velocity=[0, 1])
        errors.append(np.abs(motion.position[-1] - exact).max())
    assert np.log2(errors[0] / errors[1]) == pytest.approx(ORDERS[scheme], abs=0.15)


def test_implicit_steps_become_coulombs_as_the_speed_vanishes():
    """v+ = soft(v, h L/m) in the limit; with v0 = 1e-14 it differs by the share (2/pi) v0/v.

    The sled's speed 2.001 is no multiple of h L/m = 0.005, where the law needs sqrt(v0) to rest.
    """
    motion = run(Blocks(1.0, 0.5), 1e-14, 0.01, 800, velocity=2.001)
    expected = np.maximum(2.001 - 0.005 * np.arange(801), 0)
    np.testing.assert_allclose(motion.velocity[:, 0], expected, atol=1e-12)
    assert motion.position[-1, 0] == pytest.approx(0.01 * expected[1:].sum(), rel=1e-12)


@settings(max_examples=30, deadline=None)
@given(
    v0=st.floats(1e-12, 1.0),
    step=st.floats(1e-3, 1e3),
    velocity=st.floats(-10, 10),
    load=st.floats(-0.9, 0.9),
)
def test_an_implicit_step_obeys_its_own_law(v0, step, velocity, load):
    """Momentum: m (v+ - v)/h = F - F_R(v+), to the rounding of the largest term."""
    motion = run(Blocks(2.0, 1.0, load=load), v0, step, 1, velocity=velocity)
    new = motion.velocity[1, 0]
    terms = [2 * new, -2 * velocity, -step * load, step * float(friction(new, 1.0, v0))]
    # one unit in the last place of v+ moves the impulse by up to (2/pi) h/v0 times it
    slack = 4 * np.spacing(abs(new)) * (2 + step / v0)
    assert abs(sum(terms)) <= 1e-14 * max(map(abs, terms)) + slack


@pytest.mark.parametrize("scheme", SCHEMES)
def test_units_change_no_digit(scheme):
    length, mass, time = 2.0**-30, 2.0**10, 2.0**-12
    force = mass * length / time**2
    plain = run(
        Blocks(1.0, 0.7, stiffness=3.0, belt=0.2, load=0.1),
        1e-2,
        0.003,
        300,
        scheme=scheme,
        position=0.3,
    )
    system = Blocks(
        mass,
        0.7 * force,
        stiffness=3.0 * mass / time**2,
        belt=0.2 * length / time,
        load=0.1 * force,
    )
    scaled = run(
        system, 1e-2 * length / time, 0.003 * time, 300, scheme=scheme, position=0.3 * length
    )
    np.testing.assert_array_equal(scaled.position / length, plain.position)
