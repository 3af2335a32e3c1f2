"""Units at the door: the same float as the SI number, or a clear refusal."""

from fractions import Fraction

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from comparisons.scene.units import FORCE, LENGTH, NUMBER, PRESSURE, Dimension, to_si

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
        ("1", LENGTH, "expected a unit of m, got one of a plain number"),
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
