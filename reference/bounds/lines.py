"""Quadratic elements on intervals, with integrals by Gauss points that are exact for them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Four points integrate polynomials of degree 7; the forms below reach degree 6.
_POINTS = 4


class Line:
    """Values and derivatives of three functions per interval at its Gauss points.

    Parameters
    ----------
    starts, ends : (n,)
    bernstein : bool
        The functions (1-t)^2, 2 t (1-t), t^2, whose smallest coefficient is below the sum
        everywhere; else those that are 1 at one of the two ends or the middle.

    Attributes
    ----------
    places, weights : (n, q)
    values, slopes : (n, 3, q)
    """

    def __init__(self, starts: Array, ends: Array, *, bernstein: bool = False) -> None:
        nodes, weights = np.polynomial.legendre.leggauss(_POINTS)
        t = 0.5 * (nodes + 1)
        s = 1 - t
        if bernstein:
            values = np.stack([s**2, 2 * t * s, t**2])
            slopes = np.stack([-2 * s, 2 * (s - t), 2 * t])
        else:
            values = np.stack([s * (s - t), 4 * t * s, t * (t - s)])
            slopes = np.stack([4 * t - 3, 4 * (s - t), 4 * t - 1])
        length = (ends - starts)[:, None]
        self.places = starts[:, None] + length * t
        self.weights = length * (0.5 * weights)
        self.values = np.broadcast_to(values, (len(starts), *values.shape))
        self.slopes = slopes / length[:, :, None]

    @property
    def swelling(self) -> Array:
        """Values plus place times slope: what a function that falls as 1/scale loses outwards."""
        return self.values + self.places[:, None] * self.slopes

    def form(self, left: Array, right: Array, weight: Array | float = 1.0) -> Array:
        """Element matrices of the integral of two of the above, shape (n, 3, 3)."""
        return np.einsum("eq,eiq,ejq->eij", self.weights * weight, left, right)


def numbers(count: int) -> NDArray[np.int64]:
    """Return the unknowns of consecutive intervals: ends even, middles odd."""
    return 2 * np.arange(count)[:, None] + np.arange(3)


def graded(cells: int, exponent: float, end: float) -> Array:
    """Places that grow as t^exponent with t = j/cells and, beyond t = 1, faster, from 0 to an end.

    Examples
    --------
    >>> graded(2, 1.0, 4.0).round(3).tolist()
    [0.0, 1.125, 4.0]
    """
    t = np.arange(64 * cells) / cells
    grown = t**exponent * (1 + t) ** 2
    last = int(np.searchsorted(grown, end))
    return grown[: last + 1] * (end / grown[last])
