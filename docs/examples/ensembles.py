"""Ensembles of very many surfaces: what they cost beside the solves, and what kills do to them.

The tables of docs/cluster.md are made by::

    python docs/examples/ensembles.py cost --methods reduced --surfaces 1000 10000 100000 1000000
    python docs/examples/ensembles.py cost --methods bem_fft --surfaces 4000
    python docs/examples/ensembles.py kill --surfaces 300 --kills 12
"""

# %%
import argparse
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np

from comparisons.questions import ensemble
from comparisons.results.ensemble_folder import SURFACES, load_ensemble, survey
from comparisons.scene.scene import Scene, load_scene

SCENE = """
name = "ensemble"
[half_space]
effective_modulus = "1 GPa"
[surface]
kind = "self_affine"
hurst = 0.8
size = "1 um"
points = {points}
rms_slope = 0.1
[loading]
force = {{ from = 1e-3, to = 1e-1, steps = 15, spacing = "log", relative_to = "E* A0 h'" }}
"""


class Used(NamedTuple):
    """What a command took: wall and processor seconds with all its processes, peak in MB."""

    wall: float
    processor: float
    peak: float


def used(*arguments: str) -> Used:
    """Run a command of roughline to its end."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    begun = time.perf_counter()
    command = [sys.executable, "-m", "roughline", *arguments]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)  # noqa: S603
    _, status, own = os.wait4(process.pid, 0)
    if status:
        raise RuntimeError(f"{' '.join(arguments)} failed")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    processor = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return Used(time.perf_counter() - begun, processor, own.ru_maxrss / 1e3)


# %% [markdown]
# Two parts one after the other, then their merge.


# %%
def cost(folder: Path, method: str, surfaces: int, workers: int) -> str:
    """Return a row of the table."""
    scene = folder / "ensemble.toml"
    scene.write_text(SCENE.format(points=64), encoding="utf-8")
    arguments = ("ensemble", str(scene), "--methods", method, "--surfaces", str(surfaces))
    parts = [folder / f"{method}-{surfaces}-{k}" for k in (1, 2)]
    spent = []
    for k, part in enumerate(parts, start=1):
        where = ("--part", f"{k}/2", "--workers", str(workers), "--out", str(part))
        spent.append(used(*arguments, *where))
    out = folder / f"{method}-{surfaces}"
    merged = used("merge", *map(str, parts), "--out", str(out))
    record = load_ensemble(out)
    (setting,) = record.settings
    whole = sum(part.processor for part in spent) + merged.processor
    size = sum(path.stat().st_size for path in (out / SURFACES).iterdir())
    cells = (
        setting.surfaces,
        setting.bundles,
        f"{setting.processor_seconds:.1f} s",
        f"{whole:.1f} s",
        f"{1 - setting.processor_seconds / whole:.1%}",
        f"{max(part.peak for part in spent):.0f} MB",
        f"{merged.peak:.0f} MB",
        f"{merged.wall:.0f} s",
        f"{size / 1e6:.1f} MB",
    )
    return f"| {method} | " + " | ".join(map(str, cells)) + " |"


# %% [markdown]
# A copy of this process, which has all packages, is killed and resumed until it comes to its end.


# %%
class Kill(NamedTuple):
    """What a kill left: whole files, their surfaces, temporary files."""

    seconds: float
    files: int
    surfaces: int
    temporary: int


def begin(scene: Scene, out: Path) -> int:
    """Start or resume an ensemble in a copy of this process; return its number."""
    process = os.fork()
    if process:
        return process
    ensemble.Ensemble(scene, out, resume=True).run()
    os._exit(0)


def killed(scene: Scene, out: Path, kills: int, seconds: float, seed: int) -> list[Kill]:
    """Kill an ensemble at moments drawn from 0 to `seconds` after each start, then let it end."""
    moments = np.random.default_rng(seed).uniform(0.0, seconds, kills)
    left = []
    for moment in moments:
        process = begin(scene, out)
        time.sleep(moment)
        os.kill(process, signal.SIGKILL)
        os.waitpid(process, 0)
        names = list((out / SURFACES).glob("*")) if out.exists() else []
        whole = [b for files in survey(out / SURFACES).values() for b in files.values()]
        torn = sum(path.name.startswith(".") for path in names)
        left.append(Kill(moment, len(whole), sum(bundle.count for bundle in whole), torn))
    if os.waitpid(begin(scene, out), 0)[1]:
        raise RuntimeError("a resumed ensemble failed")
    return left


def kill(
    folder: Path, surfaces: int, kills: int, *, points: int = 64, task: float = 1.0, seed: int = 1
) -> tuple[list[Kill], bool]:
    """Return what the kills left, and whether the end has the digits of an undisturbed run."""
    path = folder / "killed.toml"
    path.write_text(SCENE.format(points=points), encoding="utf-8")
    overrides = {"surface.realisations": surfaces, "compare.methods": ["bem_fft"]}
    scene = load_scene(path, overrides)
    ensemble.TASK_SECONDS = task
    begun = time.perf_counter()
    whole = ensemble.Ensemble(scene, folder / "whole").run()
    seconds = time.perf_counter() - begun
    left = killed(scene, folder / "killed", kills, 2 * seconds / kills, seed)
    record = load_ensemble(folder / "killed")
    digests = [[s.digest for s in r.settings] for r in (whole.record, record)]
    return left, digests[0] == digests[1] and not record.missing


def main() -> None:
    """Print one of the tables."""
    parser = argparse.ArgumentParser()
    parser.add_argument("what", choices=["cost", "kill"])
    parser.add_argument("--surfaces", type=int, nargs="+", default=[1000])
    parser.add_argument("--methods", nargs="+", default=["reduced"])
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--kills", type=int, default=12)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="ensembles-") as name:
        if options.what == "kill":
            left, identical = kill(Path(name), options.surfaces[0], options.kills)
            print("| killed after | whole files | surfaces kept | temporary files |")
            print("|---|---|---|---|")
            for row in left:
                cells = (f"{row.seconds:.1f} s", row.files, row.surfaces, row.temporary)
                print("| " + " | ".join(map(str, cells)) + " |")
            print(f"digits of an undisturbed run: {'yes' if identical else 'NO'}")
            return
        for method in options.methods:
            for surfaces in options.surfaces:
                print(cost(Path(name), method, surfaces, options.workers), flush=True)


if __name__ == "__main__":
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    main()
