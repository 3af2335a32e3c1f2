"""Intervals that theorems give: bars held against them, and rough scenes between them."""

import json
import os
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from threadpoolctl import threadpool_info

import roughline
from comparisons.errors import InputError
from comparisons.judging import truth as judging
from comparisons.judging.truth import Truth
from comparisons.methods.normal import proved
from comparisons.methods.normal.proved import enclosures
from comparisons.questions import single
from comparisons.questions.single import solve_scene
from comparisons.results.record import StudyRecord
from comparisons.results.recording import record_scene
from comparisons.results.rows import Rows
from comparisons.scene.scene import load_scene, make_scene
from comparisons.solving.execution import execute
from comparisons.solving.plan import task_of
from comparisons.solving.planning import plan_scene
from reference import closed_form
from reference.bounds.interval import Interval, inverse
from reports.plots.curves import PROVED, curve
from roughline.commands.terminal import print_study

BALL = {
    "name": "ball",
    "half_space": {"effective_modulus": "1 GPa"},
    "indenter": {"shape": "paraboloid", "radius": "1 mm"},
    "loading": {"penetration": ["1 um", "2 um"]},
    "compare": {
        "quantities": ["force", "penetration", "stiffness", "energy"],
        "methods": ["bem_fft"],
        "resolutions": [8, 16, 32],
        "proved": True,
    },
}


def recorded():
    """Return what a grid finds without the closed form, which would be the reference."""
    (plan,) = plan_scene(make_scene(BALL, "ball", Path()))
    levels = BALL["compare"]["resolutions"]
    solved = {("bem_fft", n): execute(task_of(plan, "bem_fft", n), 1) for n in levels}
    return record_scene(plan, solved)


SPHERE = {"indenter": {"shape": "sphere", "radius": "1 mm"}}
OVAL = {"indenter": {"shape": "elliptic_punch", "semi_axes": ["1 mm", "2 mm"]}}


@pytest.mark.parametrize(
    ("tables", "exact", "width"),
    [
        ({}, closed_form.paraboloid(1e-3, 1e9), 2e-5),
        ({"loading": {"force": ["1 N", "2 N"]}}, closed_form.paraboloid(1e-3, 1e9), 2e-5),
        # with a length of its own: up to a/R = 0.5 (Sneddon 1965)
        (SPHERE | {"loading": {"force": [1.2, 120.0]}}, closed_form.sphere(1e-3, 1e9), 3e-4),
        # it moves all of the face by the same: admitted to both programmes, so exact but rounding
        (OVAL, None, 1e-12),
    ],
)
def test_what_is_exact_lies_between_the_sides_that_a_solve_writes(tables, exact, width):
    """Of a prescribed penetration the force is enclosed, of a force the penetration."""
    result = solve_scene({**BALL, **tables}, "closed_form")
    document = {name: np.array(values) for name, values in json.loads(result.to_json()).items()}
    free = {"force", "penetration", "stiffness", "energy"} - {result.plan.loads.control}
    assert {name for name in document if name.endswith("_lower")} == {f"{n}_lower" for n in free}
    for name in free:
        value, lower, upper = (document[f"{name}{side}"] for side in ("", "_lower", "_upper"))
        if exact is not None:
            depth = exact.penetration(document["force"])
            value = depth if name == "penetration" else getattr(exact, name)(depth)
        rounding = 1e-14 * value  # the depth is found from a force
        assert (lower <= value + rounding).all()
        assert (value - rounding <= upper).all()
        # an energy is about the product of force and penetration
        assert (upper / lower - 1 < (2 * width if name == "energy" else width)).all()


def test_nothing_is_proved_before_somebody_reads_it(monkeypatch):
    """A loop over solves that reads their forces does not pay for bounds."""
    asked = []
    monkeypatch.setattr(single, "enclosures_asked_for", lambda *of: asked.append(of) or {})
    result = roughline.solve("paraboloid", "closed_form")
    assert result["force"].size
    assert "force" in repr(result)
    assert not asked
    assert len(result.table()) > 1
    assert len(asked) == 1


def test_bounds_are_computed_on_one_thread(monkeypatch):
    """Threads that wait for each other cost minutes on a machine that is busy otherwise."""
    threads = []
    monkeypatch.setattr(
        proved,
        "_known",
        lambda *_: threads.extend(pool["num_threads"] for pool in threadpool_info()),
    )
    (plan,) = plan_scene(make_scene(BALL, "ball", Path()))
    proved.enclosures(plan.scene, plan.geometry, plan.loads)
    assert set(threads) == {1}


def test_a_ball_may_be_pressed_deeper_than_anything_is_proved():
    """Built-in contacts ask for what is proved if there is any: of a ball up to its radius."""
    result = solve_scene("sphere", "reduced", 10, overrides={"loading": {"penetration": ["15 mm"]}})
    assert result.converged
    assert not any(name.endswith("_lower") for name in result.columns())


# No place sees all of its sides.
HORSESHOE = [[0, 0], [5, 0], [5, 5], [4, 5], [4, 1], [1, 1], [1, 5], [0, 5]]


@pytest.mark.slow
def test_a_face_of_which_no_place_sees_all_lies_between_parts_of_it_and_its_hull():
    """The square that holds it is 5 m wide: 1.1523 x 5; its area, 13 m^2, is that of a circle."""
    columns = solve_scene(
        {**BALL, "indenter": {"shape": "polygon_punch", "vertices": HORSESHOE}}, "bem_fft", 16
    ).columns()
    assert (columns["stiffness_lower"] < columns["stiffness"]).all()
    assert (columns["stiffness"] < columns["stiffness_upper"]).all()
    np.testing.assert_allclose(columns["stiffness_upper"], 1.1523 * 5e9, rtol=2e-3)
    np.testing.assert_allclose(columns["stiffness_lower"], 2e9 * np.sqrt(13 / np.pi), rtol=1e-9)


def test_a_report_draws_the_interval_and_says_which_bars_miss_it(monkeypatch):
    record = recorded()
    assert record.disagreements == ()
    sides = record.rows["force_lower"][record.rows["resolution"] == 32]
    assert np.isfinite(sides).all()
    # force, stiffness and energy of two load steps; what it took, and what the truth took
    proved = record.reference.proved
    assert (proved.bars, proved.missed) == (6, 0)
    assert 0 < proved.width < 2e-5
    assert min(proved.seconds, proved.truth_seconds) > 0
    figure = curve(record, "penetration", "force")
    assert figure is not None
    assert PROVED in [band.label for band in figure.bands]
    assert "every bar of a reference reaches it" in figure.caption
    # a theorem about another ball: no bar reaches its interval
    monkeypatch.setattr(judging, "missed_by", lambda value, *_: np.full(len(value), 0.01))
    record = recorded()
    assert any("misses the proved interval by 1" in text for text in record.disagreements)
    assert "6 of 6 bars miss it" in curve(record, "penetration", "force").caption
    # another scene of the same study, of which nothing is proved, has the columns, too
    columns = {name: np.nan for name in record.rows if name.endswith(("_lower", "_upper"))}
    rows = Rows.of(record.rows.frame().assign(**columns))
    other = replace(record, rows=rows, reference=replace(record.reference, proved=None))
    figure = curve(other, "penetration", "force")
    assert PROVED not in [band.label for band in figure.bands]
    assert "theorem" not in figure.caption


def test_every_reference_is_held_against_the_interval_not_only_the_best(monkeypatch):
    assert roughline.compare(BALL).record.reference.proved.bars == 12
    # bars that are a thousandth of what they are: the grid's miss, the closed form's do not
    narrow = Truth.bar
    monkeypatch.setattr(Truth, "bar", lambda self, *at, **kind: 1e-3 * narrow(self, *at, **kind))
    record = roughline.compare(BALL).record
    assert record.reference.method == "closed_form"
    missed = [text for text in record.disagreements if "misses the proved interval" in text]
    # a sentence for each of three quantities, whose bars miss at both loads
    assert (len(missed), record.reference.proved.missed) == (3, 6)
    assert all("bem_fft 32" in text for text in missed)


def test_an_interval_is_a_tenth_of_the_tolerance_and_narrower_for_a_sharper_one():
    widths = []
    for tolerance in (0.01, 0.002):
        scene = {**BALL, "compare": {**BALL["compare"], "tolerance": tolerance}}
        columns = solve_scene(scene, "closed_form").columns()
        widths.append((columns["force_upper"] / columns["force_lower"] - 1).max())
    # the third power of the cells, of which there are as many more as the tolerance's third root
    assert widths[0] < 1e-3
    assert 3 < widths[0] / widths[1] < 8


def test_a_notebook_says_what_is_proved_and_has_the_sides():
    comparison = roughline.compare("cylinder", "closed_form", "reduced", quantities=["force"])
    assert "lies by theorem" in comparison.proved
    assert comparison.proved in repr(comparison)
    assert "lies by theorem" in comparison._repr_html_()
    steps = comparison.steps()
    sides = steps.loc[steps["method"] == "closed_form", ["force_lower", "force", "force_upper"]]
    assert (np.diff(sides.to_numpy(dtype=float), axis=1) >= 0).all()


@pytest.mark.slow
@pytest.mark.skipif("ROUGHLINE_QUICK" not in os.environ, reason="needs a finished quick suite")
def test_no_bar_of_the_quick_suite_misses_what_is_proved(quick_suite):
    """Each of them is a theorem's word against an estimate: a miss is a defect."""
    proved = {s.name: s.reference.proved for s in quick_suite.values() if s.reference.proved}
    # eleven single contacts, each of some quantities at some load steps
    assert len(proved) >= 11
    assert sum(item.bars for item in proved.values()) >= 600
    assert [name for name, item in proved.items() if item.missed] == []


def test_a_run_counts_the_bars_that_are_held_against_theorems(capsys):
    record = recorded()
    header = {"created": "", "command": "", "effort": "quick", "machine": {}, "versions": {}}
    print_study(StudyRecord(seconds=1.0, scenes=(record, record), **header), [])
    said = " ".join(capsys.readouterr().out.split())
    assert "references of 2 scenes are held against theorems; no bar misses" in said


BLOCK = Path(__file__).parents[3] / "docs" / "examples" / "block.toml"
FORCE = {"force": {"values": [0.05], "relative_to": "E* A0 h'"}}


@pytest.fixture
def small(rough):
    asked = {"quantities": ["force", "penetration", "energy", "stiffness"], "proved": True}
    return partial(rough, compare=asked | {"tolerance": 0.05}, points=4, short_cutoff="0.5 um")


@pytest.mark.slow
@pytest.mark.parametrize(("periodic", "width"), [(False, 0.2), (True, 0.15)])
def test_penetration_at_a_force_and_force_at_that_penetration_are_enclosed(small, periodic, width):
    """The half-space on 64 x 64 cells lies between bounds on 32 x 32.

    Four points a side are few: the bounds of the free patch are wide at its rim.
    """

    def solved(loading):
        """Solve on cells that are finer than those of the bounds."""
        return solve_scene(small(periodic=periodic, loading=loading), "bem_fft", 64).columns()

    columns = solved(FORCE)
    depth = columns["penetration"]
    assert columns["penetration_lower"] < depth < columns["penetration_upper"]
    assert columns["penetration_upper"] / columns["penetration_lower"] - 1 < width
    assert "force_lower" not in columns
    for name in ("energy", "stiffness"):
        assert columns[f"{name}_lower"] < columns[name] < columns[f"{name}_upper"]
    again = solved({"penetration": list(depth)})
    assert again["force_lower"] < columns["force"] < again["force_upper"]
    assert again["force_upper"] / again["force_lower"] - 1 < 2.5 * width
    assert again["energy_lower"] < columns["energy"] < again["energy_upper"]
    assert again["stiffness_lower"] < columns["stiffness"] < again["stiffness_upper"]


@pytest.mark.slow
def test_a_load_at_which_nothing_is_proved_leaves_the_others_theirs(small):
    """Cells of a period prove nothing of a contact far smaller than they are: NaN, no traceback."""
    loads = {"penetration": ["1e-15 m", "10 nm"]}
    (plan,) = plan_scene(small(periodic=True, loading=loads))
    sides = enclosures(plan.scene, plan.geometry, plan.loads)
    assert np.isnan([sides["force_lower"][0], sides["force_upper"][0]]).all()
    assert 0 < sides["force_lower"][1] < sides["force_upper"][1]


class Sampled:
    """Bounds without width, which hand back depth, load and pressure as they are asked for them."""

    top = 0.0

    def __init__(self, *_):
        pass

    def mean_pressure(self, depth, _):
        return Interval(depth, depth)

    force = mean_pressure

    def penetration(self, load, _):
        return Interval(load, load)

    def stored(self, mean, depth, _):
        return depth

    def energy(self, depth, _):
        return depth

    def stiffness(self, *arguments):
        return arguments[0]  # the mean pressure of a period, the depth of a patch


@pytest.mark.parametrize("periodic", [False, True])
def test_depths_of_bounds_count_from_their_highest_sample(small, periodic, monkeypatch):
    """Of the scene from the top of the surface, which lies above it."""
    (plan,) = plan_scene(small(periodic=periodic, loading=FORCE))
    higher, area = 2e-9, plan.geometry.area
    highest = plan.geometry.top(0) - plan.geometry.heights(0, 4).mean()
    monkeypatch.setattr(Sampled, "top", highest - higher)
    monkeypatch.setattr(proved, "PeriodicSurface" if periodic else "Patch", Sampled)
    proof = proved.proof_of(plan.scene, plan.geometry)
    per = area if periodic else 1.0
    deep = proof.force(5e-9)
    np.testing.assert_allclose((deep.lower / per, deep.upper / per), 3e-9, rtol=1e-6)
    # what is short of the sample is not proved to touch, and bears less than what touches deeper
    short = proof.force(1e-9)
    assert (short.lower, short.upper / per) == (0.0, pytest.approx(1e-9, rel=1e-6))
    back = proof.penetration(3e-9 * per)
    np.testing.assert_allclose((back.lower, back.upper), 5e-9, rtol=1e-6)
    depth, load = Interval(5e-9, 6e-9), Interval(3e-9 * area, 4e-9 * area)
    energy = proof.energy(depth, load)
    np.testing.assert_allclose((energy.lower / per, energy.upper / per), (3e-9, 4e-9), rtol=1e-6)
    stiffness = proof.stiffness(depth, load)
    np.testing.assert_allclose(stiffness.lower / per, 3e-9, rtol=1e-6)
    for quantity in (proof.energy, proof.stiffness):
        with pytest.raises(ArithmeticError, match="not proved to touch"):
            quantity(Interval(1e-9, 6e-9), load)


def test_an_energy_that_underflows_is_not_enclosed():
    """Of 1e-300 N: d is 1e-203 m, and F d is no double-precision number."""
    (plan,) = plan_scene(load_scene("paraboloid", {"loading": {"force": ["1e-300 N", "1 N"]}}))
    sides = enclosures(plan.scene, plan.geometry, plan.loads)
    assert np.isnan([sides["energy_lower"][0], sides["energy_upper"][0]]).all()
    assert 0 < sides["penetration_lower"][0] < sides["penetration_upper"][0] < 1e-200
    assert 0 < sides["energy_lower"][1] < sides["energy_upper"][1]


def indented(shape, **keys):
    return {"indenter": {"shape": shape, **keys}}


SOFT_SPHERE = indented("sphere", radius="1 mm") | {"half_space": {"effective_modulus": "1 GPa"}}


@pytest.mark.parametrize(
    ("scene", "changes", "reason"),
    [
        ("rough-free", {}, "one surface, .* the mean over 20000: surface.realisations = 1"),
        ("measured-map", {}, "a measured patch goes on between its points by splines"),
        ("rough-patch", {"surface.points": [60, 64]}, "of a free patch are for square ones"),
        ("rough-patch", {"surface.points": 256}, "more than 128 points a side .* minutes a load"),
        (
            "rough-patch",
            {"surface.periodic": True, "loading": {"penetration": ["1 um"]}},
            "up to a penetration of",
        ),
        ("rough-patch", {"loading": {"mean_gap": ["10 nm"]}}, "nothing .* prescribed mean_gap"),
        ("adhesive-ball", {}, "without friction, adhesion or memory"),
        ("friction-steel", {}, "without friction, adhesion or memory"),
        ("rubber-ball", {}, "without friction, adhesion or memory"),
        (BLOCK, {}, r"for a half-space, and the \[body\] is finite"),
        ("paraboloid", indented("profile", r=[0, 1e-3], f=[0, 1e-4]), "no bound"),
        ("paraboloid", indented("power_law", exponent=0.5, coefficient=0.1), "convex"),
        (
            "paraboloid",
            indented("ellipsoid", radius_x="1 mm", radius_y="1 m"),
            "the contact is 67.9 times as long as wide, .* ratios up to 60",
        ),
        (
            "paraboloid",
            indented("rectangle_punch", sides=["1 mm", "31 mm"]),
            "the face is 31 times as long as wide, .* ratios up to 30",
        ),
        (
            "paraboloid",
            SOFT_SPHERE | {"loading": {"penetration": ["1.5 mm"]}},
            r"up to a penetration of 1.00\smm",
        ),
        (
            "paraboloid",
            SOFT_SPHERE | {"loading": {"force": ["5 kN"]}},
            r"up to a force of 1.20\skN, and the largest is 5.00\skN",
        ),
    ],
)
def test_scenes_of_which_nothing_is_proved_are_refused_in_words(scene, changes, reason):
    with pytest.raises(InputError, match=f"compare.proved: .*{reason}"):
        plan_scene(load_scene(scene, changes | {"compare.proved": True}))


def test_an_argument_is_enclosed_by_what_was_tried_and_nothing_else():
    """Bounds of x^3 with kinks: inside; no upper end is claimed where none was reached."""

    def lower(x):
        return 0.98 * x**3 - (0.05 if x > 1.97 else 0.0)

    for guess in (0.1, 1.0, 2.0, 30.0):
        found = inverse(8.0, lower, lambda x: 1.03 * x**3, guess)
        assert 2.0 in found
        assert found.width < 0.03
    with pytest.raises(ArithmeticError, match="nothing is proved that reaches 8"):
        inverse(8.0, lambda x: min(lower(x), 7.0), lambda x: x**3, 1.0)
