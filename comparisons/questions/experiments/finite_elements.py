"""Section 19.1.2: time and memory of finite elements for rough surfaces, and the waves they know.

All solvers are timed as in a study (`comparisons.solving.execution`), on one thread, with the same
surfaces and loads, on grids of N x N points with decreasing spacing.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from comparisons.facts.methods import GRID, MODEL
from comparisons.questions.experiments.experiment import (
    Finding,
    Fraction,
    Share,
    experiment,
    one_of,
    worst,
)
from comparisons.scene.scene import load_scene
from comparisons.solving.execution import execute
from comparisons.solving.plan import task_of
from comparisons.solving.planning import plan_scene
from reference.fem import Material
from reference.fem.columns import compliance
from reference.layered import Stack

# A patch whose shortest wave has four points on the coarsest of these grids (eight per side).
_RECIPE = {
    "surface.points": 8,
    "surface.short_cutoff": "0.25 um",
    "surface.realisations": 3,
    "loading.force": {
        "from": 0.02, "to": 0.1, "steps": 3, "spacing": "log", "relative_to": "E* A0 h'"
    },
    "compare.quantities": ["penetration", "contact_area"],
}  # fmt: skip
# The shortest wave has four points on 16; on coarser grids the error is not a power law. There
# are four, as one alone may meet the highest peak by chance.
_DOUBLED = (16, 32, 64, 128)
# Of meshes that repeat from cell to cell, too, and finer: they cost as little as boundary elements.
_REPEATING = (32, 64, 96, 128)
_GRIDS: dict[str, dict[str, tuple[int, ...]]] = {
    "quick": {"fem": (8, 16, 24), GRID: _DOUBLED, MODEL: _DOUBLED},
    "full": {"fem": (8, 16, 24, 32, 48), GRID: _DOUBLED, MODEL: _DOUBLED},
}
_TRUTH = 512
# Increases of the resident memory below a megabyte are not resolved and count as one.
LEAST_MEMORY = 1e6


@dataclass(frozen=True)
class Series:
    """A method on refined grids: points per side, seconds and bytes per surface, rms error."""

    points: np.ndarray
    seconds: np.ndarray
    memory: np.ndarray
    errors: np.ndarray


@dataclass(frozen=True)
class Law:
    """Least-squares fit of y = c N^p in logarithms, with the standard error of a prediction."""

    constant: float
    exponent: float
    scatter: float

    def at(self, points: float) -> float:
        """Return the value at N points per side."""
        return float(np.exp(self.constant + self.exponent * np.log(points)))

    def reaches(self, value: float) -> float:
        """Return the N at which the law has a given value."""
        return float(np.exp((np.log(value) - self.constant) / self.exponent))


def power_law(points: np.ndarray, values: np.ndarray) -> Law:
    """Return the fit of y = c N^p.

    >>> law = power_law(np.array([1.0, 2.0, 4.0]), np.array([3.0, 12.0, 48.0]))
    >>> round(law.exponent, 12), round(law.at(8), 9)
    (2.0, 192.0)
    """
    x, y = np.log(points), np.log(values)
    exponent, constant = np.polyfit(x, y, 1)
    residual = y - constant - exponent * x
    freedom = max(len(x) - 2, 1)
    return Law(float(constant), float(exponent), float(np.sqrt((residual**2).sum() / freedom)))


@lru_cache(maxsize=8)
def measure_series(method: str, effort: str, mesh: str) -> Series:
    """Measure a method, with rms errors over surfaces and loads relative to the finest grid."""
    (plan, *_) = plan_scene(load_scene("rough-patch", _RECIPE | {"methods.fem.mesh": mesh}))
    realisations = tuple(range(3))

    def solve(name: str, points: int) -> tuple[np.ndarray, float, float]:
        seconds: list[float] = []
        while len(seconds) < 3 or sum(seconds) < 1:
            solution = execute(task_of(plan, name, points, realisations))
            if not solution.converged.all():
                raise ArithmeticError(f"{name} at {points} points: {solution.reasons}")
            seconds.append(solution.seconds)
        least = min(seconds)  # other work on the machine only adds
        return solution.quantities["penetration"], least / len(realisations), solution.memory

    true = solve(GRID, _TRUTH)[0]
    points = _REPEATING if mesh == "repeating" else _GRIDS[effort][method]
    rows = [solve(method, n) for n in points]
    errors = [float(np.sqrt(np.mean((row[0] / true - 1) ** 2))) for row in rows]
    return Series(
        np.array(points, dtype=float),
        np.array([row[1] for row in rows]),
        np.array([max(row[2], LEAST_MEMORY) for row in rows]),
        np.array(errors),
    )


@experiment("finite-element-cost", "rms error of the penetration that both reach")
def finite_element_cost(
    effort: str,
    *,
    accuracy: Fraction = 0.02,
    points: Annotated[int, Field(strict=False, ge=0, le=2048)] = 0,
    against: Annotated[str, one_of(GRID, MODEL)] = GRID,
    resource: Literal["time", "memory"] = "time",
    mesh: Literal["block", "repeating"] = "block",
) -> Share:
    """Time or memory of another method over that of finite elements on rough surfaces.

    For one surface and three loads. Compared at the grids on which either method reaches the rms
    `accuracy` of the penetration, from fitted laws c N^p of error and cost, or at `points` per
    side. Where all grids of the other method reach it, its measured cost on the coarsest counts: at
    most too much. The measurable form of the statement is that the cost of the other method is a
    small share; its bar is the scatter of the fits.
    """
    if against == MODEL and not points:
        raise ValueError("a line does not converge to the surface: compare with reduced at points")
    series = {name: measure_series(name, effort, mesh) for name in ("fem", against)}
    laws, grids, costs, scatter = {}, {}, {}, []
    for name, runs in series.items():
        measured = runs.seconds if resource == "time" else runs.memory
        laws[name] = power_law(runs.points, measured)
        if name == against and not points and (runs.errors <= accuracy).all():
            # No grid coarser than the coarsest measured one is considered: its cost is a bound.
            grids[name], costs[name] = float(runs.points[0]), float(measured[0])
            continue
        scatter.append(laws[name].scatter)
        if points:
            grids[name] = float(points)
        else:
            error = power_law(runs.points, runs.errors)
            grids[name] = max(error.reaches(accuracy), float(runs.points[0]))
            scatter.append(laws[name].exponent * error.scatter / abs(error.exponent))
        costs[name] = laws[name].at(grids[name])
    share = costs[against] / costs["fem"]
    spread = float(np.exp(2 * np.hypot.reduce(scatter)))
    details = {
        f"{resource} of finite elements over the other": 1 / share,
        "factor of the bar": spread,
        "points per side, finite elements": grids["fem"],
        f"points per side, {against}": grids[against],
        f"exponent of {resource}, finite elements": laws["fem"].exponent,
        f"exponent of {resource}, {against}": laws[against].exponent,
    }
    unit, scale = ("hours for 450 surfaces", 8) if resource == "time" else ("gigabytes", 1e9)
    for name, law in laws.items():
        details[f"{unit} of 64 x 64, {name}"] = law.at(64) / scale
    return Share(share, share * (spread - 1), details)


# Growth of the elements with depth, whose floor is 1e-7, and depth of the body in waves.
GROWTH, DEPTH, FLOOR, _NU = 1.08, 4.0, 2e-7, 0.3


@experiment("element-waves", "wavelength in elements")
def element_waves(effort: str, *, wavelength: Annotated[float, Field(gt=1.999)] = 8.0) -> Finding:
    """Work of a wave of pressure on a half-space of finite elements, against the exact one.

    Along the elements and across their diagonal; the larger error counts. The bar is the floor
    below all waves, from elements that grow with depth.
    """
    angles = np.array([0.0, np.pi / 4])
    q = 2 * np.pi / wavelength
    body = Stack([DEPTH * wavelength], [Material(1.0, _NU)])
    phases = q * np.cos(angles), q * np.sin(angles)
    work = compliance(phases, (1.0, 1.0), body, element="quadratic", growth=GROWTH, smooth=True)
    stated = work * q / (2 * (1 - _NU**2))
    details = {"along": float(stated[0]) - 1, "diagonal": float(stated[1]) - 1}
    return Finding(*worst(stated, np.ones(2)), FLOOR, details)
