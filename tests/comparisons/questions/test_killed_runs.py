"""SIGKILL at any moment: what is finished is kept, nothing torn is read, nothing differs."""

import subprocess
import sys
from pathlib import Path

import pytest

from comparisons.errors import ResultsError
from comparisons.questions.study import Study
from comparisons.results.folder import LOCK
from comparisons.results.record import FIELDS_FOLDER
from comparisons.results.store import STUDY, load_study
from comparisons.solving.planning import plan_scene

EXAMPLES = Path(__file__).resolve().parents[3] / "docs" / "examples"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "workers", "runs"),
    [
        ("run", "0", "3"),
        pytest.param("run", "2", "1", marks=pytest.mark.nightly),
        ("claims", "0", "1"),
        ("ensemble", "0", "2"),
    ],
)
def test_what_is_killed_at_random_moments_ends_like_what_is_not(kind, workers, runs, monkeypatch):
    """A few moments of the twenty of docs/cluster.md, and one of a command with two processes.

    Each command spends seconds on its start, in which nothing can be torn.
    """
    monkeypatch.setenv("PYTHONPATH", str(EXAMPLES.parents[1]))
    words = [kind, "--workers", workers, "--runs", runs, "--size", "20", "--seed", "7"]
    command = [sys.executable, EXAMPLES / "killed_runs.py", *words]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    lines = [line.strip("| ").split(" | ") for line in done.stdout.splitlines()[-int(runs) :]]
    for _, kept, _, redone, left, identical in lines:
        assert (redone, left, identical) == ("0", "0", "yes")
        solves, total = map(int, kept.split(" of "))
        assert solves <= total


def test_what_a_kill_leaves_behind_is_cleaned_and_does_not_stop_a_resume(scene, tmp_path):
    """Temporary files beside whole ones, tables without a study, a torn solution."""
    plans = plan_scene(scene(compare={"methods": ["closed_form", "reduced"]}))
    Study(plans, tmp_path).run()
    fields = tmp_path / FIELDS_FOLDER
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


HOLDER = """
import signal, sys
from pathlib import Path
from comparisons.results.folder import held
with held(Path(sys.argv[1])), held(Path(sys.argv[1])):
    print("held", flush=True)
    signal.pause()
"""


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
def test_one_process_writes_a_folder_and_a_killed_one_lets_go(scene, tmp_path, monkeypatch):
    """The other one is told who has it, nothing is touched, and what a kill leaves is no result."""
    monkeypatch.setenv("PYTHONPATH", str(EXAMPLES.parents[1]))
    plans = plan_scene(scene(compare={"methods": ["closed_form"]}))
    out = tmp_path / "out"
    command = [sys.executable, "-c", HOLDER, out]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as holder:
        assert holder.stdout.readline() == "held\n"
        for options in ({}, {"overwrite": True}, {"resume": True}):
            with pytest.raises(ResultsError, match=f"in use by process {holder.pid} since 2"):
                Study(plans, out, **options).run()
        holder.kill()
    assert [path.name for path in out.iterdir()] == [LOCK]
    Study(plans, out).run()
    assert not (out / LOCK).exists()
