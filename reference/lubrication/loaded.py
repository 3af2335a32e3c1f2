"""A film that carries a given load on a deforming surface: Newton's method on all of it at once.

Unknowns are the film's s in every cell and the separation between the bodies; the equations are the
balance of mass in every cell and that of forces. The Jacobian of the flow is exact. What the
pressure bends is a convolution (`halfspace.kernels`), so that steps are found by GMRES,
preconditioned by a sparse factorisation in which a cell bends its neighbours only.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import LinearOperator, gmres

from reference.arrays import Array
from reference.errors import ConvergenceError
from reference.halfspace.kernels import FreeOperator
from reference.lubrication.reynolds import Film, FilmCells, FilmState, Transport, factors

# Of its thickness anywhere, the film keeps at least this share in one step of Newton's method.
_KEPT = 0.35
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


class BentSurface:
    """The elastic half-space below the equal cells of a film; beyond them a point load bends it.

    The unit load bends the surroundings by `far`, 1/(pi E* r); the compliance is 1/E*, zero for a
    rigid surface.
    """

    def __init__(self, cells: FilmCells, compliance: float) -> None:
        self.cells, self.compliance = cells, compliance
        self.far = np.zeros(cells.shape)
        if not compliance:
            return
        nx, ny = (part.stop - part.start for part in cells.core)
        self.body = FreeOperator((nx, ny * cells.copies), cells.spacing, 1 / compliance)
        x, y = cells.centres
        self.far = compliance / (np.pi * np.hypot(x, y))
        self.far[cells.core] = 0.0

    def respond(self, pressure: Array) -> Array:
        """Return the displacement of the equal cells under the pressure on them."""
        result = np.zeros(self.cells.shape)
        if self.compliance:
            core = pressure[self.cells.core]
            result[self.cells.core] = self.body.apply(self.cells.whole(core))[:, -core.shape[1] :]
        return result

    @cached_property
    def near(self) -> sparse.csr_array:
        """The displacement under pressure on the next cells only, as a matrix."""
        size = self.far.size
        if not self.compliance:
            return sparse.csr_array((size, size))
        index = np.arange(size).reshape(self.cells.shape)[self.cells.core]
        nx, ny = index.shape
        weights = self.body.coefficients((2, 2))
        # beside row 0 lies its image, where the cells are mirrored
        around = np.pad(index, 1, constant_values=-1)
        if self.cells.mirrored:
            around[1:-1, 0] = index[:, 0]
        rows, columns, values = [], [], []
        for i, j in np.ndindex(3, 3):
            beside = around[i : i + nx, j : j + ny]
            rows.append(index[beside >= 0])
            columns.append(beside[beside >= 0])
            values.append(np.full(rows[-1].size, weights[abs(i - 1), abs(j - 1)]))
        places = np.concatenate(rows), np.concatenate(columns)
        return sparse.csr_array((np.concatenate(values), places), shape=(size, size))


@dataclass(frozen=True, eq=False)
class LoadedFilm:
    """A film between bodies, of which one is elastic, pressed together by a load."""

    film: Film
    surface: BentSurface
    load: float = 1.0

    def displacement(self, pressure: Array) -> Array:
        """Return the displacement of all cells under a pressure."""
        return self.load * self.surface.far + self.surface.respond(pressure)

    # overflows are detected in the error and reported
    @np.errstate(over="ignore", invalid="ignore", divide="ignore")
    def solve(self, flow: Transport, start: FilmState, tolerance: float = 1e-10) -> FilmState:
        """Return the film that flows so, from a state nearby."""
        film, cells = self.film, self.film.cells

        def jacobian(vector: Array) -> Array:
            change, rise = vector[:-1], vector[-1]
            pressed = (positive * change).reshape(cells.shape)
            bent = slopes.displacement @ self.surface.respond(pressed).ravel()
            mass = slopes.s @ change + bent + slopes.separation * rise
            return np.append(mass, push @ change) / scale

        def precondition(vector: Array) -> Array:
            """Eliminate the separation by the force."""
            right = vector * scale
            part = solver.solve(right[:-1])
            rise = (push @ part - right[-1]) / weight
            return np.append(part - rise * response, rise)

        state = replace(start, displacement=self.displacement(start.pressure))
        history: list[float] = []
        factored: Array | None = None
        counts: list[float] = []
        for rounds in range(30):
            # Balances of mass and of forces. Mass is compared with what flows through a cell: far
            # out, where the gap is wide, pressures that are zero to round-off drive more than the
            # surfaces carry.
            mass = flow.balance(film, state)
            force = float((state.pressure * cells.area).sum() - self.load)
            through = flow.carried(film, state) + film.driven(state)
            error = max(float(np.abs(mass / through).max()), abs(force) / self.load)
            history.append(error)
            if error <= tolerance:
                return replace(state, error=error, rounds=rounds, history=history)
            stalled = len(history) > _STALLED and error > history[-1 - _STALLED] > 1
            if stalled or not error <= _LOST * min(history):
                break
            # Derivatives. Rows count as their errors do: flows of far cells are larger by digits.
            slopes = flow.slopes(film, state)
            scale = np.append(through.ravel(), self.load)
            positive = (state.s > 0).ravel().astype(float)
            push = cells.area.ravel() * positive
            # The factorisation is renewed where GMRES is slow, and where cells rupture or heal.
            slow = len(counts) > _PATIENCE
            if factored is None or slow or np.count_nonzero(positive != factored) > _SWITCHED:
                near = slopes.displacement @ self.surface.near @ sparse.diags_array(positive)
                solver, factored = factors(slopes.s + near), positive
                response = solver.solve(slopes.separation)
                weight = float(push @ response)
            # GMRES ends at its preconditioned residual, so that the true one may miss the accuracy:
            # the next round makes up for it, the factorisation is no worse.
            counts, size = [], mass.size + 1
            step, _ = gmres(
                LinearOperator((size, size), jacobian),
                -np.append(mass.ravel(), force) / scale,
                M=LinearOperator((size, size), precondition),
                rtol=min(1e-2, 0.1 * error),
                atol=0.1 * tolerance,
                restart=_MOST,
                maxiter=1,
                callback=counts.append,
                callback_type="pr_norm",
            )
            state = self._moved(flow, state, step[:-1].reshape(mass.shape), float(step[-1]))
        near_the_end = min(history) < _NEAR
        reason = "stagnates at round-off" if near_the_end else "too thin for its cells"
        raise ConvergenceError(
            f"the film is balanced to {history[-1]:.1e}, not to {tolerance:.0e}, after "
            f"{len(history)} rounds: {reason}",
            history,
        )

    def _moved(self, flow: Transport, state: FilmState, change: Array, rise: float) -> FilmState:
        """Return the state after a step, shortened where the film would become too thin."""
        before, share = self.film.thickness(state), 1.0
        for _ in range(30):
            s = state.s + share * change
            # A cell that ruptures or heals halts at zero. A slope of p says nothing of theta, nor
            # the reverse: far before the contact p is 1e-9 of theta.
            s = np.where((state.s > 0) != (s > 0), np.copysign(np.finfo(float).tiny, s), s)
            moved = replace(
                state,
                s=s,
                separation=state.separation + share * rise,
                displacement=self.displacement(np.maximum(s, 0.0)),
            )
            thick = (self.film.thickness(moved) > _KEPT * before).all()
            if thick and flow.admits(moved.separation):
                break
            share /= 2
        return moved
