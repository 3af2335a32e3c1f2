"""Convolution of a real field with a real, even kernel by FFT.

    out = F^-1[ T F[field, padded with zeros] ], cropped to the field,

T(q_x, q_y) real and even in both wavenumbers: influence coefficients, or |q|. Axes are transformed
separately, so that rows of zeros and cropped rows are never transformed. Single precision takes
half the time of double.

Of T only q_x, q_y >= 0 are kept. A large field is transformed in blocks: rows into the columns of
one array of modes, there column by column forth and back, and rows of it into the result. Padding
exists in one block at a time, and the modes are all that is held beside field and result: 4 bytes
per cell of a periodic field in single precision, 8 in double; twice that of a free one.

The transforms are SciPy's; docs/half-space.md compares the alternatives.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, DTypeLike, NDArray
from scipy import fft

from reference.halfspace import pieces

Array = NDArray[np.floating]

# Up to this many padded cells the field is one block: its modes stay in the processor's cache.
_ONE_BLOCK = 600**2
# Sides of the tiles in which blocks are transposed.
_TILE = 16


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
        quarter = np.asarray(transfer)[: padded[0] // 2 + 1]
        self._in_blocks = padded[0] * padded[1] > _ONE_BLOCK
        # blocks hold columns as rows
        self._factors = np.array(quarter.T if self._in_blocks else quarter, dtype, order="C")

    def __call__(self, field: Array, out: Array | None = None) -> Array:
        """Return the convolution of a field of the right shape and precision.

        `out` receives the result, by default a new array; it may be the field itself.
        """
        if out is None:
            out = np.empty(self.shape, self._factors.dtype)
        if self._in_blocks:
            self._convolve_blocks(field, out)
        else:
            self._convolve(field, out)
        return out

    def set_mean_factor(self, value: float) -> None:
        """Change the transfer function at zero wavenumber."""
        self._factors[0, 0] = value

    def _convolve(self, field: Array, out: Array) -> None:
        (rows, columns), (length, width) = self.shape, self.padded
        modes = fft.rfft(field, width, axis=1, workers=1)
        # buffer of columns, as new memory would cost as much as the arithmetic
        modes = fft.fft(modes, length, axis=0, overwrite_x=True, workers=1)
        _multiply(modes.view(self._factors.dtype), self._factors)
        modes = fft.ifft(modes, axis=0, overwrite_x=True, workers=1)
        out[:] = fft.irfft(modes[:rows], width, axis=1, workers=1)[:, :columns]

    def _convolve_blocks(self, field: Array, out: Array) -> None:
        (rows, columns), (length, width) = self.shape, self.padded
        half = width // 2 + 1
        modes = np.empty((half, rows), np.result_type(self._factors, np.complex64))

        def forward(part: slice) -> None:
            _put(fft.rfft(field[part], width, axis=1, workers=1), modes[:, part])

        def columnwise(part: slice) -> None:
            block = fft.fft(modes[part], length, axis=1, workers=1)
            _multiply_columns(block.view(self._factors.dtype), self._factors[part])
            modes[part] = fft.ifft(block, axis=1, overwrite_x=True, workers=1)[:, :rows]

        def backward(part: slice) -> None:
            block = np.empty((part.stop - part.start, half), modes.dtype)
            _get(modes[:, part], block)
            out[part] = fft.irfft(block, width, axis=1, workers=1)[:, :columns]

        pieces.over(rows, pieces.rows_of(width), forward)
        pieces.over(half, pieces.rows_of(length), columnwise)
        pieces.over(rows, pieces.rows_of(width), backward)


@njit(cache=True, error_model="numpy")
def _multiply(parts, factors):
    """Multiply complex rows, given as interleaved real and imaginary parts, by real factors."""
    for i in range(parts.shape[0]):
        row = min(i, parts.shape[0] - i)
        for j in range(factors.shape[1]):
            parts[i, 2 * j] *= factors[row, j]
            parts[i, 2 * j + 1] *= factors[row, j]


@njit(cache=True, nogil=True, error_model="numpy")
def _multiply_columns(parts, factors):
    """Multiply the complex columns of a block, which are its rows, by factors even in q_x."""
    length, half = parts.shape[1] // 2, factors.shape[1]
    for i in range(parts.shape[0]):
        for j in range(half):
            parts[i, 2 * j] *= factors[i, j]
            parts[i, 2 * j + 1] *= factors[i, j]
        for j in range(half, length):
            parts[i, 2 * j] *= factors[i, length - j]
            parts[i, 2 * j + 1] *= factors[i, length - j]


@njit(cache=True, nogil=True)
def _put(block, modes):
    """Write the transpose of a block, tile by tile, so that both stay in the cache."""
    rows, columns = block.shape
    for first in range(0, columns, _TILE):
        for start in range(0, rows, _TILE):
            for j in range(first, min(first + _TILE, columns)):
                for i in range(start, min(start + _TILE, rows)):
                    modes[j, i] = block[i, j]


@njit(cache=True, nogil=True)
def _get(modes, block):
    """Fill a block with the transpose of modes."""
    rows, columns = block.shape
    for start in range(0, rows, _TILE):
        for first in range(0, columns, _TILE):
            for i in range(start, min(start + _TILE, rows)):
                for j in range(first, min(first + _TILE, columns)):
                    block[i, j] = modes[j, i]
