"""Contact pressures by projected conjugate gradients, refined to a double-precision residual.

minimise  1/2 p.K p - p.(d - g)  over p >= 0,

with given d, or with given sum of p, in which case d is the multiplier of that constraint. Where a
body yields, with given d, over 0 <= p <= cap. The
contact set changes in every iteration, as in I. A. Polonsky and L. M. Keer, Wear 231 (1999) 206,
and V. Rey, G. Anciaux and J.-F. Molinari, Comput. Mech. 60 (2017) 69. `descent` iterates on a
correction of the pressure; here the residual of the sum is recomputed in double precision until it
meets the tolerance. The stages, each followed by the next if it fails:

1. single precision, preconditioned by |q|;
2. double precision, preconditioned;
3. double precision, plain: slow, but with proved convergence.

All quantities enter homogeneously: no absolute tolerance, and a change of units by powers of two
changes no digit.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import DTypeLike, NDArray
from scipy import fft

from reference.errors import ConvergenceError
from reference.halfspace import descent, kernels, pieces
from reference.halfspace.convolution import Convolution
from reference.halfspace.operators import HalfSpace, power_of_two
from reference.halfspace.solution import Effort

Field = NDArray[np.float64]

# Digits gained by a single-precision stage before the residual is recomputed in double precision.
_SINGLE_GAIN = 3e-5
# Margin of the goal of a stage relative to the tolerance, as the recomputed residual differs
# slightly.
_MARGIN = 0.7

# Error of a displacement by FFT in units of round-off, with a margin; and the violation below which
# it is considered.
_ROUNDING, _ROUNDING_NEAR = 16.0, 1e-6

# Fewest empty cells that separate opposite rims of a free patch in the preconditioner, else a
# quarter of its side: the residual is continued across them from rim to rim. From 256 to 1024 cells
# a side (contact 4 and 20 %) it takes a fifth less convolutions than 8 cells do.
_RIM = 8


@dataclass
class Problem:
    """Gap (infinite where contact is impossible), and one load: a depth, or a total of pressures.

    If not `unilateral`, cells of finite gap stay in contact for any sign of their pressure. Cells
    whose pressure is the `cap` may overlap; it takes a depth.
    """

    operator: HalfSpace
    gap: Field
    depth: float | None = None
    total: float | None = None
    unilateral: bool = True
    cap: float = np.inf

    @classmethod
    def of(
        cls, operator: HalfSpace, gap: Field, kind: str, value: float, cap: float = np.inf
    ) -> Problem:
        """Return the problem of a gap under a depth or a force."""
        gap = np.ascontiguousarray(gap)
        if kind == "penetration":
            return cls(operator, gap, depth=value, cap=cap)
        return cls(operator, gap, total=value / operator.cell_area)


@dataclass
class State:
    """Pressure, its displacement, the depth, the largest violation, whether it is small enough.

    The displacement is dropped while a stage iterates, which needs its memory. `single` and
    `double` count the convolutions so far, in either precision.
    """

    pressure: Field
    displacement: Field
    depth: float
    worst: float = np.inf
    converged: bool = False
    single: int = 0
    double: int = 0
    history: list[float] = field(default_factory=list)

    @property
    def violation(self) -> float:
        """Largest violation relative to the depth."""
        return self.worst / self.depth if self.depth > 0 else np.inf


@dataclass(frozen=True)
class _Stage:
    """One iteration stage, ended when the violation has not halved in `patience` iterations.

    A working stage gains a digit in at most five iterations.
    """

    dtype: DTypeLike
    plain: bool
    patience: int


_STAGES = (
    _Stage(np.float32, plain=False, patience=20),
    _Stage(np.float64, plain=False, patience=60),
    _Stage(np.float64, plain=True, patience=2**62),
)


def minimise(problem: Problem, start: Field, effort: Effort) -> State:
    """Solve the contact problem from a starting pressure, which is overwritten.

    Raises
    ------
    ConvergenceError
        With the violations of all iterations, if no stage reaches the tolerance.
    """
    state = approach(problem, start, effort)
    if not state.converged:
        raise ConvergenceError(
            f"contact iteration stopped at a violation of {state.violation:.1e} of the penetration "
            f"after {len(state.history)} iterations (tolerance {effort.tolerance:.1e})",
            state.history,
        )
    return state


def approach(problem: Problem, start: Field, effort: Effort) -> State:
    """Return where all stages get from a starting pressure, which is overwritten.

    Raises
    ------
    ConvergenceError
        If the range of numbers is exceeded.
    """
    tolerance, max_iterations = effort.tolerance, effort.max_iterations
    _over(_admit, start, problem.gap, problem.unilateral, problem.cap)
    state = State(start, _NOTHING, problem.depth or 0.0)
    _refresh(problem, state, tolerance)
    for stage in _STAGES:
        while not state.converged and len(state.history) < max_iterations:
            before = state.worst
            outcome = _improve(problem, state, stage, effort)
            _refresh(problem, state, tolerance)
            if outcome == descent.STALLED or not state.worst < before / 4:
                break
    return state


def fixed_contact_response(
    operator: HalfSpace, mask: NDArray[np.bool_], tolerance: float, max_iterations: int = 2000
) -> State:
    """Return the pressure (of either sign) on `mask` that displaces its cells by one."""
    problem = Problem(operator, np.where(mask, 0.0, np.inf), depth=1.0, unilateral=False)
    return minimise(problem, np.zeros(operator.shape), Effort(tolerance, max_iterations))


def _refresh(problem: Problem, state: State, tolerance: float) -> None:
    """Evaluate displacement, depth and violation in double precision."""
    if problem.total is not None:
        # a step conserves the total up to rounding
        state.pressure *= problem.total / state.pressure.sum()
    operator = problem.operator
    if state.pressure.any():
        displacement = operator.convolution(np.float64)(state.pressure)
        state.displacement = np.asarray(displacement, dtype=np.float64)
        state.double += 1
    else:
        state.displacement = np.zeros(operator.shape)
    maps = state.displacement, state.pressure, problem.gap
    loaded = _over(_displace, *maps, operator.unit)
    if problem.depth is None:
        total, count = (sum(part[k] for part in loaded) for k in (0, 1))
        state.depth = total / count if count else np.nan
    state.worst = max(_over(_violation, *maps, problem.unilateral, state.depth, problem.cap))
    if not np.isfinite([state.worst, state.depth]).all():
        raise ConvergenceError("the contact iteration exceeded the range of numbers", state.history)
    state.converged = state.violation <= max(tolerance, _rounding(problem, state))


def _rounding(problem: Problem, state: State) -> float:
    """Return the violation possible from rounding of the displacement; 0 if far from it.

    Pressures much above that of full contact displace a nearly flat surface by much more than its
    heights, and rounding of this displacement is a visible part of the penetration.
    """
    if state.violation > _ROUNDING_NEAR:
        return 0.0
    operator = problem.operator
    displacement = state.pressure.max() * max(operator.spacing) / operator.effective_modulus
    return float(_ROUNDING * np.finfo(float).eps * displacement / state.depth)


def _improve(problem: Problem, state: State, stage: _Stage, effort: Effort) -> int:
    """Run one stage on the correction of the pressure, in units near its size."""
    operator = problem.operator
    length = power_of_two(state.worst)
    pressure_unit = length / operator.unit
    clearance, lower = (np.empty(operator.shape, stage.dtype) for _ in range(2))
    maps = clearance, lower, state.displacement, state.pressure, problem.gap
    _over(_prepare, *maps, (problem.unilateral, state.depth, length, pressure_unit))
    del maps
    state.displacement = _NOTHING
    cap = float(np.asarray(problem.cap / pressure_unit, stage.dtype))
    iteration = descent.Descent(
        *(clearance.reshape(-1), lower.reshape(-1), operator.convolution(stage.dtype)),
        None if stage.plain else _preconditioner(operator, stage.dtype),
        problem.total is not None,
        _settling(operator) if operator.periodic and problem.total is None else 0.0,
        cap,
    )
    outcome = iteration.run(
        _goal(state, stage, effort.tolerance) / length,
        state.depth / length,
        stage.patience,
        effort.max_iterations - len(state.history),
    )
    if stage.dtype == np.float32:
        state.single += iteration.convolutions
    else:
        state.double += iteration.convolutions
    state.history += iteration.history
    bounds = problem.unilateral, pressure_unit, problem.cap, lower.dtype.type(cap)
    _over(_accept, state.pressure, iteration.correction, lower, bounds)
    return outcome


def _goal(state: State, stage: _Stage, tolerance: float) -> float:
    """Return the goal of a stage: the tolerance, approached in equal steps in single precision."""
    if not state.depth > 0:
        return _SINGLE_GAIN * state.worst
    goal = _MARGIN * tolerance * state.depth
    if stage.dtype == np.float32 and goal < state.worst:
        steps = np.ceil(np.log(goal / state.worst) / np.log(_SINGLE_GAIN))
        return float(state.worst * (goal / state.worst) ** (1 / steps))
    return float(goal)


def _preconditioner(operator: HalfSpace, dtype: DTypeLike) -> Convolution:
    """Return |q| in Fourier space, the inverse of the half-space under a periodic pressure.

    Of other bodies it is the inverse of their compliance, in the same units.

    The zero mode is half the smallest wavenumber, so that the operator is positive definite. On a
    periodic half-space with free mean pressure it is set from the contact (`_settling`): near full
    contact a uniform pressure on the contact has almost no energy, and without a matching large
    zero mode the iterations increase from 25 to many hundreds.
    """

    def make() -> Convolution:
        padded = operator.shape
        if not operator.periodic:
            rows, columns = (
                fft.next_fast_len(n + max(_RIM, n // 4), real=True) for n in operator.shape
            )
            padded = rows, columns
        stiffness = operator.wave_stiffness(kernels.quarter(padded, operator.spacing))
        stiffness *= _wave_unit(operator)
        return Convolution(padded, padded, stiffness, dtype)

    inverse = operator.cached(("preconditioner", np.dtype(dtype).name), make)
    lowest = 2 * np.pi / max(n * s for n, s in zip(inverse.padded, operator.spacing, strict=True))
    longest = float(operator.wave_stiffness(np.array([lowest]))[0])
    inverse.set_mean_factor(longest / 2 * _wave_unit(operator))
    return inverse


def _wave_unit(operator: HalfSpace) -> float:
    """Return the power of two that scales |q| to about one."""
    return power_of_two(max(operator.spacing))


def _settling(operator: HalfSpace) -> float:
    """Return the factor from the stiffness of a uniform pressure on the contact to the mean factor.

    |q| lacks E*/2; a further 2 because pressure concentrates at the rims of the open cells.
    """
    stiffness = operator.unit * operator.effective_modulus
    return 4 * _wave_unit(operator) / stiffness


_NOTHING: Field = np.empty((0, 0))


def _over(work: Callable[..., Any], *arguments: Any) -> list[Any]:
    """Return what a compiled loop makes of every piece of the maps among its arguments."""
    flat = [a.reshape(-1) if isinstance(a, np.ndarray) else a for a in arguments]
    maps = sum(isinstance(a, np.ndarray) for a in arguments)

    if flat[0].size <= pieces.SIZE:
        return [work(*flat)]

    def piece(part: slice) -> Any:
        return work(*(values[part] for values in flat[:maps]), *flat[maps:])

    return pieces.over(flat[0].size, pieces.SIZE, piece)


@njit(cache=True, nogil=True, error_model="numpy")
def _admit(pressure, gap, unilateral, cap):
    """Take away pressure where contact is impossible, tension, and what is above the cap."""
    for k in range(gap.size):
        pressure[k] = min(pressure[k], cap)
        if gap[k] == np.inf or (unilateral and pressure[k] < 0):
            pressure[k] = 0.0


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
def _prepare(clearance, lower, displacement, pressure, gap, state):
    """Fill clearance and bound of the correction; ratios out of range count as infinite.

    `state` contains whether contact is unilateral, the depth, and units of length and pressure.
    """
    unilateral, depth, length, unit = state
    for k in range(gap.size):
        clearance[k] = descent.NEVER
        lower[k] = 0
        if gap[k] < np.inf:
            clearance[k] = min((displacement[k] + gap[k] - depth) / length, descent.NEVER)
            bound = -pressure[k] / unit if unilateral else -descent.NEVER
            lower[k] = max(bound, -descent.NEVER)


@njit(cache=True, nogil=True, error_model="numpy")
def _accept(pressure, correction, lower, bounds):
    """Add the correction; cells on a bound have no pressure, or that of the cap.

    `bounds` contains whether contact is unilateral, the unit of the correction, the cap, and that
    of the correction in its unit.
    """
    unilateral, unit, cap, room = bounds
    for k in range(pressure.size):
        value = pressure[k] + np.float64(correction[k]) * unit
        if unilateral and (value < 0 or not correction[k] > lower[k]):
            value = 0.0
        elif value > cap or not correction[k] < lower[k] + room:
            value = cap
        pressure[k] = value
