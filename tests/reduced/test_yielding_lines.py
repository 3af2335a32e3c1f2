"""Rough lines with capped springs: elastic limit, full yield, memory, what is refused."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from reduced.errors import ConvergenceError
from reduced.loads import Load, LoadPath
from reduced.plasticity import Yielding, YieldingSprings, walk
from reduced.profiles.equivalents import paraboloid
from reduced.rough.lines import RoughLines
from reduced.rough.press import press

POINTS = 512
_X = 2 * np.pi * np.arange(POINTS) / POINTS
ROUGH = RoughLines(
    [sum(k**-1.3 * np.cos(k * _X + k * k + row) for k in range(1, 17)) for row in (0.0, 1.0)], 1.0
)
READINGS = [
    ("stress", "one_radius"),
    ("stress", "own_curvature"),
    ("elastic_root", "own_curvature"),
]
SOFT = 0.005  # E* h'/H = 4


def led(springs: Yielding, *loads: float, control: str = "force", line: RoughLines = ROUGH):
    """Lead lines along a path."""
    return walk(line, springs, LoadPath(control, np.array(loads)))


@pytest.mark.parametrize(("reading", "rule"), [*READINGS, ("none", "one_radius")])
def test_lines_that_are_hard_enough_are_elastic_to_the_last_digit(reading, rule):
    hard = led(Yielding(1.0, 1e6, reading, rule), 1.0, 20.0)
    for step, force in enumerate((1.0, 20.0)):
        elastic = press(ROUGH, 1.0, Load("force", force))
        for name in ("penetration", "contact_area", "stiffness", "energy", "mean_gap"):
            assert_array_equal(getattr(hard.contact, name)[:, step], getattr(elastic, name)[:, 0])
    assert not hard.residual_depth.any()
    assert not hard.plastic_share.any()


@pytest.mark.parametrize("reading", ["stress", "elastic_root"])
def test_a_parabola_is_that_of_springs_below_a_ball(reading):
    x = np.arange(-1000, 1001) / 1000
    hardness, path = 0.2, np.array([0.3, 0.25])
    # the equivalent profile of a ball of radius 1
    line = RoughLines(-x * x, 1e-3, periodic=False)
    springs = Yielding(1.0, hardness, reading, "own_curvature")
    rough = led(springs, *path, control="penetration", line=line)
    ball = YieldingSprings(paraboloid(1.0), 1.0, hardness, reading, reach=0.3, springs=1000)
    straight = ball.walk(LoadPath("penetration", path))
    assert_allclose(rough.contact.force[0], straight.force, rtol=2e-3)
    assert_allclose(rough.residual_depth[0], straight.residual_depth, rtol=0.01)


def test_contacts_in_full_yield_have_a_mean_pressure():
    # each connected contact is a parabola of its length and depth: (pi/4) H on (pi/4) l^2
    x = np.arange(-500, 501) / 500
    line = RoughLines(-x * x, 1 / 500, periodic=False)
    answer = led(Yielding(1.0, 1e-4), 0.3, control="penetration", line=line).contact
    assert_allclose(answer.force / answer.contact_area, np.pi / 4 * 1e-4, rtol=0.01)


@pytest.mark.parametrize(("reading", "rule"), READINGS)
def test_unloading_is_elastic_and_reloading_finds_the_state_again(reading, rule):
    springs = Yielding(1.0, SOFT / 2, reading, rule)
    answer = led(springs, 1.0, 0.5, 0.0, 1.0)
    down, half, away, again = answer.contact.penetration.T
    assert (answer.plastic_share[:, 0] > 0.1).all()
    assert not answer.plastic_share[:, 1].any()
    assert (half < down).all()
    assert (away == answer.residual_depth[:, 2]).all()
    assert_allclose(again, down, rtol=1e-9)
    assert_allclose(answer.plastic_share[:, 3], answer.plastic_share[:, 0])
    left = answer.residual_depth
    assert_allclose(left, left[:, :1].repeat(4, axis=1), rtol=1e-9)
    # softer than elastic
    assert (down > press(ROUGH, 1.0, Load("force", 1.0)).penetration[:, 0]).all()


@pytest.mark.parametrize(("reading", "rule"), READINGS[1:])
def test_forces_and_penetrations_are_one_curve(reading, rule):
    springs = Yielding(1.0, SOFT, reading, rule)
    by_force = led(springs, 0.5, 2.0, line=ROUGH[0])
    by_depth = led(springs, *by_force.contact.penetration[0], control="penetration", line=ROUGH[0])
    assert_allclose(by_depth.contact.force[0], [0.5, 2.0], rtol=1e-9)


def test_what_cannot_be_is_refused():
    with pytest.raises(ConvergenceError, match="never carry"):
        led(Yielding(1.0, SOFT), 1e9)
    with pytest.raises(ValueError, match="nothing holds"):
        led(Yielding(1.0, SOFT), -1.0)
    with pytest.raises(ValueError, match="hardness") as caught:
        Yielding(1.0, -1.0, "elastic_root", "one_radius")
    assert "'stress' only" in str(caught.value)
