"""Convolution of a real field with a real, even kernel by FFT.

    out = F^-1[ T F[field, padded with zeros] ], cropped to the field,

T(q_x, q_y) real and even in both wavenumbers: influence coefficients, or |q|. Axes are transformed
separately, so that rows of zeros and cropped rows are never transformed. Single precision takes
half the time of double.

The transforms are SciPy's; docs/half-space.md compares the alternatives.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, DTypeLike, NDArray
from scipy import fft

Array = NDArray[np.floating]


class Convolution:
    """Convolution of fields of one shape with one kernel.

    Parameters
    ----------
    shape : (int, int)
        Shape of field and result.
    padded : (int, int)
        Lengths of the transforms: `shape` for a periodic field, at least the sum of field and
        kernel lengths less one for a free one.
    transfer : array_like, shape (padded[0], padded[1]//2 + 1)
        Real transfer function on the modes of `rfft2`, even in both wavenumbers.
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
        self.transfer = np.array(transfer, dtype, order="C")

    def __call__(self, field: Array) -> Array:
        """Return the convolution of a field of the right shape and precision, a new array."""
        (rows, columns), (length, width) = self.shape, self.padded
        modes = fft.rfft(field, width, axis=1, workers=1)
        # buffer of columns, as new memory would cost as much as the arithmetic
        modes = fft.fft(modes, length, axis=0, overwrite_x=True, workers=1)
        _multiply(modes.view(self.transfer.dtype), self.transfer)
        modes = fft.ifft(modes, axis=0, overwrite_x=True, workers=1)
        padded_field = fft.irfft(modes[:rows], width, axis=1, workers=1)
        return np.ascontiguousarray(padded_field[:, :columns])

    def set_mean_factor(self, value: float) -> None:
        """Change the transfer function at zero wavenumber."""
        self.transfer[0, 0] = value


@njit(cache=True, error_model="numpy")
def _multiply(parts, factors):
    """Multiply complex rows, given as interleaved real and imaginary parts, by real factors."""
    for i in range(factors.shape[0]):
        for j in range(factors.shape[1]):
            parts[i, 2 * j] *= factors[i, j]
            parts[i, 2 * j + 1] *= factors[i, j]
