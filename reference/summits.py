"""Summits of a periodic height map: positions and curvatures."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import fft, ndimage

Pair = tuple[float, float]


class Summits(NamedTuple):
    """Local maxima of a map: grid indices (m, 2) and principal curvatures (m, 2), larger first.

    Curvatures are positive for a convex summit.
    """

    places: NDArray[np.intp]
    curvatures: NDArray[np.float64]


def hessian(height: ArrayLike, spacing: Pair) -> tuple[NDArray[np.float64], ...]:
    """Return second derivatives (hxx, hyy, hxy) of a periodic map, exact for band-limited ones.

    Spectral: h^ times -qx^2, -qy^2, -qx qy. The Nyquist component has no mixed derivative.

    Examples
    --------
    >>> x = np.arange(16) / 16
    >>> h = np.cos(2 * np.pi * x)[:, None] * np.ones(16)
    >>> hxx, hyy, hxy = hessian(h, (1 / 16, 1 / 16))
    >>> bool(np.allclose(hxx, -4 * np.pi**2 * h)), bool(np.allclose(hyy, 0)), hxy.shape
    (True, True, (16, 16))
    """
    height = np.asarray(height, dtype=float)
    if height.ndim != 2 or not np.isfinite(height).all():
        raise ValueError(f"height must be a finite 2-D map, not of shape {height.shape}")
    shape = height.shape
    qx = 2 * np.pi * fft.fftfreq(shape[0], spacing[0])[:, None]
    qy = 2 * np.pi * fft.rfftfreq(shape[1], spacing[1])[None, :]
    spectrum = fft.rfft2(height, workers=1)
    mixed = qx * qy
    if shape[0] % 2 == 0:
        mixed[shape[0] // 2, :] = 0.0
    if shape[1] % 2 == 0:
        mixed[:, -1] = 0.0
    factors = (qx**2, qy**2, mixed)
    return tuple(fft.irfft2(-factor * spectrum, s=shape, workers=1) for factor in factors)


def summits(height: ArrayLike, spacing: Pair) -> Summits:
    """Return the local maxima of a periodic map, higher than their eight neighbours.

    Curvatures are the eigenvalues of minus the Hessian at the grid point, which differ from those
    at the summit by O(dx^2): refine the map until they converge. Points that are not summits of the
    band-limited surface (smaller curvature not positive) are omitted.

    Examples
    --------
    >>> x = 2 * np.pi * np.arange(32) / 32
    >>> h = np.cos(x)[:, None] + np.cos(x)[None, :]
    >>> peaks = summits(h, (2 * np.pi / 32,) * 2)
    >>> peaks.places.tolist(), np.round(peaks.curvatures, 12).tolist()
    ([[0, 0]], [[1.0, 1.0]])
    """
    height = np.asarray(height, dtype=float)
    hxx, hyy, hxy = hessian(height, spacing)
    ring = np.ones((3, 3), dtype=bool)
    ring[1, 1] = False
    places = np.argwhere(height > ndimage.maximum_filter(height, footprint=ring, mode="wrap"))
    xx, yy, xy = (derivative[tuple(places.T)] for derivative in (hxx, hyy, hxy))
    mean, half = -(xx + yy) / 2, np.hypot((xx - yy) / 2, xy)
    convex = mean > half
    return Summits(places[convex], np.stack([mean + half, mean - half], axis=1)[convex])
