"""Springs that enter unstretched: the parabola's closed form, any profile, rough rollers."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import quad
from scipy.optimize import brentq

from reduced.friction.roll import roll, roll_rough
from reduced.friction.slide import Friction, tangential_modulus
from reduced.loads import Load
from reduced.profiles.equivalents import cone, paraboloid
from reduced.springs.line import Springs

FRICTION = Friction(0.8, 0.5)
FULL = 2 * 0.5 / 0.8  # 2 mu a E*/(G* R) at a = R = E* = 1


def parabola(per_radius=40):
    return Springs(paraboloid(1.0), 1.0, per_radius=per_radius)


@pytest.mark.parametrize("share", [1e-9, 0.1, 0.5, 0.9, 1.0, 5.0])
def test_parabola_is_one_minus_a_cube(share):
    line = roll(parabola(), FRICTION, Load("penetration", 1.0), share * FULL)
    exact = 1 - (1 - min(share, 1.0)) ** 3
    exact = exact if share > 1e-6 else 3 * share
    # of second order in the springs
    assert_allclose(line.tangential_force / (0.5 * line.force), exact, rtol=1e-4)


def test_parabola_sticks_from_the_leading_edge():
    line = roll(parabola(400), FRICTION, Load("penetration", 1.0), np.array([0.25, 0.5]) * FULL)
    assert_allclose(line.stick_length, 2 * (1 - np.array([0.25, 0.5])), rtol=1e-3)


@pytest.mark.parametrize(("nu", "error"), [(0.0, -0.41), (0.25, -0.446), (0.5, -0.487)])
def test_slope_of_the_line_falls_short_of_kalkers(nu, error):
    """C11 = 4/(2 - nu) where the half-space has 3.40, 4.12 and 5.20."""
    friction = Friction(tangential_modulus(0.5, nu), 1.0)
    line = roll(parabola(), friction, Load("penetration", 1.0), 1e-9)
    slope = line.tangential_force[0] / 1e-9
    assert_allclose(slope, 4 / (2 - nu), rtol=1e-6)
    assert_allclose(slope / {0.0: 3.40, 0.25: 4.12, 0.5: 5.20}[nu] - 1, error, atol=0.005)


def test_any_creep_has_the_direction_of_its_force():
    line = roll(parabola(), FRICTION, Load("force", 1.0), [0.3, -0.4], [0.4, 0.3])
    straight = roll(parabola(), FRICTION, Load("force", 1.0), 0.5)
    assert_allclose(line.tangential_force, straight.tangential_force * [0.6, -0.8], rtol=1e-12)
    assert_allclose(line.lateral_force, straight.tangential_force * [0.8, 0.6], rtol=1e-12)


def test_cone_against_quadrature():
    """With w = d - (pi/2) |x| t: the stick ends where the stretch meets it."""
    line = roll(Springs(cone(1.0), 1.0, per_radius=200), FRICTION, Load("penetration", 1.0), 0.3)
    a, rate = 2 / np.pi, 0.8 * 0.3 / 0.5
    bound = lambda x: 1 - np.pi / 2 * abs(x)  # noqa: E731
    end = brentq(lambda x: bound(x) - rate * (a - x), -a, 0)
    exact = 0.5 * (quad(bound, -a, end)[0] + rate * (a - end) ** 2 / 2)
    assert_allclose(line.tangential_force, exact, rtol=1e-3)


def test_zero_creep_is_no_force():
    line = roll(parabola(), FRICTION, Load("force", 1.0), 0.0)
    assert (line.tangential_force, line.lateral_force, line.stick_length) == (
        0,
        0,
        2 * line.contact_radius,
    )


def test_rough_roller_approaches_the_smooth_one():
    x = (np.arange(-150, 151)) / 100
    rng = np.random.default_rng(2)
    rough = rng.standard_normal(2000)
    line = roll(parabola(), FRICTION, Load("force", 4 / 3), 0.4)
    tractions = []
    for height in (1e-4, 0.3):
        rolled = roll_rough(x**2, height * rough, 0.01, 1.0, FRICTION, 4 / 3, 0.4)
        assert_allclose(rolled.force, 4 / 3, rtol=1e-9)
        tractions.append(rolled.tangential_force)
    assert_allclose(tractions[0], line.tangential_force, rtol=0.02)
    assert abs(tractions[1] / line.tangential_force[0] - 1) > 0.01
    assert rolled.scatter > 0
