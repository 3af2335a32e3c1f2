"""Kill runs at random moments and resume them: nothing is done twice, nothing differs.

Each run is killed with SIGKILL at a moment drawn between its start and its end, then resumed to
the end and compared with an undisturbed run (columns of time and memory apart). The table of
docs/cluster.md is made by (some minutes)::

    python docs/examples/killed_runs.py --runs 20 --workers 0 --realisations 100
"""

# %%
import argparse
import os
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from comparisons.errors import ResultsError
from comparisons.questions.study import Study
from comparisons.scene.scene import load_scene
from comparisons.solving.planning import plan_scene
from comparisons.tasks.solution import load_solution

SCENE = """
name = "killed"
[half_space]
effective_modulus = "1 GPa"
[surface]
kind = "self_affine"
hurst = 0.8
size = "1 um"
points = 64
rms_slope = 0.1
realisations = {realisations}
[loading]
force = {{ from = 1e-3, to = 1e-1, steps = 5, spacing = "log", relative_to = "E* A0 h'" }}
[compare]
tolerance = 0.5 # few surfaces and lines do
methods = ["reduced", "bem_fft"]
resolutions = [32, 64]
"""
CLOCK = [
    "seconds",
    "setup_seconds",
    "seconds_all",
    "setup_seconds_all",
    "compile_seconds",
    "memory",
]


@dataclass(frozen=True)
class Killed:
    """What was seen of one run: the moment as a share of the whole, files and solves."""

    moment: float
    solves: int
    leftovers: int
    redone: int
    left: int
    identical: bool


def command(scene: Path, out: Path, workers: int, *more: str) -> list[str]:
    """Return the command line of a run."""
    arguments = ["run", str(scene), "--full", "--no-pictures", "--out", str(out)]
    return [sys.executable, "-m", "roughline", *arguments, "--workers", str(workers), *more]


def solved(out: Path) -> dict[str, float]:
    """Return the measured seconds of the solutions in a folder: no two solves take the same.

    Whole runs write them once more, without what no page shows; what is soon solved is then none.
    """
    taken = {}
    for path in (out / "fields").glob("[!.]*.npz"):
        with suppress(ResultsError):
            taken[path.name] = load_solution(path).seconds
    return taken


def leftovers(out: Path) -> int:
    """Return the number of temporary files in a folder."""
    return sum(path.name.startswith(".") for path in out.rglob("*")) if out.exists() else 0


def numbers(out: Path) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return the tables of a run as they are written, without times and memory."""
    tables = (pd.read_csv(out / name, dtype=str) for name in ("results.csv", "measures.csv"))
    rows, measures = (table.drop(columns=CLOCK, errors="ignore") for table in tables)
    return rows, measures


def forked(scene: Path, out: Path, *more: str) -> int:
    """Start the study in a copy of this process, which has all packages; return its number."""
    process = os.fork()
    if process:
        return process
    flags = {word.removeprefix("--"): True for word in more}
    plans = plan_scene(load_scene(scene), "full")
    Study(plans, out, effort="full", **flags).run()
    os._exit(0)


def start(scene: Path, out: Path, workers: int, *more: str) -> int:
    """Start a run as a command; with no workers, the bare study without its start-up."""
    if not workers:
        return forked(scene, out, *more)
    devnull = subprocess.DEVNULL
    arguments = command(scene, out, workers, *more)
    return subprocess.Popen(arguments, stdout=devnull, stderr=devnull).pid  # noqa: S603


def finish(process: int) -> None:
    """Wait for the end of a run, which must be a good one."""
    if os.waitpid(process, 0)[1] != 0:
        raise RuntimeError("a run failed")


# %% [markdown]
# One run: killed, looked at, resumed, compared.


# %%
def killed(scene: Path, out: Path, complete: Path, moment: float, seconds: float, workers: int):
    """Kill a run after a share `moment` of the `seconds` that it takes, and resume it."""
    process = start(scene, out, workers)
    time.sleep(moment * seconds)
    os.kill(process, signal.SIGKILL)  # a process that has ended waits for us, and takes no harm
    os.waitpid(process, 0)
    time.sleep(1.5)  # processes that it had started see that it is gone
    before, torn = solved(out), leftovers(out)
    finish(start(scene, out, workers, "--resume"))
    after = solved(out)
    return Killed(
        moment=moment,
        solves=len(before),
        leftovers=torn,
        # Whole runs drop what is soon solved again.
        redone=sum(after.get(name, taken) != taken for name, taken in before.items()),
        left=leftovers(out),
        identical=all(a.equals(b) for a, b in zip(numbers(out), numbers(complete), strict=True)),
    )


def experiment(runs: int, workers: int, realisations: int, seed: int) -> tuple[list[Killed], int]:
    """Return what became of all runs, and how many solves the whole study has."""
    moments = np.random.default_rng(seed).uniform(0.0, 1.0, runs)
    with tempfile.TemporaryDirectory(prefix="killed-") as name:
        folder = Path(name)
        scene = folder / "killed.toml"
        scene.write_text(SCENE.format(realisations=realisations), encoding="utf-8")
        # The others find everything compiled, and copies of this process loaded.
        warm = Study(plan_scene(load_scene(scene), "full"), folder / "warm", effort="full")
        warm.run()
        begun = time.perf_counter()
        finish(start(scene, folder / "whole", workers))
        seconds = time.perf_counter() - begun
        outcomes = []
        for k, moment in enumerate(sorted(moments)):
            outcomes.append(
                killed(scene, folder / str(k), folder / "whole", moment, seconds, workers)
            )
            print(outcomes[-1], file=sys.stderr, flush=True)
        return outcomes, warm.counts[1]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description="--workers 0: the study without its start-up")
    for option, default in (("runs", 20), ("workers", 2), ("realisations", 200), ("seed", 1)):
        parser.add_argument(f"--{option}", type=int, default=default)
    runs, total = experiment(**vars(parser.parse_args()))
    print(
        "| killed at | solves kept | temporary files left | kept ones solved again | "
        "temporary files after resume | identical |"
    )
    print("|---|---|---|---|---|---|")
    for run in runs:
        cells = (f"{run.moment:.0%}", f"{run.solves} of {total}", run.leftovers, run.redone)
        row = (*cells, run.left, "yes" if run.identical else "NO")
        print("| " + " | ".join(map(str, row)) + " |")


if __name__ == "__main__":
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    main()
