"""Bars held against intervals that theorems give."""

import json
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from threadpoolctl import threadpool_info

import roughline
from comparisons.judging import truth as judging
from comparisons.judging.truth import Truth
from comparisons.methods.normal import proved
from comparisons.questions import single
from comparisons.questions.single import solve_scene
from comparisons.results.record import StudyRecord
from comparisons.results.rows import Rows
from comparisons.results.scene_record import record_scene
from comparisons.scene.scene import make_scene
from comparisons.solving.execution import execute
from comparisons.solving.plan import task_of
from comparisons.solving.planning import plan_scene
from reference import closed_form
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
    scene = {**BALL, "compare": {**BALL["compare"], "methods": ["bem_fft", "closed_form"]}}
    (plan,) = plan_scene(make_scene(scene, "ball", Path()))
    grids = {("bem_fft", n): execute(task_of(plan, "bem_fft", n), 1) for n in (8, 16, 32)}
    solved = {("closed_form", 1): execute(task_of(plan, "closed_form", 1), 1), **grids}
    assert record_scene(plan, solved).reference.proved.bars == 12
    # bars that are a thousandth of what they are: the grid's miss, the closed form's do not
    narrow = Truth.bar
    monkeypatch.setattr(Truth, "bar", lambda self, *at, **kind: 1e-3 * narrow(self, *at, **kind))
    record = record_scene(plan, solved)
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
