"""Ensembles of very many surfaces: what they cost beside the solves.

The figures of docs/cluster.md are made by::

    python docs/examples/ensembles.py --methods reduced --surfaces 10000 100000 1000000
    python docs/examples/ensembles.py --methods bem_fft --surfaces 4000
"""

# %%
import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

from comparisons.results.ensemble_folder import SURFACES, load_ensemble

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
[loading]
force = { from = 1e-3, to = 1e-1, steps = 15, spacing = "log", relative_to = "E* A0 h'" }
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
    scene.write_text(SCENE, encoding="utf-8")
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


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--surfaces", type=int, nargs="+", default=[1000])
    parser.add_argument("--methods", nargs="+", default=["reduced"])
    parser.add_argument("--workers", type=int, default=1)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="ensembles-") as name:
        for method in options.methods:
            for surfaces in options.surfaces:
                print(cost(Path(name), method, surfaces, options.workers), flush=True)


if __name__ == "__main__":
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    main()
