"""A viscoelastic half-space under pressure travelling at constant speed, on a grid of cells.

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
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy import fft

from reference.arrays import Array, Modes
from reference.closed_form.numerics import gauss_rule
from reference.contact.body import check_grid, check_pressure
from reference.errors import positive_faults, refuse
from reference.halfspace import kernels
from reference.viscoelastic.materials import GeneralisedMaxwell

_NODES = 12  # per panel; 1e-9 of the own-cell value, with the logarithms at the cell's edges
_DEEP = 44.0  # exp(-44) is negligible


class Travelling:
    """The half-space operator of the sliding solver: not symmetric, but positive definite.

    The material is a dissipative solid in shear, nu = 1/2; the pressure moves along +x at a
    speed relative to it. Periodic, the mean displacement is zero.
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

    def coarser(self) -> Travelling:
        """Return the same half-space on cells of twice the side; the shape must be even."""
        shape = (self.shape[0] // 2, self.shape[1] // 2)
        spacing = (2 * self.spacing[0], 2 * self.spacing[1])
        return Travelling(shape, spacing, self.material, self.speed, periodic=self.periodic)

    def apply(self, pressure: ArrayLike) -> Array:
        """Return the displacement of all cells under cell pressures, with zero mean if periodic."""
        modes = fft.rfft2(check_pressure(pressure, self.shape), self.padded)
        modes *= self.transfer
        return fft.irfft2(modes, self.padded)[: self.shape[0], : self.shape[1]]

    @cached_property
    def table(self) -> Array:
        """Displacement at an offset of (i, j) cells from the load, indices modulo `padded`."""
        transfer = self.transfer.copy()
        transfer[0, 0] += self.datum
        return fft.irfft2(transfer, self.padded)

    @cached_property
    def datum(self) -> float:
        """Uniform displacement by unit mean pressure on a periodic grid, by convention.

        Any positive number makes the operator definite; penetrations are without it.
        """
        return float(np.abs(self.transfer).max()) if self.periodic else 0.0

    @cached_property
    def transfer(self) -> Modes:
        """Transfer function from pressure to displacement on the padded grid, modes of `rfft2`.

        Of a periodic grid 2/(|q| 4 G*(-q_x v)), and zero for q = 0. Waves along y do not travel and
        have the relaxed modulus; the Nyquist wave along x has no direction, and the real part is
        used.
        """
        nx, ny = self.shape
        if self.periodic:
            qx, _ = kernels.wavenumbers(self.shape, self.spacing)
            softness = 1 / (4 * self.material.dynamic_modulus(-self.speed * qx))
            if nx % 2 == 0:
                softness[nx // 2] = softness[nx // 2].real
            return kernels.periodic(self.shape, self.spacing, 1.0) * softness
        values = self.coefficients()
        wrapped = np.zeros(self.padded)
        rows = np.arange(-(nx - 1), nx) % self.padded[0]
        wrapped[rows, :ny] = values
        if ny > 1:
            wrapped[rows, -(ny - 1) :] = values[:, :0:-1]
        return fft.rfft2(wrapped)

    def coefficients(self) -> Array:
        """Return the displacement of the free half-space under unit pressure on one cell.

        At offsets -(nx - 1) ... nx - 1 of the point from the loaded cell in x, and 0 ... ny - 1 in
        y.
        """
        across = np.arange(self.shape[1])[None, :]
        return self._crept(lambda offsets: kernels.love(offsets, across, self.spacing, 1.0))

    def _crept(self, elastic: Callable[[Array], Array]) -> Array:
        """Return the displacement with all creep modes; `elastic` at offsets along x, E* = 1."""
        nx, modes = self.shape[0], self.material.creep_modes
        offsets = np.arange(-(nx - 1), nx)[:, None].astype(float)
        at_once = elastic(offsets)
        total = modes.instantaneous * at_once
        for compliance, time in zip(modes.compliances, modes.times, strict=True):
            # averaged over exp(-s/reach)/reach from far ahead back to the rear, in cells:
            # A(i) = int_0^1 ... + exp(-1/reach) A(i + 1)
            reach = self.speed / self.spacing[0] * time
            # panels of a cell have its middle as an edge, and are finer at first
            falls = [reach * 2.0**k for k in range(6) if reach * 2.0**k < 1]
            averaged = np.zeros_like(at_once)
            for s, weight in _memory_rule(sorted({0.0, 0.5, 1.0, *falls}), reach):
                averaged += weight * elastic(offsets + s)
            # panels ahead of the grid grow with the distance
            ends, width, last = [0.0], min(nx / 2, reach), _DEEP * reach
            while ends[-1] < last:
                ends.append(min(ends[-1] + width, last))
                width = min(2 * width, 4 * reach)
            following = np.zeros(at_once.shape[1])
            for s, weight in _memory_rule(ends, reach):
                following += weight * elastic(np.array([[float(nx) + s]]))[0]
            decay = np.exp(-1 / reach)
            for i in range(2 * nx - 2, -1, -1):
                following = averaged[i] + decay * following
                averaged[i] = following
            total = total + compliance * averaged
        return total / 4


class TravellingPlane(Travelling):
    """The half-space below strips of infinite length: plane strain, forces per length.

    A line force displaces the surface by -2/(pi E*) ln|x| (Johnson 1985, eq. 2.19), up to a
    constant, which a penetration has with it. It is chosen so that the surface is pressed in within
    a hundred grids, and as many ways that the slowest of the modes remembers. There are `cells` of
    one width along x.
    """

    def __init__(
        self, cells: int, width: float, material: GeneralisedMaxwell, speed: float
    ) -> None:
        super().__init__((cells, 1), (width, 1.0), material, speed)

    def coefficients(self) -> Array:
        """Return the displacement at offsets along x, shape (2 cells - 1, 1)."""
        cells, width = self.shape[0], self.spacing[0]
        remembered = self.speed / width * max(self.material.creep_modes.times, default=0.0)
        far = np.log(100 * (cells + remembered))

        def elastic(offsets: Array) -> Array:
            ahead, behind = (
                np.where(x == 0, 0.0, x * np.log(np.where(x == 0, 1.0, abs(x))))
                for x in (offsets + 0.5, offsets - 0.5)
            )
            return 2 * width / np.pi * (1 + far - (ahead - behind))

        return self._crept(elastic)


def _memory_rule(ends: list[float], reach: float) -> zip[tuple[float, float]]:
    """Return nodes and weights of exp(-s/reach)/reach ds on panels, smoothed at their ends.

    s = a + (b - a) t^3 (10 - 15 t + 6 t^2) makes x ln x at an end smooth enough for Gauss points.
    """
    nodes, weights = gauss_rule(_NODES)
    t = (1 + nodes) / 2
    shape, slope = t**3 * (10 - 15 * t + 6 * t**2), 30 * t**2 * (1 - t) ** 2
    begin, width = np.array(ends[:-1])[:, None], np.diff(ends)[:, None]
    s = (begin + width * shape).ravel()
    mass = (width * slope * weights / 2).ravel() * np.exp(-s / reach) / reach
    return zip(s, mass, strict=True)
