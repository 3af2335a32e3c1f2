"""Contacts of a rough line one by one, and the local stress rule on them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reduced.loads import Load
from reduced.rough.press import RoughLines, press
from reduced.rough.regions import line_stress, regions

EDGES = ["sub_cell", "nodal"]
LINES = st.lists(st.integers(-40, 40), min_size=2, max_size=60).filter(lambda v: len(set(v)) > 1)


@pytest.mark.parametrize("edges", EDGES)
@pytest.mark.parametrize("periodic", [True, False])
@settings(max_examples=30, deadline=None)
@given(values=LINES, level=st.integers(0, 90))
def test_regions_add_up_to_what_press_counts(edges, periodic, values, level):
    """Number, sum and sum of squares, from two implementations that share no code.

    Levels lie halfway between possible heights, where touching decides nothing.
    """
    line = np.array(values, dtype=float)
    lines = RoughLines(line, 0.25, periodic)
    contacts = regions(lines, level + 0.5, edges=edges)
    c = press(lines, 1.0, Load("penetration", level + 0.5), edges=edges)
    assert contacts.lengths.size == c.contact_count[0, 0]
    assert contacts.lengths.sum() == pytest.approx(c.contact_length[0, 0], rel=1e-12)
    assert np.pi / 4 * np.sum(contacts.lengths**2) == pytest.approx(c.contact_area[0, 0], rel=1e-12)
    assert np.all(contacts.deflection > 0)
    assert np.unique(contacts.region).size == contacts.lengths.size


@pytest.mark.parametrize("rule", ["own_curvature", "one_radius"])
def test_the_rule_on_a_sampled_parabola_is_hertz(rule):
    """Pressure (2 E* a/(pi R)) sqrt(1 - x^2/a^2) on g = x^2/R, off the grid at the edges.

    Second differences of a parabola are exact but for rounding, which loses h/(dx^2 h'') = 1e4.
    One radius takes length and depth of the sampled contact: of second order in dx, 1e-4 here.
    """
    spacing, modulus, radius, a = 0.01, 3.0, 2.0, 0.5037
    x = spacing * np.arange(-100, 101)
    line = RoughLines(-(x**2) / radius, spacing, periodic=False)
    stress = line_stress(line, modulus, a**2 / radius, rule=rule)
    at = x[stress.regions.points]
    hertz = 2 * modulus * a / (np.pi * radius) * np.sqrt(1 - (at / a) ** 2)
    assert stress.undefined_share == 0
    tolerance = 1e-10 if rule == "own_curvature" else 1e-4
    np.testing.assert_allclose(stress.pressure, hertz, rtol=tolerance)


def test_hollow_and_straight_points_have_no_value():
    """A tent is straight but for its tip; a crown of two tips is hollow between them."""
    tent = np.array([0.0, 1.0, 2.0, 3.0, 2.0, 1.0, 0.0, 0.0])
    stress = line_stress(RoughLines(tent, 1.0), 1.0, 2.5)
    assert stress.regions.points.tolist() == [1, 2, 3, 4, 5]
    assert stress.valid.tolist() == [False, False, True, False, False]
    assert stress.undefined_share == pytest.approx(0.8)
    assert line_stress(RoughLines(tent, 1.0), 1.0, 2.5, rule="one_radius").undefined_share == 0
    crown = np.array([0.0, 3.0, 2.0, 3.0, 0.0, 0.0])
    assert line_stress(RoughLines(crown, 1.0), 1.0, 1.5).valid.tolist() == [True, False, True]


def test_no_contact_has_no_undefined_points():
    stress = line_stress(RoughLines(np.array([0.0, 1.0, 0.0]), 1.0), 1.0, -0.5)
    assert (stress.pressure.size, stress.undefined_share, stress.regions.lengths.size) == (
        0,
        0.0,
        0,
    )


@given(st.integers(-60, 60), st.integers(-60, 60))
@settings(max_examples=15, deadline=None)
def test_units_by_powers_of_two_are_bit_identical(height, stiff):
    line = np.random.default_rng(1).normal(size=64)
    unit, modulus = 2.0**height, 2.0**stiff
    for rule in ("own_curvature", "one_radius"):
        one = line_stress(RoughLines(line, 1.0), 1.0, 1.5, rule=rule)
        two = line_stress(RoughLines(line * unit, unit), modulus, 1.5 * unit, rule=rule)
        np.testing.assert_array_equal(two.pressure, one.pressure * modulus)
        np.testing.assert_array_equal(two.regions.lengths, one.regions.lengths * unit)
