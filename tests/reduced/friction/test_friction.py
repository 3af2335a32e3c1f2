"""Springs with friction: shear, slip and memory of a path; rolling in closed form."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.integrate import quad
from scipy.optimize import brentq

from reduced.friction.roll import roll, roll_rough
from reduced.friction.slide import (
    Friction,
    follow,
    slide,
    slide_lines,
    stiffness_ratio,
    tangential_modulus,
)
from reduced.loads import Load, LoadPath
from reduced.profiles.equivalents import cone, paraboloid
from reduced.rough.press import RoughLines
from reduced.springs.line import Springs

E, G, MU = 1.3, 0.9, 0.4

paths = st.lists(st.floats(-1, 1), min_size=1, max_size=12).map(np.array)


def pulled(body, **loads):
    """Slide springs, or rough lines, under a normal load, along a tangential path."""
    (control, load), (along, path) = loads.items()
    loads = Load(control, load), LoadPath(along, path)
    if isinstance(body, Springs):
        return slide(body, Friction(G, MU), *loads)
    return slide_lines(body, E, Friction(G, MU), *loads)


def rough_line(seed: int, points: int = 48) -> np.ndarray:
    """Return a rough line; its knots are exact for both laws, so no smoothness is needed."""
    return np.random.default_rng(seed).standard_normal(points)


def test_ratio_of_stiffness_is_mindlins():
    """(19.18): 4G/(2-nu) over E* = 2G/(1-nu)."""
    for nu in (-0.5, 0.0, 0.3, 0.5):
        expected = tangential_modulus(2.0, nu) / (2 * 2.0 / (1 - nu))
        assert stiffness_ratio(nu) == pytest.approx(expected, rel=1e-15)


@pytest.mark.parametrize("share", [0.05, 0.5, 0.95])
def test_cattaneo_mindlin_to_rounding(share):
    """The cubic through the springs is the parabola itself: rounding, at any offset."""
    d, force = 0.9, 4 / 3 * E * 0.9**1.5
    sliding = pulled(
        Springs(paraboloid(1.0), E, per_radius=11, offset=0.3),
        force=force,
        tangential_force=[share * MU * force],
    )
    left = 1 - share
    u = 3 * MU * force / (4 * np.sqrt(d) * G) * (1 - left ** (2 / 3))
    assert sliding.tangential_displacement[0] == pytest.approx(u, rel=1e-12)
    assert sliding.stick_length[0] == pytest.approx(2 * np.sqrt(d) * left ** (1 / 3), rel=1e-12)
    assert sliding.stiffness[0] == pytest.approx(G * sliding.stick_length[0], rel=1e-14)


@pytest.mark.parametrize("periodic", [True, False])
@given(path=paths, depth=st.floats(0.05, 6.0), seed=st.integers(0, 50))
@settings(max_examples=25, deadline=None)
def test_memory_of_branches_is_what_single_springs_do(periodic, path, depth, seed):
    """Masing branches and springs followed one by one are two programs for one law: rounding.

    The bound is relative to mu F and to the length of the line.
    """
    line = rough_line(seed)
    u = path * 2 * MU * E * depth / G
    fast = pulled(
        RoughLines(line, 0.5, periodic=periodic), penetration=depth, tangential_displacement=u
    )
    way = np.full(u.size + 1, depth), np.concatenate([[0.0], u])
    slow = follow(line.max() - line, 0.5, E, Friction(G, MU), *way, periodic=periodic)
    assert fast.force[0] == pytest.approx(slow.force[-1], rel=1e-11)
    bound = 1e-11 * MU * fast.force[0]
    assert np.abs(fast.tangential_force[0] - slow.tangential_force[1:]).max() < bound


@given(path=paths, seed=st.integers(0, 50))
@settings(max_examples=25, deadline=None)
def test_force_control_inverts_displacement_control(path, seed):
    """Displacements found from forces give back the forces (below sliding, where they are unique).

    Rounding of a displacement near the first touch of a spring is magnified: 1e-8 of mu F.
    """
    line = rough_line(seed)
    normal = 3.0
    given_forces = 0.99 * path * MU * normal
    there = pulled(RoughLines(line, 0.5), force=normal, tangential_force=given_forces)
    back = pulled(
        RoughLines(line, 0.5),
        force=normal,
        tangential_displacement=there.tangential_displacement[0],
    )
    assert np.abs(back.tangential_force[0] - given_forces).max() < 1e-8 * MU * normal
    assert back.dissipation[0, -1] == pytest.approx(
        there.dissipation[0, -1], rel=1e-6, abs=1e-8 * MU * MU * normal
    )


def test_loss_of_a_cycle_is_mindlins():
    """Mindlin & Deresiewicz 1953 (Johnson 1985, (7.52)) for the paraboloid, force amplitude T.

    dW = (18/5) (mu F)^2/(a G*) {1 - (1-s)^(5/3) - (5/6) s [1 + (1-s)^(2/3)]}, s = T/(mu F).
    """
    share, normal = 0.6, 2.0
    path = share * MU * normal * np.array([1, -1, 1])
    sliding = pulled(Springs(paraboloid(1.0), E), force=normal, tangential_force=path)
    a = (0.75 * normal / E) ** (1 / 3)
    left = 1 - share
    bracket = 1 - left ** (5 / 3) - 5 / 6 * share * (1 + left ** (2 / 3))
    johnson = 18 / 5 * (MU * normal) ** 2 / (a * G) * bracket
    assert sliding.dissipation[2] - sliding.dissipation[0] == pytest.approx(johnson, rel=1e-9)


@pytest.mark.slow
@given(seed=st.integers(0, 1000))
@settings(max_examples=5, deadline=None)
def test_work_is_stored_or_lost_on_any_path(seed):
    """Energy balance of normal and tangential work, both forces, on a path of both displacements.

    Trapezoids, 100 to a stretch, leave 1e-3; what is lost can only grow.
    """
    rng = np.random.default_rng(seed)
    line = rough_line(seed, 12)
    depth = np.interp(np.arange(0, 8, 1 / 100), np.arange(9), rng.uniform(0, 2, 9))
    shift = np.interp(np.arange(0, 8, 1 / 100), np.arange(9), rng.uniform(-2, 2, 9))
    shift -= shift[0]
    result = follow(line.max() - line, 0.5, E, Friction(G, MU), depth, shift)

    def work(force: np.ndarray, way: np.ndarray) -> np.ndarray:
        return np.cumsum((force[1:] + force[:-1]) / 2 * np.diff(way))

    stored = result.elastic_energy
    put_in = work(result.force, depth) + work(result.tangential_force, shift)
    lost = put_in - (stored[1:] - stored[0])
    assert np.diff(lost).min() > -1e-3 * stored.max()
    assert np.abs(result.tangential_force).max() <= MU * result.force.max() * (1 + 1e-12)


def test_any_step_is_exact_on_a_straight_path():
    """Sixteen steps for one change nothing: events inside a step are found, not stepped over."""
    rng = np.random.default_rng(5)
    depth, shift = rng.uniform(0.1, 3, 60), rng.uniform(-2, 2, 60)
    fine = np.arange(0, 59 + 1e-9, 1 / 16)
    line = rough_line(5)
    coarse, dense = (
        follow(
            line.max() - line,
            0.5,
            E,
            Friction(G, MU),
            np.interp(at, np.arange(60), depth),
            np.interp(at, np.arange(60), shift),
        )
        for at in (np.arange(60), fine)
    )
    largest = np.abs(coarse.tangential_force).max()
    assert np.abs(dense.tangential_force[::16] - coarse.tangential_force).max() < 1e-11 * largest
    assert coarse.knots.max() < 6 * line.size


def test_pressing_and_shifting_in_proportion_sticks_or_slides():
    """u/d below mu E*/G*: every spring sticks and F_x = G* u/(E* d) F; above, F_x = mu F."""
    gap = paraboloid(1.0).height((np.arange(-60, 60) + 0.5) / 50)
    for ratio in (0.5, 2.0):
        depth = np.linspace(0.1, 1.0, 5)
        shift = ratio * MU * E / G * depth
        result = follow(gap, 0.02, E, Friction(G, MU), depth, shift)
        expected = min(ratio, 1) * MU * result.force
        assert result.tangential_force == pytest.approx(expected, rel=1e-12)


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
    # a force far below what the rounding of a penetration of 3 can tell
    light = roll_rough(x**2 + 3, 0.3 * rough, 0.01, 1.0, FRICTION, 1e-30, 0.4)
    assert_allclose(light.force, 1e-30, rtol=1e-12)
