"""A film that carries a given load on a deforming surface: Newton's method on all of it at once.

Unknowns are the film's s in every cell and the separation between the bodies; the equations are the
balance of mass in every cell and that of forces. The Jacobian of the flow is exact. What the
pressure bends is a convolution (`halfspace.operators`), so that steps are found by GMRES,
preconditioned by a sparse factorisation in which a cell bends its neighbours only.
"""

from __future__ import annotations

from copy import copy
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import LinearOperator, SuperLU, gmres, splu

from reference.errors import ConvergenceError
from reference.lubrication.reynolds import Film
from reference.lubrication.surface import Surface
from reference.lubrication.transport import Entrainment, State, Transport

Field = NDArray[np.float64]

# Of its thickness anywhere, the film keeps at least this share in one step of Newton's method.
_KEPT = 0.35
_ROUNDS = 30
# Steps of GMRES after which the factorisation is renewed, and most of them.
_PATIENCE, _MOST = 25, 60
# Cells that may rupture or heal before it is renewed.
_SWITCHED = 4
# Errors beyond the least one by this factor are a divergence.
_LOST = 1e8
# Rounds within which an error above one must fall.
_STALLED = 8
# Errors below this one are near the solution: more cells would not help.
_NEAR = 1e-6


def rigid_film_at(film: Film, separation: float, speed: float, tolerance: float = 1e-12) -> State:
    """Return the film between rigid bodies at a given distance, drawn along at L.

    With the gap given the equations are linear but for where the film ruptures: each round solves
    them for the cells that were full in the one before. It ends where none switches, or where only
    pressures do that are zero to round-off.

    Raises
    ------
    ConvergenceError
        If full and ruptured cells do not settle.
    """
    rigid = np.zeros(film.gap.shape)
    flow = Entrainment(speed)
    gap = film.thickness(separation, rigid)
    full = (film.cells.centres[0] < 0) & (gap < film.inlet)
    state = State(np.where(full, 1.0, np.minimum(film.inlet / gap, 0.5) - 1), separation, rigid)
    history: list[float] = []
    # oil that does not fit through fills the gap upstream, a cell in each round
    for rounds in range(_ROUNDS + film.gap.shape[0]):
        slopes = flow.slopes(film, state)
        change = _factors(slopes.s).solve(flow.balance(film, state).ravel())
        s = state.s - change.reshape(rigid.shape)
        switched = np.count_nonzero((s > 0) != (state.s > 0))
        state = replace(state, s=s)
        error = float(np.abs(flow.balance(film, state) / flow.carried(film, state)).max())
        history.append(error)
        if not switched or error <= tolerance:
            return replace(state, error=error, rounds=rounds + 1, history=history)
    raise ConvergenceError("full and ruptured film do not settle", history)


class LoadedFilm:
    """A film between bodies pressed together by a load.

    Parameters
    ----------
    film : Film
    surface : Surface
    load : float
    """

    def __init__(self, film: Film, surface: Surface, load: float) -> None:
        self.film, self.surface, self.load = film, surface, load
        self.near = surface.near()

    def under(self, load: float) -> LoadedFilm:
        """Return the same film under another load."""
        other = copy(self)
        other.load = load
        other.surface = self.surface.under(load)
        return other

    # overflows are detected in the error and reported
    @np.errstate(over="ignore", invalid="ignore", divide="ignore")
    def solve(self, flow: Transport, start: State, tolerance: float = 1e-10) -> State:
        """Return the film that flows so, from a state nearby.

        Raises
        ------
        ConvergenceError
            With the history of errors.
        """
        state = replace(start, displacement=self.surface.displacement(start.pressure))
        history: list[float] = []
        step: _Step | None = None
        for rounds in range(_ROUNDS):
            mass = flow.balance(self.film, state)
            force = float((state.pressure * self.film.cells.area).sum() - self.load)
            imbalance = float(np.abs(mass / self.through(flow, state)).max())
            error = max(imbalance, abs(force) / self.load)
            history.append(error)
            if error <= tolerance:
                return replace(state, error=error, rounds=rounds, history=history)
            stalled = len(history) > _STALLED and error > history[-1 - _STALLED] > 1
            if stalled or not error <= _LOST * min(history):
                break
            if step is None or step.stale(state):
                step = _Step(self, flow, state)
            else:
                step.renew(state)
            change = step.solve(mass, force, min(1e-2, 0.1 * error), 0.1 * tolerance)
            state = self._moved(flow, state, *change)
        raise ConvergenceError(
            f"the film is balanced to {history[-1]:.1e}, not to {tolerance:.0e}, after "
            f"{len(history)} rounds: {_reason(history)}",
            history,
        )

    def through(self, flow: Transport, state: State) -> Field:
        """Return what flows through each cell, which its balance is compared with.

        Far out, where the gap is wide, pressures that are zero to round-off drive more than the
        surfaces carry.
        """
        driven = self.film.driven(state.pressure, state.separation, state.displacement)
        return flow.carried(self.film, state) + driven

    def _moved(self, flow: Transport, state: State, change: Field, rise: float) -> State:
        """Return the state after a step, shortened where the film would become too thin."""
        before = self.film.thickness(state.separation, state.displacement)
        share = 1.0
        for _ in range(30):
            s, separation = (
                _crossed(state.s, state.s + share * change),
                state.separation + share * rise,
            )
            displacement = self.surface.displacement(np.maximum(s, 0.0))
            thick = (self.film.thickness(separation, displacement) > _KEPT * before).all()
            if thick and flow.admits(separation):
                break
            share /= 2
        return replace(state, s=s, separation=separation, displacement=displacement)


def _crossed(before: Field, after: Field) -> Field:
    """Return a step's s, halted at zero where a cell ruptures or heals.

    A slope of p says nothing of theta, nor the reverse: far before the contact p is 1e-9 of theta.
    """
    return np.where((before > 0) != (after > 0), np.copysign(np.finfo(float).tiny, after), after)


def _reason(history: list[float]) -> str:
    """Return why Newton's method ended: it came near and stands still, or never did."""
    return "stagnates at round-off" if min(history) < _NEAR else "too thin for its cells"


class _Step:
    """A step of Newton's method, and the factorisation that finds it."""

    def __init__(self, loaded: LoadedFilm, flow: Transport, state: State) -> None:
        self.loaded, self.flow = loaded, flow
        self.slow = False
        self.renew(state)
        near = self.slopes.displacement @ loaded.near @ sparse.diags(self.positive)
        self.factors = _factors(self.slopes.s + near)
        self.factored = self.positive
        self.response = self.factors.solve(self.slopes.separation)
        self.weight = float(self.push @ self.response)

    def stale(self, state: State) -> bool:
        """Whether the factorisation is of a film too different from a state."""
        switched = np.count_nonzero((state.s > 0).ravel() != (self.factored > 0))
        return self.slow or bool(switched > _SWITCHED)

    def renew(self, state: State) -> None:
        """Take the derivatives of another state; the factorisation stays."""
        self.slopes = self.flow.slopes(self.loaded.film, state)
        # rows count as their errors do: a far cell's flow is larger by many digits
        self.scale = np.append(self.loaded.through(self.flow, state).ravel(), self.loaded.load)
        self.positive = (state.s > 0).ravel().astype(float)
        self.push = self.loaded.film.cells.area.ravel() * self.positive

    def solve(
        self, mass: Field, force: float, accuracy: float, floor: float
    ) -> tuple[Field, float]:
        """Return the changes of s and of the separation.

        `accuracy` is relative, `floor` what the errors need not fall below. GMRES ends at its
        preconditioned residual, so that the true one may miss the accuracy: the next round of
        Newton's method makes up for it, the factorisation is no worse.
        """
        size = mass.size + 1
        counts: list[float] = []
        answer, _ = gmres(
            LinearOperator((size, size), self._apply),
            -np.append(mass.ravel(), force) / self.scale,
            M=LinearOperator((size, size), self._precondition),
            rtol=accuracy,
            atol=floor,
            restart=_MOST,
            maxiter=1,
            callback=counts.append,
            callback_type="pr_norm",
        )
        self.slow = len(counts) > _PATIENCE
        return answer[:-1].reshape(mass.shape), float(answer[-1])

    def _apply(self, vector: Field) -> Field:
        change, rise = vector[:-1], vector[-1]
        pressed = (self.positive * change).reshape(self.loaded.film.cells.shape)
        displacement = self.loaded.surface.respond(pressed).ravel()
        mass = (
            self.slopes.s @ change
            + self.slopes.displacement @ displacement
            + self.slopes.separation * rise
        )
        return np.append(mass, self.push @ change) / self.scale

    def _precondition(self, vector: Field) -> Field:
        """Eliminate the separation by the force."""
        right = vector * self.scale
        part = self.factors.solve(right[:-1])
        rise = (self.push @ part - right[-1]) / self.weight
        return np.append(part - rise * self.response, rise)


def _factors(matrix: sparse.spmatrix) -> SuperLU:
    """Factorise a matrix whose pattern is symmetric; its ordering halves time and memory."""
    return splu(
        matrix.tocsc(),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.01,
        options={"SymmetricMode": True},
    )
