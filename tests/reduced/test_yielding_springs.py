"""Springs and rough lines that yield: both readings of the rule, Zunker & Kamrin's ball, limits."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from reduced.loads import Load, LoadPath
from reduced.plasticity import Yielding, YieldingSprings, ZunkerKamrin, first_yield, walk
from reduced.profiles.equivalents import cone, paraboloid
from reduced.rough.press import RoughLines, press

HARDNESS = 2.84e-3  # Y = 1e-3, E* = R = 1
YIELD = (np.pi * 1.6e-3 / 2) ** 2  # d_y of p0 = 1.6 Y
FORCE = 4 / 3 * YIELD**1.5


def ball(reading, deepest, springs=2000) -> YieldingSprings:
    """Return springs under a ball of R = 1."""
    return YieldingSprings(paraboloid(1.0), 1.0, HARDNESS, reading, reach=deepest, springs=springs)


@pytest.mark.parametrize("reading", ["stress", "elastic_root"])
@pytest.mark.parametrize("share", [2, 5, 10, 60])
def test_readings_carry_the_integral_of_their_caps(reading, share):
    cap, a = (np.pi * HARDNESS) ** 2 / 4 / YIELD, np.sqrt(share)  # lengths in d_y, sqrt(R d_y)
    b = np.sqrt(max(share - cap, 0.0))  # springs within it yield
    rim = 2 * (share * (a - b) - (a**3 - b**3) / 3)
    middle = {
        "stress": np.sqrt(cap) * (b * np.sqrt(a**2 - b**2) + share * np.arcsin(b / a)),
        "elastic_root": 2 * b * cap,
    }
    depth = share * YIELD
    force = ball(reading, depth).walk(LoadPath("penetration", depth)).force
    assert_allclose(force / FORCE, (rim + middle[reading]) / (4 / 3), rtol=1e-4)


def test_stress_reading_ends_at_a_uniform_pressure():
    deep = 1e5 * YIELD
    line = ball("stress", deep).walk(LoadPath("penetration", deep))
    # all but a rim yields: sigma = H everywhere is the pressure (pi/4) H
    assert_allclose(line.force, np.pi / 4 * HARDNESS * np.pi * deep, rtol=1e-3)


def test_elastic_root_is_hertz_up_to_the_cap_of_its_deepest_spring():
    cap = (np.pi * HARDNESS) ** 2 / 4  # delta_y = pi^2 H^2 R1/(2 E*^2), R1 = R/2
    line = ball("elastic_root", 2 * cap).walk(LoadPath("penetration", [cap, 2 * cap]))
    assert_allclose(line.force[0], 4 / 3 * cap**1.5, rtol=1e-3)
    assert line.residual_depth[0] == 0.0
    # one more cap deep, the middle has lost just that
    assert_allclose(line.residual_depth[1], cap, rtol=1e-3)
    assert line.force[1] < 0.99 * 4 / 3 * (2 * cap) ** 1.5


@pytest.mark.parametrize("reading", ["stress", "elastic_root"])
def test_unloading_is_elastic_and_reloading_returns(reading):
    top = 20 * YIELD
    line = ball(reading, top)
    up = line.walk(LoadPath("penetration", top))
    left = float(up.residual_depth[0])
    path = [top, 0.5 * (top + left), left * (1 + 1e-9), 0.5 * (top + left), top]
    cycle = line.walk(LoadPath("penetration", path))
    assert_allclose(cycle.force[3:], cycle.force[1::-1], rtol=1e-12)
    assert_allclose(cycle.residual_depth, left, rtol=1e-12)
    assert cycle.force[2] < 1e-6 * cycle.force[0]
    # one spring is last; of caps that are all the same the middle lets go at once
    last = 0.1 if reading == "stress" else 0.95
    assert cycle.contact_radius[2] < last * cycle.contact_radius[0]


def test_force_finds_the_penetration_that_carries_it():
    top = 20 * YIELD
    line = ball("stress", top)
    force = line.walk(LoadPath("penetration", [5 * YIELD, top])).force
    again = line.walk(LoadPath("force", [*force, 0.0]))
    assert_allclose(again.penetration[:2], [5 * YIELD, top], rtol=1e-9)
    assert_allclose(again.penetration[2], again.residual_depth[1], rtol=1e-12)


def test_first_yield_of_a_ball_is_that_of_its_pressure():
    assert_allclose(first_yield(paraboloid(1.0), 1.0, 1.6e-3), YIELD, rtol=1e-14)
    with pytest.raises(ValueError, match="curved"):
        first_yield(cone(0.1), 1.0, 1.6e-3)


def test_zunker_kamrin_is_hertz_first_and_continuous_where_it_yields():
    model = ZunkerKamrin(1.0, 1.0, 1e-3)
    before, after = (model.at(d, d) for d in model.yields_at * np.array([1 - 1e-9, 1 + 1e-9]))
    assert_allclose(before[:2], after[:2], rtol=1e-8)
    small = model.yields_at / 2
    assert_allclose(model.at(small, small)[0], 4 / 3 * small**1.5, rtol=1e-14)
    # errors of the sheet against finite elements: +35 % of 25.5, +18 % of 246.6
    for share, force in ((10, 34.4), (60, 291.0)):
        assert_allclose(model.at(share * YIELD, share * YIELD)[0] / FORCE, force, rtol=0.01)


def test_zunker_kamrin_unloads_to_what_remains():
    model = ZunkerKamrin(1.0, 1.0, 1e-3, sphere=True)
    top = 60 * YIELD
    line = model.walk(LoadPath("penetration", [top, 0.95 * top, 0.0, top]))
    assert_allclose(line.force[3], line.force[0], rtol=1e-14)
    assert line.force[2] == line.contact_radius[2] == 0.0
    under_force = model.walk(LoadPath("force", [line.force[0], line.force[1], 0.0]))
    assert_allclose(under_force.penetration[:2], line.penetration[:2], rtol=1e-9)
    assert_allclose(under_force.penetration[2], line.residual_depth[0], rtol=1e-9)


def test_a_sphere_goes_in_no_deeper_than_its_radius():
    ball = ZunkerKamrin(1.0, 1.0, 1e-3, sphere=True)
    assert ball.walk(LoadPath("penetration", 1.0)).force[0] > 0
    for depth in (1.5, 2.5):
        with pytest.raises(ValueError, match="deeper"):
            ball.walk(LoadPath("penetration", depth))
    # a uniform pressure of less than 2.75 Y on the whole disc carries less
    with pytest.raises(ValueError, match="as deep as its radius"):
        ball.walk(LoadPath("force", np.pi * 2.75e-3))
    # a paraboloid has no equator
    assert ZunkerKamrin(1.0, 1.0, 1e-3).walk(LoadPath("penetration", 2.5)).force[0] > 0


@pytest.mark.parametrize("reading", ["stress", "elastic_root", "none"])
def test_without_a_force_virgin_springs_are_just_touched(reading):
    line = ball(reading, YIELD, springs=10).walk(LoadPath("force", [0.0, FORCE]))
    assert line.penetration[0] == line.residual_depth[0] == 0.0
    assert line.penetration[1] > 0


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
