"""The viscoelastic half-space under travelling pressure, as an operator on a grid of cells."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import fft

from reference.halfspace.operators import check_grid, check_pressure
from reference.sliding import kernels
from reference.viscoelastic.materials import GeneralisedMaxwell

Array = NDArray[np.float64]


class Travelling:
    """What the sliding solver needs to know of a half-space: not symmetric, but positive definite.

    Parameters
    ----------
    shape, spacing
        Cells (nx, ny) and their sides.
    material : GeneralisedMaxwell
        Shear behaviour of a solid that dissipates; nu = 1/2.
    speed : float
        v > 0 of the pressure along +x, over the material.
    periodic : bool
        Whether the grid repeats, with zero mean displacement, or lies on a free half-space.

    Raises
    ------
    ValueError
        Listing what is wrong.
    """

    def __init__(
        self,
        shape: tuple[int, int],
        spacing: tuple[float, float],
        material: GeneralisedMaxwell,
        speed: float,
        *,
        periodic: bool = False,
    ) -> None:
        check_grid(shape, spacing, 1.0)
        faults = []
        if not material.equilibrium_modulus > 0:
            faults.append("material must be a solid: a fluid never carries a load at rest")
        if not (np.isfinite(speed) and speed > 0):
            faults.append(f"speed must be positive and finite, not {speed!r}")
        if faults:
            raise ValueError("; ".join(faults))
        self.shape = (int(shape[0]), int(shape[1]))
        self.spacing = (float(spacing[0]), float(spacing[1]))
        self.material, self.speed, self.periodic = material, float(speed), periodic
        doubled = (fft.next_fast_len(2 * n - 1, real=True) for n in self.shape)
        self.padded = self.shape if periodic else tuple(doubled)

    @property
    def cell_area(self) -> float:
        """Area of one cell, dx dy."""
        return self.spacing[0] * self.spacing[1]

    @property
    def relaxed_modulus(self) -> float:
        """E* = 4 G of the material at rest."""
        return 4 * self.material.equilibrium_modulus

    def coarser(self) -> Travelling:
        """Return the same half-space on cells of twice the side; the shape has to be even."""
        shape = (self.shape[0] // 2, self.shape[1] // 2)
        spacing = (2 * self.spacing[0], 2 * self.spacing[1])
        return Travelling(shape, spacing, self.material, self.speed, periodic=self.periodic)

    @cached_property
    def transfer(self) -> NDArray[np.complex128]:
        """Transfer function from pressure to displacement on the padded grid, modes of `rfft2`."""
        if self.periodic:
            return kernels.periodic(self.shape, self.spacing, self.material, self.speed)
        nx, ny = self.shape
        values = kernels.travelling(self.shape, self.spacing, self.material, self.speed)
        wrapped = np.zeros(self.padded)
        rows = np.arange(-(nx - 1), nx) % self.padded[0]
        wrapped[rows, :ny] = values
        if ny > 1:
            wrapped[rows, -(ny - 1) :] = values[:, :0:-1]
        return fft.rfft2(wrapped)

    @cached_property
    def datum(self) -> float:
        """Displacement that a unit mean pressure adds to the whole of a periodic grid, here.

        Any positive number makes the operator definite; what it adds is taken out of the
        penetration afterwards. Zero on the free half-space.
        """
        return float(np.abs(self.transfer).max()) if self.periodic else 0.0

    @cached_property
    def table(self) -> Array:
        """Displacement at an offset of (i, j) cells from a loaded one, indices modulo `padded`."""
        transfer = self.transfer.copy()
        transfer[0, 0] += self.datum
        return fft.irfft2(transfer, self.padded)

    def apply(self, pressure: ArrayLike) -> Array:
        """Displacement of all cell centres under cell pressures, of zero mean if periodic."""
        modes = fft.rfft2(check_pressure(pressure, self.shape), self.padded)
        modes *= self.transfer
        return fft.irfft2(modes, self.padded)[: self.shape[0], : self.shape[1]]
