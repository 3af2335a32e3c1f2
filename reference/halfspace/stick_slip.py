"""Tangential tractions within given friction bounds: stick, slip and its direction.

For a known pressure, Coulomb's law in one step is the convex problem (Duvaut & Lions 1976;
Kalker 1990)

    minimise  1/2 q.A q - q.w  over |q_i| <= b_i,   b = mu p,

w the tangential displacement required for stick. At the minimum the slip r = w - A q is zero where
the traction is below its bound, and parallel to the traction elsewhere. The solver uses conjugate
gradients on the set of free components, like Polonsky & Keer (1999) for pressures: both components
of sticking cells, the tangent to the friction circle of slipping cells. A slipping cell that turns
has the curvature |r|/b of its circle in addition to its elastic response. Steps are projected onto
the circles; cells whose residual points inwards become free. If the energy increases, a projected
gradient step, which cannot increase it, is taken instead.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from reference.errors import ConvergenceError
from reference.halfspace.traction import NormalAndTangential

Field = NDArray[np.float64]
Fields = NDArray[np.float64]

# A given total needs some tens of iterations; without progress in this many, the shift is searched.
_PATIENCE = 60
# Tractions this close to their bound count as on it.
ON_BOUND = 1 - 1e-12
# Newton steps for the shift that gives projected tractions their total, relative to the bounds.
_SHIFTS, _TOTAL = 100, 1e-14


@dataclass
class Tractions:
    """Tractions within their bounds.

    Attributes
    ----------
    traction : ndarray, shape (2, nx, ny)
    displacement : ndarray, shape (2, nx, ny)
        Tangential displacement by the tractions.
    slip : ndarray, shape (2, nx, ny)
        w + U e_x - A q on loaded cells; zero within the error for stick.
    sliding : ndarray of bool, shape (nx, ny)
        Loaded cells on their bound.
    shift : float
        U, the rigid displacement along x if a total is given, otherwise 0.
    error : float
        Largest slip of sticking cells, and of others transverse or opposite to their traction.
    iterations : int
    history : list of float
        Errors of the iterations.
    """

    traction: Fields
    displacement: Fields
    slip: Fields
    sliding: NDArray[np.bool_]
    shift: float
    error: float
    history: list[float] = field(default_factory=list)

    @property
    def iterations(self) -> int:
        """Number of iterations."""
        return len(self.history)


def minimise(
    problem: Shear,
    start: Fields,
    tolerance: float,
    max_iterations: int = 2000,
) -> Tractions:
    """Return the tractions.

    Parameters
    ----------
    problem : Shear
    start : ndarray, shape (2, nx, ny)
        Initial tractions, projected to the bounds.
    tolerance : float
        Largest error of the slip, a length.
    max_iterations : int

    Raises
    ------
    ConvergenceError
        With the errors of all iterations.
    """
    if problem.total is None:
        return problem.solve(start, tolerance, max_iterations)
    try:
        return problem.solve(start, tolerance, max_iterations, _PATIENCE)
    except ConvergenceError as stalled:
        spent = list(stalled.history)
    return _search_shift(problem, start, tolerance, max_iterations, spent)


def _search_shift(
    problem: Shear, start: Fields, tolerance: float, max_iterations: int, spent: list[float]
) -> Tractions:
    """Return the rigid displacement for the total, by Brent's method on single solutions.

    For contacts close to full sliding: without sticking cells the shift is undetermined, and the
    iteration with a given total stalls. The total grows with the shift, and the problem at a given
    shift is well posed.
    """
    total = problem.total
    assert total is not None
    solutions: dict[float, Tractions] = {}
    last = [start]

    def missing(shift: float) -> float:
        target = problem.target.copy()
        target[0] += shift
        inner = Shear(problem.body, problem.bound, target)
        solutions[shift] = inner.solve(last[0], tolerance, max_iterations)
        last[0] = solutions[shift].traction
        spent.extend(solutions[shift].history)
        return float(solutions[shift].traction[0].sum()) - total

    reach = float(np.abs(problem.target[:, problem.loaded]).max())
    reach = max(reach, problem.most / problem.loaded.sum() / problem.safe, tolerance)
    low, high = -reach, reach
    while missing(low) > 0 or missing(high) < 0:
        low, high = 2 * low, 2 * high
        if high > 2.0**20 * reach:
            raise ConvergenceError("no rigid displacement carries the tangential force", spent)
    shift = float(brentq(missing, low, high, xtol=tolerance / 8, rtol=1e-14))
    if shift not in solutions:
        missing(shift)
    answer = solutions[shift]
    answer.shift, answer.history = shift, spent
    return answer


class Shear:
    """The problem of tractions within bounds, with stick and slip, in any units.

    Parameters
    ----------
    body : NormalAndTangential
    bound : ndarray, shape (nx, ny)
        mu p >= 0; cells with 0 carry no traction.
    target : ndarray, shape (2, nx, ny)
        Displacement w required for stick (up to U along x with a total).
    total : float, optional
        Sum of the tractions along x over the cells (force over cell area), below the sum of the
        bounds; the rigid displacement along x is then an unknown.
    """

    def __init__(
        self, body: NormalAndTangential, bound: Field, target: Fields, total: float | None = None
    ) -> None:
        self.body, self.bound, self.target, self.total = body, bound, target, total
        self.loaded = bound > 0
        self.inverse_bound = np.divide(1.0, bound, out=np.zeros(bound.shape), where=self.loaded)
        self.most = float(bound.sum())
        # an upper bound of the operator's eigenvalues, for the length of a gradient step
        self.safe = 0.5 / body.unit
        # close to the displacement of a cell under its own traction
        self.cell_compliance = (
            (body.compliance.normal + body.compliance.lateral) * body.spacing[0] / 2
        )

    def solve(
        self, start: Fields, tolerance: float, max_iterations: int, patience: int | None = None
    ) -> Tractions:
        """Iterate to the tolerance; stop if the error has not halved in `patience` steps."""
        traction = self.project(start)
        state = self.evaluate(traction, [])
        direction: Fields | None = None
        scaled_before, residual_before = 1.0, traction
        energy = self.energy(state)
        while not state.error <= tolerance:
            if len(state.history) >= max_iterations or _stalled(state.history, patience):
                raise ConvergenceError(
                    f"friction iteration stopped at a slip error of {state.error:.1e} "
                    f"({state.error / tolerance:.1e} of the tolerance)",
                    state.history,
                )
            free, turn = self.free_part(state)
            soft = np.sqrt(self.cell_compliance / (self.cell_compliance + turn))
            scaled = self.only_free(soft * self.body.precondition(soft * free), state)
            power = float((free * scaled).sum())
            if direction is None:
                direction = scaled
            else:
                gain = float((scaled * (free - residual_before)).sum()) / scaled_before
                direction = scaled + max(gain, 0.0) * self.only_free(direction, state)
            scaled_before, residual_before = power, free
            moved, hit = self.step(state, free, direction, turn)
            new = self.evaluate(moved, state.history)
            new_energy = self.energy(new)
            if new_energy > energy + 1e-12 * abs(energy):
                new = self.evaluate(
                    self.project(state.traction + self.safe * state.slip), state.history
                )
                new_energy, hit = self.energy(new), True
            if hit or np.any(new.sliding != state.sliding):
                direction = None
            state, energy = new, new_energy
        return state

    def step(
        self, state: Tractions, free: Fields, direction: Fields, turn: Field
    ) -> tuple[Fields, bool]:
        """Minimise along the direction and project to the bounds."""
        image = self.body.shear(direction)
        curvature = float((direction * image).sum() + (turn * (direction**2).sum(axis=0)).sum())
        length = float((free * direction).sum()) / curvature
        moved = state.traction + length * direction
        size = np.hypot(*moved)
        hit = bool(np.any((size > self.bound) & self.loaded & ~state.sliding))
        circle = np.where(
            state.sliding & (turn > 0), self.bound / np.where(size > 0, size, 1.0), 1.0
        )
        return self.project(moved * circle), hit

    def evaluate(self, traction: Fields, history: list[float]) -> Tractions:
        """Return displacement, slip, shift and error of tractions within their bounds."""
        displacement = self.body.shear(traction)
        slip = np.where(self.loaded, self.target - displacement, 0.0)
        sliding = self.loaded & (np.hypot(*traction) >= ON_BOUND * self.bound)
        sticking = self.loaded & ~sliding
        shift = 0.0
        if self.total is not None:
            at = sticking if sticking.any() else self.loaded
            shift = -float(slip[0][at].mean())
            slip[0][self.loaded] += shift
        state = Tractions(traction, displacement, slip, sliding, shift, 0.0, history)
        free, _ = self.free_part(state)
        state.error = float(np.hypot(*free).max())
        if not np.isfinite(state.error):
            raise ConvergenceError("the friction iteration exceeded the range of numbers", history)
        history.append(state.error)
        return state

    def free_part(self, state: Tractions) -> tuple[Fields, Field]:
        """Return the inadmissible part of the slip, and the curvature of the friction circles.

        For cells on their bound with outward slip, only the part transverse to the traction counts.
        """
        along = (state.traction * state.slip).sum(axis=0) * self.inverse_bound
        constrained = state.sliding & (along >= 0)
        normal = state.traction * self.inverse_bound
        free = np.where(constrained, state.slip - along * normal, state.slip)
        return free, np.where(constrained, along * self.inverse_bound, 0.0)

    def only_free(self, field: Fields, state: Tractions) -> Fields:
        """Return the free components of a field; with a given total, of zero sum along x."""
        along = (state.traction * state.slip).sum(axis=0)
        constrained = state.sliding & (along >= 0)
        normal = state.traction * self.inverse_bound
        radial = np.where(constrained, (field * normal).sum(axis=0), 0.0)
        free = np.where(self.loaded, field - radial * normal, 0.0)
        sticking = self.loaded & ~constrained
        if self.total is not None and sticking.any():
            free[0][sticking] -= free[0].sum() / np.count_nonzero(sticking)
        return free

    def project(self, traction: Fields) -> Fields:
        """Return tractions projected to their bounds, a given total by a shift along x."""
        inside, shift = self._clip(traction), 0.0
        if self.total is None:
            return inside
        low, high = -np.inf, np.inf
        for _ in range(_SHIFTS):
            missing = self.total - float(inside[0].sum())
            if abs(missing) <= _TOTAL * self.most:
                break
            low, high = (shift, high) if missing > 0 else (low, shift)
            shift += missing / self._answer(traction, shift)
            if not low < shift < high:
                shift = (low + high) / 2
            inside = self._clip(_moved(traction, shift))
        return inside

    def _answer(self, traction: Fields, shift: float) -> float:
        """Return the growth of the total with the shift; clipped cells respond tangentially.

        At least the response of one cell in a million of full bounds, to keep steps finite.
        """
        along, across = _moved(traction, shift)
        size = np.hypot(along, across)
        over = self.loaded & (size > self.bound)
        share = np.divide(across, size, out=np.ones(size.shape), where=over)
        rate = np.divide(self.bound, size, out=np.ones(size.shape), where=over) * share**2
        return max(float(rate[self.loaded].sum()), 1e-6)

    def _clip(self, traction: Fields) -> Fields:
        size = np.hypot(*traction)
        over = size > self.bound
        share = np.divide(self.bound, size, out=np.ones(size.shape), where=over & (size > 0))
        return np.where(self.loaded, traction * share, 0.0)

    def energy(self, state: Tractions) -> float:
        """Return the value of the functional; the shift does no work, as the total is given."""
        return float((state.traction * (state.displacement / 2 - self.target)).sum())


def _moved(traction: Fields, shift: float) -> Fields:
    """Return the tractions with a shift along x."""
    return np.array([traction[0] + shift, traction[1]])


def _stalled(history: list[float], patience: int | None) -> bool:
    """Return whether the smallest error has not halved in the last iterations."""
    if patience is None or len(history) <= patience:
        return False
    return min(history[-patience:]) > 0.5 * min(history[:-patience])
