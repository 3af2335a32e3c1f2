"""Marks of all plots of errors: arrows for signs and at the foot, crosses for failures."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from comparisons import formatting as fmt
from comparisons.results import selection
from comparisons.results.store import SceneRecord
from reports.plots.figure import Axis, Series
from reports.plots.style import CROSS, Look, Marker, look

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


def refusal(scene: SceneRecord, item: selection.Failure) -> str:
    """Return the setting and the reason of a failure."""
    return f"{look(item.method, scene).label}, N = {fmt.count(item.resolution)}: {item.reason}"
