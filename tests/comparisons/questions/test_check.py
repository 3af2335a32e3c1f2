"""The check: planted faults are found and named for what they are; baselines are files to trust."""

from dataclasses import replace

import numpy as np
import pytest

from comparisons.errors import InputError
from comparisons.facts.methods import INDEPENDENT
from comparisons.questions import check as check_module
from comparisons.questions.check import (
    AGREEMENT,
    CHECK_SCENES,
    MODEL,
    PACKAGED,
    REFERENCES,
    SPEED,
    Finding,
    check_against,
    drift,
    run_for_check,
)
from comparisons.results.record import StudyRecord
from comparisons.results.rows import Rows
from comparisons.results.store import STUDY, load_study, save_study
from comparisons.scene.scene import SINGLE, Scene
from reference.halfspace import kernels
from roughline.commands.app import run_command

FAULT = 1.002
CHECKED = ("reduced", *INDEPENDENT)


@pytest.fixture(scope="module")
def before() -> StudyRecord:
    """Solve a paraboloid, for which closed form, BEM and FEM are all there."""
    return run_for_check(scenes=["paraboloid"])


def about(findings: list[Finding], subject: str) -> Finding:
    (only,) = [finding for finding in findings if finding.subject == subject]
    return only


def with_model(record: StudyRecord, name: str, factor: float) -> StudyRecord:
    """Return a record in which a column of the model's rows has another factor."""
    (scene,) = record.scenes
    rows = scene.rows.frame()
    rows.loc[rows["method"] == "reduced", name] *= factor
    return record.model_copy(update={"scenes": (replace(scene, rows=Rows.of(rows)),)})


@pytest.mark.slow
def test_a_kernel_off_by_half_a_per_cent_is_named_twice(before, monkeypatch):
    """The FFT solver has moved, and closed form and finite elements outvote it."""
    sound = kernels.love
    monkeypatch.setattr(kernels, "love", lambda *a, **k: 1.005 * sound(*a, **k))
    findings = drift(before, run_for_check(scenes=["paraboloid"]))
    assert not about(findings, MODEL).drifted
    moved = about(findings, REFERENCES)
    assert moved.drifted
    assert moved.text.startswith("the reference moved: FFT BEM: ")
    assert "closed form and FEM did not" in moved.text.replace("Closed", "closed")
    agreement = about(findings, AGREEMENT)
    assert agreement.drifted
    assert "FFT BEM and closed form differ" in agreement.text


@pytest.mark.slow
def test_the_same_factor_in_both_is_named_as_shared(before, monkeypatch):
    """All read E* from the scene: a fault there moves model and truth alike, and no error shows."""
    sound = Scene.effective_modulus.fget
    monkeypatch.setattr(Scene, "effective_modulus", property(lambda self: FAULT * sound(self)))
    findings = drift(before, run_for_check(scenes=["paraboloid"]))
    moved = about(findings, MODEL)
    assert moved.drifted
    assert "moved by the same factor 1.002" in moved.text
    assert moved.text.endswith("something they share has changed")
    assert not about(findings, AGREEMENT).drifted


def test_a_scene_that_was_changed_is_not_blamed_on_the_code(before):
    """Another E in the scene's file moves model and truth alike; nothing of roughline did."""
    (own,) = before.scenes
    renamed, softer = (
        before.model_copy(update={"scenes": (replace(own, text=text),)})
        for text in (
            own.text.replace("[compare]", "[compare]\ntolerance = 0.02"),
            own.text.replace("youngs_modulus", "poisson_free_modulus"),
        )
    )
    assert not any(f.drifted for f in drift(before, renamed))
    (result,) = drift(before, softer)
    assert result.drifted
    assert "the scene itself is not the baseline's" in result.text


def test_a_slower_model_is_told_and_no_drift(before):
    timed, slow = (with_model(before, "seconds", factor) for factor in (1e6, 1e8))
    told = about(drift(timed, slow), SPEED)
    assert "took longer: " in told.text
    assert told.notable
    assert not told.drifted


def test_references_that_differ_are_a_drift_where_none_did_before(before):
    def differing(*texts):
        scenes = (replace(before.scenes[0], disagreements=texts),)
        return before.model_copy(update={"scenes": scenes})

    told = about(drift(differing("A and B differ by 2 %."), before), AGREEMENT)
    assert (told.drifted, told.notable) == (False, False)
    known, new = "A and B differ by 3 %.", "A and C differ by 3 %."
    told = about(drift(differing("A and B differ by 2 %."), differing(known)), AGREEMENT)
    assert (told.text, told.drifted, told.notable) == (f"as in the baseline: {known}", False, True)
    told = about(drift(differing(known), differing(known, new)), AGREEMENT)
    assert (told.text, told.drifted) == (f"{known} {new}", True)


def test_a_quantity_that_vanished_is_a_drift(before):
    lost = drift(before, with_model(before, "force", float("nan")))
    assert about(lost, MODEL).text.endswith("no value of force any more")
    assert about(lost, MODEL).drifted


def test_update_shows_the_drift_and_keeps_other_scenes(before, tmp_path, monkeypatch):
    (scene,) = before.scenes
    other = replace(scene, name="other", rows=scene.rows.where(scene.rows["step"] < 0))
    save_study(before.model_copy(update={"scenes": (scene, other), "directory": tmp_path}))
    now = with_model(before, "force", 1.1)
    monkeypatch.setattr(check_module, "run_for_check", lambda *a: now)
    (moved,) = [f for f in check_against(tmp_path, update=True) if f.drifted]
    assert "force by +10 %" in moved.text.replace("\u202f", " ")
    assert {scene.name for scene in load_study(tmp_path).scenes} == {"paraboloid", "other"}
    assert not any(f.drifted for f in check_against(tmp_path))


def test_baselines_that_cannot_be_read_say_what_is_wrong(before, tmp_path):
    with pytest.raises(InputError, match=r"no results of roughline here.*--update writes"):
        check_against(tmp_path, scenes=["paraboloid"])
    (tmp_path / STUDY).write_text("{}")
    with pytest.raises(InputError, match="damaged results"):
        check_against(tmp_path, scenes=["paraboloid"])


def test_a_baseline_of_another_method_is_no_baseline(before):
    (found,) = drift(before, before, "mine")
    assert found.drifted
    assert found.text == "not in the baseline: --update adds it"


def test_the_packaged_baseline_covers_all_scenes_of_a_check():
    stored = load_study(PACKAGED)
    assert {scene.name for scene in stored.scenes} == set(CHECK_SCENES)
    assert all("reduced" in scene.rows["method"] for scene in stored.scenes)


@pytest.mark.slow
def test_this_version_is_its_own_baseline(quick_suite):
    """All scenes of a check; a single contact that the quick suite has is not solved again."""
    taken = [quick_suite[name] for name in SINGLE if name in quick_suite]
    names = {scene.name for scene in taken}
    now = run_for_check(scenes=[name for name in CHECK_SCENES if name not in names])
    known = [
        replace(scene, rows=scene.rows.where(np.isin(scene.rows["method"], CHECKED)))
        for scene in taken
    ]
    now = now.model_copy(update={"scenes": (*known, *now.scenes)})
    findings = drift(load_study(PACKAGED), now)
    assert {finding.scene for finding in findings} == set(CHECK_SCENES)
    drifted = [finding for finding in findings if finding.drifted]
    assert not drifted, drifted


@pytest.mark.slow
def test_the_command_ends_with_one_on_drift(before, tmp_path, capsys):
    stored = with_model(before, "force", 2.0)
    save_study(stored.model_copy(update={"directory": tmp_path}))
    assert run_command(["check", "paraboloid", "--baseline", str(tmp_path)]) == 1
    assert "the reduced model moved" in capsys.readouterr().out
