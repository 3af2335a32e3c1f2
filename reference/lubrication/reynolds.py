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

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import SuperLU, splu

from reference.arrays import Array
from reference.errors import ConvergenceError, count_faults, refuse

# Each cell of the surroundings is wider than the one before by this share over the number of cells
# per unit of length: the surroundings are refined with the core, down to the least share.
SHARE = 3.0
LEAST = 0.12


class FilmCells:
    """A tensor grid of cells with increasing edges x and y.

    The elastic body gives way below the `core` of equal cells, of sides `spacing`. If `mirrored`,
    the cells are one half (y > 0) of a film that is even in y: nothing flows through the edge of
    smallest y. If `closed`, nothing flows through the edges across y at all: a film of infinite
    width. At all other edges p = 0. The `centres` and the `widths` along x and y are open meshes;
    the `area` includes mirror images, with which there are so many `copies`.
    """

    def __init__(
        self,
        x: Array,
        y: Array,
        core: tuple[slice, slice],
        *,
        mirrored: bool = True,
        closed: bool = False,
    ) -> None:
        self.x, self.y, self.core, self.mirrored, self.closed = x, y, core, mirrored, closed
        self.shape = x.size - 1, y.size - 1
        self.copies = 2 if mirrored else 1
        self.centres = (x[1:] + x[:-1])[:, None] / 2, (y[1:] + y[:-1])[None, :] / 2
        self.widths = np.diff(x)[:, None], np.diff(y)[None, :]
        self.area: Array = self.copies * self.widths[0] * self.widths[1]
        (dx, dy), (rows, columns) = self.widths, core
        self.spacing = float(dx[rows.start, 0]), float(dy[0, columns.start])

    def whole(self, values: Array, *, odd: bool = False) -> Array:
        """Return values with those of the mirror images, of opposite sign where odd."""
        if not self.mirrored:
            return values
        return np.concatenate([(-1 if odd else 1) * values[:, ::-1], values], axis=1)

    @property
    def whole_core(self) -> tuple[slice, slice]:
        """The equal cells, mirror images included, where `whole` has them."""
        if not self.mirrored:
            return self.core
        (rows, columns), size = self.core, self.shape[1]
        return rows, slice(size - columns.stop, size + columns.stop)


def stretched(
    start: float, stop: float, steps: int, ends: tuple[float, float], growth: float
) -> Array:
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


Gap = Callable[[Array, Array], Array]

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

    s: Array = field(repr=False)
    separation: float
    displacement: Array = field(repr=False)
    error: float = np.inf
    rounds: int = 0
    history: list[float] = field(default_factory=list, repr=False)

    @property
    def pressure(self) -> Array:
        """Pressure in the cells."""
        return np.maximum(self.s, 0.0)

    @property
    def vapour(self) -> Array:
        """Share of the gap that vapour fills."""
        return np.maximum(-self.s, 0.0)


class Film:
    """The film over cells, under a rigid gap (zero at first touch); its inlet is flooded.

    Faces, flat, are those along x and then those along y. From cells to faces `steps` take the
    differences, of values that are zero beyond the ends, `means` the mean, at an end the value of
    its cell, and `upstream` the value of the cell before a face along x.
    """

    def __init__(self, cells: FilmCells, gap: Gap) -> None:
        self.cells = cells
        (nx, ny), (x, y), (dx, dy) = cells.shape, cells.centres, cells.widths
        self.gap = gap(x, y)
        self.face_gaps = _flat(gap(cells.x[:, None], y), gap(x, cells.y[None, :]))
        # area over distance of the centres; at the ends over that to the edge
        along, across = (
            1 / np.diff(np.concatenate([edges[:1], at.ravel(), edges[-1:]]))
            for edges, at in ((cells.x, x), (cells.y, y))
        )
        if cells.mirrored or cells.closed:
            across[0] = 0.0
        if cells.closed:
            across[-1] = 0.0
        self.conductance = _flat(along[:, None] * dy, across * dx)
        self.width = _flat(np.broadcast_to(dy, (nx + 1, ny)), np.zeros((nx, ny + 1)))

        def to_faces(x_faces: sparse.sparray, y_faces: sparse.sparray) -> sparse.csr_array:
            both = (
                sparse.kron(x_faces, sparse.eye_array(ny)),
                sparse.kron(sparse.eye_array(nx), y_faces),
            )
            return sparse.csr_array(sparse.vstack(both))

        own, before = ([sparse.eye_array(n + 1, n, k=k) for n in (nx, ny)] for k in (0, -1))
        self.steps = to_faces(own[0] - before[0], own[1] - before[1])
        both = to_faces(own[0] + before[0], own[1] + before[1])
        self.means = sparse.csr_array(sparse.diags_array(1 / both.sum(axis=1)) @ both)
        self.upstream = to_faces(before[0], 0 * before[1])

    def thickness(self, state: FilmState) -> Array:
        """Return the gap in the middle of the cells."""
        return self.gap + state.separation + state.displacement

    def oil(self, state: FilmState) -> Array:
        """Return the thickness of oil in each cell."""
        return (1 - state.vapour) * self.thickness(state)

    def faces(self, state: FilmState) -> Array:
        """Return the gap in the faces."""
        return self.face_gaps + state.separation + self.means @ state.displacement.ravel()

    def driven(self, state: FilmState) -> Array:
        """Return how much each pressure would drive out of its cell, were there none around."""
        around = np.abs(self.steps).T @ (self.conductance * self.faces(state) ** 3)
        return state.pressure * around.reshape(self.gap.shape)

    def flow(self, state: FilmState, speed: float) -> Array:
        """Return what flows through each face, per time, where surfaces move at L = `speed`."""
        h = self.faces(state)
        carried = h - self.upstream @ (state.vapour * self.thickness(state)).ravel()
        pushed = self.conductance * h**3 * (self.steps @ state.pressure.ravel())
        return speed * self.width * carried - pushed


def _flat(along: Array, across: Array) -> Array:
    return np.concatenate([along.ravel(), across.ravel()])


class Slopes(NamedTuple):
    """Derivatives of the balance by s, by the displacement of each cell, and by the separation."""

    s: sparse.csr_array
    displacement: sparse.csr_array
    separation: Array


@dataclass(frozen=True)
class Transport:
    """What drives a film besides pressure, and what a thicker one keeps.

    Surfaces draw it along x at the mean speed U, L = 12 eta U (`speed`); or bodies approach at V,
    L = 12 eta V (`approach`), one step in time after the films of the `past`, one and two steps
    ago. The separation is the clock: it falls by V dt. Its derivative is a backward difference of
    second order on steps of any size.
    """

    speed: float
    approach: float = 0.0
    past: tuple[FilmState, ...] = ()

    def balance(self, film: Film, state: FilmState) -> Array:
        """Return the volume of oil that leaves each cell per time, and what it stores."""
        leaving = -(film.steps.T @ film.flow(state, self.speed)).reshape(film.gap.shape)
        if not self.past:
            return leaving
        weights = self._weights(self.past[0].separation - state.separation)
        kept = sum(w * film.oil(s) for w, s in zip(weights, (state, *self.past), strict=True))
        return leaving + self.carried(film, state) * kept

    def slopes(self, film: Film, state: FilmState) -> Slopes:
        """Return its derivatives; that by the separation includes the weights of the difference."""
        diagonal, h, drawn = sparse.diags_array, film.faces(state), self.speed * film.width
        steep = film.conductance * h**2
        upstream = diagonal(drawn) @ film.upstream
        full, thickness = (state.s > 0).ravel(), film.thickness(state).ravel()
        by_s = diagonal(steep * h) @ film.steps @ diagonal(full.astype(float))
        by_s -= upstream @ diagonal(np.where(full, 0.0, thickness))
        by_s = sparse.csr_array(film.steps.T @ by_s)
        by_u = diagonal(3 * steep * (film.steps @ state.pressure.ravel()) - drawn) @ film.means
        by_u += upstream @ diagonal(state.vapour.ravel())
        by_u = sparse.csr_array(film.steps.T @ by_u)
        if not self.past:
            return Slopes(by_s, by_u, by_u.sum(axis=1))
        fall, area = self.past[0].separation - state.separation, self.carried(film, state).ravel()
        step, by_oil = 1e-6 * fall, area * self._weights(fall)[0]
        sides = self._weights(fall + step), self._weights(fall - step), (state, *self.past)
        turned = sum((a - b) / (2 * step) * film.oil(s) for a, b, s in zip(*sides, strict=True))
        by_s = by_s + diagonal(by_oil * np.where(full, 0.0, thickness))
        by_u = sparse.csr_array(by_u + diagonal(by_oil * (1 - state.vapour).ravel()))
        return Slopes(sparse.csr_array(by_s), by_u, by_u.sum(axis=1) - area * np.ravel(turned))

    def carried(self, film: Film, state: FilmState) -> Array:
        """Return what the balance of each cell is compared with, per time.

        The flow through a face, or what the approach displaces.
        """
        if self.past:
            volume = self.approach * film.cells.area / film.cells.copies
            return np.broadcast_to(volume, film.gap.shape)
        return self.speed * film.cells.widths[1] * film.thickness(state)

    def admits(self, separation: float) -> bool:
        """Whether it is possible at this separation: bodies that approach have come closer."""
        return not self.past or separation < self.past[0].separation

    def _weights(self, fall: float) -> tuple[float, ...]:
        """Weights of the oil of the last three films in d(oil)/dt over V."""
        last = self.past[1].separation - self.past[0].separation
        both = fall + last
        return (fall + both) / (fall * both), -both / (fall * last), fall / (last * both)


def rigid_film_at(film: Film, separation: float) -> FilmState:
    """Return the film between rigid bodies at a given distance, drawn along at L = 1.

    The equations are linear but for where the film ruptures: each round solves them for the cells
    that were full in the one before, until only pressures switch that are zero to round-off.
    """
    rigid = np.zeros(film.gap.shape)
    flow = Transport(1.0)
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
    x: Array = field(repr=False)
    pressure: Array = field(repr=False)
    flow: Array = field(repr=False)


def rigid_cylinder(resolution: int) -> LineFilm:
    """Return the film below a rigid cylinder on a rigid plane, at its least thickness h0.

    On so many cells per sqrt(2 R h0), which it judges: load and rupture are known in closed form.

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
    return LineFilm(
        load=24 * float(pressure @ cells.area.ravel()),
        rupture=float(x[last] + (x[last] - x[last - 1]) * root / (before - root)),
        x=x,
        pressure=pressure,
        flow=film.flow(state, 1.0)[: edges.size],
    )


def factors(matrix: sparse.sparray) -> SuperLU:
    """Factorise a matrix whose pattern is symmetric; its ordering halves time and memory."""
    return splu(
        matrix.tocsc(),
        permc_spec="MMD_AT_PLUS_A",
        panel_size=1,
        diag_pivot_thresh=0.01,
        options={"SymmetricMode": True},
    )
