"""Profiles, stick zones, ridges and section 19.7: the experiments against closed forms."""

from __future__ import annotations

import math

import pytest

from comparisons.errors import InputError
from comparisons.questions.experiments import EXPERIMENTS


def measure(name, value, effort="quick", **parameters):
    return EXPERIMENTS[name].measure(value, effort, **parameters)


@pytest.mark.parametrize(("exponent", "factor"), [(1, 4 / math.pi), (2, 1.0), (4, 0.75)])
def test_half_the_radius_stands_for_another_body(exponent, factor):
    """F of the profile 2 r^n is (4/pi) int sin^n: a cone 4/pi as steep, r^4 three quarters."""
    assert measure("equivalent-body", exponent).error == pytest.approx(factor - 1, abs=1e-12)
    assert abs(measure("equivalent-body", exponent, rule="transform").error) < 1e-12


def test_the_stick_radius_is_cattaneos():
    """At F_x = 7/8 mu F of a ball c = a/2, and u/u_slide = 1 - (1/8)^(2/3)."""
    measured = measure("stick-radius", 0.875)
    assert abs(measured.error) < 1e-12
    share = measured.details["displacement over that at which all slides"]
    assert share == pytest.approx(1 - 0.125 ** (2 / 3), rel=1e-12)


def test_a_ball_that_is_pushed_at_one_depth_is_cattaneos_in_both_models():
    """Half of the sliding displacement: F_x = (1 - (1/2)^(3/2)) mu F; the half-space 0.2 % off it.

    Slip off the axis, which the springs leave out, is what remains.
    """
    measured = measure("changing-load", 1.0)
    assert measured.details["stated"] == pytest.approx(1 - 0.5**1.5, abs=1e-6)
    assert abs(measured.error) < 2e-3


@pytest.mark.slow
def test_a_ball_that_is_pushed_in_deeper_as_it_is_pushed_aside_sticks():
    """Mindlin and Deresiewicz: dF_x/dF below mu throughout, so that nothing slips."""
    measured = measure("changing-load", 2.0)
    assert measured.details["share of the springs that stick"] == pytest.approx(1.0)
    assert measured.details["stated"] < 0.5


def test_the_line_of_ridges_is_pressed_flat_while_half_of_them_is_in_contact():
    """At half of p* the true share is 1/2 (Westergaard), that of the line its ceiling pi/4."""
    assert measure("ridges", 0.5).error == pytest.approx(math.pi / 2 - 1, rel=1e-9)
    assert measure("ridges", 0.5, quantity="mean_gap").error == -1.0


def test_the_procedure_keeps_what_its_rule_keeps():
    """Ring sums keep the mean square height; one radius per contact gives a stress everywhere."""
    height = "rms height of the lines over the maps'"
    literal, corrected = (
        measure("procedure", 0.1, quantity="undefined", variant=variant)
        for variant in ("literal", "corrected")
    )
    assert corrected.error == 0.0
    assert corrected.details[height] == pytest.approx(1.0, rel=1e-12)
    assert literal.error > 0.4
    assert literal.details[height] < 0.995


@pytest.mark.slow
def test_a_tension_with_a_tail_is_of_longer_range_than_a_constant_one():
    """Of the same strength and work: the rule is farther off, as on the grids of the tables."""
    constant, tail = (
        measure("adhesive-range", 1.0, law=law) for law in ("constant", "exponential")
    )
    assert tail.error < constant.error < 0
    assert tail.error == pytest.approx(1 / 1.1218 - 1, abs=1e-3 + tail.uncertainty)


def test_what_has_no_meaning_is_refused():
    for name, value, parameters in (
        ("equivalent-body", 0.0, {}),
        ("equivalent-body", 2.0, {"rule": "quarter"}),
        ("stick-radius", 1.0, {}),
        ("changing-load", 0.0, {}),
        ("ridges", 1.0, {}),
        ("ridges", 0.1, {"ridges": 0}),
        ("procedure", 0.1, {"variant": "mine"}),
        ("adhesive-range", 5.0, {"law": "exponential"}),
    ):
        with pytest.raises(InputError, match=name):
            measure(name, value, **parameters)
