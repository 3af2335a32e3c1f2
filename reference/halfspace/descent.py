"""The core of the contact solver: projected conjugate gradients on a correction.

    minimise  1/2 x.K x - x.t  over x >= lower,   free sum of x, or sum x = 0

x corrects a known pressure p (lower = -p), and t is the remaining displacement. Where a body yields
and the sum is free, also x <= lower + cap. Because x and t are
small if p is nearly converged, single precision suffices for most iterations: the double-precision
residual is computed outside (`conjugate_gradients`), as in iterative refinement.

The clearance K x - t is kept up to date with every change of x, so that neither K x nor t is held.
The work between convolutions is compiled, with few passes over the grid, in pieces that threads may
share. The loops have no branches, so that they are vectorised; sums may be reordered for this.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from reference.halfspace import pieces
from reference.halfspace.convolution import Convolution
from reference.halfspace.extension import Extension

Array = NDArray[np.floating]
Map = NDArray[np.floating] | NDArray[np.uint8]

# Clearance of cells that must stay unloaded, so that they appear far from contact.
NEVER = 1e30

_REORDER = {"reassoc", "contract", "nsz"}
# LLVM does not vectorise a running maximum of floats; this many are computed in parallel.
_PEAKS = 64

# Without halving of the violation in so many iterations the residual is continued by zeros, which
# is slow and sure: cutting off steps that reach far may lead in circles.
_WANDERING = 5

# Where the contact set changed, old directions may turn the new one from the residual: a step along
# it is short, and what it cuts off undoes it. Below this share of the slope of the preconditioned
# residual alone, which exact conjugate gradients have, that one is the direction.
_ALIGNED = 0.9

# What the bounds added is taken from the cells around; some of them reach a bound, too. Where they
# leave more than this share it is taken from others, so many times at most: under a force up to a
# third of the convolutions less. Under a penetration near full contact more than one loses its way
# (noise on cells of 1:50: 4 of 24 solves do not end, with one 1 of 24).
_LEFT, _SHIFTS = 0.1, {True: 3, False: 1}

# End of an iteration: at its goal, without progress, or at the limit of iterations.
REACHED, STALLED, EXHAUSTED = 0, 1, 2


@dataclass
class Descent:
    """One run of the iteration, from a correction of zero.

    Attributes
    ----------
    clearance, lower : ndarray
        K x - t, first -t, and the bound of the correction, in the precision of the iteration.
    kernel, inverse : Convolution
        K, and its inverse on a period that contains the grid, which with an `Extension` of the
        residual to it is the preconditioner; None for the plain method.
    fixed_sum : bool
        Whether the sum of the correction is zero and the depth free (force control).
    settle : float
        Factor that matches the mean mode of the preconditioner to the contact, or 0 for none.
    cap : float
        Largest pressure; infinite with a fixed sum.
    correction : ndarray
        x, flat like the clearance and its bound.
    history : list of float
        Violations of the iterations, relative to the depth.
    convolutions : int
        Number of convolutions.
    """

    clearance: Array
    lower: Array
    kernel: Convolution
    inverse: Convolution | None
    fixed_sum: bool
    settle: float
    cap: float = np.inf
    history: list[float] = field(default_factory=list)
    convolutions: int = 0

    def __post_init__(self) -> None:
        self.correction, self._direction = self._blank(), self._blank()
        self._residual, self._previous = self._blank(), self._blank()
        # the preconditioned residual, then the displacement by the direction
        self._response = np.empty_like(self.clearance)
        self._free = np.zeros(self.clearance.size, np.uint8)
        self._slope, self._opened, self._cautious = 0.0, 0.0, False
        if self.inverse is not None:
            shape, period = self.kernel.shape, self.inverse.shape
            self._extension = Extension(shape, period, self.clearance.dtype)
            # on a periodic grid the result of the preconditioner is computed in place
            whole = period == shape
            self._period = (
                self._response.reshape(shape) if whole else np.empty(period, self.lower.dtype)
            )

    def _blank(self) -> Array:
        return np.zeros(self.clearance.size, self.clearance.dtype)

    def run(self, goal: float, depth: float, patience: int, limit: int) -> int:
        """Iterate until no clearance exceeds the goal; return how the iteration ended.

        Parameters
        ----------
        goal, depth : float
            Target clearance; current depth, which scales the history. In units of the clearance.
        patience : int
            Iterations without halving of the violation before the stage ends.
        limit : int
            Largest number of iterations.
        """
        best, best_at = np.inf, 0
        for iteration in range(limit):
            worst, count, shift = self._turn_to_residual()
            total = depth + shift
            self.history.append(worst / total if total > 0 else np.inf)
            if worst <= goal:
                return REACHED
            if worst < best / 2:
                best, best_at = worst, iteration
            self._cautious = iteration - best_at > _WANDERING
            if iteration - best_at > patience or count == 0 or not self._step(count):
                return STALLED
        return EXHAUSTED

    def _turn_to_residual(self) -> tuple[float, float, float]:
        """Fill residual and free set (loaded or overlapping); return violation, cells, depth.

        Cells at the cap are free only where the shape lets go.
        """
        state = self.clearance, self.correction, self.lower
        shift = 0.0
        if self.fixed_sum:
            total, loaded = _summed(_swept(_loaded, state))
            shift = total / loaded if loaded > 0 else 0.0
        parts = _swept(_residual, (*state, self._residual, self._free), (shift, self.cap))
        worst = max(part[2] for part in parts)
        total, count = _summed(parts)[:2]
        if self.fixed_sum and count > 0:
            _swept(_level, (self._residual, self._free), total / count)
        return worst, count, shift

    def _step(self, count: float) -> bool:
        """Move along the next direction up to the bound; return False without a direction."""
        slope = self._turn(self._preconditioned(count), count)
        if not slope > 0:
            return False
        response = self._displaced(self._direction)
        curvature = _dot(self._direction, response)
        if not curvature > 0:
            return False
        state = response, self.clearance, self.correction, self.lower, self._direction
        moved = _swept(_advance, state, (slope / curvature, self.cap))
        added, excess, loads = _summed(moved)
        if added > 0:
            # the response now has what the bounds added to the pressure
            if self.inverse is not None and not self._cautious:
                excess, loads = self._shifted(added, excess, loads)
            if self.fixed_sum:
                share = -excess / loads if loads > 0 else 0.0
                _swept(_rescale, (response, self.correction, self.lower), share)
            more = self._displaced(response)
            _swept(_add, (self.clearance, more))
        self._residual, self._previous = self._previous, self._residual
        return True

    def _shifted(self, added: float, excess: float, loads: float) -> tuple[float, float]:
        """Take what the bounds added from the loaded cells around; return the last two sums.

        Pressure p on open cells displaces the contact as K_CC^-1 K_CO p does on the contact, the
        transpose of its best extension: the contact hardly moves when the cut-off moves there. A
        change of all pressures in proportion alone excites the longest waves.
        """
        shape = self.kernel.shape
        state = self.correction, self.lower
        # the previous residual is no longer needed
        free, moved = self._free.reshape(shape), self._previous.reshape(shape)
        cut_off, least = self._response.reshape(shape), _LEFT * added
        for _ in range(_SHIFTS[self.fixed_sum]):
            if not added > least or not sum(_swept(_between, (*state, self._free), self.cap)):
                break
            if self._period.shape != shape:
                self._period[:] = 0
                self._period[: shape[0], : shape[1]] = cut_off
                cut_off = self._period
            self._extension.cover(free)
            self._extension.restrict(cut_off, free, moved)
            maps = self._response, *state, self._previous
            added, excess, loads = _summed(_swept(_shift, maps, self.cap))
            cut_off = moved
        return excess, loads

    def _turn(self, scaled: Array, count: float) -> float:
        """Set the next conjugate direction (Polak-Ribiere); return the slope along it.

        Polak-Ribiere directions restart automatically when the contact set changes; with the
        restarts of Polonsky and Keer, rough contacts took up to four times as many iterations.
        """
        maps = scaled, self._direction, self._free, self._residual
        sums = _summed(_swept(_products, (*maps, self._previous)))
        sum_scaled, sum_direction, sum_previous, now, crossed = sums
        # under force control all directions sum to zero on the free set, like the residual
        mean = sum_scaled / count if self.fixed_sum else 0.0
        crossed -= mean * sum_previous
        beta = max(0.0, (now - crossed) / self._slope) if self._slope > 0 else 0.0
        offset = mean + beta * sum_direction / count if self.fixed_sum else 0.0
        slope = float(sum(_swept(_combine, maps, offset, beta)))
        if not slope > _ALIGNED * now:
            slope = float(sum(_swept(_combine, maps, mean, 0.0)))
        self._slope = now
        return slope

    def _preconditioned(self, count: float) -> Array:
        if self.inverse is None:
            return self._residual
        empty = self.clearance.size - count
        if self.settle > 0 and empty > 0 and abs(empty - self._opened) > empty / 5:
            self._opened = empty
            uniform = self._free.astype(self.clearance.dtype)
            mean = _dot(uniform, self._displaced(uniform))
            self.inverse.set_mean_factor(self.settle * count / mean)
        shape, period = self.kernel.shape, self._period
        residual, free = self._residual.reshape(shape), self._free.reshape(shape)
        response = self._response.reshape(shape)
        self.convolutions += 1
        if self._cautious:
            period[:] = 0
            period[: shape[0], : shape[1]] = residual
            response[:] = self.inverse(period, period)[: shape[0], : shape[1]]
        else:
            self._extension.extend(residual, free, period)
            self.inverse(period, period)
            self._extension.restrict(period, free, response)
        return self._response

    def _displaced(self, values: Array) -> Array:
        self.convolutions += 1
        shape = self.kernel.shape
        self.kernel(values.reshape(shape), self._response.reshape(shape))
        return self._response


def _swept(
    work: Callable[..., Any], maps: tuple[Map, ...], *numbers: float | tuple[float, ...]
) -> list[Any]:
    """Return what a compiled loop makes of every piece of flat maps."""
    dtype = maps[0].dtype.type
    scalars = [
        tuple(map(dtype, value)) if isinstance(value, tuple) else dtype(value) for value in numbers
    ]
    if maps[0].size <= pieces.SIZE:
        return [work(*maps, *scalars)]
    return pieces.over(
        maps[0].size, pieces.SIZE, lambda part: work(*(m[part] for m in maps), *scalars)
    )


def _summed(parts: list[Any]) -> Any:
    """Return the sums of what a loop found in every piece."""
    return parts[0] if len(parts) == 1 else tuple(map(sum, zip(*parts, strict=True)))


def _dot(first: Array, second: Array) -> float:
    return float(sum(_swept(_product, (first, second))))


@njit(cache=True, nogil=True, error_model="numpy", fastmath=_REORDER)
def _loaded(clearance, correction, lower):
    """Return sum and number of the clearances of loaded cells; their mean moves the depth."""
    total, count = 0.0, 0.0
    for k in range(clearance.size):
        loaded = 1.0 if correction[k] > lower[k] else 0.0
        total += loaded * np.float64(clearance[k])
        count += loaded
    return total, count


@njit(cache=True, nogil=True, error_model="numpy", fastmath=_REORDER)
def _residual(clearance, correction, lower, residual, free, limits):
    """Fill residual and free set; return the clearances' sum, the cells, the violation.

    `limits` are the shift of the depth and the cap.
    """
    shift, cap = limits
    zero, total, count = residual.dtype.type(0), 0.0, 0
    for k in range(clearance.size):
        moved = clearance[k] - shift
        is_free = (correction[k] > lower[k]) | (moved < zero)
        is_free &= (correction[k] < lower[k] + cap) | (moved > zero)
        moved = moved if is_free else zero
        free[k] = is_free
        residual[k] = -moved
        total += np.float64(moved)
        count += is_free
    return total, float(count), _largest(residual)


@njit(cache=True, nogil=True, error_model="numpy")
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
    largest = peaks[0]
    for peak in peaks:
        largest = peak if peak > largest else largest
    return np.float64(largest)


@njit(cache=True, nogil=True, error_model="numpy", fastmath=_REORDER)
def _level(residual, free, mean):
    """Take the mean from the residual on the free set."""
    for k in range(residual.size):
        residual[k] += mean * residual.dtype.type(free[k])


@njit(cache=True, nogil=True, error_model="numpy", fastmath=_REORDER)
def _products(scaled, direction, free, residual, previous):
    """Return the sums on the free set that the next direction needs."""
    sum_scaled, sum_direction, sum_previous, now, crossed = 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(scaled.size):
        inside = np.float64(free[k])
        value = inside * np.float64(scaled[k])
        sum_scaled += value
        now += value * np.float64(residual[k])
        crossed += value * np.float64(previous[k])
        sum_direction += inside * np.float64(direction[k])
        sum_previous += inside * np.float64(previous[k])
    return sum_scaled, sum_direction, sum_previous, now, crossed


@njit(cache=True, nogil=True, error_model="numpy", fastmath=_REORDER)
def _combine(scaled, direction, free, residual, offset, factor):
    """Set direction = scaled + factor direction - offset on the free set; return its slope."""
    slope = 0.0
    for k in range(scaled.size):
        inside = scaled.dtype.type(free[k])
        direction[k] = inside * (scaled[k] + factor * direction[k] - offset)
        slope += np.float64(direction[k]) * np.float64(residual[k])
    return slope


@njit(cache=True, nogil=True, error_model="numpy", fastmath=_REORDER)
def _product(first, second):
    total = 0.0
    for k in range(first.size):
        total += np.float64(first[k]) * np.float64(second[k])
    return total


@njit(cache=True, nogil=True, error_model="numpy", fastmath=_REORDER)
def _advance(response, clearance, correction, lower, direction, limits):
    """Step along the direction up to the bounds; the response becomes what the bounds added.

    `limits` are the length of the step and the cap. Returns the size of what was added, the sum of
    the correction and that of the pressures.
    """
    length, cap = limits
    added, excess, loads = 0.0, 0.0, 0.0
    for k in range(clearance.size):
        clearance[k] += length * response[k]
        value = correction[k] + length * direction[k]
        upper = lower[k] + cap
        bounded = value if value > lower[k] else lower[k]
        bounded = bounded if bounded < upper else upper
        response[k] = bounded - value
        added += abs(np.float64(bounded - value))
        correction[k] = bounded
        excess += np.float64(bounded)
        loads += np.float64(bounded - lower[k])
    return added, excess, loads


@njit(cache=True, nogil=True, error_model="numpy")
def _between(correction, lower, free, cap):
    """Fill the cells on neither bound; return their number."""
    count = 0
    for k in range(correction.size):
        free[k] = (correction[k] > lower[k]) & (correction[k] < lower[k] + cap)
        count += free[k]
    return count


@njit(cache=True, nogil=True, error_model="numpy", fastmath=_REORDER)
def _shift(added, correction, lower, moved, cap):
    """Take `moved` off within the bounds; return sums as `_advance`.

    `moved` becomes what the bounds added this time.
    """
    left, excess, loads = 0.0, 0.0, 0.0
    for k in range(correction.size):
        target = correction[k] - moved[k]
        upper = lower[k] + cap
        value = target if target > lower[k] else lower[k]
        value = value if value < upper else upper
        added[k] += value - correction[k]
        moved[k] = value - target
        left += abs(np.float64(value - target))
        correction[k] = value
        excess += np.float64(value)
        loads += np.float64(value - lower[k])
    return left, excess, loads


@njit(cache=True, nogil=True, error_model="numpy", fastmath=_REORDER)
def _rescale(added, correction, lower, share):
    """Scale the pressures, correction - lower, by 1 + share, so that the correction's sum is 0."""
    for k in range(correction.size):
        more = share * (correction[k] - lower[k])
        added[k] += more
        correction[k] += more


@njit(cache=True, nogil=True, error_model="numpy", fastmath=_REORDER)
def _add(values, more):
    for k in range(values.size):
        values[k] += more[k]
