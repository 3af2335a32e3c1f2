"""SIGKILL at any moment: what is finished is kept, nothing torn is read, nothing differs."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import pytest

from comparisons.questions.study import Study
from comparisons.results.store import FIELDS, STUDY, load_study
from comparisons.solving.planning import plan_scene

EXAMPLES = Path(__file__).resolve().parents[3] / "docs" / "examples"


def example(name, monkeypatch):
    """Return a script of the pages as a module."""
    monkeypatch.setenv("PYTHONPATH", str(EXAMPLES.parents[1]))
    spec = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
    script = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, name, script)
    spec.loader.exec_module(script)
    return script


@pytest.mark.slow
def test_runs_killed_at_random_moments_end_like_undisturbed_ones(monkeypatch):
    """Three moments of the twenty of docs/cluster.md, on two processes."""
    script = example("killed_runs", monkeypatch)
    result, total = script.experiment(runs=3, workers=2, realisations=50, seed=7)
    assert all(part.identical for part in result)
    assert all(part.redone == 0 and part.left == 0 for part in result)
    assert all(part.solves <= total for part in result)


def test_what_a_kill_leaves_behind_is_cleaned_and_does_not_stop_a_resume(scene, tmp_path):
    """Temporary files beside whole ones, tables without a study, a torn solution."""
    plans = plan_scene(scene(compare={"methods": ["closed_form", "reduced"]}))
    Study(plans, tmp_path).run()
    fields = tmp_path / FIELDS
    (path, *_) = sorted(fields.glob("*.npz"))
    ours = [
        *(tmp_path / f".{name}.abcd1234" for name in ("results.csv", "study.json", "report.html")),
        *(fields / f".{path.name}.abcd_234", fields / f".{path.stem}.vtu.abcd1234"),
    ]
    theirs = [tmp_path / ".gitignore", tmp_path / ".notes.txt.abcd1234", fields / ".hidden"]
    for part in (*ours, *theirs):
        part.write_bytes(b"torn")
    path.write_bytes(path.read_bytes()[:100])
    study = Study(plans, tmp_path, resume=True)
    study.run()
    assert study.lost() == []
    assert not any(part.exists() for part in ours)
    assert all(part.exists() for part in theirs)


def test_a_folder_is_known_as_ours_from_the_first_moment(scene, tmp_path, monkeypatch):
    """Killed between results.csv and study.json, a first run must not look like someone else's."""
    plans = plan_scene(scene(compare={"methods": ["closed_form"]}))
    seen = []

    def killed(study):
        seen.append(load_study(study.directory).interrupted)
        raise MemoryError

    with monkeypatch.context() as patched:
        patched.setattr(Study, "inquiries", killed)
        with pytest.raises(MemoryError):
            Study(plans, tmp_path / "out").run()
    assert seen == [True]
    assert (tmp_path / "out" / STUDY).exists()
    Study(plans, tmp_path / "out", resume=True).run()
    assert not load_study(tmp_path / "out").interrupted


@pytest.mark.slow
def test_an_ensemble_killed_at_random_moments_has_the_digits_of_an_undisturbed_one(
    tmp_path, monkeypatch
):
    """Six kills of the twelve of docs/cluster.md, of small surfaces."""
    pytest.importorskip("pyarrow")
    script = example("ensembles", monkeypatch)
    monkeypatch.setattr(script.ensemble, "TASK_SECONDS", script.ensemble.TASK_SECONDS)
    left, identical = script.kill(tmp_path, 150, 6, points=16, task=0.1)
    assert identical
    kept = [state.surfaces for state in left]
    assert kept == sorted(kept)
