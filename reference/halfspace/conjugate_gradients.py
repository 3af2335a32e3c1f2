"""Contact pressures by projected conjugate gradients, refined until a double residual agrees.

minimise  1/2 p.K p - p.(d - g)  over p >= 0,

with d given, or with the sum of p given, in which case d is the multiplier of that constraint. The
contact set changes in every iteration, as in I. A. Polonsky and L. M. Keer, Wear 231 (1999) 206,
and V. Rey, G. Anciaux and J.-F. Molinari, Comput. Mech. 60 (2017) 69. `descent` iterates on a
correction of the pressure; here the residual of the sum is taken anew, in double precision, until
it meets the tolerance. The stages, each taken over from by the next where it fails:

1. single precision, preconditioned by |q|;
2. double precision, preconditioned;
3. double precision, plain: slow, but with a proof of convergence behind it.

All quantities enter homogeneously: no absolute tolerance, and a change of units by powers of two
changes no digit.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numba import njit
from numpy.typing import DTypeLike, NDArray
from scipy import fft

from reference.errors import ConvergenceError
from reference.halfspace import descent, kernels
from reference.halfspace.convolution import Convolution
from reference.halfspace.operators import HalfSpace, power_of_two
from reference.halfspace.solution import Effort

Field = NDArray[np.float64]

# Digits gained by one stage of single precision before the residual is taken in double again.
_SINGLE_GAIN = 3e-5
# Margin of the goal of a stage against the tolerance: the fresh residual differs a little.
_MARGIN = 0.7

# Units of round-off that a displacement by FFT is wrong by, with a margin; and the violation below
# which it is worth while to ask.
_ROUNDING, _ROUNDING_NEAR = 16.0, 1e-6

# Empty cells that keep opposite rims of a free patch apart in the preconditioner. |q| reaches only
# as r^-3, so that a few are as good as doubling the grid; none cost half as many iterations again.
_RIM = 8


@dataclass
class Problem:
    """Gap with the cells that may touch, and the one load: a depth, or a total of the pressures.

    Where not `unilateral`, the allowed cells stay in contact whatever the sign of their pressure.
    """

    operator: HalfSpace
    gap: Field  # finite everywhere; where `allowed` is False its value is not used
    allowed: NDArray[np.bool_]
    depth: float | None = None
    total: float | None = None
    unilateral: bool = True

    @classmethod
    def of(cls, operator: HalfSpace, gap: Field, kind: str, value: float) -> Problem:
        """Problem of a gap, infinite where nothing can touch, under a penetration or a force."""
        gap = np.ascontiguousarray(gap)
        allowed = np.isfinite(gap)
        finite = np.where(allowed, gap, 0.0)
        if kind == "penetration":
            return cls(operator, finite, allowed, depth=value)
        return cls(operator, finite, allowed, total=value / operator.cell_area)


@dataclass
class State:
    """Pressure, its displacement and clearance, the depth and the largest violation.

    `single` and `double` count the convolutions so far, in either precision.
    """

    pressure: Field
    displacement: Field
    clearance: Field
    depth: float
    worst: float = np.inf
    single: int = 0
    double: int = 0
    history: list[float] = field(default_factory=list)

    @property
    def violation(self) -> float:
        """Largest violation relative to the depth."""
        return self.worst / self.depth if self.depth > 0 else np.inf


@dataclass(frozen=True)
class _Stage:
    """One way to iterate, given up when the violation has not halved in `patience` iterations.

    Where a stage works it gains a digit in five iterations or fewer.
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
    """Solve the contact problem from a starting pressure.

    Raises
    ------
    ConvergenceError
        With the violation of every iteration, when no stage reaches the tolerance.
    """
    tolerance, max_iterations = effort.tolerance, effort.max_iterations
    pressure: Field = np.where(problem.allowed, start, 0.0).astype(np.float64, copy=False)
    if problem.unilateral:
        np.maximum(pressure, 0.0, out=pressure)
    state = State(pressure, np.empty_like(pressure), np.empty_like(pressure), problem.depth or 0.0)
    if _refresh(problem, state, tolerance):
        return state
    for stage in _STAGES:
        while len(state.history) < max_iterations:
            before = state.worst
            outcome = _improve(problem, state, stage, effort)
            if _refresh(problem, state, tolerance):
                return state
            if outcome == descent.STALLED or not state.worst < before / 4:
                break
    raise ConvergenceError(
        f"contact iteration stopped at a violation of {state.violation:.1e} of the penetration "
        f"after {len(state.history)} iterations (tolerance {tolerance:.1e})",
        state.history,
    )


def fixed_contact_response(
    operator: HalfSpace, mask: NDArray[np.bool_], tolerance: float, max_iterations: int = 2000
) -> Field:
    """Pressure (of either sign) that displaces the cells of `mask` by one and loads no others."""
    nothing = np.zeros(operator.shape)
    problem = Problem(operator, nothing, mask, depth=1.0, unilateral=False)
    return minimise(problem, nothing, Effort(tolerance, max_iterations)).pressure


def _refresh(problem: Problem, state: State, tolerance: float) -> bool:
    """Evaluate displacement, depth and clearance in double precision; True when good enough."""
    if problem.total is not None:
        # a step keeps the total but for rounding
        state.pressure *= problem.total / state.pressure.sum()
    operator = problem.operator
    displacement = operator.convolution(np.float64)(state.pressure)
    state.displacement = np.asarray(displacement, dtype=np.float64)
    state.double += 1
    state.worst, state.depth = _clearances(
        (state.pressure, state.displacement, state.clearance),
        (problem.gap, problem.allowed, problem.unilateral),
        operator.unit,
        np.nan if problem.depth is None else problem.depth,
    )
    if not np.isfinite([state.worst, state.depth]).all():
        raise ConvergenceError("the contact iteration left the range of numbers", state.history)
    return state.violation <= max(tolerance, _rounding(problem, state))


def _rounding(problem: Problem, state: State) -> float:
    """Violation that the rounding of the displacement alone may cause; 0 where it is far away.

    A pressure many times that of full contact displaces a nearly flat surface by much more than its
    own heights, and the last digits of that are a visible part of the penetration.
    """
    if state.violation > _ROUNDING_NEAR:
        return 0.0
    operator = problem.operator
    displacement = state.pressure.max() * max(operator.spacing) / operator.effective_modulus
    return float(_ROUNDING * np.finfo(float).eps * displacement / state.depth)


def _improve(problem: Problem, state: State, stage: _Stage, effort: Effort) -> int:
    """Run one stage on the correction of the pressure, in units near its own size."""
    operator = problem.operator
    length = power_of_two(state.worst)
    pressure_unit = length / operator.unit
    target, lower = (np.empty(operator.shape, stage.dtype) for _ in range(2))
    _prepare(
        (state.clearance, state.pressure),
        (problem.allowed, problem.unilateral),
        (length, pressure_unit),
        (target, lower),
    )
    iteration = descent.Descent(
        *(target, lower, operator.convolution(stage.dtype)),
        None if stage.plain else _preconditioner(operator, stage.dtype),
        problem.total is not None,
        _settling(operator) if operator.periodic and problem.total is None else 0.0,
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
    _accept(state.pressure, iteration.correction, lower, problem.unilateral, pressure_unit)
    return outcome


def _goal(state: State, stage: _Stage, tolerance: float) -> float:
    """Clearance that a stage should reach: the tolerance, in equal steps in single precision."""
    if not state.depth > 0:
        return _SINGLE_GAIN * state.worst
    goal = _MARGIN * tolerance * state.depth
    if stage.dtype == np.float32 and goal < state.worst:
        steps = np.ceil(np.log(goal / state.worst) / np.log(_SINGLE_GAIN))
        return float(state.worst * (goal / state.worst) ** (1 / steps))
    return float(goal)


def _preconditioner(operator: HalfSpace, dtype: DTypeLike) -> Convolution:
    """|q| in Fourier space: the inverse of the half-space under a periodic pressure.

    The zero mode is half the smallest wavenumber, so that the whole is positive definite. It has to
    be set from the contact (`_settling`) where the mean pressure is free on a periodic one: near
    full contact a uniform pressure on the contact costs almost no energy, and without the matching
    large zero mode the iterations grow from 25 to many hundreds.
    """

    def make() -> Convolution:
        padded = operator.shape
        if not operator.periodic:
            rows, columns = (fft.next_fast_len(n + _RIM, real=True) for n in operator.shape)
            padded = rows, columns
        wavenumber = np.hypot(*kernels.wavenumbers(padded, operator.spacing))
        return Convolution(operator.shape, padded, wavenumber * _wave_unit(operator), dtype)

    inverse = operator.cached(("preconditioner", np.dtype(dtype).name), make)
    lowest = 2 * np.pi / max(n * s for n, s in zip(inverse.padded, operator.spacing, strict=True))
    inverse.set_mean_factor(lowest / 2 * _wave_unit(operator))
    return inverse


def _wave_unit(operator: HalfSpace) -> float:
    """Power of two that brings |q| near one."""
    return power_of_two(max(operator.spacing))


def _settling(operator: HalfSpace) -> float:
    """Factor from the stiffness of a uniform pressure on the contact to the mean factor.

    |q| leaves out E*/2; a further 2 because pressure crowds at the rims of the open cells.
    """
    stiffness = operator.unit * operator.effective_modulus
    return 4 * _wave_unit(operator) / stiffness


@njit(cache=True, error_model="numpy")
def _clearances(state, problem, unit, wanted_depth):
    """Scale the displacement, fill the clearance; (largest violation, depth).

    `state` are pressure, displacement and clearance, `problem` gap, allowed and unilateral.
    The depth is the mean of displacement + gap over the loaded cells where it is not given (NaN).
    """
    (pressure, displacement, clearance), (gap, allowed, unilateral) = state, problem
    depth = wanted_depth
    total, count = 0.0, 0
    for i in range(gap.shape[0]):
        for j in range(gap.shape[1]):
            displacement[i, j] *= unit
            clearance[i, j] = displacement[i, j] + gap[i, j]
            if pressure[i, j] > 0:
                total += clearance[i, j]
                count += 1
    if np.isnan(wanted_depth):
        depth = total / count
    worst = 0.0
    for i in range(gap.shape[0]):
        for j in range(gap.shape[1]):
            clearance[i, j] -= depth
            if allowed[i, j]:
                if not unilateral or pressure[i, j] > 0:
                    worst = max(worst, abs(clearance[i, j]))
                else:
                    worst = max(worst, -clearance[i, j])
    return worst, depth


@njit(cache=True, error_model="numpy")
def _prepare(state, cells, units, correction):
    """Fill target and bound of the correction; ratios out of range stand for infinity."""
    (clearance, pressure), (allowed, unilateral) = state, cells
    (length, pressure_unit), (target, lower) = units, correction
    for i in range(clearance.shape[0]):
        for j in range(clearance.shape[1]):
            target[i, j] = descent.NEVER
            lower[i, j] = 0
            if allowed[i, j]:
                target[i, j] = max(-clearance[i, j] / length, descent.NEVER)
                bound = -pressure[i, j] / pressure_unit if unilateral else descent.NEVER
                lower[i, j] = max(bound, descent.NEVER)


@njit(cache=True, error_model="numpy")
def _accept(pressure, correction, lower, unilateral, pressure_unit):
    """Add the correction; cells that ended on their bound are free of pressure."""
    for i in range(pressure.shape[0]):
        for j in range(pressure.shape[1]):
            value = pressure[i, j] + np.float64(correction[i, j]) * pressure_unit
            if unilateral and (value < 0 or not correction[i, j] > lower[i, j]):
                value = 0.0
            pressure[i, j] = value
