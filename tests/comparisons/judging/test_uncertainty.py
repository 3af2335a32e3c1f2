"""How well a truth is known: grid convergence, standard errors, their combination."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from comparisons.judging.uncertainty import (
    RULE,
    combined,
    grid_uncertainty,
    ratio_of_means,
    share_uncertainty,
    standard_error,
)

N = np.array([10, 20, 40])


def column(*values):
    """Return one load step at several resolutions."""
    return np.array(values, dtype=float)[:, None]


# --- grids ----------------------------------------------------------------------------------


@pytest.mark.parametrize("order", [0.6, 0.8, 1.0])
def test_monotone_convergence_has_the_index_of_roache(order):
    """1.25 |f3 - f2|/(r^p - 1), which for f = 1 + c n^-p is 1.25 times the true error."""
    curves = 1 + 0.3 * N[:, None] ** -order
    error = abs(curves[-1, 0] - 1) / curves[-1, 0]
    assert grid_uncertainty(N, curves)[0] == pytest.approx(1.25 * error, rel=1e-9)


@pytest.mark.parametrize("order", [0.51, 1.0, 1.5, 2.0, 4.0])
@pytest.mark.parametrize("resolutions", [(10, 20, 40), (4, 6, 9), (8, 16, 48), (5, 10, 20, 40)])
def test_the_bar_encloses_the_true_error_of_every_credible_order(order, resolutions):
    """Faster convergence than the first order is not relied upon, so the bar only grows."""
    n = np.array(resolutions)
    for sign in (1, -1):
        curves = 2 + sign * 0.1 * n[:, None] ** -float(order) * np.array([1.0, 2.0, 3.0])
        error = np.abs(curves[-1] - 2) / curves[-1]
        assert np.all(grid_uncertainty(n, curves) >= error)


@pytest.mark.parametrize(
    ("grids", "values", "bar"),
    [
        (
            N,
            (99, 101, 100),
            RULE.unsafe * 0.01,
        ),  # oscillating: the factor times the last difference
        (N, (100, 101, 105), RULE.unsafe * 4 / 105),  # diverging
        # two that agree by chance: at first order the last difference is half the one before
        (N, (98, 100, 100), 1.25 * 0.01),
        (N[:2], (102, 100), RULE.two * 0.02),  # of two grids, at first order: over r - 1
        ((10, 30), (102, 100), RULE.two * 0.01),
        (N, (7, 7, 7), 0.0),
        (N[:2], (7, 7), 0.0),
    ],
)
def test_other_differences_have_a_factor_of_the_last_one(grids, values, bar):
    assert grid_uncertainty(np.array(grids), column(*values))[0] == pytest.approx(bar, rel=1e-12)


def test_slow_convergence_is_covered_by_half_an_order_and_the_unsafe_factor():
    """Errors n^-0.3, 0.33 of 1 at the finest: factor |f3 - f2| / (sqrt 2 - 1) is above it."""
    bar = grid_uncertainty(N, column(*(1 + np.asarray(N, float) ** -0.3)))
    finest = 1 + float(N[-1]) ** -0.3
    assert bar[0] >= (finest - 1) / finest


def test_a_load_step_that_agrees_by_chance_has_half_the_typical_bar():
    """First-order convergence at four steps, and one whose grids happen to agree."""
    curves = np.array([[1.04] * 4 + [1.0], [1.02] * 4 + [1.0], [1.01] * 4 + [1.0]])
    bars = grid_uncertainty(N, curves)
    assert bars[-1] == pytest.approx(bars[0] / 2, rel=1e-9)


def test_one_grid_says_nothing():
    assert np.isnan(grid_uncertainty(N[:1], column(7))).all()
    lost = np.array([[1.0, 2.0], [np.nan, np.nan]])
    assert np.isnan(grid_uncertainty(N[:2], lost)).all()


def test_a_lost_grid_is_passed_over():
    """A resolution without any answer leaves the other two."""
    lost = column(102, np.nan, 100)
    expected = grid_uncertainty(N[[0, 2]], column(102, 100))
    np.testing.assert_array_equal(grid_uncertainty(N, lost), expected)


values = st.floats(1e-6, 1e6) | st.floats(-1e6, -1e-6)


@given(
    curves=st.tuples(st.integers(2, 5), st.integers(1, 6)).flatmap(
        lambda shape: arrays(float, shape, elements=values)
    ),
    start=st.integers(2, 30),
    growth=st.sampled_from([1.2, 1.5, 2.0, 4.0]),
    power=st.integers(-40, 40),
)
def test_bars_are_numbers_never_negative_and_know_no_units(curves, start, growth, power):
    n = np.ceil(start * growth ** np.arange(len(curves))) + np.arange(len(curves))
    bars = grid_uncertainty(n, curves)
    assert np.isfinite(bars).all()
    assert (bars >= 0).all()
    np.testing.assert_array_equal(grid_uncertainty(n, curves * 2.0**power), bars)
    np.testing.assert_array_equal(grid_uncertainty(n, -curves), bars)
    # No less than the last two grids differ at that step, whatever the branch.
    last = np.abs(curves[-1] - curves[-2]) / np.abs(curves[-1])
    ratio = n[-1] / n[-2]
    spread = max(ratio**RULE.highest - 1, 1)
    assert (bars >= RULE.safe * last / spread * (1 - 1e-12)).all()


# --- ensembles ------------------------------------------------------------------------------


def test_standard_error_of_the_mean():
    """1, 2, 3: standard deviation 1, standard error 1/sqrt(3)."""
    samples = np.array([[1.0, 5.0], [2.0, np.nan], [3.0, np.nan]])
    error = standard_error(samples)
    assert error[0] == pytest.approx(1 / math.sqrt(3), rel=1e-14)
    assert np.isnan(error[1])


def test_independent_sources_add_as_squares():
    assert combined(np.array([3.0]), np.array([4.0]))[0] == 5
    assert np.isnan(combined(np.array([np.nan]), np.array([4.0])))[0]


def test_ratio_of_means_covers_as_often_as_it_says():
    """Two correlated ensembles of 20: the 95 % bar holds the true ratio in 93 to 97 % of cases.

    4000 repetitions have a standard error of 0.35 %; the delta method is first order only.
    """
    rng = np.random.default_rng(3)
    common = rng.normal(size=(20, 4000))
    x = 3 + 0.5 * common + 0.1 * rng.normal(size=(20, 4000))
    y = 2 + 0.4 * common + 0.1 * rng.normal(size=(20, 4000))
    paired, narrow = ratio_of_means(x, y, paired=True)
    _, wide = ratio_of_means(x, y, paired=False)
    covered = np.mean(np.abs(paired / 1.5 - 1) <= narrow)
    assert 0.93 < covered < 0.97
    # The common part cancels: without the covariance the bar is far too wide.
    assert np.median(wide) > 2 * np.median(narrow)


def test_ratio_of_means_of_single_values_does_not_scatter():
    ratio, bar = ratio_of_means(np.array([[2.0]]), np.array([[4.0]]), paired=True)
    assert ratio[0] == 0.5
    assert bar[0] == 0


def test_ratio_of_means_leaves_out_pairs_that_lost_a_partner():
    x = np.array([[1.0], [2.0], [np.nan]])
    y = np.array([[1.0], [2.0], [90.0]])
    ratio, bar = ratio_of_means(x, y, paired=True)
    assert ratio[0] == 1
    assert bar[0] == 0


@pytest.mark.parametrize("rough", [False, True])
def test_a_step_that_the_finest_grid_lost_has_no_bar(rough):
    """The other steps' changes say nothing of a value that is not there."""
    curves = np.array([[1.2, 1.2], [1.1, 1.1], [1.05, np.nan]])
    grids = np.array([16, 32, 64])
    if rough:
        bars = share_uncertainty(grids, curves, ("stiffness", "free"))
    else:
        bars = grid_uncertainty(grids, curves)
    assert np.isfinite(bars[0])
    assert np.isnan(bars[1])


@pytest.mark.parametrize("kind", ["cells", "elements", "free"])
def test_an_area_that_is_zero_on_the_finest_grid_has_no_bar_relative_to_it(kind):
    """Nor does it widen those of lighter loads, which bars on cells are not below."""
    curves = np.array([[1.2, 1.2, 1.2], [1.1, 1.1, 1.1], [1.05, 0.0, 1.05]])
    bars = share_uncertainty(np.array([16, 32, 64]), curves, ("contact_area", kind))
    assert np.isnan(bars[1])
    assert (bars[[0, 2]] < 1).all()
