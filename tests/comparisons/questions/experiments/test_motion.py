"""Masses that vibrate, strike and rub: what the experiments measure, against closed forms."""

from __future__ import annotations

import math

import pytest

from comparisons.errors import InputError
from comparisons.questions.experiments import EXPERIMENTS


def measure(name, value, effort="quick", **parameters):
    return EXPERIMENTS[name].measure(value, effort, **parameters)


def test_the_set_valued_law_converges_without_a_characteristic_speed():
    """Order near 2, friction being continuous at every event: at least 1.5 over a factor of 8."""
    coarse, fine = (measure("set-valued-steps", steps).error for steps in (100, 800))
    assert fine < coarse / 8**1.5
    assert measure("set-valued-steps", 100).details["law evaluations"] == 400


def test_the_set_valued_law_holds_a_block_where_the_regularised_one_creeps():
    for load in (0.1, 0.999):
        held = measure("set-valued-steps", load, along="load", quantity="rest", steps=50)
        assert held.error == 0.0


def test_the_amplitude_of_the_regularised_oscillator_tends_to_den_hartogs():
    """It falls with v0, and is Den Hartog's inside the bar where v0 is a ten-thousandth of V."""
    errors = [measure("regularised-amplitude", ratio).error for ratio in (10, 100)]
    assert errors[0] > errors[1] > 0
    smallest = measure("regularised-amplitude", 1e4)
    assert abs(smallest.error) < smallest.uncertainty


def test_a_small_vibration_softens_as_the_square_of_its_amplitude():
    """1 - (A/d0)^2/24 (Nayak 1972): 24 times the linear error is the square, to order A^2."""
    linear = measure("free-vibration", 1.1, model="linear").error
    assert 24 * linear == pytest.approx(0.1**2, rel=0.05)
    assert abs(measure("free-vibration", 1.1, model="second_order").error) < linear / 100


@pytest.mark.parametrize(("deepest", "state"), [(1.5, "stays in contact"), (2.5, "flies")])
def test_springs_have_the_frequency_of_the_energy_in_contact_and_in_flight(deepest, state):
    springs = measure("free-vibration", deepest)
    assert abs(springs.error) < springs.uncertainty < 1e-5
    assert springs.details["the ball"] == state


def test_a_weak_drive_at_resonance_is_linear_and_the_springs_know_it():
    """P/F0 over twice the damping, times 2/3 for d0 k = 1.5 F0: 1/150 of the static depth."""
    springs = measure("forced-vibration", 1e-3)
    assert abs(springs.error) < springs.uncertainty < 1e-3
    linear = measure("forced-vibration", 1e-3, model="linear")
    assert abs(linear.error) < 1e-6
    assert linear.details["amplitude over static depth"] == pytest.approx(1 / 150, rel=1e-6)


@pytest.mark.parametrize(("exponent", "number"), [(1.0, 2.80436), (2.0, 2.94328)])
def test_the_course_of_an_impact_is_deresiewiczs(exponent, number):
    """T v/x_m of cone and paraboloid; depths differ by less than the bar of the steps."""
    measured = measure("impact-in-time", exponent)
    assert measured.details["duration times v over depth"] == pytest.approx(number, abs=1e-5)
    assert measured.error < measured.uncertainty < 1e-4


@pytest.mark.parametrize("quantity", ["work", "friction"])
def test_the_corrected_time_loop_of_rubber_loses_no_energy_and_settles(quantity):
    """Fast and slow: the printed loop is 50 % off in work at a relaxation number of one."""
    for number in (0.1, 10.0):
        assert abs(measure("corrected-rubber", number, quantity=quantity).error) < 1e-7


def test_more_relaxation_times_represent_a_spectrum_better():
    """Half a one per decade misses it by a third, two are within 1 %."""
    errors = [measure("relaxation-series", count).error for count in (0.5, 1, 2)]
    assert errors[0] > 0.3 > errors[1] > 0.01 > errors[2]


def test_what_has_no_meaning_is_refused():
    for name, value, parameters in (
        ("set-valued-steps", 1, {}),
        ("set-valued-steps", 1.5, {"along": "load", "quantity": "rest"}),
        ("regularised-amplitude", 0.0, {}),
        ("regularised-amplitude", 10.0, {"ratio": 1.0}),
        ("free-vibration", 1.0, {}),
        ("forced-vibration", 0.1, {"model": "second_order"}),
        ("impact-in-time", -1.0, {}),
        ("corrected-rubber", 1.0, {"quantity": "start"}),
        ("relaxation-series", math.nan, {}),
    ):
        with pytest.raises(InputError, match=name):
            measure(name, value, **parameters)
