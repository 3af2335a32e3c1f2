"""Measures of how far two solutions are apart; one definition each, as the report prints them."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import PchipInterpolator, RegularGridInterpolator

# A ring of this share of the contact radius is left out on either side of a singular edge or tip.
SINGULAR_RING = 0.1
# What is compared at the last load: name, error, bar.
Measure = tuple[str, float, float]


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


def pressure_difference(
    pressure: np.ndarray, weight: np.ndarray, reference: np.ndarray, keep: np.ndarray
) -> float:
    """Return the relative L2 difference over the reference's contact, by `weight`, (n,)."""
    inside = keep & (reference > 0) & np.isfinite(reference)
    norm = float(np.sum(weight[inside] * reference[inside] ** 2))
    if norm == 0:
        return float("nan")
    difference = weight[inside] * (pressure[inside] - reference[inside]) ** 2
    return float(np.sqrt(np.sum(difference) / norm))


def grid_pressure_at(
    fields: dict[str, np.ndarray], x: np.ndarray, y: np.ndarray, shape: tuple[int, ...] | None
) -> np.ndarray:
    """Return a gridded reference pressure at other points.

    On a grid that is coarser by a whole number as means over its cells; else by interpolation.
    """
    nx, ny = (int(n) for n in fields["pressure_shape"])
    values = fields["pressure"].reshape(nx, ny)
    if shape is not None and nx % shape[0] == 0 and ny % shape[1] == 0:
        fx, fy = nx // shape[0], ny // shape[1]
        same_extent = np.isclose(
            float(np.ptp(x)) * shape[0] / max(shape[0] - 1, 1),
            float(np.ptp(fields["pressure_x"])) * nx / max(nx - 1, 1),
            rtol=1e-6,
        )
        if same_extent:
            return values.reshape(shape[0], fx, shape[1], fy).mean(axis=(1, 3)).ravel()
    axes = (fields["pressure_x"].reshape(nx, ny)[:, 0], fields["pressure_y"].reshape(nx, ny)[0])
    look_up = RegularGridInterpolator(axes, values, bounds_error=False, fill_value=0.0)
    return np.asarray(look_up(np.stack([x, y], axis=-1)))
