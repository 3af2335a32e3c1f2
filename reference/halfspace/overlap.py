"""The geometric overlap of shape and undeformed half-space, as an estimate of the contact."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from reference.halfspace.operators import HalfSpace

Field = NDArray[np.float64]


def overlap_depth(operator: HalfSpace, gap: Field, force: float) -> float:
    """Return the depth at which the overlap (d - g) has E* V/sqrt(A) = F, 6 % low for Hertz."""
    gaps = np.sort(gap[np.isfinite(gap)])
    count = np.arange(1, gaps.size + 1)
    volume = count * gaps - np.cumsum(gaps)
    forces = operator.effective_modulus * np.sqrt(operator.cell_area / count) * volume
    if force >= forces[-1]:
        slope = operator.effective_modulus * np.sqrt(operator.cell_area * count[-1])
        return float(gaps[-1] + (force - forces[-1]) / slope)
    above = int(np.searchsorted(np.maximum.accumulate(forces), force, side="right"))
    share = (force - forces[above - 1]) / (forces[above] - forces[above - 1])
    return float(gaps[above - 1] + share * (gaps[above] - gaps[above - 1]))


def overlap_pressure(operator: HalfSpace, gap: Field, depth: float) -> Field:
    """Return a pressure proportional to the overlap, of the right order of magnitude.

    Zero where no cell overlaps, as at a depth that round-off loses:

    >>> from reference.halfspace.operators import FreeOperator
    >>> overlap_pressure(FreeOperator((1, 2), (1.0, 1.0), 1.0), np.ones((1, 2)), 1.0)
    array([[0., 0.]])
    """
    overlap = np.maximum(depth - gap, 0.0)
    area = max(int(np.count_nonzero(overlap)), 1) * operator.cell_area
    return overlap * (operator.effective_modulus / np.sqrt(area))
