"""Ensembles: numbers of surfaces and lines, and the one surface of a map among single lines."""

import numpy as np
import pytest

from comparisons.judging import refinement
from comparisons.judging.levels import Levels, ensemble_text
from comparisons.judging.refinement import LINES_SHARE, SCATTER, enlarged, expected
from comparisons.judging.truth import choose_truth
from comparisons.judging.verdicts import Verdict
from comparisons.results.recording import FEWEST_LINES, record_scene
from comparisons.scene.scene import load_scene
from comparisons.solving.plan import surface_cost, task_of
from comparisons.solving.planning import plan_scene
from comparisons.tasks.solution import Solution

NAMES = ("contact_area", "penetration", "mean_gap", "stiffness")
TOLERANCE = 0.05


@pytest.fixture
def first(rough):
    """Plan an ensemble and answer its first surfaces: 1 + scatter on all grids, + noise on each."""

    def make(scatter=0.2, noise=0.01, realisations=100_000, lost=(), **compare):
        compared = {"tolerance": TOLERANCE, "methods": ["reduced", "bem_fft"], **compare}
        (plan, *_) = plan_scene(
            rough(points=16, realisations=realisations, compare=compared | {"quantities": NAMES})
        )
        stream = np.random.default_rng(1)
        own = {
            method: 1 + scatter * stream.standard_normal((1000, 1))
            for method in compared["methods"]
        }
        solved = {}
        for planned in plan.methods:
            for n in planned.resolutions:
                count = plan.number(planned.method, n)
                task = task_of(plan, planned.method, n, tuple(range(count)))
                values = own[planned.method][:count] * np.ones(task.shape)
                values = values + noise * stream.standard_normal(task.shape)
                solution = Solution.of(task, dict.fromkeys(NAMES, values))
                if (planned.method, n) in lost:
                    solution = Solution.lost(task, "lost")
                solved[planned.method, n] = solution
        return plan, solved

    return make


def numbers(plan, method="bem_fft"):
    (planned,) = [m for m in plan.methods if m.method == method]
    return planned.numbers


def scatters(plan, solved, method):
    """Return what the variances of the first surfaces make of the chosen numbers, 95 %."""
    levels = Levels.of(solved, method)
    grids = [solution.quantities["stiffness"] for solution in levels.solutions.values()]
    parts = refinement.variances(grids) / np.array(numbers(plan, method))[:, None]
    return 1.96 * np.sqrt(parts.sum(axis=0)).max()


def test_means_scatter_no_more_than_is_wanted_and_lines_a_fifth_of_it(first):
    """The aim is somewhat less, and numbers are rounded up to whole tasks: never more."""
    plan, solved = first(scatter=0.07)
    chosen = enlarged(plan, solved, "quick")
    wanted = SCATTER["quick"] * TOLERANCE
    assert 0.5 * wanted < scatters(chosen, solved, "bem_fft") <= wanted
    assert scatters(chosen, solved, "reduced") <= LINES_SHARE["quick"] * wanted
    assert list(numbers(chosen)) == sorted(numbers(chosen), reverse=True)


def test_surfaces_go_where_they_are_cheap(first):
    """Twice the scatter between surfaces: more than twice as many, on the coarse grid alone."""
    few, many = (enlarged(*first(scatter=s), "quick") for s in (0.07, 0.14))
    assert numbers(many)[0] > 2 * numbers(few)[0]
    assert numbers(many)[-1] == numbers(few)[-1]


def test_too_few_realisations_are_said_with_what_they_leave(first):
    plan, solved = first(realisations=60)
    chosen = enlarged(plan, solved, "quick")
    assert numbers(chosen)[0] == 60
    (note,) = [note for note in chosen.notes if "no more surfaces" in note]
    assert "than the scene's realisations: their scatter leaves " in note
    assert "instead of 3.8\u202f% in the worst mean" in note


def test_a_budget_that_is_too_small_is_said_and_the_first_surfaces_stay(first, monkeypatch):
    plan, solved = first(scatter=0.3)
    monkeypatch.setitem(refinement.SURFACES_BUDGET, "quick", 1e-3)
    chosen = enlarged(plan, solved, "quick")
    assert numbers(chosen) == numbers(plan)
    assert any("than what 0 solves of 64 x 64 points cost" in note for note in chosen.notes)


def test_more_surfaces_are_expected_of_an_ensemble_as_its_budget_or_the_scene_allows(first):
    much, little, none = (
        sum(
            kind.realisations * surface_cost(kind.method, kind.resolution)
            for kind in expected(first(realisations=most)[0], "quick")
        )
        for most in (100_000, 60, 1)
    )
    assert 0.5 * refinement.SURFACES_BUDGET["quick"] < much < refinement.SURFACES_BUDGET["quick"]
    assert 0.0 < little < 0.5 * much
    assert none == 0.0


def test_no_scatter_asks_for_no_more_than_the_first_surfaces(first):
    plan, solved = first(scatter=0.0, noise=0.0)
    chosen = enlarged(plan, solved, "quick")
    assert numbers(chosen) == numbers(plan)
    assert numbers(chosen, "reduced") == numbers(plan, "reduced")
    assert not any("surfaces" in note for note in chosen.notes)
    scatter = Levels.of(solved, "bem_fft").scatter("stiffness", max(n for _, n in solved))
    np.testing.assert_array_equal(scatter, 0.0)


def test_a_quantity_that_one_grid_lacks_chooses_no_numbers(first):
    """There is no difference between grids to know; the others choose."""
    plan, solved = first(scatter=0.07)
    expected_numbers = numbers(enlarged(plan, solved, "quick"))
    coarsest = min(n for method, n in solved if method == "bem_fft")
    for (method, n), solution in solved.items():
        if method == "bem_fft":  # wild, where it is at all
            solution.quantities["stiffness"] = 5 * solution.quantities["stiffness"] - 4
        if (method, n) == ("bem_fft", coarsest):
            del solution.quantities["stiffness"]
    assert numbers(enlarged(plan, solved, "quick")) == expected_numbers


def test_a_mean_of_zeros_does_not_scatter(first):
    """The gap of lines that are all closed: its error of -100 % is no question of a bar."""
    _, solved = first()
    for (method, _), solution in solved.items():
        if method == "reduced":
            solution.quantities["stiffness"] = np.zeros_like(solution.quantities["stiffness"])
    lines = Levels.of(solved, "reduced")
    np.testing.assert_array_equal(lines.scatter("stiffness", lines.finest), 0.0)


def test_one_realisation_is_no_ensemble(first):
    plan, solved = first(realisations=1)
    chosen = enlarged(plan, solved, "quick")
    assert numbers(chosen) == ()
    assert [len(s.converged) for (m, _), s in solved.items() if m == "bem_fft"] == [1] * 5


def test_surfaces_that_are_all_lost_choose_nothing_and_say_so(first):
    """On all grids: no numbers. On one grid: the others still choose theirs."""
    plan, _ = first()
    everywhere = [("bem_fft", n) for m in plan.methods for n in m.resolutions]
    plan, solved = first(lost=everywhere)
    chosen = enlarged(plan, solved, "quick")
    assert numbers(chosen) == numbers(plan)
    assert any("no answer to choose them from" in note for note in chosen.notes)
    plan, solved = first(lost=everywhere[-1:])
    chosen = enlarged(plan, solved, "quick")
    assert all(now >= before for now, before in zip(numbers(chosen), numbers(plan), strict=True))


def test_lines_and_surfaces_are_named_as_what_they_are():
    assert ensemble_text("reduced", [2000, 1000], [64, 128]) == "2000 lines at 64, 1000 at 128"
    assert ensemble_text("bem_fft", [1], [64]) == "1 surface at 64"
    assert ensemble_text("fem", [], [64]) == ""


def test_the_truth_says_what_is_missing_for_a_bar(first):
    """One surface with an answer on the finest grid, at the second load: no scatter is invented."""
    plan, solved = first()
    finest = max(n for method, n in solved if method == "bem_fft")
    fine = solved["bem_fft", finest]
    fine.quantities["stiffness"][1:, 1] = np.nan
    said = choose_truth(solved, plan.loads.axis, NAMES).sentence(NAMES)
    assert "known to: contact area" in said
    lacking = "stiffness not at every load: at load step 2 one surface on grid 3 of 3: "
    assert lacking + "how it scatters is not known." in said
    alone = {key: s for key, s in solved.items() if key == ("bem_fft", finest)}
    assert "only one resolution was run" in choose_truth(alone, plan.loads.axis, NAMES).sentence(
        NAMES
    )


def test_a_bar_relative_to_nothing_is_said_to_be_missing(first):
    plan, solved = first(realisations=1)
    finest = max(n for method, n in solved if method == "bem_fft")
    solved["bem_fft", finest].quantities["mean_gap"][:, 1] = 0.0
    said = choose_truth(solved, plan.loads.axis, NAMES).sentence(NAMES)
    assert "mean gap not at every load: it is zero on the finest grid." in said


def test_finite_elements_take_the_wider_share_of_free_surfaces(rough):
    """The narrow shares of periodic surfaces were measured on cells."""
    (plan, *_) = plan_scene(rough(points=16, periodic=True))

    def bar(method):
        grids = {
            n: Solution.of(task_of(plan, method, n), {"mean_gap": 1 + 1.6 / n}) for n in (16, 32)
        }
        return Levels(method, grids).discretisation("mean_gap")[0]

    assert bar("fem") > 1.5 * bar("bem_fft")


AREA = "contact_area"


@pytest.fixture(scope="module")
def plan():
    changes = {
        "surface.crop": [0, 0, 16, 16],
        "compare": {"quantities": [AREA], "methods": ["reduced", "bem_fft"]},
    }
    return plan_scene(load_scene("measured-map", changes))[0]


def outside(plan, lines, surface, grids=(1.0, 1.0)):
    """Return the load steps at which a surface is outside the band of lines."""
    steps = len(plan.loads.values)
    solved = {}
    for n, share in zip((16, 32), grids, strict=True):
        task = task_of(plan, "bem_fft", n)
        solved["bem_fft", n] = Solution.of(task, {AREA: share * np.asarray(surface)})
    task = task_of(plan, "reduced", 16, tuple(range(len(lines))))
    curves = np.asarray(lines)[:, None] * np.ones(steps)
    solved["reduced", 16] = Solution.of(task, {AREA: curves})
    verdicts = record_scene(plan, solved).verdicts
    (own,) = [v for v in verdicts if (v.method, v.at) == ("reduced", "force")]
    return own.outside_band


def test_a_surface_is_inside_or_outside_the_band_of_single_lines(plan):
    """90 % of 1, 2, .. 100 lie between 5.95 and 95.05; the grids agree, so nothing blurs it."""
    lines = np.arange(1.0, 101.0)
    assert outside(plan, lines, [6.0, 50.0, 50.0, 50.0, 95.0]) == ()
    assert outside(plan, lines, [5.9, 50.0, 95.1, 96.0, 50.0]) == (0, 2, 3)


def test_the_bar_of_the_surface_counts_for_it(plan):
    """Its area changed by 10 % from one grid to the next: 98 may be 95."""
    lines, surface = np.arange(1.0, 101.0), [50.0, 50.0, 50.0, 50.0, 98.0]
    assert outside(plan, lines, surface) == (4,)
    assert outside(plan, lines, surface, grids=(1.1, 1.0)) == ()


def test_few_lines_have_no_band(plan):
    assert outside(plan, np.arange(1.0, FEWEST_LINES), np.ones(5)) is None


def test_only_grids_of_cells_err_at_the_contact_line(plan):
    """An area of 1.0 counted as 1.5: cells leave at least 0.5 0.5^1.5 = 17 %, springs nothing."""
    steps = np.ones(len(plan.loads.values))
    for method, least, most in (("bem_fft", 0.17, np.inf), ("reduced", 0.0, 1e-9)):
        solved = {
            (method, n): Solution.of(
                task_of(plan, method, n), {AREA: steps, "contact_area_raw": 1.5 * steps}
            )
            for n in (16, 32, 64)
        }
        bar = Levels.of(solved, method).discretisation(AREA)
        assert (bar >= least).all()
        assert (bar <= most).all()


@pytest.mark.parametrize(
    ("steps", "words"),
    [
        (None, ""),
        ((), "within the scatter of single lines"),
        ((1,), "beyond the scatter of single lines at load step 2"),
        ((0, 3), "beyond the scatter of single lines at load steps 1, 4"),
        ((1, 2, 3, 4), "beyond the scatter of single lines at load steps 2 to 5"),
    ],
)
def test_a_verdict_says_where_the_surface_lies(steps, words):
    numbers = {"step": 4, "error": 0.2, "uncertainty": 0.01, "low": 0.19, "high": 0.21}
    asked = {"quantity": AREA, "at": "force", "tolerance": 0.05}
    judged = Verdict(word="outside", outside_band=steps, **asked, **numbers)
    assert judged.band == words
    expected = "load step 5, equal force"
    assert judged.where == expected + (f"; the lines' mean, the surface {words}" if words else "")


@pytest.mark.parametrize("follows", [True, False])
def test_the_leading_grids_surfaces_serve_a_method_that_scatters_with_them(first, follows):
    """A solver's answers do: 3 % below on each surface. A theory gives all surfaces one answer."""
    plan, solved = first(methods=["reduced", "bem_fft", "fem"], noise=0.0)
    grid = solved["bem_fft", min(n for name, n in solved if name == "bem_fft")]
    for n in [n for name, n in solved if name == "fem"]:
        task = task_of(plan, "fem", n, tuple(range(plan.number("fem", n))))
        surfaces = grid.quantities["stiffness"][: len(task.realisations)]
        values = 0.97 * surfaces if follows else np.full_like(surfaces, 0.97)
        solved["fem", n] = Solution.of(task, dict.fromkeys(NAMES, values))
    levels = Levels.of(solved, "fem")
    mean = 0.97 * (grid.quantities["stiffness"].mean(axis=0) if follows else 1.0)
    # to round-off; a few surfaces alone would miss the mean by a tenth
    assert levels.curves(n)["stiffness"] == pytest.approx(mean, rel=1e-12)
    assert (levels.anchor is not None) == follows
