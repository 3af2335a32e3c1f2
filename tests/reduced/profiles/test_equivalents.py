"""Equivalent profiles against textbook closed forms and against each other."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq
from scipy.special import ellipe, ellipkm1

from reduced.errors import ConvergenceError
from reduced.profiles.equivalents import (
    cone,
    cylinder,
    ellipsoid,
    half_radius,
    paraboloid,
    power_law,
    pyramid,
    rounded_punch,
    sphere,
    tabulated,
)
from reduced.profiles.transform import from_function, inverse_transform

X = np.array([1e-3, 0.1, 0.5, 1.001, 1.3, 1.9])
ROUNDING = 1e-14  # a few operations on doubles
QUADRATURE = 1e-12  # what from_function promises

SMOOTH = [paraboloid(2.0), sphere(2.0), cone(0.3), power_law(0.7, 0.2), power_law(1.5, 0.3)]
SMOOTH += [power_law(4.0, 0.3), rounded_punch(1.0, 3.0), rounded_punch(0.3, 3.0)]


def test_a_pyramid_is_the_cone_of_its_sectional_areas():
    # a square of side 2 h/s at height h
    line = pyramid(0.4)
    cone_of = cone(0.4 * np.sqrt(np.pi / 4))
    np.testing.assert_allclose(line.height(X), cone_of.height(X), rtol=ROUNDING)
    np.testing.assert_allclose(
        pyramid(0.3, 1000).height(X), cone(0.3).height(X), rtol=2e-6
    )  # to the square of the sides' angle


def test_the_gaussian_radius_errs_as_the_exact_ellipse_says():
    """Radii 2 : 1: the force at equal penetration is 1.0 % low (theory notes, checked by hand).

    F = 4/3 E* sqrt(R) d^(3/2) F_2^(-3/2): of the ellipse F_2(e), with the ratio of the axes that
    gives these radii (Johnson 1985, eqs. 4.26, 4.28, 4.30).
    """

    def radii(squared):  # of curvature, as their ratio R'/R'', at the eccentricity
        k, e = ellipkm1(1 - squared), ellipe(squared)
        return (e / (1 - squared) - k) / (k - e)

    squared = brentq(lambda m: radii(m) - 2, 1e-6, 0.9)
    b, k, e = np.sqrt(1 - squared), ellipkm1(1 - squared), ellipe(squared)
    # with a = 1, p0 = E* = 1: d = b K, 1/(2 R') = b (K - E)/m, F = 2/3 pi b
    long = squared / (2 * b * (k - e))
    line = ellipsoid(long, long / 2)
    by_springs = 4 / 3 * np.sqrt(line.length) * (b * k) ** 1.5
    assert by_springs / (2 / 3 * np.pi * b) - 1 == pytest.approx(-0.00990, abs=2e-5)


@pytest.mark.parametrize("profile", SMOOTH, ids=lambda p: f"{p.name}-{p.length:.3g}")
def test_transform_by_quadrature_equals_closed_forms(profile):
    """G by quadrature of f' alone; g' with f'' or with differences of f' (1e-10 by their step)."""
    section = profile.section
    edge = min(section.edge, 1.95)
    shared = {"length": 1.0, "breakpoints": section.breakpoints, "edge": edge}
    exact = from_function(section.slope, f_second=section.curvature, **shared)
    differences = from_function(section.slope, **shared)
    np.testing.assert_allclose(exact.height(X), profile.height(X), rtol=QUADRATURE, atol=0)
    np.testing.assert_allclose(exact.slope(X), profile.slope(X), rtol=2 * QUADRATURE, atol=0)
    np.testing.assert_allclose(differences.slope(X), profile.slope(X), rtol=1e-10, atol=0)
    tip = np.zeros(1)
    if profile.name != "power_law":  # the tip of x^0.7 is infinitely steep
        np.testing.assert_allclose(exact.slope(tip), profile.slope(tip), rtol=ROUNDING)
    np.testing.assert_array_equal(exact.height(tip), 0.0)
    np.testing.assert_allclose(differences.curvature(X), profile.curvature(X), rtol=1e-8, atol=1e-9)


R_CUBED = np.array([0.0, 0.3, 0.7, 1.2, 2.0])
TABLES = [tabulated(R_CUBED, R_CUBED**3, kind) for kind in ("pchip", "linear")]


@pytest.mark.parametrize("profile", [*SMOOTH, *TABLES], ids=lambda p: f"{p.name}-{p.length:.3g}")
def test_inverse_transform_returns_the_section(profile):
    """f(r) = (2/pi) int_0^r g/sqrt(r^2 - x^2) dx: back to the body, 1e-12, tables and kinks too."""
    r = np.array([0.0, 1e-3, 0.1, 0.29, 0.5, 1.001, 1.5, 1.9])
    result, exact = inverse_transform(profile, r), profile.section.height(r)
    scale = np.maximum(exact, 1e-12 * exact.max())
    assert np.all(np.abs(result - exact) <= QUADRATURE * np.maximum(scale, result))


def test_inverse_transform_of_a_punch_is_flat_and_ends():
    f = inverse_transform(cylinder(1.0), np.array([0.0, 0.5, 1.0, 1.0001]))
    np.testing.assert_array_equal(f, [0.0, 0.0, 0.0, np.inf])
    with pytest.raises(ValueError, match="r must"):
        inverse_transform(cylinder(1.0), np.array([-0.1]))


@pytest.mark.parametrize("profile", [*SMOOTH, cylinder(1.0)], ids=lambda p: p.name)
@given(st.floats(1e-12, 1.0))
def test_contact_radius_inverts_the_height(profile, fraction):
    """g(a(d)) = d as far as one unit in the last place of a can reach it."""
    if profile.name == "cylinder":
        assert profile.contact_radius(fraction) == 1.0
        return
    d = float(profile.height(np.array(1.8))) * fraction
    a = profile.contact_radius(d)
    # two units in the last place of a, and of g itself
    error = 4e-16 * (float(profile.slope(a)) * a + d)
    assert abs(float(profile.height(a)) - d) <= 4 * error


def test_half_radius_rule_is_exact_for_parabola_and_punch_only():
    """The chapter's rule: cone 4/pi too deep, the power law by 2/kappa_n, as it is printed."""
    np.testing.assert_allclose(half_radius(paraboloid(2.0).section).height(X), X**2 / 2, rtol=1e-15)
    assert float(half_radius(cylinder(1.0).section).contact_radius(0.1)) == 1.0
    ratio = half_radius(cone(0.3).section).height(X) / cone(0.3).height(X)
    np.testing.assert_allclose(ratio, 4 / np.pi, rtol=ROUNDING)
    ratio = half_radius(power_law(4, 0.3).section).height(X) / power_law(4, 0.3).height(X)
    np.testing.assert_allclose(ratio, 2 / (8 / 3), rtol=ROUNDING)


@pytest.mark.parametrize("interpolation", ["linear", "pchip"])
def test_table_equals_quadrature_of_its_own_section(interpolation):
    """Segment-wise transform against the general quadrature of the same f', between the nodes."""
    r = np.array([0.0, 0.3, 0.7, 1.2, 2.0])
    table = tabulated(r, r**3, interpolation)
    section = table.section
    general = from_function(
        section.slope, 1.0, section.breakpoints, f_second=section.curvature, edge=2.0
    )
    x = np.array([0.1, 0.31, 0.8, 1.5, 1.99])
    np.testing.assert_allclose(table.height(x), general.height(x), rtol=QUADRATURE)
    np.testing.assert_allclose(table.slope(x), general.slope(x), rtol=QUADRATURE)
    step = 1e-5
    difference = (table.slope(x + step) - table.slope(x - step)) / (2 * step)
    # Central differences: step^2 g''''/6, up to 1e-6 just behind the node at 0.3.
    np.testing.assert_allclose(table.curvature(x), difference, rtol=1e-5)


@pytest.mark.parametrize(("interpolation", "rate"), [("linear", 1.4), ("pchip", 1.9)])
def test_tables_converge_to_the_shape(interpolation, rate):
    """Order 3/2 by linear segments, at least 2 by pchip.

    The slope of linear segments is a staircase, and the kernel an inverse square root at r = x.
    """
    errors, sizes = [], np.array([10, 20, 40, 80])
    x = np.random.default_rng(3).uniform(0.3, 1.9, 200)
    for n in sizes:
        r = np.linspace(0, 2, n + 1)
        error = tabulated(r, r**3, interpolation).height(x) / (3 * np.pi / 4 * x**3) - 1
        errors.append(np.sqrt(np.mean(error**2)))
    assert -np.polyfit(np.log(sizes), np.log(errors), 1)[0] > rate


def test_unmarked_kinks_are_noticed():
    """A step of f' that is no breakpoint: the quadrature says so instead of returning 3 digits."""

    def flank(r):
        return np.where(r > 0.5, 1.0, 0.2)

    with pytest.raises(ConvergenceError, match="breakpoints") as caught:
        from_function(flank, 1.0).height(np.array([1.0]))
    assert len(caught.value.history) > 1
    marked = from_function(flank, 1.0, (0.5,)).height(np.array([1.0]))
    assert marked[0] == pytest.approx(0.2 * np.pi / 2 + 0.8 * np.arccos(0.5), rel=QUADRATURE)
