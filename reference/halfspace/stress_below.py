r"""Stress inside a half-space under a pressure on rectangular cells, and where it is largest.

Of a uniform pressure on a rectangle all stresses are elementary functions of its corners (A. E. H.
Love, Phil. Trans. R. Soc. A 228 (1929) 377). With V = int p/r dA and chi = int p ln(r + z) dA,
K. L. Johnson, Contact Mechanics (1985), eq. (3.23),

    2 pi s_xx = 2 nu V_z - z V_xx - (1 - 2 nu) chi_xx,    2 pi s_xy = -(1 - 2 nu) chi_xy - z V_xy,
    2 pi s_zz = V_z - z V_zz,                             2 pi s_xz = -z V_xz,

and s_yy, s_yz likewise. Stresses do not depend on Young's modulus. Under contacts they are largest
below the surface, where a half-space yields first: for Hertz at nu = 0.3 the shear stress has
0.310 of the largest pressure 0.48 a below (Johnson 1985, section 4.2).
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy import fft
from scipy.optimize import minimize_scalar

from reference.arrays import Array
from reference.elasticity import largest_shear, von_mises
from reference.errors import poisson_faults, positive_faults, refuse, spacing_faults

# Depths of the search, from half a cell to this many radii of the loaded area; then between two of
# them to this relative accuracy, with which the stress is known to its square. The surface itself
# comes last: there this share of a cell is the depth.
_DEPTHS, _DEEPEST, DEPTH_DIGITS = 12, 2.0, 0.002
_SURFACE = 1e-6


def stress_below(
    pressure: ArrayLike, spacing: tuple[float, float], depth: float, poisson_ratio: float
) -> Array:
    """Return the stress at a depth below the centres of the cells, tension positive.

    Parameters
    ----------
    pressure : (nx, ny) array_like
        Uniform on each cell, nothing outside.
    depth : float
        Positive, in the unit of the spacing.

    Returns
    -------
    (6, nx, ny) ndarray
        xx, yy, zz, yz, xz, xy, in the unit of the pressure.

    Examples
    --------
    Far below, a cell is a point force: s_zz = -3 F/(2 pi z^2)

    >>> field = stress_below([[1.0]], (1.0, 1.0), 100.0, 0.3)
    >>> round(float(field[2, 0, 0]) * 2 * np.pi * 100**2, 3)
    -3.0
    """
    pressure = np.asarray(pressure, dtype=float)
    faults = spacing_faults(spacing) + positive_faults(depth=depth) + poisson_faults(poisson_ratio)
    if pressure.ndim != 2 or not np.isfinite(pressure).all():
        faults.append("pressure must be a grid of finite numbers")
    refuse(faults)

    # corners between all offsets of two cells, those to the left in the order of the transform
    (nx, ny), z, nu = pressure.shape, depth, poisson_ratio
    x, y = (
        (np.arange(-n, n + 1) - 0.5)[:, None] * step
        for n, step in zip((nx, ny), spacing, strict=True)
    )
    y = y.T
    r = np.sqrt(x**2 + y**2 + z**2)
    # r + x and r + y without cancellation
    r_x = np.where(x < 0, (y**2 + z**2) / (r + np.abs(x)), r + x)
    r_y = np.where(y < 0, (x**2 + z**2) / (r + np.abs(y)), r + y)
    v_z = -np.arctan(x * y / (z * r))
    v_xx, v_yy, v_xy = x / (r * r_y), y / (r * r_x), 1 / r
    chi_xx, chi_yy = -2 * np.arctan(x / (r_y + z)), -2 * np.arctan(y / (r_x + z))
    corners = (
        2 * nu * v_z - z * v_xx - (1 - 2 * nu) * chi_xx,
        2 * nu * v_z - z * v_yy - (1 - 2 * nu) * chi_yy,
        v_z + z * (v_xx + v_yy),
        -z * z / (r * r_x),
        -z * z / (r * r_y),
        -z * v_xy - (1 - 2 * nu) * np.log(r + z),
    )
    loads = fft.rfft2(pressure, (2 * nx, 2 * ny), workers=1)
    stress = np.empty((6, nx, ny))
    for component, corner in zip(stress, corners, strict=True):
        kernel = np.diff(np.diff(corner, axis=0), axis=1) / (2 * np.pi)
        transfer = fft.rfft2(np.fft.ifftshift(kernel), workers=1)
        component[:] = fft.irfft2(loads * transfer, (2 * nx, 2 * ny), workers=1)[:nx, :ny]
    return stress


class Largest(NamedTuple):
    """The largest shear stress and von Mises stress inside, and how deep they are."""

    shear: float
    shear_depth: float
    von_mises: float
    von_mises_depth: float


def largest_below(
    pressure: ArrayLike,
    spacing: tuple[float, float],
    poisson_ratio: float,
    stress: Callable[[float], Array] | None = None,
) -> Largest:
    """Return the largest stresses below the cells, from the surface on (depth 0).

    They lie at the surface near the edge of a contact where Poisson's ratio is small or negative.

    Parameters
    ----------
    pressure, spacing, poisson_ratio
        As for `stress_below`; some of the pressure is positive.
    stress : callable, optional
        Depth -> stress (6, nx, ny) of another body, in place of the half-space's.

    Examples
    --------
    Hertz, nu = 0.3: 0.310 p0 at 0.48 a, and 0.620 p0

    >>> x = (np.arange(32) - 15.5) / 16
    >>> p = np.sqrt(np.maximum(1 - x[:, None] ** 2 - x**2, 0.0))
    >>> most = largest_below(p, (1 / 16, 1 / 16), 0.3)
    >>> [round(value, 2) for value in (most.shear, most.shear_depth, most.von_mises)]
    [0.31, 0.48, 0.62]
    """
    pressure = np.asarray(pressure, dtype=float)
    at = stress or (lambda depth: stress_below(pressure, spacing, depth, poisson_ratio))
    radius = np.sqrt(np.count_nonzero(pressure > 0) * spacing[0] * spacing[1] / np.pi)
    cell = min(spacing)
    depths = np.geomspace(cell / 2, max(_DEEPEST * radius, 2 * cell), _DEPTHS)

    def both(depth: float) -> Array:
        field = np.moveaxis(at(depth), 0, -1)
        equivalent = von_mises(field)
        # sqrt(J2) <= largest shear sqrt(4/3): principal stresses only where they may be largest
        near = equivalent >= np.sqrt(3) / 2 * equivalent.max()
        return np.array([largest_shear(field[near]).max(), equivalent.max()])

    values, surface = np.array([both(depth) for depth in depths]), both(_SURFACE * cell)
    found = []
    for which in (0, 1):
        best = int(np.argmax(values[:, which]))
        value, depth = values[best, which], depths[best]
        if 0 < best < _DEPTHS - 1:
            between = minimize_scalar(
                lambda logarithm, which=which: -both(np.exp(logarithm))[which],
                bounds=np.log(depths[[best - 1, best + 1]]),
                method="bounded",
                options={"xatol": DEPTH_DIGITS},
            )
            if -between.fun > value:
                value, depth = -between.fun, np.exp(between.x)
        if surface[which] > value:
            value, depth = surface[which], 0.0
        found += [float(value), float(depth)]
    return Largest(*found)
