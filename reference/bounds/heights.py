r"""Heights that are trigonometric polynomials: values, slopes and certified curvatures.

A map of n points per side stands for the trigonometric polynomial of least degree through them
(`reference.surfaces.refine`): the one of the modes that are computed, and proofs are of this one;
it passes the points at a distance of rounding. Sampled M times finer than its degree asks for, its
largest modulus exceeds the largest sample by a factor of 1/cos(pi/(2M)) per direction at most
(Ehlich & Zeller 1964, Math. Z. 86, 41).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import fft

from reference.bounds.interval import EPSILON
from reference.bounds.transforms import transform_rounding

Array = NDArray[np.float64]


def levelled(heights: ArrayLike) -> Array:
    """Return heights counted from their mean: of a map that lies far from zero no digits are lost.

    Raises
    ------
    ValueError
        For heights that are no finite map.
    """
    heights = np.asarray(heights, dtype=float)
    if heights.ndim != 2 or not heights.size or not np.isfinite(heights).all():
        raise ValueError(f"heights must be a finite map, not of shape {heights.shape}")
    return heights - heights.mean()


class Waves:
    """The band-limited surface through a periodic map of heights.

    Parameters
    ----------
    heights : (n, m)
    size : (float, float)
        Sides of the map.
    """

    def __init__(self, heights: Array, size: tuple[float, float]) -> None:
        self.points = heights.shape
        modes = fft.fft2(heights, norm="forward")
        # a mode at half the sampling frequency is shared by its two signs; a product of cosines
        for axis, count in enumerate(self.points):
            if count % 2 == 0:
                modes = _split(modes, count, axis)
        self._modes = modes
        self._orders = tuple(
            fft.fftfreq(n, 1 / n) if n % 2 else np.append(fft.fftfreq(n, 1 / n), n // 2)
            for n in self.points
        )
        self._size = size

    def at(
        self, grid: tuple[int, int], shift: tuple[float, float], order: tuple[int, int] = (0, 0)
    ) -> Array:
        """Values or derivatives at the points of a grid, shifted by parts of its steps."""
        factors = []
        for axis in (0, 1):
            wave = 2 * np.pi * self._orders[axis] / self._size[axis]
            along = shift[axis] * self._size[axis] / grid[axis]
            factors.append((1j * wave) ** order[axis] * np.exp(1j * wave * along))
        modes = self._modes * factors[0][:, None] * factors[1][None, :]
        whole = np.zeros(grid, dtype=complex)
        rows, columns = (
            np.round(o).astype(int) % n for o, n in zip(self._orders, grid, strict=True)
        )
        np.add.at(whole, (rows[:, None], columns[None, :]), modes)
        return fft.ifft2(whole, norm="forward").real

    def on(self, x: Array, y: Array, order: tuple[int, int] = (0, 0)) -> Array:
        """Values or derivatives at the places (x_i, y_j), lengths from the first point on."""
        factors = []
        for axis, places in enumerate((x, y)):
            wave = 2 * np.pi * self._orders[axis] / self._size[axis]
            factors.append((1j * wave) ** order[axis] * np.exp(1j * np.outer(places, wave)))
        return np.asarray((factors[0] @ self._modes @ factors[1].T).real)

    def mean_under(self, middle: Array, axes: Array) -> float:
        """Mean height under the pressure of a flat elliptic punch, see `mean_gaps.WavyGap`.

        Parameters
        ----------
        middle : (2,)
        axes : (2, 2)
            The semi-axes as columns.
        """
        qx, qy = (2 * np.pi * o / s for o, s in zip(self._orders, self._size, strict=True))
        along = [axis[0] * qx[:, None] + axis[1] * qy for axis in axes.T]
        factor = np.sinc(np.hypot(*along) / np.pi)
        phases = np.exp(1j * middle[0] * qx), np.exp(1j * middle[1] * qy)
        return float((phases[0] @ (self._modes * factor) @ phases[1]).real)

    @property
    def rounding(self) -> float:
        """Bound of the rounding of a value, from `on` or `mean_under`.

        Phases up to pi n err by as many epsilons, sums of n terms by not more.
        """
        return 8 * EPSILON * sum(self.points) * float(np.abs(self._modes).sum())

    def rounding_on(self, grid: tuple[int, int]) -> float:
        """Bound of the rounding of a value on a grid, from `at`: the norm over all of them."""
        return _of_grid(grid) * float(np.linalg.norm(self._modes))

    def curvatures(self, finer: int = 8) -> tuple[float, float, float]:
        """Bounds of |h_xx|, |h_xy|, |h_yy| everywhere, from samples so many times finer."""
        grid = (finer * self.points[0], finer * self.points[1])
        # the largest of the values is not below their rms, the norm over the root of their number
        beyond = math.cos(math.pi / (2 * finer)) ** -2 * (1 + 2 * _of_grid(grid))
        bounds = [
            float(np.abs(self.at(grid, (0, 0), order)).max()) * beyond
            for order in ((2, 0), (1, 1), (0, 2))
        ]
        return bounds[0], bounds[1], bounds[2]

    def highest(self, finer: int = 8) -> tuple[float, float]:
        """Bounds of the greatest height: that of a sample, and one that no point exceeds."""
        grid = (finer * self.points[0], finer * self.points[1])
        top = float(self.at(grid, (0, 0)).max())
        xx, xy, yy = self.curvatures(finer)
        # at the highest point the slope is zero, and the nearest sample half a step away
        step_x, step_y = (0.5 * s / n for s, n in zip(self._size, grid, strict=True))
        return top, top + 0.5 * (xx * step_x**2 + 2 * xy * step_x * step_y + yy * step_y**2)


def _of_grid(grid: tuple[int, int]) -> float:
    """Return the rounding of the values on a grid, over the norm of their modes."""
    return (transform_rounding(*grid) + 16 * EPSILON) * math.sqrt(grid[0] * grid[1])


def _split(modes: NDArray[np.complex128], count: int, axis: int) -> NDArray[np.complex128]:
    """Append the positive half of the mode at half the sampling frequency along an axis."""
    moved = np.moveaxis(modes, axis, 0)
    half = moved[count // 2 : count // 2 + 1] / 2
    moved = np.concatenate([moved[: count // 2], half, moved[count // 2 + 1 :], half])
    return np.moveaxis(moved, 0, axis)
