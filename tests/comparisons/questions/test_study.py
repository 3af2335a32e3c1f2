"""Studies: what is done is kept, resumed without doing it again, and the same with workers."""

import time
from contextlib import nullcontext
from dataclasses import replace
from unittest.mock import Mock

import meshio
import numpy as np
import pandas as pd
import pytest

from comparisons.errors import ResultsError
from comparisons.judging.truth import NO_REFERENCE, Truth
from comparisons.methods.normal.reduced import ReducedProfile
from comparisons.methods.registry import SOLVERS, concerned
from comparisons.questions import study as study_module
from comparisons.questions.study import Study
from comparisons.results import store
from comparisons.results.advice import advise
from comparisons.results.record import FIELDS_FOLDER
from comparisons.results.store import MEASURES, RESULTS, STUDY, TO_TAKE, load_study
from comparisons.scene.scene import load_scene
from comparisons.solving.execution import execute
from comparisons.solving.jobs import Done, Executor, Job, SerialExecutor
from comparisons.solving.planning import plan_scene
from comparisons.tasks import task as task_module
from comparisons.tasks.shown_loads import SHOWN_ONLY, stored_steps

# Columns that differ from run to run by their nature.
CLOCK = ["seconds", "setup_seconds", "seconds_all", "setup_seconds_all", "compile_seconds"]
CLOCK += ["memory"]


@pytest.fixture
def ball(scene):
    """Return plans of four quick solves: three of the ball, one closed form."""
    compared = {"methods": ["closed_form", "reduced", "bem_fft"], "resolutions": [6, 12]}
    return plan_scene(scene(compare=compared | {"quantities": ["force", "pressure"]}))


@pytest.fixture
def counted(monkeypatch):
    done = []

    def count(task):
        done.append(task)
        return execute(task)

    monkeypatch.setattr(study_module, "execute", count)
    return done


def interrupt_after(monkeypatch, number):
    """Let a keyboard interrupt fall into the solve after `number` whole ones."""
    done = []

    def stop(task, **how):
        if len(done) == number:
            raise KeyboardInterrupt
        done.append(task)
        return execute(task, **how)

    monkeypatch.setattr(study_module, "execute", stop)


def results(directory) -> pd.DataFrame:
    return pd.read_csv(directory / RESULTS, dtype={"realisation": str}).drop(columns=CLOCK)


def snapshot(directory):
    return {
        path.relative_to(directory): path.read_bytes()
        for path in directory.rglob("*")
        if path.is_file()
    }


def test_a_run_leaves_the_files_of_the_contract(ball, tmp_path):
    directory = tmp_path / "out"
    record = Study(ball, directory, command="roughline run test.toml", paraview=True).run()
    names = {path.name for path in directory.iterdir()}
    assert names == {RESULTS, MEASURES, TO_TAKE, STUDY, FIELDS_FOLDER}
    assert len(list((directory / FIELDS_FOLDER).glob("*.npz"))) == 5
    assert len(list((directory / FIELDS_FOLDER).glob("*.vtu"))) == 2  # the grids
    assert not record.interrupted
    assert record.command == "roughline run test.toml"
    assert record.machine["threads"] == 1
    assert "numpy" in record.versions


def test_bars_are_recorded_at_every_load_and_small_disagreements_as_footnotes(
    ball, tmp_path, monkeypatch
):
    """A disagreement is said in one place."""

    def told(truth, quantities, tolerance=0.0, titles=()):
        return ("large",) if tolerance else ("large", "small")

    monkeypatch.setattr(Truth, "disagreements", told)
    (scene,) = Study(ball, tmp_path).run().scenes
    loads = len(ball[0].loads.values)
    assert loads > 1
    bars = scene.reference.sources["force"]
    assert bars
    assert all(len(bar) == loads for bar in bars.values())
    assert (scene.disagreements, scene.reference.footnotes) == (("large",), ("small",))


def test_code_is_compiled_before_the_first_solve_here_and_only_for_what_is_missing(
    ball, tmp_path, monkeypatch, counted
):
    """Beside a solve it would spoil its time; processes of their own see to it themselves."""
    asked, told = [], []

    def ahead(tasks):
        asked.append(([task.key for task in tasks], len(counted)))
        yield Done(Job("code", len), seconds=2.0)

    monkeypatch.setattr(study_module, "compile_ahead", ahead)
    study = Study(ball, tmp_path, watch=lambda study, done: told.append(done and done.job.key))
    study.run()
    keys = [task.key for task in study.plans[0].tasks]
    assert asked == [(keys, 0)]
    assert told[:2] == [None, "code"]
    counted.clear()
    (tmp_path / FIELDS_FOLDER / f"{keys[-1]}.npz").unlink()
    Study(ball, tmp_path, resume=True).run()
    assert asked[1:] == [([keys[-1]], 0)]

    class Elsewhere(Executor):
        finished = SerialExecutor.finished

    Study(ball, tmp_path, overwrite=True, executor=Elsewhere()).run()
    assert len(asked) == 2


def test_speeds_beyond_the_range_of_a_fit_are_not_lost(tmp_path):
    """The command ends well: that the fit has no answer there is said as the scene is judged."""
    plans = plan_scene(load_scene("soft-ball-film", {"compare.methods": ["hamrock_dowson"]}))
    study = Study(plans, tmp_path)
    study.run()
    (task,) = plans[0].tasks
    assert study.solution(task).converged.tolist() == [[True, False, False]]
    assert study.lost() == []
    assert load_study(tmp_path).scenes[0].failures == []


@pytest.mark.slow
def test_files_for_paraview_are_whole_when_a_run_that_wrote_none_is_resumed(ball, tmp_path):
    """A run keeps what its pages show: displacements are solved for again."""
    Study(ball, tmp_path / "whole", paraview=True).run()
    Study(ball, tmp_path / "later").run()
    Study(ball, tmp_path / "later", resume=True, paraview=True).run()
    for path in (tmp_path / "whole" / FIELDS_FOLDER).glob("*.vtu"):
        files = (tmp_path / run / FIELDS_FOLDER / path.name for run in ("whole", "later"))
        whole, later = map(meshio.read, files)
        assert "displacement" in whole.point_data | whole.cell_data
        assert set(later.point_data | later.cell_data) == set(whole.point_data | whole.cell_data)


@pytest.mark.slow
@pytest.mark.parametrize("killed", [False, True])
def test_the_finest_grid_has_all_that_pages_show_when_a_run_is_resumed_with_fewer(
    scene, tmp_path, killed
):
    """The run before left it out on a coarser grid, which is now the finest."""
    compared = {"methods": ["closed_form", "bem_fft"], "quantities": ["force", "pressure"]}
    both, coarse = (
        plan_scene(scene(compare=compared | {"resolutions": n})) for n in ([6, 12], [6])
    )

    def kill(study, _):
        if killed and study.under_way.counts[0] == study.under_way.counts[1]:
            raise MemoryError

    with pytest.raises(MemoryError) if killed else nullcontext():
        Study(both, tmp_path / "out", watch=kill).run()
    (record,) = Study(coarse, tmp_path / "out", resume=True).run().scenes
    assert stored_steps(record.load_fields("bem_fft", 6)) == [0, 1]


def test_a_part_expects_its_share_of_the_surfaces_that_pilots_will_ask_for(rough, tmp_path):
    """All parts solve the pilots."""
    plans = plan_scene(rough(realisations=200, compare={"methods": ["bem_fft"]}))
    told = {}

    def stop(study, _):
        told[study.part] = study.remaining().seconds, study.under_way.remaining([]).seconds
        raise KeyboardInterrupt

    for part in ((1, 1), (1, 2), (2, 2)):
        with pytest.raises(KeyboardInterrupt):
            Study(plans, tmp_path / f"{part}", part=part, watch=stop).run()
    (whole, pilots), *parts = told.values()
    (one, _), (other, _) = parts
    assert whole > pilots > 0
    assert one + other == pytest.approx(whole + pilots)


def test_the_body_is_stressed_on_the_finest_grid_alone(scene):
    """Pages show no other; on it stresses take as long as a solve."""
    compared = {"methods": ["fem"], "resolutions": [2], "quantities": ["force", "pressure"]}
    (task,) = (t for t in plan_scene(scene(compare=compared))[0].tasks if t.method == "fem")
    fine, coarse = (study_module.solve_task(task, finest=finest) for finest in (True, False))
    shown_only = {name for name in fine.fields if name.startswith(SHOWN_ONLY)}
    assert {"mesh_von_mises", "step.0.pressure"} <= shown_only
    assert set(coarse.fields) == set(fine.fields) - shown_only
    np.testing.assert_array_equal(coarse.fields["pressure"], fine.fields["pressure"])


@pytest.mark.slow
def test_a_run_that_is_killed_while_it_writes_leaves_no_verdicts_beside_other_rows(
    ball, tmp_path, monkeypatch
):
    Study(ball, tmp_path / "out").run()
    with monkeypatch.context() as patch:
        patch.setattr(store, "write_table", Mock(side_effect=KeyboardInterrupt))
        with pytest.raises(KeyboardInterrupt):
            Study(ball, tmp_path / "out", resume=True).run()
    killed = load_study(tmp_path / "out")
    assert (killed.scenes, killed.interrupted) == ((), True)
    assert len(Study(ball, tmp_path / "out", resume=True).run().scenes) == 1


def test_the_table_has_a_row_for_every_solve_and_step_and_the_columns_of_the_contract(
    ball, tmp_path
):
    Study(ball, tmp_path / "out").run()
    table = pd.read_csv(tmp_path / "out" / RESULTS)
    contract = "scene method options resolution realisation step penetration force contact_area "
    contract += "contact_area_raw error_force reference reference_uncertainty seconds "
    contract += "setup_seconds compile_seconds unknowns iterations violation converged reason "
    contract += "memory threads machine"
    assert set(contract.split()) <= set(table.columns)
    solved = table[table["step"].notna()]
    assert solved.groupby(["method", "resolution"]).size().to_dict() == {
        ("closed_form", 1): 3,
        ("reduced", 6): 3,
        ("reduced", 12): 3,
        ("bem_fft", 6): 3,
        ("bem_fft", 12): 3,
    }
    # Methods that were not run have a row with the reason.
    refused = table[table["step"].isna()].set_index("method")["reason"]
    others = set(concerned(load_scene("paraboloid")))
    others -= set(solved["method"])
    assert refused.to_dict() == dict.fromkeys(others, "not asked for")
    hertz = 4 / 3 * 210e9 / 0.91 * 0.1 * solved["penetration"] ** 1.5
    np.testing.assert_allclose(solved["force"], hertz, rtol=2e-2)
    assert (solved["seconds"] > 0).all()
    assert (solved["setup_seconds"] <= solved["seconds"]).all()


def test_a_used_folder_is_left_alone(ball, tmp_path, counted):
    (tmp_path / "notes.txt").write_text("mine")
    before = snapshot(tmp_path)
    with pytest.raises(ResultsError, match="is not empty: use --resume"):
        Study(ball, tmp_path).run()
    assert snapshot(tmp_path) == before
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]
    assert counted == []


def test_a_finished_folder_is_named_as_such_and_resuming_it_keeps_its_time(ball, tmp_path):
    """Nothing is in use, and nothing is solved again: the run took what it took."""
    first = Study(ball, tmp_path / "out").run()
    with pytest.raises(ResultsError, match="out has results already: use --resume"):
        Study(ball, tmp_path / "out").run()
    again = Study(ball, tmp_path / "out", resume=True).run()
    assert again.seconds > first.seconds


@pytest.mark.slow
def test_what_the_comparison_takes_counts_into_the_time_of_the_run(ball, tmp_path, monkeypatch):
    """Proofs of the quick suite once took longer than the four minutes that it claimed."""
    compared = study_module.record_scene

    def slowly(*arguments, **how):
        time.sleep(0.2)
        return compared(*arguments, **how)

    known = Study(ball, tmp_path / "out").run()
    monkeypatch.setattr(study_module, "record_scene", slowly)
    again = Study(ball, tmp_path / "out", resume=True).run()
    assert again.seconds > known.seconds + 0.2


def test_theorems_are_asked_at_the_end_only(scene, tmp_path, monkeypatch):
    """Of a rough patch they take half a minute: ctrl-C does not wait for them."""
    asked = {"methods": ["closed_form", "reduced", "bem_fft"], "resolutions": [6], "proved": True}
    plans = plan_scene(scene(compare=asked))
    with monkeypatch.context() as patch:
        interrupt_after(patch, 2)
        with pytest.raises(KeyboardInterrupt):
            Study(plans, tmp_path).run()
    stopped = load_study(tmp_path).scenes
    finished = Study(plans, tmp_path, resume=True).run().scenes
    assert not any(record.reference.proved for record in stopped)
    assert all(record.reference.proved.bars for record in finished)


def test_resuming_and_overwriting_exclude_each_other(ball, tmp_path):
    with pytest.raises(ResultsError, match="--resume and --overwrite: expected at most one"):
        Study(ball, tmp_path / "out", resume=True, overwrite=True).run()
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_overwriting_solves_everything_anew_and_spares_other_files(ball, tmp_path, counted):
    (tmp_path / "notes.txt").write_text("mine")
    Study(ball, tmp_path, overwrite=True).run()
    (tmp_path / FIELDS_FOLDER / "stale-fem-3-0-0123456789ab.npz").write_bytes(b"old")
    (tmp_path / FIELDS_FOLDER / "mine.npz").write_bytes(b"not roughline's")
    Study(ball, tmp_path, overwrite=True).run()
    assert len(counted) == 10
    assert (tmp_path / "notes.txt").read_text() == "mine"
    assert (tmp_path / FIELDS_FOLDER / "mine.npz").read_bytes() == b"not roughline's"
    assert len(list((tmp_path / FIELDS_FOLDER).glob("*.npz"))) == 5 + 1


def test_resuming_solves_only_what_is_missing_torn_or_changed(ball, scene, tmp_path, counted):
    Study(ball, tmp_path / "out").run()
    first = results(tmp_path / "out")
    counted.clear()
    Study(ball, tmp_path / "out", resume=True).run()
    assert counted == []
    files = {path.name: path for path in (tmp_path / "out" / FIELDS_FOLDER).glob("*.npz")}
    (torn,) = [files[name] for name in files if "bem_fft-12" in name]
    torn.write_bytes(torn.read_bytes()[:-300])
    (missing,) = [files[name] for name in files if "reduced-6" in name]
    missing.unlink()
    (foreign,) = [files[name] for name in files if "bem_fft-6" in name]
    foreign.write_bytes(b"no npz at all")
    Study(ball, tmp_path / "out", resume=True).run()
    assert {(task.method, task.resolution) for task in counted} == {
        ("bem_fft", 12),
        ("reduced", 6),
        ("bem_fft", 6),
    }
    pd.testing.assert_frame_equal(results(tmp_path / "out"), first)
    counted.clear()
    stiffer = plan_scene(
        scene(compare={"methods": ["closed_form"]}, half_space={"effective_modulus": 1e9})
    )
    Study(stiffer, tmp_path / "out", resume=True).run()
    assert len(counted) == 1


def test_an_interrupt_keeps_what_is_done_and_resuming_completes_it(ball, tmp_path, monkeypatch):
    """The interrupted and resumed run has the very numbers of an undisturbed one."""
    Study(ball, tmp_path / "whole").run()
    interrupt_after(monkeypatch, 2)
    with pytest.raises(KeyboardInterrupt):
        Study(ball, tmp_path / "out").run()
    kept = results(tmp_path / "out")
    assert set(kept.loc[kept["step"].notna(), "method"]) == {"closed_form", "reduced"}
    record = load_study(tmp_path / "out")
    assert record.interrupted
    assert record.scenes[0].reference.method == "closed_form"
    monkeypatch.setattr(study_module, "execute", execute)
    record = Study(ball, tmp_path / "out", resume=True).run()
    assert not record.interrupted
    pd.testing.assert_frame_equal(results(tmp_path / "out"), results(tmp_path / "whole"))


def test_a_lost_load_is_told_with_the_reason_of_the_same_surface(rough, tmp_path):
    """The first surface ends at the last load, the second one earlier."""
    few = {"methods": ["bem_fft"], "resolutions": [16]}
    plans = plan_scene(rough(realisations=2, loading={"force": [1e-6, 2e-6, 3e-6]}, compare=few))
    study = Study(plans, tmp_path / "out")
    (task,) = plans[0].tasks
    solution = execute(task)
    solution.fail((0, 2), "late")
    solution.fail((1, 1), "early")
    study.adopt([(task, solution)])
    told = "2 of 3 load steps, the first is load step 2: early"
    assert [reason for _, reason in study.lost()] == [told]


@pytest.mark.slow
def test_an_interrupted_block_of_realisations_is_not_half_a_mean(rough, tmp_path, monkeypatch):
    """Two blocks of 25; with one of them, no mean of the ensemble is shown."""
    many = rough(realisations=30, compare={"methods": ["bem_fft"], "resolutions": [16]})
    plans = plan_scene(many, "full")
    assert len(plans[0].tasks) == 2
    interrupt_after(monkeypatch, 1)
    with pytest.raises(KeyboardInterrupt):
        Study(plans, tmp_path / "out", effort="full").run()
    assert "mean" not in str((tmp_path / "out" / RESULTS).read_text())
    monkeypatch.setattr(study_module, "execute", execute)
    Study(plans, tmp_path / "out", effort="full", resume=True).run()
    table = results(tmp_path / "out")
    solved = table[table["step"].notna()]
    assert solved["realisation"].tolist() == [
        *(str(k) for k in range(30) for _ in range(2)),
        *("mean", "mean"),
    ]


@pytest.mark.parametrize(
    ("what", "now"), [("versions", {"numpy": "99"}), ("source_digest", "edited")]
)
def test_other_packages_or_an_edited_source_solve_anew(
    ball, tmp_path, counted, monkeypatch, what, now
):
    """What another numpy, or another roughline, found is not mixed with what this one finds."""
    Study(ball, tmp_path / "out").run()
    counted.clear()
    monkeypatch.setattr(task_module, what, lambda: now)
    again = [replace(plan) for plan in ball]  # plans made anew, as another process would
    Study(again, tmp_path / "out", resume=True).run()
    assert len(counted) == 5


def test_full_effort_refines_the_truth_in_the_folder(scene, tmp_path):
    """A square punch, known to a fifth of 2 % only on finer grids than the two planned.

    Resolutions that a scene lists are not refined, so these are planned by hand.
    """
    compared = {"methods": ["reduced", "bem_fft"], "tolerance": 0.02}
    (plan,) = plan_scene(
        scene(indenter={"shape": "square_punch", "side": 1e-3}, compare=compared), "full"
    )
    coarse = [replace(m, resolutions=(2, 4)) if m.supported else m for m in plan.methods]
    told = []
    Study(
        [replace(plan, methods=tuple(coarse))],
        tmp_path / "out",
        effort="full",
        watch=lambda study, _: told.append(study.remaining().complete),
    ).run()
    assert told[:-1] == [False] * (len(told) - 1)  # a finer grid may follow
    assert told[-1]
    record = load_study(tmp_path / "out").scenes[0]
    assert record.reference.method == "bem_fft"
    assert record.reference.resolution > 4
    assert np.sqrt(np.mean(record.reference.known_to("force") ** 2)) <= 0.02 / 5
    (planned,) = [m for m in record.plan.methods if m.method == "bem_fft"]
    assert planned.resolutions[-1] == record.reference.resolution


def test_a_method_that_fails_costs_its_rows_and_is_tried_again_on_resume(
    ball, tmp_path, monkeypatch, counted
):
    """Else a fixed bug, or a machine with more memory, would never get its chance."""

    class Broken(ReducedProfile):
        def solve(self, task):
            raise RuntimeError("out of springs")

    with monkeypatch.context() as broken:
        broken.setitem(SOLVERS, "reduced", (Broken,))
        study = Study(ball, tmp_path / "out")
        study.run()
    lost = [(task.method, task.resolution, reason) for task, reason in study.lost()]
    reason = "RuntimeError: out of springs (in solve)"
    assert lost == [("reduced", 6, reason), ("reduced", 12, reason)]
    table = results(tmp_path / "out")
    broken = table[table["method"] == "reduced"]
    assert not broken["converged"].any()
    assert broken["penetration"].tolist() == [1e-6, 2e-6, 4e-6] * 2
    assert table.loc[table["method"] == "bem_fft", "converged"].all()
    counted.clear()
    study = Study(ball, tmp_path / "out", resume=True)
    study.run()
    assert {task.method for task in counted} == {"reduced"}
    assert study.lost() == []


def test_without_any_truth_the_rows_are_there_and_the_answer_says_so(scene, tmp_path):
    square = {"shape": "square_punch", "side": 1e-3}
    only = scene(indenter=square, compare={"methods": ["reduced"], "resolutions": [10]})
    record = Study(plan_scene(only), tmp_path / "out").run()
    assert record.scenes[0].reference == NO_REFERENCE
    assert "so no reference is available" in advise(record.scenes[0]).sentence
    assert load_study(tmp_path / "out").scenes[0].reference == NO_REFERENCE
