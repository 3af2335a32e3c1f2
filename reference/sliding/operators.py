"""The viscoelastic half-space under travelling pressure, as an operator on a grid of cells."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import fft

from reference.arguments import positive_faults, refuse
from reference.contact.body import check_grid, check_pressure
from reference.sliding import kernels
from reference.viscoelastic.materials import GeneralisedMaxwell

Array = NDArray[np.float64]


class Travelling:
    """The half-space operator of the sliding solver: not symmetric, but positive definite.

    Parameters
    ----------
    shape, spacing
        Cells (nx, ny) and their sides.
    material : GeneralisedMaxwell
        Shear behaviour of a dissipative solid; nu = 1/2.
    speed : float
        v > 0 of the pressure along +x, relative to the material.
    periodic : bool
        Periodic grid with zero mean displacement, or a free half-space.
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
            faults.append("material must be a solid: a fluid cannot carry a static load")
        refuse(faults + positive_faults(speed=speed))
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
        """Relaxed modulus E* = 4 G of the material."""
        return 4 * self.material.equilibrium_modulus

    def coarser(self) -> Travelling:
        """Return the same half-space on cells of twice the side; the shape must be even."""
        shape = (self.shape[0] // 2, self.shape[1] // 2)
        spacing = (2 * self.spacing[0], 2 * self.spacing[1])
        return Travelling(shape, spacing, self.material, self.speed, periodic=self.periodic)

    @cached_property
    def transfer(self) -> NDArray[np.complex128]:
        """Transfer function from pressure to displacement on the padded grid, modes of `rfft2`."""
        if self.periodic:
            return kernels.periodic(self.shape, self.spacing, self.material, self.speed)
        nx, ny = self.shape
        values = self._coefficients()
        wrapped = np.zeros(self.padded)
        rows = np.arange(-(nx - 1), nx) % self.padded[0]
        wrapped[rows, :ny] = values
        if ny > 1:
            wrapped[rows, -(ny - 1) :] = values[:, :0:-1]
        return fft.rfft2(wrapped)

    def _coefficients(self) -> Array:
        """Displacements of the free half-space at all offsets, as `kernels.travelling`."""
        return kernels.travelling(self.shape, self.spacing, self.material, self.speed)

    @cached_property
    def datum(self) -> float:
        """Uniform displacement by unit mean pressure on a periodic grid, by convention.

        Any positive number makes the operator definite; its contribution is subtracted from the
        penetration afterwards. Zero for the free half-space.
        """
        return float(np.abs(self.transfer).max()) if self.periodic else 0.0

    @cached_property
    def table(self) -> Array:
        """Displacement at an offset of (i, j) cells from the load, indices modulo `padded`."""
        transfer = self.transfer.copy()
        transfer[0, 0] += self.datum
        return fft.irfft2(transfer, self.padded)

    def apply(self, pressure: ArrayLike) -> Array:
        """Return the displacement of all cells under cell pressures, with zero mean if periodic."""
        modes = fft.rfft2(check_pressure(pressure, self.shape), self.padded)
        modes *= self.transfer
        return fft.irfft2(modes, self.padded)[: self.shape[0], : self.shape[1]]


class TravellingPlane(Travelling):
    """The half-space below strips of infinite length: plane strain, forces per length.

    Displacements, and a penetration with them, are known up to a constant only.

    Parameters
    ----------
    cells, width
        Number and side of the cells along x.
    material, speed
        As for `Travelling`.
    """

    def __init__(
        self, cells: int, width: float, material: GeneralisedMaxwell, speed: float
    ) -> None:
        super().__init__((cells, 1), (width, 1.0), material, speed)

    def _coefficients(self) -> Array:
        return kernels.travelling_plane(self.shape[0], self.spacing[0], self.material, self.speed)
