"""Results folders: whole files or none, every digit, and nothing trusted on the way back."""

import io
import json
import math
import os
import pickle
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from comparisons.errors import ResultsError
from comparisons.files import read_arrays, write_arrays
from comparisons.judging.truth import Bar, Reference, Verification
from comparisons.judging.verdicts import Verdict
from comparisons.results.record import FIELDS_FOLDER, SceneRecord, StudyRecord
from comparisons.results.rows import Rows
from comparisons.results.store import RESULTS, STUDY, load_study, save_study
from comparisons.solving.plan import Measured, MethodPlan, PlanRecord, Roughness

THIRD = 1 / 3
PLAN = PlanRecord(
    methods=(MethodPlan("bem_fft", True, "", (8,), "the surface"),),
    left_out=(("comparison of pressures", "not asked for"),),
    notes=("one",),
    measured=Measured((1e-6, 2e-6), (1.0, 3.0), 1e9, fit_zero=False),
    roughness=Roughness((1e6, 2e6), (1e-30, 1e-31), 1e-9, 0.1, 1e5, 2.0),
)
REFERENCE = Reference(
    *("bem_fft", 8, "the finest"),
    sources={"penetration": {"discretisation": [0.1, math.nan]}},
    bars={"penetration": Bar(0.1, 1)},
    footnotes=("a little apart",),
    proved=Verification(6, 0, (), 1e-4, 0.5, 2.0),
)
JUDGED = Verdict(
    method="fem",
    resolution=8.0,
    quantity="force",
    at="penetration",
    word="outside",
    tolerance=0.01,
    error=-0.5,
    rms=THIRD,
    step=1,
)
MISSING = Verdict(method="fem", quantity="energy", at="force", tolerance=0.01, reason="why")


@pytest.fixture
def record(tmp_path):
    """Return a small study whose one field file exists."""
    folder = tmp_path / "study"
    path = folder / FIELDS_FOLDER / "a-bem_fft-8-0-abc.npz"
    write_arrays(path, {"pressure": np.arange(6.0)})
    rows = pd.DataFrame(
        {
            "scene": ["a"] * 3,
            "method": ["bem_fft", "bem_fft", "fem"],
            "resolution": [8.0, 8.0, np.nan],
            "step": [0.0, 1.0, np.nan],
            "force": [THIRD, 0.1 + 0.2, np.nan],
            "converged": [True, True, False],
            "reason": ["", "", 'says "no", at length;\nand twice'],
        }
    )
    scene = SceneRecord(
        name="a",
        title="Ball, <b>bold</b> \U0001f600",
        text='name = "a"',
        control="force",
        quantities=("penetration", "contact_area"),
        tolerance=0.01,
        plan=PLAN,
        reference=REFERENCE,
        disagreements=("a and b differ",),
        rows=Rows.of(rows),
        verdicts=(JUDGED, MISSING),
        fields={("bem_fft", 8): path},
    )
    return StudyRecord(
        directory=folder,
        created="2026-01-31T12:00:00+00:00",
        command="roughline run a.toml",
        effort="quick",
        seconds=1.5,
        machine={"system": "Linux", "cores": 2, "memory": 8_000_000_000},
        versions={"numpy": "2.1"},
        scenes=(scene,),
        interrupted=True,
    )


def test_a_study_comes_back_as_it_was(record):
    save_study(record)
    again = load_study(record.directory)
    for name in ("created", "command", "effort", "seconds", "machine", "versions", "interrupted"):
        assert getattr(again, name) == getattr(record, name)
    (old,), (new,) = record.scenes, again.scenes
    for name in ("name", "title", "text", "control", "quantities", "tolerance", "plan"):
        assert getattr(new, name) == getattr(old, name)
    assert new.disagreements == old.disagreements
    # NaN is not equal to itself: written out they are the same.
    assert repr(new.reference) == repr(old.reference)
    assert repr(new.verdicts) == repr(old.verdicts)
    for name in ("force", "reason"):  # to the last digit
        np.testing.assert_array_equal(new.rows[name], old.rows[name])
    np.testing.assert_array_equal(
        new.load_fields("bem_fft", 8)["pressure"], old.load_fields("bem_fft", 8)["pressure"]
    )
    assert new.load_fields("fem", 8) == {}


def test_tables_are_plain_comma_separated_text(record):
    """results.csv is read by others: first line names, numbers in full, one line end."""
    save_study(record)
    text = (record.directory / RESULTS).read_bytes()
    assert text.startswith(b"scene,method,resolution,step,force,converged,reason,scene_hash\n")
    assert b"0.30000000000000004" in text
    assert b"\r" not in text


class Bomb:
    """Raises a flag when unpickled."""

    def __reduce__(self):
        return os.putenv, ("ROUGHLINE_BOMB", "exploded")


def test_torn_foreign_and_pickled_array_files_are_refused(tmp_path):
    """Nor is anything unpickled: a pickle by the name of an array file, an object array in one."""
    write_arrays(tmp_path / "whole.npz", {"a": np.arange(1000.0)})
    np.savez(tmp_path / "hidden.npz", a=np.array([Bomb()], dtype=object))
    np.save(stream := io.BytesIO(), np.arange(3))
    contents = {
        "torn": (tmp_path / "whole.npz").read_bytes()[:-200],
        "single": stream.getvalue(),
        "pickled": pickle.dumps(Bomb()),
        "empty": b"",
    }
    for name, content in contents.items():
        (tmp_path / f"{name}.npz").write_bytes(content)
    for name in (*contents, "hidden", "missing"):
        with pytest.raises(ResultsError, match="not a readable array file"):
            read_arrays(tmp_path / f"{name}.npz")
    assert "ROUGHLINE_BOMB" not in os.environ


def reloaded(record, change):
    """Load the study whose document was changed on disk."""
    save_study(record)
    study = record.directory / STUDY
    study.write_text(json.dumps(change(json.loads(study.read_text())), indent=1))
    return load_study(record.directory)


@pytest.mark.parametrize("name", ["../secret.npz", "/etc/passwd", "fields/../../secret.npz", ""])
def test_field_files_outside_the_folder_are_refused(record, tmp_path, name):
    """By their name, or where a link leads."""
    (tmp_path / "secret.npz").write_bytes(b"x")
    if not name:
        name = f"{FIELDS_FOLDER}/link.npz"
        (record.directory / name).symlink_to(tmp_path / "secret.npz")
    with pytest.raises(ResultsError, match="leads out of"):
        reloaded(record, lambda d: scene(d, fields=[["bem_fft", 8, name]]))


WRONG = {
    "a list": lambda d: [],
    "no scenes": lambda d: {k: v for k, v in d.items() if k != "scenes"},
    "seconds not a number": lambda d: d | {"seconds": float("nan")},
    "nested machine": lambda d: d | {"machine": {"system": {"a": 1}}},
    "text missing": lambda d: scene(d, text=None),
    "tolerance of nothing": lambda d: scene(d, tolerance=0),
    "tolerance of all": lambda d: scene(d, tolerance=1),
    "method as text": lambda d: scene(d, plan={"methods": ["fem"], "left_out": [], "notes": []}),
    "verdict without a tolerance": lambda d: scene(d, verdicts=[{"quantity": "a", "at": "b"}]),
    "reference without a method": lambda d: scene(d, reference={"resolution": 8, "text": "a"}),
    "bar as text": lambda d: scene(d, reference={"sources": {"force": {"solver": ["1 %"]}}}),
    "field without resolution": lambda d: scene(d, fields=[["fem", "a.npz"]]),
    "file as number": lambda d: scene(d, fields=[["fem", 8, 3]]),
}


def scene(document, **changes):
    document["scenes"][0] |= changes
    return document


@pytest.mark.parametrize("damage", WRONG)
def test_a_study_of_the_wrong_form_is_refused(record, damage):
    with pytest.raises(ResultsError, match="damaged results"):
        reloaded(record, WRONG[damage])


def test_a_study_of_another_version_is_no_damage(record):
    other = {"source": "0" * 64, "effort": "thorough"}
    with pytest.raises(ResultsError, match=r"written by another version of roughline \(.*effort"):
        reloaded(record, lambda d: d | other)


@pytest.mark.parametrize(
    ("file", "content"),
    [
        (STUDY, b""),
        (STUDY, b"{"),
        (STUDY, b"\xff\xfe"),
        (STUDY, b"[" * 100_000),
        (RESULTS, b""),
        (RESULTS, b"\xff\xfe\x00"),
        (RESULTS, b"method\nfem\n"),
        (RESULTS, b"broken\n"),
        (RESULTS, b'scene,method\n"a,b\n'),
    ],
)
def test_damaged_and_missing_files_are_named(record, tmp_path, file, content):
    save_study(record)
    (record.directory / file).write_bytes(content)
    with pytest.raises(ResultsError, match="damaged results"):
        load_study(record.directory)
    (record.directory / file).unlink()
    with pytest.raises(ResultsError, match=f"{file} is missing"):
        load_study(record.directory)
    for path in (tmp_path / "nowhere", tmp_path):
        with pytest.raises(ResultsError):
            load_study(path)


def test_a_folder_of_another_command_is_called_so(tmp_path):
    (tmp_path / "ensemble.json").touch()
    with pytest.raises(ResultsError, match=r"of `roughline run` here .*, ensemble.json is there"):
        load_study(tmp_path)


def test_a_run_that_ended_at_its_first_file_has_no_scenes(record):
    save_study(record.model_copy(update={"scenes": ()}))
    (record.directory / RESULTS).unlink()
    assert load_study(record.directory).scenes == ()


def edited(record, name, change):
    save_study(record)
    table = pd.read_csv(record.directory / name)
    change(table).to_csv(record.directory / name, index=False)
    return load_study(record.directory)


@pytest.mark.parametrize(
    ("name", "change", "said"),
    [
        (RESULTS, lambda t: t.drop(columns="method"), "results.csv: column method: missing"),
        (RESULTS, lambda t: t.assign(step="many"), "results.csv: column step: expected numbers"),
        (RESULTS, lambda t: t.assign(resolution=-1), "results.csv: column resolution: expected"),
        (RESULTS, lambda t: t.assign(method=""), "results.csv: column method: expected a text"),
        (RESULTS, lambda t: t.assign(converged="perhaps"), "column converged: expected True or F"),
        (
            RESULTS,
            lambda t: t.assign(step="many", force="some"),
            "column step: expected numbers; column force: expected numbers",
        ),
    ],
)
def test_tables_edited_by_hand_are_refused_in_words(record, name, change, said):
    with pytest.raises(ResultsError, match=said):
        edited(record, name, change)


def test_whole_numbers_stay_whole_beside_a_refused_method():
    table = pd.DataFrame({"scene": ["a", "a"], "step": [0, 1], "iterations": [12, np.nan]})
    assert Rows.of(table).frame().to_csv(index=False) == "scene,step,iterations\na,0,12\na,1,\n"


def test_what_a_table_has_not_is_unknown(record):
    scenes = edited(record, RESULTS, lambda t: t[["scene"]][:0]).scenes
    assert [len(scenes[0].rows[name]) for name in ("method", "force", "converged")] == [0, 0, 0]
    rows = record.scenes[0].rows
    assert np.isnan(rows["energy"]).all()
    assert rows["machine"].tolist() == ["", "", ""]


def test_a_scene_may_be_called_nan(record):
    """Words that pandas takes for missing values are names like others."""
    scene = record.scenes[0]
    named = replace(scene, name="nan", rows=Rows.of(scene.rows.frame().assign(scene="nan")))
    save_study(record.model_copy(update={"scenes": (named,)}))
    (scene,) = load_study(record.directory).scenes
    assert scene.name == "nan"
    assert len(scene.rows) == 3


def test_rows_of_another_scene_are_refused(record):
    """As where two runs, of one scene at two moduli, wrote into one folder."""
    save_study(record)
    rows = (record.directory / RESULTS).read_bytes()
    save_study(
        record.model_copy(update={"scenes": (replace(record.scenes[0], text="[half_space]\n"),)})
    )
    load_study(record.directory)
    (record.directory / RESULTS).write_bytes(rows)
    with pytest.raises(ResultsError, match=r"results\.csv: rows of another scene a than study"):
        load_study(record.directory)


@pytest.mark.parametrize(
    ("arrays", "said"),
    [
        ({"pressure": np.array(["x", "y"])}, "pressure: expected numbers"),
        ({"pressure": np.ones(3), "pressure_x": np.ones(2)}, "expected lists of one length"),
        ({"pressure": np.ones((2, 2))}, "expected lists of one length"),
        ({"penetration": np.ones(2)}, "penetration: expected one number"),
        ({"pressure": np.ones(4), "pressure_shape": np.array([3, 3])}, "pressure_shape: expected"),
        ({"heights": np.ones(4), "size": np.ones(2)}, "heights: expected a map"),
        ({"heights": np.ones((2, 2))}, "size: expected two numbers"),
        ({"mesh_points": np.ones((4, 2))}, "mesh_points: expected points"),
        ({"mesh_points": np.ones((4, 3)), "mesh_cells": np.array([[9]])}, "mesh_cells: expected"),
    ],
)
def test_fields_edited_by_hand_are_refused_in_words(record, arrays, said):
    write_arrays(record.scenes[0].fields["bem_fft", 8], arrays)
    with pytest.raises(ResultsError, match=said):
        record.scenes[0].load_fields("bem_fft", 8)
