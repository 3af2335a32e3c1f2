"""The compiled inside of the contact solver: projected conjugate gradients on a correction.

    minimise  1/2 x.K x - x.t  over x >= lower,   free sum of x, or sum x = 0

x corrects a known pressure p (lower = -p), t is what the displacements of p leave to be done. Since
x and t are small where p is nearly right, single precision is enough for most of the way: the
double-precision residual is taken outside (`conjugate_gradients`), as in iterative refinement.

Everything between the first iteration and the last is one compiled call on kept memory. The loops
have no branches, so that they are vectorised; sums may be reordered for that reason.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import DTypeLike, NDArray

from reference.halfspace.convolution import convolve

Array = NDArray[np.floating]

# Target of cells that may not be loaded: they always seem to be far from contact.
NEVER = -1e30

_REORDER = {"reassoc", "contract", "nsz"}
# LLVM finds no vectors in a running maximum of floats: so many are run side by side.
_PEAKS = 64

# How an iteration ends: at its goal, without progress, or at the limit of iterations.
REACHED, STALLED, EXHAUSTED = 0, 1, 2


class Work(NamedTuple):
    """Arrays of one grid in one precision."""

    correction: Array
    target: Array
    lower: Array
    displacement: Array
    residual: Array
    previous: Array
    direction: Array
    free: Array
    scaled: Array  # preconditioned residual, then the response to the direction


def allocate(shape: tuple[int, int], dtype: DTypeLike) -> Work:
    """Return work arrays, zero."""
    return Work(*(np.zeros(shape, dtype) for _ in Work._fields))


@njit(cache=True, error_model="numpy")
def descend(work, kernel, precondition, plain, fixed_sum, settle, goal, depth, patience, history):
    """Iterate on the correction until no clearance exceeds the goal.

    Arguments
    ---------
    work : Work
        Correction (zero at first), target and lower bound; the rest is overwritten.
    kernel, precondition : Plan
        K, and its approximate inverse, unused if `plain`.
    fixed_sum : bool
        Whether the sum of the correction is zero and the depth free (force control).
    settle : float
        Factor that matches the mean mode of the preconditioner to the contact, or 0 to leave it.
    goal, depth : float
        Clearance to reach; present depth, by which the history is divided. Units of the target.
    patience : int
        Iterations without halving the violation before giving up.
    history : ndarray
        Receives the violation of each iteration; its length limits them.

    Returns
    -------
    (outcome, iterations, convolutions)
    """
    response = work.scaled
    residual, previous = work.residual, work.previous
    work.displacement[:] = 0
    work.direction[:] = 0
    previous[:] = 0
    shift = _loaded_mean(work) if fixed_sum else 0.0
    descent, best, best_at, opened, convolutions = 0.0, np.inf, 0, 0.0, 0
    for iteration in range(history.size):
        worst, count = _residual(work, residual, shift, fixed_sum)
        total = depth + shift
        history[iteration] = worst / total if total > 0 else np.inf
        if worst <= goal:
            return REACHED, iteration + 1, convolutions
        if worst < best / 2:
            best, best_at = worst, iteration
        if iteration - best_at > patience or count == 0:
            return STALLED, iteration + 1, convolutions
        if plain:
            work.scaled[:] = residual
        else:
            empty = residual.size - count
            if settle > 0 and empty > 0 and abs(empty - opened) > empty / 5:
                opened = empty
                convolve(work.free, work.scaled, kernel)
                convolutions += 1
                precondition.transfer[0] = settle * count / _dot(work.free, work.scaled)
            convolve(residual, work.scaled, precondition)
            convolutions += 1
        slope, descent = _turn(work, residual, previous, fixed_sum, count, descent)
        if not slope > 0:
            return STALLED, iteration + 1, convolutions
        convolve(work.direction, response, kernel)
        convolutions += 1
        curvature = _dot(work.direction, response)
        if not curvature > 0:
            return STALLED, iteration + 1, convolutions
        clipped = _advance(work, response, slope / curvature)
        if clipped:
            if fixed_sum:
                _restore_sum(work)
            convolve(work.correction, work.displacement, kernel)
            convolutions += 1
        if fixed_sum:
            shift = _loaded_mean(work)
        residual, previous = previous, residual
    return EXHAUSTED, history.size, convolutions


@njit(cache=True, error_model="numpy", fastmath=_REORDER)
def _loaded_mean(work):
    """Mean of displacement - target over the loaded cells: what the depth gains."""
    displacement, target = work.displacement.reshape(-1), work.target.reshape(-1)
    correction, lower = work.correction.reshape(-1), work.lower.reshape(-1)
    total, count = 0.0, 0.0
    for k in range(target.size):
        loaded = 1.0 if correction[k] > lower[k] else 0.0
        total += loaded * np.float64(displacement[k] - target[k])
        count += loaded
    return total / count if count > 0 else 0.0


@njit(cache=True, error_model="numpy", fastmath=_REORDER)
def _residual(work, residual_map, shift, fixed_sum):
    """Residual on the free set (loaded, or overlapping); largest violation and number of cells."""
    displacement, target = work.displacement.reshape(-1), work.target.reshape(-1)
    correction, lower = work.correction.reshape(-1), work.lower.reshape(-1)
    residual, free = residual_map.reshape(-1), work.free.reshape(-1)
    zero = residual.dtype.type(0)
    one = residual.dtype.type(1)
    moved = residual.dtype.type(shift)
    total, count = 0.0, 0.0
    for k in range(target.size):
        clearance = displacement[k] - target[k] - moved
        is_free = one if (correction[k] > lower[k]) | (clearance < zero) else zero
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
    return worst, count


@njit(cache=True, error_model="numpy")
def _largest(values):
    """Largest absolute value."""
    peaks = np.zeros(_PEAKS, values.dtype)
    whole = values.size - values.size % _PEAKS
    for start in range(0, whole, _PEAKS):
        for k in range(_PEAKS):
            size = abs(values[start + k])
            peaks[k] = size if size > peaks[k] else peaks[k]
    for k in range(whole, values.size):
        peaks[0] = max(peaks[0], abs(values[k]))
    return np.float64(peaks.max())


@njit(cache=True, error_model="numpy", fastmath=_REORDER)
def _turn(work, residual_map, previous_map, fixed_sum, count, descent):
    """Turn to the next conjugate direction (Polak and Ribiere); slope along it, residual.scaled.

    The directions of Polak and Ribiere forget by themselves when the contact set changes; with the
    restarts of Polonsky and Keer instead, rough contacts took up to four times as many iterations.
    """
    scaled, free = work.scaled.reshape(-1), work.free.reshape(-1)
    residual, previous = residual_map.reshape(-1), previous_map.reshape(-1)
    direction = work.direction.reshape(-1)
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
def _advance(work, response_map, step):
    """Step along the direction, stop at the bound; True when something was stopped."""
    displacement, response = work.displacement.reshape(-1), response_map.reshape(-1)
    correction, lower = work.correction.reshape(-1), work.lower.reshape(-1)
    direction = work.direction.reshape(-1)
    length = displacement.dtype.type(step)
    clipped = 0.0
    for k in range(displacement.size):
        displacement[k] += length * response[k]
        value = correction[k] + length * direction[k]
        clipped += 1.0 if value < lower[k] else 0.0
        correction[k] = value if value > lower[k] else lower[k]
    return clipped > 0


@njit(cache=True, error_model="numpy", fastmath=_REORDER)
def _restore_sum(work):
    """Shrink the pressures, correction - lower, in proportion until the correction's sum is 0."""
    correction, lower = work.correction.reshape(-1), work.lower.reshape(-1)
    excess, loads = 0.0, 0.0
    for k in range(correction.size):
        excess += np.float64(correction[k])
        loads += np.float64(correction[k] - lower[k])
    share = correction.dtype.type(-excess / loads) if loads > 0 else correction.dtype.type(0)
    for k in range(correction.size):
        correction[k] += share * (correction[k] - lower[k])
