"""An elastic body as the linear map from pressures on a grid of cells to their displacements.

Solvers use only `ElasticBody`: shape, spacing, the convolution with its compliance, and the
stiffness of its waves. The half-space, layered bodies and finite elements on a grid are its
subclasses; they define the body beyond the grid (free, or periodic images of the grid).

The convolution of a real field with a real, even kernel is by FFT:

    out = F^-1[ T F[field, padded with zeros] ], cropped to the field,

T(q_x, q_y) real and even in both wavenumbers: influence coefficients, or |q|. Axes are transformed
separately, so that rows of zeros and cropped rows are never transformed. Single precision takes
half the time of double.

Of T only q_x, q_y >= 0 are kept. A large field is transformed in blocks: rows into one array of
modes, there some columns at a time forth and back, as many as the cache holds, and rows of it into
the result. Padding exists in one block at a time, and the modes are all that is held besides.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Any, Self, TypeVar

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, DTypeLike
from scipy import fft

from reference.arrays import Array, Floats
from reference.contact import pieces
from reference.errors import positive_faults, refuse, spacing_faults

Cached = TypeVar("Cached")

# Up to this many padded cells the field is one block: its modes stay in the processor's cache.
_ONE_BLOCK = 600**2
# Numbers in a block of columns, and the fewest columns: several fill a line of the cache.
_COLUMNS, _FEWEST = 2**17, 16
# Kernels of coarser grids and of windows are kept for the next solve up to so many cells.
LARGEST_KEPT = 2**20


class ElasticBody:
    """A body under a grid of cells: u = K p, a convolution.

    Kernels are computed on first use and cached, and a preconditioner is adapted to every contact,
    so a body must be used by one thread at a time. Pickles contain only the arguments.
    """

    periodic: bool  # whether the grid repeats
    # How far outside Hertz's circle `areas.located_area`, whose law is that of Love's cells, puts
    # the rim, in cells (`docs/examples/rim_excess.py`).
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

    @property
    def bounded(self) -> bool:
        """Whether cells with g >= d are never in contact, as where pressure lifts no cell."""
        return False

    def coefficients(self, shape: tuple[int, int]) -> Array:
        """Displacement per pressure at offsets from zero to less than `shape`, of a free body."""
        raise NotImplementedError

    def restrict(self, shape: tuple[int, int]) -> Self:
        """Return the same body on a smaller rectangle of cells, where it is `bounded`."""
        raise NotImplementedError

    def cached(self, key: Hashable, make: Callable[[], Cached]) -> Cached:
        """Return the cached result of `make` for this key."""
        if key not in self._cache:
            self._cache[key] = make()
        return self._cache[key]

    def _transfer(self) -> Array:
        """Return the transfer function on the modes of `rfft2`; those of q_x < 0 are not read."""
        raise NotImplementedError

    def _alike(self, shape: tuple[int, int], spacing: tuple[float, float]) -> Self:
        """Return the same body under other cells."""
        raise NotImplementedError

    def wave_stiffness(self, wavenumber: Array) -> Array:
        """Return pressure over displacement of waves, in units of E*/2: |q| on the half-space."""
        return wavenumber

    @property
    def unit(self) -> float:
        """Power of two near the largest transfer factor, the unit of `convolution`."""
        self.convolution(np.float64)
        return float(self._cache["unit"])

    @property
    def transfer(self) -> Array:
        """Transfer function from pressure to displacement on the padded grid.

        On the modes of `rfft2` with q_x >= 0; it is even in both wavenumbers. A new array.
        """
        return np.asarray(self.convolution(np.float64).transfer * self.unit, np.float64)

    def coarser(self) -> Self | None:
        """Body under every second point, or None if the period is no multiple of it.

        Cached up to `LARGEST_KEPT` cells.
        """
        if self.periodic and any(n % 2 for n in self.shape):
            return None
        shape = (self.shape[0] + 1) // 2, (self.shape[1] + 1) // 2
        spacing = 2 * self.spacing[0], 2 * self.spacing[1]
        if shape[0] * shape[1] > LARGEST_KEPT:
            return self._alike(shape, spacing)
        return self.cached("coarser", lambda: self._alike(shape, spacing))

    def convolution(self, dtype: DTypeLike) -> Convolution:
        """Return the convolution from pressure to displacement/`unit` in a given precision."""
        kind, exact = np.dtype(dtype), np.dtype(np.float64)
        if "unit" not in self._cache:  # that in double precision alone keeps the kernel
            transfer = self._transfer()[: self._padded[0] // 2 + 1]
            unit = power_of_two(transfer.max())
            kernel = Convolution(self.shape, self._padded, transfer / unit, exact)
            self._cache |= {"unit": unit, exact: kernel}
        transfer = self._cache[exact].transfer
        return self.cached(kind, lambda: Convolution(self.shape, self._padded, transfer, kind))

    def apply(self, pressure: ArrayLike) -> Array:
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


def check_pressure(pressure: ArrayLike, shape: tuple[int, int]) -> Array:
    """Return the pressure as a double array of the operator's shape, or raise ValueError."""
    pressure = np.asarray(pressure, dtype=float)
    if pressure.shape != shape:
        raise ValueError(f"pressure has shape {pressure.shape}, the operator {shape}")
    return pressure


def wavenumbers(shape: tuple[int, int], spacing: tuple[float, float]) -> tuple[Array, Array]:
    """Return angular wavenumbers (q_x, q_y) of a real FFT, of shapes (nx, 1) and (1, ny//2 + 1)."""
    qx = 2 * np.pi * fft.fftfreq(shape[0], spacing[0])
    qy = 2 * np.pi * fft.rfftfreq(shape[1], spacing[1])
    return qx[:, None], qy[None, :]


def quarter(shape: tuple[int, int], spacing: tuple[float, float]) -> Array:
    """Return |q| for q_x, q_y >= 0, of shape (nx//2 + 1, ny//2 + 1): what even functions need."""
    qx, qy = wavenumbers(shape, spacing)
    return np.hypot(qx[: shape[0] // 2 + 1], qy)


class Convolution:
    """Convolution of fields of one shape with one kernel.

    `padded` has the lengths of the transforms: `shape` for a periodic field, at least the sum of
    field and kernel lengths less one for a free one. The transfer function is real, on the modes of
    `rfft2`, and even in both wavenumbers: rows beyond padded[0]//2 are not read, and not kept. The
    dtype, float32 or float64, is that of fields, transforms and result.

    >>> one_cell_on = np.exp(-2j * np.pi * np.fft.fftfreq(6))[:, None].real * np.ones((1, 3))
    >>> neighbours = Convolution((6, 4), (6, 4), one_cell_on, np.float64)
    >>> field = np.zeros((6, 4))
    >>> field[0, 1] = 2.0
    >>> neighbours(field)[:, 1].round(12) + 0.0
    array([0., 1., 0., 0., 0., 1.])
    """

    def __init__(
        self, shape: tuple[int, int], padded: tuple[int, int], transfer: ArrayLike, dtype: DTypeLike
    ) -> None:
        self.shape = shape
        self.padded = padded
        self.transfer = np.array(np.asarray(transfer)[: padded[0] // 2 + 1], dtype, order="C")

    def __call__(self, field: Floats, out: Floats | None = None) -> Floats:
        """Return the convolution of a field of the right shape, in the precision of the kernel.

        `out` receives the result, by default a new array; it may be the field itself.
        """
        if out is None:
            out = np.empty(self.shape, self.transfer.dtype)
        for array in (field, out):
            if array.shape != self.shape:
                raise ValueError(f"fields must have shape {self.shape}, not {array.shape}")
        field = np.asarray(field, self.transfer.dtype)
        rows, columns, (length, width) = *self.shape, self.padded
        if length * width <= _ONE_BLOCK:
            modes = fft.rfft(field, width, axis=1, workers=1)
            modes = self._columnwise(modes)
            out[:] = fft.irfft(modes, width, axis=1, workers=1)[:, :columns]
            return out
        half = width // 2 + 1
        modes = np.empty((rows, half), np.result_type(self.transfer, np.complex64))

        def forward(part: slice) -> None:
            modes[part] = fft.rfft(field[part], width, axis=1, workers=1)

        def columnwise(part: slice) -> None:
            block = self._columnwise(modes[:, part], part.start)
            if not np.may_share_memory(block, modes):
                modes[:, part] = block

        def backward(part: slice) -> None:
            out[part] = fft.irfft(modes[part], width, axis=1, workers=1)[:, :columns]

        pieces.over(rows, pieces.rows_of(width), forward)
        pieces.over(half, max(_FEWEST, _COLUMNS // length), columnwise)
        pieces.over(rows, pieces.rows_of(width), backward)
        return out

    def _columnwise(self, modes: Floats, first: int = 0) -> Floats:
        """Return columns of modes, from a first one on, times their factors of the transfer.

        Overwrites them unless they are padded.
        """
        # in place where possible, as new memory would cost as much as the arithmetic
        block = fft.fft(modes, self.padded[0], axis=0, overwrite_x=True, workers=1)
        _multiply(block.view(self.transfer.dtype), self.transfer, first)
        return fft.ifft(block, axis=0, overwrite_x=True, workers=1)[: len(modes)]


@njit(cache=True, nogil=True, error_model="numpy")
def _multiply(parts, factors, first):
    """Multiply complex rows, as interleaved real and imaginary parts, by factors from a column on.

    Of a slice of the factors it would be compiled once more, on the first large grid.
    """
    for i in range(parts.shape[0]):
        row = min(i, parts.shape[0] - i)
        for j in range(parts.shape[1] // 2):
            parts[i, 2 * j] *= factors[row, first + j]
            parts[i, 2 * j + 1] *= factors[row, first + j]
