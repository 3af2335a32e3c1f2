"""How well a truth is known: grids, surfaces, standard errors, and refinement until it will do."""

import itertools
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import psutil
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from comparisons.facts.methods import METHODS
from comparisons.judging.levels import allocate, estimate, variances, within_budget
from comparisons.judging.refinement import BUDGET, refinements
from comparisons.judging.uncertainty import (
    HIGHEST,
    OF_TWO,
    SAFE,
    UNSAFE,
    combined,
    grid_uncertainty,
    ratio_of_means,
    share_uncertainty,
    standard_error,
)
from comparisons.solving.plan import task_of
from comparisons.solving.planning import plan_scene
from comparisons.tasks.solution import Solution

N = np.array([10, 20, 40])
FIRST = 1.25 * 0.01 / 1.01  # Roache's index of a last change of 1 % at first order


def column(*values):
    return np.array(values, dtype=float)[:, None]


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
        (N, (99, 101, 100), UNSAFE * 0.01),  # oscillating: the factor times the last difference
        (N, (100, 101, 105), UNSAFE * 4 / 105),  # diverging
        # two that agree by chance: at first order the last difference is half the one before
        (N, (98, 100, 100), 1.25 * 0.01),
        (N[:2], (102, 100), OF_TWO * 0.02),  # of two grids, at first order: over r - 1
        ((10, 30), (102, 100), OF_TWO * 0.01),
        (N, (7, 7, 7), 0.0),
        (N[:2], (7, 7), 0.0),
        (N, (102, np.nan, 100), OF_TWO * 0.02 / 3),  # a grid that was lost is passed over
        # one grid says nothing, nor does one that was lost at a step about that step
        (N[:1], (7,), np.nan),
        (N[:2], ((1, 2), (np.nan, np.nan)), (np.nan, np.nan)),
        (N, ((1.04, 1.04), (np.nan, 1.02), (1.01, 1.01)), (np.nan, 1.25 * 0.01 / 1.01)),
        (N, ((1.2, 1.2), (1.1, 1.1), (1.05, np.nan)), (1.25 * 0.05 / 1.05, np.nan)),
        # at first order; a step that agrees by chance has half the typical bar
        (N, ((1.04, 1.04, 1), (1.02, 1.02, 1), (1.01, 1.01, 1)), np.array([2, 2, 1]) * FIRST / 2),
    ],
)
def test_other_differences_have_a_factor_of_the_last_one(grids, values, bar):
    bars = grid_uncertainty(np.array(grids), np.array(values, dtype=float).reshape(len(grids), -1))
    assert bars == pytest.approx(np.atleast_1d(bar), rel=1e-12, nan_ok=True)


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
    spread = max(ratio**HIGHEST - 1, 1)
    assert (bars >= SAFE * last / spread * (1 - 1e-12)).all()


def test_standard_error_of_the_mean():
    """1, 2, 3: standard deviation 1, standard error 1/sqrt(3)."""
    samples = np.array([[1.0, 5.0], [2.0, np.nan], [3.0, np.nan]])
    error = standard_error(samples)
    assert error[0] == pytest.approx(1 / np.sqrt(3), rel=1e-14)
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


@pytest.mark.parametrize(("x", "y", "of"), [((2,), (4,), 0.5), ((1, 2, np.nan), (1, 2, 90), 1.0)])
def test_ratio_of_means_of_single_values_and_of_pairs_less_those_that_lost_a_partner(x, y, of):
    ratio, bar = ratio_of_means(column(*x), column(*y), paired=True)
    assert (ratio[0], bar[0]) == (of, 0)


@pytest.mark.parametrize("kind", ["cells", "elements", "free"])
@pytest.mark.parametrize("finest", [0.0, np.nan])
def test_an_area_that_the_finest_grid_lost_or_that_is_zero_there_has_no_bar(kind, finest):
    """Nor does it widen those of lighter loads, which bars on cells are not below."""
    curves = np.array([[1.2, 1.2, 1.2], [1.1, 1.1, 1.1], [1.05, finest, 1.05]])
    bars = share_uncertainty(np.array([16, 32, 64]), curves, ("contact_area", kind))
    assert np.isnan(bars[1])
    assert (bars[[0, 2]] < 1).all()


def test_a_share_of_no_power_of_the_area_needs_no_contact():
    """Elements follow the contact line: a value without any area has the bar of the others."""
    curves = np.array([[1.2, 1.2], [1.1, 1.1], [1.05, 1.05]])
    areas = np.array([0.0, 1.0])
    bars = share_uncertainty(np.array([16, 32, 64]), curves, ("force", "elements"), areas=areas)
    assert bars[0] == bars[1] > 0


SQUARE = {"shape": "square_punch", "side": 1e-3}


def refined(plan, solved, solve, budget=BUDGET):
    """Return the plan with all refinements, each solved as it is asked for."""
    for finer in refinements(plan, solved, budget):
        plan = finer
        solve(plan)
    return plan


@pytest.fixture
def refine(scene):
    """Refine a plan whose FFT solver has an error of C/N in force, at a cost of N^2 seconds."""

    def run(
        *, error=1.0, tolerance=0.05, seconds=1e-6, lost_from=10**9, budget=BUDGET, listed=None
    ):
        compared = {"tolerance": tolerance, "methods": ["bem_fft"]} | (listed or {})
        (plan,) = plan_scene(scene(indenter=SQUARE, compare=compared))
        start = (8, 16)
        chosen = [
            replace(m, resolutions=start) if m.method == "bem_fft" else m for m in plan.methods
        ]
        plan = replace(plan, methods=tuple(chosen))
        store = {}

        def solve(item):
            for method in item.methods:
                for n in method.resolutions:
                    store.setdefault((method.method, n), solution(item, n))

        def solution(item, n):
            depth = item.loads.values[None, :]
            result = Solution.empty(task_of(plan, "bem_fft", n))
            result.seconds = seconds * n**2
            if n < lost_from:
                result.quantities = {"penetration": depth, "force": depth * (1 + error / n)}
                result.converged[:] = True
                result.violation[:] = 0.0
            return result

        solve(plan)
        done = refined(plan, lambda _: dict(store), solve, budget)
        (planned,) = [item for item in done.methods if item.method == "bem_fft"]
        return planned.resolutions, done.notes

    return run


def test_the_truth_is_refined_until_its_bar_is_a_fifth_of_the_tolerance(refine):
    """Error 1/N at first order of a punch with corners: the bar is 1.25/N (3/N on two grids).

    Wanted is 0.05/5 = 1/100: N = 16 has 3/16, N = 32 has 1.25/32, N = 64 1.25/64, and N = 128 the
    first below a hundredth.
    """
    resolutions, notes = refine()
    assert resolutions == (8, 16, 32, 64, 128)
    assert notes == ()


def test_a_truth_that_is_known_well_enough_is_left_as_it_is(refine):
    assert refine(error=1e-4) == ((8, 16), ())
    assert refine(tolerance=0.5) == ((8, 16, 32), ())  # 2/17 on two grids, wanted 0.1


def test_what_ends_a_refinement_is_named(refine, monkeypatch):
    resolutions, (note,) = refine(tolerance=1e-4, seconds=0.5)
    # 0.5 s N^2 and 4.7 times that for the next: at N = 16 already 602 s.
    assert resolutions == (8, 16)
    assert "ends at N = 16, the next would take about 602 s, more than the budget" in note
    resolutions, (note,) = refine(tolerance=1e-4, lost_from=64)
    assert resolutions == (8, 16, 32, 64)
    assert "bem_fft found no answer at N = 64" in note
    memory = SimpleNamespace(available=2.5e8, total=2.5e8)
    monkeypatch.setattr(psutil, "virtual_memory", lambda: memory)
    resolutions, (note,) = refine(tolerance=1e-6)
    assert resolutions[-1] < 1024
    assert f"ends at N = {resolutions[-1]}, needs about" in note


def test_growth_of_work_is_that_of_the_method(refine):
    """With a budget just above 4.7 times the last solve it goes on, just below it ends."""
    last = METHODS["bem_fft"].growth * 16**2
    assert refine(tolerance=1e-3, seconds=1.0, budget=1.01 * last)[0] == (8, 16, 32)
    assert refine(tolerance=1e-3, seconds=1.0, budget=0.99 * last)[0] == (8, 16)


def test_a_scene_with_a_closed_form_needs_no_refinement(scene):
    (plan,) = plan_scene(scene(compare={"methods": ["closed_form"]}))
    exact = Solution.empty(task_of(plan, "closed_form", 1))
    exact.quantities = {"force": np.ones((1, 3)), "penetration": plan.loads.values[None, :]}
    exact.converged[:] = True
    never = pytest.fail
    assert refined(plan, lambda _: {("closed_form", 1): exact}, never) is plan
    assert refined(plan, lambda _: {}, never) is plan


def test_listed_resolutions_are_not_refined_beyond(refine):
    resolutions, (note,) = refine(listed={"resolutions": [8, 16]})
    assert resolutions == (8, 16)
    assert "the resolutions that the scene lists" in note


def test_a_second_candidate_follows_the_truth_on_one_rough_surface(rough):
    """Both are asked for every finer grid, elements up to 512 points a side, to be compared."""
    methods = {"methods": ["bem_fft", "fem"], "tolerance": 1e-4}
    (plan,) = plan_scene(rough(points=64, short_cutoff=None, compare=methods))
    store = {}

    def solve(item):
        for task in item.tasks:
            result = Solution.empty(task)
            error = 1 + (1 if task.method == "bem_fft" else 2) / task.resolution
            result.quantities = {name: np.full((1, 2), error) for name in plan.compared}
            result.quantities["force"] = plan.loads.values[None, :]
            result.converged[:], result.seconds = True, 1e-3
            store[task.method, task.resolution] = result

    solve(plan)
    done = refined(plan, lambda _: dict(store), solve)
    grids = {item.method: item.resolutions for item in done.methods if item.supported}
    assert grids["fem"] == (64, 128, 256, 512)
    assert grids["bem_fft"][:4] == (64, 128, 256, 512)
    assert len(grids["bem_fft"]) > 4


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
        # a surface that only the finer grid has, as in merged runs of one grid each: two are left
        ([[[1], [2]], [[1.5], [2.7], [99]]], [1.5 + 0.6], [0.6 * T1], [""]),
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
