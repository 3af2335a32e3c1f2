"""Distributions over a rough contact: sums, ends, distances, and their way into the results."""

import json

import numpy as np
import pytest

from comparisons.judging.fields import distance
from comparisons.methods.normal.reduced_lines import line_values
from comparisons.questions.single import solve_scene
from comparisons.results.store import load_study
from comparisons.scene.scene import SceneError, load_scene
from comparisons.tasks.distributions import Stretches, edges, histogram
from reduced.loads import Load
from reduced.rough.press import RoughLines, press
from reports.plots.surfaces import distributions
from roughline import Study

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
    scene = {
        "name": "ball",
        "half_space": {"effective_modulus": "1 GPa"},
        "indenter": {"shape": "paraboloid", "radius": "1 mm"},
        "loading": {"force": [1.0]},
        "compare": {"quantities": ["contact_sizes"]},
    }
    with pytest.raises(SceneError, match=r"contact_sizes: expected an elastic, frictionless rough"):
        load_scene(scene)
