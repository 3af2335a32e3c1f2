"""Initial pressures of the contact iteration: full contact, a coarser grid, or the overlap."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from reference.errors import ConvergenceError
from reference.halfspace.conjugate_gradients import Problem, approach
from reference.halfspace.convolution import Convolution
from reference.halfspace.operators import LARGEST_KEPT, HalfSpace
from reference.halfspace.overlap import overlap_depth, overlap_pressure
from reference.halfspace.solution import Effort

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


def starting_pressure(operator: HalfSpace, gap: Field, kind: str, value: float) -> Field:
    """Return a non-negative pressure near the solution under a penetration or a force."""
    return _start(operator, gap, kind, value)[0]


def _start(operator: HalfSpace, gap: Field, kind: str, value: float) -> tuple[Field, bool]:
    """Return a pressure to start from, and whether it is that of full contact.

    Every second point has fewer waves, and less tension: where full contact has too much there, so
    it has on all points.
    """
    coarse, full = _coarser(operator, gap, kind, value), True
    if coarse is not None:
        points = np.ascontiguousarray(gap[::2, ::2])
        below, full = _start(coarse, points, kind, value)
    if kind == "force" and operator.periodic and full:
        pressure = _full_contact(operator, gap, value)
        if pressure is not None:
            return pressure, True
    if coarse is not None:
        pressure = _improved(coarse, points, below, kind, value)
        if pressure is not None:
            return _interpolated(pressure, operator), False
    depth = value
    if kind == "force":
        least = float(gap.min())
        depth = least + _SHALLOWER * (overlap_depth(operator, gap, value) - least)
    return overlap_pressure(operator, gap, depth), False


def _coarser(operator: HalfSpace, gap: Field, kind: str, value: float) -> HalfSpace | None:
    """Return the operator on every second point; None if it cannot help."""
    if min(operator.shape) < _SHORTEST_COARSENED:
        return None
    points = gap[::2, ::2]
    if not np.isfinite(points).any():
        return None
    if kind == "penetration":
        closed = operator.periodic and value >= points.mean()
        if closed or not points.min() < value:
            return None
    return operator.coarser()


def _full_contact(operator: HalfSpace, gap: Field, force: float) -> Field | None:
    """Return the linear solution of full contact, K p = <g> - g, if nearly without tension."""
    if not np.isfinite(gap).all():
        return None
    pressure = _inverse(operator)(gap)
    pressure *= -1 / operator.unit
    pressure += force / (gap.size * operator.cell_area) - pressure.mean()
    if np.count_nonzero(pressure < 0) > _NEARLY_FULL * pressure.size:
        return None
    return np.maximum(pressure, 0.0, out=pressure)


def _inverse(operator: HalfSpace) -> Convolution:
    """Return unit times the inverse of a periodic half-space, on fields of zero mean."""
    with np.errstate(divide="ignore"):
        inverse = 1 / operator.convolution(np.float64).transfer
    inverse[0, 0] = 0.0  # neither kernel has zeros other than the mean
    return Convolution(operator.shape, operator.shape, inverse, np.float64)


def _improved(
    operator: HalfSpace, gap: Field, start: Field, kind: str, value: float
) -> Field | None:
    """Return the pressure on a coarser grid, to its tolerance or as near as it gets."""
    problem = Problem.of(operator, gap, kind, value)
    tolerance = _COARSE_TOLERANCE * min(1.0, _COARSE_SIDE / max(gap.shape))
    try:
        return approach(problem, start, Effort(tolerance, _COARSE_ITERATIONS)).pressure
    except ConvergenceError:
        return None
    finally:
        if gap.size > LARGEST_KEPT:
            operator.forget()


def _interpolated(pressure: Field, operator: HalfSpace) -> Field:
    """Return linear interpolation from every second point, constant beyond the last one.

    Block-wise repetition of values costs more iterations than the coarser grid saves.
    """
    finer = np.empty(operator.shape)
    _interpolate(pressure, finer, operator.periodic)
    return finer


@njit(cache=True)
def _interpolate(coarse, fine, periodic):
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
