"""Curves, errors and costs of a scene, each drawn on axes that are given.

What is drawn is taken from the results by the functions that the report uses; only the drawing is
matplotlib's.
"""

from __future__ import annotations

import textwrap
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from comparisons import formatting as fmt
from comparisons.judging.metrics import sizes_along_path
from comparisons.results import selection
from comparisons.results.store import SceneRecord
from comparisons.scene.loading import NORMAL
from comparisons.scene.method_names import known_methods
from reports.paper.style import TRUTH, Look, axis_label, colour, literal, look
from reports.plots.curves import SPREAD, error_range, error_tables, quantiles
from reports.plots.speed import pareto_front, reference_cost, time_range, timed_points, truth_bar
from reports.plots.style import drawing_order, log_ticks, wants_log

MUTED, INK = colour("@muted"), colour("@ink")
BAR = {"color": TRUTH, "alpha": 0.35, "lw": 0, "label": "bar of the truth"}
FRONT, ASKED, PRICED = "Pareto front", "asked: ", "truth ("
LONGEST_LABEL = 32


def curve_pairs(scene: SceneRecord) -> list[tuple[str, str]]:
    """Return what is drawn over what: (column to the right, column upwards).

    Under normal loads force against penetration, and area against force, whichever of them is
    prescribed; else every quantity along the path, over time or over the speeds.
    """
    if scene.control in NORMAL and not scene.is_path:
        pairs = [("penetration", "force"), ("force", "contact_area")]
    else:
        along = selection.drawn_along(scene)
        names = [q for q in scene.quantities if q != along and "pressure" not in q]
        pairs = [(along, name) for name in names]
    drawable = _curve_tables(scene)
    return [pair for pair in pairs if any(_has(rows, pair) for rows in drawable.values())]


def error_quantities(scene: SceneRecord) -> list[str]:
    """Return the quantities whose error is known along the loads."""
    return [name for name in scene.quantities if error_tables(scene, name)]


def speed_quantities(scene: SceneRecord) -> list[tuple[str, str]]:
    """Return (quantity, equal load) of which errors and times are known."""
    return [key for key, points in timed_points(scene).items() if not points.empty]


def draw_curve(axes: Any, scene: SceneRecord, across: str, up: str) -> None:
    """Draw a quantity over another, all methods at their finest resolution, the truth's bar grey.

    Of an ensemble the means, with the 5 % and 95 % quantiles over the realisations.
    """
    tables = {m: rows for m, rows in _curve_tables(scene).items() if _has(rows, (across, up))}
    values = {
        name: np.concatenate([selection.column(rows, name) for rows in tables.values()])
        for name in (across, up)
    }
    scales = [fmt.prefix_for(values[name], fmt.quantity(name).unit) for name in (across, up)]
    _set_scales(axes, scene, values[across], values[up])
    for method, rows in tables.items():
        lines = _Lines(scene, method, rows, (across, up), (scales[0].factor, scales[1].factor))
        lines.draw_bands(axes)
        marker = "" if method == "closed_form" else look(method).marker
        axes.plot(*lines.points, **_line(look(method)) | {"marker": marker})
    axes.set_xlabel(axis_label(across, scales[0].unit))
    axes.set_ylabel(wrapped(axis_label(up, scales[1].unit)))


@dataclass(frozen=True)
class _Lines:
    """One method's curve, and the bands around it: on the axis that is not prescribed."""

    scene: SceneRecord
    method: str
    rows: pd.DataFrame
    names: tuple[str, str]
    factors: tuple[float, float]

    @property
    def points(self) -> tuple[np.ndarray, np.ndarray]:
        x, y = (selection.column(self.rows, n) for n in self.names)
        return x * self.factors[0], y * self.factors[1]

    @property
    def sideways(self) -> bool:
        return self.names[1] == self.scene.control

    def draw_bands(self, axes: Any) -> None:
        """Draw the scatter of the realisations, and the bar of the truth."""
        place = 0 if self.sideways else 1
        value, name, factor = self.points[place], self.names[place], self.factors[place]
        truth = self.method == selection.reference(self.scene)[0]
        level = selection.column(self.rows, "resolution")[0]
        single = selection.realisations(self.scene, self.method, level)
        # Solvers of the same surfaces scatter alike: of them the truth's band says it all.
        if not single.empty and (truth or _is_line(self.method)):
            low, high = quantiles(single, name, selection.column(self.rows, "step"))
            own = {"color": look(self.method).colour, "alpha": 0.13, "lw": 0}
            self._fill(axes, low * factor, high * factor, own)
        bar = selection.column(self.rows, f"reference_uncertainty_{name}")
        if truth and (bar > fmt.ROUND_OFF).any():
            half = bar * (sizes_along_path(value) if self.scene.is_path else np.abs(value))
            self._fill(axes, value - half, value + half, BAR)

    def _fill(self, axes: Any, low: np.ndarray, high: np.ndarray, own: dict[str, Any]) -> None:
        fill = axes.fill_betweenx if self.sideways else axes.fill_between
        fill(self.points[1 if self.sideways else 0], low, high, **own)


def _is_line(method: str) -> bool:
    known = known_methods().get(method)
    return known is not None and known.dimension == 1


def _set_scales(axes: Any, scene: SceneRecord, across: np.ndarray, up: np.ndarray) -> None:
    """Take logarithmic axes where values spread wide; load curves are near power laws: both."""
    if scene.is_path:
        return
    wide = wants_log(across)
    upright = wants_log(up) if scene.control in NORMAL else wide and wants_log(up, SPREAD)
    if scene.control in NORMAL and (wide or upright):
        wide = upright = bool(
            (across[np.isfinite(across)] > 0).all() and (up[np.isfinite(up)] > 0).all()
        )
    if wide:
        axes.set_xscale("log")
    if upright:
        axes.set_yscale("log")


def _curve_tables(scene: SceneRecord) -> dict[str, pd.DataFrame]:
    tables = {m: selection.curve(scene, m) for m in drawing_order(selection.methods(scene))}
    return {method: rows for method, rows in tables.items() if len(rows)}


def _has(rows: pd.DataFrame, pair: tuple[str, str]) -> bool:
    known = [np.isfinite(selection.column(rows, name)) for name in pair]
    return bool((known[0] & known[1]).any())


def _line(own: Look) -> dict[str, Any]:
    return {
        "color": own.colour,
        "linestyle": own.dash,
        "marker": own.marker,
        "markersize": own.size,
        "markerfacecolor": "white",
        "markeredgewidth": 0.8,
        "label": own.label,
    }


def draw_error(axes: Any, scene: SceneRecord, name: str) -> None:
    """Draw the size of a quantity's error at every load step: filled above the truth, hollow below.

    Grey: below what the truth is sure of; the line is the tolerance that was asked for.
    """
    tables = error_tables(scene, name)
    loads = np.concatenate([selection.compared_along(scene, rows) for rows in tables.values()])
    errors = [selection.column(rows, f"error_{name}") for rows in tables.values()]
    low, high = error_range(np.abs(np.concatenate(errors)), scene.tolerance)
    scale = fmt.prefix_for(loads, fmt.quantity(scene.along).unit)
    if wants_log(loads) and not scene.is_path:
        axes.set_xscale("log")
    truth = max(tables.values(), key=len)
    bars = selection.column(truth, f"reference_uncertainty_{name}")
    if (bars > low).any():
        steps = selection.compared_along(scene, truth) * scale.factor
        shade = np.where(bars > low, bars, np.nan)
        axes.fill_between(steps, low, shade, **BAR)
    for (method, rows), error in zip(tables.items(), errors, strict=True):
        own = look(method)
        x = selection.compared_along(scene, rows) * scale.factor
        size = np.maximum(np.abs(error), low)
        axes.plot(x, size, **_line(own), clip_on=False)
        # NaN where hollow: an empty line that is not clipped would have its place at the origin.
        above = np.where(error >= 0, size, np.nan)
        if np.isfinite(above).any():
            axes.plot(x, above, own.marker, ms=own.size, color=own.colour, clip_on=False)
    draw_errors_axis(axes, scene.tolerance, low, high, f"error of {fmt.quantity(name).words}")
    axes.set_xlabel(axis_label(scene.along, scale.unit))
    if scene.along == "step":
        axes.xaxis.get_major_locator().set_params(integer=True)
    finish_scale(axes.xaxis)


def draw_speed(axes: Any, scene: SceneRecord, name: str, at: str) -> None:
    """Draw the largest error against time: lines join resolutions, dashed the Pareto front."""
    points = timed_points(scene)[name, at]
    times, errors = (selection.column(points, key) for key in ("seconds", "maximum"))
    low, high = error_range(errors, scene.tolerance)
    span = time_range(scene, points)
    axes.set_xscale("log")
    axes.set_xlim(*span)
    bar = truth_bar(scene, name, points)
    if bar > low:
        axes.axhspan(low, bar, **BAR)
    x, y = pareto_front(times, np.maximum(errors, low))
    axes.plot(
        [*x, span[1]], [*y, y[-1]], drawstyle="steps-post", ls=(0, (3, 2)), c=MUTED, lw=0.8,
        label=FRONT,
    )  # fmt: skip
    for method in drawing_order(dict.fromkeys(points["method"])):
        part = points[points["method"] == method].sort_values("resolution")
        spent, size = (selection.column(part, key) for key in ("seconds", "maximum"))
        own = _line(look(method)) | {"markerfacecolor": look(method).colour}
        axes.plot(spent, np.maximum(size, low), **own, clip_on=False)
    _draw_truth_cost(axes, scene, span, bar, low)
    draw_errors_axis(
        axes, scene.tolerance, low, high, f"largest error of {fmt.quantity(name).words}"
    )
    ticks = log_ticks(*span, lambda value: fmt.with_unit(value, "s", 1), most=5)
    _ticks(axes.xaxis, ticks)
    axes.set_xlabel("time for all loads of the scene")


def _draw_truth_cost(
    axes: Any, scene: SceneRecord, span: tuple[float, float], bar: float, low: float
) -> None:
    """Mark what the truth itself cost, at the bar that it reached."""
    cost = reference_cost(scene)
    if bar <= low or not len(cost) or not span[0] < cost[0] < span[1]:
        return
    own = look(selection.reference(scene)[0])
    axes.plot(
        cost, [bar], own.marker, color=own.colour, ms=own.size + 1.5, mec=INK, mew=0.9,
        label=f"{PRICED}{own.label})",
    )  # fmt: skip


def finish_scale(axis: Any) -> None:
    """Give a logarithmic axis plain numbers at 1, 2 and 5, once its limits are known."""
    if axis.get_scale() == "log":
        _ticks(axis, log_ticks(*axis.get_view_interval(), lambda value: fmt.number(value, 1)))


def wrapped(label: str) -> str:
    """Return a label in lines that fit beside an axis of a column's height."""
    return "\n".join(textwrap.wrap(label, LONGEST_LABEL, break_long_words=False))


def legend_place(label: str) -> tuple[int, str]:
    """Return what sorts a legend: the methods first, then the truth, the asked, the front."""
    labels = [look(method).label for method in selection.METHOD_ORDER]
    if label in labels:
        return labels.index(label), ""
    others = (PRICED, BAR["label"], ASKED, FRONT)
    places = [index for index, start in enumerate(others) if label.startswith(str(start))]
    return len(labels) + 1 + places[0] if places else len(labels), label


def draw_errors_axis(axes: Any, tolerance: float, low: float, high: float, title: str) -> None:
    """Make the upright axis one of errors, with the line of the tolerance that was asked for."""
    axes.set_yscale("log")
    axes.set_ylim(low, high)
    _ticks(axes.yaxis, log_ticks(low, high, fmt.tolerance))
    axes.set_ylabel(wrapped(literal(title)))
    axes.axhline(tolerance, color=INK, lw=0.7, label=f"{ASKED}{fmt.tolerance(tolerance)}")


def _ticks(axis: Any, ticks: dict[str, Any]) -> None:
    axis.set_ticks(ticks["tickvals"], ticks["ticktext"])
    axis.set_ticks([], minor=True)
