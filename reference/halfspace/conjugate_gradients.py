"""Projected conjugate gradients for the pressures of frictionless contact.

minimise  1/2 p.K p - p.(d - g)  over p >= 0,

with d given, or with the sum of p given, in which case d is the multiplier of that constraint. The
contact set changes in every iteration, as in I. A. Polonsky and L. M. Keer, Wear 231 (1999) 206,
and V. Rey, G. Anciaux and J.-F. Molinari, Comput. Mech. 60 (2017) 69. The directions are those of
Polak and Ribiere, which forget by themselves when the set changes; with the restarts of Polonsky
and Keer instead, rough contacts took up to four times as many iterations.

All quantities enter homogeneously: no absolute tolerance, and a change of units by powers of two
changes no digit.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy import fft

from reference.errors import ConvergenceError
from reference.halfspace import kernels
from reference.halfspace.operators import HalfSpace

Field = NDArray[np.float64]

# The preconditioned method is given up when its best violation has not halved in this many
# iterations; where it works it gains a digit in five or fewer.
_PATIENCE = 60

# Units of round-off that a displacement by FFT is wrong by, with a margin; and the violation below
# which it is worth while to ask.
_ROUNDING, _ROUNDING_NEAR = 16.0, 1e-6

# Empty cells that keep opposite rims of a free patch apart in the preconditioner. |q| reaches only
# as r^-3, so that a few are as good as doubling the grid; none cost half as many iterations again.
_RIM = 8


@dataclass
class Problem:
    """Gap with the cells that may touch, and the one load: a depth, or a total of the pressures."""

    operator: HalfSpace
    gap: Field  # finite everywhere; where `allowed` is False its value is not used
    allowed: NDArray[np.bool_]
    depth: float | None = None
    total: float | None = None


@dataclass
class State:
    """Pressure, its displacement and the depth: all that one stage hands to the next."""

    pressure: Field
    displacement: Field
    depth: float
    history: list[float] = field(default_factory=list)


def minimise(problem: Problem, start: Field, tolerance: float, max_iterations: int) -> State:
    """Solve the contact problem from a starting pressure; preconditioned first, then plainly.

    Raises
    ------
    ConvergenceError
        With the violation of every iteration, when neither stage reaches the tolerance.
    """
    pressure = np.where(problem.allowed, np.maximum(start, 0.0), 0.0)
    if problem.total is not None:
        pressure *= problem.total / pressure.sum()
    state = State(pressure, problem.operator.apply(pressure), problem.depth or 0.0)
    for precondition, patience in (
        (WavenumberPreconditioner(problem.operator), _PATIENCE),
        (None, max_iterations),
    ):
        if _iterate(problem, state, precondition, tolerance, max_iterations, patience):
            return state
    raise ConvergenceError(
        f"contact iteration stopped at a violation of {state.history[-1]:.1e} of the penetration "
        f"after {len(state.history)} iterations (tolerance {tolerance:.1e})",
        state.history,
    )


class WavenumberPreconditioner:
    """|q| in Fourier space: the inverse of the half-space under a periodic pressure.

    The zero mode is half the smallest wavenumber, so that the whole is positive definite. It has to
    be set from the contact (`settle`) where the mean pressure is free on a periodic one: near
    full contact a uniform pressure on the contact costs almost no energy, and without the matching
    large zero mode the iterations grow from 25 to many hundreds.
    """

    def __init__(self, operator: HalfSpace) -> None:
        self._operator = operator
        self._padded = operator.shape
        if not operator.periodic:
            self._padded = tuple(fft.next_fast_len(n + _RIM, real=True) for n in operator.shape)
        qx, qy = kernels.wavenumbers(self._padded, operator.spacing)
        self._wavenumber = np.hypot(qx, qy)
        self._wavenumber[0, 0] = 1 / max(operator.spacing)
        self._wavenumber[0, 0] = self._wavenumber.min() / 2
        self._open_cells = 0

    def __call__(self, residual: Field) -> Field:
        """Return the preconditioned residual."""
        spectrum = fft.rfft2(residual, s=self._padded, workers=1)
        spectrum *= self._wavenumber
        whole = fft.irfft2(spectrum, s=self._padded, overwrite_x=True, workers=1)
        return np.ascontiguousarray(whole[: residual.shape[0], : residual.shape[1]])

    def settle(self, mask: NDArray[np.bool_]) -> None:
        """Match the zero mode to the energy of a uniform pressure on the mask, when that moved."""
        open_cells = mask.size - np.count_nonzero(mask)
        if open_cells in (0, mask.size) or abs(open_cells - self._open_cells) <= open_cells / 5:
            return
        self._open_cells = open_cells
        uniform = mask.astype(float)
        compliance = _dot(uniform, self._operator.apply(uniform)) / uniform.sum()
        # |q| leaves out E*/2; a further 2 because pressure crowds at the rims of the open cells
        self._wavenumber[0, 0] = 4 / (compliance * self._operator.effective_modulus)


def _iterate(
    problem: Problem,
    state: State,
    precondition: WavenumberPreconditioner | None,
    tolerance: float,
    max_iterations: int,
    patience: int,
) -> bool:
    """Run one stage on the state; True when the tolerance is met by a fresh displacement."""
    shape = problem.operator.shape
    residual, previous = np.zeros(shape), np.zeros(shape)
    direction, free = np.zeros(shape), np.zeros(shape, dtype=bool)
    descent = 0.0
    best, best_at, fresh = np.inf, len(state.history), True
    while len(state.history) < max_iterations:
        violation = _residual(problem, state, residual, free)
        state.history.append(violation)
        if violation <= tolerance or violation <= _rounding(problem, state, violation):
            if fresh:
                return True
            state.displacement, fresh = problem.operator.apply(state.pressure), True
            state.history.pop()
            continue
        if violation < best / 2:
            best, best_at = violation, len(state.history)
        if len(state.history) - best_at > patience:
            return False
        scaled = _precondition(problem, precondition, residual, free)
        constrained = problem.total is not None
        slope, descent = _turn(scaled, residual, previous, direction, free, constrained, descent)
        if slope <= 0:
            return False
        response = problem.operator.apply(direction)
        curvature = _dot(direction, response)
        if curvature <= 0:
            return False
        fresh = _advance_state(problem, state, direction, response, slope / curvature)
        residual, previous = previous, residual
    return False


def _rounding(problem: Problem, state: State, violation: float) -> float:
    """Violation that the rounding of the displacement alone may cause; 0 where it is far away.

    A pressure many times that of full contact displaces a nearly flat surface by much more than its
    own heights, and the last digits of that are a visible part of the penetration.
    """
    if violation > _ROUNDING_NEAR or not state.depth > 0:
        return 0.0
    operator = problem.operator
    displacement = state.pressure.max() * max(operator.spacing) / operator.effective_modulus
    return float(_ROUNDING * np.finfo(float).eps * displacement / state.depth)


def _precondition(
    problem: Problem,
    precondition: WavenumberPreconditioner | None,
    residual: Field,
    free: NDArray[np.bool_],
) -> Field:
    """Residual through the preconditioner, or a copy of it."""
    if precondition is None:
        return residual.copy()
    if problem.operator.periodic and problem.total is None:
        precondition.settle(free)
    return precondition(residual)


def _residual(problem: Problem, state: State, residual: Field, free: NDArray[np.bool_]) -> float:
    """Fill residual and free set of the present pressure, update the depth; the violation."""
    if problem.total is not None:
        state.depth = _contact_mean(state.pressure, state.displacement, problem.gap)
    worst = _clearances(
        state.pressure,
        state.displacement,
        problem.gap,
        problem.allowed,
        state.depth,
        problem.total is not None,
        residual,
        free,
    )
    return worst / state.depth if state.depth > 0 else np.inf


def _advance_state(
    problem: Problem, state: State, direction: Field, response: Field, length: float
) -> bool:
    """Step, clip at zero pressure and restore the total; True when the displacement is fresh."""
    clipped = _advance(state.pressure, state.displacement, direction, response, length)
    if problem.total is not None:
        # a step keeps the total but for rounding, a clipped one has lost some of it
        factor = problem.total / state.pressure.sum()
        state.pressure *= factor
        state.displacement *= factor
    if clipped:
        state.displacement = problem.operator.apply(state.pressure)
    return clipped


@njit(cache=True)
def _contact_mean(pressure, displacement, gap):
    """Mean of displacement + gap over the cells with pressure: the depth under force control."""
    total, count = 0.0, 0
    for i in range(pressure.shape[0]):
        for j in range(pressure.shape[1]):
            if pressure[i, j] > 0:
                total += displacement[i, j] + gap[i, j]
                count += 1
    return total / count


@njit(cache=True)
def _clearances(pressure, displacement, gap, allowed, depth, constrained, residual, free):
    """Residual on the free set (pressure > 0, or overlap), and the largest violation."""
    worst, total, count = 0.0, 0.0, 0
    for i in range(pressure.shape[0]):
        for j in range(pressure.shape[1]):
            clearance = displacement[i, j] + gap[i, j] - depth
            loaded = pressure[i, j] > 0
            free[i, j] = loaded or (allowed[i, j] and clearance < 0)
            residual[i, j] = 0.0
            if free[i, j]:
                worst = max(worst, abs(clearance))
                residual[i, j] = -clearance
                total -= clearance
                count += 1
    if constrained and count > 0:
        mean = total / count
        for i in range(pressure.shape[0]):
            for j in range(pressure.shape[1]):
                if free[i, j]:
                    residual[i, j] -= mean
    return worst


@njit(cache=True)
def _turn(scaled, residual, previous, direction, free, constrained, descent):
    """Turn to the next conjugate direction on the free set; (slope along it, residual.scaled)."""
    mean = _free_mean(scaled, free) if constrained else 0.0
    now, crossed = 0.0, 0.0
    for i in range(scaled.shape[0]):
        for j in range(scaled.shape[1]):
            if free[i, j]:
                scaled[i, j] -= mean
                now += scaled[i, j] * residual[i, j]
                crossed += scaled[i, j] * previous[i, j]
            else:
                scaled[i, j] = 0.0
                direction[i, j] = 0.0
    beta = max(0.0, (now - crossed) / descent) if descent > 0 else 0.0
    mean = beta * _free_mean(direction, free) if constrained else 0.0
    slope = 0.0
    for i in range(scaled.shape[0]):
        for j in range(scaled.shape[1]):
            if free[i, j]:
                direction[i, j] = scaled[i, j] + beta * direction[i, j] - mean
                slope += direction[i, j] * residual[i, j]
    if slope <= 0:
        direction[:] = scaled
        slope = now
    return slope, now


@njit(cache=True)
def _free_mean(values, free):
    total, count = 0.0, 0
    for i in range(values.shape[0]):
        for j in range(values.shape[1]):
            if free[i, j]:
                total += values[i, j]
                count += 1
    return total / count


@njit(cache=True)
def _dot(first, second):
    total = 0.0
    for i in range(first.shape[0]):
        for j in range(first.shape[1]):
            total += first[i, j] * second[i, j]
    return total


@njit(cache=True)
def _advance(pressure, displacement, direction, response, length):
    """Step along the direction, cut tension off; True when something was cut."""
    clipped = False
    for i in range(pressure.shape[0]):
        for j in range(pressure.shape[1]):
            displacement[i, j] += length * response[i, j]
            if direction[i, j] != 0.0:
                value = pressure[i, j] + length * direction[i, j]
                if value < 0:
                    value = 0.0
                    clipped = True
                pressure[i, j] = value
    return clipped


def fixed_contact_response(
    operator: HalfSpace, mask: NDArray[np.bool_], tolerance: float, max_iterations: int = 2000
) -> Field:
    """Pressure (of either sign) that displaces the cells of `mask` by one and loads no others."""
    precondition = WavenumberPreconditioner(operator)
    if operator.periodic:
        precondition.settle(mask)
    pressure = np.zeros(operator.shape)
    residual = mask.astype(float)
    scaled = np.where(mask, precondition(residual), 0.0)
    direction = scaled.copy()
    descent = (residual * scaled).sum()
    history = []
    for _ in range(max_iterations):
        response = operator.apply(direction)
        length = descent / (direction * response).sum()
        pressure += length * direction
        residual -= np.where(mask, length * response, 0.0)
        history.append(float(np.abs(residual).max()))
        if history[-1] <= tolerance:
            return pressure
        scaled = np.where(mask, precondition(residual), 0.0)
        descent, previous = (residual * scaled).sum(), descent
        direction = scaled + (descent / previous) * direction
    raise ConvergenceError("conjugate gradients on the fixed contact set did not converge", history)
