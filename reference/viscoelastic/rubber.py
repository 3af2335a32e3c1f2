"""Steady sliding contact of a rigid rough body on a viscoelastic half-space.

Find p >= 0 with clearance c = g - d + A p >= 0 and p c = 0, A the travelling operator. A is not
symmetric, so there is no energy to minimise and conjugate gradients do not apply; but its symmetric
part is positive definite, so the solution is unique (a linear complementarity problem with a
P-matrix; Cottle, Pang & Stone 1992), found by pivoting (`reference.contact.pivot`). Changing all
cells at once can cycle here, because pressure on a cell displaces the cells behind it more than the
cell itself. Causes are ahead of their effects, so only the foremost wrong cells of every row are
changed per round, and in Murty's order the foremost cell of all. Coarser grids give the start.
Contact sets are small, so the equations are factorised: Krylov methods need hundreds of products.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import lu_factor, lu_solve

from reference.arrays import Array, Indices, Mask
from reference.contact.pivot import Pivoted, bordered, pivot
from reference.errors import ConvergenceError, refuse
from reference.loads import Load
from reference.viscoelastic.materials import GeneralisedMaxwell
from reference.viscoelastic.travelling import Travelling

LIMIT = 9000
"""Largest number of contact cells for a factorisation: 650 MB and about 20 s."""

_COARSEST = 12  # smallest number of cells per side for a coarser grid
_ROUNDING = 1e-11  # tolerated overlap and tension, relative to penetration and largest pressure


@dataclass(frozen=True)
class SlidingContact:
    """Steady sliding along +x."""

    penetration: float
    force: float
    tangential_force: float  # F_x = sum p dg/dx dA, against the motion
    pressure: Array  # (nx, ny): cell values, not negative
    rounds: int  # number of contact sets
    # largest overlap, or clearance in contact, relative to the penetration; by FFT
    violation: float
    operator: Travelling = field(repr=False)
    history: list[int] = field(default_factory=list, repr=False)  # number of wrong cells by round

    @property
    def friction_coefficient(self) -> float:
        """F_x/F."""
        return self.tangential_force / self.force

    @property
    def mask(self) -> Mask:
        """Cells in contact."""
        return self.pressure > 0

    @property
    def contact_area(self) -> float:
        """Contact area by counted cells."""
        return float(np.count_nonzero(self.mask)) * self.operator.cell_area


def slide_on_rubber(
    operator: Travelling,
    gap: ArrayLike,
    load: Load,
    *,
    slope: ArrayLike | None = None,
    start: ArrayLike | None = None,
) -> SlidingContact:
    """Return the steady sliding of a rigid shape along +x on a viscoelastic half-space.

    On the free half-space the grid must contain the contact, which lies where g < d. On the
    periodic one the mean displacement is zero. `slope` is dg/dx at the cell centres, by default by
    central differences; `start` is the initial contact set, by default that of a grid of twice the
    spacing, recursively.

    A paraboloid of radius 1, slowly: mu = v tau/R, half of that of the reduced model.

    >>> from reference.viscoelastic.materials import GeneralisedMaxwell
    >>> rubber = GeneralisedMaxwell.kelvin_voigt(0.25, 0.25)
    >>> x = (np.arange(-12, 12) + 0.5) / 100
    >>> half_space = Travelling((24, 24), (0.01, 0.01), rubber, 0.02)
    >>> ball = (x[:, None] ** 2 + x**2) / 2
    >>> contact = slide_on_rubber(half_space, ball, Load("force", 4e-3 / 3))
    >>> 0.7 < contact.friction_coefficient / 0.02 < 1
    True
    """
    load.one_of("force", "penetration")
    load.single()
    gap = np.asarray(gap, dtype=float)
    faults = []
    if gap.shape != operator.shape:
        faults.append(f"gap has shape {gap.shape}, the operator {operator.shape}")
    elif not (np.isfinite(gap).all() and (gap >= 0).all()):
        faults.append("gap must be finite and not negative")
    if slope is None and gap.ndim == 2 and gap.shape[0] > 1:
        slope = np.gradient(gap, operator.spacing[0], axis=0)
        if operator.periodic:
            slope = (np.roll(gap, -1, 0) - np.roll(gap, 1, 0)) / (2 * operator.spacing[0])
    slope = np.zeros(gap.shape) if slope is None else np.asarray(slope, dtype=float)
    if slope.shape != gap.shape or not np.isfinite(slope).all():
        faults.append(f"slope must be finite, of the shape of the gap, got shape {slope.shape}")
    refuse(faults)

    cells = _Cells(operator, gap)
    if start is None:
        start = _coarse_start(operator, gap, load)
    settled = _settled(cells, cells.of_grid(start), load)
    pressure, history = cells.on_grid(settled.pressures), settled.history
    loaded = pressure > 0
    # strips have no cells at their sides
    edges = loaded[[0, -1]].any() or (loaded.shape[1] > 1 and loaded[:, [0, -1]].any())
    if edges and not operator.periodic:
        raise ConvergenceError("the contact reaches the edge of the grid", history)
    depth = settled.depth - operator.datum * float(pressure.mean())
    clearance = gap - depth + operator.apply(pressure)
    scale = max(abs(depth), float(np.ptp(gap)) * 2.0**-40)
    inside = np.abs(clearance[loaded]).max(initial=0.0)
    return SlidingContact(
        penetration=depth,
        force=float(pressure.sum() * operator.cell_area),
        tangential_force=float((pressure * slope).sum() * operator.cell_area),
        pressure=pressure,
        rounds=len(history),
        violation=float(max(inside, -clearance.min()) / scale),
        operator=operator,
        history=history,
    )


class _Cells:
    """All cells of a grid, or one half of them if grid and gap are mirror images in y."""

    def __init__(self, operator: Travelling, gap: Array) -> None:
        self.operator = operator
        self.mirrored = gap.shape[1] % 2 == 0 and bool(np.array_equal(gap, gap[:, ::-1]))
        self.copies = 2 if self.mirrored else 1
        self.width = gap.shape[1] // self.copies
        self.gaps = np.ascontiguousarray(gap[:, : self.width]).ravel()

    def of_grid(self, values: ArrayLike) -> NDArray:
        """Return the values of the cells from those of the grid."""
        return np.asarray(values)[:, : self.width].ravel().copy()

    def on_grid(self, values: Array) -> Array:
        """Return the values on the whole grid."""
        half = values.reshape(-1, self.width)
        return np.hstack([half, half[:, ::-1]]) if self.mirrored else half

    def displacement(self, inside: Indices, pressures: Array) -> Array:
        """Return A p of all cells, `Travelling.datum` included, which makes A definite."""
        whole = np.zeros((pressures.shape[1], self.gaps.size))
        whole[:, inside] = pressures.T
        fields = [self.on_grid(p) for p in whole]
        lifts = [self.operator.datum * float(pressure.mean()) for pressure in fields]
        moved = [self.of_grid(self.operator.apply(pressure)) for pressure in fields]
        return np.stack(moved, axis=1) + lifts

    def factorised(self, inside: Indices) -> Callable[[Array], Array]:
        if inside.size > LIMIT:
            raise ConvergenceError(
                f"{inside.size} cells in contact exceed the limit of {LIMIT}: use a coarser grid"
            )
        matrix = self.coefficients(inside, inside)
        factor = lu_factor(matrix, overwrite_a=True, check_finite=False)
        return partial(lu_solve, factor, overwrite_b=True, check_finite=False)

    def coefficients(self, points: Indices, loaded: Indices) -> Array:
        places = *np.divmod(points, self.width), *np.divmod(loaded, self.width)
        return _matrix(*places, self.operator.table, self.mirrored, self.operator.shape[1])


@njit(cache=True)
def _matrix(rows, columns, loaded_rows, loaded_columns, table, mirrored, width):
    """Return the displacements of cells under unit pressure on cells (and their mirror images)."""
    nx, ny = table.shape
    matrix = np.empty((rows.size, loaded_rows.size))
    for a in range(rows.size):
        for b in range(loaded_rows.size):
            i, j = (rows[a] - loaded_rows[b]) % nx, (columns[a] - loaded_columns[b]) % ny
            value = table[i, j]
            if mirrored:
                value += table[i, (columns[a] + loaded_columns[b] - width + 1) % ny]
            matrix[a, b] = value
    return matrix


def _settled(cells: _Cells, start: Mask, load: Load) -> Pivoted:
    """Return the contact of the cells; depths include `Travelling.datum` times the mean."""
    area = cells.operator.cell_area * cells.copies
    mean = cells.operator.datum * cells.copies / np.prod(cells.operator.shape)
    force = load.control == "force"
    return pivot(
        bordered(cells.coefficients, cells.factorised, cells.displacement, 1 / 4),
        cells.gaps,
        start,
        load.single() / area if force else load.single(),
        per_depth=0.0 if force else 1.0,
        per_pressure=1.0 if force else -mean,
        changes=partial(_foremost, cells.width),
        patience=np.inf,  # a front moves on while as many cells are wrong as before
        rounding=_ROUNDING,
        max_rounds=400,
    )


@njit(cache=True)
def _foremost(width, tension, overlap):
    """Return the foremost wrong cells of every row: consecutive cells of the same kind."""
    change = np.zeros_like(tension)
    for column in range(width):
        i = tension.size - width + column
        while i >= 0 and not (tension[i] or overlap[i]):
            i -= width
        kind = tension if i >= 0 and tension[i] else overlap
        while i >= 0 and kind[i]:
            change[i] = True
            i -= width
    return change


def _coarse_start(operator: Travelling, gap: Array, load: Load) -> Mask:
    """Return the contact set on twice the spacing, or the deeper half of the geometric overlap."""
    if any(n % 2 or n < 2 * _COARSEST for n in operator.shape):
        depth = load.single()
        if load.control == "force":
            # the depth at which springs of E*/(grid width) carry the force
            gaps = np.sort(gap.ravel())
            width = max(n * s for n, s in zip(operator.shape, operator.spacing, strict=True))
            carried = np.arange(1, gaps.size + 1) * gaps - np.cumsum(gaps)
            carried *= 4 * operator.material.equilibrium_modulus / width * operator.cell_area
            depth = float(gaps[min(int(np.searchsorted(carried, depth)), gaps.size - 1)])
        return gap <= max(depth / 2, gap.min())
    coarse = (gap[::2, ::2] + gap[1::2, ::2] + gap[::2, 1::2] + gap[1::2, 1::2]) / 4
    half = operator.coarser()
    cells = _Cells(half, coarse)
    start = cells.of_grid(_coarse_start(half, coarse, load))
    loaded = cells.on_grid(_settled(cells, start, load).pressures) > 0
    return loaded.repeat(2, axis=0).repeat(2, axis=1)


_COARSE = 24  # cells across the window on which a depth is determined from a force
_SECANTS = 30


def slide_shape(
    gap: Callable[[Array, Array], Array],
    window: tuple[float, float],
    material: GeneralisedMaxwell,
    speed: float,
    cells: int,
    load: Load,
) -> SlidingContact:
    """Return the sliding of a shape on square cells around the origin, with slopes over a cell.

    `window` has half-widths that contain the contact; so many cells lie across its wider side,
    and up to 8 more than needed across the other one.
    """
    step = 2 * max(window) / cells
    shape = [8 * max(1, int(np.ceil(half / (4 * step) - 1e-9))) for half in window]
    rows, columns = (np.asarray((np.arange(n) - (n - 1) / 2) * step, float) for n in shape)
    x, y = rows[:, None], columns[None, :]
    slope = (gap(x + step / 2, y) - gap(x - step / 2, y)) / step
    operator = Travelling((shape[0], shape[1]), (step, step), material, speed)
    return slide_on_rubber(operator, gap(x, y), load, slope=slope)


def window_depth(
    gap: Callable[[Array, Array], Array],
    reach: Callable[[float], tuple[float, float]],
    material: GeneralisedMaxwell,
    speed: float,
    load: Load,
) -> float:
    """Return a depth whose overlap contains the contact: the penetration, or 5 % above the need.

    That of a force is computed on a coarse grid, by secant steps in logarithms.
    """
    force = load.single()
    if load.one_of("force", "penetration") == "penetration":
        return force

    def excess(depth: float) -> float:
        contact = slide_shape(
            gap, reach(depth), material, speed, _COARSE, Load("penetration", depth)
        )
        return float(np.log(contact.force / force))

    # a disc of E* under the force: 2 E* a d, with the overlap's own width for a
    depth = 1.0
    for _ in range(_SECANTS):
        depth = force / (8 * material.equilibrium_modulus * max(reach(depth)))
    history: list[float] = []
    exponent, before = 1.5, None
    for _ in range(_SECANTS):
        ratio = excess(depth)
        history.append(abs(ratio))
        if history[-1] < 0.01:
            return 1.05 * depth
        if before is not None and ratio != before[1]:
            slope = (ratio - before[1]) / float(np.log(depth / before[0]))
            exponent = min(max(slope, 0.5), 3.0)
        before = depth, ratio
        depth *= float(np.exp(-ratio / exponent))
    raise ConvergenceError("no depth of the shape carries the force", history)
