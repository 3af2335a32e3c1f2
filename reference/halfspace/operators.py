"""The half-space as a linear operator from cell pressures to cell displacements.

Solvers use only `HalfSpace`: shape, spacing, `apply`. The operator defines the half-space beyond
the grid (free, or periodic images of the grid).
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Any, Self, TypeVar

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray
from scipy import fft

from reference.arguments import positive_faults, refuse, spacing_faults
from reference.halfspace import kernels, pieces
from reference.halfspace.convolution import Convolution

Cached = TypeVar("Cached")

# The rim of pressures through the cells' values lies further out than that of uniform ones.
RIM_EXCESS: dict[str, float] = {"continuum": 0.016, "cells": 0.0}
# Kernels of coarser grids and of windows are kept for the next solve up to so many cells.
LARGEST_KEPT = 2**20
# Arrays that Love's formula needs beside its result.
_TEMPORARIES = 16


class HalfSpace:
    """The half-space operator of the iterative solvers.

    Kernels are computed on first use and cached, and a preconditioner is adapted to every contact,
    so an operator must be used by one thread at a time. Pickles contain only the arguments.

    Attributes
    ----------
    periodic : bool
        Whether the grid repeats.
    rim_excess : float
        How far outside Hertz's circle the law of `contact_line`, which is that of Love's cells,
        puts the rim, in cells (`docs/examples/rim_excess.py`).
    """

    periodic: bool
    rim_excess: float = 0.0

    def __init__(
        self, shape: tuple[int, int], spacing: tuple[float, float], effective_modulus: float
    ) -> None:
        check_grid(shape, spacing, effective_modulus)
        self.shape = (int(shape[0]), int(shape[1]))
        self.spacing = (float(spacing[0]), float(spacing[1]))
        self.effective_modulus = float(effective_modulus)
        # a period needs no padding
        self._padded = self.shape
        self._cache: dict[Hashable, Any] = {}

    def __getstate__(self) -> dict[str, Any]:
        return self.__dict__ | {"_cache": {}}

    @property
    def cell_area(self) -> float:
        """Area of one cell, dx dy."""
        return self.spacing[0] * self.spacing[1]

    @property
    def mean_compliance(self) -> float:
        """Mean displacement per mean pressure of a periodic body; zero on the half-space."""
        return float(self.convolution(np.float64).transfer[0, 0]) * self.unit

    @property
    def sinks(self) -> bool:
        """Whether a uniform pressure displaces a periodic body: not so on the half-space."""
        return self.periodic and self.mean_compliance > 0

    def cached(self, key: Hashable, make: Callable[[], Cached]) -> Cached:
        """Return the cached result of `make` for this key."""
        if key not in self._cache:
            self._cache[key] = make()
        return self._cache[key]

    def _transfer(self) -> NDArray[np.float64]:
        """Return the transfer function on the modes of `rfft2`; those of q_x < 0 are not read."""
        raise NotImplementedError

    def wave_stiffness(self, wavenumber: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return pressure over displacement of waves, in units of E*/2: |q| on the half-space."""
        return wavenumber

    @property
    def unit(self) -> float:
        """Power of two near the largest transfer factor, the unit of `convolution`."""
        return self._exact()[1]

    @property
    def transfer(self) -> NDArray[np.float64]:
        """Transfer function from pressure to displacement on the padded grid.

        On the modes of `rfft2` with q_x >= 0; it is even in both wavenumbers. A new array.
        """
        return np.asarray(self.convolution(np.float64).transfer * self.unit, np.float64)

    def _alike(self, shape: tuple[int, int], spacing: tuple[float, float]) -> Self:
        """Return the operator of the same body on other cells."""
        raise NotImplementedError

    def coarser(self) -> Self | None:
        """Operator on every second point (cached), or None if the period is no multiple of it."""
        if self.periodic and any(n % 2 for n in self.shape):
            return None
        shape = (self.shape[0] + 1) // 2, (self.shape[1] + 1) // 2
        spacing = 2 * self.spacing[0], 2 * self.spacing[1]
        return self.cached("coarser", lambda: self._alike(shape, spacing))

    def convolution(self, dtype: DTypeLike) -> Convolution:
        """Return the convolution from pressure to displacement/`unit` in a given precision."""
        dtype, exact = np.dtype(dtype), self._exact()[0]
        if dtype == np.float64:
            return exact

        def make() -> Convolution:
            return Convolution(self.shape, self._padded, exact.transfer, dtype)

        return self.cached(("convolution", dtype.name), make)

    def _exact(self) -> tuple[Convolution, float]:
        """Return the convolution in double precision, which alone keeps the kernel, and `unit`."""

        def make() -> tuple[Convolution, float]:
            transfer = self._transfer()[: self._padded[0] // 2 + 1]
            unit = power_of_two(transfer.max())
            return Convolution(self.shape, self._padded, transfer / unit, np.float64), unit

        return self.cached("exact", make)

    def forget(self) -> None:
        """Drop all that is kept; it is made again when needed."""
        self._cache.clear()

    def apply(self, pressure: ArrayLike) -> NDArray[np.float64]:
        """Return the displacement of all cell centres under cell pressures of shape `shape`."""
        pressure = np.ascontiguousarray(check_pressure(pressure, self.shape))
        displacement = np.asarray(self.convolution(np.float64)(pressure), dtype=np.float64)
        displacement *= self.unit
        return displacement


def window(
    parts: dict[tuple[int, int], Cached],
    shape: tuple[int, int],
    make: Callable[[tuple[int, int]], Cached],
) -> Cached:
    """Return the operator on a window of cells, of the kept ones or a new one.

    The last ones are kept, of `LARGEST_KEPT` cells together: a sweep has as many as loads.
    """
    part = parts.pop(shape, None)
    while parts and sum(n * m for n, m in (*parts, shape)) > LARGEST_KEPT:
        del parts[next(iter(parts))]
    parts[shape] = make(shape) if part is None else part
    return parts[shape]


def power_of_two(value: float) -> float:
    """Return the largest power of two up to a positive value."""
    return float(2.0 ** (np.frexp(value)[1] - 1)) if value > 0 else 1.0


def check_grid(
    shape: tuple[int, int], spacing: tuple[float, float], effective_modulus: float
) -> None:
    """Raise one ValueError that lists all errors in a grid or its modulus."""
    faults = []
    if len(shape) != 2 or any(int(n) != n or n < 1 for n in shape):
        faults.append(f"shape must be two positive integers, not {shape!r}")
    faults += spacing_faults(spacing)
    faults += positive_faults(effective_modulus=effective_modulus)
    refuse(faults)


def check_pressure(pressure: ArrayLike, shape: tuple[int, int]) -> NDArray[np.float64]:
    """Return the pressure as a double array of the operator's shape, or raise ValueError."""
    pressure = np.asarray(pressure, dtype=float)
    if pressure.shape != shape:
        raise ValueError(f"pressure has shape {pressure.shape}, the operator {shape}")
    return pressure


class FreeOperator(HalfSpace):
    """Free half-space under a rectangle of cells with uniform pressure: u = K p, (19.2).

    The sum over cells is an exact linear convolution with Love's coefficients (`kernels.love`),
    by real FFTs on a zero-padded grid, without periodic images.

    Parameters
    ----------
    shape : (int, int)
        Number of cells (nx, ny).
    spacing : (float, float)
        Cell sides (dx, dy), consistent units.
    effective_modulus : float
        E*, consistent units.

    Examples
    --------
    >>> import numpy as np
    >>> K = FreeOperator((3, 3), (1.0, 1.0), 1.0)
    >>> u = K.apply(np.ones((3, 3)))
    >>> bool(np.isclose(u[1, 1], 3 * 4 * np.log(1 + np.sqrt(2)) / np.pi))
    True
    """

    periodic = False

    @property
    def lifts(self) -> bool:
        """Whether pressure on a cell may raise another: never on the half-space."""
        return False

    def __init__(
        self, shape: tuple[int, int], spacing: tuple[float, float], effective_modulus: float
    ) -> None:
        super().__init__(shape, spacing, effective_modulus)
        # an even number of cells, so that the kernel's transform is one of cosines
        self._padded = tuple(2 * fft.next_fast_len(n, real=True) for n in self.shape)

    def coefficients(self, shape: tuple[int, int]) -> NDArray[np.float64]:
        """Love's coefficients at offsets from zero to less than `shape`; (19.3)."""
        coefficients = self._cache.get("coefficients")
        if coefficients is None or any(
            n > k for n, k in zip(shape, coefficients.shape, strict=True)
        ):
            # more than needed, as the next window of a sweep may be larger
            size = tuple(min(n, max(64, k)) for n, k in zip(self.shape, shape, strict=True))
            coefficients = self._love(*size)
            self._cache["coefficients"] = coefficients
        return coefficients[: shape[0], : shape[1]]

    def _transfer(self) -> NDArray[np.float64]:
        """Return the transform of the even kernel, by cosines; unused offsets are zero."""
        kernel = np.zeros([n // 2 + 1 for n in self._padded])
        kept = "coefficients" in self._cache
        kernel[: self.shape[0], : self.shape[1]] = self.coefficients(self.shape)
        if not kept and kernel.size > LARGEST_KEPT:
            self._cache.pop("coefficients", None)  # no window has asked for them
        for axis in (0, 1):
            kernel = fft.dct(kernel, type=1, axis=axis, overwrite_x=True, workers=1)
        return kernel

    def _love(self, rows: int, columns: int) -> NDArray[np.float64]:
        """Return Love's coefficients, some rows at a time."""
        table = np.empty((rows, columns))

        def fill(part: slice) -> None:
            i, j = np.ix_(np.arange(part.start, part.stop), np.arange(columns))
            table[part] = kernels.love(i, j, self.spacing, self.effective_modulus)

        pieces.over(rows, pieces.rows_of(_TEMPORARIES * columns), fill)
        return table

    def _alike(self, shape: tuple[int, int], spacing: tuple[float, float]) -> Self:
        return type(self)(shape, spacing, self.effective_modulus)

    def restrict(self, shape: tuple[int, int]) -> Self:
        """Return the operator of the same body on a smaller rectangle of cells (cached)."""
        parts: dict[tuple[int, int], Self] = self.cached("restricted", dict)
        return window(parts, shape, self._part)

    def _part(self, shape: tuple[int, int]) -> Self:
        part = self._alike(shape, self.spacing)
        part._cache["coefficients"] = self.coefficients(shape)
        return part


class PeriodicOperator(HalfSpace):
    """Half-space under periodic pressure with zero mean displacement: u^(q) = T(q) p^(q).

    Parameters
    ----------
    shape, spacing, effective_modulus
        As for `FreeOperator`; the period is (nx dx, ny dy).
    kernel : {"continuum", "cells"}
        T = 2/(E*|q|), or the same for pressures uniform on cells: see `kernels.periodic`.

    Examples
    --------
    >>> import numpy as np
    >>> x = np.arange(16) / 16
    >>> p = np.broadcast_to(np.cos(2 * np.pi * x)[:, None], (16, 16))
    >>> u = PeriodicOperator((16, 16), (1 / 16, 1 / 16), 1.0).apply(p)
    >>> bool(np.allclose(u, p / np.pi))
    True
    """

    periodic = True

    def __init__(
        self,
        shape: tuple[int, int],
        spacing: tuple[float, float],
        effective_modulus: float,
        kernel: kernels.Kernel = "continuum",
    ) -> None:
        super().__init__(shape, spacing, effective_modulus)
        self.kernel = kernel
        self.rim_excess = RIM_EXCESS.get(kernel, 0.0)
        _ = self.unit  # raises for an unknown kernel

    def _transfer(self) -> NDArray[np.float64]:
        grid = self.shape, self.spacing
        return kernels.periodic_quarter(*grid, self.effective_modulus, self.kernel)

    def _alike(self, shape: tuple[int, int], spacing: tuple[float, float]) -> Self:
        return type(self)(shape, spacing, self.effective_modulus, self.kernel)
