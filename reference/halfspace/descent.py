"""The inside of the contact solver: projected conjugate gradients on a correction.

    minimise  1/2 x.K x - x.t  over x >= lower,   free sum of x, or sum x = 0

x corrects a known pressure p (lower = -p), t is what the displacements of p leave to be done. Since
x and t are small where p is nearly right, single precision is enough for most of the way: the
double-precision residual is taken outside (`conjugate_gradients`), as in iterative refinement.

What an iteration does between its convolutions is compiled, in few passes over the grid. The loops
have no branches, so that they are vectorised; sums may be reordered for that reason.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numba import njit
from numpy.typing import NDArray

from reference.halfspace.convolution import Convolution

Array = NDArray[np.floating]

# Target of cells that may not be loaded: they always seem to be far from contact.
NEVER = -1e30

_REORDER = {"reassoc", "contract", "nsz"}
# LLVM finds no vectors in a running maximum of floats: so many are run side by side.
_PEAKS = 64

# How an iteration ends: at its goal, without progress, or at the limit of iterations.
REACHED, STALLED, EXHAUSTED = 0, 1, 2


@dataclass
class Descent:
    """One run of the iteration, from a correction of zero.

    Attributes
    ----------
    target, lower : ndarray
        t, and the bound of the correction; their precision is that of the iteration.
    kernel, inverse : Convolution
        K, and its approximate inverse that preconditions; None for the plain method.
    fixed_sum : bool
        Whether the sum of the correction is zero and the depth free (force control).
    settle : float
        Factor that matches the mean mode of the preconditioner to the contact, or 0 to leave it.
    correction : ndarray
        x.
    history : list of float
        Violation of each iteration, relative to the depth.
    convolutions : int
        How many there were.
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
        """Iterate until no clearance exceeds the goal; how it ended.

        Parameters
        ----------
        goal, depth : float
            Clearance to reach; present depth, by which the history is divided. Units of the target.
        patience : int
            Iterations without halving the violation before giving up.
        limit : int
            Most iterations.
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
        """Move along the next direction, as far as the bound lets; False where there is no way."""
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
    """Mean of displacement - target over the loaded cells: what the depth gains."""
    total, count = 0.0, 0.0
    for k in range(target.size):
        loaded = 1.0 if correction[k] > lower[k] else 0.0
        total += loaded * np.float64(displacement[k] - target[k])
        count += loaded
    return total / count if count > 0 else 0.0


@njit(cache=True, error_model="numpy", fastmath=_REORDER)
def _residual(maps, maps_out, fixed_sum):
    """Residual on the free set (loaded, or overlapping); largest violation, cells, depth gained.

    `maps` are displacement, target, correction and its bound; `maps_out` takes the residual and
    the free set.
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
    """Largest absolute value."""
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
    """Turn to the next conjugate direction (Polak and Ribiere); slope along it, residual.scaled.

    `maps` are the preconditioned residual, the free set, the residual, and the one before.

    The directions of Polak and Ribiere forget by themselves when the contact set changes; with the
    restarts of Polonsky and Keer instead, rough contacts took up to four times as many iterations.
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
    # under force control all directions have the sum zero on the free set; the residual has it
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
    """Set direction = scaled + beta direction - offset on the free set; slope along it."""
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
    """Step along the direction, stop at the bound; True when something was stopped."""
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
    """Shrink the pressures, correction - lower, in proportion until the correction's sum is 0."""
    correction, lower = correction_map.reshape(-1), lower_map.reshape(-1)
    excess, loads = 0.0, 0.0
    for k in range(correction.size):
        excess += np.float64(correction[k])
        loads += np.float64(correction[k] - lower[k])
    share = correction.dtype.type(-excess / loads) if loads > 0 else correction.dtype.type(0)
    for k in range(correction.size):
        correction[k] += share * (correction[k] - lower[k])
