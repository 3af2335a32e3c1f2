"""The check: planted faults are found and named for what they are; baselines are files to trust."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from comparisons.errors import InputError
from comparisons.methods.normal import reduced as reduced_method
from comparisons.questions.benchmarks.yardstick import interleaved
from comparisons.questions.regression import check as check_module
from comparisons.questions.regression import snapshot
from comparisons.questions.regression.check import (
    AGREEMENT,
    MODEL,
    REFERENCES,
    SPEED,
    Finding,
    check_against,
    compare_snapshots,
)
from comparisons.questions.regression.snapshot import (
    CHECK_SCENES,
    PACKAGED,
    Snapshot,
    Speed,
    identity,
    load_baseline,
    save_baseline,
    take_snapshot,
)
from comparisons.scene.scene import Scene, load_scene
from reference.halfspace import kernels
from roughline.commands.app import run_command

FAULT = 1.002


@pytest.fixture(scope="module")
def before() -> Snapshot:
    """Solve a paraboloid, for which closed form, BEM and FEM are all there."""
    return take_snapshot(scenes=["paraboloid"])


def about(findings: list[Finding], subject: str) -> Finding:
    (only,) = [finding for finding in findings if finding.subject == subject]
    return only


@pytest.mark.slow
def test_the_same_code_has_not_moved(before):
    findings = compare_snapshots(before, take_snapshot(scenes=["paraboloid"]))
    assert not any(finding.drifted for finding in findings if finding.subject != SPEED)
    assert {finding.subject for finding in findings} == {MODEL, REFERENCES, AGREEMENT, SPEED}


@pytest.mark.slow
def test_a_stiffer_reduced_model_is_named(before, monkeypatch):
    """A factor 1.002 in the springs: the model's force moves by 0.2 %, the references do not."""
    sound = reduced_method.indent

    def faulty(springs, load):
        return sound(replace(springs, effective_modulus=FAULT * springs.effective_modulus), load)

    monkeypatch.setattr(reduced_method, "indent", faulty)
    findings = compare_snapshots(before, take_snapshot(scenes=["paraboloid"]))
    moved = about(findings, MODEL)
    assert moved.drifted
    assert moved.text.startswith("the reduced model moved: ")
    assert "+0.20" in moved.text
    assert not about(findings, REFERENCES).drifted
    assert not about(findings, AGREEMENT).drifted


@pytest.mark.slow
def test_a_kernel_off_by_half_a_per_cent_is_named_twice(before, monkeypatch):
    """The FFT solver has moved, and closed form and finite elements outvote it."""
    sound = kernels.love
    monkeypatch.setattr(kernels, "love", lambda *a, **k: 1.005 * sound(*a, **k))
    findings = compare_snapshots(before, take_snapshot(scenes=["paraboloid"]))
    assert not about(findings, MODEL).drifted
    moved = about(findings, REFERENCES)
    assert moved.drifted
    assert moved.text.startswith("the reference moved: FFT BEM: ")
    assert "closed form and FEM did not" in moved.text.replace("Closed", "closed")
    agreement = about(findings, AGREEMENT)
    assert agreement.drifted
    assert agreement.text.startswith("FFT BEM stands alone against the others.")


@pytest.mark.slow
def test_the_same_factor_in_both_is_named_as_shared(before, monkeypatch):
    """All read E* from the scene: a fault there moves model and truth alike, and no error shows."""
    sound = Scene.effective_modulus.fget
    monkeypatch.setattr(Scene, "effective_modulus", property(lambda self: FAULT * sound(self)))
    findings = compare_snapshots(before, take_snapshot(scenes=["paraboloid"]))
    moved = about(findings, MODEL)
    assert moved.drifted
    assert "moved by the same factor 1.002" in moved.text
    assert moved.text.endswith("something they share has changed")
    assert not about(findings, AGREEMENT).drifted


def test_a_scene_that_was_changed_is_not_blamed_on_the_code(before):
    """Another E in the scene's file moves model and truth alike; nothing of roughline did."""
    own = before.scenes["paraboloid"]
    assert own.scene == identity(load_scene("paraboloid", {"title": "another"}))
    softer = identity(load_scene("paraboloid", {"half_space.youngs_modulus": 1e9}))
    now = {"paraboloid": own.model_copy(update={"scene": softer})}
    (result,) = compare_snapshots(before, before.model_copy(update={"scenes": now}))
    assert result.drifted
    assert "the scene itself is not the baseline's" in result.text


def slower(snapshot: Snapshot, model: float, machine: float) -> Snapshot:
    scene = snapshot.scenes["paraboloid"]
    speed = Speed(
        seconds=scene.speed.seconds * model * machine,
        yardstick_seconds=scene.speed.yardstick_seconds * machine,
        ratio=scene.speed.ratio * model,
    )
    changed = scene.model_copy(update={"speed": speed})
    return snapshot.model_copy(update={"scenes": {"paraboloid": changed}})


def test_a_slow_machine_is_not_a_slow_model(before):
    machine = about(compare_snapshots(before, slower(before, 1.0, 3.0)), SPEED)
    assert machine.text.startswith("the machine is slower: 3.0 times")
    assert not machine.drifted
    model = about(compare_snapshots(before, slower(before, 3.0, 1.0)), SPEED)
    assert model.text.startswith("the reduced model is slower: 3.0 times")
    assert model.drifted


def test_a_quantity_that_vanished_is_a_drift(before):
    scene = before.scenes["paraboloid"]
    curves = scene.model.model_copy(
        update={"quantities": {k: v for k, v in scene.model.quantities.items() if k != "force"}}
    )
    now = before.model_copy(
        update={"scenes": {"paraboloid": scene.model_copy(update={"model": curves})}}
    )
    assert about(compare_snapshots(before, now), MODEL).text.endswith("any more for force")


def test_update_shows_the_drift_and_keeps_other_scenes(before, tmp_path, monkeypatch):
    path = tmp_path / "baseline.json"
    other = before.model_copy(update={"scenes": before.scenes | {"other": slower_scene(before)}})
    save_baseline(path, other)
    scene = before.scenes["paraboloid"]
    force = [1.1 * value for value in scene.model.quantities["force"]]
    curves = scene.model.model_copy(
        update={"quantities": scene.model.quantities | {"force": force}}
    )
    now = before.model_copy(
        update={"scenes": {"paraboloid": scene.model_copy(update={"model": curves})}}
    )
    monkeypatch.setattr(check_module, "take_snapshot", lambda *a: now)
    (moved,) = [f for f in check_against(path, update=True) if f.drifted]
    assert "force by +10 %" in moved.text.replace("\u202f", " ")
    stored = load_baseline(path)
    assert stored.scenes["paraboloid"].model.quantities["force"] == force
    assert stored.scenes["other"] == other.scenes["other"]
    assert not any(f.drifted for f in check_against(path))


def slower_scene(snapshot: Snapshot):
    return slower(snapshot, 2.0, 1.0).scenes["paraboloid"]


def test_baselines_that_cannot_be_read_say_what_is_wrong(before, tmp_path):
    path = tmp_path / "baseline.json"
    with pytest.raises(InputError, match="no baseline can be read here"):
        load_baseline(path)
    path.write_text("{}")
    with pytest.raises(InputError, match=r"not a baseline of roughline: method: Field required"):
        load_baseline(path)
    document = json.loads(before.model_dump_json())
    document["scenes"]["paraboloid"]["model"]["quantities"]["force"] = "many"
    path.write_text(json.dumps(document))
    with pytest.raises(InputError, match=r"scenes\.paraboloid\.model\.quantities\.force"):
        load_baseline(path)
    save_baseline(path, before.model_copy(update={"method": "mine"}))
    with pytest.raises(InputError, match="expected a baseline of reduced, got one of mine"):
        check_against(path)


def test_the_packaged_baseline_covers_all_scenes_of_a_check():
    stored = load_baseline(PACKAGED)
    assert set(stored.scenes) == set(CHECK_SCENES)
    assert all(scene.model is not None for scene in stored.scenes.values())


@pytest.mark.slow
def test_this_version_is_its_own_baseline(monkeypatch):
    """The whole check, as continuous integration runs it; how fast is the machine's business."""
    monkeypatch.setattr(snapshot, "interleaved", lambda tasks: interleaved(tasks, 1))
    drifted = [f for f in check_against(PACKAGED) if f.drifted and f.subject != SPEED]
    assert not drifted, drifted


@pytest.mark.slow
def test_the_command_ends_with_one_on_drift(before, tmp_path, capsys):
    path = tmp_path / "baseline.json"
    scene = before.scenes["paraboloid"]
    force = [2 * value for value in scene.model.quantities["force"]]
    curves = scene.model.model_copy(
        update={"quantities": scene.model.quantities | {"force": force}}
    )
    changed = scene.model_copy(update={"model": curves})
    save_baseline(path, before.model_copy(update={"scenes": {"paraboloid": changed}}))
    assert run_command(["check", "paraboloid", "--baseline", str(path)]) == 1
    assert "the reduced model moved" in capsys.readouterr().out
    assert load_baseline(path).scenes["paraboloid"].model.quantities["force"] == force
