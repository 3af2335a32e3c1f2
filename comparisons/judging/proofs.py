"""Estimated bars held against proved intervals."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from comparisons.facts.quantities import quantity
from comparisons.facts.quantities.proved import ENCLOSED
from comparisons.formatting import relative
from comparisons.judging.truth import Truth


def missed_by(
    value: np.ndarray, bar: np.ndarray, lower: np.ndarray, upper: np.ndarray
) -> np.ndarray:
    """By how much a value with its relative bar lies outside an interval, relative; zero inside.

    >>> import numpy as np
    >>> low, high = np.full(2, 0.98), np.full(2, 0.99)
    >>> missed_by(np.ones(2), np.array([0.02, 0.005]), low, high).round(3)
    array([0.   , 0.005])
    """
    size = np.abs(value)
    beyond = np.maximum(value - bar * size - upper, lower - value - bar * size)
    return np.maximum(beyond, 0.0) / size


def bars_missed(truth: Truth, sides: Mapping[str, np.ndarray]) -> tuple[str, ...]:
    """Return a sentence for each quantity whose bar does not reach the proved interval.

    Such a bar is too narrow by a theorem, not by another estimate. An unknown bar misses nothing.
    """
    sentences = []
    for name in ENCLOSED:
        if name not in truth.curves or f"{name}_lower" not in sides:
            continue
        bar = truth.bar(name, truth.axis)
        beyond = missed_by(truth.curves[name], bar, sides[f"{name}_lower"], sides[f"{name}_upper"])
        if np.nanmax(beyond, initial=0.0) > 0:
            step = int(np.nanargmax(beyond))
            sentences.append(
                f"The bar of {truth.label} in {quantity(name).label} misses the proved interval by "
                f"{relative(beyond[step])} at load step {step + 1}."
            )
    return tuple(sentences)
