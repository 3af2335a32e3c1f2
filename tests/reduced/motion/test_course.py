"""A rigid mass on springs (Fig. 19.4): impacts by energy and in steps, stability, vibrations."""

import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.special import beta

from reduced.motion.course import SCHEMES, Mass, Push, Stepping, move
from reduced.motion.elastic_impact import SpringContact, impact_depth, strike
from reduced.profiles.equivalents import (
    cone,
    cylinder,
    paraboloid,
    power_law,
    rounded_punch,
    sphere,
)
from reduced.springs.line import Springs


def duration_number(exponent: float) -> float:
    """T v/x_m = 2 int_0^1 du/sqrt(1 - u^p), p = 2 + 1/n, as a beta function."""
    p = 2 + 1 / exponent
    return 2 * float(beta(1 / p, 0.5)) / p


def moved(contact, mass, step, steps, *push, **scheme):
    return move(contact, mass, Stepping(step, steps), *push, **scheme)


@pytest.mark.parametrize(
    ("profile", "exponent", "tolerance"),
    [
        # exact on cubics: the rest is rounding
        (paraboloid(1.0), 2.0, 1e-13),
        (cone(0.3), 1.0, 1e-13),
        (cylinder(0.5), math.inf, 1e-13),
        (power_law(3.0, 0.5), 3.0, 1e-13),
        # 40 springs on smooth curves, dx^4; on x^1.5 dx^2.5
        (power_law(4.0, 0.5), 4.0, 2e-8),
        (power_law(1.5, 0.5), 1.5, 3e-6),
    ],
)
def test_impacts_of_power_laws_last_as_the_closed_form_says(profile, exponent, tolerance):
    """At two velocities a factor of 3 apart; force and depth are those of the static curve."""
    result = strike(Springs(profile, 1.0), 2.0, [1e-3, 3e-3])
    number = result.duration * result.velocity / result.penetration
    np.testing.assert_allclose(number, duration_number(exponent), rtol=tolerance)
    # energy: F x_m/p = m v^2/2 for F ~ x^(p-1)
    p = 2 + 1 / exponent
    np.testing.assert_allclose(
        result.force * result.penetration / p, result.velocity**2, rtol=10 * tolerance
    )


@pytest.mark.parametrize("profile", [paraboloid(1.0), sphere(1.0), rounded_punch(0.1, 1.0)])
@pytest.mark.parametrize("scheme", ["verlet", "energy"])
def test_steps_in_time_reach_the_impact_by_energy(profile, scheme):
    """Second order in the step: the duration between 50 and 400 steps, fitted within 0.2."""
    exact = strike(Springs(profile, 1.0), 1.0, [0.02])
    contact = SpringContact(Springs(profile, 1.0), impact_depth(profile, 1.0, 2e-4))
    counts, errors = np.array([50, 100, 200, 400]), []
    for n in counts:
        motion = moved(
            contact, Mass(1.0, velocity=0.02), exact.duration[0] / (n - 0.37), n + 2, scheme=scheme
        )
        errors.append(abs(motion.release()[0] / exact.duration[0] - 1))
        # sampled at the steps: off by at most (w h)^2/8 of the force's crest, w T < 5
        assert motion.force.max() == pytest.approx(exact.force[0], rel=4 / n**2 * 5 + 3 / n**2)
    assert -np.polyfit(np.log(counts), np.log(errors), 1)[0] == pytest.approx(2, abs=0.2)


def test_a_fourth_order_step_keeps_its_order_inside_the_contact_only():
    """Yoshida's step on a linear spring: 4. Through first touch and release, well below.

    There F ~ x^1.5, and one of the three steps goes backwards out of the contact; where in a step
    the release lies is arbitrary, so that errors scatter about an order between 2 and 3.
    """
    counts = np.array([128, 256, 512, 1024])
    punch = SpringContact(Springs(cylinder(0.5), 1.0), 10.0)
    ball = SpringContact(Springs(paraboloid(1.0), 1.0), impact_depth(paraboloid(1.0), 1.0, 2e-4))
    exact = float(strike(Springs(paraboloid(1.0), 1.0), 1.0, [0.02]).duration[0])
    held, struck = [], []
    for n in counts:
        run = moved(punch, Mass(1.0, position=6.0), 10 / n, n, Push(load=5.0), scheme="yoshida")
        held.append(abs(run.position[-1] - 5 - math.cos(10)))
        run = moved(ball, Mass(1.0, velocity=0.02), exact / (n + 0.5), n + 3, scheme="yoshida")
        struck.append(abs(run.release()[0] / exact - 1))
    slopes = [-np.polyfit(np.log(counts), np.log(errors), 1)[0] for errors in (held, struck)]
    assert slopes[0] == pytest.approx(4, abs=0.1)
    assert 1.5 < slopes[1] < 3.5


@settings(max_examples=40, deadline=None)
@example(steps=15, mass=3.0, speed=0.0625)  # here Newton's last steps alternate by a rounding
@given(steps=st.integers(2, 300), mass=st.floats(0.1, 10), speed=st.floats(1e-4, 0.1))
def test_an_elastic_impact_gives_back_its_energy_whatever_the_step(steps, mass, speed):
    """Restitution 1 with the energy-conserving step, even with two steps per impact: to 1e-11."""
    exact = strike(Springs(paraboloid(1.0), 1.0), mass, [speed])
    contact = SpringContact(Springs(paraboloid(1.0), 1.0), 2 * exact.penetration[0])
    motion = moved(contact, Mass(mass, velocity=speed), exact.duration[0] / steps, 3 * steps + 3)
    assert motion.release()[1] == pytest.approx(-speed, rel=1e-11)


def test_verlet_is_stable_up_to_two_over_the_frequency():
    """A mass held on a punch, k = 1: h w = 1.99 stays, 2.01 leaves; implicit, 20 stays."""
    punch = SpringContact(Springs(cylinder(0.5), 1.0), 10.0)
    for step, scheme, stays in (
        (1.99, "verlet", True),
        (2.01, "verlet", False),
        (20.0, "energy", True),
    ):
        motion = moved(punch, Mass(1.0, position=5.001), step, 200, Push(load=5.0), scheme=scheme)
        assert (np.abs(motion.position - 5).max() < 0.05) == stays


@pytest.mark.parametrize("scheme", SCHEMES)
def test_a_ramp_of_force_moves_a_linear_spring_as_the_closed_form_says(scheme):
    """Mass at rest on a punch, k = m = 1, force t up to 4, then 4: x = t - sin t, then the swing.

    Second order: (0.005)^2 of the motion, and cubics between the records.
    """
    punch = SpringContact(Springs(cylinder(0.5), 1.0), 10.0)
    run = moved(
        punch, Mass(1.0), 0.005, 2000, Push(history=([0.0, 4.0], [0.0, 4.0])), scheme=scheme
    )
    early = np.linspace(0, 4, 33)
    x, v = run.at(early)
    np.testing.assert_allclose(x, early - np.sin(early), atol=1e-4)
    np.testing.assert_allclose(v, 1 - np.cos(early), atol=1e-4)
    late = np.linspace(4, 10, 33)
    start, speed = 4 - math.sin(4) - 4, 1 - math.cos(4)
    expected = 4 + start * np.cos(late - 4) + speed * np.sin(late - 4)
    np.testing.assert_allclose(run.at(late)[0], expected, atol=1e-4)
    with pytest.raises(ValueError, match="times must lie"):
        run.at(11.0)
