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
from comparisons.solving.plan_record import PlanRecord

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
        answer="",
        disagreements=(),
        rows=Rows.of(pd.DataFrame(rows)),
    )
    told = {"machine": {"processor": "one"}, "versions": {"numpy": "2.0"}} | more
    when = ("2026-01-01T00:00:00+00:00", "roughline run", "quick", 1.0)
    return StudyRecord(*when, **told, scenes=(scene,), directory=tmp_path)


def reduced_change(before, after, **more):
    result = {change.method: change for change in compare_runs(before, after, **more).changes}
    assert result["bem_fft"].kinds == (SAME,)
    return result["reduced"]


def test_a_run_against_itself_is_the_same(tmp_path):
    record = compare_runs(study(tmp_path), study(tmp_path))
    assert [change.kinds for change in record.changes] == [(SAME,), (SAME,)]
    assert record.notes == ()
    assert not record.failed


@pytest.mark.parametrize(
    ("factor", "moved"), [(1 + 1e-4, True), (1 - 1e-4, True), (1 + 1e-7, False)]
)
def test_a_moved_force_is_found_with_its_sign(tmp_path, factor, moved):
    change = reduced_change(study(tmp_path), study(tmp_path, factor=factor))
    assert (CHANGED in change.kinds) == moved
    assert change.quantity == "force"
    assert change.change == pytest.approx(factor - 1, rel=1e-6)  # the difference of two roundings


def test_the_threshold_of_a_move_is_the_users(tmp_path):
    far = reduced_change(study(tmp_path), study(tmp_path, factor=1.001), moved=0.01)
    assert far.kinds == (SAME,)


def test_lost_answers_are_bad_and_found_ones_are_not(tmp_path):
    gone = reduced_change(study(tmp_path), study(tmp_path, converged=False))
    assert gone.bad
    assert "3 of 3 answers lost: ran away" in gone.text
    assert LOST in gone.kinds
    back = reduced_change(study(tmp_path, converged=False), study(tmp_path))
    assert RECOVERED in back.kinds
    assert not back.bad


def test_a_quantity_without_its_value_is_lost(tmp_path):
    change = reduced_change(study(tmp_path), study(tmp_path, factor=np.nan))
    assert LOST in change.kinds
    assert change.text == "no value of force any more"
    assert not reduced_change(study(tmp_path, factor=np.nan), study(tmp_path)).bad


def test_a_verdict_that_changes_is_told_with_both_words(tmp_path):
    change = reduced_change(study(tmp_path), study(tmp_path, verdict="outside"))
    assert change.kinds == (VERDICT,)
    assert change.text == "force at equal penetration was within, is outside"


def test_slower_is_judged_on_one_machine_only(tmp_path):
    slow = reduced_change(study(tmp_path), study(tmp_path, seconds=0.2))
    assert slow.kinds == (SLOW,)
    assert slow.ratio == pytest.approx(2.0)
    assert "2.0 times slower" in slow.text
    assert slow.only_timed
    assert not slow.bad  # a time alone is no worse answer
    elsewhere = study(tmp_path, seconds=0.2, machine={"processor": "another"})
    record = compare_runs(study(tmp_path), elsewhere)
    assert not record.failed
    assert any("machines differ" in note for note in record.notes)


def test_times_too_short_to_read_are_not_judged(tmp_path):
    change = reduced_change(study(tmp_path, seconds=1e-4), study(tmp_path, seconds=1e-3))
    assert change.kinds == (SAME,)


def test_a_scene_that_was_only_laid_out_differently_is_the_same(tmp_path):
    """One line or five: what the text says is compared, so that writers of TOML may change."""
    runs = [study(tmp_path) for _ in range(2)]
    texts = "[loading]\nforce = [1.0, 2.0]\n", "[loading]\nforce = [\n  1.0,\n  2.0,\n]\n"
    laid_out = [
        replace(run, scenes=(replace(run.scenes[0], text=text),))
        for run, text in zip(runs, texts, strict=True)
    ]
    assert compare_runs(*laid_out).notes == ()


def test_versions_scenes_and_truths_that_differ_are_named(tmp_path):
    after = study(tmp_path, versions={"numpy": "3.0"})
    scene = replace(after.scenes[0], text="other", reference=Reference("fem", 6, ""))
    other = replace(after.scenes[0], name="cone")
    record = compare_runs(study(tmp_path), replace(after, scenes=(scene, other)))
    assert record.notes == (
        "numpy: 2.0 before, 3.0 after",
        "ball: the scene itself differs",
        "ball: the reference was bem_fft 20, now fem 6",
        "cone: in the second run only",
    )
    assert [c.kinds for c in record.changes if c.scene == "cone"] == [(ONE_SIDED,)] * 2
