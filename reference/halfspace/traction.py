"""The half-space as a linear operator from tangential tractions to displacements, with inverse.

`NormalAndTangential` complements `operators.ElasticBody` on the same grid and body by Cerruti's
solution. Tractions and tangential displacements have shape (2, nx, ny).
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from reference.contact.body import ElasticBody, power_of_two, window
from reference.halfspace import cerruti, kernels
from reference.halfspace.cerruti import Compliance, Transfer
from reference.halfspace.operators import FreeOperator, PeriodicOperator

Field = NDArray[np.float64]
Fields = NDArray[np.float64]

# Empty cells that separate opposite rims of a free patch in the preconditioner.
_RIM = 8


class NormalAndTangential:
    """Half-space with normal and tangential tractions on one grid.

    Parameters
    ----------
    shape : (int, int)
        Number of cells (nx, ny).
    spacing : (float, float)
        Cell sides (dx, dy).
    compliance : Compliance
        Elastic constants, see `cerruti.Compliance`.
    periodic : bool
        The periodic images of the grid (band-limited tractions, zero mean displacements) instead of
        the free half-space (tractions uniform on cells).

    Raises
    ------
    ValueError
        As `FreeOperator`.

    Examples
    --------
    A tangential force displaces points behind it forwards and lifts them; pressure pulls points
    towards itself:

    >>> body = NormalAndTangential((8, 1), (1.0, 1.0), Compliance.of(1.0, 0.3))
    >>> push = np.zeros((2, 8, 1))
    >>> push[0, 4] = 1.0
    >>> bool(body.shear(push)[0, 0, 0] > 0), bool(body.lift(push)[0, 0] < 0)
    (True, True)
    >>> bool(body.drag(push[0])[0, 0, 0] > 0)
    True
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
        """Return the same free half-space on a smaller rectangle of cells (cached)."""
        if shape == self.shape:
            return self
        return window(
            self._parts,
            shape,
            lambda part: NormalAndTangential(part, self.spacing, self.compliance),
        )

    @cached_property
    def _transfer(self) -> Transfer:
        if self.periodic:
            return cerruti.periodic_transfer(self.shape, self.spacing, self.compliance)
        return cerruti.free_transfer(self._table, self.free_coefficients())

    def free_coefficients(self) -> Transfer:
        """Displacements by tractions on a cell of the free half-space, at offsets from zero on."""
        return cerruti.free_coefficients(self.shape, self.spacing, self.compliance)

    def _table(self, quarter: Field, sign_x: int, sign_y: int) -> NDArray[np.complex128]:
        """Return the transform of coefficients on the padded grid, mirrored with their signs."""
        table = np.zeros(self.padded)
        nx, ny = self.shape
        table[:nx, :ny] = quarter
        if nx > 1:
            table[-(nx - 1) :, :ny] = sign_x * quarter[:0:-1]
        if ny > 1:
            table[:, -(ny - 1) :] = sign_y * table[:, ny - 1 : 0 : -1]
        return fft.rfft2(table, workers=1)

    def shear_coefficients(self) -> Fields:
        """Return u_x by q_x, u_y by q_y, and u_x by q_y, at offsets of cells modulo `padded`."""
        t = self._transfer
        table: Fields = fft.irfft2(np.array([t.xx, t.yy, t.xy]), self.padded, workers=1)
        return table

    def _forward(self, fields: Fields) -> NDArray[np.complex128]:
        return fft.rfft2(fields, s=self.padded, axes=(-2, -1), workers=1)

    def _back(self, modes: NDArray[np.complex128]) -> Fields:
        nx, ny = self.shape
        field = fft.irfft2(modes, s=self.padded, axes=(-2, -1), workers=1, overwrite_x=True)
        return field[..., :nx, :ny]

    def shear(self, traction: Fields) -> Fields:
        """Return the tangential displacement (2, nx, ny) under tangential tractions (2, nx, ny)."""
        t = self._transfer
        along, across = self._forward(traction)
        return self._back(np.array([t.xx * along + t.xy * across, t.xy * along + t.yy * across]))

    def lift(self, traction: Fields) -> Field:
        """Return the normal displacement (nx, ny), inwards, under tangential tractions."""
        t = self._transfer
        along, across = self._forward(traction)
        return self._back(1j * (t.x * along + t.y * across))

    def drag(self, pressure: Field) -> Fields:
        """Return the tangential displacement (2, nx, ny) under a pressure."""
        t = self._transfer
        modes = -1j * self._forward(pressure)
        return self._back(np.array([t.x * modes, t.y * modes]))

    @cached_property
    def unit(self) -> float:
        """Power of two near the largest factor from traction to displacement."""
        return power_of_two(max(self._transfer.xx.max(), self._transfer.yy.max()))

    @cached_property
    def _inverse(self) -> tuple[tuple[int, int], Fields]:
        """Return padded shape and factors of the inverse periodic half-space, times a power of two.

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
        factors = [wavenumber / shear + more * part for part in (qx * qx, qy * qy)]
        return padded, np.array([*factors, more * (qx * qy)]) * self.unit

    def precondition(self, displacement: Fields) -> Fields:
        """Return the approximate traction, times `unit`, for a tangential displacement."""
        padded, (xx, yy, xy) = self._inverse
        along, across = fft.rfft2(displacement, s=padded, axes=(-2, -1), workers=1)
        modes = np.array([xx * along + xy * across, xy * along + yy * across])
        field = fft.irfft2(modes, s=padded, axes=(-2, -1), workers=1, overwrite_x=True)
        return field[:, : self.shape[0], : self.shape[1]]
