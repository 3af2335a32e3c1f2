"""Greenwood and Williamson's model on the summits of the very surfaces, and the line beside it."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from comparisons.questions.experiments.rough_ensemble import (
    Surface,
    compare,
    line_samples,
    surface_samples,
    truth,
)
from comparisons.questions.experiments.running import Finding, above, experiment, one_of
from reference.closed_form.rough import GreenwoodWilliamson
from reference.summits import summits

QUANTITIES = ("contact_area", "mean_gap", "stiffness")
# Surfaces whose summits are counted, on grids so much finer that their curvatures have converged.
_SURFACES, _FACTOR = 12, 4


@lru_cache(maxsize=64)
def of_surface(surface: Surface) -> GreenwoodWilliamson:
    """Return the model with density, mean radius and heights of the surfaces' own summits."""
    step = 1 / (surface.points * _FACTOR)
    heights, radii, count = [], [], 0
    for k in range(_SURFACES):
        surface_map = surface.heights(k, _FACTOR)
        peaks = summits(surface_map, (step, step))
        heights.append(surface_map[tuple(peaks.places.T)])
        radii.append(1 / np.sqrt(peaks.curvatures.prod(axis=1)))
        count += len(peaks.places)
    pooled = np.concatenate(heights)
    return GreenwoodWilliamson(
        density=count / _SURFACES,
        radius=float(np.concatenate(radii).mean()),
        mean=float(pooled.mean()),
        deviation=float(pooled.std(ddof=1)),
    )


def _asperities(
    effort: str,
    *,
    load: float = 0.01,
    quantity: str = "contact_area",
    statement: str = "model",
    hurst: float = 0.8,
    roll_off: float = 4.0,
    shortest: float = 4.0,
    periodic: bool = False,
    realisations: float = 60,
) -> Finding:
    """Compare the model with the surfaces, or its error with that of the line.

    Statements: ``"model"``, its relative error; ``"line_is_better"``, by how much the magnitude of
    the line's error exceeds the model's, zero where it does not.
    """
    above("load", load, 0)
    one_of("quantity", quantity, *QUANTITIES)
    one_of("statement", statement, "model", "line_is_better")
    surface = Surface.of(64, hurst, roll_off, shortest, periodic)
    count = int(realisations) if effort == "full" else min(int(realisations), 20)
    stiffness = quantity == "stiffness"

    def sample(factor: int, number: int) -> np.ndarray:
        return surface_samples(surface, float(load), factor, number, stiffness)[quantity]

    true, grid_bar = truth(sample, "refined", count, effort)
    model = of_surface(surface)
    separation = model.separation(load)
    stated = {
        "contact_area": model.area(separation),
        "mean_gap": separation,
        "stiffness": model.stiffness(separation),
    }[quantity]
    error, bar = compare([stated], true, grid_bar)
    line = line_samples(surface, float(load), max(4 * count, 450))[quantity]
    of_line, bar_of_line = compare(line, true, grid_bar)
    details: dict[str, float | str] = {
        "model": stated,
        "surfaces": float(true.mean()),
        "error of the line": of_line,
        "error of the model": error,
        "mean radius of summits times density^(1/2)": model.radius * model.density**0.5,
    }
    if statement == "model":
        return Finding(error, bar, details)
    excess, doubt = abs(of_line) - abs(error), float(np.hypot(bar, bar_of_line))
    low, high = max(excess - doubt, 0.0), max(excess + doubt, 0.0)
    return Finding(0.5 * (low + high), 0.5 * (high - low), details)


EXPERIMENTS = (
    experiment(
        "asperities",
        "Greenwood and Williamson's model on the summits of the surfaces themselves",
        "load F/(E* A0 h')",
        "load",
        _asperities,
    ),
)
