"""Pressures to start from: full contact, the contact on a coarser grid, or the overlap."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from reference.contact.body import LARGEST_KEPT, Convolution, ElasticBody
from reference.contact.descent import descend
from reference.errors import ConvergenceError

Field = NDArray[np.float64]

# For grids with a shorter side, a coarser grid saves no time.
_SHORTEST_COARSENED = 128
# Violation of the coarser solution; a smaller one is lost in the interpolation. Measured on rough
# surfaces of 256 to 1024 points a side: it saves a fifth to a third of the iterations on the finest
# grid. Beyond this side it falls with the grid: the shortest waves are an ever smaller part of the
# penetration, and at 1e-2 a coarse grid would pass on what it was given, the errors of all before.
_COARSE_TOLERANCE, _COARSE_SIDE, _COARSE_ITERATIONS = 1e-2, 256, 60
# The overlap for a force is slightly deeper than the contact.
_SHALLOWER = 0.85
# With tension in more cells than this fraction, the linear solution is not a good start.
_NEARLY_FULL = 0.1


def starting_pressure(
    body: ElasticBody, gap: Field, control: str, value: float
) -> tuple[Field, bool]:
    """Return a non-negative pressure near the contact, and whether it is that of full contact.

    ``control`` is a penetration or a force.
    """
    # every second point has fewer waves, and less tension: where full contact has too much there,
    # so it has on all points
    points, full = np.ascontiguousarray(gap[::2, ::2]), True
    helps = min(body.shape) >= _SHORTEST_COARSENED and np.isfinite(points).any()
    if helps and control == "penetration":
        closed = body.periodic and value >= points.mean()
        helps = not closed and points.min() < value
    coarse = body.coarser() if helps else None
    if coarse is not None:
        below, full = starting_pressure(coarse, points, control, value)

    # full contact, K p = <g> - g, if nearly without tension
    if full and control == "force" and body.periodic and np.isfinite(gap).all():
        with np.errstate(divide="ignore"):
            inverse = 1 / body.convolution(np.float64).transfer
        inverse[0, 0] = 0.0  # kernels have no zeros other than the mean
        pressure = Convolution(body.shape, body.shape, inverse, np.float64)(gap)
        pressure *= -1 / body.unit
        pressure += value / (gap.size * body.cell_area) - pressure.mean()
        if np.count_nonzero(pressure < 0) <= _NEARLY_FULL * pressure.size:
            return np.maximum(pressure, 0.0, out=pressure), True
        del inverse, pressure

    # the coarser grid, solved to its tolerance or as near as it gets, interpolated linearly:
    # repeated values cost more iterations than it saves
    if coarse is not None:
        tolerance = _COARSE_TOLERANCE * min(1.0, _COARSE_SIDE / max(points.shape))
        effort = {"tolerance": tolerance, "max_iterations": _COARSE_ITERATIONS}
        try:
            descend(coarse, points, below, control, value, **effort, partial=True)
            finer = np.empty(body.shape)
            _interpolate(below, finer, body.periodic)
            return finer, False
        except ConvergenceError:
            pass
        finally:
            if points.size > LARGEST_KEPT:
                coarse.forget()
    depth = value
    if control == "force":
        least = float(gap.min())
        depth = least + _SHALLOWER * (overlap_depth(body, gap, value) - least)
    return overlap_pressure(body, gap, depth), False


def overlap_depth(body: ElasticBody, gap: Field, force: float) -> float:
    """Return the depth at which the overlap (d - g) has E* V/sqrt(A) = F, 6 % low for Hertz."""
    gaps = np.sort(gap[np.isfinite(gap)])
    count = np.arange(1, gaps.size + 1)
    volume = count * gaps - np.cumsum(gaps)
    forces = body.effective_modulus * np.sqrt(body.cell_area / count) * volume
    if force >= forces[-1]:
        slope = body.effective_modulus * np.sqrt(body.cell_area * count[-1])
        return float(gaps[-1] + (force - forces[-1]) / slope)
    above = int(np.searchsorted(np.maximum.accumulate(forces), force, side="right"))
    share = (force - forces[above - 1]) / (forces[above] - forces[above - 1])
    return float(gaps[above - 1] + share * (gaps[above] - gaps[above - 1]))


def overlap_pressure(body: ElasticBody, gap: Field, depth: float) -> Field:
    """Return a pressure proportional to the overlap, of the right order of magnitude.

    Zero where no cell overlaps, as at a depth that round-off loses:

    >>> from reference.halfspace.operators import FreeOperator
    >>> overlap_pressure(FreeOperator((1, 2), (1.0, 1.0), 1.0), np.ones((1, 2)), 1.0)
    array([[0., 0.]])
    """
    overlap = np.maximum(depth - gap, 0.0)
    area = max(int(np.count_nonzero(overlap)), 1) * body.cell_area
    return overlap * (body.effective_modulus / np.sqrt(area))


@njit(cache=True)
def _interpolate(coarse, fine, periodic):
    """Fill the finer grid linearly from every second point, constant beyond the last one."""
    rows, columns = coarse.shape
    for i in range(fine.shape[0]):
        above, below = i // 2, (i + 1) // 2
        if below == rows:
            below = 0 if periodic else above
        for j in range(fine.shape[1]):
            left, right = j // 2, (j + 1) // 2
            if right == columns:
                right = 0 if periodic else left
            upper, lower = coarse[above, left] + coarse[above, right], coarse[below, left]
            fine[i, j] = (upper + lower + coarse[below, right]) / 4
