"""Make the tables of docs/reduced-model.md: readings of Fig. 19.8, load curves, costs, constants.

Run from the repository's root (a quarter of an hour on one core). Tables that the page shows are
written into it, others are printed; all of them, or those that are named::

    python docs/examples/experiment_tables.py NAME
"""

# %%
import math
import sys
from pathlib import Path

import numpy as np

from comparisons import formatting as fmt
from comparisons.facts.methods import METHODS
from comparisons.questions.experiments import EXPERIMENTS
from comparisons.questions.experiments.finite_elements import LEAST_MEMORY, measure_series
from comparisons.questions.experiments.punched_section import press_section
from comparisons.questions.experiments.rough_contact import CHOICES
from comparisons.questions.experiments.vibrations import rayleigh_share, wave_impact
from reference.closed_form.rough_theories import line_peaks, surface_peaks
from reports.tables.written import rewrite

PAGE = Path(__file__).resolve().parents[1] / "reduced-model.md"
LOADS = (0.001, 0.003, 0.01, 0.03, 0.1)

# %% [markdown]
# What "the surface's contact area" and "the line" may mean in Fig. 19.8.

COUNTED = {"quantity": "contact_area_raw", "grid": "native"}
READINGS = {
    "counted cells, C1D sampled (as printed)": {**COUNTED, "rule": "printed"},
    "as printed, H = 0.3": {**COUNTED, "rule": "printed", "hurst": 0.3},
    "as printed, springs counted whole": {
        **COUNTED,
        "rule": "printed",
        "edges": "nodal",
        "line_points": 64,
    },
    "area at vanishing spacing, ring sums": {},
    "the same, periodic": {"periodic": True},
    "the same, H = 0.3": {"hurst": 0.3},
    "the same, plateau above L/8": {"roll_off": 8},
    "the same, shortest wave 8 dx": {"shortest": 8},
    "the same, line of L/8": {"line_length": 0.125},
    "counted, H = 0.3, plateau above L/8, line of L/8": {
        **COUNTED,
        "hurst": 0.3,
        "roll_off": 8,
        "line_length": 0.125,
    },
}


def readings(realisations: int = 120, effort: str = "full") -> list[list[str]]:
    """Area of the line over that of the surface, by reading and load, with its bar."""
    measure = EXPERIMENTS["rough-contact"].measure
    rows = [["reading (H = 0.8 unless said)", *(f"F = {load:g}" for load in LOADS)]]
    for name, parameters in READINGS.items():
        errors = [measure(load, effort, realisations=realisations, **parameters) for load in LOADS]
        cells = [f"{1 + error.error:.2f} ± {error.uncertainty:.2f}" for error in errors]
        rows.append([name, *cells])
    return rows


def load_curves(realisations: int = 300, effort: str = "full") -> list[list[str]]:
    """Other quantities of the line over those of the surface, by load."""
    measure = EXPERIMENTS["rough-contact"].measure
    rows = [
        ["quantity (line over surface, H = 0.8, free patch)", *(f"F = {load:g}" for load in LOADS)]
    ]
    for name in ("penetration", "stiffness", "mean_gap", "contact_length", "contact_area"):
        errors = [measure(load, effort, realisations=realisations, quantity=name) for load in LOADS]
        cells = [f"{1 + error.error:.2f} ± {error.uncertainty:.2f}" for error in errors]
        rows.append([name.replace("_", " "), *cells])
    return rows


# %%
def constants() -> list[list[str]]:
    """List the numbers of bodies, impacts and peaks that the page speaks of."""
    fixed, free = (press_section(1e4, 0.3, support=s, elements=16) for s in ("fixed", "inertia"))
    near = press_section(100.0, 0.3, elements=16)
    shares = [EXPERIMENTS["energy-share"].measure(k) for k in (1.0, 5.0)]
    plane = EXPERIMENTS["kinetic-energy"].measure(1e-4, frame="held", kind="plane")
    slow, fast = (wave_impact(v, 0.3) for v in (1e-5, 1e-2))
    steel = wave_impact(1e-5, 0.3, elastic_sphere=True)
    line, summits = line_peaks(1.0, 8 / 3), surface_peaks(0.5, 1.0)
    numbers = {
        "k/(2E\\*a) − 1 of the held half-ball, times R/a": 100 * (near.stiffness / 2 - 1),
        "energy farther than D": shares[0].error,
        "energy farther than 5 D, times r/D": 5 * shares[1].error,
        "(19.10) over the energy farther than D": shares[0].details[
            "(19.10) over the energy beyond"
        ],
        "the same, farther than 5 D": shares[1].details["(19.10) over the energy beyond"],
        "coefficient of D/R in (19.12), half-space, ν = 0.3": 5.2 / (2 * np.pi * 0.7),
        "v0 of the round side": fixed.mean_displacement[-1] * fixed.radius,
        "v0 of the centre of mass": abs(round(free.mean_displacement[-1] * free.radius, 9)),
        "and of (D/R)²": free.mean_square_displacement[-1] * (free.radius / 2) ** 2,
        "plane strain, D/R = 1e-4: m v0²/2 over K, less one": plane.error,
        "Rayleigh waves' share of radiated power, ν = 1/4": rayleigh_share(0.25),
        "energy lost over (v/c0)^(3/5), rigid sphere": slow.energy_lost / 1e-5**0.6,
        "sphere and half-space of one material": steel.energy_lost / 1e-5**0.6,
        "energy lost at v/c0 = 0.01, rigid sphere": fast.energy_lost,
        "duration over Hertz's there": fast.duration,
        "largest force over Hertz's there": fast.force,
        "peak radius, line over Gaussian surface": line.mean_radius / summits.mean_radius,
        "peak curvature, line over Gaussian surface": line.mean_curvature / summits.mean_curvature,
    }
    return [["number", "value"], *([name, f"{value:.4g}"] for name, value in numbers.items())]


# %%
def best_readings(effort: str = "full") -> list[list[str]]:
    """Area of the line over that of the surface under the readings that a search chose."""
    measure = EXPERIMENTS["best-reading"].measure
    rows = [["chosen by", "reading (counted cells)", *(f"F = {load:g}" for load in LOADS)]]
    chosen = (("largest", math.inf, "of all"), ("largest", 1.0, "H ≤ 1"), ("median", 1.0, "H ≤ 1"))
    for by, steepest, among in chosen:
        errors = [measure(load, effort, by=by, steepest=steepest) for load in LOADS]
        details = errors[0].details
        description = ", ".join(f"{c.name} {details[c.name]}" for c in CHOICES)
        cells = [f"{1 + error.error:.2f} ± {error.uncertainty:.2f}" for error in errors]
        rows.append([f"{by} error over the loads, {among}", description, *cells])
    return rows


def costs(effort: str = "full") -> list[list[str]]:
    """Time, memory and error against N: a surface and three loads, one thread.

    A line stands for no single surface, so its error at three of them says nothing.
    """
    rows = [["method", "N x N points", "time of a surface", "peak memory", "error, rms"]]
    for name in ("fem", "bem_fft", "reduced"):
        series = measure_series(name, effort)
        for n, seconds, memory, error in zip(
            *(series.points, series.seconds, series.memory, series.errors), strict=True
        ):
            storage = fmt.with_unit(memory, "B") if memory > LEAST_MEMORY else "below 1 MB"
            size = "–" if name == "reduced" else fmt.relative(error)
            cells = (f"{n:.0f}", fmt.duration(seconds), storage, size)
            rows.append([METHODS[name].title, *cells])
    return rows


# %%
TABLES = {
    "constants": constants,
    "readings": readings,
    "load-curves": load_curves,
    "best-readings": best_readings,
    "costs": costs,
}


# %%
if __name__ == "__main__":
    rewrite(PAGE, TABLES, sys.argv[1:])
