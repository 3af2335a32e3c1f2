"""Displacement of an elastic half-space under uniform tangential tractions on rectangular cells.

Cerruti's solution (1882; Johnson 1985, eqs. (3.75)-(3.77)) on the surface, z into the half-space,
for forces P along z and Q along x at the origin:

    u_x = Q/(2 pi G) [(1 - nu)/r + nu x^2/r^3] - P (1 - 2 nu)/(4 pi G) x/r^2,
    u_y = Q/(2 pi G)  nu x y/r^3               - P (1 - 2 nu)/(4 pi G) y/r^2,
    u_z = P (1 - nu)/(2 pi G) /r               + Q (1 - 2 nu)/(4 pi G) x/r^2.

Integrated over a cell exactly; logarithms, roots and angles are rationalised to avoid cancellation,
and beyond 16 cell sides Gauss points are used, as for Love's coefficients (`kernels`). All
quantities are in consistent units.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.arguments import poisson_faults, positive_faults, refuse
from reference.halfspace import kernels

Field = NDArray[np.float64]


@dataclass(frozen=True)
class Compliance:
    """Elastic constants of a half-space under a rigid body.

    Attributes
    ----------
    normal : float
        c1 = (1 - nu)/G = 2/E*.
    lateral : float
        c2 = nu/G.
    coupling : float
        c3 = (1 - 2 nu)/(2 G). Divided by c1 it is Dundurs' second constant.

    Examples
    --------
    >>> steel = Compliance.of(80.0, 0.25)
    >>> round(steel.effective_modulus, 9), round(steel.tangential_modulus, 9)
    (213.333333333, 182.857142857)
    """

    normal: float
    lateral: float
    coupling: float

    @classmethod
    def of(cls, shear_modulus: float, poisson_ratio: float) -> Compliance:
        """Return the constants of one elastic body in contact with a rigid one.

        Raises
        ------
        ValueError
            Unless G is positive and finite and -1 < nu <= 1/2.
        """
        refuse(positive_faults(shear_modulus=shear_modulus) + poisson_faults(poisson_ratio))
        nu, G = poisson_ratio, shear_modulus
        return cls((1 - nu) / G, nu / G, (1 - 2 * nu) / (2 * G))

    @property
    def effective_modulus(self) -> float:
        """E*."""
        return 2 / self.normal

    @property
    def tangential_modulus(self) -> float:
        """G*, 4 G/(2 - nu) for one body."""
        return 4 / (2 * self.normal + self.lateral)


class CellIntegrals(NamedTuple):
    """Integrals over a cell of x^2/r^3, y^2/r^3, x y/r^3, x/r^2 and y/r^2 about a point."""

    xx: Field
    yy: Field
    xy: Field
    x: Field
    y: Field


def cell_integrals(i: ArrayLike, j: ArrayLike, spacing: tuple[float, float]) -> CellIntegrals:
    """Return integrals of Cerruti's terms over a cell, at a point i, j cells from its centre.

    Parameters
    ----------
    i, j : array_like
        Offsets of the point from the loaded cell along x and y, in cells, broadcast; either sign.
    spacing : (float, float)
        Cell sides (dx, dy).

    Returns
    -------
    CellIntegrals
        The last three are odd in the coordinates of their names. The error is below 1e-11 up to a
        distance of 1e4 cells (tested against 40 digits), relative to the larger of the two
        integrals of the same type.

    Examples
    --------
    >>> own = cell_integrals(0, 0, (1.0, 1.0))
    >>> bool(np.isclose(own.xx + own.yy, 4 * np.log(1 + np.sqrt(2)), rtol=1e-15)), float(own.x)
    (True, 0.0)
    """
    dx, dy = spacing
    i, j = np.broadcast_arrays(np.asarray(i, dtype=float), np.asarray(j, dtype=float))
    x, y = np.abs(i) * dx, np.abs(j) * dy
    far = np.maximum(x, y) > kernels.FAR * max(dx, dy)
    values = np.empty((5, *i.shape))
    values[:, far] = _gauss(x[far], y[far], dx, dy)
    values[:, ~far] = _closed(x[~far], y[~far], dx, dy)
    xx, yy, xy, along_x, along_y = values
    return CellIntegrals(
        xx, yy, np.sign(i) * np.sign(j) * xy, np.sign(i) * along_x, np.sign(j) * along_y
    )


def _closed(x: Field, y: Field, dx: float, dy: float) -> list[Field]:
    """Return the closed forms for x, y >= 0."""
    return [
        kernels.across_integral(y, x, dy, dx),
        kernels.across_integral(x, y, dx, dy),
        _mixed(x, y, dx, dy),
        _pull(x, y, dx, dy),
        _pull(y, x, dy, dx),
    ]


def _mixed(x: Field, y: Field, dx: float, dy: float) -> Field:
    """Return the double difference of -r, with differences of roots from their squares."""
    a, b, c, d = x + dx / 2, x - dx / 2, y + dy / 2, y - dy / 2
    ac, ad, bc, bd = np.hypot(a, c), np.hypot(a, d), np.hypot(b, c), np.hypot(b, d)
    return 4 * x * y * dx * dy * (1 / (ac + bc) + 1 / (ad + bd)) / ((ac + ad) * (bc + bd))


def _pull(x: Field, y: Field, dx: float, dy: float) -> Field:
    """Return the integral of x/r^2, the double difference of y ln r + x arctan(y/x)."""
    a, b, c, d = x + dx / 2, x - dx / 2, y + dy / 2, y - dy / 2
    ad, bc, bd = a * a + d * d, b * b + c * c, b * b + d * d
    # r = 0 does not occur, as points are never on the corners of a cell
    upper, lower = np.log1p(2 * x * dx / bc), np.log1p(2 * x * dx / bd)
    twist = np.log1p(-4 * x * y * dx * dy / (bc * ad))
    logarithms = y * twist / 2 + dy / 4 * (upper + lower)
    angles = a * np.arctan2(a * dy, a * a + c * d) - b * np.arctan2(b * dy, b * b + c * d)
    return logarithms + angles


def _gauss(x: Field, y: Field, dx: float, dy: float) -> Field:
    """Return the integrals far away by 4 x 4 Gauss points."""
    nodes, weights = np.polynomial.legendre.leggauss(4)
    total = np.zeros((5, *x.shape))
    for node_x, weight_x in zip(nodes, weights, strict=True):
        at_x = x + node_x * dx / 2
        for node_y, weight_y in zip(nodes, weights, strict=True):
            at_y = y + node_y * dy / 2
            square = at_x * at_x + at_y * at_y
            terms = np.array([at_x * at_x, at_y * at_y, at_x * at_y, at_x, at_y])
            terms[:3] /= np.sqrt(square)
            total += weight_x * weight_y * terms / square
    return total * (dx * dy / 4)


class Transfer(NamedTuple):
    """Fourier factors on the modes of `rfft2` of the (padded) grid.

    `xx`, `yy`, `xy` from tangential traction to tangential displacement (real); `x`, `y` from
    tangential traction to normal displacement, and with opposite sign from pressure to tangential
    displacement (imaginary parts).
    """

    xx: Field
    yy: Field
    xy: Field
    x: Field
    y: Field


def free_coefficients(
    shape: tuple[int, int], spacing: tuple[float, float], compliance: Compliance
) -> Transfer:
    """Return the displacements by uniform tractions on a cell, at offsets from zero on.

    `x` and `y` of the normal displacement, by tractions.
    """
    i, j = np.ix_(*(np.arange(n) for n in shape))
    cells = cell_integrals(i, j, spacing)
    c1, c2, c3 = compliance.normal, compliance.lateral, compliance.coupling
    both, scale = cells.xx + cells.yy, 1 / (2 * np.pi)
    return Transfer(
        scale * (c1 * both + c2 * cells.xx),
        scale * (c1 * both + c2 * cells.yy),
        scale * c2 * cells.xy,
        scale * c3 * cells.x,
        scale * c3 * cells.y,
    )


def free_transfer(
    table: Callable[[Field, int, int], NDArray[np.complex128]],
    coefficients: Transfer,
) -> Transfer:
    """Return the factors of the free half-space under uniform tractions on cells.

    Parameters
    ----------
    table : callable
        ``table(quarter, sign_x, sign_y)``: transform of the coefficients whose values at offsets
        from zero on are `quarter`, even (1) or odd (-1) in x and y.
    coefficients : Transfer
        As of `free_coefficients`.
    """
    return Transfer(
        table(coefficients.xx, 1, 1).real.copy(),
        table(coefficients.yy, 1, 1).real.copy(),
        table(coefficients.xy, -1, -1).real.copy(),
        table(coefficients.x, -1, 1).imag.copy(),
        table(coefficients.y, 1, -1).imag.copy(),
    )


def periodic_transfer(
    shape: tuple[int, int], spacing: tuple[float, float], compliance: Compliance
) -> Transfer:
    r"""Return the factors of the periodic half-space with zero mean displacement.

    u^ = [(c1 + c2) - c2 q q'/|q|^2] q^/|q| for the tangential tractions, -i c3 q_x/|q|^2 from
    them to u_z (the Fourier transforms of Cerruti's solution): band-limited tractions through the
    cell values. Odd factors have no Nyquist mode on a real grid, where it is zero.

    Examples
    --------
    >>> made = periodic_transfer((8, 8), (1.0, 1.0), Compliance.of(1.0, 0.25))
    >>> k = 2 * np.pi / 8  # the factor is 1 - nu along the wave, 1 transverse to it
    >>> [round(float(t[1, 0] * k), 12) for t in (made.xx, made.yy)]
    [0.75, 1.0]
    """
    qx, qy = kernels.wavenumbers(shape, spacing)
    square = qx * qx + qy * qy
    square[0, 0] = np.inf
    c1, c2, c3 = compliance.normal, compliance.lateral, compliance.coupling
    odd_x, odd_y = qx.copy(), qy.copy()
    if shape[0] % 2 == 0:
        odd_x[shape[0] // 2, 0] = 0.0
    if shape[1] % 2 == 0:
        odd_y[0, -1] = 0.0
    wavenumber = np.sqrt(square)
    return Transfer(
        (c1 + c2 - c2 * qx * qx / square) / wavenumber,
        (c1 + c2 - c2 * qy * qy / square) / wavenumber,
        -c2 * odd_x * odd_y / square / wavenumber,
        -c3 * odd_x / square,
        -c3 * odd_y / square,
    )
