"""Vibrations on an elastic contact: closed forms against Runge-Kutta."""

import math

import pytest
from scipy.integrate import solve_ivp

from comparisons.questions.experiments.vibrations import (
    contact_resonance,
    deepest_without_flight,
    forced_vibration,
    free_period,
    linear_amplitude,
    power_backbone,
)
from reference.closed_form import paraboloid, power_law

BALL = paraboloid(1.0, 1.0)
LOAD = 1 / 6  # d0 = 1/4, k = 1


def test_hertzs_contact_resonance():
    """k^3 = 6 E*^2 R F0 (Johnson 1985, section 4.2)."""
    frequency = contact_resonance(paraboloid(0.02, 1e11), 0.1, 50.0)
    assert (0.1 * frequency**2) ** 3 == pytest.approx(6 * 1e22 * 0.02 * 50, rel=1e-12)


@pytest.mark.parametrize("exponent", [1, 2, 4])
def test_the_backbone_is_that_of_lindstedt(exponent):
    """1 - (q-1)(2q+1)/48 (A/d0)^2; the next order is (A/d0)^4: the rest falls by 16 at A/2."""
    form = power_law(exponent, 0.5, 1.0)
    static = float(form.penetration(0.1))
    w0 = contact_resonance(form, 1.0, 0.1)
    rests = []
    for part in (0.2, 0.1):
        deepest = static * (1 + part)
        ratio = 2 * math.pi / free_period(form, 1.0, 0.1, deepest) / w0
        # the amplitude is half the distance of the turning points
        energy = float(form.energy(deepest)) - 0.1 * deepest
        low = turning(form, 0.1, energy, static)
        amplitude = 0.5 * (deepest - low) / static
        rests.append(abs(ratio - power_backbone(exponent, amplitude)))
    assert rests[0] / rests[1] == pytest.approx(16, rel=0.35)


def turning(form, load, energy, static):
    """Upper turning point, by bisection."""
    low, high = 0.0, static
    for _ in range(100):
        x = 0.5 * (low + high)
        low, high = (x, high) if float(form.energy(x)) - load * x > energy else (low, x)
    return x


def test_contact_is_lost_from_1_842_of_the_static_depth_on():
    """2.5^(2/3) (the depth of a mass let go at first touch); the period is continuous there."""
    limit = deepest_without_flight(BALL, LOAD)
    assert limit / 0.25 == pytest.approx(2.5 ** (2 / 3), rel=1e-13)
    below, above = (free_period(BALL, 1.0, LOAD, limit * (1 + e)) for e in (-1e-10, 1e-10))
    # beyond, the flight grows as the square root of the energy: 2 v/g
    assert above == pytest.approx(below, rel=1e-4)


@pytest.mark.parametrize("deepest", [0.3, 0.45, 0.6, 1.0])
def test_free_periods_with_and_without_flight(deepest):
    """By energy against Runge and Kutta: two periods later the mass is back where it was."""
    period = free_period(BALL, 1.0, LOAD, deepest)
    run = solve_ivp(
        lambda _, y: [y[1], LOAD - float(BALL.force(max(y[0], 0.0)))],
        *((0, 2 * period), [deepest, 0.0]),
        method="DOP853",
        rtol=1e-11,
        atol=1e-13,
        max_step=0.01 * period,
    )
    # a time error e shows in the velocity as F e: both back to 1e-7
    assert abs(run.y[1, -1]) < 1e-6
    assert run.y[0, -1] == pytest.approx(deepest, rel=1e-9)


def test_small_forced_vibrations_are_linear_and_larger_ones_soften():
    """P = 1e-3 F0 at resonance with 10 % of critical damping times two: P/(c w0), to (A/d0)^2.

    The mean of the vibration moves by -(A/d0)^2/12 d0: F is convex.
    """
    shift = []
    for share in (0.005, 0.01):
        motion = forced_vibration(
            BALL, 1.0, 0.1, LOAD, share * LOAD, 1.0, periods=40, tolerance=1e-8
        )
        linear = linear_amplitude(1.0, 1.0, 0.1, share * LOAD, 1.0)
        assert motion.amplitude == pytest.approx(linear, rel=(linear / 0.25) ** 2 + 1e-6)
        assert motion.flight == 0
        shift.append(1 - motion.mean / 0.25)
    assert shift[1] / shift[0] == pytest.approx(4, rel=0.02)
