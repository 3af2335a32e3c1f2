"""Contact on the half-space by FFT and projected conjugate gradients, for large grids.

The solver has stages that pass on a pressure: an initial pressure (overlap, or extrapolation of
previous loads), a window that contains the contact, conjugate gradients, and a final evaluation on
the whole grid. The inputs are operator, gap and load, the output is a `Contact`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from reference.errors import ConvergenceError
from reference.halfspace.conjugate_gradients import Problem, State, minimise
from reference.halfspace.operators import FreeOperator, HalfSpace
from reference.halfspace.overlap import overlap_depth
from reference.halfspace.solution import (
    Contact,
    Effort,
    Press,
    assemble,
    contact_of,
    from_first_touch,
)
from reference.halfspace.starts import starting_pressure
from reference.loads import Load

Field = NDArray[np.float64]

CONTROLS = ("penetration", "force", "mean_gap")

# The depth is estimated from the geometric overlap: the actual one is 0.96 of it for Hertz, 0.64 to
# 0.93 for rough surfaces, 1.12 for a single cell. If it is exceeded, the window grows and the load
# is solved again.
_REACH = 1.15


def solve(
    press: Press,
    load: Load,
    *,
    tolerance: float = 1e-8,
    start: Contact | None = None,
    max_iterations: int = 2000,
) -> Contact:
    """Return the frictionless contact of a rigid shape on a half-space at one load.

    Finds p >= 0 with u = K p = d - g where p > 0 and u >= d - g elsewhere. On the periodic
    half-space the mean displacement is zero, so that mean_gap = <g> - d for finite gaps.

    Parameters
    ----------
    press : Press
        The shape over the half-space.
    load : Load
        Penetration, force or mean gap (over the finite cells), one value, consistent units.
    tolerance : float
        Largest overlap of free cells and largest gap of loaded cells, relative to the penetration.
        Tension does not occur.
    start : Contact, optional
        A solution at a nearby load to start from.
    max_iterations : int
        Limit for all stages together.

    Returns
    -------
    Contact

    Raises
    ------
    ValueError
        If arguments are invalid; lists all of them.
    ConvergenceError
        With the history of violations, if the tolerance is not reached.

    Examples
    --------
    Hertz, F = 4/3 E* sqrt(R) d^1.5, with R = 1 and d = 0.01:

    >>> import numpy as np
    >>> x = (np.arange(64) - 31.3) / 240
    >>> K = FreeOperator((64, 64), (1 / 240, 1 / 240), 1.0)
    >>> ball = Press(K, (x[:, None] ** 2 + x**2) / 2)
    >>> contact = solve(ball, Load("penetration", 0.01))
    >>> round(contact.force / (4 / 3 * 0.01**1.5), 2)
    1.0
    """
    kind, value = load.one_of(*CONTROLS), load.single()
    effort = Effort(tolerance, max_iterations)
    pressure = None if start is None else _checked_start(start, press.operator)
    return _solve(press, kind, value, pressure, effort)


def sweep(
    press: Press, load: Load, *, tolerance: float = 1e-8, max_iterations: int = 2000
) -> Iterator[Contact]:
    """Solve a strictly increasing list of loads, with warm starts.

    Arguments as for `solve`, which are checked at the call, not at the first `next`. The start is
    the last pressure, extrapolated linearly in the load from the last two.

    Yields
    ------
    Contact
        One per load.

    Raises
    ------
    ConvergenceError
        On iteration, if a load fails; a new sweep may begin at the next load.
    """
    load.one_of(*CONTROLS)
    return _sweep(press, load, Effort(tolerance, max_iterations))


def _sweep(press: Press, load: Load, effort: Effort) -> Iterator[Contact]:
    earlier: Field | None = None
    last: Field | None = None
    for step, value in enumerate(load.values):
        start = None if last is None else _extrapolated(earlier, last, load.values[: step + 1])
        earlier = last  # the one before is not needed during the solve
        contact = _solve(press, load.control, float(value), start, effort)
        last = contact.pressure
        yield contact
        contact.forget_displacement()  # whoever has the contact: the next load needs the memory
        del contact, start


def _extrapolated(earlier: Field | None, last: Field, loads: NDArray[np.float64]) -> Field:
    """Return the pressure at the last load, linear in the load: a new array."""
    if earlier is None:
        return last.copy()
    guess = last - earlier
    guess *= (loads[-1] - loads[-2]) / (loads[-2] - loads[-3])
    guess += last
    return np.maximum(guess, 0.0, out=guess) if (guess > 0).any() else last.copy()


def _checked_start(start: Contact, operator: HalfSpace) -> Field:
    if start.pressure.shape != operator.shape:
        raise ValueError(f"start has shape {start.pressure.shape}, the operator {operator.shape}")
    return start.pressure.astype(np.float64)


# overflows are detected in the result and reported
@np.errstate(over="ignore", invalid="ignore")
def _solve(press: Press, kind: str, value: float, start: Field | None, effort: Effort) -> Contact:
    """Solve one load; the start is overwritten."""
    operator, gap = press.operator, press.gap
    if kind == "mean_gap":
        return _solve_mean_gap(press, value, start, effort)
    if kind == "force" and press.hardness < np.inf:
        return _solve_yielding(press, value, start, effort)
    if kind == "penetration":
        _refuse_closed_gap(press, value)
        if gap.min() >= value:
            return assemble(press, np.zeros(operator.shape), value, 0, [0.0])
    elif operator.periodic and not operator.sinks and not gap.any():
        return _flat_on_flat(press, value)
    if press.lowest > 0:
        depth = value - press.lowest if kind == "penetration" else value
        return from_first_touch(_solve(press.touching(), kind, depth, start, effort), gap)
    reach = _reach(operator, gap, kind, value)
    while True:
        window = _window(operator, gap, reach, start)
        part = _restricted(operator, window)
        inside = np.ascontiguousarray(gap[window])
        problem = Problem.of(part, inside, kind, value, press.hardness)
        state = minimise(problem, _first(problem, start, window, kind, value), effort)
        # u >= 0 everywhere, so cells outside with a gap of at least the depth do not overlap
        if part is operator or state.depth <= reach:
            return _answer(press, window, state)
        # under force control the depth was only an estimate
        reach, start = 1.2 * state.depth, _embedded(operator, window, state.pressure)


def _reach(operator: HalfSpace, gap: Field, kind: str, value: float) -> float:
    """Return the gap up to which contact is looked for; on a periodic half-space anywhere."""
    if kind == "penetration" or not _bounded(operator):
        return value if kind == "penetration" else np.inf
    return _REACH * overlap_depth(operator, gap, value)


def _first(
    problem: Problem, start: Field | None, window: tuple[slice, slice], kind: str, value: float
) -> Field:
    """Return a pressure to start from, which may be overwritten."""
    if start is None:
        return starting_pressure(problem.operator, problem.gap, kind, value)
    return np.ascontiguousarray(start[window])


def _answer(press: Press, window: tuple[slice, slice], state: State) -> Contact:
    complete = state.pressure.shape == press.operator.shape
    pressure = state.pressure if complete else _embedded(press.operator, window, state.pressure)
    contact = contact_of(
        press, pressure, state.depth, state.violation, len(state.history), state.history
    )
    contact = replace(contact, convolutions=(state.single, state.double))
    if complete:
        vars(contact)["displacement"] = state.displacement
    return contact


def _embedded(operator: HalfSpace, window: tuple[slice, slice], inside: Field) -> Field:
    """Return the pressures of a window on the whole grid."""
    pressure = np.zeros(operator.shape)
    pressure[window] = inside
    return pressure


def _flat_on_flat(press: Press, force: float) -> Contact:
    """Return the uniform pressure of a periodic flat, without a penetration to scale violations."""
    operator = press.operator
    pressure = np.full(operator.shape, force / (press.gap.size * operator.cell_area))
    contact = contact_of(press, pressure, 0.0, 0.0, 0, [0.0])
    vars(contact)["displacement"] = np.zeros(operator.shape)
    return contact


def _refuse_closed_gap(press: Press, depth: float) -> None:
    gap = press.gap
    operator = press.operator
    rigid = operator.periodic and not operator.sinks and press.hardness == np.inf
    if rigid and np.isfinite(gap).all() and depth >= gap.mean():
        raise ValueError(
            f"penetration {depth!r} reaches the mean gap {float(gap.mean())!r}: the periodic "
            "half-space is in full contact there and the penetration does not set the force; "
            "give the force"
        )


def _window(
    operator: HalfSpace, gap: Field, reach: float, start: Field | None
) -> tuple[slice, slice]:
    """Return the smallest useful rectangle of cells with gap < reach, or the whole grid."""
    grid = (slice(0, operator.shape[0]), slice(0, operator.shape[1]))
    if not _bounded(operator):
        return grid
    near = gap < reach
    if start is not None:
        near |= start > 0
    rows, columns = (
        _padded_range(np.flatnonzero(near.any(axis=1 - axis)), operator.shape[axis])
        for axis in (0, 1)
    )
    cells = (rows.stop - rows.start) * (columns.stop - columns.start)
    return (rows, columns) if cells < 0.7 * gap.size else grid


def _bounded(operator: HalfSpace) -> bool:
    """Whether cells with g >= d are never in contact, as on the free half-space, where u >= 0.

    A periodic half-space has no such bound, nor have finite elements below long cells.
    """
    return isinstance(operator, FreeOperator) and not operator.lifts


def _padded_range(indices: NDArray[np.intp], size: int) -> slice:
    """Return the range of indices, with a length rounded up to 8 to share kernels."""
    length = min(size, -(-(indices[-1] + 1 - indices[0]) // 8) * 8)
    first = min(int(indices[0]), size - length)
    return slice(first, first + length)


def _restricted(operator: HalfSpace, window: tuple[slice, slice]) -> HalfSpace:
    rows, columns = window
    shape = rows.stop - rows.start, columns.stop - columns.start
    if shape == operator.shape or not isinstance(operator, FreeOperator):
        return operator
    return operator.restrict(shape)


def _solve_mean_gap(press: Press, mean_gap: float, start: Field | None, effort: Effort) -> Contact:
    """Solve at d = <g> - mean gap if <u> = 0, else by a search over d."""
    gap = press.gap
    finite = np.isfinite(gap)
    widest = float(gap[finite].mean())
    if mean_gap >= widest:
        raise ValueError(
            f"mean_gap {mean_gap!r} is not below the mean gap at first touch, {widest!r}"
        )

    def at(depth: float, pressure: Field | None) -> Contact:
        return _solve(press, "penetration", depth, pressure, effort)

    if press.operator.periodic and not press.operator.sinks and finite.all():
        return at(widest - mean_gap, start)
    # met to the tolerance times the penetration, like every clearance
    goal = _Goal("mean gap", lambda c: c.mean_gap - mean_gap, lambda c: c.penetration)
    touch = (0.0, widest - mean_gap)
    return _search_depth(at, goal, effort.tolerance, touch, widest - mean_gap, start)


def _solve_yielding(press: Press, force: float, start: Field | None, effort: Effort) -> Contact:
    """Solve a force below a hardness: elastically if that is enough, else by a search over d."""
    elastic = _solve(Press(press.operator, press.gap), "force", force, start, effort)
    if elastic.pressure.max() <= press.hardness:
        return elastic
    most = press.hardness * np.count_nonzero(np.isfinite(press.gap)) * press.operator.cell_area
    if not force < most:
        raise ConvergenceError(f"force {force:.3g}: the hardness carries less than {most:.3g}")

    def at(depth: float, pressure: Field | None) -> Contact:
        return _solve(press, "penetration", depth, pressure, effort)

    # a clearance of the tolerance is worth some of it in force
    goal = _Goal("force", lambda contact: force - contact.force, lambda _: 10 * force)
    first = press.lowest, force
    return _search_depth(at, goal, effort.tolerance, first, elastic.penetration, elastic.pressure)


class _Goal(NamedTuple):
    """What is prescribed in place of a penetration.

    Attributes
    ----------
    name : str
    missing : callable
        What a contact lacks of it: decreases with the penetration, negative if pressed too deep.
    scale : callable
        What it is met to a tolerance of.
    """

    name: str
    missing: Callable[[Contact], float]
    scale: Callable[[Contact], float]


def _search_depth(
    at: Callable[[float, Field | None], Contact],
    goal: _Goal,
    tolerance: float,
    touch: tuple[float, float],
    depth: float,
    start: Field | None,
) -> Contact:
    """Search d by bracketed secant steps, from what is missing at first touch and at a depth."""
    previous, low, high = touch, touch[0], np.inf
    history: list[float] = []
    for _ in range(60):
        contact = at(depth, start)
        error = goal.missing(contact)
        history += contact.history
        if abs(error) <= tolerance * goal.scale(contact):
            return replace(contact, iterations=len(history), history=history)
        low, high = (depth, high) if error > 0 else (low, depth)
        run, rise = depth - previous[0], error - previous[1]
        slow = abs(error) > abs(previous[1]) / 2 and np.isfinite(high)
        previous, start = (depth, error), contact.pressure
        depth = np.inf if slow or not run * rise < 0 else depth - error * run / rise
        if not low < depth < high:
            depth = (low + high) / 2 if np.isfinite(high) else 2 * low
    raise ConvergenceError(f"no penetration reached the prescribed {goal.name}", history)
