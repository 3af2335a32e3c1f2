"""Rolling in the plane: rollers of infinite length on the half-space, in plane strain.

Loads per length of the roller. A line force displaces the surface by a logarithm (Flamant;
Johnson 1985, eqs. (2.19), (2.29)), whose datum has no meaning and drops out of every difference:

    u_x = -Q c1/pi ln|x|,   c1 = (1 - nu)/G;    antiplane: u_y = -Q_y/(pi G) ln|x|.

Finite elements of plane strain take its place in `PlaneElements`, at rest or, with inertia, flowing
through their mesh at a speed V. For the continuum that is a factor of the compliance,

    alpha_s (1 - alpha_s^2)/(4 alpha_d alpha_s - (1 + alpha_s^2)^2) / (1 - nu),
    alpha^2 = 1 - V^2/c^2 of shear and of pressure waves

(L. B. Freund, Dynamic Fracture Mechanics, 1990, sec. 4.3): `moving_compliance`.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy import fft

from reference.arrays import Array
from reference.elasticity import Material
from reference.errors import count_faults, positive_faults, refuse
from reference.fem.grid_body import beyond_cells
from reference.halfspace.traction import Compliance

# Cells of a period over those of the grid, and at least: elements differ from the half-space within
# some cells only, but with inertia everywhere.
_APART, _APART_MOVING, _LEAST = 1, 16, 64


@dataclass(frozen=True)
class PlaneSurface:
    """The plane half-space under uniform tractions on cells, a grid of shape (cells, 1)."""

    cells: int
    width: float  # of a cell along x
    compliance: Compliance

    def __post_init__(self) -> None:
        refuse(count_faults(1, cells=self.cells) + positive_faults(width=self.width))

    @property
    def spacing(self) -> tuple[float, float]:
        """Cell sides; the second is a unit of length of the roller."""
        return (self.width, 1.0)

    def shear_coefficients(self) -> Array:
        """Return the displacement at all offsets (`reference.rolling.roll.TangentialSurface`)."""
        offsets = np.minimum(np.arange(2 * self.cells), 2 * self.cells - np.arange(2 * self.cells))
        x = (offsets + 0.5) * self.width, (offsets - 0.5) * self.width
        # the integral of ln|x| over the cell
        logarithm = x[0] * np.log(x[0]) - x[1] * np.log(np.abs(x[1])) - self.width
        c1, c2 = self.compliance.normal, self.compliance.lateral
        table = np.zeros((3, offsets.size, 1))
        table[0, :, 0], table[1, :, 0] = (-c1 / np.pi * logarithm, -(c1 + c2) / np.pi * logarithm)
        return table


@dataclass(frozen=True)
class PlaneElements(PlaneSurface):
    """Finite elements of plane strain below the same cells: splines across the depth."""

    poisson_ratio: float  # of the material of `compliance`
    inertia: float = 0.0  # rho V^2/G

    def shear_coefficients(self) -> Array:
        """Return the displacement at all offsets (`reference.rolling.roll.TangentialSurface`)."""
        nu = self.poisson_ratio
        material = Material(2 * (1 + nu) * (1 - nu) / self.compliance.normal, nu)
        apart = _APART_MOVING if self.inertia else _APART
        period = 2 * fft.next_fast_len(max(apart * self.cells, _LEAST), real=True), 1
        more = beyond_cells(
            period, (self.width,) * 2, material, element="splines", inertia=self.inertia
        )
        table = super().shear_coefficients()
        places = np.minimum(np.arange(2 * self.cells), 2 * self.cells - np.arange(2 * self.cells))
        table[0, :, 0] += more.xx[places, 0]
        table[1, :, 0] += more.yy[places, 0]
        return table


def moving_compliance(poisson_ratio: float, inertia: float) -> float:
    """Return the compliance of tangential loads that move, over that at rest; rho V^2/G < 0.76.

    Rayleigh's function 4 p s - (1 + s^2)^2 with s^2 = 1 - I, p^2 = 1 - k I vanishes with I = rho
    V^2/G: it is divided by I before its two terms could cancel.

    >>> round(moving_compliance(0.25, 0.0), 12), moving_compliance(0.25, 0.3) > 1.1
    (1.0, True)
    """
    k = (1 - 2 * poisson_ratio) / (2 * (1 - poisson_ratio))
    shear, pressure = np.sqrt(1 - inertia), np.sqrt(1 - k * inertia)
    over_inertia = 16 * (1 - k) - (24 - 16 * k) * inertia + 8 * inertia**2 - inertia**3
    rayleigh = over_inertia / (4 * pressure * shear + (2 - inertia) ** 2)
    return float(shear / rayleigh / (1 - poisson_ratio))


def hertz(x: ArrayLike, half_width: float, force: float) -> Array:
    """Return the pressure of a cylinder, 2 F/(pi a) sqrt(1 - x^2/a^2), F per length.

    >>> round(float(hertz(0.0, 1.0, np.pi)), 12)
    2.0
    """
    share = np.maximum(1 - (np.asarray(x) / half_width) ** 2, 0.0)
    pressure: Array = 2 * force / (np.pi * half_width) * np.sqrt(share)
    return pressure
