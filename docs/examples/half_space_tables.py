"""Make the tables of docs/half-space.md: kernels, stages of the solver, dense against FFT.

Run from the repository's root (a minute on one core). Tables that the page shows are written into
it, others are printed; all of them, or those that are named::

    python docs/examples/half_space_tables.py NAME
"""

# %%
import contextlib
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

from reference.contact import descent
from reference.contact import press as pressing
from reference.contact.press import press
from reference.errors import ConvergenceError
from reference.halfspace import FreeOperator, PeriodicOperator, kernels
from reference.halfspace.areas import located_area
from reference.loads import Load
from reference.surfaces import SelfAffine, self_affine
from reports.tables.written import rewrite

PAGE = Path(__file__).resolve().parents[1] / "half-space.md"
POINTS = 256
SLOPE = 0.1


def gap_of(points: int, cutoff: int, roll_off: float | None = 0.25) -> np.ndarray:
    """Return the initial gap of a self-affine surface of unit side, H = 0.8, cutoff in cells."""
    height = self_affine(
        points,
        1.0,
        SelfAffine(hurst=0.8, rms_slope=SLOPE, long_cutoff=roll_off, short_cutoff=cutoff / points),
        seed=1,
        realisation=0,
    )
    return height.max() - height


def cpu(task: Callable[[], object], repeats: int = 5) -> float:
    """Median processor time on warm code, in milliseconds."""
    task()
    times = []
    for _ in range(repeats):
        start = time.process_time()
        task()
        times.append(time.process_time() - start)
    return 1e3 * float(np.median(times))


# %% [markdown]
# The two periodic kernels by wavelength, and what they and the free surroundings change in a
# contact.


# %%
def transfer_ratio() -> list[list[str]]:
    """Cells over continuum, for waves along an axis."""
    shape, spacing = (POINTS, POINTS), (1.0, 1.0)
    ratio = kernels.periodic(shape, spacing, 1.0, "cells")[1:, 0]
    ratio /= kernels.periodic(shape, spacing, 1.0, "continuum")[1:, 0]
    waves = (64, 16, 8, 4, 2)
    shares = [f"{ratio[POINTS // wave - 1]:.4f}" for wave in waves]
    return [["wavelength in cells", *map(str, waves)], ["cells/continuum", *shares]]


def kernel_choice() -> list[list[str]]:
    """Press one map with one force: area and penetration against those of the continuum kernel."""
    rows = [
        [
            "short cutoff in cells",
            "area, cells",
            "penetration, cells",
            "area, free",
            "penetration, free",
        ]
    ]
    for cutoff in (16, 8, 4, 2):
        gap = gap_of(POINTS, cutoff)
        grid = gap.shape, (1 / POINTS, 1 / POINTS), 1.0
        operators = (
            PeriodicOperator(*grid),
            PeriodicOperator(*grid, kernel="cells"),
            FreeOperator(*grid),
        )
        contacts = [press(operator, gap, Load("force", 0.1 * SLOPE)) for operator in operators]
        base, *finer = [
            (located_area(contact, patch=True), contact.penetration) for contact in contacts
        ]
        cells = [
            f"{100 * (value / reference - 1):+.2f} %"
            for measured in finer
            for value, reference in zip(measured, base, strict=True)
        ]
        rows.append([str(cutoff), *cells])
    return rows


# %% [markdown]
# What each part of the solver is worth: the same contacts with parts switched off.


# %%
def solver_parts() -> list[list[str]]:
    """Count iterations and processor time of solves at 20 % and 4 % contact."""
    full = descent._STAGES
    variants = {
        "all": (full, 128),
        "without coarser grids": (full, 10**9),
        "double precision only": (full[1:], 128),
        "plain (no preconditioner, double)": (full[2:], 10**9),
    }
    cases = [(16, 0.1), (16, 0.02), (4, 0.1), (4, 0.02)]
    rows = [["", *(f"cutoff {cutoff}, F = {share} E\\* A0 h'" for cutoff, share in cases)]]
    for name, (stages, shortest) in variants.items():
        descent._STAGES, pressing.SHORTEST_COARSENED = stages, shortest
        cells = []
        for cutoff, share in cases:
            gap = gap_of(POINTS, cutoff)
            operator = PeriodicOperator(gap.shape, (1 / POINTS, 1 / POINTS), 1.0)
            force = share * SLOPE
            iterations = press(operator, gap, Load("force", force)).iterations
            spent = cpu(partial(press, operator, gap, Load("force", force)))
            cells.append(f"{iterations}, {spent:.0f} ms")
        rows.append([name, *cells])
    descent._STAGES, pressing.SHORTEST_COARSENED = full, 128
    return rows


# %% [markdown]
# The dense oracle against the FFT: Hertz with more and more contact cells.


# %%
def dense_or_fft() -> list[list[str]]:
    """Processor time of one cold solve at given force; rounds and iterations."""
    rows = [["contact cells", "dense", "rounds", "FFT", "iterations", "largest difference in p/p0"]]
    for cells in (10, 30, 100, 300, 1000, 3000):
        radius = np.sqrt(cells / np.pi)
        n = 2 * int(1.45 * radius + 2)
        x = np.arange(n) - n / 2 + 0.3
        operator = FreeOperator((n, n), (1.0, 1.0), 1.0)
        gap, force = (x[:, None] ** 2 + x**2) / 2 / radius**2, 4 / 3 * radius
        exact = press(operator, gap, Load("force", force), by="pivot")
        contact = press(operator, gap, Load("force", force))
        repeats = 3 if cells < 1000 else 1
        spent = [
            cpu(partial(press, operator, gap, Load("force", force), by=by), repeats)
            for by in ("pivot", "descent")
        ]
        difference = np.abs(contact.pressure - exact.pressure).max() / exact.pressure.max()
        counts = [str(exact.iterations), str(contact.iterations)]
        rows.append(
            [
                str(int(exact.mask.sum())),
                f"{spent[0]:.1f} ms",
                counts[0],
                f"{spent[1]:.1f} ms",
                counts[1],
                f"{difference:.0e}",
            ]
        )
    return rows


def hardest() -> list[list[str]]:
    """White noise on cells of 1:50 under a penetration near full contact, twelve surfaces."""
    operator = PeriodicOperator((64, 64), (1.0, 50.0), 1.0)
    rows = [["penetration / mean gap at first touch", "solved", "iterations, median (all)"]]
    for share in (0.5, 0.9, 0.99, 0.9999):
        counts = []
        for seed in range(12):
            height = np.random.default_rng(seed).standard_normal((64, 64))
            gap = height.max() - height
            load = Load("penetration", share * float(gap.mean()))
            with contextlib.suppress(ConvergenceError):
                counts.append(press(operator, gap, load).iterations)
        spread = f"{np.median(counts):.0f} ({min(counts)} to {max(counts)})" if counts else "-"
        rows.append([str(share), f"{len(counts)} of 12", spread])
    return rows


# %%
TABLES = {
    "transfer-ratio": transfer_ratio,
    "kernel-choice": kernel_choice,
    "solver-parts": solver_parts,
    "hardest": hardest,
    "dense-or-fft": dense_or_fft,
}


# %%
if __name__ == "__main__":
    rewrite(PAGE, TABLES, sys.argv[1:])
