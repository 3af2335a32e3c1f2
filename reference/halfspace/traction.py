"""The half-space under tangential tractions: Cerruti's solution on cells, as a linear operator.

Cerruti's solution (1882; Johnson 1985, eqs. (3.75)-(3.77)) on the surface, z into the half-space,
for forces P along z and Q along x at the origin:

    u_x = Q/(2 pi G) [(1 - nu)/r + nu x^2/r^3] - P (1 - 2 nu)/(4 pi G) x/r^2,
    u_y = Q/(2 pi G)  nu x y/r^3               - P (1 - 2 nu)/(4 pi G) y/r^2,
    u_z = P (1 - nu)/(2 pi G) /r               + Q (1 - 2 nu)/(4 pi G) x/r^2.

Integrated over a cell exactly; logarithms, roots and angles are rationalised to avoid cancellation,
and beyond 16 cell sides Gauss points are used, as for Love's coefficients (`kernels`). Tractions
and tangential displacements have shape (2, nx, ny); quantities are in consistent units.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import fft

from reference.arrays import Array, Modes
from reference.contact.body import ElasticBody, window
from reference.errors import poisson_faults, positive_faults, refuse
from reference.halfspace import kernels
from reference.halfspace.kernels import FreeOperator, PeriodicOperator

# Empty cells that separate opposite rims of a free patch in the preconditioner.
_RIM = 8


@dataclass(frozen=True)
class Compliance:
    """Elastic constants of a half-space under a rigid body.

    >>> steel = Compliance.of(80.0, 0.25)
    >>> round(steel.effective_modulus, 9), round(steel.tangential_modulus, 9)
    (213.333333333, 182.857142857)
    """

    normal: float  # c1 = (1 - nu)/G = 2/E*
    lateral: float  # c2 = nu/G
    coupling: float  # c3 = (1 - 2 nu)/(2 G). Divided by c1 it is Dundurs' second constant.

    @classmethod
    def of(cls, shear_modulus: float, poisson_ratio: float) -> Compliance:
        """Return the constants of one elastic body in contact with a rigid one."""
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


class Cerruti(NamedTuple):
    """Five parts of Cerruti's solution, on cells or as Fourier factors.

    `xx`, `yy`, `xy`: tangential displacements by tangential tractions. `x`, `y`: the normal one by
    tractions, and with opposite sign tangential ones by pressure; their Fourier factors are
    imaginary, and held as such parts. Before elastic constants come in: integrals over a cell of
    x^2/r^3, y^2/r^3, x y/r^3, x/r^2 and y/r^2.
    """

    xx: Array
    yy: Array
    xy: Array
    x: Array
    y: Array


def wave_factors(compliance: Compliance, qx: Array, qy: Array) -> Cerruti:
    """Return the factors from waves of traction to displacement; those of no wave are zero.

    u^ = [(c1 + c2) - c2 q q'/|q|^2] q^/|q| for tangential tractions, -i c3 q_x/|q|^2 from them to
    u_z.
    """
    c1, c2, c3 = compliance.normal, compliance.lateral, compliance.coupling
    square = qx * qx + qy * qy
    square[square == 0] = np.inf
    wavenumber = np.sqrt(square)
    return Cerruti(
        (c1 + c2 - c2 * qx * qx / square) / wavenumber,
        (c1 + c2 - c2 * qy * qy / square) / wavenumber,
        -c2 * qx * qy / square / wavenumber,
        -c3 * qx / square,
        -c3 * qy / square,
    )


def cell_integrals(i: ArrayLike, j: ArrayLike, spacing: tuple[float, float]) -> Cerruti:
    """Return integrals of Cerruti's terms over a cell, at a point i, j cells from its centre.

    Offsets of either sign along x and y, broadcast. The error is below 1e-11 up to a distance of
    1e4 cells (tested against 40 digits), relative to the larger of the two integrals of a type.
    """
    dx, dy = spacing
    i, j = np.broadcast_arrays(np.asarray(i, dtype=float), np.asarray(j, dtype=float))
    x, y = np.abs(i) * dx, np.abs(j) * dy
    far = np.maximum(x, y) > kernels.FAR * max(dx, dy)
    values = np.empty((5, *i.shape))

    def terms(x: Array, y: Array, weight: float) -> Array:
        square = x * x + y * y
        parts = np.array([x * x, y * y, x * y, x, y])
        parts[:3] /= np.sqrt(square)
        return weight * parts / square

    values[:, far] = kernels.over_cell(terms, x[far], y[far], spacing)
    x, y = x[~far], y[~far]
    # x y/r^3: the double difference of -r, with differences of roots from their squares
    a, b, c, d = x + dx / 2, x - dx / 2, y + dy / 2, y - dy / 2
    ac, ad, bc, bd = np.hypot(a, c), np.hypot(a, d), np.hypot(b, c), np.hypot(b, d)
    mixed = 4 * x * y * dx * dy * (1 / (ac + bc) + 1 / (ad + bd)) / ((ac + ad) * (bc + bd))
    values[:, ~far] = (
        kernels.across_integral(y, x, dy, dx),
        kernels.across_integral(x, y, dx, dy),
        mixed,
        _pull(x, y, dx, dy),
        _pull(y, x, dy, dx),
    )
    xx, yy, xy, along_x, along_y = values
    return Cerruti(xx, yy, np.sign(i) * np.sign(j) * xy, np.sign(i) * along_x, np.sign(j) * along_y)


def _pull(x: Array, y: Array, dx: float, dy: float) -> Array:
    """Return the integral of x/r^2, the double difference of y ln r + x arctan(y/x)."""
    a, b, c, d = x + dx / 2, x - dx / 2, y + dy / 2, y - dy / 2
    ad, bc, bd = a * a + d * d, b * b + c * c, b * b + d * d
    # r = 0 does not occur, as points are never on the corners of a cell
    upper, lower = np.log1p(2 * x * dx / bc), np.log1p(2 * x * dx / bd)
    twist = np.log1p(-4 * x * y * dx * dy / (bc * ad))
    logarithms = y * twist / 2 + dy / 4 * (upper + lower)
    angles = a * np.arctan2(a * dy, a * a + c * d) - b * np.arctan2(b * dy, b * b + c * d)
    return logarithms + angles


def tensor_product(
    factors: Sequence[NDArray[Any]], fields: Array, padded: tuple[int, ...]
) -> Array:
    """Return the vector field with the Fourier factors (xx, yy, xy) times that of another one."""
    xx, yy, xy = factors
    along, across = fft.rfft2(fields, s=padded, axes=(-2, -1), workers=1)
    modes = np.array([xx * along + xy * across, xy * along + yy * across])
    field = fft.irfft2(modes, s=padded, axes=(-2, -1), workers=1, overwrite_x=True)
    return field[:, : fields.shape[1], : fields.shape[2]]


class NormalAndTangential:
    """Half-space with normal and tangential tractions on one grid.

    Periodic: the images of the grid (band-limited tractions, zero mean displacements) instead
    of the free half-space (tractions uniform on cells).
    """

    def __init__(
        self,
        shape: tuple[int, int],
        spacing: tuple[float, float],
        compliance: Compliance,
        *,
        periodic: bool = False,
    ) -> None:
        kind = PeriodicOperator if periodic else FreeOperator
        self.normal: ElasticBody = kind(shape, spacing, compliance.effective_modulus)
        self.compliance = compliance
        self.shape, self.spacing = self.normal.shape, self.normal.spacing
        self.periodic, self.cell_area = periodic, self.normal.cell_area
        self.padded = self.shape
        if not periodic:
            self.padded = tuple(fft.next_fast_len(2 * n - 1, real=True) for n in self.shape)
        self._parts: dict[tuple[int, int], NormalAndTangential] = {}

    def restrict(self, shape: tuple[int, int]) -> NormalAndTangential:
        """Return the same free body on a smaller rectangle of cells (cached)."""
        if shape == self.shape:
            return self
        return window(self._parts, shape, self._part)

    def _part(self, shape: tuple[int, int]) -> NormalAndTangential:
        return NormalAndTangential(shape, self.spacing, self.compliance)

    def free_coefficients(self) -> Cerruti:
        """Displacements by tractions on a cell of the free half-space, at offsets from zero on."""
        i, j = np.ix_(*(np.arange(n) for n in self.shape))
        cells = cell_integrals(i, j, self.spacing)
        c1, c2, c3 = self.compliance.normal, self.compliance.lateral, self.compliance.coupling
        scale, both = 1 / (2 * np.pi), cells.xx + cells.yy
        return Cerruti(
            scale * (c1 * both + c2 * cells.xx),
            scale * (c1 * both + c2 * cells.yy),
            scale * c2 * cells.xy,
            scale * c3 * cells.x,
            scale * c3 * cells.y,
        )

    @cached_property
    def _transfer(self) -> Cerruti:
        """Fourier factors on the modes of `rfft2`."""
        nx, ny = self.shape
        if self.periodic:
            # band-limited tractions through the cell values; odd factors have no Nyquist mode on a
            # real grid
            grid = kernels.wavenumbers(self.shape, self.spacing)
            factors = wave_factors(self.compliance, *grid)
            if nx % 2 == 0:
                factors.xy[nx // 2] = factors.x[nx // 2] = 0.0
            if ny % 2 == 0:
                factors.xy[:, -1] = factors.y[:, -1] = 0.0
            return factors

        def transform(quarter: Array, sign_x: int, sign_y: int) -> Modes:
            # mirrored to negative offsets, even (1) or odd (-1)
            table = np.zeros(self.padded)
            table[:nx, :ny] = quarter
            if nx > 1:
                table[-(nx - 1) :, :ny] = sign_x * quarter[:0:-1]
            if ny > 1:
                table[:, -(ny - 1) :] = sign_y * table[:, ny - 1 : 0 : -1]
            return fft.rfft2(table, workers=1)

        cells = self.free_coefficients()
        return Cerruti(
            transform(cells.xx, 1, 1).real.copy(),
            transform(cells.yy, 1, 1).real.copy(),
            transform(cells.xy, -1, -1).real.copy(),
            transform(cells.x, -1, 1).imag.copy(),
            transform(cells.y, 1, -1).imag.copy(),
        )

    def shear_coefficients(self) -> Array:
        """Return u_x by q_x, u_y by q_y, and u_x by q_y, at offsets of cells modulo `padded`."""
        t = self._transfer
        table: Array = fft.irfft2(np.array([t.xx, t.yy, t.xy]), self.padded, workers=1)
        return table

    def _back(self, modes: Modes) -> Array:
        nx, ny = self.shape
        field = fft.irfft2(modes, s=self.padded, axes=(-2, -1), workers=1, overwrite_x=True)
        return field[..., :nx, :ny]

    def shear(self, traction: Array) -> Array:
        """Return the tangential displacement (2, nx, ny) under tangential tractions (2, nx, ny)."""
        return tensor_product(self._transfer[:3], traction, self.padded)

    def lift(self, traction: Array) -> Array:
        """Return the normal displacement (nx, ny), inwards, under tangential tractions."""
        t = self._transfer
        along, across = fft.rfft2(traction, s=self.padded, axes=(-2, -1), workers=1)
        return self._back(1j * (t.x * along + t.y * across))

    def drag(self, pressure: Array) -> Array:
        """Return the tangential displacement (2, nx, ny) under a pressure."""
        t = self._transfer
        modes = -1j * fft.rfft2(pressure, s=self.padded, workers=1)
        return self._back(np.array([t.x * modes, t.y * modes]))

    @property
    def own(self) -> float:
        """Displacement of a cell by a unit tangential traction on itself, roughly."""
        return (self.compliance.normal + self.compliance.lateral) * self.spacing[0] / 2

    @cached_property
    def _inverse(self) -> tuple[tuple[int, ...], tuple[Array, Array, Array]]:
        """Return padded shape and factors of the inverse periodic half-space.

        |q| [1/(c1 + c2) + (1/c1 - 1/(c1 + c2)) q q'/|q|^2]; half the smallest wavenumber at q = 0.
        """
        padded = self.shape
        if not self.periodic:
            padded = tuple(fft.next_fast_len(n + _RIM, real=True) for n in self.shape)
        qx, qy = kernels.wavenumbers(padded, self.spacing)
        wavenumber = np.hypot(qx, qy)
        lengths = [n * step for n, step in zip(padded, self.spacing, strict=True)]
        wavenumber[0, 0] = np.pi / max(lengths)
        c1, shear = self.compliance.normal, self.compliance.normal + self.compliance.lateral
        more = (1 / c1 - 1 / shear) / wavenumber
        xx, yy = (wavenumber / shear + more * part for part in (qx * qx, qy * qy))
        return padded, (xx, yy, more * (qx * qy))

    def near(self, slip: Array) -> Array:
        """Return the traction of a tangential displacement on a periodic grid."""
        padded, factors = self._inverse
        return tensor_product(factors, slip, padded)
