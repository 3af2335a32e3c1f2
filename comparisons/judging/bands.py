"""Single lines and surfaces beside their mean: the band that 90 % of them lie in.

A time of one line belongs to the errors of single lines, which scatter. And the one surface of a
measured map is a sample like the lines with its spectrum: where its value lies among theirs, the
error of their mean may be no more than scatter.
"""

from __future__ import annotations

import numpy as np

from comparisons.facts.methods import METHODS
from comparisons.judging.levels import Levels
from comparisons.judging.truth import Truth

# The band that figures draw: 90 % of the lines lie in it.
BAND = (0.05, 0.95)
# Fewer lines have no such quantiles.
FEWEST = 20


def single_errors(errors: np.ndarray) -> dict[str, float]:
    """Return the band of single realisations' errors (m, k), at the step where it reaches furthest.

    Steps count from 0. Empty where too few realisations have an error.
    """
    known = np.isfinite(errors).sum(axis=0) >= FEWEST
    if not known.any():
        return {}
    low, high = np.full((2, errors.shape[1]), np.nan)
    low[known], high[known] = np.nanquantile(errors[:, known], BAND, axis=0)
    step = int(np.nanargmax(np.fmax(np.abs(low), np.abs(high))))
    ends = float(low[step]), float(high[step])
    return {"single_low": ends[0], "single_high": ends[1], "single_step": step}


def steps_outside(judged: Levels, resolution: int, truth: Truth, name: str) -> list[int] | None:
    """Return the load steps, from 0, at which the surface is outside the band of the lines.

    Outside by more than the bar of its value. None where there is no such band: of methods that
    solve the surface itself, of truths that are means over many surfaces, of few lines.
    """
    solution = judged.solutions[resolution]
    values = solution.quantities.get(name)
    one_surface = truth.levels.rough and len(truth.solution.converged) == 1
    if METHODS[judged.method].dimension != 1 or not one_surface or values is None:
        return None
    if len(values) < FEWEST or name not in truth.curves or not np.isfinite(values).all():
        return None
    low, high = np.quantile(values, BAND, axis=0)
    value = truth.curves[name]
    bar = np.abs(value) * np.nan_to_num(truth.bar(name), nan=np.inf)
    beyond = (value - bar > high) | (value + bar < low)
    return [int(step) for step in np.flatnonzero(beyond)]
