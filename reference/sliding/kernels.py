"""Displacement of a viscoelastic half-space under pressure travelling at constant speed.

In the frame of the pressure, which moves along +x, a material point now at x was at x + v t' a time
t' ago. With the elastic displacement K p for E* = 1 and the creep compliance J(t) of the shear
modulus, nu = 1/2 (E* = 4 G), the correspondence principle gives

    u(x, y) = 1/4 { J_0 K p(x, y) + sum_k J_k int_0^inf exp(-s/l_k)/l_k K p(x + s, y) ds },

l_k = v lambda_k: Love's coefficients, averaged over the region ahead. For waves exp(i q x) it is
u^ = 2 p^/(|q| 4 G*(-q_x v)), the form of the periodic half-space (Persson 2001 uses it so; steady
contact: Johnson 1985, 9.5; Carbone & Putignano, J. Mech. Phys. Solids 61 (2013) 1822).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from reference.halfspace import kernels
from reference.viscoelastic.materials import GeneralisedMaxwell

Array = NDArray[np.float64]

_NODES = 12  # per panel; 1e-9 of the own-cell value, with the logarithms at the cell's edges
_DEEP = 44.0  # exp(-44) is negligible


def travelling(
    shape: tuple[int, int],
    spacing: tuple[float, float],
    material: GeneralisedMaxwell,
    speed: float,
) -> Array:
    """Return the displacement at cell centres under unit pressure on a travelling cell.

    Parameters
    ----------
    shape : (int, int)
        Number of cells (nx, ny) of the grid.
    spacing : (float, float)
        Cell sides.
    material : GeneralisedMaxwell
        A solid, nu = 1/2.
    speed : float
        v > 0 along +x.

    Returns
    -------
    ndarray, shape (2 nx - 1, ny)
        At offsets -(nx - 1) ... nx - 1 of the point from the loaded cell in x and 0 ... ny - 1 in
        y; even in the latter.

    Examples
    --------
    In slow motion the material is relaxed: Love's coefficient for E* = 4 G.

    >>> solid = GeneralisedMaxwell.kelvin_voigt(1.0, 1.0)
    >>> slow = travelling((2, 1), (1.0, 1.0), solid, 1e-9)
    >>> bool(np.isclose(slow[1, 0], np.log(1 + np.sqrt(2)) / np.pi))
    True
    """
    across = np.arange(shape[1])[None, :]

    def elastic(offsets: Array) -> Array:
        return kernels.love(offsets, across, spacing, 1.0)

    return _remembered(elastic, shape[0], material, speed / spacing[0])


def travelling_plane(cells: int, width: float, material: GeneralisedMaxwell, speed: float) -> Array:
    """Return the same of strips of infinite length, shape (2 cells - 1, 1): plane strain.

    A line force displaces the surface by -2/(pi E*) ln|x| (Johnson 1985, eq. 2.19), up to a
    constant, chosen so that the surface is pressed in within a hundred grids, and as many ways that
    the slowest of the modes remembers.
    """
    remembered = speed / width * max(material.creep_modes.times, default=0.0)
    far = np.log(100 * (cells + remembered))

    def elastic(offsets: Array) -> Array:
        ends = offsets + 0.5, offsets - 0.5
        logarithms = [
            np.where(x == 0, 0.0, x * np.log(np.where(x == 0, 1.0, abs(x)))) for x in ends
        ]
        return 2 * width / np.pi * (1 + far - (logarithms[0] - logarithms[1]))

    return _remembered(elastic, cells, material, speed / width)


def _remembered(
    elastic: Callable[[Array], Array], nx: int, material: GeneralisedMaxwell, speed: float
) -> Array:
    """Return the displacement with all creep modes; `elastic` at offsets along x, E* = 1.

    The speed is in cells per time.
    """
    modes = material.creep_modes
    total = modes.instantaneous * elastic(np.arange(-(nx - 1), nx)[:, None].astype(float))
    for compliance, time in zip(modes.compliances, modes.times, strict=True):
        total = total + compliance * _averaged_ahead(elastic, nx, speed * time)
    return total / 4


def _averaged_ahead(elastic: Callable[[Array], Array], nx: int, reach: float) -> Array:
    """Return a coefficient averaged over exp(-s/reach)/reach, s in cells, at all offsets.

    A(i) = int_0^1 ... + exp(-1/reach) A(i + 1), from far ahead back to the rear.
    """
    offsets = np.arange(-(nx - 1), nx)[:, None].astype(float)
    cell = np.zeros_like(elastic(offsets))
    for s, weight in zip(*_measure(_within(reach), reach), strict=True):
        cell += weight * elastic(offsets + s)
    beyond = np.zeros((1, cell.shape[1]))
    for s, weight in zip(*_measure(_ahead(nx, reach), reach), strict=True):
        beyond += weight * elastic(np.array([[float(nx) + s]]))
    decay, following = np.exp(-1 / reach), beyond[0]
    for i in range(2 * nx - 2, -1, -1):
        following = cell[i] + decay * following
        cell[i] = following
    return cell


def _within(reach: float) -> list[float]:
    """Return ends of panels within a cell: with its middle as a possible edge, finer at first."""
    falls = [reach * 2.0**k for k in range(6) if reach * 2.0**k < 1]
    return sorted({0.0, 0.5, 1.0, *falls})


def _ahead(nx: int, reach: float) -> list[float]:
    """Return ends of panels from nx cells ahead on, with widths growing with the distance."""
    ends, width, last = [0.0], min(nx / 2, reach), _DEEP * reach
    while ends[-1] < last:
        ends.append(min(ends[-1] + width, last))
        width = min(2 * width, 4 * reach)
    return ends


def _measure(ends: list[float], reach: float) -> tuple[Array, Array]:
    """Return nodes and weights of exp(-s/reach)/reach ds on panels, smoothed at their ends.

    s = a + (b - a) t^3 (10 - 15 t + 6 t^2) makes x ln x at an end smooth enough for Gauss points.
    """
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    t = (1 + nodes) / 2
    shape, slope = t**3 * (10 - 15 * t + 6 * t**2), 30 * t**2 * (1 - t) ** 2
    begin, width = np.array(ends[:-1])[:, None], np.diff(ends)[:, None]
    s = (begin + width * shape).ravel()
    mass = (width * slope * weights / 2).ravel() * np.exp(-s / reach) / reach
    return s, mass


def periodic(
    shape: tuple[int, int],
    spacing: tuple[float, float],
    material: GeneralisedMaxwell,
    speed: float,
) -> NDArray[np.complex128]:
    """Return the transfer function u^ = T p^ of the periodic half-space, T = 2/(|q| 4 G*(-q_x v)).

    The q = 0 term is zero: the displacement has zero mean, the datum of the periodic problem. Waves
    along y do not travel and have the relaxed modulus; the Nyquist wave along x has no direction,
    and the real part is used.

    Returns
    -------
    ndarray, shape (nx, ny//2 + 1)
        On the modes of `rfft2`.
    """
    transfer = kernels.periodic(shape, spacing, 1.0)
    qx, _ = kernels.wavenumbers(shape, spacing)
    softness = 1 / (4 * material.dynamic_modulus(-speed * qx))
    if shape[0] % 2 == 0:
        softness[shape[0] // 2] = softness[shape[0] // 2].real
    return transfer * softness
