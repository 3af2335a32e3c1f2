"""Pressures and distributions compared at the last load."""

import json

import numpy as np
import pytest
from scipy import special

from comparisons.judging.fields import distance, field_measures
from comparisons.judging.truth import choose_truth
from comparisons.methods.normal.reduced import line_values
from comparisons.questions.single import solve_scene
from comparisons.results.store import load_study
from comparisons.scene.scene import SceneError, load_scene
from comparisons.solving.execution import execute
from comparisons.solving.plan import task_of
from comparisons.solving.planning import plan_scene
from comparisons.tasks.distributions import Stretches, edges, histogram
from comparisons.tasks.solution import Solution
from reduced.loads import Load
from reduced.rough.press import RoughLines, press
from reports.plots.surfaces import distributions
from roughline import Study

COMPARABLE = {"quantities": ["force", "pressure"]}
SQUARE = {"shape": "square_punch", "side": 2.0}


def cells(n, half=1.0):
    """Return cell centres of an n by n grid on a square, as fields have them."""
    centres = half * (2 * (np.arange(n) + 0.5) / n - 1)
    x, y = (part.ravel() for part in np.meshgrid(centres, centres, indexing="ij"))
    return x, y, np.full(n * n, (2 * half / n) ** 2)


def solution(plan, points, pressure, *, shape=None, force=None):
    x, y, weight = points
    fields = {"pressure_x": x, "pressure_y": y, "pressure": pressure, "pressure_weight": weight}
    if shape is not None:
        fields["pressure_shape"] = np.array(shape)
    whole = float(np.sum(pressure * weight)) if force is None else force
    curves = {"penetration": plan.loads.values, "force": whole}
    solution = Solution.of(task_of(plan, "bem_fft", 4), curves, violation=0.0)
    solution.fields.update(fields)
    return solution


def measures(plan, solved, method, resolution):
    truth = choose_truth(solved, "penetration", ("force",))
    result = field_measures(plan, solved, method, resolution, truth)
    return {name: (error, bar) for name, error, bar in result}


@pytest.fixture
def square(scene):
    return plan_scene(scene(indenter=SQUARE, compare=COMPARABLE))[0]


def test_a_ring_of_a_tenth_of_the_contact_radius_is_left_out_along_straight_sharp_edges(square):
    """Only the cells within 0.1 sqrt(4/pi) of the sides are spoilt: the difference is the 2 %."""
    x, y, weight = cells(40)
    smooth = 1 + 0.1 * x
    near = 1 - np.maximum(np.abs(x), np.abs(y)) < 0.1 * np.sqrt(4 / np.pi)
    solved = {
        ("bem_fft", 20): solution(square, (x, y, weight), smooth, shape=(40, 40)),
        ("fem", 4): solution(square, (x, y, weight), np.where(near, 9.0, 1.02) * smooth),
    }
    rows = measures(square, solved, "fem", 4)
    assert rows["pressure"][0] == pytest.approx(0.02, rel=1e-9)


def test_a_quarter_of_a_mesh_stands_for_the_whole(square):
    """The truth is known on nodes with x, y >= 0 only, the grid covers all four quarters."""
    x, y, weight = cells(12)
    node = np.linspace(0, 1, 13)
    node_x, node_y = (part.ravel() for part in np.meshgrid(node, node))
    solved = {
        ("fem", 8): solution(square, (node_x, node_y, np.full(169, 4 / 169)), 1 + node_x + node_y),
        ("fem", 4): solution(square, (node_x, node_y, np.full(169, 4 / 169)), 1 + node_x + node_y),
        ("bem_fft", 6): solution(
            square, (x, y, weight), 1.01 * (1 + np.abs(x) + np.abs(y)), shape=(12, 12)
        ),
    }
    truth = choose_truth(
        {k: v for k, v in solved.items() if k[0] == "fem"}, "penetration", ("force",)
    )
    result = field_measures(square, solved, "bem_fft", 6, truth)
    (error,) = [error for name, error, _ in result if name == "pressure"]
    assert error == pytest.approx(0.01, rel=1e-6)


def test_the_bar_is_the_change_from_the_next_coarser_grid(square):
    """1.25 times the change over r - 1: 2 % between N = 5 and N = 15 give 1.25 %."""
    x, y, weight = cells(30)
    coarse = cells(10)
    solved = {
        ("bem_fft", 15): solution(square, (x, y, weight), np.ones(900), shape=(30, 30)),
        ("bem_fft", 5): solution(square, coarse, np.full(100, 1.02), shape=(10, 10)),
        ("fem", 4): solution(square, coarse, np.full(100, 1.1)),
    }
    error, bar = measures(square, solved, "fem", 4)["pressure"]
    assert error == pytest.approx(0.1, rel=1e-9)
    assert bar == pytest.approx(1.25 * 0.02 / 2, rel=1e-9)
    del solved["bem_fft", 5]
    assert np.isnan(measures(square, solved, "fem", 4)["pressure"][1])


def test_a_coarse_solution_is_held_against_means_over_its_cells(square):
    """Errors that cancel over the cells of N = 5 leave the truth's own bar, and none of theirs.

    The truth's grid N = 10 changes by a checkerboard of 4 % to N = 20: 5 % for cells like its own,
    nothing for cells of four of them.
    """
    (x, y, weight), middle, coarse = cells(40), cells(20), cells(10)
    board = 1 + 0.04 * (1 - 2 * (np.indices((20, 20)).sum(axis=0) % 2)).ravel()
    solved = {
        ("bem_fft", 20): solution(square, (x, y, weight), np.ones(1600), shape=(40, 40)),
        ("bem_fft", 10): solution(square, middle, board, shape=(20, 20)),
        ("fem", 10): solution(square, middle, np.full(400, 1.1), shape=(20, 20)),
        ("fem", 5): solution(square, coarse, np.full(100, 1.1), shape=(10, 10)),
        ("fem", 20): solution(square, (x, y, weight), np.full(1600, 1.1), shape=(40, 40)),
    }
    grids = {key: value for key, value in solved.items() if key[0] == "bem_fft"}
    truth = choose_truth(grids, "penetration", ("force",))
    for resolution, bar in ((20, 1.25 * 0.04), (10, 0.0), (5, 0.0)):
        result = field_measures(square, solved, "fem", resolution, truth)
        ((_, error, own),) = [part for part in result if part[0] == "pressure"]
        assert error == pytest.approx(0.1, rel=1e-9)
        assert own == pytest.approx(bar, abs=1e-12)


def test_pressures_that_were_not_asked_for_or_not_found_are_not_compared(square):
    x, y, weight = cells(10)
    truth = solution(square, (x, y, weight), np.ones(100), shape=(10, 10))
    silent = solution(square, (x, y, weight), np.ones(100))
    silent.fields.clear()
    lost = solution(square, (x, y, weight), np.ones(100))
    lost.converged[0, -1] = False
    solved = {("bem_fft", 5): truth, ("fem", 4): silent, ("fem", 6): lost}
    assert measures(square, solved, "fem", 4) == {}
    assert measures(square, solved, "fem", 6) == {}
    # A truth without a pressure still leaves the integral.
    solved = {("bem_fft", 5): silent, ("fem", 4): truth}
    truth = choose_truth({("bem_fft", 5): silent}, "penetration", ("force",))
    result = field_measures(square, solved, "fem", 4, truth)
    assert [name for name, *_ in result] == ["pressure_integral"]


def test_points_where_a_rule_has_no_real_pressure_do_not_count(square):
    """(19.37) may have none: NaN, left out of the difference and of the integral."""
    x, y, weight = cells(10)
    p = np.ones(100)
    p[55] = np.nan
    solved = {
        ("bem_fft", 5): solution(square, (x, y, weight), np.ones(100), shape=(10, 10)),
        ("fem", 4): solution(square, (x, y, weight), p, force=4.0),
    }
    rows = measures(square, solved, "fem", 4)
    assert rows["pressure"][0] == pytest.approx(0)
    assert rows["pressure_integral"][0] == pytest.approx(-0.01)


@pytest.mark.parametrize("shape", ["cone", "cylinder"])
def test_a_cone_is_compared_away_from_its_tip_and_a_punch_from_its_edge(scene, shape):
    """The pressure is as arcosh(a/r) (Sneddon 1965), and as (a^2 - r^2)^(-1/2): exact elsewhere."""
    size = {"slope": 0.1} if shape == "cone" else {"radius": 1e-3}
    (plan,) = plan_scene(scene(indenter={"shape": shape, **size}, compare=COMPARABLE))
    depth, modulus = plan.loads.values[-1], plan.scene.effective_modulus
    exact = execute(task_of(plan, "closed_form", 1), 1)
    x = np.linspace(0.01, 0.99, 99)
    if shape == "cone":
        a = 2 / np.pi * depth / 0.1
        spoilt = np.where(x < 0.0999, 0.0, 0.05 * modulus * np.arccosh(1 / x))
    else:
        a = 1e-3
        spoilt = np.where(x > 0.9001, 0.0, modulus * depth / (np.pi * a * np.sqrt(1 - x**2)))
    weight = 2 * np.pi * x * 0.01 * a**2
    solved = {
        ("closed_form", 1): exact,
        ("fem", 4): solution(plan, (x * a, np.zeros(99), weight), spoilt),
    }
    rows = measures(plan, solved, "fem", 4)
    assert rows["pressure"] == (pytest.approx(0, abs=1e-9), 0.0)


ALL = ["pressure_distribution", "gap_distribution", "contact_sizes"]


@pytest.fixture
def patch(rough):
    """Return a maker of a small periodic ensemble, asked for all distributions."""

    def make(**compare):
        asked = {"quantities": ["contact_area", "contact_count", "mean_gap", *ALL]}
        surface = {"long_cutoff": "0.5 um", "periodic": True, "realisations": 3}
        force = {"values": [0.01, 0.03], "relative_to": "E* A0 h'"}
        return rough(loading={"force": force}, compare=asked | compare, **surface)

    return make


@pytest.mark.parametrize("method", ["bem_fft", "fem"])
def test_distributions_of_a_surface_add_up_to_its_area_force_and_contacts(patch, method):
    """Cells: the counted area, the force to the width of a bin, the number of contacts."""
    single = solve_scene(patch(), method, 16)
    curves, sums = single.solution.quantities, single.solution.distributions
    area, modulus = single.plan.geometry.area, single.plan.scene.effective_modulus
    assert sums["pressure_distribution"].shape[0] == 3
    counted = curves["contact_area_raw"][:, -1] / area
    np.testing.assert_allclose(sums["pressure_distribution"].sum(axis=-1), counted, rtol=1e-12)
    np.testing.assert_allclose(sums["gap_distribution"].sum(axis=-1), 1 - counted, rtol=1e-12)
    np.testing.assert_array_equal(
        sums["contact_sizes"].sum(axis=-1), curves["contact_count"][:, -1]
    )
    bins = edges("pressure_distribution", single.plan.scene, single.plan.geometry)
    force = sums["pressure_distribution"] @ np.sqrt(bins[1:] * bins[:-1]) * area
    np.testing.assert_allclose(force, curves["force"][:, -1], rtol=0.07)
    assert bins[0] < modulus * 0.1 < bins[-1]


def test_a_line_carries_its_force_and_area_and_is_open_by_its_mean_gap():
    """Whatever the shape of the line: the stretches integrate to what `press` sums."""
    heights = np.random.default_rng(3).normal(size=64).cumsum()
    for periodic in (True, False):
        line = RoughLines(heights - heights.mean(), 0.25, periodic)
        contact = press(line, 2.0, Load("penetration", 4.0))
        values = line_values(line, 2.0, "sub_cell", 4.0, (16.0, 16.0))
        pressure, gap, sizes = (values[name] for name in ALL)
        nominal = line.length**2
        ends = [np.maximum(side, 0) for side in (pressure.first, pressure.last)]
        # of a stretch cut by the rim only the part with positive pressure counts
        part = np.where(
            (pressure.first > 0) & (pressure.last > 0),
            1.0,
            (ends[0] + ends[1]) / np.abs(pressure.first - pressure.last + 1e-300),
        )
        mean = (ends[0] + ends[1]) / 2
        force = float(np.sum(pressure.weight * part * mean)) * nominal
        assert force == pytest.approx(contact.force[0, 0], rel=1e-9)
        area = float(np.sum(pressure.weight * part)) * nominal
        assert area == pytest.approx(contact.contact_area[0, 0], rel=1e-9)
        assert float(np.sum(sizes.first)) == pytest.approx(contact.contact_area[0, 0], rel=1e-12)
        bins = np.geomspace(1e-6, 100, 4000)
        open_by = histogram(bins, gap) @ np.sqrt(bins[1:] * bins[:-1])
        assert open_by == pytest.approx(contact.mean_gap[0, 0], rel=1e-4)


def test_a_straight_flank_has_a_constant_density():
    """Values spread evenly from -1 to 3: a quarter is not positive, the rest lies evenly."""
    bins = np.geomspace(1e-3, 10, 41)
    counts = histogram(bins, Stretches(np.array([-1.0]), np.array([3.0]), np.array([4.0])))
    assert counts.sum() == pytest.approx(3.0)
    inside = slice(1, np.searchsorted(bins, 3.0) - 1)
    np.testing.assert_allclose((counts / np.diff(bins))[inside], 1.0, rtol=1e-12)


def test_the_distance_is_the_mean_difference_of_values_of_equal_rank():
    """Twice the values: as far apart as their mean. Twice the number of values: no distance."""
    bins = np.geomspace(0.1, 100, 3001)
    values = np.random.default_rng(1).uniform(1, 3, 20000)
    first, second = (histogram(bins, Stretches.points(v)) for v in (values, 2 * values))
    assert distance(second, first, bins) == pytest.approx(1.0, rel=1e-3)
    assert distance(2 * first, first, bins) == 0.0
    assert np.isnan(distance(0 * first, first, bins))


@pytest.mark.slow
@pytest.mark.parametrize("scattered", ["bem_fft", "reduced"])
def test_the_bar_of_a_distribution_has_the_scatter_of_surfaces_and_of_lines(patch, scattered):
    """Of those that are alike there is none; n samples x_i of a mean by Student's t.

    Sizes c in one bin or the other: the distance from the mean is the share that moves, times the
    width of a bin over the mean of the sizes.
    """
    name = "contact_sizes"
    (plan,) = plan_scene(patch())
    bins = edges(name, plan.scene, plan.geometry)
    places = np.array([3, 4, 4, 3, 4])
    solved = {}
    for method, levels in (("bem_fft", (16, 32)), ("reduced", (64,))):
        own = places if method == scattered else np.full(5, 4)
        for n in levels:
            task = task_of(plan, method, n, tuple(range(5)))
            solved[method, n] = Solution.of(task, {"penetration": 1e-9, "force": 1.0})
            for row, place in enumerate(own):
                counts = np.eye(len(bins) - 1)[place]
                solved[method, n].put_distributions(row, {name: counts})
    truth = choose_truth(solved, plan.loads.axis, ("force",))
    assert truth.method == "bem_fft"
    ((_, _, bar),) = field_measures(plan, solved, "reduced", 64, truth)
    moved = (bins[5] - bins[3]) / 2  # of the middle of a bin to that of the next
    share = np.std(places, ddof=1) / np.sqrt(5)  # of a mean share
    alone = np.array([bins[k : k + 2].mean() for k in places]).mean()
    assert bar == pytest.approx(special.stdtrit(4, 0.975) * share * moved / alone, rel=1e-9)


def test_distributions_reach_json_tables_and_report(patch, tmp_path):
    """What is asked for is measured, judged, kept and drawn: for surfaces, lines and theories."""
    compare = {
        "methods": ["bem_fft", "reduced", "persson"],
        "tolerance": 0.5,
        "resolutions": [16, 32],
    }
    Study(patch(**compare), tmp_path / "out").run()
    record = load_study(tmp_path / "out").scenes[0]
    judged = {(v.method, v.quantity) for v in record.verdicts if v.word != "no result"}
    assert {("reduced", name) for name in ALL} <= judged
    theory = {("persson", f"{name}_distribution") for name in ("pressure", "gap")}
    assert theory <= judged
    assert set(record.distributions["method"]) == {"bem_fft", "reduced", "persson"}
    assert [figure.quantity for figure in distributions(record)] == sorted(ALL, key=len)
    document = json.loads(solve_scene(patch(), "reduced", 16).to_json())
    part = document["pressure_distribution"]
    assert len(part["low"]) == len(part["high"]) == len(part["amount"]) > 3


def test_an_indenter_has_no_distributions():
    changes = {"loading": {"force": [1.0]}, "compare.quantities": ["contact_sizes"]}
    with pytest.raises(SceneError, match=r"contact_sizes: expected an elastic, frictionless rough"):
        load_scene("paraboloid", changes)
