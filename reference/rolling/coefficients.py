"""Creep coefficients of elliptic contacts: the limit of vanishing slip.

Kalker's linear theory (1967; 1990, app. E), where all of the contact sticks, is with c^2 = a b

    F_x = C11 G c^2 xi,    F_y = C22 G c^2 eta + C23 G c^3 phi,
    M_z = -C23 G c^3 eta + C33 G c^4 phi,

phi the spin. G is that of two equal bodies; one elastic body on a rigid one has 2 G in its place,
as here.

The contact is cut into strips along the rolling direction, each as long as its area requires, and
these into cells that are fine at both ends, x = h sin: tractions grow as a square root from the
leading edge, and without slip they are unbounded at the trailing edge. With neither steps along the
outline nor coarse cells at its ends the error is of second order in the cells, and a straight line
over the square of their size gives the limit. `on_grid` has the square cells of the solvers, whose
error is of first order.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reference.arguments import poisson_faults, positive_faults, refuse
from reference.halfspace.cerruti import Compliance, cell_integrals
from reference.rolling.roll import Creep, TangentialSurface, Upstream, rigid_slip, steady

Array = NDArray[np.float64]

_CELLS = (10, 14, 20)
_ONE_OF_EACH = (Creep(1.0), Creep(0.0, 1.0), Creep(0.0, 0.0, 1.0))


@dataclass(frozen=True)
class CreepCoefficients:
    """Coefficients on several grids, and their limit.

    Attributes
    ----------
    cells : ndarray, shape (k,)
        Strips on half the width, and cells on each of them.
    values : ndarray, shape (k, 4)
        C11, C22, C23 and C33 on the grids.
    limit : ndarray, shape (4,)
        By a straight line over the square of the cell size.
    uncertainty : ndarray, shape (4,)
        Largest change of the limit where one of the grids is left out, or the way from the finest
        grid to the limit if larger.
    """

    cells: Array
    values: Array
    limit: Array
    uncertainty: Array

    @classmethod
    def of(cls, cells: tuple[int, ...], values: Array) -> CreepCoefficients:
        """Return the study of values on grids."""
        numbers = np.array(cells, dtype=float)

        def line(kept: NDArray[np.bool_]) -> Array:
            return np.array(np.polyfit(numbers[kept] ** -2, values[kept], 1)[1])

        everything = np.ones(len(cells), dtype=bool)
        limit = line(everything)
        others = [line(np.arange(len(cells)) != left) for left in range(len(cells))]
        changes = np.abs(np.array(others) - limit).max(axis=0)
        left = np.abs(values[-1] - limit)
        return cls(numbers, values, limit, np.maximum(changes, left))


def creep_coefficients(
    poisson_ratio: float, axis_ratio: float, cells: tuple[int, ...] = _CELLS
) -> CreepCoefficients:
    """Return C11, C22, C23 and C33 of the half-space.

    Parameters
    ----------
    poisson_ratio : float
    axis_ratio : float
        a/b, a the semi-axis along which the contact rolls.
    cells : tuple of int
        Strips on half the width, and cells on each; three grids at least, ascending.

    Examples
    --------
    >>> circle = creep_coefficients(0.25, 1.0, (4, 6, 8))
    >>> bool(abs(circle.limit[0] / 4.12 - 1) < 0.005)
    True
    """
    faults = poisson_faults(poisson_ratio) + positive_faults(axis_ratio=axis_ratio)
    if len(cells) < 3 or list(cells) != sorted(set(cells)) or cells[0] < 1:
        faults.append(f"cells must be three ascending numbers at least, not {cells!r}")
    refuse(faults)
    compliance = Compliance.of(1.0, poisson_ratio)
    values = [_Strips(axis_ratio, count).coefficients(compliance) for count in cells]
    return CreepCoefficients.of(cells, np.array(values))


class _Strips:
    """One half of an elliptic contact of area pi, in strips along the way of rolling.

    Parameters
    ----------
    axis_ratio : float
    count : int
        Strips, and cells on each.
    """

    def __init__(self, axis_ratio: float, count: int) -> None:
        a, b = np.sqrt(axis_ratio), 1 / np.sqrt(axis_ratio)
        edges = np.linspace(0.0, 1.0, count + 1)
        areas = np.diff(edges * np.sqrt(1 - edges**2) + np.arcsin(edges)) / 2
        half = a * count * areas  # of the length of a strip
        ends = np.sin(np.pi / 2 * np.linspace(-1.0, 1.0, count + 1))
        middle = (ends[1:] + ends[:-1]) / 2
        self.width = b / count
        self.y = (np.arange(count) + 0.5) * self.width
        self.x = half[:, None] * middle
        self.lengths = half[:, None] * np.diff(ends)
        # with a point ahead of each strip, from which material enters
        self.points = half[:, None] * np.append(middle, 2 - middle[-1])

    def coefficients(self, compliance: Compliance) -> Array:
        """Return C11, C22, C23 and C33, c = 1: sums of the tractions of full stick over 2 G."""
        direct, image = self._differences(compliance)
        along, across, spin = self._ways()
        forces: list[float] = []
        for parity, ways in ((1, [along]), (-1, [across, spin])):
            # q_x has this parity in y, and q_y the other one
            xx, yy, xy, yx = (
                direct[part] + sign * parity * image[part]
                for part, sign in ((0, 1), (1, -1), (2, -1), (2, 1))
            )
            matrix = np.block([[xx, xy], [yx, yy]])
            tractions = np.linalg.solve(matrix, np.array(ways).reshape(len(ways), -1).T)
            for traction in tractions.T.reshape(-1, 2, *self.x.shape):
                sums = 2 * self.width * (traction * self.lengths).sum(axis=(1, 2))
                forces.append(float(sums[(1 - parity) // 2]))
        turning = traction[1] * self.x - traction[0] * self.y[:, None]  # by spin, the last
        forces.append(2 * self.width * float((turning * self.lengths).sum()))
        return np.array(forces) / 2

    def _ways(self) -> Array:
        """Return the rigid slip from each cell to the next upstream, shape (3, 2, *cells).

        By creep along and across, and by spin, (-y, x), whose integral is taken.
        """
        upstream = np.diff(self.points, axis=1)
        ways = np.zeros((3, 2, *upstream.shape))
        ways[0, 0] = ways[1, 1] = upstream
        ways[2] = -self.y[:, None] * upstream, np.diff(self.points**2, axis=1) / 2
        return ways

    def _differences(self, compliance: Compliance) -> Array:
        """Return u - u upstream by the tractions of cells and of their mirror images.

        Shape (2, 3, n, n): u_x by q_x, u_y by q_y, u_x by q_y.
        """
        table = np.empty((2, 3, self.x.size, self.x.size))
        c1, c2 = compliance.normal, compliance.lateral
        for source, (strip, place) in enumerate(np.ndindex(*self.x.shape)):
            length = float(self.lengths[strip, place])
            along = (self.points - self.x[strip, place]) / length
            for mirrored, y in enumerate((self.y[strip], -self.y[strip])):
                across = np.broadcast_to(((self.y - y) / self.width)[:, None], along.shape)
                cell = cell_integrals(along, across, (length, self.width))
                both = c1 * (cell.xx + cell.yy)
                parts = np.stack([both + c2 * cell.xx, both + c2 * cell.yy, c2 * cell.xy])
                table[mirrored, :, :, source] = -np.diff(parts, axis=2).reshape(3, -1)
        return table / (2 * np.pi)


def on_grid(
    surface: Callable[[tuple[int, int], float], TangentialSurface], axis_ratio: float, cells: int
) -> Array:
    """Return C11, C22, C23 and C33 on one grid.

    Parameters
    ----------
    surface : callable
        ``surface(shape, side)``: an elastic surface of G = 1 on square cells.
    axis_ratio : float
        As for `creep_coefficients`.
    cells : int
        Per shorter semi-axis. The area that is counted takes the place of pi a b.
    """
    a, b = np.sqrt(axis_ratio), 1 / np.sqrt(axis_ratio)
    side = min(a, b) / cells
    half = [int(np.ceil(axis / side)) for axis in (a, b)]
    # a row ahead, from which material enters, and one behind: the spin is about the middle
    x = (np.arange(-half[0] - 1, half[0] + 1) + 0.5) * side
    y = (np.arange(-half[1], half[1]) + 0.5) * side
    inside = (x[:, None] / a) ** 2 + (y / b) ** 2 < 1
    flow, stuck = Upstream(surface(inside.shape, side), inside.shape), np.where(inside, np.inf, 0.0)
    slips = [rigid_slip(creep, inside.shape, (side, side)) for creep in _ONE_OF_EACH]
    along, across, spin = (steady(flow, stuck, slip).traction for slip in slips)
    turning = (spin[1] * x[:, None] - spin[0] * y).sum()
    forces = np.array([along[0].sum(), across[1].sum(), spin[1].sum(), turning])
    # F = C 2 G c^2, c^3 or c^4
    return forces * side**2 / (2 * (inside.sum() * side**2 / np.pi) ** np.array([1, 1, 1.5, 2]))
