"""Greenwood and Williamson's model on the summits of the very surfaces, and the line beside it."""

from __future__ import annotations

from functools import lru_cache
from typing import Annotated, Literal

import numpy as np

from comparisons.questions.experiments.experiment import (
    Above,
    Details,
    Finding,
    OneOf,
    Share,
    experiment,
    number_of,
)
from comparisons.questions.experiments.rough_ensemble import (
    Surface,
    compare,
    line_samples,
    surface_samples,
    truth,
)
from reference.closed_form.rough_theories import GreenwoodWilliamson
from reference.surfaces import summits

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


@experiment(
    "asperities",
    "Asperities of the surfaces themselves beside the surfaces and the line",
    "load",
    "load F/(E* A0 h')",
)
def asperities(
    effort: str,
    *,
    load: Annotated[float, Above(0)] = 0.01,
    quantity: Annotated[str, OneOf(*QUANTITIES)] = "contact_area",
    statement: Literal["model", "line_is_better"] = "model",
    hurst: float = 0.8,
    roll_off: float = 4.0,
    shortest: float = 4.0,
    periodic: bool = False,
    realisations: float = 60,
) -> Finding | Share:
    """Compare the model with the surfaces, or its error with that of the line.

    Statements: ``"model"``, its relative error; ``"line_is_better"``, by how much the magnitude of
    the line's error exceeds the model's, zero where it does not.
    """
    surface = Surface.of(64, hurst, roll_off, shortest, periodic)
    count = number_of(realisations, effort, 20)
    stiffness = quantity == "stiffness"

    def sample(factor: int, number: int) -> np.ndarray:
        return surface_samples(surface, float(load), factor, number, stiffness)[quantity]

    true, grid_bar = truth(sample, "refined", count, effort)
    model = of_surface(surface)
    separation = model.separation(load)  # E* = A0 = h' = 1; without interaction the mean gap
    stated = {
        "contact_area": model.area(separation),
        "mean_gap": separation,
        "stiffness": model.stiffness(separation),
    }[quantity]
    line = line_samples(surface, float(load), max(4 * count, 450))[quantity]
    details: Details = {}
    of_model = compare([stated], true, grid_bar, details)
    of_line = compare(line, true, grid_bar, details)
    details |= {"error of the line": of_line.error, "error of the model": of_model.error}
    if statement == "model":
        return of_model
    excess = abs(of_line.error) - abs(of_model.error)
    doubt = float(np.hypot(of_model.uncertainty, of_line.uncertainty))
    low, high = max(excess - doubt, 0.0), max(excess + doubt, 0.0)
    return Share(0.5 * (low + high), 0.5 * (high - low), details, "excess")
