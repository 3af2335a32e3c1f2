"""Drawing of figures on given matplotlib axes."""

from __future__ import annotations

import textwrap
from typing import Any

import numpy as np

from reports.paper.style import axis_label, colour, literal
from reports.plots.axes import log_ticks
from reports.plots.figure import Axis, Band, Figure, Series

LONGEST_LABEL = 32
MARKER_SIZE = 0.38  # points of print for a pixel of the page


def draw(axes: Any, figure: Figure) -> None:
    """Draw a figure: shading, lines and markers, then the axes."""
    axes.set(xscale=_scale(figure.x), yscale=_scale(figure.y))
    for stretch in figure.stretches:
        ends = (end * figure.x.scale.factor for end in (stretch.low, stretch.high))
        shade = {"color": colour(stretch.colour), "alpha": 0.12, "lw": 0.5}
        axes.axvspan(*ends, **shade, label=literal(stretch.label))
    for band in figure.bands:
        _draw_band(axes, band, figure)
    for series in figure.series:
        if series.legend:  # what only a caption explains is the page's
            _draw_series(axes, series, figure)
    for level in figure.levels:
        style = {"color": colour(level.colour), "lw": 0.7, "ls": level.dash.matplotlib}
        height = level.value * figure.y.scale.factor
        axes.axhline(height, **style, label=literal(level.label) or None)
    for guide in figure.guides:
        if guide.text:
            continue  # the ticks say it, too
        place = guide.value * figure.x.scale.factor
        axes.axvline(place, color=colour(guide.colour), lw=0.6, ls=":", zorder=0.5)
    _finish(axes, figure)


def _scale(axis: Axis) -> str:
    return "log" if axis.log else "linear"


def _draw_band(axes: Any, band: Band, figure: Figure) -> None:
    fill = axes.fill_betweenx if band.sideways else axes.fill_between
    along, across = figure.x.scale.factor, figure.y.scale.factor
    if band.sideways:
        along, across = across, along
    style = {"color": colour(band.colour), "alpha": band.opacity, "lw": 0}
    label = literal(band.label) or None
    fill(band.along * along, band.low * across, band.high * across, **style, label=label)


def _draw_series(axes: Any, series: Series, figure: Figure) -> None:
    look = series.look
    x, y = series.x * figure.x.scale.factor, series.y * figure.y.scale.factor
    if not np.isfinite(x * y).any():
        return  # an empty line that is not clipped would have its place at the origin
    ink = colour(look.colour)
    rim = colour("@ink") if series.outlined else ink
    (line,) = axes.plot(
        *(x, y),
        color=ink,
        linestyle=look.dash.matplotlib if series.line else "none",
        linewidth=series.width / 2,
        drawstyle="steps-post" if series.stairs else "default",
        marker=look.marker.matplotlib if series.marks else "",
        markersize=MARKER_SIZE * (series.size or look.size),
        markerfacecolor="white" if np.any(series.hollow) else ink,
        markeredgecolor=rim,
        markeredgewidth=0.8,
        alpha=series.faint if series.faint < 1.0 else None,
        label=literal(look.label),
        clip_on=figure.clipped,
    )
    hollow = np.broadcast_to(series.hollow, x.shape)
    if series.marks and hollow.any() and not hollow.all():
        axes.plot(
            *(x[~hollow], y[~hollow], line.get_marker()),
            color=ink,
            markersize=line.get_markersize(),
            clip_on=figure.clipped,
        )
    if series.bars is not None:
        up = series.bars * figure.y.scale.factor
        down = np.minimum(up, 0.999 * np.abs(y)) if figure.y.log else up
        axes.errorbar(x, y, yerr=[down, up], fmt="none", ecolor=ink, elinewidth=0.8, capsize=1.5)


def _finish(axes: Any, figure: Figure) -> None:
    """Set the limits, then the ticks and titles."""
    if figure.x.limits:
        axes.set_xlim(*np.multiply(figure.x.limits, figure.x.scale.factor))
    if figure.y.limits:
        axes.set_ylim(*np.multiply(figure.y.limits, figure.y.scale.factor))
    _set_ticks(axes.xaxis, figure.x)
    _set_ticks(axes.yaxis, figure.y)
    axes.set_xlabel(_title(figure.x))
    axes.set_ylabel(
        "\n".join(textwrap.wrap(_title(figure.y), LONGEST_LABEL, break_long_words=False))
    )
    if figure.x.quantity == "step":
        axes.xaxis.get_major_locator().set_params(integer=True)


def _title(axis: Axis) -> str:
    if axis.quantity:
        return axis_label(axis.quantity, axis.scale.unit)
    return literal(f"{axis.title} of {axis.of}" if axis.of else axis.label)


def _set_ticks(axis: Any, drawn: Axis) -> None:
    """Set the ticks of a figure; of a logarithmic axis without any, plain numbers at 1, 2 and 5."""
    if not (drawn.log or drawn.ticks):
        return
    ends = axis.get_view_interval()
    ticks = drawn.ticks or log_ticks(ends, lambda value: f"{value:g}")
    factor = drawn.scale.factor if drawn.ticks else 1.0
    axis.set_ticks([value * factor for value, _ in ticks], [text for _, text in ticks])
    axis.set_ticks([], minor=True)
