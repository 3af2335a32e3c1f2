"""Runs of several machines merged: the same as one run, or a list of what speaks against it."""

import json
import shutil

import numpy as np
import pandas as pd
import pytest

from comparisons.errors import InputError
from comparisons.questions.merging import merge
from comparisons.questions.study import Study
from comparisons.results.record import FIELDS_FOLDER
from comparisons.results.store import MEASURES, RESULTS, STUDY, load_study
from comparisons.solving import execution
from comparisons.solving.planning import plan_scene
from comparisons.tasks.solution import load_solution, save_solution

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module", autouse=True)
def _soon_solved():
    """Let every solve be one that is soon done, also on a busy machine."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("comparisons.questions.study.SOON_SOLVED", np.inf)
        yield


CLOCK = ["seconds", "setup_seconds", "seconds_all", "setup_seconds_all", "compile_seconds"]
CLOCK += ["memory", "machine"]
GRIDS = {"methods": ["reduced", "bem_fft"], "resolutions": [16, 32], "tolerance": 0.3}
# Tasks of the first surfaces and lines: every part solves them, to choose the same numbers.
FIRST = 2 + 1 + 2


def ensemble(rough, **compare):
    """Return plans of 60 surfaces, all of which the coarse grid needs, and of many lines."""
    force = {"values": [0.05], "relative_to": "E* A0 h'"}
    scene = rough(realisations=60, loading={"force": force}, compare=GRIDS | compare)
    return plan_scene(scene, "full")


def run(plans, folder, **more):
    study = Study(plans, folder, effort="full", **more)
    study.run()
    return study


def table(folder, name=RESULTS):
    return pd.read_csv(folder / name, dtype=str).drop(columns=CLOCK, errors="ignore")


def assert_same(one, other):
    for name in (RESULTS, MEASURES):
        pd.testing.assert_frame_equal(table(one, name), table(other, name))
    old, new = (load_study(part).scenes for part in (one, other))
    for a, b in zip(old, new, strict=True):
        for name in ("text", "plan", "reference", "disagreements"):
            assert getattr(a, name) == getattr(b, name)
        kept = [{key: path.name for key, path in run.fields.items()} for run in (a, b)]
        assert kept[0] == kept[1]


@pytest.fixture(scope="module")
def solved(rough, tmp_path_factory):
    """Return a folder with a whole run and three parts of it, solved once for all tests here."""
    root = tmp_path_factory.mktemp("solved")
    run(ensemble(rough), root / "whole")
    for k in (1, 2, 3):
        study = run(ensemble(rough), root / f"part-{k}", part=(k, 3))
        assert study.lost() == []
        assert load_study(root / f"part-{k}").part == f"{k}/3"
    return root


@pytest.fixture
def parts(solved, tmp_path):
    """Return the folders of a whole run and of three parts of it, for a test to change."""
    shutil.copytree(solved, tmp_path, dirs_exist_ok=True)
    return tmp_path / "whole", [tmp_path / f"part-{k}" for k in (1, 2, 3)]


def test_three_parts_are_the_whole(parts, tmp_path):
    whole, folders = parts
    names = [{path.name for path in (folder / FIELDS_FOLDER).glob("*.npz")} for folder in folders]
    solved = [len(own) for own in names]
    assert sum(solved) == len(set.union(*names)) + 2 * FIRST
    assert max(solved) - min(solved) <= 1
    study = merge(folders, tmp_path / "merged")
    assert study.lost() == []
    assert_same(whole, tmp_path / "merged")
    # What is soon solved again is not kept, of the one run as of the merged one.
    kept = [
        {path.name for path in (f / FIELDS_FOLDER).iterdir()} for f in (whole, tmp_path / "merged")
    ]
    assert kept[0] == kept[1] < set.union(*names)
    assert len(load_study(tmp_path / "merged").runs) == 3


def test_a_lost_surface_of_a_whole_run_takes_no_other_with_it(rough, tmp_path):
    """Blocks that were not kept are solved again beside one that was lost, which keeps its why."""
    solved = run(ensemble(rough, methods=["reduced"]), tmp_path / "solved")
    tasks = [task for plan in solved.plans for task in plan.tasks]
    answers = {task.key: solved.solution(task) for task in tasks}
    lost = answers[tasks[0].key]
    lost.converged[3], lost.reasons[3, 0] = False, "made for this test"
    study = Study(solved.plans, tmp_path / "reduced", effort="full")
    study.adopt((task, answers[task.key]) for task in tasks)
    study.save(study.record(1.0))
    run(ensemble(rough, methods=["bem_fft"]), tmp_path / "bem_fft")
    merged = merge([tmp_path / "reduced", tmp_path / "bem_fft"], tmp_path / "merged")
    assert [reason for _, reason in merged.lost()] == ["made for this test"]


def test_a_missing_part_is_told_and_makes_no_half_mean(parts, tmp_path):
    _, folders = parts
    study = merge(folders[:2], tmp_path / "merged")
    assert {reason for _, reason in study.lost()} == {"not done"}
    counts = [table(f)["realisation"].eq("mean").sum() for f in (parts[0], tmp_path / "merged")]
    assert counts[1] < counts[0]
    again = merge([tmp_path / "merged", folders[2]], tmp_path / "all")
    assert again.lost() == []
    assert_same(parts[0], tmp_path / "all")
    assert len(load_study(tmp_path / "all").runs) == 3


def test_a_merged_folder_that_is_resumed_still_lists_its_runs(parts, rough, tmp_path):
    _, folders = parts
    path = folders[0] / STUDY
    path.write_text(json.dumps(json.loads(path.read_text()) | {"interrupted": True}))
    merge(folders[:2], tmp_path / "merged")
    assert load_study(tmp_path / "merged").interrupted
    before = load_study(tmp_path / "merged").runs
    study = run(ensemble(rough), tmp_path / "merged", resume=True)
    assert study.lost() == []
    assert not load_study(tmp_path / "merged").interrupted
    assert load_study(tmp_path / "merged").runs == before
    assert len(before) == 2


def test_methods_and_scenes_of_different_machines_come_together(rough, scene, tmp_path):
    ball = {"methods": ["closed_form", "reduced"]}
    balls = plan_scene(scene(name="ball", compare=ball), "full")
    run([*ensemble(rough), *balls], tmp_path / "whole")
    run(ensemble(rough, methods=["reduced"]), tmp_path / "a")
    run([*ensemble(rough, methods=["bem_fft"]), *balls], tmp_path / "b")
    merge([tmp_path / "a", tmp_path / "b"], tmp_path / "merged")
    assert_same(tmp_path / "whole", tmp_path / "merged")


def test_resolutions_come_together(rough, tmp_path):
    """Each run chooses its numbers of surfaces for the grids that it knows: both are kept."""
    for name, grids in (("a", [32]), ("b", [16])):
        run(ensemble(rough, resolutions=grids), tmp_path / name)
    study = merge([tmp_path / "a", tmp_path / "b"], tmp_path / "merged")
    assert study.lost() == []
    rows = table(tmp_path / "merged")
    assert set(rows[rows["realisation"] == "mean"]["resolution"].astype(float)) == {16, 32}
    (scene,) = load_study(tmp_path / "merged").scenes
    for planned in scene.plan.methods:
        assert len(planned.numbers) == len(planned.resolutions)


def test_grids_of_a_single_contact_come_together(scene, tmp_path):
    """The finest grid of one run, whose pictures are kept, is a coarse one of all."""
    for name, grids in (("whole", [8, 16]), ("a", [8]), ("b", [16])):
        compare = {"methods": ["closed_form", "bem_dense"], "resolutions": grids}
        run(plan_scene(scene(compare=compare), "quick"), tmp_path / name)
    assert merge([tmp_path / "a", tmp_path / "b"], tmp_path / "merged").lost() == []
    rows = [table(tmp_path / name) for name in ("whole", "merged")]
    pd.testing.assert_frame_equal(*rows)


def test_both_machines_are_stated(rough, tmp_path, monkeypatch):
    """The rows of a mean name all machines that solved a part of it.

    The first surfaces, which both solve, are said to be the first one's.
    """
    for k, name in ((1, "laptop"), (2, "server")):
        monkeypatch.setattr(execution, "this_machine", lambda name=name: name)
        run(ensemble(rough, resolutions=[16]), tmp_path / name, part=(k, 2))
    merge([tmp_path / "laptop", tmp_path / "server"], tmp_path / "merged")
    rows = pd.read_csv(tmp_path / "merged" / RESULTS)
    solved = rows[rows["realisation"] == "mean"].groupby("method")["machine"]
    assert set(solved.get_group("reduced")) == {"laptop + server"}
    assert set(solved.get_group("bem_fft")) <= {"laptop", "laptop + server"}


def test_other_versions_or_sources_are_listed(parts, tmp_path):
    _, folders = parts
    study = folders[0] / STUDY
    document = json.loads(study.read_text())
    document["versions"]["numpy"] = "99.9"
    document["source"] = "edited"
    study.write_text(json.dumps(document))
    with pytest.raises(InputError, match=r"numpy: 99.9, here .*\n.*source: edited, here "):
        merge(folders, tmp_path / "merged")
    assert not (tmp_path / "merged").exists()


def test_a_solve_with_two_answers_is_a_conflict(parts, tmp_path):
    whole, _ = parts
    shutil.copytree(whole, tmp_path / "other")
    path = next((tmp_path / "other" / FIELDS_FOLDER).glob("*-bem_fft-16-0-*.npz"))
    solution = load_solution(path)
    solution.quantities["force" if "force" in solution.quantities else "contact_area"] *= 1.01
    save_solution(path, solution)
    with pytest.raises(InputError, match=r"bem_fft 16, realisations from 0: .* differ by 1.0e-02"):
        merge([whole, tmp_path / "other"], tmp_path / "merged")
    solution.quantities["force" if "force" in solution.quantities else "contact_area"] *= np.nan
    save_solution(path, solution)
    with pytest.raises(InputError, match="differ; a value is known to one of them only"):
        merge([whole, tmp_path / "other"], tmp_path / "merged")
    assert [item.name for item in tmp_path.iterdir() if "merged" in item.name] == []


def test_another_scene_of_the_same_name_is_a_conflict(rough, tmp_path):
    run(ensemble(rough, methods=["reduced"]), tmp_path / "a")
    run(ensemble(rough, methods=["bem_fft"], tolerance=0.05), tmp_path / "b")
    with pytest.raises(InputError, match="differ in more than methods and resolutions"):
        merge([tmp_path / "a", tmp_path / "b"], tmp_path / "merged")


def test_a_used_folder_and_a_single_run_are_refused(parts, tmp_path):
    whole, folders = parts
    with pytest.raises(InputError, match="expected a new or empty folder"):
        merge(folders, whole)
    with pytest.raises(InputError, match="expected two runs or more, got 1"):
        merge(folders[:1], tmp_path / "merged")


def test_a_run_named_twice_or_killed_before_its_end_is_refused(parts, tmp_path):
    """What a killed run has solved is in no plan: merging would drop it without a word."""
    _, folders = parts
    again = folders[1] / ".." / folders[1].name
    study = folders[0] / STUDY
    study.write_text(json.dumps(json.loads(study.read_text()) | {"scenes": []}))
    told = r"part-1: ended before .*\n.*part-2: named more than once"
    with pytest.raises(InputError, match=told):
        merge([*folders, again], tmp_path / "merged")
    assert not (tmp_path / "merged").exists()


def test_a_plan_with_a_method_that_is_not_known_here_is_refused(rough, tmp_path):
    folders = [tmp_path / "a", tmp_path / "b"]
    for folder in folders:
        run(ensemble(rough, methods=["reduced"], resolutions=[16]), folder)
    path = folders[0] / STUDY
    document = json.loads(path.read_text())
    document["scenes"][0]["plan"]["methods"][0]["method"] = "other"
    path.write_text(json.dumps(document))
    with pytest.raises(InputError, match="other not known here"):
        merge(folders, tmp_path / "merged")


def test_a_torn_solution_counts_as_missing(parts, tmp_path):
    _, folders = parts
    names = [{path.name for path in (folder / FIELDS_FOLDER).glob("*.npz")} for folder in folders]
    only = min(names[1] - names[0] - names[2])  # the first surfaces are in all parts
    path = folders[1] / FIELDS_FOLDER / only
    path.write_bytes(path.read_bytes()[:-200])
    assert len(merge(folders, tmp_path / "merged").lost()) == 1
