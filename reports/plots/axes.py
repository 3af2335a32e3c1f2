"""Axes of quantities, relative errors and times."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

import numpy as np

from comparisons import formatting as fmt
from comparisons.facts.quantities import quantity
from comparisons.results.record import Failure, SceneRecord
from reports.plots.figure import Axis, Level, Series
from reports.plots.style import CROSS, Look, Marker, look

HALF_DECADE = 10**0.5
LEAST_SHARE = 1e-4
# Parts of keys of scenes that are no words.
KEYS = {"youngs": "Young's", "poisson": "Poisson's", "hurst": "Hurst exponent"}
KEYS |= {"radius_x": "radius along x", "radius_y": "radius along y"}
LOG_SPAN = 15.0  # loads spread wider than this are drawn on logarithmic axes
Ticks = tuple[tuple[float, str], ...]


def value_axis(
    name: str, values: np.ndarray, log: bool, edges: Sequence[float] | np.ndarray = ()
) -> Axis:
    """Return the axis of a quantity with one prefix: linear from zero, or logarithmic (1-2-5).

    `edges` are the edges of bands. They widen a logarithmic axis by at most half a decade, because
    a bar that almost reaches zero would dominate it.
    """
    scale = fmt.prefix_for(values, quantity(name).unit)
    positive = values[np.isfinite(values) & (values > 0)]
    if not log or not len(positive):
        return Axis(quantity=name, scale=scale)
    wide = np.asarray(edges, dtype=float)
    wide = np.clip(
        wide[np.isfinite(wide)], positive.min() / HALF_DECADE, positive.max() * HALF_DECADE
    )
    limits = padded(np.concatenate([positive, wide]), 0.06, 0.05)
    ticks = log_ticks(limits, one_digit, factor=scale.factor)
    if len(ticks) < 2:  # a range so narrow needs no logarithm, and would be left without numbers
        return Axis(quantity=name, scale=scale)
    return Axis(quantity=name, scale=scale, log=True, limits=limits, ticks=ticks)


def error_axis(low: float, high: float, title: str, of: str = "") -> Axis:
    """Return a logarithmic axis of relative errors, its ticks in per cent."""
    ticks = log_ticks((low, high), per_cent)
    return Axis(title, "|e|" if of else "", of, log=True, limits=(low, high), ticks=ticks)


def per_cent(error: float) -> str:
    """Write a relative error in per cent, however small: one axis has one unit.

    >>> per_cent(1e-5), per_cent(10.0), per_cent(1e-8)
    ('0.001\u202f%', '1\u202f000\u202f%', '10⁻⁶\u202f%')
    """
    if error > 0.99e-4:
        return fmt.tolerance(error)
    if error > 0.99e-6:
        return f"{100 * error:.4f}".rstrip("0") + "\u202f%"
    return fmt.number(100 * error, 1).removeprefix("1×") + "\u202f%"


def one_digit(value: float) -> str:
    """Write a number as ticks have it."""
    return fmt.number(value, 1)


def log_axis(
    title: str,
    limits: tuple[float, float],
    label: Callable[[float], str] = one_digit,
    most: int = 8,
) -> Axis:
    """Return a logarithmic axis with formatted ticks."""
    return Axis(title, log=True, limits=limits, ticks=log_ticks(limits, label, most))


def time_axis(title: str, limits: tuple[float, float]) -> Axis:
    """Return a logarithmic axis of times."""
    return log_axis(title, limits, lambda value: fmt.with_unit(value, "s", 1), most=6)


def padded(values: np.ndarray, share: float, least: float) -> tuple[float, float]:
    """Return limits around positive values, padded by a fraction of their decades or by `least`."""
    low, high = np.log10(values.min()), np.log10(values.max())
    margin = max(share * (high - low), least)
    return float(10 ** (low - margin)), float(10 ** (high + margin))


def error_range(sizes: np.ndarray, tolerance: float) -> tuple[float, float]:
    """Return whole decades, at least two, that contain the tolerance and all errors that matter.

    Errors below a ten-thousandth of the tolerance (1 ppm of 1 %) do not: they are arrows at the
    foot, so that round-off in one quantity does not squeeze the others.
    """
    # Larger errors than an axis can have decades for come from damaged results only.
    finite = sizes[(sizes < 1e200) & (sizes > fmt.ROUND_OFF)]
    low = min(float(finite.min()) if len(finite) else tolerance, tolerance) / 1.5
    low = max(low, LEAST_SHARE * tolerance)
    high = max(float(finite.max()) if len(finite) else tolerance, tolerance) * 1.5
    low, high = 10.0 ** np.floor(np.log10(low)), 10.0 ** np.ceil(np.log10(high))
    return float(max(low, 1e-16)), float(max(high, 100 * low))


def tolerance_line(tolerance: float) -> Level:
    """Return the line at the requested tolerance."""
    return Level(tolerance, f"asked: {fmt.tolerance(tolerance)}")


def log_ticks(
    limits: tuple[float, float], label: Callable[[float], str], most: int = 8, factor: float = 1.0
) -> Ticks:
    """Return ticks within limits, with formatted labels: 1-2-5, or whole decades if many.

    Ticks are round numbers in the unit of the axis, given by `factor`; a power of ten has no "1×".

    >>> log_ticks((0.9e-6, 3e-6), str, factor=1e6)
    ((1e-06, '1.0'), (2e-06, '2.0'))
    """
    low, high = (edge * factor for edge in limits)
    first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
    stride = max(1, math.ceil((last - first + 1) / most))
    steps = (1, 2, 5) if 3 * (last - first) <= most + 2 else (1,)
    values = (
        float(f"{step}e{power}") for power in range(first, last + 1, stride) for step in steps
    )
    return tuple(
        (v / factor, label(v).removeprefix("1×"))
        for v in values
        if 0.999 * low <= v <= 1.001 * high
    )


def key_words(key: str) -> str:
    """Write a key of a scene in words.

    >>> key_words("youngs_modulus"), key_words("radius_x"), key_words("rms_slope")
    ("Young's modulus", 'radius along x', 'rms slope')
    """
    for part, words in KEYS.items():
        key = key.replace(part, words)
    return key.replace("_", " ")


def wants_log(values: Iterable[object], span: float = LOG_SPAN) -> bool:
    """Tell whether positive values span so many decades that they need a logarithmic axis.

    >>> wants_log([1, 2, 5]), wants_log([1e-7, 1e-5]), wants_log([0.0, 1.0])
    (False, True, False)
    """
    finite = np.array([float(v) for v in values if fmt.finite(v)])
    return bool(len(finite) and finite.min() > 0 and finite.max() / finite.min() > span)


# Their tips stand where they are put: on the axis, or off a point by a share of the axis' height.
UP, DOWN = Marker("arrow-up", 6), Marker("arrow-down", 7)
OFF = 0.035
FOOT_NOTE = "Arrows at the foot: at or below it."
SIGN_NOTE = "Arrows at the points: up, too large; down, too small."


def parted(series: Series, low: float, *, always: bool = False) -> list[Series]:
    """Return a series above the foot, and its points at or below the foot as arrows there.

    The line ends where the points leave the plot: one drawn along the foot would be a value. With
    `always`, both are returned even if one is empty.
    """
    below = np.isfinite(series.y) & (series.y <= low)
    if not below.any() and not always:
        return [series]
    group = series.group or series.look.label
    above = replace(series, y=np.where(below, np.nan, series.y), group=group)
    arrows = replace(
        series,
        look=replace(series.look, marker=DOWN),
        y=np.where(below, low, np.nan),
        line=False,
        hollow=False,
        bars=None,
        legend=False,
        group=group,
        size=9,
    )
    return [above, arrows]


def with_foot(axis: Axis, drawn: list[Series]) -> Axis:
    """Return the axis with "≤" at its lowest tick, if any arrow stands there."""
    if not axis.limits:
        return axis
    low = axis.limits[0]
    if not any((series.y == low).any() for series in drawn if series.look.marker is DOWN):
        return axis
    ticks = tuple(
        (value, f"≤ {text}" if value <= 1.001 * low else text) for value, text in axis.ticks
    )
    return replace(axis, ticks=ticks)


def sign_marks(series: Series, errors: np.ndarray, low: float, high: float) -> list[Series]:
    """Return arrows above the points of positive errors, and below those of negative ones."""
    away = (high / low) ** OFF
    shown = np.isfinite(series.y) & (series.y > low)
    return [
        replace(
            series,
            look=replace(series.look, label="", marker=marker),
            y=np.where(shown & (way * errors > 0), series.y * away**way, np.nan),
            line=False,
            hollow=False,
            hover=None,
            group=series.group or series.look.label,
            size=6,
        )
        for marker, way in ((UP, 1), (DOWN, -1))
        if np.any(shown & (way * errors > 0))
    ]


def failed(style: Look, x: Iterable[float], edge: float, reasons: Iterable[str]) -> Series:
    """Return crosses at the upper edge of a plot, each with its reason."""
    places = np.array(list(x), dtype=float)
    return Series(
        replace(style, label=f"{style.label}: failed", marker=CROSS, size=11),
        places,
        # A hair inside: rounding in the logarithm must not push them out of the plot.
        np.full(len(places), 0.995 * edge),
        line=False,
        hollow=True,
        hover=tuple(reasons),
    )


def refusal(scene: SceneRecord, item: Failure) -> str:
    """Return the setting and the reason of a failure."""
    return f"{look(item.method, scene).at(item.resolution)}: {item.reason}"
