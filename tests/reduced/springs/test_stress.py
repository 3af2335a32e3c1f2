"""Surface pressure: closed forms, the total force, and where the local rule holds."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from reduced.profiles.equivalents import (
    cone,
    cylinder,
    paraboloid,
    power_law,
    rounded_punch,
    sphere,
    tabulated,
)
from reduced.springs.stress import abel, local_rule, one_radius_rule

S = np.array([1e-6, 0.05, 0.3, 0.7, 0.9, 0.999])  # r/a
TABLE = tabulated(np.linspace(0, 2, 15), np.linspace(0, 2, 15) ** 2 / 4)
STRAIGHT = tabulated(np.linspace(0, 2, 9), np.linspace(0, 2, 9) ** 2 / 4, "linear")


def test_hertz_cone_and_punch_pressures():
    """P = 2 E*/(pi R) sqrt(a^2 - r^2); (E* tan t/2) arccosh(a/r); E* d/(pi sqrt(b^2 - r^2))."""
    modulus, d = 3.0, 0.2
    a = np.sqrt(2.0 * d)
    expected = 2 * modulus / (np.pi * 2.0) * np.sqrt(a**2 - (S * a) ** 2)
    np.testing.assert_allclose(abel(paraboloid(2.0), modulus, d, S * a), expected, rtol=1e-12)
    a = d / (np.pi / 2 * 0.3)
    expected = modulus * 0.3 / 2 * np.arccosh(1 / S)
    np.testing.assert_allclose(abel(cone(0.3), modulus, d, S * a), expected, rtol=1e-12)
    expected = modulus * d / (np.pi * 0.7 * np.sqrt(1 - S**2))
    np.testing.assert_allclose(abel(cylinder(0.7), modulus, d, S * 0.7), expected, rtol=1e-12)


def test_cone_pressure_keeps_its_digits_at_the_edge():
    """Edge of p = (E* tan t/2) arcosh(a/r) -> (E* tan t/2) sqrt(2 (a/r - 1)) for r -> a."""
    a = 1.0 / (np.pi / 2 * 0.3)
    r = a * (1 - 2.0 ** -np.arange(26.0, 48.0, 4.0))
    near = (a - r) / r
    expected = 0.15 * np.sqrt(2 * near) * (1 - near / 12)  # the next term is near^2
    np.testing.assert_allclose(abel(cone(0.3), 1.0, 1.0, r), expected, rtol=1e-14)


@pytest.mark.parametrize(
    "profile", [paraboloid(2.0), cone(0.3), cylinder(1.0)], ids=lambda p: p.name
)
def test_quadrature_equals_the_closed_integrals(profile):
    """The general path, taken by profiles without a closed form, against the closed forms."""
    a = float(profile.contact_radius(0.4))
    closed = abel(profile, 1.0, 0.4, S * a)
    general = abel(replace(profile, abel_integral=None), 1.0, 0.4, S * a)
    np.testing.assert_allclose(general, closed, rtol=1e-11)


def test_elliptic_kernel_of_a_table_equals_quadrature_of_its_slope():
    """Two orders of integration, two code paths; radii off the nodes, where g' is singular."""
    r = np.array([0.011, 0.2, 0.41, 0.66])
    closed = abel(TABLE, 1.0, 0.3, r)
    general = abel(replace(TABLE, abel_integral=None), 1.0, 0.3, r)
    np.testing.assert_allclose(closed, general, rtol=1e-10)


PROFILES = [paraboloid(2.0), sphere(2.0), cone(0.3), power_law(1.5, 0.3), power_law(5, 0.3)]
PROFILES += [rounded_punch(0.3, 3.0), cylinder(1.0), TABLE, STRAIGHT]


@pytest.mark.slow
@pytest.mark.parametrize("profile", PROFILES, ids=lambda p: p.name)
@pytest.mark.parametrize("penetration", [0.1, 3.0])
def test_pressure_carries_the_force_of_the_springs(profile, penetration):
    """2 pi int p r dr = 2 E* int (d - g) dx to 1e-10; tables press beyond their edge at d = 3."""
    a = float(profile.contact_radius(penetration))
    marks = np.array([0.0, *(b for b in profile.breakpoints if b < a), a])
    pressure_force = spring_force = 0.0
    for lower, upper in pairwise(marks):
        t, weight = nodes_towards(both_ends=upper < a)
        begin, end = np.arcsin(lower / a), np.arcsin(upper / a)
        angle = begin + (end - begin) * t
        # nodes may round onto a kink, where the pressure of straight segments is unbounded
        r = np.clip(a * np.sin(angle), lower * (1 + 1e-15), upper * (1 - 1e-15))
        ring = 2 * np.pi * a * np.cos(angle) * r * (end - begin)
        pressure_force += np.sum(weight * ring * abel(profile, 1.0, penetration, r))
        x = lower + (upper - lower) * t
        spring_force += 2 * (upper - lower) * np.sum(weight * (penetration - profile.height(x)))
    assert pressure_force == pytest.approx(spring_force, rel=1e-10)


def nodes_towards(both_ends):
    """Gauss nodes on (0, 1) that cluster at kinks, where pressures have logarithms.

    At the left, and at the right unless it is the contact edge, where p cos(angle) is smooth.
    """
    s, w = np.polynomial.legendre.leggauss(160)
    s, w = (s + 1) / 2, w / 2
    if not both_ends:
        return s**6, 6 * s**5 * w
    sums = s**6 + (1 - s) ** 6
    return s**6 / sums, w * 6 * (s * (1 - s)) ** 5 / sums**2


def test_one_radius_rule_is_exact_for_the_paraboloid_and_the_mean_of_the_punch():
    """(19.37) with R1 = a^2/(2 d): Hertz to 1e-12; the punch 2 E* d/(pi a), so its force too."""
    profile, d = paraboloid(2.0), 0.3
    r = S * float(profile.contact_radius(d))
    hertz = one_radius_rule(profile, 5.0, d, r)
    np.testing.assert_allclose(hertz, abel(profile, 5.0, d, r), rtol=1e-12)
    punch = one_radius_rule(cylinder(0.5), 5.0, d, np.array([0.0, 0.2, 0.49, 0.5, 3.0]))
    np.testing.assert_allclose(punch[:3] * np.pi * 0.25, 2 * 5.0 * 0.5 * d, rtol=1e-13)
    np.testing.assert_array_equal(punch[3:], 0.0)


def test_one_radius_rule_has_a_value_where_the_own_curvature_has_none():
    """Cone: R1 = a^2/(2 d), sigma = (E*/pi) (2 d/a) sqrt(1 - r/a), finite at the tip."""
    d = 0.3
    a = d / (np.pi / 2 * 0.3)
    r = np.array([0.0, 0.5, 0.9]) * a
    expected = 2 * d / (np.pi * a) * np.sqrt(1 - r / a)
    np.testing.assert_allclose(one_radius_rule(cone(0.3), 1.0, d, r), expected, rtol=1e-13)
    assert not local_rule(cone(0.3), 1.0, d, r)[1].any()


def test_local_rule_is_exact_for_the_paraboloid():
    """(19.34)-(19.37): the rule was made for the parabola; 1e-12 whatever the spacing."""
    profile, d = paraboloid(2.0), 0.3
    r = S * float(profile.contact_radius(d))
    pressure, valid = local_rule(profile, 5.0, d, r, spacing=0.017)
    np.testing.assert_allclose(pressure, abel(profile, 5.0, d, r), rtol=1e-12)
    assert valid.all()


def test_local_rule_says_where_it_is_undefined():
    """Straight flanks and flats have no curvature: pressure 0, not valid; outside is valid."""
    pressure, valid = local_rule(cone(0.3), 1.0, 0.3, np.array([0.0, 0.1, 5.0]))
    np.testing.assert_array_equal(pressure, 0.0)
    np.testing.assert_array_equal(valid, [False, False, True])
    pressure, valid = local_rule(rounded_punch(0.3, 1.0), 1.0, 0.1, np.array([0.1, 0.35]))
    np.testing.assert_array_equal(valid, [False, True])
    assert pressure[1] > 0


def test_round_tips_have_a_finite_pressure():
    for profile in (paraboloid(2.0), sphere(2.0), rounded_punch(0.3, 3.0), power_law(1.5, 0.3)):
        assert np.isfinite(abel(profile, 1.0, 0.1, np.zeros(1))[0])
