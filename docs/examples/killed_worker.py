"""A study on three workers of a local cluster, one of them killed: the results of a serial run.

The figures of docs/cluster.md are printed by (some minutes on two cores; needs the extra
``cluster``)::

    python docs/examples/killed_worker.py --realisations 450
"""

# %%
import argparse
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import numpy as np
import pandas as pd

SCENE = """
name = "ensemble"
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
force = {{ from = 1e-3, to = 1e-1, steps = 15, spacing = "log", relative_to = "E* A0 h'" }}
[compare]
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


def run(scene: Path, out: Path, *more: str) -> float:
    """Run the study and return its wall time."""
    arguments = ["run", str(scene), "--full", "--no-pictures", "--out", str(out), *more]
    start = time.perf_counter()
    program = [sys.executable, "-m", "roughline", *arguments]
    subprocess.run(program, check=True, stdout=subprocess.DEVNULL)  # noqa: S603
    return time.perf_counter() - start


def same(first: Path, second: Path) -> bool:
    """Tell whether two runs are the same in every digit, times and memory apart."""
    pairs = []
    for name in ("results.csv", "measures.csv"):
        tables = (pd.read_csv(folder / name, dtype=str) for folder in (first, second))
        pairs.append([table.drop(columns=CLOCK, errors="ignore") for table in tables])
    return all(a.equals(b) for a, b in pairs)


def kill_one(pids: list[int], out: Path, generator: np.random.Generator, log: list[str]) -> None:
    """Kill a random worker when a random number of solves is done."""
    tasks = int(generator.integers(2, 20))
    while len(list((out / "fields").glob("[!.]*.npz"))) < tasks:
        time.sleep(0.05)
    victim = int(generator.choice(pids))
    os.kill(victim, signal.SIGKILL)
    log.append(f"worker {pids.index(victim) + 1} of {len(pids)} killed after {tasks} tasks")


def main() -> None:
    """Run the study on this process alone and on a cluster whose worker dies, and compare."""
    from distributed import LocalCluster

    parser = argparse.ArgumentParser()
    for option, default in (("realisations", 450), ("workers", 3), ("seed", 1)):
        parser.add_argument(f"--{option}", type=int, default=default)
    options = parser.parse_args()
    generator, log = np.random.default_rng(options.seed), []
    settings = {"n_workers": options.workers, "threads_per_worker": 1, "dashboard_address": ":0"}
    with (
        tempfile.TemporaryDirectory(prefix="cluster-") as name,
        LocalCluster(**settings) as cluster,
    ):
        folder = Path(name)
        scene = folder / "ensemble.toml"
        scene.write_text(SCENE.format(realisations=options.realisations), encoding="utf-8")
        with cluster.get_client() as client:
            pids = list(client.run(os.getpid).values())
        out = folder / "cluster"
        arguments = (pids, out, generator, log)
        threading.Thread(target=kill_one, args=arguments, daemon=True).start()
        together = run(scene, out, "--scheduler", cluster.scheduler_address)
        alone = run(scene, folder / "serial")
        tasks = len(list((out / "fields").glob("*.npz")))
        print(f"{options.realisations} realisations, {tasks} tasks; {'; '.join(log)}")
        answer = same(folder / "serial", out)
        print(f"cluster {together:.0f} s, serial {alone:.0f} s, identical: {answer}")


if __name__ == "__main__":
    main()
