"""Measures of how far two solutions are apart; one definition each, as the report prints them."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import PchipInterpolator


def sizes_along_path(values: np.ndarray) -> np.ndarray:
    """Return what errors along a path are relative to: its largest size, at every known step."""
    size = np.abs(np.asarray(values, dtype=float))
    largest = np.nanmax(size) if np.isfinite(size).any() else np.nan
    return np.where(np.isfinite(size), largest, np.nan)


def relative_error(value: np.ndarray, reference: np.ndarray, *, path: bool = False) -> np.ndarray:
    """Return value / reference - 1, NaN where either is missing or the reference is zero.

    Along a path: (value - reference) / max |reference|.
    """
    value, reference = np.asarray(value, dtype=float), np.asarray(reference, dtype=float)
    if path:
        size = sizes_along_path(reference)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(size > 0, (value - reference) / size, np.nan)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(reference != 0, value / reference - 1, np.nan)


def at_equal(x: np.ndarray, reference_x: np.ndarray, reference_y: np.ndarray) -> np.ndarray:
    """Return the reference curve y(x) at the points x.

    Monotone cubic interpolation of log y against log x: exact for power laws, which indentation
    curves are or nearly are. A method that errs by some per cent ends a little beyond the
    reference's last load; there the curve goes on with its end slope, for at most half of the
    last interval of log x. Further out there is no value: NaN.

    >>> d = np.array([1.0, 2.0, 4.0])
    >>> bool(np.isclose(at_equal(np.array([3.0]), d, d**1.5)[0], 3**1.5, rtol=1e-14))
    True
    """
    good = (
        np.isfinite(reference_x) & np.isfinite(reference_y) & (reference_x > 0) & (reference_y > 0)
    )
    # In logarithms, because two loads that differ in the last digit only have the same one.
    known_x, known_y = np.log(reference_x[good]), np.log(reference_y[good])
    if len(known_x) > 1 and known_x[0] > known_x[-1]:  # a mean gap closes as the force grows
        known_x, known_y = known_x[::-1], known_y[::-1]
    result = np.full(np.shape(x), np.nan)
    if len(known_x) < 2 or np.any(np.diff(known_x) <= 0):
        return result
    curve = PchipInterpolator(known_x, known_y)
    usable = np.isfinite(x) & (x > 0)
    points = np.log(x[usable])
    ends = np.clip(points, known_x[0], known_x[-1])
    beyond = points - ends
    values = curve(ends) + curve.derivative()(ends) * beyond
    margin = 0.5 * np.array([known_x[1] - known_x[0], known_x[-1] - known_x[-2]])
    values[(beyond < -margin[0]) | (beyond > margin[1])] = np.nan
    result[usable] = np.exp(values)
    return result


def rms_and_maximum(errors: np.ndarray) -> tuple[float, float]:
    """Return the rms and the largest absolute value over the load steps (NaN where none)."""
    finite = errors[np.isfinite(errors)]
    if not len(finite):
        return float("nan"), float("nan")
    return float(np.sqrt(np.mean(finite**2))), float(np.abs(finite).max())


def front(times: np.ndarray, errors: np.ndarray) -> list[int]:
    """Return the indices of points that no other one beats in both, the fastest first.

    >>> front(np.array([1.0, 2.0, 3.0]), np.array([0.1, 0.2, 0.01]))
    [0, 2]
    """
    best, left = np.inf, []
    for index in np.lexsort((errors, times)):
        if errors[index] < best:
            best = errors[index]
            left.append(int(index))
    return left
