"""A rigid shape pressed on an elastic body: by descent on large grids, by pivoting on small ones.

Find p >= 0 with u = K p = d - g where p > 0 and u >= d - g elsewhere. Where a body yields, at a
largest pressure, cells that have it give way beyond their elastic displacement, and overlap.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from reference.arrays import Array, Mask
from reference.contact.body import Convolution, ElasticBody
from reference.contact.descent import descend
from reference.contact.pivot import CELL_LIMIT, pivot, tabulated
from reference.errors import ConvergenceError, choice_faults, refuse
from reference.loads import Load

CONTROLS = {"descent": ("penetration", "force", "mean_gap"), "pivot": ("penetration", "force")}

# The depth is estimated from the geometric overlap: the actual one is 0.96 of it for Hertz, 0.64 to
# 0.93 for rough surfaces, 1.12 for a single cell. If it is exceeded, the window grows and the load
# is solved again.
_REACH = 1.15
# For grids with a shorter side, a coarser grid saves no time.
SHORTEST_COARSENED = 128
# Violation to which the coarser grid is solved; what is finer is lost in the interpolation. Beyond
# this side it falls with the grid, as the shortest waves are an ever smaller part of the
# penetration.
_COARSE_TOLERANCE, _COARSE_SIDE, _COARSE_ITERATIONS = 1e-2, 256, 60
# The overlap for a force is slightly deeper than the contact.
_SHALLOWER = 0.85
# With tension in more cells than this fraction, the linear solution is not a good start.
_NEARLY_FULL = 0.1


@dataclass(frozen=True)
class Contact:
    """One converged load step of a rigid shape on an elastic body.

    Displacement and gaps of the whole grid are evaluated on demand.
    """

    # rigid approach d, from gap zero: after first touch where the smallest gap is zero; in contact
    # displacement = d - gap
    penetration: float
    force: float  # sum of pressure times cell area
    pressure: Array  # (nx, ny): cell values, not negative
    iterations: int  # all stages on the finest grid, in the last window, at all depths of a search
    # Largest distance from the contact conditions, relative to the penetration: the overlap of
    # cells without pressure or the remaining gap (of either sign) of cells with pressure, whichever
    # is larger; recomputed in double precision for the final pressure.
    violation: float
    operator: ElasticBody = field(repr=False)
    initial_gap: Array = field(repr=False)
    # violations of the iterations; of pivoting, wrong cells by round
    history: list[float] = field(default_factory=list, repr=False)
    # of these iterations, in single and in double precision
    convolutions: tuple[int, int] = (0, 0)

    @property
    def mask(self) -> Mask:
        """Cells in contact, pressure > 0."""
        return self.pressure > 0

    @cached_property
    def displacement(self) -> Array:
        """Displacement of all cells, positive into the body."""
        return self.operator.apply(self.pressure)

    def with_displacement(self, displacement: Array) -> Contact:
        """Return the contact with its displacement, which need not be computed then."""
        known = replace(self)
        vars(known)["displacement"] = displacement
        return known

    def forget_displacement(self) -> None:
        """Give its memory back; it is computed again when asked for, to the same digits."""
        vars(self).pop("displacement", None)

    @property
    def gap(self) -> Array:
        """Remaining gap of all cells; infinite outside the shape."""
        return self.initial_gap - self.penetration + self.displacement

    @cached_property
    def mean_gap(self) -> float:
        """Mean of the remaining gap over the cells where it is finite."""
        finite = np.isfinite(self.initial_gap)
        if self.operator.periodic and finite.all():
            mean = self.operator.mean_compliance * float(self.pressure.mean())
            return float(self.initial_gap.mean()) - self.penetration + mean
        return float(self.gap[finite].mean())


def press(
    body: ElasticBody,
    gap: ArrayLike,
    load: Load,
    *,
    cap: float = np.inf,
    start: Contact | None = None,
    tolerance: float = 1e-8,
    max_iterations: int = 2000,
    by: Literal["descent", "pivot"] = "descent",
) -> Contact:
    """Return the frictionless contact of a rigid shape on a body at one load.

    By descent (`descent`): preconditioned conjugate gradients on any body, for large grids. By
    pivoting (`pivot`), the chapter's contact iteration (19.5-19.8): solve inside the contact,
    remove cells in tension, add overlapping cells, repeat, with dense matrices; residuals near
    rounding, for up to some thousand contact cells of an elastic body that is not periodic.

    Parameters
    ----------
    gap : array_like, shape (nx, ny)
        Initial gap g >= 0 of the shape; +inf where contact is impossible.
    load : Load
        Penetration, force, or (by descent) mean gap over the finite cells; one value. On the
        periodic half-space the mean displacement is zero, so that mean_gap = <g> - d.
    cap : float
        Largest pressure that the body carries, its hardness (by descent).
    start : Contact, optional
        A solution at a nearby load.
    tolerance : float
        By descent: largest overlap of unloaded cells and largest gap of loaded cells, relative to
        the penetration, or what rounding leaves if that is more (`Contact.violation` tells).
        Tension does not occur. A force below a cap is met to ten times the tolerance.
    max_iterations : int
        Limit for all stages of one descent together (a search for a depth, below a cap, makes
        several), or of contact sets. Beyond it a ConvergenceError has the history of violations.

    Examples
    --------
    Hertz, F = 4/3 E* sqrt(R) d^1.5, with R = 1 and d = 0.01:

    >>> from reference.halfspace import FreeOperator
    >>> x = (np.arange(64) - 31.3) / 240
    >>> K = FreeOperator((64, 64), (1 / 240, 1 / 240), 1.0)
    >>> ball = (x[:, None] ** 2 + x**2) / 2
    >>> for by in ("descent", "pivot"):
    ...     contact = press(K, ball, Load("penetration", 0.01), by=by)
    ...     print(round(contact.force / (4 / 3 * 0.01**1.5), 2), contact.violation < 1e-8)
    1.0 True
    1.0 True
    """
    load.single()
    contacts = sweep(
        body,
        gap,
        load,
        cap=cap,
        start=start,
        tolerance=tolerance,
        max_iterations=max_iterations,
        by=by,
    )
    return next(contacts)


def sweep(
    body: ElasticBody,
    gap: ArrayLike,
    load: Load,
    *,
    cap: float = np.inf,
    start: Contact | None = None,
    tolerance: float = 1e-8,
    max_iterations: int = 2000,
    by: Literal["descent", "pivot"] = "descent",
) -> Iterator[Contact]:
    """Solve a strictly increasing list of loads, each from the last; one contact per load.

    Arguments as for `press`, which are checked at the call, not at the first `next`. After `start`
    each load begins with the last pressure, by descent extrapolated linearly in the load from the
    last two. Where a load fails, a new sweep may begin at the next one.
    """
    refuse(choice_faults("by", by, CONTROLS))
    load.one_of(*CONTROLS[by])
    if by == "pivot" and body.periodic:
        raise ValueError("pivoting is for bodies that are not periodic; use descent")
    if by == "pivot" and cap < np.inf:
        raise ValueError("pivoting is for elastic bodies; use descent below a hardness")
    faults = [] if cap > 0 else [f"hardness must be positive, not {cap!r}"]
    refuse(faults + effort_faults(tolerance, max_iterations))
    gap = check_gap(body, gap)
    if start is not None and start.pressure.shape != body.shape:
        raise ValueError(f"start has shape {start.pressure.shape}, the operator {body.shape}")
    if by == "pivot":
        return _pivot(body, gap, load, start, max_iterations)

    def descend_all() -> Iterator[Contact]:
        earlier: Array | None = None
        last = None if start is None else np.asarray(start.pressure, np.float64)
        loads = load.values
        for step, value in enumerate(loads):
            begin = None if last is None else last.copy()
            if last is not None and earlier is not None:
                guess = last - earlier
                guess *= (value - loads[step - 1]) / (loads[step - 1] - loads[step - 2])
                guess += last
                begin = np.maximum(guess, 0.0, out=guess) if (guess > 0).any() else begin
                del guess
            earlier = last if step else None  # the one before is not needed during the solve
            contact = _descend(
                body, gap, load.control, float(value), begin, cap, tolerance, max_iterations
            )
            last = contact.pressure
            yield contact
            contact.forget_displacement()  # whoever has it: the next load needs the memory
            del contact, begin

    return descend_all()


# overflows are detected in the result and reported
@np.errstate(over="ignore", invalid="ignore")
def _descend(
    body: ElasticBody,
    gap: Array,
    control: str,
    value: float,
    start: Array | None,
    cap: float,
    tolerance: float,
    max_iterations: int,
) -> Contact:
    """Solve one load by descent; the start is overwritten."""
    finite, lowest, effort = np.isfinite(gap), float(gap.min()), (tolerance, max_iterations)

    def at(depth: float, pressure: Array | None) -> Contact:
        return _descend(body, gap, "penetration", depth, pressure, cap, *effort)

    # a mean gap is a depth where <u> = 0, else searched for; met to the tolerance times the
    # penetration, like every clearance
    if control == "mean_gap":
        widest = float(gap[finite].mean())
        if value >= widest:
            raise ValueError(
                f"mean_gap {value!r} is not below the mean gap at first touch, {widest!r}"
            )
        if body.periodic and not body.sinks and finite.all():
            return at(widest - value, start)
        return _search_depth(
            at,
            missing=lambda contact: contact.mean_gap - value,
            allowed=lambda contact: tolerance * contact.penetration,
            touch=(0.0, widest - value),
            depth=widest - value,
            start=start,
            name="mean gap",
        )
    # a force below a cap: the elastic contact if that is enough, else a search
    if control == "force" and cap < np.inf:
        elastic = _descend(body, gap, "force", value, start, np.inf, *effort)
        if elastic.pressure.max() <= cap:
            return elastic
        most = cap * np.count_nonzero(finite) * body.cell_area
        if not value < most:
            raise ConvergenceError(f"force {value:.3g}: the hardness carries less than {most:.3g}")
        return _search_depth(
            at,
            missing=lambda contact: value - contact.force,
            # a clearance of the tolerance is worth some of it in force
            allowed=lambda _: tolerance * (10 * value),
            touch=(lowest, value),
            depth=elastic.penetration,
            start=elastic.pressure,
            name="force",
        )
    if control == "penetration":
        rigid = body.periodic and not body.sinks and cap == np.inf
        if rigid and finite.all() and value >= gap.mean():
            raise ValueError(
                f"penetration {value!r} reaches the mean gap {float(gap.mean())!r}: the periodic "
                "half-space is in full contact there and the penetration does not set the force; "
                "give the force"
            )
        if lowest >= value:
            return assemble(body, gap, np.zeros(body.shape), value, 0, [0.0])
    # flat on flat: a uniform pressure, without a penetration to scale violations
    elif body.periodic and not body.sinks and not gap.any():
        pressure = np.full(body.shape, value / (gap.size * body.cell_area))
        force = float(pressure.sum() * body.cell_area)
        contact = Contact(0.0, force, pressure, 0, 0.0, body, gap, [0.0])
        return contact.with_displacement(np.zeros(body.shape))
    if lowest > 0:
        depth = value - lowest if control == "penetration" else value
        near = _descend(body, gap - lowest, control, depth, start, cap, *effort)
        return _from_first_touch(near, gap)

    # contact is looked for where gaps are below the depth, in a window; a body that is not
    # `bounded` may touch anywhere. Under a force the depth is an estimate
    bounded, reach = body.bounded, value
    if control == "force":
        reach = _REACH * overlap_depth(body, gap, value) if bounded else np.inf
    while True:
        window = np.s_[:, :]
        if bounded:
            within = gap < reach if start is None else (gap < reach) | (start > 0)
            smallest = rectangle(within)
            window = smallest if gap[smallest].size < 0.7 * gap.size else window
        inside = np.ascontiguousarray(gap[window])
        part = body if inside.shape == body.shape else body.restrict(inside.shape)
        if start is None:
            begin, _ = _starting_pressure(part, inside, control, value)
        else:
            begin = np.ascontiguousarray(start[window])
        found = descend(
            part,
            inside,
            begin,
            control,
            value,
            cap=cap,
            tolerance=tolerance,
            max_iterations=max_iterations,
        )
        pressure = found.pressure
        if part is not body:
            pressure = np.zeros(body.shape)
            pressure[window] = found.pressure
        # u >= 0 everywhere, so cells outside with a gap of at least the depth do not overlap
        if part is body or found.depth <= reach:
            contact = Contact(
                penetration=float(found.depth),
                force=float(pressure.sum() * body.cell_area),
                pressure=pressure,
                iterations=len(found.history),
                violation=float(found.violation),
                operator=body,
                initial_gap=gap,
                history=found.history,
                convolutions=(found.single, found.double),
            )
            return contact.with_displacement(found.displacement) if part is body else contact
        reach, start = 1.2 * found.depth, pressure


def rectangle(cells: Mask) -> tuple[slice, slice]:
    """Return the smallest rectangle around cells, its sides rounded up to 8 to share kernels."""
    sides = []
    for axis, size in enumerate(cells.shape):
        used = np.flatnonzero(cells.any(axis=1 - axis))
        length = min(size, -(-int(used[-1] + 1 - used[0]) // 8) * 8)
        first = min(int(used[0]), size - length)
        sides.append(slice(first, first + length))
    return sides[0], sides[1]


def _starting_pressure(
    body: ElasticBody, gap: Array, control: str, value: float
) -> tuple[Array, bool]:
    """Return a non-negative pressure near the contact, and whether it is that of full contact."""
    # every second point has fewer waves and less tension: where full contact has too much tension
    # there, it has on all points, and is not tried
    points, full = np.ascontiguousarray(gap[::2, ::2]), True
    helps = min(body.shape) >= SHORTEST_COARSENED and np.isfinite(points).any()
    if helps and control == "penetration":
        closed = body.periodic and value >= points.mean()
        helps = not closed and points.min() < value
    coarse = body.coarser() if helps else None
    if coarse is not None:
        below, full = _starting_pressure(coarse, points, control, value)

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
            reached = descend(coarse, points, below, control, value, **effort, partial=True)
            finer = np.empty(body.shape)
            _interpolate(reached.pressure, finer, body.periodic)
            return finer, False
        except ConvergenceError:
            pass
    depth = value
    if control == "force":
        least = float(gap.min())
        depth = least + _SHALLOWER * (overlap_depth(body, gap, value) - least)
    return overlap_pressure(body, gap, depth), False


def overlap_depth(body: ElasticBody, gap: Array, force: float) -> float:
    """Return the depth at which the overlap (d - g) has E* V/sqrt(A) = F, 4 % deep for Hertz."""
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


def overlap_pressure(body: ElasticBody, gap: Array, depth: float) -> Array:
    """Return a pressure proportional to the overlap, of the right order of magnitude.

    Zero where no cell overlaps, as at a depth that round-off loses:

    >>> from reference.halfspace.kernels import FreeOperator
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


def _search_depth(
    at: Callable[[float, Array | None], Contact],
    missing: Callable[[Contact], float],
    allowed: Callable[[Contact], float],
    *,
    touch: tuple[float, float],
    depth: float,
    start: Array | None,
    name: str,
) -> Contact:
    """Return the contact that misses no more than is allowed, with the history of all on the way.

    ``at(depth, start)`` is the contact at a depth; `missing` is positive for one too shallow, and
    decreases with the depth; `allowed` is what it may be. `touch` has a depth without contact, and
    what is missing there; `depth` and `start` come first.
    """
    previous, low, high = touch, touch[0], np.inf
    history: list[float] = []
    single = double = 0
    for _ in range(60):
        contact = at(depth, start)
        error = missing(contact)
        history += contact.history
        single, double = single + contact.convolutions[0], double + contact.convolutions[1]
        if abs(error) <= allowed(contact):
            return replace(
                contact, iterations=len(history), history=history, convolutions=(single, double)
            )
        low, high = (depth, high) if error > 0 else (low, depth)
        run, rise = depth - previous[0], error - previous[1]
        slow = abs(error) > abs(previous[1]) / 2 and np.isfinite(high)
        previous, start = (depth, error), contact.pressure
        depth = np.inf if slow or not run * rise < 0 else depth - error * run / rise
        if not low < depth < high:
            depth = (low + high) / 2 if np.isfinite(high) else 2 * low
    raise ConvergenceError(f"no penetration reached the prescribed {name}", history)


def _pivot(
    body: ElasticBody, gap: Array, load: Load, start: Contact | None, max_iterations: int
) -> Iterator[Contact]:
    """Pivot on the cells that the body can reach, with depths relative to first touch.

    By (19.7) for the pressures in contact, and (19.8) for the displacements outside.
    """
    lowest, force = float(gap.min()), load.control == "force"
    near, known = gap - lowest, -np.inf
    mask = None if start is None else start.mask
    loads = load.values if force else load.values - lowest
    reaches = [started_from(body, near, value) if force else value for value in loads.tolist()]
    for prescribed, value, reach in zip(load.values.tolist(), loads, reaches, strict=True):
        if value <= 0:
            yield assemble(body, gap, np.zeros(body.shape), prescribed, 0, [0.0])
            continue
        while True:
            if known < reach:
                # all loads use the cells of the largest one, and therefore the same factor
                known = max(reach, reaches[-1])
                rows, columns, gaps, unit, respond = tabulated(body, near, known)
            active = gaps < reach
            if np.count_nonzero(active) > CELL_LIMIT:  # about half of an overlap stays in contact
                active[np.argsort(gaps, kind="stable")[CELL_LIMIT:]] = False
            if mask is not None and mask[rows, columns].any():
                active = mask[rows, columns]
            settled = pivot(
                respond,
                gaps,
                active,
                value / body.cell_area * unit if force else value,
                per_depth=0.0 if force else 1.0,
                per_pressure=1.0 if force else 0.0,
                max_rounds=max_iterations,
            )
            pressure = np.zeros(body.shape)
            pressure[rows, columns] = settled.pressures / unit
            mask = pressure > 0
            if settled.depth <= known:
                break
            # the depth was only an estimate: restart with all cells below the actual one
            reach = 1.2 * settled.depth
        rounds = settled.history
        contact = assemble(body, near, pressure, settled.depth, len(rounds), rounds)
        yield _from_first_touch(contact, gap) if lowest > 0.0 else contact


def started_from(body: ElasticBody, gap: Array, force: float) -> float:
    """Return the depth whose overlap the pivoting starts from under a force, with a margin."""
    return 1.5 * overlap_depth(body, gap, force)


def _from_first_touch(contact: Contact, gap: Array) -> Contact:
    """Return the contact of a gap from that of ``gap - gap.min()``, whose depths lose no digits."""
    penetration = contact.penetration + float(gap.min())
    share = contact.penetration / penetration
    moved = replace(
        contact, penetration=penetration, violation=contact.violation * share, initial_gap=gap
    )
    known = "displacement" in vars(contact)
    return moved.with_displacement(contact.displacement) if known else moved


def assemble(
    body: ElasticBody,
    gap: ArrayLike,
    pressure: Array,
    penetration: float,
    iterations: int,
    history: Sequence[float],
) -> Contact:
    """Return the contact of a pressure, with force and violation evaluated on the whole grid."""
    gap = check_gap(body, gap)
    displacement, finite = body.apply(pressure), np.isfinite(gap)
    clearance = np.where(finite, gap, 0.0) - penetration + displacement
    contact = Contact(
        penetration=float(penetration),
        force=float(pressure.sum() * body.cell_area),
        pressure=pressure,
        iterations=iterations,
        violation=violation(clearance, pressure > 0, finite, penetration),
        operator=body,
        initial_gap=gap,
        history=list(history),
    )
    return contact.with_displacement(displacement)


def violation(clearance: Array, mask: Mask, finite: Mask, penetration: float) -> float:
    """Return the largest |clearance| in contact or overlap outside, relative to the penetration."""
    inside = np.abs(clearance[mask]).max(initial=0.0)
    overlap = -clearance[finite & ~mask].min(initial=0.0)
    worst = max(inside, overlap)
    return float(worst / penetration) if worst > 0 else 0.0


def certify(
    body: ElasticBody, gap: ArrayLike, load: Load, contact: Contact, *, cap: float = np.inf
) -> float:
    """Return the largest violation of an answer, computed anew from pressure and penetration.

    Apart from the solvers, in double precision, on all cells: overlap, gap under pressure and a
    missed mean gap, relative to the penetration; tension, pressure beyond the cap and pressure
    where contact is impossible, relative to the mean in contact; a missed force or penetration,
    relative to it.

    A pressure one per cent too large raises the clearance in contact by as much of the penetration:

    >>> from reference.halfspace import FreeOperator
    >>> K, gap = FreeOperator((2, 2), (1.0, 1.0), 1.0), np.zeros((2, 2))
    >>> load = Load("penetration", 1)
    >>> contact = press(K, gap, load)
    >>> certify(K, gap, load, contact) < 1e-8
    True
    >>> round(certify(K, gap, load, replace(contact, pressure=1.01 * contact.pressure)), 6)
    0.01
    """
    gap, p, depth = check_gap(body, gap), contact.pressure, contact.penetration
    finite, loaded = np.isfinite(gap), p > 0
    clearance = np.where(finite, gap, 0.0) - depth + body.apply(p)
    mean_gap = float(clearance[finite].mean())
    # cells at the cap may overlap
    clearance = np.where((p >= cap) & (clearance < 0), 0.0, clearance)
    # a flat on a flat period has no penetration
    scale = depth if depth > 0 else float(p.max()) * max(body.spacing) / body.effective_modulus
    worst = [violation(clearance, loaded & finite, finite, scale)]
    mean = float(p[loaded].mean()) if loaded.any() else 1.0
    worst += [float(v / mean) for v in (-p.min(), p.max() - cap, np.abs(p[~finite]).max(initial=0))]
    value, force = load.single(), float(p.sum() * body.cell_area)
    reached = {"penetration": depth, "force": force}
    if load.control in reached:
        worst.append(abs(reached[load.control] / value - 1))
    else:
        worst.append(abs(mean_gap - value) / scale)
    return max(worst)


def effort_faults(tolerance: float, max_iterations: int) -> list[str]:
    """Return messages for a tolerance out of range, and for fewer than one iteration."""
    faults = []
    if not 0 < tolerance < 1:
        faults.append(f"tolerance must lie between 0 and 1, not {tolerance!r}")
    if max_iterations < 1:
        faults.append(f"max_iterations must be at least 1, not {max_iterations!r}")
    return faults


def check_gap(body: ElasticBody, gap: ArrayLike) -> Array:
    """Return the gap as a double array, or raise ValueError with all errors."""
    gap = np.asarray(gap, dtype=float)
    faults = []
    if gap.shape != body.shape:
        faults.append(f"gap has shape {gap.shape}, the operator {body.shape}")
    if np.isnan(gap).any():
        faults.append(f"gap has {int(np.isnan(gap).sum())} undefined (NaN) points")
    if (gap < 0).any():
        faults.append(f"gap must not be negative, its minimum is {np.nanmin(gap)!r}")
    if not np.isfinite(gap).any():
        faults.append("gap is infinite everywhere: nothing can touch")
    refuse(faults)
    return gap
