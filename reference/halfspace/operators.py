"""The half-space as a linear operator from cell pressures to cell displacements.

Solvers see only `HalfSpace`: shape, spacing, `apply`. What the half-space looks like beyond the
grid (free, or the periodic images of the grid) is the operator's business.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import fft

from reference.halfspace import kernels

# One FFT thread: studies run one task per core, and threads inside a task would fight over them.
_WORKERS = 1


class HalfSpace(Protocol):
    """What the iterative solvers need to know of a half-space."""

    shape: tuple[int, int]
    spacing: tuple[float, float]
    effective_modulus: float
    periodic: bool

    @property
    def cell_area(self) -> float:
        """Area of one cell."""

    def apply(self, pressure: ArrayLike) -> NDArray[np.float64]:
        """Displacement of the cell centres under the given cell pressures."""


def check_grid(
    shape: tuple[int, int], spacing: tuple[float, float], effective_modulus: float
) -> None:
    """Raise one ValueError that lists everything wrong with a grid or its modulus."""
    faults = []
    if len(shape) != 2 or any(int(n) != n or n < 1 for n in shape):
        faults.append(f"shape must be two positive integers, not {shape!r}")
    if len(spacing) != 2 or not all(np.isfinite(s) and s > 0 for s in spacing):
        faults.append(f"spacing must be two positive lengths (dx, dy), not {spacing!r}")
    if not (np.isfinite(effective_modulus) and effective_modulus > 0):
        faults.append(f"effective_modulus must be positive and finite, not {effective_modulus!r}")
    if faults:
        raise ValueError("; ".join(faults))


def check_pressure(pressure: ArrayLike, shape: tuple[int, int]) -> NDArray[np.float64]:
    """Return the pressure as a double array of the operator's shape, or raise ValueError."""
    pressure = np.asarray(pressure, dtype=float)
    if pressure.shape != shape:
        raise ValueError(f"pressure has shape {pressure.shape}, the operator {shape}")
    return pressure


class FreeOperator:
    """Free half-space under a rectangle of cells with uniform pressure: u = K p, (19.2).

    The sum over cells is an exact linear convolution with Love's coefficients (`kernels.love`),
    done by real FFTs on a zero-padded grid: no periodic images.

    Parameters
    ----------
    shape : (int, int)
        Number of cells (nx, ny).
    spacing : (float, float)
        Cell sides (dx, dy), consistent units.
    effective_modulus : float
        E*, consistent units.

    Raises
    ------
    ValueError
        If an argument is not positive; all faults are listed.

    Examples
    --------
    >>> import numpy as np
    >>> K = FreeOperator((3, 3), (1.0, 1.0), 1.0)
    >>> u = K.apply(np.ones((3, 3)))
    >>> bool(np.isclose(u[1, 1], 3 * 4 * np.log(1 + np.sqrt(2)) / np.pi))
    True
    """

    periodic = False

    def __init__(
        self, shape: tuple[int, int], spacing: tuple[float, float], effective_modulus: float
    ) -> None:
        check_grid(shape, spacing, effective_modulus)
        self.shape = (int(shape[0]), int(shape[1]))
        self.spacing = (float(spacing[0]), float(spacing[1]))
        self.effective_modulus = float(effective_modulus)
        self._padded = tuple(fft.next_fast_len(2 * n - 1, real=True) for n in self.shape)
        self._transfer = self._transform()
        self._parts: dict[tuple[int, int], FreeOperator] = {}

    @property
    def cell_area(self) -> float:
        """Area of one cell, dx dy."""
        return self.spacing[0] * self.spacing[1]

    def _transform(self) -> NDArray[np.float64]:
        """Transform of the wrapped kernel: real, because the kernel is even in both offsets."""
        offsets = [np.minimum(np.arange(m), m - np.arange(m)) for m in self._padded]
        quarter = kernels.love(
            np.arange(offsets[0].max() + 1)[:, None],
            np.arange(offsets[1].max() + 1)[None, :],
            self.spacing,
            self.effective_modulus,
        )
        return fft.rfft2(quarter[np.ix_(*offsets)], workers=_WORKERS).real.copy()

    def apply(self, pressure: ArrayLike) -> NDArray[np.float64]:
        """Displacement of all cell centres under cell pressures of shape `shape`."""
        pressure = check_pressure(pressure, self.shape)
        nx, ny = self.shape
        # rows of zeros need no transform along y, and rows of no interest need none on the way back
        rows = fft.rfft(pressure, n=self._padded[1], axis=1, workers=_WORKERS)
        spectrum = fft.fft(rows, n=self._padded[0], axis=0, workers=_WORKERS)
        spectrum *= self._transfer
        rows = fft.ifft(spectrum, axis=0, overwrite_x=True, workers=_WORKERS)[:nx]
        return fft.irfft(rows, n=self._padded[1], axis=1, workers=_WORKERS)[:, :ny]

    def restrict(self, shape: tuple[int, int]) -> FreeOperator:
        """Operator of the same half-space on a smaller rectangle of the same cells (kept)."""
        if shape not in self._parts:
            self._parts[shape] = FreeOperator(shape, self.spacing, self.effective_modulus)
        return self._parts[shape]


class PeriodicOperator:
    """Half-space under periodic pressure with zero mean displacement: u^(q) = T(q) p^(q).

    Parameters
    ----------
    shape, spacing, effective_modulus
        As for `FreeOperator`; the period is (nx dx, ny dy).
    kernel : {"continuum", "cells"}
        T = 2/(E*|q|), or the same for pressures uniform on cells: see `kernels.periodic`.

    Raises
    ------
    ValueError
        If an argument is not positive or the kernel unknown; all faults are listed.

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
        check_grid(shape, spacing, effective_modulus)
        self.shape = (int(shape[0]), int(shape[1]))
        self.spacing = (float(spacing[0]), float(spacing[1]))
        self.effective_modulus = float(effective_modulus)
        self.kernel = kernel
        self._transfer = kernels.periodic(self.shape, self.spacing, self.effective_modulus, kernel)

    @property
    def cell_area(self) -> float:
        """Area of one cell, dx dy."""
        return self.spacing[0] * self.spacing[1]

    def apply(self, pressure: ArrayLike) -> NDArray[np.float64]:
        """Displacement (mean zero) of all cell centres under one period of pressures."""
        pressure = check_pressure(pressure, self.shape)
        spectrum = fft.rfft2(pressure, workers=_WORKERS)
        spectrum *= self._transfer
        return fft.irfft2(spectrum, s=self.shape, overwrite_x=True, workers=_WORKERS)
