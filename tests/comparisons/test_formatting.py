"""Numbers as the report prints them; expected texts follow the rules of the report's design."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from comparisons import formatting as f

T = "\u202f"


# How each function writes a value: three digits and a true minus; errors in per cent or ppm;
# durations from digits to minutes and hours; counts in groups of three.
WRITTEN = {
    f.number: [
        (0, "0"),
        (-0.0, "0"),
        (math.nan, "–"),
        (math.inf, "–"),
        (None, "–"),
        ("text", "–"),
        (1, "1.00"),
        (999.96, f"1{T}000"),
        (123456, f"123{T}000"),
        (0.1 + 0.2, "0.300"),
        (-2.5e-3, "−0.00250"),
        (1e-300, "1.00×10⁻³⁰⁰"),
        (-6.626e34, "−6.63×10³⁴"),
    ],
    f.relative: [
        (0.01, f"1.0{T}%"),
        (1e-5, f"10{T}ppm"),
        (-0.000123, f"−0.012{T}%"),
        (1e-4, f"0.010{T}%"),
        (0.99999e-4, f"0.010{T}%"),
        (2.0, f"200{T}%"),
        (1e-8, f"0.010{T}ppm"),
        (1e-16, "1.0×10⁻¹⁶"),
        (0.0, f"0{T}%"),
        (math.nan, "–"),
    ],
    f.duration: [
        (4.2e-8, f"42{T}ns"),
        (60, f"60{T}s"),
        (119.9, f"2{T}min{T}0{T}s"),
        (3600, f"1{T}h{T}0{T}min"),
        (None, "–"),
    ],
    f.count: [(2097152, f"2{T}097{T}152"), (math.nan, "–")],
}


@pytest.mark.parametrize(
    ("write", "value", "text"), [(w, *row) for w, rows in WRITTEN.items() for row in rows]
)
def test_numbers_errors_durations_and_counts_are_written_for_readers(write, value, text):
    assert write(value) == text


@pytest.mark.parametrize(
    ("values", "unit", "scale"),
    [
        ([1e-6, 4e-6], "m", (1e6, "µm")),
        ([9.999e-7], "m", (1e6, "µm")),  # three digits print 1.00 µm, not 1000 nm
        ([2e-12], "m2", (1e12, "µm²")),
        ([5e-20], "m2", (1e18, "nm²")),
        ([1.9e-14], "m2", (1e12, "µm²")),  # 0.019 µm² rather than 19 000 nm²
        ([3.1e-7], "m2", (1e6, "mm²")),  # 0.31 mm² rather than 310 000 µm²
        ([1e-40], "m", (1e15, "fm")),
        ([3e30], "N", (1e-12, "TN")),
        ([2e6], "N/m", (1e-6, "MN/m")),
        ([90.0], "s", (1.0, "s")),
        ([5000.0], "s", (1.0, "s")),  # nobody writes kiloseconds
        ([7.0], "", (1.0, "")),
        ([], "N", (1.0, "N")),
    ],
)
def test_one_prefix_serves_all_values_of_a_plot(values, unit, scale):
    result = f.prefix_for(values, unit)
    assert result.factor == pytest.approx(scale[0], rel=1e-12)
    assert result.unit == scale[1]


def test_an_error_and_its_bar_share_unit_and_decimal_place():
    assert f.plus_minus(0.0052, 0.0003) == f"+0.520 ± 0.030{T}%"
    assert f.plus_minus(0.0002, 3e-6) == f"+0.0200 ± 0.0003{T}%"
    assert f.plus_minus(4.0, 0.028) == f"+400 ± 3{T}%"
    assert f.plus_minus(0.0996, 0.0013) == f"+9.96 ± 0.13{T}%"
    assert f.plus_minus(0.0005, 0.002) == f"+0.050 ± 0.20{T}%"  # at least two digits
    assert f.plus_minus(1e-6, 0.002) == f"0 ± 0.20{T}%"  # far below its bar
    assert f.plus_minus(2e-9, 1e-9) == "< 1\u202fppm"
    assert f.plus_minus(0.0052, 0.0) == f"+0.52{T}%"  # exact truth: no bar
    assert f.plus_minus(0.0052, 1e-12) == f"+0.52{T}%"  # a bar below the last digit
    assert f.plus_minus(2e-16, 1e-12) == "round-off"
    assert f.plus_minus(0.0052, math.nan).endswith("± ?")
    assert f.plus_minus(None, 0.1) == "–"


@given(st.floats(min_value=-1e300, max_value=1e300, allow_subnormal=False))
def test_printed_numbers_are_right_to_half_a_unit_in_the_third_digit(value):
    """Read the text back: rounding to three digits moves a number by at most half of 1e-2."""
    text = f.number(value).replace(T, "").replace("−", "-")
    mantissa, _, power = text.partition("×10")
    plain = power.translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789"))
    read = float(mantissa) * 10.0 ** int(plain or 0) if power else float(mantissa)
    assert read == pytest.approx(value, rel=5.1e-3)
