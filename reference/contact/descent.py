"""Projected, preconditioned conjugate gradients, in single, then in double precision.

    minimise  1/2 p.K p - p.(d - g)  over 0 <= p <= cap,

with given d, or with given sum of p (without a cap), in which case d is the multiplier of that
constraint. The contact set changes in every iteration, after I. A. Polonsky & L. M. Keer, Wear 231
(1999) 206, but without their restarts; V. Rey, G. Anciaux & J.-F. Molinari, Comput. Mech. 60 (2017)
69.

`descend` is iterative refinement: the residual is computed in double precision, and
`_conjugate_gradients` finds a correction x of the pressure p,

    minimise  1/2 x.K x - x.t  over -p <= x <= cap - p,   any sum of x, or sum x = 0,

with t the displacement that remains. Because x and t are small near the solution, single precision
suffices for most iterations.

All quantities enter homogeneously: no absolute tolerance, and a change of units by powers of two
changes no digit.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import DTypeLike
from scipy import fft

from reference.arrays import Array, Floats
from reference.contact.body import Convolution, ElasticBody, power_of_two, quarter
from reference.contact.extension import Extension
from reference.contact.pieces import each_piece, sums
from reference.errors import ConvergenceError

# Precision; whether plain; and the iterations without halving of the violation that end a stage
# (one that works gains a digit in at most five). Preconditioned by the inverse compliance of waves,
# in single and in double precision; plain: slow, but with proved convergence.
_STAGES: tuple[tuple[DTypeLike, bool, int], ...] = (
    (np.float32, False, 20),
    (np.float64, False, 60),
    (np.float64, True, 2**62),
)
# Digits gained in single precision before the residual is recomputed, and the margin of the goal of
# a stage relative to the tolerance, as the recomputed residual differs slightly.
_SINGLE_GAIN, _MARGIN = 3e-5, 0.7
# Error of a displacement by FFT in units of round-off, with a margin; and the violation below which
# it is considered.
_ROUNDING, _ROUNDING_NEAR = 16.0, 1e-6
# Fewest empty cells that separate opposite rims of a free patch in the preconditioner, else a
# quarter of its side: the residual is continued across them from rim to rim.
_RIM = 8

# Clearance of cells that must stay unloaded, so that they appear far from contact.
NEVER = 1e30
# Without halving of the violation in so many iterations the residual is continued by zeros, which
# is slow and sure: cutting off steps that reach far may lead in circles.
_WANDERING = 5
# Where the contact set changed, old directions may turn the new one from the residual: a step along
# it is short, and the bounds undo it. If its slope is below this share of that along the
# preconditioned residual alone (one, in exact conjugate gradients), that one is the direction.
_ALIGNED = 0.9
# The pressure that clipping at the bounds added is taken from the cells around; some of them reach
# a bound, too. Passes end when this share is left, or after so many under a force (up to a third of
# the convolutions less) and under a penetration (more may not end near full contact).
_LEFT, _SHIFTS = 0.1, {True: 3, False: 1}

_REORDER = {"reassoc", "contract", "nsz"}


class Descended(NamedTuple):
    """Where the descent got: pressure, displacement, depth, and the relative violation.

    `history` has the violations of the iterations, `single` and `double` count the convolutions in
    either precision.
    """

    pressure: Array
    displacement: Array
    depth: float
    violation: float
    history: list[float]
    single: int
    double: int


def descend(
    body: ElasticBody,
    gap: Array,
    start: Array,
    control: str,
    value: float,
    *,
    cap: float = np.inf,
    unilateral: bool = True,
    tolerance: float,
    max_iterations: int,
    partial: bool = False,
) -> Descended:
    """Return the pressure under a penetration or a force, from a starting one (overwritten).

    Gaps are +inf where contact is impossible. Cells at the cap, which is for a given penetration,
    may overlap. If not `unilateral`, cells of finite gap stay in contact for any sign of their
    pressure. The tolerance is the largest overlap of unloaded cells and clearance of loaded ones,
    relative to the depth, unless rounding leaves more; `partial` returns what was reached within
    `max_iterations`, whatever its violation. A ConvergenceError has the violations of all
    iterations.
    """
    pressure, gaps = start.reshape(-1), np.ascontiguousarray(gap).reshape(-1)
    np.minimum(pressure, cap, out=pressure)
    pressure[gaps == np.inf] = 0.0
    if unilateral:
        np.maximum(pressure, 0.0, out=pressure)
    by_force = control == "force"
    depth, history, single, double = 0.0 if by_force else value, list[float](), 0, 0
    level, before, stalled = 0, np.inf, False
    settle = 0.0
    if body.periodic and not by_force:
        # the zero mode is to be that of the contact, <1_C, K 1_C>/n_C inverted: 2 as |q| lacks
        # E*/2, a further 2 as pressure concentrates at the rims of the open cells
        settle = 4 * power_of_two(max(body.spacing)) / (body.unit * body.effective_modulus)
    while True:
        # displacement, depth and violation in double precision
        if by_force:  # a step conserves it up to rounding
            pressure *= value / body.cell_area / pressure.sum()
        displacement = np.zeros(body.shape)
        if pressure.any():
            displacement = np.asarray(body.convolution(np.float64)(start), dtype=np.float64)
            double += 1
        moved = displacement.reshape(-1)
        heights, loaded = sums(each_piece(_displace, moved, pressure, gaps, body.unit))
        if by_force:
            depth = heights / loaded if loaded else np.nan
        worst = max(each_piece(_violation, moved, pressure, gaps, unilateral, depth, cap))
        if not np.isfinite([worst, depth]).all():
            raise ConvergenceError("the contact iteration exceeded the range of numbers", history)
        violation, enough = worst / depth if depth > 0 else np.inf, tolerance
        if violation <= _ROUNDING_NEAR:
            # pressures much above that of full contact displace a nearly flat surface by much more
            # than its heights: rounding of this displacement is a visible part of the depth
            largest = pressure.max() * max(body.spacing) / body.effective_modulus
            enough = max(tolerance, float(_ROUNDING * np.finfo(float).eps * largest / depth))

        # the next stage where this one does not help any more: a call that works gains far more
        if stalled or not worst < before / 4:
            level += 1
        before, limit = worst, max_iterations - len(history)
        if violation <= enough or limit <= 0 or level == len(_STAGES):
            break
        dtype, plain, patience = _STAGES[level]

        # its goal: the tolerance, approached in equal steps in single precision
        goal = _MARGIN * tolerance * depth if depth > 0 else _SINGLE_GAIN * worst
        if dtype == np.float32 and depth > 0 and goal < worst:
            steps = np.ceil(np.log(goal / worst) / np.log(_SINGLE_GAIN))
            goal = float(worst * (goal / worst) ** (1 / steps))

        # the correction, in units near its size
        length = power_of_two(worst)
        unit = length / body.unit
        clearance, lower = (np.empty(gaps.size, dtype) for _ in range(2))
        each_piece(
            _prepare, clearance, lower, moved, pressure, gaps, unilateral, depth, length, unit
        )
        del displacement, moved  # the iteration needs their memory
        room = float(np.asarray(cap / unit, dtype))
        correction, violations, convolutions, stalled = _conjugate_gradients(
            clearance,
            lower,
            body.convolution(dtype),
            None if plain else _preconditioner(body, dtype),
            fixed_sum=by_force,
            settle=settle,
            cap=room,
            goal=goal / length,
            depth=depth / length,
            patience=patience,
            limit=limit,
        )
        single += convolutions if dtype == np.float32 else 0
        double += convolutions if dtype == np.float64 else 0
        history += violations
        each_piece(
            _accept, pressure, correction, lower, unilateral, unit, cap, lower.dtype.type(room)
        )
        del clearance, correction, lower
    if violation > enough and not partial:
        raise ConvergenceError(
            f"contact iteration stopped at a violation of {violation:.1e} of the penetration "
            f"after {len(history)} iterations (tolerance {tolerance:.1e})",
            history,
        )
    return Descended(start, displacement, depth, violation, history, single, double)


def _conjugate_gradients(  # noqa: PLR0913
    clearance: Floats,
    lower: Floats,
    kernel: Convolution,
    inverse: Convolution | None,
    *,
    fixed_sum: bool,
    settle: float,
    cap: float,
    goal: float,
    depth: float,
    patience: int,
    limit: int,
) -> tuple[Floats, list[float], int, bool]:
    """Return the correction x, the violations, the convolutions, and whether it stalled.

    Fields are flat, in the precision of the iteration. The clearance K x - t, first -t, is kept up
    to date with every change of x, so that neither K x nor t is held; `lower` is the bound -p. The
    preconditioner is `inverse`, that of the kernel on a period that contains the grid, with an
    `Extension` of the residual to it; `settle` matches its mean mode to the contact, or 0. With a
    fixed sum that of x is zero and the depth unknown (a given force). It ends at the clearance
    `goal`, or after `patience` iterations without halving of the violation, or `limit` of all.
    """
    shape, number = kernel.shape, clearance.dtype.type
    part, most = np.s_[: shape[0], : shape[1]], number(cap)
    correction, direction, residual, previous = (np.zeros_like(clearance) for _ in range(4))
    # in turn the preconditioned residual, the displacement by the direction, the pressure that the
    # bounds added, and the displacement by that
    image, free = np.empty_like(clearance), np.zeros(clearance.size, np.uint8)
    image_map, free_map = image.reshape(shape), free.reshape(shape)
    if inverse is not None:
        extension = Extension(inverse.shape, clearance.dtype)
        # on a periodic grid the result of the preconditioner is computed in place
        period = image_map if inverse.shape == shape else np.empty(inverse.shape, lower.dtype)
    history: list[float] = []
    convolutions, slope, opened, best, best_at = 0, 0.0, 0.0, np.inf, 0
    for iteration in range(limit):
        # residual: minus the clearance of the free set: loaded or overlapping cells, and at the cap
        # those where the shape lets go. A fixed sum moves the depth by the mean of loaded cells,
        # and the residual has no mean, so that directions keep the force
        shift = 0.0
        if fixed_sum:
            heights, loaded = sums(each_piece(_loaded, clearance, correction, lower))
            shift = heights / loaded if loaded > 0 else 0.0
        moved = number(shift)
        parts = each_piece(_residual, clearance, correction, lower, residual, free, moved, most)
        worst = max(of_piece[2] for of_piece in parts)
        heights, count = sums(parts)[:2]
        if fixed_sum and count > 0:
            np.add(residual, number(heights / count), out=residual, where=free.view(bool))
        history.append(worst / (depth + shift) if depth + shift > 0 else np.inf)
        if worst <= goal:
            return correction, history, convolutions, False
        if worst < best / 2:
            best, best_at = worst, iteration
        cautious = iteration - best_at > _WANDERING
        if iteration - best_at > patience or count == 0:
            return correction, history, convolutions, True

        # preconditioned residual
        scaled = residual
        if inverse is not None:
            empty = clearance.size - count
            # anew where the number of empty cells changed by a fifth
            if settle > 0 and empty > 0 and abs(empty - opened) > empty / 5:
                opened = empty
                uniform = free.astype(clearance.dtype)
                kernel(uniform.reshape(shape), image_map)
                mean = sum(each_piece(_product, uniform, image))
                if mean > 0:  # not so below cells of waves that the body does not feel
                    inverse.transfer[0, 0] = settle * count / mean
                convolutions += 1
            if cautious:
                period[:] = 0
                period[part] = residual.reshape(shape)
                image_map[:] = inverse(period, period)[part]
            else:
                extension.extend(residual.reshape(shape), free_map, period)
                inverse(period, period)
                extension.restrict(period, free_map, image_map)
            scaled = image
            convolutions += 1

        # direction (Polak-Ribiere), which restarts by itself where the contact set changes; with
        # the restarts of Polonsky and Keer, rough contacts take up to four times as many iterations
        maps = scaled, direction, free, residual
        sum_scaled, sum_direction, sum_previous, now, crossed = sums(
            each_piece(_products, *maps, previous)
        )
        # with a fixed sum all directions sum to zero on the free set, like the residual
        mean = sum_scaled / count if fixed_sum else 0.0
        crossed -= mean * sum_previous
        beta = max(0.0, (now - crossed) / slope) if slope > 0 else 0.0
        offset = mean + beta * sum_direction / count if fixed_sum else 0.0
        slope = now
        ahead = float(sum(each_piece(_combine, *maps, number(offset), number(beta))))
        if not ahead > _ALIGNED * now:
            ahead = float(sum(each_piece(_combine, *maps, number(mean), number(0.0))))
        if not ahead > 0:
            return correction, history, convolutions, True

        # step to the minimum along it, cut off at the bounds
        kernel(direction.reshape(shape), image_map)
        convolutions += 1
        curvature = float(sum(each_piece(_product, direction, image)))
        if not curvature > 0:
            return correction, history, convolutions, True
        length = number(ahead / curvature)
        parts = each_piece(_advance, image, clearance, correction, lower, direction, length, most)
        added, excess, loads = sums(parts)

        # the image is now the pressure that clipping added. Moved by E^T to the loaded cells around
        # it, it hardly moves the contact: pressure p on open cells displaces the contact as
        # K_CC^-1 K_CO p does on the contact, and E^T is near that. A change of all pressures in
        # proportion excites the longest waves: only for the small rest
        if added > 0:
            cut_off, least = image_map, _LEFT * added
            tries = _SHIFTS[fixed_sum] if inverse is not None and not cautious else 0
            for _ in range(tries):
                # cells on neither bound
                inside = (correction > lower) & (correction < lower + most)
                np.copyto(free, inside)
                if not added > least or not inside.any():
                    break
                if period.shape != shape:
                    period[:] = 0
                    period[part] = cut_off
                    cut_off = period
                extension.cover(free_map, free_map)  # the shares of blocks alone
                extension.restrict(cut_off, free_map, previous.reshape(shape))
                added, excess, loads = sums(
                    each_piece(_shift, image, correction, lower, previous, most)
                )
                cut_off = previous.reshape(shape)
            if fixed_sum:
                share = -excess / loads if loads > 0 else 0.0
                each_piece(_rescale, image, correction, lower, number(share))
            kernel(image_map, image_map)
            convolutions += 1
            clearance += image
        residual, previous = previous, residual
    return correction, history, convolutions, False


def _preconditioner(body: ElasticBody, dtype: DTypeLike) -> Convolution:
    """Return the inverse compliance of waves, |q| on the half-space, up to a power of two.

    The zero mode is half the smallest wavenumber, so that the operator is positive definite. On a
    periodic half-space with unknown mean pressure it is set from the contact (`settle`): near full
    contact a uniform pressure on the contact has almost no energy, and without a matching large
    zero mode the iterations increase from 25 to many hundreds.
    """
    unit = power_of_two(max(body.spacing))

    def make() -> Convolution:
        padded = body.shape
        if not body.periodic:
            rows, columns = (
                fft.next_fast_len(n + max(_RIM, n // 4), real=True) for n in body.shape
            )
            padded = rows, columns
        stiffness = body.wave_stiffness(quarter(padded, body.spacing))
        stiffness *= unit
        return Convolution(padded, padded, stiffness, dtype)

    inverse = body.cached(("preconditioner", np.dtype(dtype).name), make)
    lowest = 2 * np.pi / max(n * s for n, s in zip(inverse.padded, body.spacing, strict=True))
    longest = float(body.wave_stiffness(np.array([lowest]))[0])
    inverse.transfer[0, 0] = longest / 2 * unit
    return inverse


@njit(cache=True, nogil=True, error_model="numpy")
def _displace(displacement, pressure, gap, unit):
    """Scale the displacement; return sum and number of displacement + gap of loaded cells."""
    total, count = 0.0, 0
    for k in range(gap.size):
        displacement[k] *= unit
        if pressure[k] > 0:
            total += displacement[k] + gap[k]
            count += 1
    return total, count


@njit(cache=True, nogil=True, error_model="numpy")
def _violation(displacement, pressure, gap, unilateral, depth, cap):
    """Return the largest clearance of loaded cells, or overlap of others below the cap."""
    worst = 0.0
    for k in range(gap.size):
        if gap[k] < np.inf:
            clearance = displacement[k] + gap[k] - depth
            if not abs(clearance) < np.inf:
                return np.inf  # a comparison with NaN would pass over it
            if pressure[k] >= cap:
                worst = max(worst, clearance)
            elif not unilateral or pressure[k] > 0:
                worst = max(worst, abs(clearance))
            else:
                worst = max(worst, -clearance)
    return worst


@njit(cache=True, nogil=True, error_model="numpy")
def _prepare(clearance, lower, displacement, pressure, gap, unilateral, depth, length, unit):
    """Fill clearance and bound of the correction; ratios out of range count as infinite."""
    for k in range(gap.size):
        clearance[k] = NEVER
        lower[k] = 0
        if gap[k] < np.inf:
            clearance[k] = min((displacement[k] + gap[k] - depth) / length, NEVER)
            bound = -pressure[k] / unit if unilateral else -NEVER
            lower[k] = max(bound, -NEVER)


@njit(cache=True, nogil=True, error_model="numpy")
def _accept(pressure, correction, lower, unilateral, unit, cap, room):
    """Add the correction; cells on a bound have no pressure, or the cap, `room` in its unit."""
    for k in range(pressure.size):
        value = pressure[k] + np.float64(correction[k]) * unit
        if unilateral and (value < 0 or not correction[k] > lower[k]):
            value = 0.0
        elif value > cap or not correction[k] < lower[k] + room:
            value = cap
        pressure[k] = value


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
def _residual(clearance, correction, lower, residual, free, shift, cap):
    """Fill residual and free set; return the clearances' sum, the cells, the violation."""
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
    # LLVM does not vectorise a running maximum of floats: 64 are computed side by side
    peaks = np.zeros(64, residual.dtype)
    blocks = residual.size - residual.size % 64
    for start in range(0, blocks, 64):
        for k in range(64):
            size = abs(residual[start + k])
            peaks[k] = size if size > peaks[k] else peaks[k]
    for k in range(blocks, residual.size):
        peaks[0] = max(peaks[0], abs(residual[k]))
    largest = peaks[0]
    for peak in peaks:
        largest = peak if peak > largest else largest
    return total, float(count), np.float64(largest)


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
def _advance(response, clearance, correction, lower, direction, length, cap):
    """Step up to the bounds, whose share the response becomes; sums of that, of x, of pressures."""
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


@njit(cache=True, nogil=True, error_model="numpy", fastmath=_REORDER)
def _shift(added, correction, lower, moved, cap):
    """Take `moved` off within the bounds, whose share it becomes; return sums as `_advance`."""
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
