"""Results folders: whole files or none, every digit, and nothing trusted on the way back."""

from __future__ import annotations

import json
import os
import pickle
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from comparisons.errors import ResultsError
from comparisons.files import read_arrays, write_arrays, write_table
from comparisons.results.store import (
    FIELDS,
    MEASURES,
    RESULTS,
    STUDY,
    SceneRecord,
    StudyRecord,
    load_study,
    save_study,
)

THIRD = 1 / 3
PLAN = {
    "methods": [
        {
            "method": "bem_fft",
            "supported": True,
            "reason": "",
            "resolutions": [8],
            "modelled": "the surface",
        }
    ],
    "left_out": [{"what": "pressure fields", "why": "not asked for"}],
    "notes": ["one"],
}
REFERENCE = {
    "method": "bem_fft",
    "resolution": 8,
    "text": "the finest",
    "uncertainty": {"penetration": 0.1, "contact_area": None},
}


@pytest.fixture
def record(tmp_path):
    """Return a small study whose one field file exists."""
    folder = tmp_path / "study"
    path = folder / FIELDS / "a-bem_fft-8-0-abc.npz"
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
        answer="No method got there.",
        disagreements=("a and b differ",),
        rows=rows,
        measures=pd.DataFrame(
            {
                "scene": ["a"],
                "method": ["fem"],
                "resolution": [8],
                "quantity": ["force"],
                "at": ["penetration"],
                "rms": [THIRD],
                "maximum": [0.5],
                "verdict": ["outside"],
            }
        ),
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


# --- there and back -------------------------------------------------------------------------


def test_a_study_comes_back_as_it_was(record):
    save_study(record)
    again = load_study(record.directory)
    for name in ("created", "command", "effort", "seconds", "machine", "versions", "interrupted"):
        assert getattr(again, name) == getattr(record, name)
    (old,), (new,) = record.scenes, again.scenes
    for name in ("name", "title", "text", "control", "quantities", "tolerance", "plan"):
        assert getattr(new, name) == getattr(old, name)
    assert new.reference == old.reference
    assert (new.answer, new.disagreements) == (old.answer, old.disagreements)
    np.testing.assert_array_equal(
        new.load_fields("bem_fft", 8)["pressure"], old.load_fields("bem_fft", 8)["pressure"]
    )
    assert new.load_fields("fem", 8) == {}


def test_numbers_come_back_to_the_last_digit(record):
    save_study(record)
    (scene,) = load_study(record.directory).scenes
    np.testing.assert_array_equal(scene.rows["force"], record.scenes[0].rows["force"])
    assert scene.measures["rms"][0] == THIRD
    assert scene.rows["reason"][2] == 'says "no", at length;\nand twice'


def test_tables_are_plain_comma_separated_text(record):
    """results.csv is read by others: first line names, numbers in full, one line end."""
    save_study(record)
    text = (record.directory / RESULTS).read_bytes()
    assert text.startswith(b"scene,method,resolution,step,force,converged,reason,scene_hash\n")
    assert b"0.30000000000000004" in text
    assert b"\r" not in text


def test_a_study_without_any_scene_comes_back(record, tmp_path):
    """What an interrupt before the first solve leaves."""
    empty = StudyRecord(
        **{name: getattr(record, name) for name in ("created", "command", "effort", "seconds")},
        directory=tmp_path / "empty",
        machine={},
        versions={},
        scenes=(),
    )
    save_study(empty)
    assert load_study(empty.directory).scenes == ()


# --- whole files or none --------------------------------------------------------------------


def test_a_table_is_replaced_whole(tmp_path):
    path = tmp_path / "t.csv"
    write_table(path, pd.DataFrame({"a": range(1000)}))
    write_table(path, pd.DataFrame({"a": [1]}))
    assert path.read_text() == "a\n1\n"


# --- strangers' folders ---------------------------------------------------------------------


class Bomb:
    """Raises a flag when unpickled."""

    def __reduce__(self):
        return os.putenv, ("ROUGHLINE_BOMB", "exploded")


def test_arrays_are_never_unpickled(tmp_path):
    """Neither a pickle with the name of an array file, nor an object array inside one."""
    plain = tmp_path / "plain.npz"
    plain.write_bytes(pickle.dumps(Bomb()))
    hidden = tmp_path / "hidden.npz"
    np.savez(hidden, a=np.array([Bomb()], dtype=object))
    for path in (plain, hidden):
        with pytest.raises(ResultsError, match="not a readable array file"):
            read_arrays(path)


def test_torn_and_foreign_array_files_are_refused(tmp_path):
    whole = tmp_path / "whole.npz"
    write_arrays(whole, {"a": np.arange(1000.0)})
    torn = tmp_path / "torn.npz"
    torn.write_bytes(whole.read_bytes()[:-200])
    single = tmp_path / "single.npz"
    with single.open("wb") as stream:
        np.save(stream, np.arange(3))
    (tmp_path / "empty.npz").write_bytes(b"")
    for name in ("torn.npz", "single.npz", "empty.npz", "missing.npz"):
        with pytest.raises(ResultsError, match="not a readable array file"):
            read_arrays(tmp_path / name)


@pytest.mark.parametrize("name", ["../secret.npz", "/etc/passwd", "fields/../../secret.npz"])
def test_field_files_outside_the_folder_are_refused(record, name):
    save_study(record)
    study = record.directory / STUDY
    document = json.loads(study.read_text())
    document["scenes"][0]["fields"] = [["bem_fft", 8, name]]
    study.write_text(json.dumps(document))
    with pytest.raises(ResultsError, match="leads out of"):
        load_study(record.directory)


def test_a_link_that_leads_outside_is_refused(record, tmp_path):
    save_study(record)
    (tmp_path / "secret.npz").write_bytes(b"x")
    link = record.directory / FIELDS / "a-bem_fft-8-0-abc.npz"
    link.unlink()
    link.symlink_to(tmp_path / "secret.npz")
    with pytest.raises(ResultsError, match="leads out of"):
        load_study(record.directory)


WRONG = {
    "a list": lambda d: [],
    "no scenes": lambda d: {k: v for k, v in d.items() if k != "scenes"},
    "scenes as text": lambda d: d | {"scenes": "abc"},
    "seconds as text": lambda d: d | {"seconds": "1"},
    "seconds not a number": lambda d: d | {"seconds": float("nan")},
    "unknown key": lambda d: d | {"colour": "red"},
    "machine as list": lambda d: d | {"machine": [1]},
    "nested machine": lambda d: d | {"machine": {"system": {"a": 1}}},
    "title as number": lambda d: scene(d, title=3),
    "text missing": lambda d: scene(d, text=None),
    "tolerance as text": lambda d: scene(d, tolerance="1 %"),
    "quantities as text": lambda d: scene(d, quantities="force"),
    "plan as list": lambda d: scene(d, plan=[]),
    "method as text": lambda d: scene(d, plan={"methods": ["fem"], "left_out": [], "notes": []}),
    "reference as text": lambda d: scene(d, reference="fem"),
    "bar as text": lambda d: scene(d, reference={"uncertainty": {"force": "1 %"}}),
    "field without resolution": lambda d: scene(d, fields=[["fem", "a.npz"]]),
    "resolution as text": lambda d: scene(d, fields=[["fem", "x", "a.npz"]]),
    "file as number": lambda d: scene(d, fields=[["fem", 8, 3]]),
    "unknown key of a scene": lambda d: scene(d, colour="red"),
}


def scene(document, **changes):
    document["scenes"][0] |= changes
    return document


@pytest.mark.parametrize("damage", WRONG)
def test_a_study_of_the_wrong_form_is_refused(record, damage):
    save_study(record)
    study = record.directory / STUDY
    study.write_text(json.dumps(WRONG[damage](json.loads(study.read_text()))))
    with pytest.raises(ResultsError, match="damaged results"):
        load_study(record.directory)


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
        (MEASURES, b""),
    ],
)
def test_damaged_files_are_refused(record, file, content):
    save_study(record)
    (record.directory / file).write_bytes(content)
    with pytest.raises(ResultsError, match="damaged results"):
        load_study(record.directory)


@pytest.mark.parametrize("file", [STUDY, RESULTS, MEASURES])
def test_a_missing_file_is_named(record, file):
    save_study(record)
    (record.directory / file).unlink()
    with pytest.raises(ResultsError, match=f"no results of roughline here \\({file} is missing"):
        load_study(record.directory)


def test_what_is_no_folder_is_refused(tmp_path):
    file = tmp_path / "file"
    file.write_text("x")
    for path in (file, tmp_path / "nowhere", tmp_path):
        with pytest.raises(ResultsError):
            load_study(path)


# --- edited by hand ------------------------------------------------------------------------------


def edited(record, name, change):
    save_study(record)
    table = pd.read_csv(record.directory / name)
    change(table).to_csv(record.directory / name, index=False)
    return load_study(record.directory)


@pytest.mark.parametrize(
    ("name", "change", "said"),
    [
        (RESULTS, lambda t: t.drop(columns="method"), "results.csv: column method: missing"),
        (MEASURES, lambda t: t.drop(columns="verdict"), "measures.csv: column verdict: missing"),
        (RESULTS, lambda t: t.assign(step="many"), "results.csv: column step: expected numbers"),
        (RESULTS, lambda t: t.assign(resolution=-1), "results.csv: column resolution: expected"),
        (MEASURES, lambda t: t.assign(quantity=""), "measures.csv: column quantity: expected a"),
        (MEASURES, lambda t: t.assign(rms="small"), "measures.csv: column rms: expected numbers"),
        (MEASURES, lambda t: t.assign(verdict="fine"), "measures.csv: column verdict: expected"),
    ],
)
def test_tables_edited_by_hand_are_refused_in_words(record, name, change, said):
    with pytest.raises(ResultsError, match=said):
        edited(record, name, change)


@pytest.mark.parametrize("name", [RESULTS, MEASURES])
def test_a_table_without_rows_has_the_columns_that_readers_ask_for(record, name):
    scenes = edited(record, name, lambda t: t[["scene"]][:0]).scenes
    table = scenes[0].rows if name == RESULTS else scenes[0].measures
    assert table.empty
    assert {"scene", "method", "resolution"} <= set(table)


@pytest.mark.parametrize("missing", ["method", "resolution", "text"])
def test_a_truth_without_its_method_is_damage(record, missing):
    save_study(record)
    path = record.directory / STUDY
    document = json.loads(path.read_text())
    del document["scenes"][0]["reference"][missing]
    path.write_text(json.dumps(document))
    with pytest.raises(ResultsError, match=r"reference: .*expected method, resolution and text"):
        load_study(record.directory)


@pytest.mark.parametrize("tolerance", ["1e308", "0", "-1", "1"])
def test_a_tolerance_that_no_scene_may_have_is_damage(record, tolerance):
    save_study(record)
    path = record.directory / STUDY
    stored = f'"tolerance": {record.scenes[0].tolerance}'
    text = path.read_text()
    assert stored in text
    path.write_text(text.replace(stored, f'"tolerance": {tolerance}'))
    with pytest.raises(ResultsError, match="tolerance"):
        load_study(record.directory)


def test_a_scene_may_be_called_nan(record):
    """Words that pandas takes for missing values are names like others."""
    scene = record.scenes[0]
    tables = {kind: getattr(scene, kind).assign(scene="nan") for kind in ("rows", "measures")}
    named = replace(scene, name="nan", **tables)
    save_study(replace(record, scenes=(named,)))
    (scene,) = load_study(record.directory).scenes
    assert scene.name == "nan"
    assert len(scene.rows) == 3


def test_rows_of_another_scene_are_refused(record):
    """As where two runs, of one scene at two moduli, wrote into one folder."""
    save_study(record)
    rows = (record.directory / RESULTS).read_bytes()
    save_study(replace(record, scenes=(replace(record.scenes[0], text="[half_space]\n"),)))
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
