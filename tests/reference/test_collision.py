"""Impacts on an elastic contact: closed forms, quadrature, the course in time."""

import math

import numpy as np
import pytest
from scipy.special import betaincinv

from reference.closed_form import cylinder, power_law, sphere
from reference.dynamics.collision import collide, collide_curve, course, power_law_collision
from reference.errors import ConvergenceError


def test_hertzs_impact_has_johnsons_numbers():
    """T = 2.94 x_m/v = 2.87 (m^2/(R E*^2 v))^(1/5) (Johnson 1985, (11.24)), as printed."""
    collision = power_law_collision(2, 0.5 / 0.02, 1e11, 0.1, 2.0)
    assert collision.duration * 2.0 / collision.penetration == pytest.approx(2.94, abs=0.005)
    johnson = 2.87 * (0.1**2 / (0.02 * 1e22 * 2.0)) ** 0.2
    assert collision.duration == pytest.approx(johnson, rel=0.002)


@pytest.mark.parametrize("exponent", [1, 1.5, 2, 3, 4, 20])
def test_quadrature_and_closed_form_of_power_laws_agree(exponent):
    """To the tolerance of the quadrature, 1e-11."""
    exact = power_law_collision(exponent, 0.5, 1.0, 2.0, 1e-3)
    rebound = collide(power_law(exponent, 0.5, 1.0), 2.0, 1e-3)
    assert rebound.duration == pytest.approx(exact.duration, rel=1e-11)
    assert rebound.force == pytest.approx(exact.force, rel=1e-12)


def test_an_impact_on_a_computed_curve_knows_its_error():
    """Twelve points of the sphere's curve: the bar covers the error and shrinks with the points."""
    form = sphere(1.0, 1.0)
    exact = collide(form, 1.0, 0.1)
    bars = []
    for points in (8, 16, 32):
        d = np.geomspace(0.02, 1.3, points) * exact.penetration
        result = collide_curve(d, form.force(d), 1.0, 0.1)
        assert abs(result.duration / exact.duration - 1) <= result.bar
        bars.append(result.bar)
    assert bars[2] < bars[0] / 4
    with pytest.raises(ValueError, match="before it stops"):
        collide_curve(d, form.force(d), 1.0, 1.0)


def test_a_sphere_can_be_hit_too_hard():
    """Beyond the depth that its theory allows the impact is refused, not extrapolated."""
    with pytest.raises(ConvergenceError, match="does not stop the mass"):
        collide(sphere(1.0, 1.0), 1.0, 1e3)


@pytest.mark.parametrize("exponent", [1, 2, 4])
def test_the_course_of_an_impact_is_deresiewiczs(exponent):
    """x/x_m = u solves I(u^p; 1/p, 1/2) = 2 t/T, the incomplete beta function; then free flight."""
    exact = power_law_collision(exponent, 0.5, 1e11, 0.03, 0.2)
    times = np.linspace(0, 2, 41)[1:] * exact.duration
    x, v = course(power_law(exponent, 0.5, 1e11), 0.03, 0.2, times)
    inside = times <= exact.duration
    early = np.minimum(times[inside], exact.duration - times[inside]) / (exact.duration / 2)
    p = 2 + 1 / exponent
    expected = exact.penetration * betaincinv(1 / p, 0.5, early) ** (1 / p)
    np.testing.assert_allclose(x[inside], expected, atol=1e-8 * exact.penetration)
    flight = -0.2 * (times[~inside] - exact.duration)
    np.testing.assert_allclose(x[~inside], flight, rtol=1e-6, atol=1e-8 * exact.penetration)
    np.testing.assert_allclose(v[~inside], -0.2, rtol=1e-8)


def test_a_sudden_force_presses_a_punch_to_twice_its_depth():
    """With k = m = 1: x = f (1 - cos t); dropped to 0 at t = pi it flies off from x = 2 f."""
    punch = cylinder(0.5, 1.0)
    t = np.array([1.0, 2.0, math.pi])
    x, _ = course(punch, 1.0, 0.0, t, ([0.0], [0.3]))
    np.testing.assert_allclose(x, 0.3 * (1 - np.cos(t)), rtol=1e-8)
    history = ([0.0, math.pi, math.pi + 1e-9], [0.3, 0.3, 0.0])
    _, v = course(punch, 1.0, 0.0, [10.0], history)
    assert v[0] == pytest.approx(-0.6, rel=1e-6)
    with pytest.raises(ValueError, match="moves the mass"):
        course(punch, 1.0, 0.0, [1.0])
