r"""Reynolds' equation with mass-conserving cavitation, on rectangular cells.

    div(h^3 grad p) = L d/dx[(1 - theta) h],    p >= 0, theta >= 0, p theta = 0,

L = 12 eta U in scaled units, theta the share of the gap that vapour fills (Elrod & Adams 1974;
as a complementarity problem Bertocchi, Dini, Giacopini, Fowell & Baldini, Tribol. Int. 67 (2013)
61). Film that ruptures and forms again needs no condition of its own: mass is conserved in every
cell. One unknown s per cell is both: p = max(s, 0), theta = max(-s, 0).

The flow through a face is h^3 dp/dn at the face's own gap; the film that a surface carries along is
of second order where the gap is full, and the vapour that takes its place is that upstream. Cells
are equal where bodies deform, and wider and wider around it: the film reaches much farther than the
contact (of the force of an entrained rigid ball, the part beyond r falls only as 1/r).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import SuperLU, splu

from reference.arguments import count_faults, refuse
from reference.errors import ConvergenceError

Field = NDArray[np.float64]


# Each cell of the surroundings is wider than the one before by this share over the number of cells
# per unit of length: the surroundings are refined with the core, down to the least share.
SHARE = 3.0
LEAST = 0.12


@dataclass(frozen=True)
class FilmCells:
    """A tensor grid of cells with increasing edges x and y.

    The elastic body gives way below the `core` of equal cells. If `mirrored`, the cells are one
    half (y > 0) of a film that is even in y: nothing flows through the edge of smallest y. If
    `closed`, nothing flows through the edges across y at all: a film of infinite width. At all
    other edges p = 0.
    """

    x: Field
    y: Field
    core: tuple[slice, slice]
    mirrored: bool = True
    closed: bool = False

    @property
    def shape(self) -> tuple[int, int]:
        """Number of cells along x and y."""
        return self.x.size - 1, self.y.size - 1

    @property
    def copies(self) -> int:
        """How many mirror images the film consists of."""
        return 2 if self.mirrored else 1

    @cached_property
    def centres(self) -> tuple[Field, Field]:
        """The centres along x and y, as an open mesh."""
        x, y = (self.x[1:] + self.x[:-1]) / 2, (self.y[1:] + self.y[:-1]) / 2
        return x[:, None], y[None, :]

    @cached_property
    def widths(self) -> tuple[Field, Field]:
        """Sides of the cells, as an open mesh."""
        return np.diff(self.x)[:, None], np.diff(self.y)[None, :]

    @cached_property
    def area(self) -> Field:
        """Area of the cells, mirror images included."""
        across, along = self.widths
        return self.copies * across * along

    def whole(self, values: Field, *, odd: bool = False) -> Field:
        """Return values with those of the mirror images, of opposite sign where odd."""
        if not self.mirrored:
            return values
        return np.concatenate([(-1 if odd else 1) * values[:, ::-1], values], axis=1)

    @property
    def whole_core(self) -> tuple[slice, slice]:
        """The equal cells, mirror images included, where `whole` has them."""
        rows, columns = self.core
        if not self.mirrored:
            return rows, columns
        size = self.shape[1]
        return rows, slice(size - columns.stop, size + columns.stop)

    @property
    def spacing(self) -> tuple[float, float]:
        """Sides of the equal cells."""
        rows, columns = self.core
        return (
            float(self.x[rows.start + 1] - self.x[rows.start]),
            float(self.y[columns.start + 1] - self.y[columns.start]),
        )


def stretched(
    start: float, stop: float, steps: int, ends: tuple[float, float], growth: float
) -> Field:
    """Return edges: `steps` equal ones from start to stop, growing ones on to the ends."""
    inner = np.linspace(start, stop, steps + 1)
    step = inner[1] - inner[0]
    growing = []
    for length in (start - ends[0], ends[1] - stop):
        count = 0
        if length > 0:
            ratio = np.log1p(length / step * (growth - 1)) / np.log(growth)
            count = max(1, int(np.ceil(ratio)) - 1)
        edges = step * np.cumsum(growth ** np.arange(1, count + 1))
        growing.append(edges * (length / edges[-1]) if count else np.empty(0))
    return np.concatenate([(start - growing[0])[::-1], inner, stop + growing[1]])


def around_point(
    per_unit: int,
    along: tuple[float, float],
    across: float,
    reach: float,
    begins: float = np.inf,
    mirrored: bool = True,
) -> FilmCells:
    """Return the cells around a point contact, or one half of them.

    `per_unit` equal cells per unit of length lie `along` x from a beginning to an end, and `across`
    in y to either side; the whole grid has the half-width `reach`, and `begins` no farther than
    that distance along x.
    """
    refuse([] if per_unit >= 2 else [f"per_unit must be at least 2, not {per_unit!r}"])
    first, last = max(along[0], -begins), along[1]
    nx, ny = round(per_unit * (last - first)), round(per_unit * across)
    reach = max(reach, 1.01 * max(-along[0], along[1], across))
    growth = 1 + max(SHARE / per_unit, LEAST)
    x = stretched(first, last, nx, (-min(reach, begins), reach), growth)
    y = stretched(0.0, across, ny, (0.0, reach), growth)
    before = int(np.searchsorted(x, first - 0.5 / per_unit))
    rows = slice(before, before + nx)
    if mirrored:
        return FilmCells(x, y, (rows, slice(0, ny)))
    margin = y.size - 1 - ny
    whole = np.concatenate([-y[:0:-1], y])
    return FilmCells(x, whole, (rows, slice(margin, margin + 2 * ny)), mirrored=False)


Gap = Callable[[Field, Field], Field]

# Rounds in which full and ruptured cells of a rigid film may settle, and the imbalance at which
# they need not.
_ROUNDS, _BALANCED = 30, 1e-12
# Half-width of the film below a rigid cylinder, over sqrt(2 R h0).
_REACH = 1e3


@dataclass(frozen=True)
class FilmState:
    """A film: pressure and vapour, and the gap.

    `s` is p where positive, -theta where negative. The `separation` is the height that is added to
    the gap of the undeformed bodies at first touch, and the `displacement` that of the surface.
    `error` is the largest imbalance: of mass in a cell, relative to what is carried through its
    faces, or of forces, relative to the load. `history` has that of all rounds of Newton's method.
    """

    s: Field = field(repr=False)
    separation: float
    displacement: Field = field(repr=False)
    error: float = np.inf
    rounds: int = 0
    history: list[float] = field(default_factory=list, repr=False)

    @property
    def pressure(self) -> Field:
        """Pressure in the cells."""
        return np.maximum(self.s, 0.0)

    @property
    def vapour(self) -> Field:
        """Share of the gap that vapour fills."""
        return np.maximum(-self.s, 0.0)


class Film:
    """The film over cells, under a rigid gap (zero at first touch); its inlet is flooded."""

    def __init__(self, cells: FilmCells, gap: Gap) -> None:
        self.cells = cells
        x, y = cells.centres
        dx, dy = cells.widths
        self.gap = gap(x, y)
        # gap of the rigid shape and conductance (area over distance) of the faces along x and y
        self.face_gaps = gap(cells.x[:, None], y), gap(x, cells.y[None, :])
        across = _inverse_distances(cells.y)[None, :] * dx
        if cells.mirrored or cells.closed:
            across[:, 0] = 0.0
        if cells.closed:
            across[:, -1] = 0.0
        self.conductances = _inverse_distances(cells.x)[:, None] * dy, across

    def thickness(self, state: FilmState) -> Field:
        """Return the gap in the middle of the cells."""
        return self.gap + state.separation + state.displacement

    def faces(self, state: FilmState) -> tuple[Field, Field]:
        """Return the gap in the faces along x and y; ends have the displacement of their cell."""
        u = state.displacement
        ux = np.pad(u, ((1, 1), (0, 0)), mode="edge")
        uy = np.pad(u, ((0, 0), (1, 1)), mode="edge")
        return (
            self.face_gaps[0] + state.separation + (ux[1:] + ux[:-1]) / 2,
            self.face_gaps[1] + state.separation + (uy[:, 1:] + uy[:, :-1]) / 2,
        )

    def driven(self, state: FilmState) -> Field:
        """Return how much each pressure would drive out of its cell, were there none around."""
        (kx, ky), (hx, hy) = self.conductances, self.faces(state)
        along, across = kx * hx**3, ky * hy**3
        return state.pressure * (along[1:] + along[:-1] + across[:, 1:] + across[:, :-1])

    def carried(self, state: FilmState) -> Field:
        """Return the thickness of oil that is carried through the faces along x."""
        oil = self.faces(state)[0]
        oil[1:] -= state.vapour * self.thickness(state)
        return oil

    def balance(self, state: FilmState, speed: float) -> Field:
        """Return what flows out of each cell, per time, where surfaces move at L = `speed`."""
        (kx, ky), (hx, hy), p = self.conductances, self.faces(state), state.pressure
        along = -kx * hx**3 * _steps(p, 0)
        across = -ky * hy**3 * _steps(p, 1)
        along += speed * self.cells.widths[1] * self.carried(state)
        return np.diff(along, axis=0) + np.diff(across, axis=1)

    def derivatives(
        self, state: FilmState, speed: float
    ) -> tuple[sparse.csr_matrix, sparse.csr_matrix]:
        """Return the derivatives of the balance by s and by the displacement of each cell.

        That by the separation is the sum of the columns of the second.
        """
        (kx, ky), (hx, hy), p = self.conductances, self.faces(state), state.pressure
        drawn = speed * self.cells.widths[1]
        along, across = kx * hx**3, ky * hy**3
        by_p = self._flow(0, along, -along) + self._flow(1, across, -across)
        by_u = self._means(0, -3 * kx * hx**2 * _steps(p, 0) + drawn)
        by_u = by_u + self._means(1, -3 * ky * hy**2 * _steps(p, 1))
        # vapour is taken from upstream
        none, upstream = np.zeros(hx.shape), np.zeros(hx.shape)
        upstream[1:] = drawn * self.thickness(state)
        by_vapour = self._flow(0, -upstream, none)
        upstream[1:] = drawn * state.vapour
        by_u = by_u + self._flow(0, -upstream, none)
        positive = (state.s > 0).ravel()
        by_s = by_p @ sparse.diags(positive.astype(float))
        by_s = by_s - by_vapour @ sparse.diags((~positive).astype(float))
        return by_s.tocsr(), by_u.tocsr()

    def _means(self, axis: int, factor: Field) -> sparse.csr_matrix:
        """Return the matrix of diff(factor * mean u of a face) along an axis."""
        before, after = factor / 2, factor / 2
        np.moveaxis(after, axis, 0)[0] *= 2
        np.moveaxis(before, axis, 0)[-1] *= 2
        return self._flow(axis, before, after)

    def _flow(self, axis: int, before: Field, after: Field) -> sparse.csr_matrix:
        """Return the balance of flows before * (cell before) + after * (cell after) per face."""
        index = np.moveaxis(np.arange(self.gap.size).reshape(self.gap.shape), axis, 0)
        before, after = np.moveaxis(before, axis, 0), np.moveaxis(after, axis, 0)
        rows, columns, values = [], [], []
        # the flow through face k leaves cell k - 1 and enters cell k
        for row, sign, faces in ((index, 1.0, slice(1, None)), (index, -1.0, slice(0, -1))):
            b, a = sign * before[faces], sign * after[faces]
            if sign > 0:
                parts = ((row, index, b), (row[:-1], index[1:], a[:-1]))
            else:
                parts = ((row[1:], index[:-1], b[1:]), (row, index, a))
            for target, source, value in parts:
                rows.append(target.ravel())
                columns.append(source.ravel())
                values.append(value.ravel())
        entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
        size = self.gap.size
        return sparse.coo_matrix(entries, shape=(size, size)).tocsr()


def _inverse_distances(edges: Field) -> Field:
    """Return one over the distance of neighbouring centres; at the ends that to the edge."""
    centres = (edges[1:] + edges[:-1]) / 2
    return 1 / np.diff(np.concatenate([edges[:1], centres, edges[-1:]]))


def _steps(p: Field, axis: int) -> Field:
    """Return differences across the faces, p being zero beyond the ends."""
    width = [(0, 0), (0, 0)]
    width[axis] = (1, 1)
    return np.diff(np.pad(p, width), axis=axis)


class Slopes(NamedTuple):
    """Derivatives of the balance by s, by the displacement of each cell, and by the separation."""

    s: sparse.csr_matrix
    displacement: sparse.csr_matrix
    separation: Field


class Transport(Protocol):
    """What drives the flow besides pressure."""

    def balance(self, film: Film, state: FilmState) -> Field:
        """Return the volume of oil that leaves each cell per time."""

    def slopes(self, film: Film, state: FilmState) -> Slopes:
        """Return its derivatives."""

    def carried(self, film: Film, state: FilmState) -> Field:
        """Return the flow that the balance of each cell is compared with."""

    def admits(self, separation: float) -> bool:
        """Whether this flow is possible at this separation."""


@dataclass(frozen=True)
class Entrainment:
    """Surfaces that draw the film along x at the mean speed U: L = 12 eta U."""

    speed: float

    def balance(self, film: Film, state: FilmState) -> Field:
        """Return the volume of oil that leaves each cell per time."""
        return film.balance(state, self.speed)

    def slopes(self, film: Film, state: FilmState) -> Slopes:
        """Return its derivatives."""
        by_s, by_displacement = film.derivatives(state, self.speed)
        return Slopes(by_s, by_displacement, np.asarray(by_displacement.sum(axis=1)).ravel())

    def carried(self, film: Film, state: FilmState) -> Field:
        """Return what is carried through a face of each cell."""
        return self.speed * film.cells.widths[1] * film.thickness(state)

    def admits(self, separation: float) -> bool:
        """Return True: it is possible at any separation."""
        return True


@dataclass(frozen=True)
class Approach:
    """Bodies that approach at a speed V, L = 12 eta V: one step in time.

    `before` is the film one step ago, `earlier` two steps ago. The separation is the clock: it
    falls by V dt. Its derivative is a backward difference of second order on steps of any size (of
    first order where only one earlier film is known).
    """

    speed: float
    before: FilmState
    earlier: FilmState | None = None

    def balance(self, film: Film, state: FilmState) -> Field:
        """Return the volume of oil that leaves each cell per time, and what it stores."""
        flow = film.balance(state, 0.0)
        fall = self.before.separation - state.separation
        own, *others = self._weights(fall)
        kept = own * _oil(film, state)
        for weight, past in zip(others, (self.before, self.earlier), strict=False):
            assert past is not None
            kept = kept + weight * _oil(film, past)
        return flow + self.speed * film.cells.area / film.cells.copies * kept

    def slopes(self, film: Film, state: FilmState) -> Slopes:
        """Return its derivatives; that by the separation includes the weights of the difference."""
        by_s, by_displacement = film.derivatives(state, 0.0)
        fall = self.before.separation - state.separation
        step = 1e-6 * fall
        area = (self.speed * film.cells.area / film.cells.copies).ravel()
        own, *_ = self._weights(fall)
        oil = [_oil(film, past) for past in (state, self.before, self.earlier) if past is not None]
        later, sooner = self._weights(fall + step), self._weights(fall - step)
        turned = sum((a - b) / (2 * step) * q for a, b, q in zip(later, sooner, oil, strict=True))
        by_oil = area * own
        empty = (state.s <= 0).ravel()
        thickness = film.thickness(state).ravel()
        by_s = by_s + sparse.diags(np.where(empty, by_oil * thickness, 0.0))
        stored = sparse.diags(by_oil * (1 - state.vapour).ravel())
        by_displacement = by_displacement + stored
        by_separation = np.asarray(by_displacement.sum(axis=1)).ravel() - area * np.ravel(turned)
        return Slopes(by_s.tocsr(), by_displacement.tocsr(), by_separation)

    def carried(self, film: Film, state: FilmState) -> Field:
        """Return the volume that the approach displaces from each cell per time."""
        return np.broadcast_to(self.speed * film.cells.area / film.cells.copies, film.gap.shape)

    def admits(self, separation: float) -> bool:
        """Whether the bodies have come closer."""
        return separation < self.before.separation

    def _weights(self, fall: float) -> tuple[float, ...]:
        """Return the weights of this film and earlier ones in d(oil)/dt over V."""
        if self.earlier is None:
            return 1 / fall, -1 / fall
        last = self.earlier.separation - self.before.separation
        both = fall + last
        return (fall + both) / (fall * both), -both / (fall * last), fall / (last * both)


def _oil(film: Film, state: FilmState) -> Field:
    """Return the thickness of oil in each cell."""
    return (1 - state.vapour) * film.thickness(state)


def rigid_film_at(film: Film, separation: float) -> FilmState:
    """Return the film between rigid bodies at a given distance, drawn along at L = 1.

    With the gap given the equations are linear but for where the film ruptures: each round solves
    them for the cells that were full in the one before. It ends where none switches, or where only
    pressures do that are zero to round-off.
    """
    rigid = np.zeros(film.gap.shape)
    flow = Entrainment(1.0)
    # full in front of the narrowest place, ruptured behind it
    s = np.where(film.cells.centres[0] < 0, 1.0, -0.5) + rigid
    state = FilmState(s, separation, rigid)
    history: list[float] = []
    # oil that does not fit through fills the gap upstream, a cell in each round
    for rounds in range(_ROUNDS + film.gap.shape[0]):
        slopes = flow.slopes(film, state)
        change = factors(slopes.s).solve(flow.balance(film, state).ravel())
        s = state.s - change.reshape(rigid.shape)
        switched = np.count_nonzero((s > 0) != (state.s > 0))
        state = replace(state, s=s)
        error = float(np.abs(flow.balance(film, state) / flow.carried(film, state)).max())
        history.append(error)
        if not switched or error <= _BALANCED:
            return replace(state, error=error, rounds=rounds + 1, history=history)
    raise ConvergenceError("full and ruptured film do not settle", history)


@dataclass(frozen=True)
class LineFilm:
    """The film below a rigid cylinder; lengths over sqrt(2 R h0).

    `load` is W h0/(eta U R), per length. The film ruptures where p = 0 by the line through the last
    two cells of sqrt p, which falls linearly there. `x` are centres of cells, `pressure` is over
    12 eta U sqrt(2 R h0)/h0^2, and `flow`, of oil through the faces between cells, over U h0.
    """

    load: float
    rupture: float
    x: Field = field(repr=False)
    pressure: Field = field(repr=False)
    flow: Field = field(repr=False)


def rigid_cylinder(resolution: int) -> LineFilm:
    """Return the film below a rigid cylinder on a rigid plane, at its least thickness h0.

    It judges the cells: its load and its rupture are known in closed form.

    On so many cells per sqrt(2 R h0), and as far as a thousand of these lengths to either side.

    Examples
    --------
    >>> film = rigid_cylinder(32)
    >>> round(film.load, 2), round(film.rupture, 2)
    (4.9, 0.47)
    """
    refuse(count_faults(2, resolution=resolution))
    # across the line: equal cells next to it
    edges = stretched(-2.0, 2.0, 4 * resolution, (-_REACH, _REACH), 1 + SHARE / 2 / resolution)
    core = slice(0, edges.size - 1), slice(0, 1)
    cells = FilmCells(edges, np.array([0.0, 1.0]), core, mirrored=False, closed=True)
    film = Film(cells, lambda x, y: x**2 + 0 * y)
    state = rigid_film_at(film, 1.0)
    x, pressure = cells.centres[0].ravel(), state.pressure.ravel()
    last = int(np.flatnonzero(pressure)[-1])
    before, root = np.sqrt(pressure[last - 1]), np.sqrt(pressure[last])
    driven = (film.conductances[0] * film.faces(state)[0] ** 3).ravel()
    falls = np.diff(np.concatenate([[0.0], pressure, [0.0]]))
    return LineFilm(
        load=24 * float(pressure @ cells.area.ravel()),
        rupture=float(x[last] + (x[last] - x[last - 1]) * root / (before - root)),
        x=x,
        pressure=pressure,
        flow=film.carried(state).ravel() - driven * falls,
    )


def factors(matrix: sparse.spmatrix) -> SuperLU:
    """Factorise a matrix whose pattern is symmetric; its ordering halves time and memory."""
    return splu(
        matrix.tocsc(),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.01,
        options={"SymmetricMode": True},
    )
