"""Multilevel means against closed-form toy problems, and what is said where data are missing."""

import itertools

import numpy as np
import pytest

from comparisons.judging.levels import allocate, estimate, variances, within_budget

# Q_l = 10 + (1 + c_l) x + d_l z_l with x, z_l independent and standard normal: known covariances.
SLOPES, NOISE = np.array([1.2, 1.05, 1.0]), np.array([0.0, 0.1, 0.05])
NUMBERS = (40, 12, 5)


def _sample(rng: np.random.Generator, repeats: int = 1, numbers=NUMBERS) -> list[np.ndarray]:
    """Draw the surfaces of independent repetitions, which stand beside each other as load steps."""
    x, z = rng.standard_normal((numbers[0], repeats)), rng.standard_normal((3, numbers[0], repeats))
    return [
        10 + SLOPES[level] * x[:n] + NOISE[level] * z[level, :n] for level, n in enumerate(numbers)
    ]


def _true_parts() -> np.ndarray:
    """a_l = Var Y_l + 2 sum over m > l of Cov(Y_l, Y_m) of the toy problem."""
    slopes = np.diff(SLOPES, prepend=0)
    # coefficients of x, z_0, z_1, z_2 in Y_0, Y_1, Y_2
    rows = np.array(
        [
            [slopes[0], NOISE[0], 0, 0],
            [slopes[1], -NOISE[0], NOISE[1], 0],
            [slopes[2], 0, -NOISE[1], NOISE[2]],
        ]
    )
    covariance = rows @ rows.T
    return np.array([covariance[k, k] + 2 * covariance[k, k + 1 :].sum() for k in range(3)])


def test_the_mean_is_unbiased_its_variance_the_formula_and_its_bar_covers_it():
    """4000 repetitions: the mean to 4 standard errors, its variance to 4 of its own (sqrt(2/4000)).

    The variance that each repetition estimates, on average, to 3 %; bars cover 95 +- 1 %.
    """
    known = estimate(_sample(np.random.default_rng(1), 4000))
    expected = float((_true_parts() / NUMBERS).sum())
    assert known.mean.mean() == pytest.approx(10, abs=4 * np.sqrt(expected / 4000))
    assert known.mean.var(ddof=1) == pytest.approx(expected, rel=4 * np.sqrt(2 / 4000))
    assert known.parts.sum(axis=0).mean() == pytest.approx(expected, rel=0.03)
    assert np.mean(abs(known.mean - 10) < known.half_width) == pytest.approx(0.95, abs=0.01)


NAN, ONE_SURFACE = np.nan, "one surface on grid 1 of 1: how it scatters is not known"
NO_ANSWER = "no surface has an answer on grid 2 of 2"
T1 = 12.7062  # Student's t(0.975, 1)


@pytest.mark.parametrize(
    ("grids", "mean", "half_width", "missing"),
    [
        # one grid: the ordinary mean, t(0.975, 2) = 4.3027, standard deviation sqrt(7)
        ([[[1, 5], [2, 5], [6, 5]]], [3, 5], [4.3027 * np.sqrt(7 / 3), 0], ["", ""]),
        ([[[2]]], [2], [NAN], [ONE_SURFACE]),
        ([[[1, 1]] * 4, [[1, NAN], [1.1, NAN]]], [1.05, NAN], [0.05 * T1, NAN], ["", NO_ANSWER]),
        # the coarse grid lost all: the finer one has its own mean, of deviation sqrt(2)
        ([[[NAN]] * 4, [[1], [3]]], [2], [T1], [""]),
        # a surface that only the finer grid has, as in merged runs of one grid each
        ([[[1], [2]], [[1.5], [2.7], [99]]], [1.5 + 0.6], [6.7163], [""]),
        # surface 0 lost on the coarse grid, surface 1 on the fine one: two differences are left
        ([[[NAN], [2], [3], [4]], [[9], [NAN], [3.5], [4.7]]], [3 + 0.6], [2.6346], [""]),
        ([[[3]] * 5, [[3.5]] * 2], [3.5], [0], [""]),
    ],
)
def test_means_and_bars_stand_on_the_answers_that_are_there(grids, mean, half_width, missing):
    known = estimate([np.array(grid, dtype=float) for grid in grids])
    assert known.mean == pytest.approx(mean, nan_ok=True)
    assert known.half_width == pytest.approx(half_width, rel=1e-4, nan_ok=True)
    assert list(known.missing) == missing


def test_a_coarse_grid_differs_from_the_finest_by_paired_differences_only():
    """The scatter of the surfaces, a hundred times that of the differences, drops out."""
    rng = np.random.default_rng(4)
    coarse = 10 + 3 * rng.standard_normal((50, 1))
    difference = 0.5 + 0.03 * rng.standard_normal((10, 1))
    known = estimate([coarse, coarse[:10] + difference])
    assert known.differing(1)[0] == 0
    # t(0.975, 9) = 2.2622
    expected = 2.2622 * difference.std(ddof=1) / np.sqrt(10)
    assert known.differing(0)[0] == pytest.approx(expected, rel=1e-4)
    assert known.half_width[0] > 10 * known.differing(0)[0]


def test_the_same_digits_however_the_surfaces_were_split():
    rng = np.random.default_rng(6)
    whole = _sample(rng, numbers=(30, 12, 5))
    cuts = zip(whole, (7, 3, 5), strict=True)
    parts = [np.concatenate(np.array_split(part, pieces)) for part, pieces in cuts]
    one, other = estimate(whole), estimate(parts)
    assert one.mean.tobytes() == other.mean.tobytes()
    assert one.half_width.tobytes() == other.half_width.tobytes()


def test_numbers_of_one_mean_are_those_of_giles():
    """n_l = sqrt(V_l/c_l) sum sqrt(V c)/allowed, rounded up."""
    variance, cost = np.array([4.0, 0.09, 0.01]), np.array([1.0, 5.0, 25.0])
    total = np.sqrt(variance * cost).sum()
    expected = np.ceil(np.sqrt(variance / cost) * total / 0.02)
    numbers = allocate(variance[:, None], cost, np.array([0.02]))
    np.testing.assert_array_equal(numbers, expected)


def test_no_cheaper_numbers_know_several_means_well_enough():
    """Against every pair of numbers in reach: at most one surface more than the cheapest."""
    variance = np.array([[1.0, 0.2, 0.6], [0.02, 0.3, 0.001]])
    cost, allowed = np.array([1.0, 4.0]), np.array([0.02, 0.02, 0.015])
    numbers = allocate(variance, cost, allowed)
    assert ((variance / numbers[:, None]).sum(axis=0) <= allowed * (1 + 1e-9)).all()
    good = [
        pair
        for pair in itertools.product(range(2, 150), range(2, 60))
        if pair[1] <= pair[0] and ((variance / np.array(pair)[:, None]).sum(0) <= allowed).all()
    ]
    cheapest = min(float(np.array(pair) @ cost) for pair in good)
    assert float(numbers @ cost) <= cheapest + cost.sum()


def test_variances_are_what_allocation_needs():
    rng = np.random.default_rng(7)
    result = variances(_sample(rng, 3000)).mean(axis=1)
    np.testing.assert_allclose(result, _true_parts(), rtol=0.1, atol=3e-4)


def test_no_scatter_needs_the_fewest_surfaces():
    assert allocate(np.zeros((3, 2)), np.array([1.0, 4.0, 16.0]), np.ones(2)).tolist() == [2, 2, 2]


def test_budgets_scale_the_numbers_and_too_small_ones_are_refused():
    numbers, cost = np.array([450, 38, 9]), np.array([1.0, 4.5, 20.0])
    assert within_budget(numbers, cost, 1e4) is numbers
    scaled = within_budget(numbers, cost, 300.0)
    assert float(scaled @ cost) <= 300.0
    assert (scaled >= 2).all()
    tight = within_budget(np.array([450, 2, 2]), cost, 60.0)
    assert tight.tolist()[1:] == [2, 2]
    assert float(tight @ cost) <= 60.0
    with pytest.raises(ValueError, match=r"budget of 12 is too small: 2 surfaces on each grid"):
        within_budget(numbers, cost, 12.0)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: allocate(np.ones((1, 1)), np.ones(1), np.zeros(1)), "without any error"),
        (lambda: allocate(np.ones((1, 1)), np.zeros(1), np.ones(1)), "costs positive"),
        (lambda: allocate(np.full((1, 1), NAN), np.ones(1), np.ones(1)), "costs positive"),
        (lambda: estimate([]), "at least one grid"),
    ],
)
def test_what_allocates_nothing_is_refused(call, words):
    with pytest.raises(ValueError, match=words):
        call()
