"""Creep coefficients of elliptic contacts: the limit of vanishing slip.

Kalker's linear theory (1967; 1990, app. E) is F_x = C11 G a b xi, F_y = C22 G a b eta, where all of
the contact sticks. G is that of two equal bodies; one elastic body on a rigid one has 2 G in its
place, as here.

The contact is cut into strips along the way of rolling, each of the length that its area asks for,
and these into cells that are fine at both ends, x = h sin: tractions rise from the leading edge as
a root, and at the trailing edge, where nothing slips, they have no bound. With neither steps along
the outline nor coarse cells at its ends the error is of second order in the cells, and a straight
line over the square of their size gives the limit. `on_grid` has the square cells of the solvers,
whose error is of first order.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reference.arguments import poisson_faults, positive_faults, refuse
from reference.halfspace.cerruti import Compliance, cell_integrals
from reference.rolling.tractions import Rolling, Surface

Array = NDArray[np.float64]

_CELLS = (10, 14, 20)


@dataclass(frozen=True)
class CreepCoefficients:
    """Coefficients on several grids, and their limit.

    Attributes
    ----------
    cells : ndarray, shape (k,)
        Strips on half the width, and cells on each of them.
    values : ndarray, shape (k, 2)
        C11 and C22 on the grids.
    limit : ndarray, shape (2,)
        By a straight line over the square of the cell size.
    uncertainty : ndarray, shape (2,)
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
    """Return C11 and C22 of the half-space.

    Parameters
    ----------
    poisson_ratio : float
    axis_ratio : float
        a/b, a the semi-axis along which the contact rolls.
    cells : tuple of int
        Strips on half the width, and cells on each; three grids at least, ascending.

    Raises
    ------
    ValueError
        Lists all invalid arguments.

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
        """Return C11 and C22: tractions of full stick, their sums over 2 G a b."""
        upstream = np.diff(self.points, axis=1).ravel()
        direct, image = self._differences(compliance)
        forces = []
        for direction, parity in enumerate((1, -1)):
            # q_x has this parity in y, and q_y the other one
            xx, yy, xy, yx = (
                direct[part] + sign * parity * image[part]
                for part, sign in ((0, 1), (1, -1), (2, -1), (2, 1))
            )
            matrix = np.block([[xx, xy], [yx, yy]])
            way = np.zeros((2, upstream.size))
            way[direction] = upstream
            traction = np.linalg.solve(matrix, way.ravel()).reshape(2, *self.x.shape)
            forces.append(2 * self.width * float((traction[direction] * self.lengths).sum()))
        return np.array(forces) / 2

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
    surface: Callable[[tuple[int, int], float], Surface], axis_ratio: float, cells: int
) -> Array:
    """Return C11 and C22 on one grid.

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
    # a row ahead, from which material enters
    x = (np.arange(-half[0], half[0] + 1) + 0.5) * side
    y = (np.arange(-half[1], half[1]) + 0.5) * side
    inside = (x[:, None] / a) ** 2 + (y / b) ** 2 < 1
    rolling = Rolling(surface(inside.shape, side), np.where(inside, np.inf, 0.0))
    forces = []
    for direction in range(2):
        creep = np.zeros((2, *inside.shape))
        creep[direction] = 1.0
        forces.append(rolling.at(creep).traction[direction].sum())
    # F = C 2 G (area/pi)
    return np.array(forces) * np.pi / (2 * inside.sum())
