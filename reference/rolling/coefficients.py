"""Creep coefficients of elliptic contacts: the limit of vanishing slip.

Kalker's linear theory (1967; 1990, app. E) is F_x = C11 G a b xi, F_y = C22 G a b eta, where all of
the contact sticks. G is that of two equal bodies; one elastic body on a rigid one has 2 G in its
place, as here.

On a grid the error is of first order in the cells, and the area of the counted cells, which takes
the place of pi a b, removes most of its scatter. Straight lines through several grids give the
limit.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reference.arguments import poisson_faults, positive_faults, refuse
from reference.halfspace.cerruti import Compliance
from reference.halfspace.traction import NormalAndTangential
from reference.rolling.tractions import Rolling, Surface

Array = NDArray[np.float64]

_CELLS = (8, 11, 16, 22)


@dataclass(frozen=True)
class CreepCoefficients:
    """Coefficients on several grids, and their limit.

    Attributes
    ----------
    cells : ndarray, shape (k,)
        Per shorter semi-axis.
    values : ndarray, shape (k, 2)
        C11 and C22 on the grids.
    limit : ndarray, shape (2,)
        By a straight line over the cell size.
    uncertainty : ndarray, shape (2,)
        Largest change of the limit where one of the grids is left out.
    """

    cells: Array
    values: Array
    limit: Array
    uncertainty: Array

    @classmethod
    def of(cls, cells: tuple[int, ...], values: Array) -> CreepCoefficients:
        """Return the study of values on grids."""
        sizes = 1 / np.array(cells, dtype=float)

        def line(kept: NDArray[np.bool_]) -> Array:
            return np.array(np.polyfit(sizes[kept], values[kept], 1)[1])

        everything = np.ones(len(cells), dtype=bool)
        limit = line(everything)
        others = [line(np.arange(len(cells)) != left) for left in range(len(cells))]
        return cls(sizes**-1, values, limit, np.abs(np.array(others) - limit).max(axis=0))


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
        Per shorter semi-axis, two grids at least.

    Raises
    ------
    ValueError
        Lists all invalid arguments.

    Examples
    --------
    >>> circle = creep_coefficients(0.25, 1.0, (4, 6, 8))
    >>> bool(abs(circle.limit[0] / 4.12 - 1) < 0.02)
    True
    """
    refuse(poisson_faults(poisson_ratio) + positive_faults(axis_ratio=axis_ratio))
    compliance = Compliance.of(1.0, poisson_ratio)

    def surface(shape: tuple[int, int], side: float) -> Surface:
        return NormalAndTangential(shape, (side, side), compliance)

    values = [on_grid(surface, axis_ratio, count) for count in cells]
    return CreepCoefficients.of(cells, np.array(values))


def on_grid(
    surface: Callable[[tuple[int, int], float], Surface], axis_ratio: float, cells: int
) -> Array:
    """Return C11 and C22 on one grid.

    Parameters
    ----------
    surface : callable
        ``surface(shape, side)``: an elastic surface of G = 1 on square cells.
    axis_ratio, cells
        As for `creep_coefficients`.
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
