"""Load lists and units: the same float as the SI number, or a clear refusal."""

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from numpy._core._multiarray_umath import __cpu_dispatch__, __cpu_features__
from pydantic_core import PydanticCustomError

from comparisons.scene.fields import FORCE, LENGTH, NUMBER, PRESSURE, TIME, Dimension, to_si
from comparisons.scene.loading import RELATIVE_FORCE, Loading, read_range


def values(given_loads, dimension=LENGTH):
    return read_range(given_loads, dimension).values


def refusal(given_loads, dimension=LENGTH) -> str:
    with pytest.raises(PydanticCustomError) as caught:
        read_range(given_loads, dimension)
    return str(caught.value)


def test_numbers_lists_and_tables_of_values():
    assert values(2e-6) == (2e-6,)
    assert values("2 um") == (2e-6,)
    assert values(["1 um", 2e-6, "5 um"]) == (1e-6, 2e-6, 5e-6)
    assert values({"values": [1, 2]}) == (1.0, 2.0)
    assert values({"values": "3 mm"}) == (3e-3,)


def test_logarithmic_ranges_have_equal_ratios_and_both_ends():
    loads = values({"from": "1 um", "to": "1 mm", "steps": 4, "spacing": "log"})
    assert loads == pytest.approx((1e-6, 1e-5, 1e-4, 1e-3), rel=1e-14)
    assert (loads[0], loads[-1]) == (1e-6, 1e-3)


def test_logarithmic_ranges_have_the_same_digits_on_every_processor(python):
    """NumPy has vector loops that this processor runs and others lack: not a bit hangs on them."""
    script = (
        "from comparisons.scene.loading import read_range\n"
        "from comparisons.scene.fields import LENGTH\n"
        "for to in range(2, 40):\n"
        "    table = {'from': 1e-6, 'to': to * 1e-6, 'steps': 20, 'spacing': 'log'}\n"
        "    print(read_range(table, LENGTH, 'loads'))\n"
    )
    loops = [name for name in __cpu_dispatch__ if __cpu_features__.get(name)]
    printed = {
        python("-c", script, NPY_DISABLE_CPU_FEATURES=off).stdout for off in ("", " ".join(loops))
    }
    assert len(printed) == 1
    assert min(printed)


@given(
    first=st.floats(1e-9, 1.0),
    ratio=st.floats(1.1, 1e6),
    steps=st.integers(2, 30),
    spacing=st.sampled_from(["linear", "log"]),
    power=st.integers(-60, 60),
)
def test_ranges_scaled_by_a_power_of_two_have_the_same_digits(first, ratio, steps, spacing, power):
    """So that a scene in other units by powers of two is bit-identical all the way."""
    table = {"from": first, "to": first * ratio, "steps": steps, "spacing": spacing}
    scale = 2.0**power
    scaled = table | {"from": first * scale, "to": first * ratio * scale}
    assert [v * scale for v in values(table)] == list(values(scaled))


@given(first=st.floats(1e-9, 1.0), ratio=st.floats(1.1, 1e6), steps=st.integers(3, 30))
def test_linear_ranges_are_the_default_match_rational_arithmetic_and_have_both_ends(
    first, ratio, steps
):
    loads = values({"from": first, "to": first * ratio, "steps": steps})
    low, high = Fraction(first), Fraction(first * ratio)
    exact = [float(low + (high - low) * i / (steps - 1)) for i in range(steps)]
    np.testing.assert_allclose(loads, exact, rtol=1e-15 * steps)
    assert (loads[0], loads[-1]) == (first, first * ratio)


def test_relative_forces_are_plain_numbers():
    loads = read_range({"values": [0.01, "5 %"], "relative_to": RELATIVE_FORCE}, FORCE)
    assert loads.values == (0.01, 0.05)
    assert loads.relative_to == RELATIVE_FORCE
    assert values({"value": 0.01, "relative_to": RELATIVE_FORCE}, FORCE) == (0.01,)
    spaced = {"from": 1e-3, "to": 1e-1, "steps": 3, "spacing": "log", "relative_to": RELATIVE_FORCE}
    assert values(spaced, FORCE) == pytest.approx((1e-3, 1e-2, 1e-1), rel=1e-14)


@pytest.mark.parametrize(
    ("loads", "expected"),
    [
        ([], "at least one load, got an empty list"),
        ({"values": []}, "at least one load, got an empty list"),
        ([1, 1], "strictly increasing values, got [1.0, 1.0]"),
        ([2, 1], "strictly increasing"),
        ([0, 1], "positive finite values"),
        ([-1, 1], "positive finite values"),
        ([1, math.inf], "positive finite values"),
        ([1, math.nan], "positive finite values"),
        ([1, "2 N", True], "load 2: expected a unit of m, got one of N, got '2 N'; load 3: expec"),
        ([[1]], "load 1: expected a number in m"),
        ({}, "expected value, values, or from, to and steps; from, to, steps missing"),
        ({"from": 1}, "to, steps missing"),
        ({"from": 1, "to": 2, "steps": 1}, "(of one load give `value`), got 1"),
        ({"from": 1, "to": 2, "steps": True}, "steps: expected a whole number"),
        ({"from": 1, "to": 2, "steps": 2.0}, "steps: expected a whole number"),
        ({"from": 1, "to": 2, "steps": 10**6}, "steps: expected a whole number"),
        ({"from": 2, "to": 1, "steps": 3}, "expected 0 < from < to, got from = 2, to = 1"),
        ({"from": 0, "to": 1, "steps": 3}, "expected 0 < from < to"),
        ({"from": math.nan, "to": 1, "steps": 3}, "expected 0 < from < to"),
        ({"from": 1, "to": math.inf, "steps": 3}, "expected 0 < from < to, got from = 1, to = inf"),
        ({"from": 1, "to": 2, "steps": 3, "spacing": "cubic"}, "spacing: expected"),
        ({"from": 1, "to": 2, "steps": 3, "step": 1}, "step: unknown key"),
        ({"values": [1], "steps": 3}, "steps: unknown key"),
        ({"value": 1, "values": [1]}, "values: unknown key"),
        ({"value": [1, 2]}, "value: expected one load (of a list give `values`), got [1, 2]"),
        ({"values": [1], "relative_to": "A0"}, 'relative_to: expected "E* A0 h\'", of a force'),
        ({"values": [1], "relative_to": RELATIVE_FORCE}, "of a force"),  # these are lengths
        ([1.0] * 10_001, "expected at most 10000 loads, got 10001"),
    ],
)
def test_each_wrong_list_is_named(loads, expected):
    assert expected in refusal(loads)


def test_all_problems_of_a_range_come_at_once():
    message = refusal({"from": "1 N", "to": "x", "steps": 0, "spacing": "cubic", "colour": 1})
    for part in ("colour: unknown key", "from: expected", "to: expected", "steps: ", "spacing: "):
        assert part in message


@given(
    knots=st.lists(st.floats(-1e3, 1e3).filter(lambda x: abs(x) > 1e-3), min_size=1, max_size=6),
    substeps=st.integers(1, 9),
    power=st.integers(-60, 60),
)
def test_a_divided_path_goes_through_its_knots_to_the_last_digit(knots, substeps, power):
    """And in other units by a power of two it has the same digits all the way."""
    loading = Loading(force=1.0, tangential_force=knots, substeps=substeps)
    path = loading.along("tangential_force", start=0.0)
    assert len(path) == substeps * len(knots)
    assert path[substeps - 1 :: substeps].tolist() == knots
    scale = 2.0**power
    scaled = Loading(force=1.0, tangential_force=[scale * k for k in knots], substeps=substeps)
    assert (scaled.along("tangential_force", start=0.0) == scale * path).all()


def test_paths_go_up_and_down_and_times_begin_at_zero():
    down = read_range({"from": "1 N", "to": "-1 N", "steps": 3}, FORCE, "path")
    assert down.values == (1.0, 0.0, -1.0)
    assert read_range([0, 1], TIME, "times").values == (0.0, 1.0)
    for wrong, words in (([0, 0], "strictly increasing times"), ([-1, 0], "times from zero on")):
        with pytest.raises(PydanticCustomError, match=words):
            read_range(wrong, TIME, "times")
    with pytest.raises(PydanticCustomError, match="from > 0 for logarithmic spacing"):
        read_range({"from": 1, "to": -1, "steps": 3, "spacing": "log"}, FORCE, "path")


SURFACE_ENERGY = Dimension(mass=1, time=-2)
PREFIXES = {"f": -15, "p": -12, "n": -9, "u": -6, "m": -3, "c": -2, "d": -1, "h": 2, "k": 3}
PREFIXES |= {"M": 6, "G": 9, "T": 12}


@pytest.mark.parametrize(
    ("text", "dimension", "value"),
    [
        ("10 nm", LENGTH, 1e-8),
        ("3.3 um", LENGTH, 3.3e-6),
        ("3.3 \u00b5m", LENGTH, 3.3e-6),  # micro sign
        ("3.3 \u03bcm", LENGTH, 3.3e-6),  # Greek mu
        ("1mm", LENGTH, 1e-3),
        (" 7 pm ", LENGTH, 7e-12),
        ("1_000.5 m", LENGTH, 1000.5),
        (".5 m", LENGTH, 0.5),
        ("5. m", LENGTH, 5.0),
        ("-2e-3 m", LENGTH, -2e-3),
        ("210 GPa", PRESSURE, 210e9),
        ("1 N/m^2", PRESSURE, 1.0),
        ("1 N / mm^2", PRESSURE, 1e6),
        ("2 kg/m/s^2", PRESSURE, 2.0),
        ("1 J m^-3", PRESSURE, 1.0),
        ("3 kN", FORCE, 3000.0),
        ("3 kg*m/s2", FORCE, 3.0),
        ("20 mJ/m^2", SURFACE_ENERGY, 0.02),
        ("20 mN/m", SURFACE_ENERGY, 0.02),
        ("40 m^-2", Dimension(length=-2), 40.0),
        ("40 mm^-2", Dimension(length=-2), 40e6),
        ("40 1/m^2", Dimension(length=-2), 40.0),
        ("50 kHz", Dimension(time=-1), 5e4),
        ("5%", NUMBER, 0.05),
        ("5 %", NUMBER, 0.05),
        ("0.3", NUMBER, 0.3),
        ("1 um/mm", NUMBER, 1e-3),
        (3, LENGTH, 3.0),
        (0.1, LENGTH, 0.1),
    ],
)
def test_a_quantity_is_the_very_float_of_its_si_number(text, dimension, value):
    """Bit-identical: exponents are added in decimal, and only the result is rounded."""
    assert to_si(text, dimension) == value


@given(
    digits=st.integers(1, 10**60),
    point=st.integers(0, 60),
    prefix=st.sampled_from(sorted(PREFIXES)),
)
@example(digits=33, point=1, prefix="u")
# A hair below the middle of two floats: rounding first to 28 digits would go the wrong way.
@example(digits=100000000000000033306690738754696212708950042724609374, point=56, prefix="k")
def test_decimal_text_is_rounded_once(digits, point, prefix):
    """The exact rational value, rounded to the nearest float by Python's own division."""
    text = f"{digits}e-{point} {prefix}m"
    exact = Fraction(digits) * Fraction(10) ** (PREFIXES[prefix] - point)
    assert to_si(text, LENGTH) == float(exact)


@pytest.mark.parametrize(
    ("value", "dimension", "message"),
    [
        (True, LENGTH, "expected a number in m"),
        (None, LENGTH, "expected a number in m"),
        ([1], FORCE, 'expected a number in N or a text with a unit such as "5 N"'),
        ("", LENGTH, "expected a number in m"),
        ("mm", LENGTH, "expected a number in m"),
        ("1,5 mm", LENGTH, "is no unit"),
        ("nan m", LENGTH, "expected a number in m"),
        ("inf m", LENGTH, "expected a number in m"),
        ("1 m 2", LENGTH, "is no unit"),
        ("1 parsec", LENGTH, "'parsec' is no known unit"),
        ("1 M", LENGTH, "'M' is no known unit"),
        ("1 m^2", LENGTH, "expected a unit of m, got one of m^2"),
        ("1", LENGTH, "expected a unit of m, got none"),
        ("1 N", PRESSURE, "expected a unit of Pa, got one of N"),
        ("5 m", NUMBER, "expected a unit of a plain number, got one of m"),
        ("one", NUMBER, "expected a number"),
        ("1 mJ", SURFACE_ENERGY, "expected a unit of kg s^-2, got one of kg m^2 s^-2"),
        ("1e500 m", LENGTH, "within the range of floats"),
        ("1e99999999999999999999 m", LENGTH, "expected a number"),
        (10**400, LENGTH, "within the range of floats"),
        ("1" * 101, LENGTH, "expected a number in m"),
        ("1 m^999", LENGTH, "is no unit"),
        ("1 //m", LENGTH, "expected a unit of m, got one of m^-1"),
    ],
)
def test_what_is_no_such_quantity_is_refused_in_words(value, dimension, message):
    with pytest.raises(ValueError, match="expected") as caught:
        to_si(value, dimension)
    assert message in str(caught.value)


@pytest.mark.slow
@given(st.text(max_size=30))
def test_no_text_makes_the_reader_fail_otherwise(text):
    """Whatever stands in a file: a float, or a ValueError that says what was expected."""
    try:
        outcome = to_si(text, LENGTH)
    except ValueError as error:
        outcome = str(error)
    assert isinstance(outcome, float) or "expected" in outcome
