"""The Slurm scripts of docs/cluster.md, with a stand-in for `sbatch` and `scancel`."""

import os
import re
import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from comparisons.questions.ensemble import Ensemble
from comparisons.results.ensemble_folder import load_ensemble
from comparisons.scene.scene import load_scene

pytest.importorskip("pyarrow")
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


@pytest.mark.slow
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


@pytest.mark.slow
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
