"""Rolling in the plane: rollers of infinite length on the half-space, in plane strain.

Loads per length of the roller. A line force displaces the surface by a logarithm (Flamant;
Johnson 1985, eqs. (2.19), (2.29)), whose datum has no meaning and drops out of every difference:

    u_x = -Q c1/pi ln|x|,   c1 = (1 - nu)/G;    antiplane: u_y = -Q_y/(pi G) ln|x|.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.arguments import count_faults, positive_faults, refuse
from reference.halfspace.cerruti import Compliance

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PlaneSurface:
    """The plane half-space under uniform tractions on cells, a grid of shape (cells, 1).

    Parameters
    ----------
    cells : int
    width : float
        Of a cell along x.
    compliance : Compliance

    Raises
    ------
    ValueError
        Lists all invalid arguments.

    Examples
    --------
    >>> surface = PlaneSurface(4, 1.0, Compliance.of(1.0, 0.5))
    >>> along, across, _ = surface.shear_coefficients()[:, :, 0]
    >>> bool(along[1] < along[0]), round(float((across[1] - across[0]) / (along[1] - along[0])), 9)
    (True, 2.0)
    """

    cells: int
    width: float
    compliance: Compliance

    def __post_init__(self) -> None:
        refuse(count_faults(1, cells=self.cells) + positive_faults(width=self.width))

    @property
    def spacing(self) -> tuple[float, float]:
        """Cell sides; the second is a unit of length of the roller."""
        return (self.width, 1.0)

    def shear_coefficients(self) -> Array:
        """Return the displacement at all offsets, as `tractions.Surface` asks for."""
        offsets = np.minimum(np.arange(2 * self.cells), 2 * self.cells - np.arange(2 * self.cells))
        x = (offsets + 0.5) * self.width, (offsets - 0.5) * self.width
        # the integral of ln|x| over the cell
        logarithm = x[0] * np.log(x[0]) - x[1] * np.log(np.abs(x[1])) - self.width
        c1, c2 = self.compliance.normal, self.compliance.lateral
        table = np.zeros((3, offsets.size, 1))
        table[0, :, 0], table[1, :, 0] = (
            -c1 / np.pi * logarithm,
            -(c1 + c2) / np.pi * logarithm,
        )
        return table


def hertz(x: ArrayLike, half_width: float, force: float) -> Array:
    """Return the pressure of a cylinder, 2 F/(pi a) sqrt(1 - x^2/a^2), F per length.

    >>> round(float(hertz(0.0, 1.0, np.pi)), 12)
    2.0
    """
    share = np.maximum(1 - (np.asarray(x) / half_width) ** 2, 0.0)
    pressure: Array = 2 * force / (np.pi * half_width) * np.sqrt(share)
    return pressure
