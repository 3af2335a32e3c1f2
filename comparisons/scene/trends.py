"""Trends of measured maps: permitted choices, defaults and subtraction."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Heights = NDArray[np.float64]


class Trend(NamedTuple):
    """A polynomial in x and y.

    Attributes
    ----------
    powers : tuple of (int, int)
        Powers of (x, y) of its terms.
    done : str
        What its subtraction is called in the report.
    """

    powers: tuple[tuple[int, int], ...]
    done: str


_LINEAR = ((0, 0), (1, 0), (0, 1))
TRENDS = {
    "none": Trend((), "left as read, no trend subtracted"),
    "mean": Trend(((0, 0),), "mean subtracted"),
    "tilt": Trend(_LINEAR, "least-squares plane subtracted"),
    "curvature": Trend(
        (*_LINEAR, (2, 0), (1, 1), (0, 2)), "least-squares polynomial of second order subtracted"
    ),
}


def trend_of(detrend: str | None, periodic: bool) -> str:
    """Return the trend to subtract: without a choice the plane, of a periodic map the mean."""
    return detrend or ("mean" if periodic else "tilt")


def trend_problem(detrend: str | None, periodic: bool) -> str:
    """Return why a trend cannot be subtracted, or an empty text.

    A plane or a parabola does not continue itself: subtracted from a periodic surface it leaves a
    jump at the sides, and a surface that depends on where its period was cut.
    """
    if detrend is not None and detrend not in TRENDS:
        return f"expected one of {', '.join(TRENDS)}, got {detrend!r}"
    if periodic and len(TRENDS[trend_of(detrend, periodic)].powers) > 1:
        return f"expected 'mean' (the default) or 'none' with periodic = true, got {detrend!r}"
    return ""


def subtracted(heights: Heights, defined: NDArray[np.bool_], trend: str) -> Heights:
    """Return the heights less the least-squares polynomial; NaN where they are not defined.

    The normal equations separate into moments X^T W Y of the weights W (1 on defined points), so
    that no matrix of the size of the map times the number of terms is formed. In coordinates from
    -1 to 1 they are well-conditioned; a second pass removes what the first one rounded off.
    """
    powers = TRENDS[trend].powers
    if not powers:
        return heights.copy()
    weight = defined.astype(np.float64)
    residual = np.where(defined, heights, 0.0)
    x, y = (np.vander(np.linspace(-1, 1, n), 5, increasing=True) for n in heights.shape)
    moments = x.T @ weight @ y
    matrix = np.array([[moments[a + c, b + d] for c, d in powers] for a, b in powers])
    for _ in range(2):
        projection = x.T @ residual @ y
        right = np.array([projection[a, b] for a, b in powers])
        coefficients = np.linalg.lstsq(matrix, right, rcond=None)[0]
        table = np.zeros((5, 5))
        for (a, b), value in zip(powers, coefficients, strict=True):
            table[a, b] = value
        residual -= (x @ table @ y.T) * weight
    return np.where(defined, residual, np.nan)
