"""How far two solutions are apart, and the one rule that judges it."""

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from comparisons.judging.fields import grid_pressure_at, pressure_difference
from comparisons.judging.metrics import at_equal
from comparisons.judging.verdicts import judged


@given(
    exponent=st.floats(0.2, 4),
    factor=st.floats(1e-6, 1e6),
    steps=st.lists(st.floats(1.001, 10), min_size=1, max_size=12),
    share=st.lists(st.floats(0, 1), min_size=1, max_size=8),
)
def test_power_laws_are_interpolated_exactly(exponent, factor, steps, share):
    """A straight line in logarithms stays straight: round-off alone, whatever the load steps."""
    depths = 1e-9 * np.cumprod([1.0, *steps])
    x = depths[0] * (depths[-1] / depths[0]) ** np.array(share)
    y = at_equal(x, depths, factor * depths**exponent)
    np.testing.assert_allclose(y, factor * x**exponent, rtol=1e-9)


def test_the_curve_goes_on_with_its_end_slope_for_half_an_interval_and_no_further():
    """The last interval of log d is log 2: the curve ends at a factor of sqrt 2 beyond its ends."""
    d = np.array([1.0, 2.0, 4.0])
    x = np.array([0.70, 0.72, 1.0, 4.0, 5.6, 5.7, -1.0, 0.0, np.nan, np.inf])
    y = at_equal(x, d, d**1.5)
    np.testing.assert_allclose(y[1:5], x[1:5] ** 1.5, rtol=1e-13)
    assert np.isnan(y[[0, 5, 6, 7, 8, 9]]).all()


def test_a_falling_load_is_read_the_other_way_round():
    """A mean gap closes as the force grows: the curve force(mean gap) is the same either way."""
    gap = np.array([8.0, 4.0, 2.0])
    np.testing.assert_allclose(at_equal(np.array([3.0]), gap, gap**-2.0), 1 / 9, rtol=1e-13)


def test_a_last_digit_beyond_the_end_is_still_the_end():
    d = np.array([1.0, 2.0, 4.0])
    x = np.array([np.nextafter(1.0, 0), np.nextafter(4.0, 5)])
    np.testing.assert_allclose(at_equal(x, d, d), [1, 4], rtol=1e-14)


def test_failed_steps_are_left_out_and_too_few_leave_nothing():
    d = np.array([1.0, 2.0, np.nan, 8.0])
    y = at_equal(np.array([4.0]), d, np.array([1.0, 4.0, 16.0, 64.0]))
    assert y[0] == pytest.approx(16.0, rel=1e-14)
    assert np.isnan(at_equal(np.array([1.0]), np.array([1.0]), np.array([1.0])))[0]
    # A curve that turns back has no single value, nor one whose loads differ by a last digit.
    for x in (np.array([1.0, 3.0, 2.0]), np.array([1.5e-6, np.nextafter(1.5e-6, 1), 3.0])):
        assert np.isnan(at_equal(np.array([2.0]), x, x))[0]


def test_between_load_steps_a_smooth_curve_is_met_to_third_order():
    """A sphere's curve is no power law: errors fall at least as h^2.5 in the step of log d."""
    exact = lambda d: d**1.5 * (1 + d)  # noqa: E731
    errors = []
    for n in (5, 9, 17):
        d = np.geomspace(0.01, 1, n)
        x = np.sqrt(d[:-1] * d[1:])
        errors.append(np.abs(at_equal(x, d, exact(d)) / exact(x) - 1).max())
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    assert rates.min() > 2.5


def test_pressure_difference_is_weighted_by_area_and_relative():
    """Twice the points with half the area each say the same."""
    truth = np.array([1.0, 2.0, 3.0])
    weight = np.array([1.0, 2.0, 0.5])
    keep = np.ones(3, dtype=bool)
    assert pressure_difference(1.1 * truth, weight, truth, keep) == pytest.approx(0.1)
    p = truth + np.array([1.0, 0.0, -1.0])
    expected = math.sqrt((1 * 1 + 0 + 0.5 * 1) / (1 * 1 + 2 * 4 + 0.5 * 9))
    assert pressure_difference(p, weight, truth, keep) == pytest.approx(expected)
    twice = [np.repeat(array, 2) for array in (p, weight / 2, truth, keep)]
    assert pressure_difference(*twice) == pytest.approx(expected)


def test_pressure_is_compared_inside_the_contact_and_outside_the_ring_only():
    truth = np.array([1.0, 0.0, np.inf, 1.0])
    p = np.array([1.2, 5.0, 7.0, 9.0])
    keep = np.array([True, True, True, False])
    assert pressure_difference(p, np.ones(4), truth, keep) == pytest.approx(0.2)
    assert math.isnan(pressure_difference(p, np.ones(4), np.zeros(4), keep))


def grid(n, function):
    centres = (np.arange(n) + 0.5) / n
    x, y = np.meshgrid(centres, centres, indexing="ij")
    return {
        "pressure_x": x.ravel(),
        "pressure_y": y.ravel(),
        "pressure": function(x, y).ravel(),
        "pressure_shape": np.array([n, n]),
    }


def test_a_finer_reference_is_averaged_over_the_coarse_cells():
    """The mean of a bilinear function over a cell is its value at the centre."""
    fine, coarse = grid(24, lambda x, y: 1 + x * y), grid(8, lambda x, y: 1 + x * y)
    pressure = grid_pressure_at(fine, coarse["pressure_x"], coarse["pressure_y"], (8, 8))
    np.testing.assert_allclose(pressure, coarse["pressure"], rtol=1e-13)
    # and it is a mean, not a look-up: a checkerboard of the fine cells averages to its mean
    fine["pressure"] = (np.indices((24, 24)).sum(axis=0) % 2).ravel().astype(float)
    pressure = grid_pressure_at(fine, coarse["pressure_x"], coarse["pressure_y"], (8, 8))
    np.testing.assert_allclose(pressure, 0.5, atol=1 / 18 + 1e-12)
    assert np.mean(pressure) == pytest.approx(0.5)


def test_elsewhere_a_reference_is_interpolated():
    fine = grid(24, lambda x, y: 1 + 2 * x - y)
    x, y = np.array([0.31, 0.7]), np.array([0.77, 0.2])
    pressure = grid_pressure_at(fine, x, y, None)
    np.testing.assert_allclose(pressure, 1 + 2 * x - y, rtol=1e-13)
    # A grid of another extent is no refinement, even if its numbers of points divide.
    other = {k: v / 2 for k, v in grid(8, lambda x, y: x).items()}
    pressure = grid_pressure_at(fine, other["pressure_x"], other["pressure_y"], (8, 8))
    np.testing.assert_allclose(
        pressure, 1 + 2 * other["pressure_x"] - other["pressure_y"], rtol=0.02
    )
    assert grid_pressure_at(fine, np.array([3.0]), np.array([0.0]), None)[0] == 0


# Binary fractions, of which sums and differences are exact: also at the boundaries.
error = st.one_of(st.integers(-64, 64).map(lambda k: k / 64), st.sampled_from([math.nan, math.inf]))
bar = st.one_of(st.integers(0, 64).map(lambda k: k / 64), st.just(math.nan))


@given(
    steps=st.lists(st.tuples(error, bar), min_size=1, max_size=5),
    tolerance=st.integers(1, 63).map(lambda k: k / 64),
)
@example(steps=[(0.25, 0.25)], tolerance=0.5)  # |e| + u = t holds
@example(steps=[(0.75, 0.25)], tolerance=0.5)  # |e| - u = t does not fail
@example(steps=[(0.25, 0.2500001)], tolerance=0.5)
@example(steps=[(-0.7500001, 0.25)], tolerance=0.5)
@example(steps=[(10.0, math.nan)], tolerance=0.01)  # an unknown bar resolves nothing
@example(steps=[(math.nan, 0.0), (0.001, 0.0)], tolerance=0.01)  # a lost step may be anything
@example(steps=[(math.nan, 0.0), (0.1, 0.0)], tolerance=0.01)  # but outside is outside
def test_a_verdict_is_that_of_the_step_it_stands_on(steps, tolerance):
    """Outside is the surest miss, |e| - u > t; else the widest reach, |e| + u <= t, decides."""
    known = {k: (abs(e), u) for k, (e, u) in enumerate(steps) if math.isfinite(e)}
    least = {k: e - u for k, (e, u) in known.items() if not math.isnan(u)}
    reach = {k: math.inf if math.isnan(u) else e + u for k, (e, u) in known.items()}
    if not known:
        word = "no result"
    elif any(miss > tolerance for miss in least.values()):
        word = "outside"
    elif len(known) == len(steps) and max(reach.values()) <= tolerance:
        word = "within"
    else:
        word = "not resolved"
    told = judged(*np.array(steps).T, tolerance)
    assert told.word == word
    if known:
        ranks = least if word == "outside" else reach
        assert ranks[told.step] == max(ranks.values())
        assert told.error == steps[told.step][0]


@pytest.mark.parametrize(
    ("errors", "bars", "step"),
    [
        ([0.002, 0.004, 0.003], [np.nan, 0.0, np.nan], 2),  # of unknown bars the larger error
        ([0.01, 0.01 * (1 + 1e-15)], [0.0, 0.0], 0),  # alike: the same step on every processor
    ],
)
def test_between_steps_that_are_alike_the_larger_error_or_the_first_decides(errors, bars, step):
    assert judged(errors, bars, 0.02).step == step
