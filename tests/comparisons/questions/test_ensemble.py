"""Very many surfaces: bundles, parts and kills change no digit, memory does not grow.

Slurm's part in docs/cluster.md is played by stand-ins for `sbatch` and `scancel`.
"""

import errno
import os
import re
import shlex
import signal
import subprocess
import sys
import time
import tracemalloc
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from comparisons.errors import InputError, LostWorkError, ResultsError
from comparisons.questions import ensemble as questions
from comparisons.questions.ensemble import Ensemble
from comparisons.questions.merging import merge_ensembles
from comparisons.results.ensemble_folder import (
    SURFACES,
    Bundle,
    load_ensemble,
    summary,
    survey,
    write_bundle,
)
from comparisons.scene.scene import load_scene
from comparisons.solving.jobs import Done, SerialExecutor
from comparisons.tasks.solution import FLAGS, Solution

pytestmark = pytest.mark.slow

pytest.importorskip("pyarrow")
METHODS = {"methods": ["reduced", "bem_fft"]}


@pytest.fixture(scope="module")
def many(rough):
    """Return a maker of scenes with a number of surfaces of 16 x 16 points."""
    return lambda number=45: rough(realisations=number, compare=METHODS)


@pytest.fixture(scope="module")
def whole(many, tmp_path_factory):
    return Ensemble(many(), tmp_path_factory.mktemp("whole") / "out").run()


def digests(result):
    return [setting.digest for setting in result.record.settings]


class Ending(SerialExecutor):
    """Loses a job and all after it, as when the process is killed."""

    def __init__(self, after):
        super().__init__()
        self.after = after

    def finished(self):
        for number, done in enumerate(super().finished()):
            if number == self.after:
                raise LostWorkError("killed")
            yield done


def test_statistics_are_those_of_the_rows(whole, many, tmp_path):
    result = Ensemble(many(30), tmp_path / "out").run()
    rows = pd.concat(
        pd.read_parquet(path).assign(method=bundle.method)
        for files in survey(tmp_path / "out" / SURFACES).values()
        for path, bundle in files.items()
    )
    assert sorted(rows.groupby("method").size()) == [60, 60]
    means = rows.groupby(["method", "step"])["contact_area"].agg(["mean", "std", "min", "max"])
    table = result.statistics.query("quantity == 'contact_area'").set_index(["method", "step"])
    table = table.loc[means.index, ["mean", "standard_deviation", "minimum", "maximum"]]
    assert np.allclose(table.to_numpy(float), means.to_numpy(float), rtol=1e-12)


def test_parts_and_bundles_of_any_size_give_the_same_digits(whole, many, tmp_path, monkeypatch):
    """Three uneven parts, cut where they please, merged."""
    monkeypatch.setattr(questions, "LEAST_BUNDLES", 1)
    for k in (1, 2, 3):
        assert len(Ensemble(many(), tmp_path / str(k), part=(k, 3)).run().record.missing) == 0
    merged = merge_ensembles([tmp_path / str(k) for k in (3, 1, 2)], tmp_path / "all")
    assert digests(merged) == digests(whole)
    assert merged.statistics.equals(whole.statistics)
    assert merged.record.missing == []
    assert load_ensemble(tmp_path / "all") == merged.record
    assert len(merged.record.runs) == 3
    again = Ensemble(many(), tmp_path / "all", resume=True).run()
    assert again.record.runs == merged.record.runs


def test_a_part_may_be_empty(many, tmp_path):
    """More parts than surfaces, as of a job array of a fixed size."""
    folders = [tmp_path / str(k) for k in (1, 2)]
    for k, folder in enumerate(folders, start=1):
        record = Ensemble(many(1), folder, part=(k, 2)).run().record
        assert record.missing == []
        assert len(record.settings) == (2 if k == 2 else 0)
    assert merge_ensembles(folders, tmp_path / "all").record.missing == []


def test_a_killed_ensemble_solves_only_what_no_whole_file_has(whole, many, tmp_path):
    """One bundle is lost by the kill, and one written file is torn afterwards."""
    with pytest.raises(LostWorkError):
        Ensemble(many(), tmp_path, executor=Ending(3)).run()
    kept = sorted((tmp_path / SURFACES).iterdir())
    torn, *sound = kept
    torn.write_bytes(torn.read_bytes()[:-50])
    times = [path.stat().st_mtime_ns for path in sound]
    again = Ensemble(many(), tmp_path, resume=True).run()
    assert digests(again) == digests(whole)
    assert [path.stat().st_mtime_ns for path in sound] == times
    assert again.record.missing == []


def test_a_folder_is_continued_whatever_file_a_full_disk_ended_at(many, tmp_path, monkeypatch):
    """The first table, before any surface: the folder must not look like someone else's."""

    def full(*_):
        raise OSError(errno.ENOSPC, "no space left on device")

    with monkeypatch.context() as patch:
        patch.setattr("comparisons.questions.ensemble.write_table", full)
        with pytest.raises(OSError, match="no space left"):
            Ensemble(many(2), tmp_path / "out").run()
    assert load_ensemble(tmp_path / "out").interrupted
    again = Ensemble(many(2), tmp_path / "out", resume=True).run()
    assert (again.record.missing, again.record.interrupted) == ([], False)


def test_surfaces_in_two_files_count_once(whole, many, tmp_path):
    """Two processes in one folder, which cut bundles differently."""
    run = Ensemble(many(), tmp_path / "out")
    run.run()
    task = next(iter(run.tasks.values()))
    job = questions.bundle_job(task, range(1, 12))
    write_bundle(tmp_path / "out" / SURFACES / f"{job.key}.parquet", job.work(*job.arguments))
    again = Ensemble(many(), tmp_path / "out", resume=True).run()
    assert digests(again) == digests(whole)
    assert [setting.surfaces for setting in again.record.settings] == [45, 45]


def test_two_grids_of_one_method_are_two_settings(rough, tmp_path):
    """As each grid by itself: also continued, and joined from two parts."""

    def run(grids, name, **options):
        scene = rough(realisations=9, compare={"methods": ["bem_fft"], "resolutions": grids})
        return Ensemble(scene, tmp_path / name, **options).run()

    alone = [*digests(run([8], "coarse")), *digests(run([16], "fine"))]
    assert len(set(alone)) == 2
    for k in (1, 2):
        run([8, 16], str(k), part=(k, 2))
    merged = merge_ensembles([tmp_path / "1", tmp_path / "2"], tmp_path / "all")
    for result in (run([8, 16], "both"), run([8, 16], "both", resume=True), merged):
        assert digests(result) == alone
        assert [setting.surfaces for setting in result.record.settings] == [9, 9]


def test_an_ensemble_grows_to_more_surfaces(whole, many, tmp_path):
    small = Ensemble(many(20), tmp_path).run()
    assert [setting.surfaces for setting in small.record.settings] == [20, 20]
    grown = Ensemble(many(), tmp_path, resume=True).run()
    assert digests(grown) == digests(whole)
    with pytest.raises(ResultsError, match="holds 45 surfaces: expected at least as many, got 20"):
        Ensemble(many(20), tmp_path, resume=True).run()


def test_a_merge_says_what_is_missing_and_refuses_what_is_there_twice(many, tmp_path):
    for k in (1, 3):
        Ensemble(many(), tmp_path / str(k), part=(k, 3)).run()
    merged = merge_ensembles([tmp_path / "1", tmp_path / "3"], tmp_path / "all")
    assert merged.record.missing == [f"{m} 16: surfaces 15 to 29" for m in ("reduced", "bem_fft")]
    with pytest.raises(InputError, match=r"more than one folder:\n .* both have surface 0"):
        merge_ensembles([tmp_path / "1", tmp_path / "all"], tmp_path / "twice")
    Ensemble(many(44), tmp_path / "2", part=(2, 3)).run()
    with pytest.raises(InputError, match="expected the scene and the number of surfaces of"):
        merge_ensembles([tmp_path / "1", tmp_path / "2"], tmp_path / "twice")
    assert not (tmp_path / "twice").exists()


def test_curves_do_not_stay_in_memory(many, tmp_path):
    values: list[Done] = []
    run = Ensemble(many(), tmp_path, watch=lambda campaign, done: values.append(done))
    run.run()
    assert len(values) > 3
    assert all(done.value.solution is None for done in values if done)


def test_memory_of_a_merge_does_not_grow_with_the_surfaces(tmp_path):
    """Statistics of 2 and of 8 bundles of 10 000 surfaces: within a fifth, where 4 times is all."""
    peaks = []
    for number in (2, 8):
        files = {}
        for k in range(number):
            solution = Solution(
                quantities={"force": np.arange(20_000.0).reshape(10_000, 2)},
                converged=np.ones((10_000, 2), dtype=bool),
                **dict.fromkeys(FLAGS[1:], np.zeros((10_000, 2), dtype=bool)),
                iterations=np.ones((10_000, 2), dtype=int),
                violation=np.ones((10_000, 2)),
                unknowns=1,
            )
            bundle = Bundle("m", 8, "id", 10_000 * k, 10_000, answers=20_000, solution=solution)
            files[tmp_path / f"{k}"] = bundle
            write_bundle(tmp_path / f"{k}", bundle)
        tracemalloc.start()
        record, table = summary(files, "penetration", [0.0, 1.0])
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
        assert record.surfaces == number * 10_000
        assert table["count"].tolist() == [number * 10_000] * 2
    assert peaks[1] < 1.2 * peaks[0]


def test_ensembles_are_refused_with_the_reason(scene, rough, many, tmp_path, monkeypatch):
    with pytest.raises(InputError, match="expected a random surface"):
        Ensemble(scene(), tmp_path / "out")
    Ensemble(many(2), tmp_path / "out").run()
    other = rough(realisations=2, rms_slope=0.2, compare=METHODS)
    with pytest.raises(ResultsError, match="another scene, method or version"):
        Ensemble(other, tmp_path / "out", resume=True).run()
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(InputError, match=r"pip install 'roughline\[parquet\]'"):
        Ensemble(many(2), tmp_path / "none")
    assert not (tmp_path / "none").exists()


DOCS = Path(__file__).resolve().parents[3] / "docs"
# What the stand-in reads of a real one: options of the command line over those of the script.
SBATCH = """#!{python}
import os, pathlib, re, subprocess, sys
words, options = sys.argv[1:], {{}}
while words and words[0].startswith("--"):
    name, _, value = words.pop(0)[2:].partition("=")
    options[name] = value or (words.pop(0) if name == "wrap" else "")
home = pathlib.Path({home!r})
number = len(list(home.glob("*.job"))) + 1
script = home / f"{{number}}.job"
text = "#!/bin/bash\\n" + options["wrap"] if "wrap" in options else open(words.pop(0)).read()
script.write_text(text)
given = dict(re.findall(r"^#SBATCH --([a-z-]+)=(\\S+)", text, re.M)) | options
first, last = map(int, given.get("array", "1-1").split("-"))
waited = options.get("dependency", "afterok:").partition(":")[2]
assert not waited or (home / f"{{waited}}.ok").exists(), f"job {{waited}} did not end well"
start = subprocess.Popen if "array" not in given and "wrap" not in given else subprocess.call
ended = []
for task in range(first, last + 1):
    slurm = {{"ARRAY_TASK_ID": task, "ARRAY_TASK_COUNT": last - first + 1, "JOB_ID": number}}
    slurm["CPUS_PER_TASK"] = given.get("cpus-per-task", 1)
    environment = os.environ | {{f"SLURM_{{name}}": str(value) for name, value in slurm.items()}}
    with open(home / f"{{number}}-{{task}}.log", "w") as log:
        streams = {{"stdout": log, "stderr": log, "start_new_session": True}}
        ended.append(start(["bash", str(script), *words], env=environment, **streams))
if start is subprocess.Popen:
    (home / f"{{number}}.pid").write_text(str(ended[0].pid))
elif not any(ended):
    (home / f"{{number}}.ok").touch()
print(number if "parsable" in options else f"Submitted batch job {{number}}")
"""
SCANCEL = """#!{python}
import os, pathlib, signal, sys
for number in sys.argv[1:]:
    os.killpg(int((pathlib.Path({home!r}) / f"{{number}}.pid").read_text()), signal.SIGKILL)
"""


@pytest.fixture
def slurm(tmp_path, monkeypatch):
    """Put the stand-in, and this Python's roughline, first on the path; return its logs' folder."""
    home = tmp_path / "slurm"
    home.mkdir()
    for name, text in (("sbatch", SBATCH), ("scancel", SCANCEL)):
        (home / name).write_text(text.format(python=sys.executable, home=str(home)))
    (home / "roughline").write_text(f'#!/bin/bash\nexec {sys.executable} -m roughline "$@"\n')
    for name in ("sbatch", "scancel", "roughline"):
        (home / name).chmod(0o755)
    monkeypatch.setenv("PATH", f"{home}:{Path(sys.executable).parent}:{os.environ['PATH']}")
    monkeypatch.setenv("PYTHONPATH", str(DOCS.parent))
    return home


@pytest.fixture
def scene_file(rough, tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(rough(realisations=60, compare={"methods": ["bem_fft"]}).text)
    return path


def shell(command):
    return subprocess.run(
        ["bash", "-c", command], check=True, capture_output=True, text=True
    ).stdout.strip()


def test_the_array_of_docs_gives_the_ensemble_of_one_machine(slurm, scene_file, tmp_path):
    """Submitted by the commands in the script's own head, three parts on one process each."""
    script = DOCS / "examples" / "ensemble.sbatch"
    submit, merge = re.findall(r"^#   (.*)$", script.read_text(), re.MULTILINE)
    parts = tmp_path / "parts"
    submit = submit.replace("ensemble.sbatch", f"--array=1-3 --cpus-per-task=1 {script}")
    submit = submit.replace("scene.toml 1000000 parts", f"{scene_file} 60 {parts}")
    merge = merge.replace("parts/*", f"{parts}/*").replace("whole", str(tmp_path / "whole"))
    shell(f"{submit}\n{merge}")
    assert sorted(path.name for path in parts.iterdir()) == ["1", "2", "3"]
    merged = load_ensemble(tmp_path / "whole")
    alone = Ensemble(load_scene(scene_file), tmp_path / "alone").run().record
    assert merged.missing == []
    assert [s.digest for s in merged.settings] == [s.digest for s in alone.settings]


def test_the_dask_cluster_of_docs_solves_an_ensemble(slurm, scene_file, tmp_path):
    """The page's own program, with two processes a job in place of 32."""
    pytest.importorskip("dask_jobqueue")
    (program,) = re.findall(
        r"```python\n(# cluster\.py.*?)```", (DOCS / "cluster.md").read_text(), re.DOTALL
    )
    small = {"32": "2", "120GB": "6GB", "source ~/venv/bin/activate": ":"}
    for theirs, ours in (small | {"maximum_jobs=2": "maximum_jobs=1"}).items():
        program = program.replace(theirs, ours)
    assert "processes=2" in program
    (tmp_path / "cluster.py").write_text(program)
    cluster = subprocess.Popen([sys.executable, "cluster.py"], cwd=tmp_path, start_new_session=True)
    try:
        address = tmp_path / "scheduler.txt"
        while not address.exists():
            assert cluster.poll() is None
            time.sleep(0.5)
        out = tmp_path / "out"
        words = f"roughline ensemble {scene_file} --scheduler $(cat {address}) --out {out}"
        for _ in range(60):  # the first worker takes a while to come
            ended = subprocess.run(["bash", "-c", words], check=False, capture_output=True)
            if ended.returncode == 0:
                break
            time.sleep(2.0)
        assert ended.returncode == 0, ended.stderr
    finally:
        os.killpg(cluster.pid, signal.SIGKILL)
        for job in slurm.glob("*.pid"):
            shell(f"scancel {shlex.quote(job.stem)} || true")
    alone = Ensemble(load_scene(scene_file), tmp_path / "alone").run().record
    assert [s.digest for s in load_ensemble(out).settings] == [s.digest for s in alone.settings]
