r"""Tangential tractions of steady rolling within given friction bounds.

The contact stands still, and the surface flows through it along -x. Its material enters
undeformed ahead of the contact; a point that has arrived at x slips over the roller by

    s = c + dx(u)        per distance rolled (steady state: the time derivative of u is -V dx(u)),

c the creep, by which the roller's surface would slide over a rigid one, u = A q the displacement
of the half-space (Johnson 1985, sec. 8.1; Kalker 1990, sec. 1.3). Between a cell and the next one
upstream the derivative is a difference, D q = A q - A q(x + dx) over dx, and Coulomb's law holds on
each cell:

    stick  s = 0 and |q| < b,      slip  q = b s/|s|,      b = mu p.

D is not symmetric: there is no energy to minimise, as in a single step of loading (`stick_slip`),
and sweeps cell by cell diverge. Both cases are the zero of one function,

    q - b e/max(b, |e|),    e = q + r s,

which Newton's method with the projected derivative of Hueber, Stadler & Wohlmuth (SIAM J. Sci.
Comput. 30 (2008) 572) solves in three to eight rounds: an active set that turns the direction of
slip at the same time. First order in the cells, as the slip belongs to the middle between two.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lu_factor, lu_solve
from scipy.sparse.linalg import LinearOperator, gmres

from reference.errors import ConvergenceError

Field = NDArray[np.float64]
Fields = NDArray[np.float64]

LIMIT = 7000
"""Largest number of unknown tractions for a factorisation: 1.5 GB and some 20 s a round."""
# Tractions this close to their bound slip.
ON_BOUND = 1 - 1e-9
_ROUNDS = 60
# A round uses the factor of another one where so many products give it so precisely.
_PRODUCTS, _PRECISION = 40, 1e-4
# Creep below this share of the largest of the field is none: mirror images are compared by it.
_EVEN = 1e-12


class Surface(Protocol):
    """What is needed of an elastic surface: its answer to tangential tractions on cells."""

    @property
    def spacing(self) -> tuple[float, float]:
        """Sides of a cell."""
        ...

    def shear_coefficients(self) -> Fields:
        """Return u_x by q_x, u_y by q_y, and u_x by q_y, at all offsets of cells.

        Shape (3, mx, my), the offsets modulo m, of at least the grid's size to either side.
        """
        ...


@dataclass(frozen=True)
class Tractions:
    """Tractions of steady rolling.

    Attributes
    ----------
    traction : ndarray, shape (2, nx, ny)
        On the half-space, of the sign of the creep.
    slip : ndarray, shape (2, nx, ny)
        Of the roller over the loaded cells, per distance rolled.
    sliding : ndarray of bool, shape (nx, ny)
        Loaded cells on their bound.
    error : float
        Largest error of a traction in Coulomb's law, relative to the largest traction.
    history : list of float
        Errors of the rounds.
    """

    traction: Fields
    slip: Fields
    sliding: NDArray[np.bool_]
    error: float
    history: list[float] = field(default_factory=list, repr=False)

    @property
    def rounds(self) -> int:
        """Number of rounds of Newton's method."""
        return len(self.history)


class Rolling:
    """Steady rolling on the loaded cells of a grid, for any number of creeps.

    Parameters
    ----------
    surface : Surface
    bound : ndarray, shape (nx, ny)
        mu p; zero outside the contact, and on the foremost cells of the grid (those of largest x),
        ahead of which nothing is known. Infinite everywhere in the contact: all of it sticks.

    Raises
    ------
    ConvergenceError
        If more cells are loaded than can be factorised.
    """

    def __init__(self, surface: Surface, bound: Field) -> None:
        self.surface, self.bound = surface, bound
        if (bound[-1] > 0).any():
            raise ConvergenceError("the contact reaches the leading edge of the grid")
        self.even = bool(np.array_equal(bound, bound[:, ::-1]))
        self._cells: dict[int, _Cells] = {}

    def at(self, creep: Fields, start: Fields | None = None, tolerance: float = 1e-9) -> Tractions:
        """Return the tractions for a creep.

        Parameters
        ----------
        creep : ndarray, shape (2, nx, ny)
            c on all cells, the part that the pressure drags along included.
        start : ndarray, shape (2, nx, ny), optional
            Tractions to start from, projected to the bounds; default: those of full stick.
        tolerance : float
            Largest `Tractions.error`.

        Raises
        ------
        ConvergenceError
            With the errors of all rounds.
        """
        cells = self._cells_for(creep)
        bound, rate = cells.of_grid(self.bound[None])[0], cells.of_grid(creep)
        if not rate.any():
            return cells.answer(np.zeros(rate.shape), rate, bound, [0.0])
        stuck = cells.stuck(rate)
        if np.isinf(bound).all():
            return cells.answer(stuck, np.zeros(rate.shape), bound, [0.0])
        begin = stuck if start is None else cells.of_grid(start)
        try:
            return _newton(cells, bound, rate, begin, tolerance)
        except ConvergenceError:
            if start is None:
                raise
        return _newton(cells, bound, rate, stuck, tolerance)

    def _cells_for(self, creep: Fields) -> _Cells:
        """Return the cells, or half of them where bounds and creep are mirror images in y.

        Longitudinal creep is even, so that q_x is even and q_y odd; lateral creep and spin about
        the middle are the other way round.
        """
        sign = 0
        if self.even and creep.shape[2] > 1:
            small = _EVEN * float(np.abs(creep).max())
            for parity in (1, -1):
                mirrored = np.array([parity, -parity])[:, None, None] * creep[:, :, ::-1]
                if np.abs(creep - mirrored)[:, self.bound > 0].max(initial=0.0) <= small:
                    sign = parity
        if sign not in self._cells:
            self._cells[sign] = _Cells(self.surface, self.bound > 0, sign)
        return self._cells[sign]


class _Cells:
    """The loaded cells, or those of one half, with the matrix between them.

    Parameters
    ----------
    sign : {0, 1, -1}
        Parity of q_x in y where only one half is solved, q_y having the other; 0: all cells.
    """

    def __init__(self, surface: Surface, loaded: NDArray[np.bool_], sign: int) -> None:
        self.shape, self.sign = loaded.shape, sign
        chosen = loaded.copy()
        if sign:
            chosen[:, (loaded.shape[1] + 1) // 2 :] = False
        self.rows, self.columns = np.nonzero(chosen)
        count = self.rows.size
        if 2 * count > LIMIT:
            raise ConvergenceError(
                f"{2 * count} tractions exceed the limit of {LIMIT}: use a coarser grid"
            )
        self.step = surface.spacing[0]
        matrix = self._matrix(surface.shear_coefficients(), loaded.shape[1])
        self.matrix = np.ascontiguousarray(matrix.transpose(0, 2, 1, 3)) / self.step
        # traction per slip, near that of a cell alone: the r of Newton's function
        self.reach = 1 / float(np.einsum("anan->an", self.matrix).max())
        self._factor: tuple[Field, NDArray[np.int32]] | None = None

    def _matrix(self, table: Fields, width: int) -> Field:
        """Return (A q - A q upstream) of the cells for unit tractions on them: (2, 2, n, n)."""
        i = self.rows[:, None] - self.rows
        xx, yy, xy = self._differences(table, i, self.columns[:, None] - self.columns)
        if self.sign:
            images = width - 1 - self.columns
            more = self._differences(table, i, self.columns[:, None] - images)
            more[:, :, images == self.columns] = 0.0  # a cell in the middle has no image
            xx, yy = xx + self.sign * more[0], yy - self.sign * more[1]
            return np.array([[xx, xy - self.sign * more[2]], [xy + self.sign * more[2], yy]])
        return np.array([[xx, xy], [xy, yy]])

    @staticmethod
    def _differences(table: Fields, i: NDArray[np.intp], j: NDArray[np.intp]) -> Fields:
        _, mx, my = table.shape
        difference: Fields = table[:, i % mx, j % my] - table[:, (i + 1) % mx, j % my]
        return difference

    def of_grid(self, fields: Fields) -> Fields:
        """Return the values on the cells, shape (k, n)."""
        return fields[:, self.rows, self.columns]

    def on_grid(self, values: Fields) -> Fields:
        """Return the values on the whole grid, with their mirror images."""
        fields = np.zeros((2, *self.shape))
        if self.sign:
            fields[:, self.rows, self.shape[1] - 1 - self.columns] = values * np.array(
                [[self.sign], [-self.sign]]
            )
        fields[:, self.rows, self.columns] = values
        return fields

    def slip(self, traction: Fields, rate: Fields) -> Fields:
        """Return c - D q."""
        count = traction.size
        driven = self.matrix.reshape(count, count) @ traction.ravel()
        return rate - driven.reshape(traction.shape)

    def stuck(self, rate: Fields) -> Fields:
        """Return the tractions of full stick."""
        identity = np.broadcast_to(np.eye(2)[:, :, None], (2, 2, rate.shape[1]))
        return self.solved(identity, self.reach * rate)

    def solved(self, turn: Field, right: Fields) -> Fields:
        """Return the change of tractions dq with dq - T (dq - r D dq) = right.

        Parameters
        ----------
        turn : ndarray, shape (2, 2, n)
            T of all cells: how the projected traction changes with the tried one.
        """
        if self._factor is not None:
            changed = self._by_old_factor(turn, right)
            if changed is not None:
                return changed
        size = right.size
        matrix = np.einsum("abn,bncm->ancm", self.reach * turn, self.matrix)
        own = np.arange(right.shape[1])
        for a in range(2):
            for b in range(2):
                matrix[a, own, b, own] += (a == b) - turn[a, b]
        self._factor = lu_factor(matrix.reshape(size, size), overwrite_a=True, check_finite=False)
        return self._divided(right).reshape(right.shape)

    def _divided(self, right: Field) -> Field:
        solved: Field = lu_solve(self._factor, right.ravel(), check_finite=False)
        return solved

    def _by_old_factor(self, turn: Field, right: Fields) -> Fields | None:
        """Solve by GMRES with the factor of another round; return None if it does not converge."""
        size = right.size
        matrix = self.matrix.reshape(size, size)

        def product(values: Field) -> Field:
            change = values.reshape(right.shape)
            left = change - self.reach * (matrix @ values).reshape(right.shape)
            return (change - np.einsum("abn,bn->an", turn, left)).ravel()

        solution, status = gmres(
            LinearOperator((size, size), product),
            right.ravel(),
            M=LinearOperator((size, size), self._divided),
            rtol=_PRECISION,
            restart=_PRODUCTS,
            maxiter=1,
        )
        return None if status else solution.reshape(right.shape)

    def answer(
        self, traction: Fields, slip: Fields, bound: Field, history: list[float]
    ) -> Tractions:
        """Return the result on the grid."""
        sliding = np.zeros(self.shape, dtype=bool)
        sliding[self.rows, self.columns] = np.hypot(*traction) >= ON_BOUND * bound
        if self.sign:
            sliding |= sliding[:, ::-1]
        on_grid = self.on_grid
        return Tractions(on_grid(traction), on_grid(slip), sliding, history[-1], history)


def _newton(
    cells: _Cells, bound: Field, rate: Fields, start: Fields, tolerance: float
) -> Tractions:
    """Return the tractions within bounds, from others."""
    traction, history = _within(start, bound), []
    for _ in range(_ROUNDS):
        slip = cells.slip(traction, rate)
        tried = traction + cells.reach * slip
        fault = traction - _within(tried, bound)
        scale = max(float(np.abs(traction).max()), float(np.finfo(float).tiny))
        history.append(float(np.abs(fault).max()) / scale)
        if not np.isfinite(history[-1]):
            break
        if history[-1] <= tolerance:
            return cells.answer(traction, slip, bound, history)
        traction = traction + cells.solved(_turn(traction, tried, bound), -fault)
    worst = f"{history[-1]:.1e} of the largest traction after {len(history)} rounds"
    raise ConvergenceError(f"Coulomb's law of rolling is violated by {worst}", history)


def _turn(traction: Fields, tried: Fields, bound: Field) -> Field:
    """Return how projected tractions change with the tried ones e, shape (2, 2, n).

    One in stick; in slip (b/|e|)(1 - q e'/(max(b, |q|) |e|)), which turns the traction.
    """
    size = np.hypot(*tried)
    slides = size > bound
    share = np.where(slides, bound / np.where(slides, size, 1.0), 1.0)
    inside = traction / np.maximum(np.where(slides, bound, 1.0), np.hypot(*traction))
    along = tried / np.where(slides, size, 1.0)
    return share * (np.eye(2)[:, :, None] - slides * inside[:, None] * along[None])


def _within(traction: Fields, bound: Field) -> Fields:
    """Return tractions projected to their bounds."""
    size = np.hypot(*traction)
    return traction * np.where(size > bound, bound / np.where(size > bound, size, 1.0), 1.0)
