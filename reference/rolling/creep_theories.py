"""Kalker's theories of rolling: the limit of small creep, computed and tabulated, and FASTSIM.

**Linear** (Kalker 1967; 1990, app. E): all of an elliptic contact sticks, and with c^2 = a b

    F_x = C11 G c^2 xi,    F_y = C22 G c^2 eta + C23 G c^3 phi,
    M_z = -C23 G c^3 eta + C33 G c^4 phi,

phi the spin. `kalker` has the coefficients of Kalker's table (table E3), to three digits.
`on_grid` computes them on the square cells of the solvers, whose error is of first order.

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

from reference.arrays import Array
from reference.errors import count_faults, poisson_faults, positive_faults, refuse
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
