"""Kalker's theories of rolling: the limit of small creep, computed and tabulated, and FASTSIM.

**Linear** (Kalker 1967; 1990, app. E): all of an elliptic contact sticks, and with c^2 = a b

    F_x = C11 G c^2 xi,    F_y = C22 G c^2 eta + C23 G c^3 phi,
    M_z = -C23 G c^3 eta + C33 G c^4 phi,

phi the spin. `kalker` has the coefficients of Kalker's table (table E3), to three digits.
`creep_coefficients` computes them: the contact is cut into strips along the rolling direction, each
as long as its area requires, and these into cells that are fine at both ends, x = h sin. The error
is of second order in the cells, and a straight line over the square of their size gives the limit.
`on_grid` has the square cells of the solvers, whose error is of first order.

**FASTSIM** (Kalker, Veh. Syst. Dyn. 11 (1982) 1): the surface is a bed of independent springs,
u = L q, of three flexibilities with which the linear limit is right: L = 8 a/(3 C G) for each
creep, L = pi a sqrt(a/b)/(4 C23 G) for spin. Strips along the rolling direction are followed from
their leading edges; the bound is mu times a parabola of the contact's force, not mu times Hertz's
pressure, with which stick and slip would not meet at the trailing edge.

G is that of two equal bodies; one elastic body on a rigid one has 2 G in its place, as here.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit

from reference.arrays import Array, Mask
from reference.errors import count_faults, poisson_faults, positive_faults, refuse
from reference.halfspace.traction import Compliance, cell_integrals
from reference.rolling.roll import Creep, TangentialSurface, Upstream, rigid_slip, steady

# a/b: 0.1 ... 1 and, by b/a, 0.9 ... 0.1; columns nu = 0, 1/4, 1/2.
_RATIOS = np.array([*np.arange(1, 11) / 10, *(10 / np.arange(9, 0, -1))])
_C11 = np.array(
    [
        [2.51, 3.31, 4.85], [2.59, 3.37, 4.81], [2.68, 3.44, 4.80], [2.78, 3.53, 4.82],
        [2.88, 3.62, 4.83], [2.98, 3.72, 4.91], [3.09, 3.81, 4.97], [3.19, 3.91, 5.05],
        [3.29, 4.01, 5.12], [3.40, 4.12, 5.20], [3.51, 4.22, 5.30], [3.65, 4.36, 5.42],
        [3.82, 4.54, 5.58], [4.06, 4.78, 5.80], [4.37, 5.10, 6.11], [4.84, 5.57, 6.57],
        [5.57, 6.34, 7.34], [6.96, 7.78, 8.82], [10.7, 11.7, 12.9],
    ]
)  # fmt: skip
_C22 = np.array(
    [
        [2.51, 2.52, 2.53], [2.59, 2.63, 2.66], [2.68, 2.75, 2.81], [2.78, 2.88, 2.98],
        [2.88, 3.01, 3.14], [2.98, 3.14, 3.31], [3.09, 3.28, 3.48], [3.19, 3.41, 3.65],
        [3.29, 3.54, 3.82], [3.40, 3.67, 3.98], [3.51, 3.81, 4.16], [3.65, 3.99, 4.39],
        [3.82, 4.21, 4.67], [4.06, 4.50, 5.04], [4.37, 4.90, 5.56], [4.84, 5.48, 6.31],
        [5.57, 6.40, 7.51], [6.96, 8.14, 9.79], [10.7, 12.8, 16.0],
    ]
)  # fmt: skip
_C23 = np.array(
    [
        [0.334, 0.473, 0.731], [0.483, 0.603, 0.809], [0.607, 0.715, 0.889], [0.72, 0.823, 0.977],
        [0.827, 0.929, 1.07], [0.93, 1.03, 1.18], [1.03, 1.14, 1.29], [1.13, 1.25, 1.40],
        [1.23, 1.36, 1.51], [1.33, 1.47, 1.63], [1.44, 1.59, 1.77], [1.58, 1.75, 1.94],
        [1.76, 1.95, 2.18], [2.01, 2.23, 2.50], [2.35, 2.62, 2.96], [2.88, 3.24, 3.70],
        [3.79, 4.32, 5.01], [5.72, 6.63, 7.89], [12.2, 14.6, 18.0],
    ]
)  # fmt: skip
_C33 = np.array(
    [
        [6.42, 8.28, 11.7], [3.46, 4.27, 5.66], [2.49, 2.96, 3.72], [2.02, 2.32, 2.77],
        [1.74, 1.93, 2.22], [1.56, 1.68, 1.86], [1.43, 1.50, 1.60], [1.34, 1.37, 1.42],
        [1.27, 1.27, 1.27], [1.21, 1.19, 1.16], [1.16, 1.11, 1.06], [1.10, 1.04, 0.954],
        [1.05, 0.965, 0.852], [1.01, 0.892, 0.751], [0.958, 0.819, 0.650], [0.912, 0.747, 0.549],
        [0.868, 0.674, 0.446], [0.828, 0.601, 0.341], [0.795, 0.526, 0.228],
    ]
)  # fmt: skip


class Coefficients(NamedTuple):
    """Kalker's coefficients: by creep along, by that across, by spin, and its moment."""

    c11: float
    c22: float
    c23: float
    c33: float


@dataclass(frozen=True)
class EllipticContact:
    """A Hertzian contact that rolls along the semi-axis a."""

    semi_axes: tuple[float, float]  # a along the rolling direction, b across
    # of the elastic body, on a rigid one
    shear_modulus: float
    poisson_ratio: float
    limit: float  # mu F

    def __post_init__(self) -> None:
        a, b = self.semi_axes
        faults = positive_faults(a=a, b=b, shear_modulus=self.shear_modulus, limit=self.limit)
        refuse(faults + poisson_faults(self.poisson_ratio))

    @property
    def coefficients(self) -> Coefficients:
        """Those of Kalker's table."""
        return kalker(self.semi_axes[0] / self.semi_axes[1], self.poisson_ratio)


@dataclass(frozen=True)
class Rolled:
    """Forces of the sign of the creep, and the area that sticks."""

    tangential_force: float
    lateral_force: float
    stick_area: float


def kalker(axis_ratio: float, poisson_ratio: float) -> Coefficients:
    """Return the coefficients of Kalker's table, a/b from 0.1 to 10, nu from 0 to 1/2.

    Between ratios of the axes linearly in their logarithm, between Poisson's ratios by a parabola.

    >>> kalker(1.0, 0.25)
    Coefficients(c11=4.12, c22=3.67, c23=1.47, c33=1.19)
    """
    faults = []
    if not 0.1 <= axis_ratio <= 10:
        faults.append(f"axis_ratio must lie between 0.1 and 10, not {axis_ratio!r}")
    if not 0 <= poisson_ratio <= 0.5:
        faults.append(f"poisson_ratio must lie between 0 and 0.5, not {poisson_ratio!r}")
    refuse(faults)
    t = poisson_ratio / 0.25
    weights = np.array([(1 - t) * (2 - t) / 2, t * (2 - t), t * (t - 1) / 2])
    place, places = np.log(axis_ratio), np.log(_RATIOS)
    values = (np.interp(place, places, table @ weights) for table in (_C11, _C22, _C23, _C33))
    return Coefficients(*(round(float(value), 12) for value in values))


def linear(
    contact: EllipticContact, creep: float, lateral_creep: float = 0.0, spin: float = 0.0
) -> Rolled:
    """Return the forces of the linear theory, beyond the limit too: it knows no friction.

    >>> round(linear(EllipticContact((1.0, 1.0), 0.5, 0.25, 1.0), 0.01).tangential_force, 12)
    0.0412
    """
    (a, b), known = contact.semi_axes, contact.coefficients
    unit = 2 * contact.shear_modulus * a * b
    across = known.c22 * lateral_creep + known.c23 * np.sqrt(a * b) * spin
    return Rolled(known.c11 * unit * creep, float(unit * across), np.pi * a * b)


def fastsim(
    contact: EllipticContact,
    creep: float,
    lateral_creep: float = 0.0,
    spin: float = 0.0,
    cells: int = 50,
) -> Rolled:
    """Return the forces of FASTSIM: `cells` strips on half the contact, steps on half a strip.

    Its linear limit is Kalker's, and full sliding the limit:

    >>> ball = EllipticContact((1.0, 1.0), 0.5, 0.25, 1.0)
    >>> round(fastsim(ball, 1e-6).tangential_force / 4.12e-6, 1)
    1.0
    >>> round(fastsim(ball, 1.0).tangential_force, 3)
    1.0
    """
    refuse(count_faults(1, cells=cells))
    (a, b), known = contact.semi_axes, contact.coefficients
    # stress per distance from the leading edge, over the highest bound, lengths over a and b
    peak = 2 * contact.limit / (np.pi * a * b)
    unit = 3 * 2 * contact.shear_modulus / (8 * peak)
    turn = 8 * contact.shear_modulus * known.c23 * spin / (np.pi * peak)
    creeps = known.c11 * unit * creep, known.c22 * unit * lateral_creep
    spins = turn * b * np.sqrt(b / a), turn * np.sqrt(a * b)
    along, across, stick = _strips(np.array([*creeps, *spins]), cells)
    total = contact.limit * 2 / np.pi
    return Rolled(along * total, across * total, stick * a * b)


@njit(cache=True)
def _strips(rates, cells):
    """Return integrals of both stresses over the bound's peak, and the sticking area, of a circle.

    Rates of stress by both creeps, and by spin at y = 1 and at x = 1.
    Between two steps the stress is that of stick up to its bound; midpoints across the strips.
    """
    along = across = stick = 0.0
    for strip in range(2 * cells):
        y = (strip + 0.5) / cells - 1
        half = np.sqrt(1 - y * y)
        step = half / cells
        x, qx, qy = half, 0.0, 0.0
        for _ in range(2 * cells):
            x -= step
            new_x = qx + (rates[0] - rates[2] * y) * step
            new_y = qy + (rates[1] + rates[3] * (x + step / 2)) * step
            bound = max(half * half - x * x, 0.0)
            size = np.hypot(new_x, new_y)
            if size > bound:
                new_x, new_y = new_x * bound / size, new_y * bound / size
            else:
                stick += step / cells
            along += (qx + new_x) / 2 * step / cells
            across += (qy + new_y) / 2 * step / cells
            qx, qy = new_x, new_y
    return along, across, stick


@dataclass(frozen=True)
class CreepCoefficients:
    """Coefficients on several grids, and their limit."""

    cells: Array  # (k,): strips on half the width, and cells on each of them
    values: Array  # (k, 4): C11, C22, C23 and C33 on the grids
    limit: Array  # (4,): by a straight line over the square of the cell size
    # (4,): largest change of the limit where one of the grids is left out, or the way from the
    # finest grid to the limit if larger
    uncertainty: Array

    @classmethod
    def of(cls, cells: tuple[int, ...], values: Array) -> CreepCoefficients:
        """Return the study of values on grids."""
        numbers = np.array(cells, dtype=float)

        def line(kept: Mask) -> Array:
            return np.array(np.polyfit(numbers[kept] ** -2, values[kept], 1)[1])

        everything = np.ones(len(cells), dtype=bool)
        limit = line(everything)
        others = [line(np.arange(len(cells)) != left) for left in range(len(cells))]
        changes = np.abs(np.array(others) - limit).max(axis=0)
        left = np.abs(values[-1] - limit)
        return cls(numbers, values, limit, np.maximum(changes, left))


def creep_coefficients(
    poisson_ratio: float, axis_ratio: float, cells: tuple[int, ...] = (10, 14, 20)
) -> CreepCoefficients:
    """Return C11, C22, C23 and C33 of the half-space.

    `axis_ratio` is a/b, a the semi-axis along which the contact rolls. `cells` are strips on
    half the width, and cells on each; three grids at least, ascending.
    """
    faults = poisson_faults(poisson_ratio) + positive_faults(axis_ratio=axis_ratio)
    if len(cells) < 3 or list(cells) != sorted(set(cells)) or cells[0] < 1:
        faults.append(f"cells must be three ascending numbers at least, not {cells!r}")
    refuse(faults)
    compliance = Compliance.of(1.0, poisson_ratio)
    values = [_on_strips(axis_ratio, count, compliance) for count in cells]
    return CreepCoefficients.of(cells, np.array(values))


def _on_strips(axis_ratio: float, count: int, compliance: Compliance) -> Array:
    """Return C11, C22, C23 and C33 from so many strips of as many cells on half of an ellipse."""
    a, b = np.sqrt(axis_ratio), 1 / np.sqrt(axis_ratio)
    edges = np.linspace(0.0, 1.0, count + 1)
    areas = np.diff(edges * np.sqrt(1 - edges**2) + np.arcsin(edges)) / 2
    half = a * count * areas  # of the length of a strip
    ends = np.sin(np.pi / 2 * np.linspace(-1.0, 1.0, count + 1))
    middle = (ends[1:] + ends[:-1]) / 2
    width = b / count
    y = (np.arange(count) + 0.5) * width
    x = half[:, None] * middle
    lengths = half[:, None] * np.diff(ends)
    # with a point ahead of each strip, from which material enters
    points = half[:, None] * np.append(middle, 2 - middle[-1])

    # u - u upstream by the tractions of cells and of their mirror images, shape (2, 3, n, n): u_x
    # by q_x, u_y by q_y, u_x by q_y
    table = np.empty((2, 3, x.size, x.size))
    c1, c2 = compliance.normal, compliance.lateral
    for source, (strip, place) in enumerate(np.ndindex(*x.shape)):
        length = float(lengths[strip, place])
        along = (points - x[strip, place]) / length
        for mirrored, at in enumerate((y[strip], -y[strip])):
            across = np.broadcast_to(((y - at) / width)[:, None], along.shape)
            cell = cell_integrals(along, across, (length, width))
            both = c1 * (cell.xx + cell.yy)
            parts = np.stack([both + c2 * cell.xx, both + c2 * cell.yy, c2 * cell.xy])
            table[mirrored, :, :, source] = -np.diff(parts, axis=2).reshape(3, -1)
    direct, image = table / (2 * np.pi)

    # the rigid slip from each cell to the next upstream, by creep along and across, and by spin,
    # (-y, x), whose integral is taken
    upstream = np.diff(points, axis=1)
    ways = np.zeros((3, 2, *upstream.shape))
    ways[0, 0] = ways[1, 1] = upstream
    ways[2] = -y[:, None] * upstream, np.diff(points**2, axis=1) / 2

    # tractions of full stick; their sums over 2 G, c = 1
    forces: list[float] = []
    for parity, chosen in ((1, ways[:1]), (-1, ways[1:])):
        # q_x has this parity in y, and q_y the other one
        xx, yy, xy, yx = (
            direct[part] + sign * parity * image[part]
            for part, sign in ((0, 1), (1, -1), (2, -1), (2, 1))
        )
        matrix = np.block([[xx, xy], [yx, yy]])
        tractions = np.linalg.solve(matrix, chosen.reshape(len(chosen), -1).T)
        for traction in tractions.T.reshape(-1, 2, *x.shape):
            sums = 2 * width * (traction * lengths).sum(axis=(1, 2))
            forces.append(float(sums[(1 - parity) // 2]))
    turning = traction[1] * x - traction[0] * y[:, None]  # by spin, the last
    forces.append(2 * width * float((turning * lengths).sum()))
    return np.array(forces) / 2


def on_grid(
    surface: Callable[[tuple[int, int], float], TangentialSurface], axis_ratio: float, cells: int
) -> Array:
    """Return C11, C22, C23 and C33 on one grid.

    ``surface(shape, side)`` is an elastic surface of G = 1 on square cells, so many per shorter
    semi-axis. The area that is counted takes the place of pi a b.
    """
    a, b = np.sqrt(axis_ratio), 1 / np.sqrt(axis_ratio)
    side = min(a, b) / cells
    half = [int(np.ceil(axis / side)) for axis in (a, b)]
    # a row ahead, from which material enters, and one behind: the spin is about the middle
    x = (np.arange(-half[0] - 1, half[0] + 1) + 0.5) * side
    y = (np.arange(-half[1], half[1]) + 0.5) * side
    inside = (x[:, None] / a) ** 2 + (y / b) ** 2 < 1
    flow, stuck = Upstream(surface(inside.shape, side), inside.shape), np.where(inside, np.inf, 0.0)
    along, across, spin = (
        steady(flow, stuck, rigid_slip(Creep(*one), inside.shape, (side, side))).traction
        for one in np.eye(3).tolist()
    )
    turning = (spin[1] * x[:, None] - spin[0] * y).sum()
    forces = np.array([along[0].sum(), across[1].sum(), spin[1].sum(), turning])
    # F = C 2 G c^2, c^3 or c^4
    return forces * side**2 / (2 * (inside.sum() * side**2 / np.pi) ** np.array([1, 1, 1.5, 2]))
