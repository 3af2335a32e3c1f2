"""Two runs compared: what moved, what was lost, what became slower; planted one by one."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from comparisons.judging.truth import Reference
from comparisons.judging.verdicts import Verdict
from comparisons.results.record import SceneRecord, StudyRecord
from comparisons.results.rows import Rows
from comparisons.results.run_comparison import (
    CHANGED,
    LOST,
    ONE_SIDED,
    RECOVERED,
    SAME,
    SLOW,
    VERDICT,
    compare_runs,
)
from comparisons.solving.plan import PlanRecord
from reports.pages.runs import before_and_after

DEPTHS = np.array([1e-6, 2e-6, 4e-6])


def study(tmp_path, *, factor=1.0, seconds=0.1, verdict="within", converged=True, **more):
    """One scene, two methods; what is asked for is done to method `reduced`."""
    rows = [
        {
            "scene": "ball",
            "method": method,
            "resolution": resolution,
            "realisation": "0",
            "step": step,
            "penetration": depth,
            "force": depth**1.5 * (factor if method == "reduced" else 1.0),
            "seconds": seconds if method == "reduced" else 1.0,
            "converged": converged if method == "reduced" else True,
            "reason": "" if converged else "ran away",
        }
        for method, resolution in (("reduced", 40), ("bem_fft", 20))
        for step, depth in enumerate(DEPTHS)
    ]
    setting = {"method": "reduced", "resolution": 40, "tolerance": 0.01}
    judged = Verdict(quantity="force", at="penetration", word=verdict, error=0.002, **setting)
    scene = SceneRecord(
        name="ball",
        title="Ball",
        text="",
        control="penetration",
        quantities=("force", "penetration"),
        tolerance=0.01,
        plan=PlanRecord(),
        reference=Reference("bem_fft", 20, ""),
        verdicts=(judged,),
        disagreements=(),
        rows=Rows.of(pd.DataFrame(rows)),
    )
    header = {
        "created": "2026-01-01T00:00:00+00:00",
        "command": "roughline run",
        "effort": "quick",
        "seconds": 1.0,
        "machine": {"processor": "one"},
        "versions": {"numpy": "2.0"},
    }
    return StudyRecord(**header | more, scenes=(scene,), directory=tmp_path)


def reduced_change(before, after, **more):
    result = {change.method: change for change in compare_runs(before, after, **more).changes}
    assert list(result["bem_fft"].kinds) == [SAME]
    return result["reduced"]


@pytest.mark.parametrize(
    ("factor", "moved", "more"),
    # the last by the user's own threshold
    [
        *((1 + 1e-4, True, {}), (1 - 1e-4, True, {}), (1 + 1e-7, False, {})),
        (1.001, False, {"moved": 0.01}),
    ],
)
def test_a_moved_force_is_found_with_its_sign(tmp_path, factor, moved, more):
    change = reduced_change(study(tmp_path), study(tmp_path, factor=factor), **more)
    assert list(change.kinds) == [CHANGED if moved else SAME]
    assert change.quantity == "force"
    assert change.change == pytest.approx(factor - 1, rel=1e-6)  # the difference of two roundings


@pytest.mark.parametrize(
    ("before", "after", "kind", "text", "bad"),
    [
        ({}, {"converged": False}, LOST, "3 of 3 answers lost: ran away", True),
        ({"converged": False}, {}, RECOVERED, "3 lost answers recovered", False),
        ({}, {"factor": np.nan}, LOST, "no value of force any more", True),
        ({"factor": np.nan}, {}, SAME, "same", False),
        (
            *({}, {"verdict": "outside"}, VERDICT),
            *("force at equal penetration was within, is outside", True),
        ),
        # a time alone is no worse answer; one that is too short to read is not judged
        ({}, {"seconds": 0.2}, SLOW, "took longer: 100\u202fms before, 200\u202fms after", False),
        ({"seconds": 0.14}, {"seconds": 1.4e-3}, SAME, "same", False),
    ],
)
def test_a_change_of_each_kind_is_told_and_lost_answers_and_verdicts_are_bad(
    tmp_path, before, after, kind, text, bad
):
    change = reduced_change(study(tmp_path, **before), study(tmp_path, **after))
    assert (change.kinds, change.text, change.bad) == ({kind: text}, text, bad)
    assert change.only_timed == (kind == SLOW)


def test_times_are_told_on_one_machine_only(tmp_path):
    elsewhere = study(tmp_path, seconds=0.2, machine={"processor": "another"})
    record = compare_runs(study(tmp_path), elsewhere)
    assert not record.failed
    assert any("machines differ" in note for note in record.notes)


def test_plots_of_two_runs_tell_a_time_once_and_have_few_ticks_of_one_unit(tmp_path):
    slow = study(tmp_path, seconds=0.2)
    tiny = replace(slow.scenes[0], verdicts=(replace(slow.scenes[0].verdicts[0], error=2e-12),))
    plots = before_and_after(
        compare_runs(study(tmp_path), slow.model_copy(update={"scenes": (tiny,)})).changes
    )
    errors, times = plots
    (hover,) = [text for series in times.series for text in series.hover or () if "educed" in text]
    assert hover.endswith("100\u202fms before, 200\u202fms after; took longer")
    assert all(label.endswith("%") for _, label in errors.y.ticks)
    assert 2 <= len(errors.x.ticks) <= 5


def test_a_scene_that_was_only_laid_out_differently_is_the_same(tmp_path):
    """One line or five: what the text says is compared, so that writers of TOML may change."""
    runs = [study(tmp_path) for _ in range(2)]
    texts = "[loading]\nforce = [1.0, 2.0]\n", "[loading]\nforce = [\n  1.0,\n  2.0,\n]\n"
    laid_out = [
        run.model_copy(update={"scenes": (replace(run.scenes[0], text=text),)})
        for run, text in zip(runs, texts, strict=True)
    ]
    assert compare_runs(*laid_out).notes == ()


def scene_with(run, text, depths=DEPTHS, **more):
    """Return a run of the scene that a text says, at some of its penetrations."""
    (scene,) = run.scenes
    steps = {
        float(step): float(k) for k, step in enumerate(np.flatnonzero(np.isin(DEPTHS, depths)))
    }
    rows = scene.rows.where(np.isin(scene.rows["step"], list(steps))).frame()
    rows = Rows.of(rows.assign(step=rows["step"].map(steps)))
    return run.model_copy(update={"scenes": (replace(scene, text=text, rows=rows, **more),)})


def test_loads_are_matched_by_value_and_what_differs_is_named(tmp_path):
    """Three penetrations, then the last alone: the input has changed, the answers have not."""
    text = "[loading.penetration]\nvalues = [{}]\n[indenter]\nradius = {}\n"
    before = scene_with(study(tmp_path), text.format("1e-6, 2e-6, 4e-6", 0.1))
    told = {"verdict": "outside", "seconds": 9.0}
    after = study(tmp_path, **told)
    after = scene_with(after, text.format("4e-6", 0.1), DEPTHS[2:], tolerance=0.05)
    record = compare_runs(before, after)
    assert [note.replace("\u202f", " ") for note in record.notes] == [
        "ball: the scene differs (plain numbers are SI): loading.penetration: 1, 2, 4 µm → 4 µm; "
        "compare.tolerance: 1 % → 5 %",
        "ball: compared at 4 µm alone, the only step in both; verdicts and times, which cover all "
        "steps, are left out",
    ]
    assert [list(change.kinds) for change in record.changes] == [[SAME]] * 2
    stiffer = scene_with(study(tmp_path, factor=1.1), text.format("4e-6", 0.2), DEPTHS[2:])
    (moved,) = compare_runs(before, stiffer).failed
    assert moved.moves == {"force": pytest.approx(0.1)}
    assert "indenter.radius: 0.1 → 0.2" in compare_runs(before, stiffer).notes[0]


def test_what_all_solves_of_a_scene_do_alike_is_told_once(tmp_path):
    """A ball of another radius, R^(1/2) in every force: no method has changed."""
    text = "name = 'ball'\n[half_space]\neffective_modulus = 1e9\n[indenter]\n"
    text += "shape = 'paraboloid'\nradius = {}\n[loading]\npenetration = [1e-6, 2e-6, 4e-6]\n"
    before = scene_with(study(tmp_path), text.format(0.010))
    table = before.scenes[0].rows.frame()
    scaled = table.assign(force=table["force"] * np.sqrt(1.44))
    (scene,) = scene_with(before, text.format(0.0144)).scenes
    after = before.model_copy(update={"scenes": (replace(scene, rows=Rows.of(scaled)),)})
    record = compare_runs(before, after)
    said = {name: told.replace("\u202f", " ") for name, told in record.alike.items()}
    assert said == {"ball": "ball: in all 2 solves force moved by +20 %"}
    (note,) = (note.replace("\u202f", " ") for note in record.notes)
    assert note.endswith("indenter.radius: 10 mm → 14.4 mm")
    assert len(record.failed) == 2
    errors = {change.errors_of for change in record.changes if change.method == "reduced"}
    assert errors == {("force", "force")}
    assert compare_runs(before, scene_with(study(tmp_path, factor=1.2), text)).alike == {}


@pytest.mark.parametrize("more", [{"control": "force"}, {}])
def test_without_a_common_load_nothing_is_compared(tmp_path, more):
    first = scene_with(study(tmp_path), "loading.penetration = 1e-6", DEPTHS[:1])
    second = scene_with(study(tmp_path), "loading.penetration = 4e-6", DEPTHS[2:], **more)
    record = compare_runs(first, second)
    assert record.notes[-1] == "ball: no load is common to both runs, so that nothing is compared"
    assert record.changes == record.compared == ()
    assert record.sentence == "Nothing in both runs can be compared"


@pytest.mark.parametrize(("factor", "moved"), [(1.005, False), (1.02, True)])
def test_small_moves_of_another_grid_do_not_count(tmp_path, factor, moved, monkeypatch):
    """N is of the largest load, and the scene asks for 1 %."""
    text = "loading.penetration = [{}]"
    before = scene_with(study(tmp_path), text.format("1e-6, 2e-6, 4e-6"))
    after = scene_with(study(tmp_path, factor=factor), text.format("1e-6, 2e-6"), DEPTHS[:2])
    assert (CHANGED in reduced_change(before, after).kinds) == moved
    assert "N is of the largest load" in compare_runs(before, after).notes[-1]
    monkeypatch.setattr("comparisons.results.run_comparison.CLOSED_FORM", "reduced")
    assert reduced_change(before, after).bad  # without a grid every move counts


def test_paths_are_compared_until_they_part(tmp_path):
    """A path meets a load twice, and what it finds there depends on where it comes from."""
    text, path = "loading.penetration = [{}]", {"axis": "step"}
    first = scene_with(study(tmp_path), text.format("1e-6, 2e-6, 4e-6"), **path)
    second = scene_with(study(tmp_path, factor=1.1), text.format("1e-6, 4e-6"), DEPTHS[::2], **path)
    (moved,) = compare_runs(first, second).failed
    assert "compared at 1 µm alone" in compare_runs(first, second).notes[-1].replace("\u202f", " ")
    assert moved.moves == {"force": pytest.approx(0.1)}


def test_the_only_scenes_of_two_runs_are_compared_whatever_their_names(tmp_path):
    (scene,) = study(tmp_path, factor=1.1).scenes
    rows = Rows.of(scene.rows.frame().assign(scene="egg"))
    renamed = study(tmp_path).model_copy(
        update={"scenes": (replace(scene, name="egg", rows=rows),)}
    )
    record = compare_runs(study(tmp_path), renamed)
    assert record.notes == ("the scene is called ball in the first run and egg in the second",)
    assert [(change.scene, change.method) for change in record.failed] == [("ball", "reduced")]


def test_one_sentence_counts_the_solves_of_both_runs(tmp_path):
    """Times are no change of an answer."""
    other = replace(study(tmp_path).scenes[0], name="cone")
    before = study(tmp_path)
    after = study(tmp_path, seconds=9.0).model_copy(
        update={"scenes": (*study(tmp_path).scenes, other)}
    )
    assert compare_runs(before, after).sentence == (
        "None of 2 solves in both runs changed an answer or a verdict; 2 more are in one run only"
    )
    moved = compare_runs(before, study(tmp_path, factor=2.0, seconds=9.0))
    assert moved.sentence == "1 of 2 solves in both runs changed an answer or a verdict"


def test_versions_scenes_and_truths_that_differ_are_named(tmp_path):
    before, after = study(tmp_path), study(tmp_path, versions={"numpy": "3.0"})
    known = replace(before.scenes[0], disagreements=("A and B differ.", "A and C differ."))
    scene = replace(after.scenes[0], text="other", reference=Reference("fem", 6, ""))
    scene = replace(scene, disagreements=("A and C differ.", "B and C differ."))
    other = replace(after.scenes[0], name="cone")
    record = compare_runs(
        before.model_copy(update={"scenes": (known,)}),
        after.model_copy(update={"scenes": (scene, other)}),
    )
    assert record.notes == (
        "numpy: 2.0 before, 3.0 after",
        "ball: the scene differs (plain numbers are SI): text: not given → 'other'",
        "ball: the reference was bem_fft 20, now fem 6",
        "ball: B and C differ.",
        "cone: in the second run only",
    )
    assert [list(c.kinds) for c in record.changes if c.scene == "cone"] == [[ONE_SIDED]] * 2
