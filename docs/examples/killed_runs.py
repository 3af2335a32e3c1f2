"""Kill campaigns at random moments and resume them: nothing is lost, done twice, or different.

Each one is killed with SIGKILL at a moment drawn between its start and its end, then resumed to the
end and compared with an undisturbed one (times and memory apart). Some minutes each::

    python docs/examples/killed_runs.py run --size 100
    python docs/examples/killed_runs.py claims
    python docs/examples/killed_runs.py ensemble --size 40000
    python docs/examples/killed_runs.py run --workers 2     # commands, with their start-up
"""

# %%
import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from comparisons.errors import ResultsError
from comparisons.questions import ensemble
from comparisons.questions.campaign import Campaign
from comparisons.questions.claims.claim import load_claims
from comparisons.questions.claims.runner import MEASUREMENT, ClaimRun
from comparisons.questions.study import Study
from comparisons.results.ensemble_folder import load_ensemble, read_bundle
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
points = {points}
rms_slope = 0.1
realisations = {size}
[loading]
force = {{ from = 1e-3, to = 1e-1, steps = 5, spacing = "log", relative_to = "E* A0 h'" }}
[compare]
tolerance = 0.5 # few surfaces and lines do
methods = ["reduced", "bem_fft"]
resolutions = [{half}, {points}]
"""
# One experiment and scenes, with grids along a parameter, bisections, nuisances and draws.
CLAIMS = ("line-height-printed", "vibration-free", "transform-round-cone", "quasi-static-force")
CLOCK = [
    *("seconds", "setup_seconds", "seconds_all", "setup_seconds_all"),
    *("compile_seconds", "memory"),
]


def tables(out: Path) -> list[str]:
    """Return the tables of a run, every digit."""
    names = ("results.csv", "measures.csv", "curves.csv")
    read = (pd.read_csv(out / name, dtype=str) for name in names)
    return [table.drop(columns=CLOCK, errors="ignore").to_csv() for table in read]


def judged(out: Path) -> Any:
    """Return what claims.json says of the claims."""

    def timeless(table: dict[str, Any]) -> dict[str, Any]:
        return {key: value for key, value in table.items() if key not in CLOCK}

    return json.loads((out / "claims.json").read_text(), object_hook=timeless)["claims"]


def statistics(out: Path) -> tuple[object, ...]:
    """Return the statistics, the digests of all curves, and how many surfaces all files have."""
    record = load_ensemble(out)
    solved = sum(read_bundle(path).count for path in (out / "surfaces").glob("[!.]*"))
    digests = [setting.digest for setting in record.settings]
    return (out / "statistics.csv").read_text(), digests, solved, record.missing


@dataclass(frozen=True)
class Kind:
    """How a kind of campaign is begun, by itself and as a command, and what it leaves."""

    begin: Callable[..., Campaign[Any, Any]]  # of a scene file, a folder and options
    words: Callable[[str], tuple[str, ...]]
    answers: str  # the folder of its answers
    load: Callable[[Path], Any]  # reads one; ResultsError if it is torn
    numbers: Callable[[Path], object]
    points: int = 64  # a side of its surfaces


KINDS = {
    "run": Kind(
        lambda scene, out, **options: Study(
            plan_scene(load_scene(scene), "full"), out, effort="full", **options
        ),
        lambda scene: ("run", scene, "--full", "--no-pictures"),
        "fields",
        # Whole runs write them once more, without what no page shows: no two solves take the same.
        lambda path: load_solution(path).seconds,
        tables,
    ),
    "claims": Kind(
        lambda _, out, **options: ClaimRun(load_claims(CLAIMS), out, **options),
        lambda _: ("claims", *CLAIMS),
        "measurements",
        lambda path: (
            load_solution(path) if path.suffix == ".npz" else MEASUREMENT.load(path),
            path.stat().st_mtime_ns,
        )[1],
        judged,
    ),
    "ensemble": Kind(
        lambda scene, out, **options: ensemble.Ensemble(
            load_scene(scene, {"compare.methods": ["reduced"]}), out, **options
        ),
        lambda scene: ("ensemble", scene, "--methods", "reduced"),
        "surfaces",
        lambda path: (read_bundle(path), path.stat().st_mtime_ns)[1],
        statistics,
        points=16,
    ),
}


@dataclass(frozen=True)
class Killed:
    """What was seen of one run: the moment as a share of the whole, files and answers."""

    moment: float
    kept: int
    leftovers: int
    redone: int
    left: int
    identical: bool


def whole(kind: Kind, out: Path) -> dict[str, Any]:
    """Return what tells the complete answers in a folder from others of the same name."""
    found = {}
    for path in (out / kind.answers).glob("[!.]*"):
        with suppress(ResultsError):
            found[path.name] = kind.load(path)
    return found


def leftovers(out: Path) -> int:
    """Return the number of temporary files in a folder."""
    return sum(path.name.startswith(".") for path in out.rglob("*")) if out.exists() else 0


def start(kind: Kind, scene: Path, out: Path, workers: int, *, resume: bool = False) -> int:
    """Start a command; with no workers the bare campaign, in a copy of this process."""
    if workers:
        words = [*kind.words(str(scene)), "--out", str(out), "--workers", str(workers)]
        words += ["--resume"] * resume
        devnull = subprocess.DEVNULL
        command = [sys.executable, "-m", "roughline", *words]
        return subprocess.Popen(command, stdout=devnull, stderr=devnull).pid  # noqa: S603
    process = os.fork()
    if not process:
        kind.begin(scene, out, resume=resume).run()
        os._exit(0)
    return process


def finish(process: int) -> None:
    """Wait for the end of a run, which must be a good one."""
    if os.waitpid(process, 0)[1] != 0:
        raise RuntimeError("a run failed")


# %% [markdown]
# One run: killed, looked at, resumed, compared.


# %%
def killed(
    kind: Kind,
    scene: Path,
    out: Path,
    complete: object,
    moment: float,
    seconds: float,
    workers: int,
) -> Killed:
    """Kill a run after a share `moment` of the `seconds` that it takes, and resume it."""
    process = start(kind, scene, out, workers)
    time.sleep(moment * seconds)
    os.kill(process, signal.SIGKILL)  # a process that has ended waits for us, and takes no harm
    os.waitpid(process, 0)
    time.sleep(1.5 if workers else 0.0)  # processes that it had started see that it is gone
    before, torn = whole(kind, out), leftovers(out)
    finish(start(kind, scene, out, workers, resume=True))
    after = whole(kind, out)
    return Killed(
        moment=moment,
        kept=len(before),
        leftovers=torn,
        # Whole studies drop what is soon solved again.
        redone=sum(after.get(name, first) != first for name, first in before.items()),
        left=leftovers(out),
        identical=kind.numbers(out) == complete,
    )


def experiment(
    kind: Kind, runs: int, workers: int, size: int, seed: int
) -> tuple[list[Killed], int]:
    """Return what became of all runs, and how many answers the whole campaign has."""
    moments = np.random.default_rng(seed).uniform(0.0, 1.0, runs)
    ensemble.TASK_SECONDS = 0.05  # many bundles
    with tempfile.TemporaryDirectory(prefix="killed-") as name:
        folder = Path(name)
        scene = folder / "killed.toml"
        text = SCENE.format(size=size, points=kind.points, half=kind.points // 2)
        scene.write_text(text, encoding="utf-8")
        # The others find everything compiled, and copies of this process loaded.
        warm = kind.begin(scene, folder / "warm")
        warm.run()
        begun = time.perf_counter()
        finish(start(kind, scene, folder / "whole", workers))
        seconds = time.perf_counter() - begun
        complete = kind.numbers(folder / "whole")
        outcomes = []
        for k, moment in enumerate(sorted(moments)):
            outcomes.append(
                killed(kind, scene, folder / str(k), complete, moment, seconds, workers)
            )
            print(outcomes[-1], file=sys.stderr, flush=True)
        return outcomes, warm.under_way.counts[1]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description="--workers 0: no commands, without their start-up")
    parser.add_argument("kind", choices=KINDS)
    for option, default in (("runs", 20), ("workers", 0), ("size", 200), ("seed", 1)):
        parser.add_argument(f"--{option}", type=int, default=default)
    options = vars(parser.parse_args())
    runs, total = experiment(KINDS[options.pop("kind")], **options)
    print(
        "| killed at | answers kept | temporary files left | kept ones solved again | "
        "temporary files after resume | identical |"
    )
    print("|---|---|---|---|---|---|")
    for run in runs:
        cells = (f"{run.moment:.0%}", f"{run.kept} of {total}", run.leftovers, run.redone)
        row = (*cells, run.left, "yes" if run.identical else "NO")
        print("| " + " | ".join(map(str, row)) + " |")


if __name__ == "__main__":
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    main()
