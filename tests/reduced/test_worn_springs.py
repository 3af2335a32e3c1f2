"""Springs whose profile wears: exact limits, volume balance, what (19.37) makes of it."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from reduced.errors import ConvergenceError
from reduced.loads import Load
from reduced.profiles.equivalents import cylinder, paraboloid, sphere
from reduced.rough.press import RoughLines
from reduced.wear import Oscillation, Rings, RoundBody, WearingLine, wear
from reference.closed_form.worn import WornPunch


def last(*args, **kwargs):
    return list(wear(*args, **kwargs))[-1]


def test_rings_carry_the_force_of_the_springs_to_round_off():
    rings = Rings(0.02, 70)
    deflection = 1 - rings.middles**2
    springs = 2 * rings.spacing * np.maximum(deflection, 0).sum()
    assert_allclose(rings.pressures(deflection) @ rings.areas, springs, rtol=1e-13)


def test_rings_and_lines_are_inverse_for_a_parabola():
    rings = Rings(0.02, 50)
    # the mean of x^2 over a spring is dx^2/12 more than in its middle
    assert_allclose(rings.lowering @ (rings.radii**2 / 2), rings.middles**2, atol=2e-4)
    assert_allclose(rings.raising @ rings.middles**2, rings.radii**2 / 2, atol=2e-3)


def test_wear_reaches_no_spring_further_in():
    """What sticks stays unworn: a ring changes its own spring and those outside."""
    rings = Rings(1.0, 12)
    worn = np.zeros(12)
    worn[6] = 1.0
    assert not (rings.lowering @ worn)[:6].any()
    assert (rings.lowering @ worn)[6] > 0


def test_stiffness_against_wear_is_positive():
    """Its eigenvalues are real, positive and below 0.63 E*/dx: steps of dx/(2 k E*) are stable."""
    rings = Rings(1.0, 40)
    change = np.array([rings.lowering @ row for row in np.eye(40)])
    answer = 2 * rings.spacing * change @ change.T / np.sqrt(np.outer(rings.areas, rings.areas))
    values = np.linalg.eigvalsh(answer)
    assert 0 < values.min() < values.max() < 0.63


@pytest.mark.parametrize("distance", [0.1, 0.5, 2.0])
@pytest.mark.parametrize("control", ["force", "penetration"])
def test_worn_punch_against_galin_and_goryacheva(control, distance):
    """The profile is flat up to its edge; 30 springs leave 2e-3, the singular edge of the start."""
    punch, body = WornPunch(1.0, 1.0, 1.0), RoundBody(cylinder(1.0), 2.0, 30)
    exact = punch.under_force if control == "force" else punch.at_penetration
    depth, force, volume = exact(0.5, distance)
    state = last(body, 1.0, Load(control, 0.5), 1.0, np.array([distance]))
    assert_allclose([state.penetration, state.force], [depth, force], rtol=2e-3)
    assert_allclose(state.volume, volume, rtol=2e-3)


def test_volume_is_archards_to_round_off():
    body = RoundBody(paraboloid(1.0), 2.5, 30)
    for distance in (0.3, 1.0):
        state = last(body, 2.0, Load("force", 0.7), 0.4, np.array([distance]))
        assert_allclose(state.volume, 0.4 * 0.7 * distance, rtol=1e-12)
        assert_allclose(state.worn @ body.rings.areas, state.volume, rtol=1e-12)


def test_wear_in_one_distance_or_in_two_is_the_same():
    """Distances are only where one looks: steps differ, and with them the second order."""
    body = RoundBody(paraboloid(1.0), 2.0, 24)
    once = last(body, 1.0, Load("force", 1.0), 1.0, np.array([0.5]))
    twice = last(body, 1.0, Load("force", 1.0), 1.0, np.array([0.17, 0.5]))
    assert_allclose(twice.penetration, once.penetration, rtol=1e-3)


def test_where_all_slips_nothing_is_left():
    body = RoundBody(paraboloid(1.0), 1.5, 15)
    state = last(body, 1.0, Load("penetration", 1.0), 1.0, np.array([10.0]), Oscillation(1.0, 3.0))
    assert state.stick_length == 0
    assert state.force < 1e-3


def test_slip_that_no_spring_resolves_wears_nothing():
    body = RoundBody(paraboloid(1.0), 1.5, 30)
    tiny, small = (
        last(body, 1.0, Load("penetration", 1.0), 1.0, np.array([1.0]), Oscillation(u, u)).volume
        for u in (1e-3, 1e-1)
    )
    assert tiny == 0 < small < 1e-3


def test_line_that_wears_by_the_local_stress_ends_straight():
    """(19.37) asks for a curvature; after some wear there is none left."""
    x = np.arange(-40, 41) * 0.05
    line = RoughLines(-(x**2), 0.05, periodic=False)
    worn = WearingLine(line, "own_curvature")
    with pytest.raises(ConvergenceError, match="no real value"):
        last(worn, 1.0, Load("force", 1.0), 1.0, np.array([3.0]))


def test_first_wear_by_one_radius_is_hertzs():
    """(19.37) is Hertz's pressure below a parabola: volume and depth of a first short distance."""
    x = np.arange(-60, 61) * 0.02
    line = WearingLine(RoughLines(-(x**2), 0.02, periodic=False), "one_radius")
    state = last(line, 1.0, Load("penetration", 1.0), 1.0, np.array([1e-3]))
    assert_allclose(state.volume, 4 / 3 * 1e-3, rtol=3e-3)
    assert_allclose(state.worn.max(), 2 / np.pi * 1e-3, rtol=3e-3)


def test_sphere_wears_to_its_equator():
    body = RoundBody(sphere(1.0), 1.2, 12)
    state = last(body, 1.0, Load("force", 0.2), 1.0, np.array([5.0]))
    assert_allclose(state.volume, 1.0, rtol=1e-12)
    assert state.contact.contact_length[0, 0] <= 2
