"""Steady sliding contact of a rigid rough body on a viscoelastic half-space.

Find p >= 0 with clearance c = g - d + A p >= 0 and p c = 0, A the travelling operator. A is not
symmetric, so there is no energy to minimise and conjugate gradients do not apply; but its symmetric
part is positive definite, so the solution is unique (a linear complementarity problem with a
P-matrix; Cottle, Pang & Stone 1992), found by pivoting (`reference.contact.pivot`). Changing all
cells at once can cycle here, because pressure on a cell displaces the cells behind it more than the
cell itself. Causes are ahead of their effects, so only the foremost wrong cells of every row are
changed per round, and in Murty's order the foremost cell of all. Coarser grids give the start.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from reference.arguments import refuse
from reference.contact.pivot import Pivoted, pivot
from reference.errors import ConvergenceError
from reference.loads import Load
from reference.sliding.cells import Cells
from reference.sliding.operators import Travelling

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_COARSEST = 12  # smallest number of cells per side for a coarser grid
_ROUNDING = 1e-11  # tolerated overlap and tension, relative to penetration and largest pressure


@dataclass(frozen=True)
class SlidingContact:
    """Steady sliding along +x.

    Attributes
    ----------
    penetration, force : float
        d and F = sum of pressure times cell area.
    tangential_force : float
        F_x = sum p dg/dx dA, against the motion.
    pressure : ndarray, shape (nx, ny)
        Cell values, not negative.
    rounds : int
        Number of contact sets.
    violation : float
        Largest overlap outside the contact, or clearance in it, relative to the penetration;
        evaluated independently by FFT.
    history : list of int
        Number of wrong cells by round.
    operator : Travelling
    """

    penetration: float
    force: float
    tangential_force: float
    pressure: Array
    rounds: int
    violation: float
    operator: Travelling = field(repr=False)
    history: list[int] = field(default_factory=list, repr=False)

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


def solve(
    operator: Travelling,
    gap: ArrayLike,
    load: Load,
    *,
    slope: ArrayLike | None = None,
    start: ArrayLike | None = None,
    max_rounds: int = 400,
) -> SlidingContact:
    """Return the steady sliding of a rigid shape along +x on a viscoelastic half-space.

    Parameters
    ----------
    operator : Travelling
        Half-space, grid and speed.
    gap : array_like, shape (nx, ny)
        Initial gap g >= 0 of the rigid shape. On the free half-space the grid must contain the
        contact: displacements are positive, so there is no contact where g > d.
    load : Load
        Force or penetration, one value. On the periodic half-space the mean displacement is zero.
    slope : array_like, shape (nx, ny), optional
        dg/dx at the cell centres; default: central differences of the gap.
    start : array_like of bool, shape (nx, ny), optional
        Initial contact set; default: that of a grid of twice the spacing, recursively.
    max_rounds : int
        Limit of contact sets.

    Returns
    -------
    SlidingContact

    Raises
    ------
    ValueError
        Lists all invalid arguments.
    ConvergenceError
        If no contact set converged, or the contact reaches the edge of a free grid.

    Examples
    --------
    A paraboloid of radius 1, slowly: mu = v tau/R, half of that of the reduced model.

    >>> from reference.viscoelastic.materials import GeneralisedMaxwell
    >>> rubber = GeneralisedMaxwell.kelvin_voigt(0.25, 0.25)
    >>> x = (np.arange(-12, 12) + 0.5) / 100
    >>> half_space = Travelling((24, 24), (0.01, 0.01), rubber, 0.02)
    >>> contact = solve(half_space, (x[:, None] ** 2 + x**2) / 2, Load("force", 4e-3 / 3))
    >>> 0.7 < contact.friction_coefficient / 0.02 < 1
    True
    """
    load.one_of("force", "penetration")
    load.single()
    gap, slope = _checked(operator, gap, slope)
    cells = Cells(operator, gap)
    if start is None:
        start = _coarse_start(operator, gap, load, max_rounds)
    settled = _settled(cells, cells.of_grid(start), load, max_rounds)
    pressure, history = cells.on_grid(settled.pressures), settled.history
    if not operator.periodic and _touches_edge(pressure):
        raise ConvergenceError("the contact reaches the edge of the grid", history)
    depth = settled.depth - operator.datum * float(pressure.mean())
    clearance = gap - depth + operator.apply(pressure)
    scale = max(abs(depth), float(np.ptp(gap)) * 2.0**-40)
    inside = np.abs(clearance[pressure > 0]).max(initial=0.0)
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


def _settled(cells: Cells, start: Mask, load: Load, max_rounds: int) -> Pivoted:
    """Return the contact of the cells; depths include `Travelling.datum` times the mean."""
    area = cells.operator.cell_area * cells.copies
    mean = cells.operator.datum * cells.copies / np.prod(cells.operator.shape)
    force = load.control == "force"
    rows = cells.operator.shape[0], cells.width

    def foremost(tension: Mask, overlap: Mask) -> Mask:
        return _foremost(tension.reshape(rows), overlap.reshape(rows)).ravel()

    return pivot(
        cells.respond,
        cells.gaps,
        start,
        load.single() / area if force else load.single(),
        per_depth=0.0 if force else 1.0,
        per_pressure=1.0 if force else -mean,
        changes=foremost,
        patience=np.inf,  # a front moves on while as many cells are wrong as before
        rounding=_ROUNDING,
        max_rounds=max_rounds,
    )


@njit(cache=True)
def _foremost(tension, overlap):
    """Return the foremost wrong cells of every row: consecutive cells of the same kind."""
    change = np.zeros_like(tension)
    for j in range(tension.shape[1]):
        i = tension.shape[0] - 1
        while i >= 0 and not (tension[i, j] or overlap[i, j]):
            i -= 1
        kind = tension if i >= 0 and tension[i, j] else overlap
        while i >= 0 and kind[i, j]:
            change[i, j] = True
            i -= 1
    return change


def _coarse_start(operator: Travelling, gap: Array, load: Load, max_rounds: int) -> Mask:
    """Return the contact set on twice the spacing, or the deeper half of the geometric overlap."""
    if any(n % 2 or n < 2 * _COARSEST for n in operator.shape):
        depth = load.single()
        if load.control == "force":
            depth = _overlap_depth(operator, gap, depth)
        return gap <= max(depth / 2, gap.min())
    coarse = (gap[::2, ::2] + gap[1::2, ::2] + gap[::2, 1::2] + gap[1::2, 1::2]) / 4
    half = operator.coarser()
    cells = Cells(half, coarse)
    start = cells.of_grid(_coarse_start(half, coarse, load, max_rounds))
    loaded = cells.on_grid(_settled(cells, start, load, max_rounds).pressures) > 0
    return loaded.repeat(2, axis=0).repeat(2, axis=1)


def _overlap_depth(operator: Travelling, gap: Array, force: float) -> float:
    """Return the depth at which springs of E*/(grid width) carry the force, as a start."""
    gaps = np.sort(gap.ravel())
    width = max(n * s for n, s in zip(operator.shape, operator.spacing, strict=True))
    carried = np.arange(1, gaps.size + 1) * gaps - np.cumsum(gaps)
    carried *= operator.relaxed_modulus / width * operator.cell_area
    return float(gaps[min(int(np.searchsorted(carried, force)), gaps.size - 1)])


def _touches_edge(pressure: Array) -> bool:
    """Return whether a cell at the rim of the grid is loaded; strips have none at their sides."""
    touched = pressure[[0, -1]] > 0
    sides = pressure[:, [0, -1]] > 0
    return bool(touched.any() or (pressure.shape[1] > 1 and sides.any()))


def _checked(operator: Travelling, gap: ArrayLike, slope: ArrayLike | None) -> tuple[Array, Array]:
    """Return gap and slope as arrays, or raise one ValueError with all errors."""
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
    return gap, slope
