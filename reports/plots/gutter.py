"""The foot of a logarithmic axis: what is at or below what can be shown is an arrow, no point."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from reports.plots.figure import Axis, Series
from reports.plots.style import Marker

ARROW = Marker("arrow-down", 7)  # their points stand on the axis
NOTE = "Arrows at the foot: at or below it."


def parted(series: Series, low: float, *, always: bool = False) -> list[Series]:
    """Return a series above the foot, and its points at or below the foot as arrows there.

    The line ends where the points leave the plot: one drawn along the foot would be a value. With
    `always`, both are returned even if one is empty.
    """
    below = np.isfinite(series.y) & (series.y <= low)
    if not below.any() and not always:
        return [series]
    above = replace(series, y=np.where(below, np.nan, series.y))
    arrows = replace(
        series,
        look=replace(series.look, marker=ARROW),
        y=np.where(below, low, np.nan),
        line=False,
        hollow=False,
        bars=None,
        legend=False,
        group=series.group or series.look.label,
        size=9,
    )
    return [replace(above, group=arrows.group), arrows]


def with_foot(axis: Axis, drawn: list[Series]) -> Axis:
    """Return the axis with "≤" at its lowest tick, if any arrow stands there."""
    if not axis.limits:
        return axis
    low = axis.limits[0]
    arrows = [series.y for series in drawn if series.look.marker is ARROW]
    if not any((y <= low).any() for y in arrows):
        return axis
    ticks = tuple(
        (value, f"≤ {text}" if value <= 1.001 * low else text) for value, text in axis.ticks
    )
    return replace(axis, ticks=ticks)
