"""Distributions over a rough contact: histograms in bins that all methods on a scene share.

A pressure or a gap counts with the share of the nominal area that has it, a contact as one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from comparisons.facts.quantities import DISTRIBUTIONS, QUANTITIES
from comparisons.geometry.prepare import RoughGeometry
from comparisons.scene.scene import Scene
from comparisons.tasks.task import Task


def edges(name: str, scene: Scene, geometry: RoughGeometry) -> np.ndarray:
    """Return the edges of the bins of a distribution, in SI units."""
    bins = QUANTITIES[name].bins
    assert bins is not None
    scale = {
        "pressure": scene.effective_modulus * geometry.rms_slope,
        "height": geometry.rms_height,
        "area": geometry.area,
    }[bins.scale]
    return scale * bins.edges


def wanted(task: Task) -> tuple[str, ...]:
    """Return the distributions that a task asks for."""
    return tuple(name for name in DISTRIBUTIONS if name in task.quantities)


@dataclass(frozen=True)
class Stretches:
    """Values that are spread evenly between two ends, each with its weight; ends may be equal."""

    first: np.ndarray
    last: np.ndarray
    weight: np.ndarray

    @classmethod
    def points(cls, values: np.ndarray, weight: float | np.ndarray = 1.0) -> Stretches:
        """Return single values."""
        values = np.ravel(values)
        return cls(values, values, np.broadcast_to(weight, values.shape))


def histogram(bins: np.ndarray, values: Stretches) -> np.ndarray:
    """Return the weight of the positive values in each bin; the outer bins take what is beyond."""
    low, high = (side(values.first, values.last) for side in (np.minimum, np.maximum))
    level = low == high
    single = level & (low > 0)
    place = np.clip(np.searchsorted(bins, low[single], side="right") - 1, 0, len(bins) - 2)
    counts = np.bincount(place, weights=values.weight[single], minlength=len(bins) - 1)
    spread = ~level & (high > 0)
    low, high, weight = low[spread], high[spread], values.weight[spread]
    if not len(low):
        return counts
    below = np.concatenate([[0.0], bins[1:-1]])  # what is not positive is in no bin
    share = np.clip((below[:, None] - low) / (high - low), 0.0, 1.0)
    inner = np.concatenate([share, np.ones((1, len(low)))])
    return np.asarray(counts + np.diff(inner, axis=0) @ weight)


def of_values(task: Task, values: Mapping[str, Stretches]) -> dict[str, np.ndarray]:
    """Return the histograms of named values of a contact."""
    assert isinstance(task.geometry, RoughGeometry)
    return {
        name: histogram(edges(name, task.scene, task.geometry), stretches)
        for name, stretches in values.items()
    }
