"""The core of the contact solver: projected conjugate gradients on a correction.

    minimise  1/2 x.K x - x.t  over x >= lower,   free sum of x, or sum x = 0

x corrects a known pressure p (lower = -p), and t is the remaining displacement. Because x and t are
small if p is nearly converged, single precision suffices for most iterations: the double-precision
residual is computed outside (`conjugate_gradients`), as in iterative refinement.

The work between convolutions is compiled, with few passes over the grid. The loops have no
branches, so that they are vectorised; sums may be reordered for this.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numba import njit
from numpy.typing import NDArray

from reference.halfspace.convolution import Convolution

Array = NDArray[np.floating]

# Target of cells that must stay unloaded, so that they appear far from contact.
NEVER = -1e30

_REORDER = {"reassoc", "contract", "nsz"}
# LLVM does not vectorise a running maximum of floats; this many are computed in parallel.
_PEAKS = 64

# End of an iteration: at its goal, without progress, or at the limit of iterations.
REACHED, STALLED, EXHAUSTED = 0, 1, 2


@dataclass
class Descent:
    """One run of the iteration, from a correction of zero.

    Attributes
    ----------
    target, lower : ndarray
        t, and the bound of the correction, in the precision of the iteration.
    kernel, inverse : Convolution
        K, and its approximate inverse as preconditioner; None for the plain method.
    fixed_sum : bool
        Whether the sum of the correction is zero and the depth free (force control).
    settle : float
        Factor that matches the mean mode of the preconditioner to the contact, or 0 for none.
    correction : ndarray
        x.
    history : list of float
        Violations of the iterations, relative to the depth.
    convolutions : int
        Number of convolutions.
    """

    target: Array
    lower: Array
    kernel: Convolution
    inverse: Convolution | None
    fixed_sum: bool
    settle: float
    history: list[float] = field(default_factory=list)
    convolutions: int = 0

    def __post_init__(self) -> None:
        self.correction, self._displacement = self._blank(), self._blank()
        self._direction, self._free = self._blank(), self._blank()
        self._residual, self._previous = self._blank(), self._blank()
        self._slope, self._opened = 0.0, 0.0

    def _blank(self) -> Array:
        return np.zeros_like(self.target)

    def run(self, goal: float, depth: float, patience: int, limit: int) -> int:
        """Iterate until no clearance exceeds the goal; return how the iteration ended.

        Parameters
        ----------
        goal, depth : float
            Target clearance; current depth, which scales the history. In units of the target.
        patience : int
            Iterations without halving of the violation before the stage ends.
        limit : int
            Largest number of iterations.
        """
        best, best_at = np.inf, 0
        for iteration in range(limit):
            worst, count, shift = _residual(
                (self._displacement, self.target, self.correction, self.lower),
                (self._residual, self._free),
                self.fixed_sum,
            )
            total = depth + shift
            self.history.append(worst / total if total > 0 else np.inf)
            if worst <= goal:
                return REACHED
            if worst < best / 2:
                best, best_at = worst, iteration
            if iteration - best_at > patience or count == 0 or not self._step(count):
                return STALLED
        return EXHAUSTED

    def _step(self, count: float) -> bool:
        """Move along the next direction up to the bound; return False without a direction."""
        slope, self._slope = _turn(
            (self._preconditioned(count), self._free, self._residual, self._previous),
            self._direction,
            self.fixed_sum,
            count,
            self._slope,
        )
        if not slope > 0:
            return False
        response = self._convolve(self.kernel, self._direction)
        curvature = _dot(self._direction, response)
        if not curvature > 0:
            return False
        clipped = _advance(
            *(self._displacement, response, self.correction, self.lower, self._direction),
            slope / curvature,
        )
        if clipped:
            if self.fixed_sum:
                _restore_sum(self.correction, self.lower)
            self._displacement = self._convolve(self.kernel, self.correction)
        self._residual, self._previous = self._previous, self._residual
        return True

    def _preconditioned(self, count: float) -> Array:
        if self.inverse is None:
            return self._residual
        empty = self.target.size - count
        if self.settle > 0 and empty > 0 and abs(empty - self._opened) > empty / 5:
            self._opened = empty
            response = self._convolve(self.kernel, self._free)
            self.inverse.set_mean_factor(self.settle * count / _dot(self._free, response))
        return self._convolve(self.inverse, self._residual)

    def _convolve(self, operator: Convolution, values: Array) -> Array:
        self.convolutions += 1
        return operator(values)


@njit(cache=True, error_model="numpy", fastmath=_REORDER)
def _loaded_mean(displacement, target, correction, lower):
    """Return the mean of displacement - target over the loaded cells, the change of depth."""
    total, count = 0.0, 0.0
    for k in range(target.size):
        loaded = 1.0 if correction[k] > lower[k] else 0.0
        total += loaded * np.float64(displacement[k] - target[k])
        count += loaded
    return total / count if count > 0 else 0.0


@njit(cache=True, error_model="numpy", fastmath=_REORDER)
def _residual(maps, maps_out, fixed_sum):
    """Fill the residual on the free set (loaded or overlapping); return violation, cells, depth.

    `maps` contains displacement, target, correction and its bound; `maps_out` receives the residual
    and the free set.
    """
    displacement, target = maps[0].reshape(-1), maps[1].reshape(-1)
    correction, lower = maps[2].reshape(-1), maps[3].reshape(-1)
    residual, free = maps_out[0].reshape(-1), maps_out[1].reshape(-1)
    shift = _loaded_mean(displacement, target, correction, lower) if fixed_sum else 0.0
    zero = residual.dtype.type(0)
    unity = residual.dtype.type(1)
    moved = residual.dtype.type(shift)
    total, count = 0.0, 0.0
    for k in range(target.size):
        clearance = displacement[k] - target[k] - moved
        is_free = unity if (correction[k] > lower[k]) | (clearance < zero) else zero
        clearance = clearance if is_free > zero else zero
        free[k] = is_free
        residual[k] = -clearance
        total += np.float64(clearance)
        count += np.float64(is_free)
    worst = _largest(residual)
    if fixed_sum and count > 0:
        mean = residual.dtype.type(total / count)
        for k in range(target.size):
            residual[k] += mean * free[k]
    return worst, count, shift


@njit(cache=True, error_model="numpy")
def _largest(values):
    """Return the largest absolute value."""
    peaks = np.zeros(_PEAKS, values.dtype)
    blocks = values.size - values.size % _PEAKS
    for start in range(0, blocks, _PEAKS):
        for k in range(_PEAKS):
            size = abs(values[start + k])
            peaks[k] = size if size > peaks[k] else peaks[k]
    for k in range(blocks, values.size):
        peaks[0] = max(peaks[0], abs(values[k]))
    return np.float64(peaks.max())


@njit(cache=True, error_model="numpy", fastmath=_REORDER)
def _turn(maps, direction_map, fixed_sum, count, descent):
    """Set the next conjugate direction (Polak-Ribiere); return slope along it, residual.scaled.

    `maps` contains the preconditioned residual, the free set, the residual, and the previous one.

    Polak-Ribiere directions restart automatically when the contact set changes; with the restarts
    of Polonsky and Keer, rough contacts took up to four times as many iterations.
    """
    scaled, free = maps[0].reshape(-1), maps[1].reshape(-1)
    residual, previous = maps[2].reshape(-1), maps[3].reshape(-1)
    direction = direction_map.reshape(-1)
    sum_scaled, sum_direction, sum_previous, now, crossed = 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(scaled.size):
        value = np.float64(scaled[k] * free[k])
        sum_scaled += value
        now += value * np.float64(residual[k])
        crossed += value * np.float64(previous[k])
        sum_direction += np.float64(direction[k] * free[k])
        sum_previous += np.float64(previous[k] * free[k])
    # under force control all directions sum to zero on the free set, like the residual
    mean = sum_scaled / count if fixed_sum else 0.0
    crossed -= mean * sum_previous
    beta = max(0.0, (now - crossed) / descent) if descent > 0 else 0.0
    offset = mean + beta * sum_direction / count if fixed_sum else 0.0
    slope = _combine(scaled, direction, free, residual, beta, offset)
    if not slope > 0:
        slope = _combine(scaled, direction, free, residual, 0.0, mean)
    return slope, now


@njit(cache=True, error_model="numpy", fastmath=_REORDER)
def _combine(scaled, direction, free, residual, beta, offset):
    """Set direction = scaled + beta direction - offset on the free set; return its slope."""
    slope, factor, less = 0.0, scaled.dtype.type(beta), scaled.dtype.type(offset)
    for k in range(scaled.size):
        direction[k] = free[k] * (scaled[k] + factor * direction[k] - less)
        slope += np.float64(direction[k]) * np.float64(residual[k])
    return slope


@njit(cache=True, error_model="numpy", fastmath=_REORDER)
def _dot(first_map, second_map):
    first, second = first_map.reshape(-1), second_map.reshape(-1)
    total = 0.0
    for k in range(first.size):
        total += np.float64(first[k]) * np.float64(second[k])
    return total


@njit(cache=True, error_model="numpy", fastmath=_REORDER)
def _advance(displacement_map, response_map, correction_map, lower_map, direction_map, step):
    """Step along the direction up to the bound; return True if the bound was reached."""
    displacement, response = displacement_map.reshape(-1), response_map.reshape(-1)
    correction, lower = correction_map.reshape(-1), lower_map.reshape(-1)
    direction = direction_map.reshape(-1)
    length = displacement.dtype.type(step)
    clipped = 0.0
    for k in range(displacement.size):
        displacement[k] += length * response[k]
        value = correction[k] + length * direction[k]
        clipped += 1.0 if value < lower[k] else 0.0
        correction[k] = value if value > lower[k] else lower[k]
    return clipped > 0


@njit(cache=True, error_model="numpy", fastmath=_REORDER)
def _restore_sum(correction_map, lower_map):
    """Scale the pressures, correction - lower, so that the correction's sum is 0."""
    correction, lower = correction_map.reshape(-1), lower_map.reshape(-1)
    excess, loads = 0.0, 0.0
    for k in range(correction.size):
        excess += np.float64(correction[k])
        loads += np.float64(correction[k] - lower[k])
    share = correction.dtype.type(-excess / loads) if loads > 0 else correction.dtype.type(0)
    for k in range(correction.size):
        correction[k] += share * (correction[k] - lower[k])
