"""Convolution of a real field with a real, even kernel by FFT.

    out = F^-1[ T F[field, padded with zeros] ], cropped to the field,

T(q_x, q_y) real and even in both wavenumbers: influence coefficients, or |q|. Axes are transformed
separately, so that rows of zeros and cropped rows are never transformed. Single precision takes
half the time of double.

Of T only q_x, q_y >= 0 are kept. A large field is transformed in blocks: rows into one array of
modes, there some columns at a time forth and back, as many as the cache holds, and rows of it into
the result. Padding exists in one block at a time, and the modes are all that is held beside field
and result: 4 bytes per cell of a periodic field in single precision, 8 in double; twice that of a
free one.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, DTypeLike, NDArray
from scipy import fft

from reference.contact import pieces

Array = NDArray[np.floating]
Field = NDArray[np.float64]

# Up to this many padded cells the field is one block: its modes stay in the processor's cache.
_ONE_BLOCK = 600**2
# Numbers in a block of columns, and the fewest columns: several fill a line of the cache.
_COLUMNS, _FEWEST = 2**17, 16


def wavenumbers(shape: tuple[int, int], spacing: tuple[float, float]) -> tuple[Field, Field]:
    """Return angular wavenumbers (q_x, q_y) of a real FFT, of shapes (nx, 1) and (1, ny//2 + 1)."""
    qx = 2 * np.pi * fft.fftfreq(shape[0], spacing[0])
    qy = 2 * np.pi * fft.rfftfreq(shape[1], spacing[1])
    return qx[:, None], qy[None, :]


def quarter(shape: tuple[int, int], spacing: tuple[float, float]) -> Field:
    """Return |q| for q_x, q_y >= 0, of shape (nx//2 + 1, ny//2 + 1): what even functions need."""
    qx, qy = wavenumbers(shape, spacing)
    return np.hypot(qx[: shape[0] // 2 + 1], qy)


class Convolution:
    """Convolution of fields of one shape with one kernel.

    Parameters
    ----------
    shape : (int, int)
        Shape of field and result.
    padded : (int, int)
        Lengths of the transforms: `shape` for a periodic field, at least the sum of field and
        kernel lengths less one for a free one.
    transfer : array_like, shape (padded[0]//2 + 1 or padded[0], padded[1]//2 + 1)
        Real transfer function on the modes of `rfft2`, even in both wavenumbers; rows beyond
        padded[0]//2 are not read.
    dtype : float32 or float64
        Precision of fields, transforms and result.

    Attributes
    ----------
    transfer : ndarray, shape (padded[0]//2 + 1, padded[1]//2 + 1)
        The transfer function that is kept, in this precision.

    Examples
    --------
    >>> one_cell_on = np.exp(-2j * np.pi * np.fft.fftfreq(6))[:, None].real * np.ones((1, 3))
    >>> neighbours = Convolution((6, 4), (6, 4), one_cell_on, np.float64)
    >>> field = np.zeros((6, 4))
    >>> field[0, 1] = 2.0
    >>> neighbours(field)[:, 1].round(12) + 0.0
    array([0., 1., 0., 0., 0., 1.])
    """

    def __init__(
        self,
        shape: tuple[int, int],
        padded: tuple[int, int],
        transfer: ArrayLike,
        dtype: DTypeLike,
    ) -> None:
        self.shape = shape
        self.padded = padded
        self.transfer = np.array(np.asarray(transfer)[: padded[0] // 2 + 1], dtype, order="C")

    def __call__(self, field: Array, out: Array | None = None) -> Array:
        """Return the convolution of a field of the right shape, in the precision of the kernel.

        `out` receives the result, by default a new array; it may be the field itself.

        Raises
        ------
        ValueError
            If the field or `out` has another shape.
        """
        if out is None:
            out = np.empty(self.shape, self.transfer.dtype)
        for array in (field, out):
            if array.shape != self.shape:
                raise ValueError(f"fields must have shape {self.shape}, not {array.shape}")
        field = np.asarray(field, self.transfer.dtype)
        if self.padded[0] * self.padded[1] > _ONE_BLOCK:
            self._convolve_blocks(field, out)
        else:
            modes = fft.rfft(field, self.padded[1], axis=1, workers=1)
            out[:] = self._of_rows(self._columnwise(modes, self.transfer))
        return out

    def set_mean_factor(self, value: float) -> None:
        """Change the transfer function at zero wavenumber."""
        self.transfer[0, 0] = value

    def _convolve_blocks(self, field: Array, out: Array) -> None:
        rows, (length, width) = self.shape[0], self.padded
        half = width // 2 + 1
        modes = np.empty((rows, half), np.result_type(self.transfer, np.complex64))

        def forward(part: slice) -> None:
            modes[part] = fft.rfft(field[part], width, axis=1, workers=1)

        def columnwise(part: slice) -> None:
            block = self._columnwise(modes[:, part], self.transfer[:, part])
            if not np.may_share_memory(block, modes):
                modes[:, part] = block

        def backward(part: slice) -> None:
            out[part] = self._of_rows(modes[part])

        pieces.over(rows, pieces.rows_of(width), forward)
        pieces.over(half, max(_FEWEST, _COLUMNS // length), columnwise)
        pieces.over(rows, pieces.rows_of(width), backward)

    def _columnwise(self, modes: Array, factors: Array) -> Array:
        """Return columns of modes times their factors; overwrites them unless they are padded."""
        # in place where possible, as new memory would cost as much as the arithmetic
        block = fft.fft(modes, self.padded[0], axis=0, overwrite_x=True, workers=1)
        _multiply(block.view(factors.dtype), factors)
        return fft.ifft(block, axis=0, overwrite_x=True, workers=1)[: len(modes)]

    def _of_rows(self, modes: Array) -> Array:
        return fft.irfft(modes, self.padded[1], axis=1, workers=1)[:, : self.shape[1]]


@njit(cache=True, nogil=True, error_model="numpy")
def _multiply(parts, factors):
    """Multiply complex rows, given as interleaved real and imaginary parts, by real factors."""
    for i in range(parts.shape[0]):
        row = min(i, parts.shape[0] - i)
        for j in range(factors.shape[1]):
            parts[i, 2 * j] *= factors[row, j]
            parts[i, 2 * j + 1] *= factors[row, j]
