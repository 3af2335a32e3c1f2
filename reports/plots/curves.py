"""The plots of a scene: load curves, and errors against load.

Every function takes a SceneRecord and returns figures, or none where there is nothing to draw:
a page never shows an empty plot.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from comparisons import formatting as fmt
from comparisons.judging.metrics import sizes_along_path
from comparisons.results import selection
from comparisons.results.store import SceneRecord
from comparisons.scene.loading import NORMAL
from reports.plots.style import (
    INK,
    Figure,
    axis,
    axis_words,
    band,
    drawing_order,
    inert,
    layout,
    log_ticks,
    numbers,
    style,
    value_axis,
    wants_log,
)

ERROR_CAPTION = (
    "Each method at its finest resolution. Filled markers: above the reference, hollow: below; on "
    "the lower edge: smaller than the axis shows. Horizontal line: the tolerance asked for. "
    "Shaded: below what the reference itself is sure of."
)
PATH_CAPTION = "Errors are relative to the largest value along the path, because it passes zero."
VISIBLE = 2e-3  # of the largest value: a bar thinner than a line of the plot is not drawn
SPREAD = 5.0  # quantities over speeds that spread wider than this take a logarithmic axis
NOTE_MARGIN = {"l": 60, "r": 52, "t": 30, "b": 50}  # room for "asked 1 %" on the right


def curves(scene: SceneRecord) -> list[Figure]:
    """Return each quantity against the prescribed load, all methods at their finest resolution.

    Along a path the points are joined in its order, so that a loop is seen as one; a history is
    drawn over time.
    """
    first = "penetration" if scene.control == "force" else "force"
    names = dict.fromkeys([first, "contact_area", *scene.quantities])
    if scene.control not in NORMAL:
        names = dict.fromkeys(scene.quantities)  # the normal load is held
    if scene.along == "time":
        names = dict.fromkeys([scene.control, *names])  # what is prescribed is seen first
    along = selection.drawn_along(scene)
    drawable = [name for name in names if name != along and "pressure" not in name]
    found = [_curve_figure(scene, name) for name in drawable]
    return [figure for figure in found if figure is not None]


def _curve_figure(scene: SceneRecord, name: str) -> Figure | None:
    tables = {m: selection.curve(scene, m) for m in drawing_order(selection.methods(scene))}
    tables = {
        method: rows
        for method, rows in tables.items()
        if np.isfinite(selection.column(rows, name)).any()
    }
    if not tables:
        return None
    along = selection.drawn_along(scene)
    loads = np.concatenate([selection.column(rows, along) for rows in tables.values()])
    values = np.concatenate([selection.column(rows, name) for rows in tables.values()])
    across = fmt.prefix_for(loads, fmt.quantity(along).unit)
    up = fmt.prefix_for(values, fmt.quantity(name).unit)
    log = wants_log(loads) and not scene.is_path
    # Load curves are near power laws; what is drawn over speeds need not be.
    upright = log and (scene.control in NORMAL or wants_log(values, SPREAD))
    data: list[dict[str, Any]] = []
    for method, rows in tables.items():
        data += _uncertainty_band(scene, method, rows, name, across.factor, up.factor)
        data += _ensemble_bands(scene, method, rows, name, across.factor, up.factor)
    data += [_curve_trace(scene, method, rows, name, across, up) for method, rows in tables.items()]
    spec = {
        "data": data,
        "layout": layout(
            value_axis(axis_words(along, across.unit), loads * across.factor, log),
            value_axis(axis_words(name, up.unit), values * up.factor, upright),
        ),
    }
    title = f"{fmt.quantity(name).words} against {fmt.quantity(along).words}"
    return Figure(
        f"curve-{name}", title[0].upper() + title[1:], _curve_caption(scene, name), spec, name
    )


def _curve_trace(
    scene: SceneRecord,
    method: str,
    rows: pd.DataFrame,
    name: str,
    across: fmt.Scale,
    up: fmt.Scale,
) -> dict[str, Any]:
    look = style(method)
    level = selection.column(rows, "resolution")[0]
    mode = "lines" if method == "closed_form" else "lines+markers"
    label = inert(f"{look.label}, N = {fmt.number(level, 6)}" if mode != "lines" else look.label)
    units = {"x": across.unit, "y": up.unit}
    trace = {
        "type": "scatter",
        "mode": mode,
        "name": inert(look.label),
        "x": numbers(selection.column(rows, selection.drawn_along(scene)), across.factor),
        "y": numbers(selection.column(rows, name), up.factor),
        "line": {"color": look.colour, "dash": look.dash, "width": 2},
        "marker": {"color": look.colour, "symbol": look.symbol, "size": look.size},
        "hovertemplate": f"{label}<br>%{{x:.3g}} {units['x']}<br>"
        f"%{{y:.3g}} {units['y']}<extra></extra>",
    }
    return trace | _error_bars(scene, method, rows, name, up.factor)


def _error_bars(
    scene: SceneRecord, method: str, rows: pd.DataFrame, name: str, factor: float
) -> dict[str, Any]:
    """Return the bars of the truth, where they are wide enough to be seen."""
    half = _half_widths(scene, method, rows, name)
    value = np.abs(selection.column(rows, name))
    if not np.any(half > VISIBLE * np.nanmax(value, initial=0.0)):
        return {}
    bars = {"type": "data", "array": numbers(half, factor), "thickness": 1.2, "width": 4}
    return {"error_y": bars}


def _half_widths(scene: SceneRecord, method: str, rows: pd.DataFrame, name: str) -> np.ndarray:
    """Return the half-widths of the truth's bars in the unit of the quantity; NaN for others."""
    value = selection.column(rows, name)
    if method != selection.reference(scene)[0]:
        return np.full(len(value), np.nan)
    bar = selection.column(rows, f"reference_uncertainty_{name}")
    return bar * (sizes_along_path(value) if scene.is_path else np.abs(value))


def _uncertainty_band(
    scene: SceneRecord, method: str, rows: pd.DataFrame, name: str, across: float, up: float
) -> list[dict[str, Any]]:
    if method != selection.reference(scene)[0]:
        return []
    value, half = selection.column(rows, name), _half_widths(scene, method, rows, name)
    x = numbers(selection.column(rows, selection.drawn_along(scene)), across)
    low, high = numbers(value - half, up), numbers(value + half, up)
    return band(x, low, high, "@truth", 0.3)


def _ensemble_bands(
    scene: SceneRecord, method: str, rows: pd.DataFrame, name: str, across: float, up: float
) -> list[dict[str, Any]]:
    """Realisations from the 5 % to the 95 % quantile, faint; the mean's standard error, stronger.

    Both stand at the mean's loads: the prescribed load is the same for every realisation.
    """
    level = selection.column(rows, "resolution")[0]
    single = selection.realisations(scene, method, level)
    if single.empty:
        return []
    x = numbers(selection.column(rows, selection.drawn_along(scene)), across)
    colour = style(method).colour
    mean, deviation = (selection.column(rows, column) for column in (name, f"stderr_{name}"))
    steps = selection.column(rows, "step")
    low, high = quantiles(single, name, steps)
    return [
        *band(x, numbers(low, up), numbers(high, up), colour, 0.10),
        *band(x, numbers(mean - deviation, up), numbers(mean + deviation, up), colour, 0.28),
    ]


def quantiles(single: pd.DataFrame, name: str, steps: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the 5 % and the 95 % quantile over the realisations at each step."""
    grouped = pd.Series(selection.column(single, name)).groupby(selection.column(single, "step"))
    low, high = grouped.quantile(0.05), grouped.quantile(0.95)
    return low.reindex(steps).to_numpy(), high.reindex(steps).to_numpy()


def _curve_caption(scene: SceneRecord, name: str) -> str:
    parts = ["Each method at its finest resolution."]
    if scene.along == "step":
        parts.append("Points are joined in the order of the path.")
    bar = (scene.reference.get("uncertainty") or {}).get(name)
    if fmt.finite(bar) and float(bar) > fmt.ROUND_OFF:
        hidden = " (thinner than its line)" if float(bar) < VISIBLE else ""
        parts.append(
            "Light band and error bars: the reference's uncertainty, at most "
            f"{fmt.relative(bar)}{hidden}."
        )
    several = [
        m
        for m in selection.methods(scene)
        if not selection.realisations(scene, m, _finest(scene, m)).empty
    ]
    if several:
        parts.append(
            "Lines: means over the realisations, with one standard error; "
            "faint: 5 % to 95 % of the realisations."
        )
    return " ".join(parts)


def _finest(scene: SceneRecord, method: str) -> float:
    levels = selection.resolutions(scene, method)
    return levels[-1] if levels else float("nan")


def errors(scene: SceneRecord) -> list[Figure]:
    """Return the size of each compared quantity's error at every load step."""
    found = [_error_figure(scene, name) for name in scene.quantities]
    return [figure for figure in found if figure is not None]


def error_tables(scene: SceneRecord, name: str) -> dict[str, pd.DataFrame]:
    """Return the load steps of each method's finest resolution that has errors of a quantity."""
    tables = {}
    for method in drawing_order(selection.methods(scene)):
        levels = [
            level
            for level in selection.resolutions(scene, method)
            if not selection.is_reference(scene, method, level)
        ]
        rows = selection.curve(scene, method, levels[-1]) if levels else pd.DataFrame()
        if np.isfinite(selection.column(rows, f"error_{name}")).any():
            tables[method] = rows
    return tables


def _error_figure(scene: SceneRecord, name: str) -> Figure | None:
    tables = error_tables(scene, name)
    if not tables:
        return None
    stacked = {
        method: (
            selection.compared_along(scene, rows),
            selection.column(rows, f"error_{name}"),
            selection.column(rows, f"reference_uncertainty_{name}"),
        )
        for method, rows in tables.items()
    }
    loads = np.concatenate([item[0] for item in stacked.values()])
    sizes = np.abs(np.concatenate([item[1] for item in stacked.values()]))
    across = fmt.prefix_for(loads, fmt.quantity(scene.along).unit)
    low, high = error_range(sizes, scene.tolerance)
    data = _truth_floor(stacked, across.factor, low)
    for method, (x, error, _) in stacked.items():
        level = selection.column(tables[method], "resolution")[0]
        data.append(_error_trace(method, level, x, error, across, low))
    data += _lost_steps(scene, across, high)
    spec = {
        "data": data,
        "layout": layout(
            value_axis(
                axis_words(scene.along, across.unit),
                loads * across.factor,
                wants_log(loads) and not scene.is_path,
            ),
            error_axis(low, high, "relative error |e|"),
            shapes=[tolerance_line(scene.tolerance)],
            annotations=[tolerance_note(scene.tolerance)],
            margin=NOTE_MARGIN,
        ),
    }
    equal = scene.along
    if equal in NORMAL:
        equal = {"force": "penetration", "penetration": "force"}.get(name, equal)
    title = f"Error of {fmt.quantity(name).words} at equal {fmt.quantity(equal).words}"
    caption = f"{ERROR_CAPTION} {PATH_CAPTION}" if scene.is_path else ERROR_CAPTION
    return Figure(f"error-{name}", title, caption, spec, name)


def error_range(sizes: np.ndarray, tolerance: float) -> tuple[float, float]:
    """Return whole decades that hold all errors and the tolerance, at least two of them."""
    # Larger errors than an axis can have decades for come from damaged results only.
    known = sizes[(sizes < 1e200) & (sizes > fmt.ROUND_OFF)]
    low = min(float(known.min()) if len(known) else tolerance, tolerance) / 1.5
    high = max(float(known.max()) if len(known) else tolerance, tolerance) * 1.5
    low, high = 10.0 ** np.floor(np.log10(low)), 10.0 ** np.ceil(np.log10(high))
    return float(max(low, 1e-16)), float(max(high, 100 * low))


def error_axis(low: float, high: float, title: str) -> dict[str, Any]:
    """Return a logarithmic axis of relative errors, labelled in per cent and ppm."""
    ticks = log_ticks(low, high, lambda value: fmt.tolerance(value))
    limits = [float(np.log10(low)), float(np.log10(high))]
    return axis(title, log=True, range=limits, **ticks)


def tolerance_line(tolerance: float) -> dict[str, Any]:
    """Return the horizontal line at the asked tolerance."""
    return {
        "type": "line",
        "xref": "paper",
        "x0": 0,
        "x1": 1,
        "y0": tolerance,
        "y1": tolerance,
        "line": {"color": INK, "width": 1},
    }


def tolerance_note(tolerance: float) -> dict[str, Any]:
    """Return the tolerance line's label, in the right margin where no marker can cover it."""
    return {
        "xref": "paper",
        "x": 1.01,
        "y": float(np.log10(tolerance)),
        "text": f"asked<br>{fmt.tolerance(tolerance)}",
        "showarrow": False,
        "xanchor": "left",
        "yanchor": "middle",
        "align": "left",
        "font": {"size": 11, "color": INK},
    }


def _truth_floor(
    stacked: dict[str, tuple[np.ndarray, np.ndarray, np.ndarray]], factor: float, low: float
) -> list[dict[str, Any]]:
    """Shade what lies below the reference's uncertainty (taken from the method with most steps)."""
    loads, _, bars = max(stacked.values(), key=lambda item: np.isfinite(item[2]).sum())
    bars = np.where(bars > low, bars, np.nan)
    return band(numbers(loads, factor), [low] * len(loads), numbers(bars), "@truth", 0.3)


def _error_trace(
    method: str, level: float, x: np.ndarray, error: np.ndarray, across: fmt.Scale, low: float
) -> dict[str, Any]:
    look = style(method)
    size = np.maximum(np.abs(error), low)
    above = error >= 0
    return {
        "type": "scatter",
        "mode": "lines+markers",
        "name": inert(look.label),
        "x": numbers(x, across.factor),
        "y": numbers(size),
        "text": [fmt.relative(value) for value in error],
        "line": {"color": look.colour, "dash": look.dash, "width": 1.5},
        "marker": {
            "color": look.colour,
            "size": max(look.size - 1, 7),
            "symbol": [look.symbol if up else f"{look.symbol}-open" for up in above],
            "line": {"width": 1.5, "color": look.colour},
        },
        "cliponaxis": False,
        "hovertemplate": f"{inert(look.label)}, N = {fmt.number(level, 6)}<br>"
        f"%{{x:.3g}} {across.unit}<br>error %{{text}}<extra></extra>",
    }


def _lost_steps(scene: SceneRecord, across: fmt.Scale, high: float) -> list[dict[str, Any]]:
    """Load steps without a result: hollow crosses at the upper edge, the reason on hover."""
    lost: dict[str, dict[float, list[str]]] = {}
    for item in selection.failures(scene):
        if np.isfinite(item.load):
            lost.setdefault(item.method, {}).setdefault(item.load, []).append(_reason(item))
    return [
        failure_trace(
            method,
            numbers(reasons, across.factor),
            high,
            ["<br>".join(texts) for texts in reasons.values()],
        )
        for method, reasons in lost.items()
    ]


def failure_trace(
    method: str, x: list[float | None], edge: float, reasons: list[str]
) -> dict[str, Any]:
    """Return hollow crosses at the upper edge of a plot."""
    look = style(method)
    return {
        "type": "scatter",
        "mode": "markers",
        "name": inert(f"{look.label}: failed"),
        "x": x,
        # A hair inside: rounding in the logarithm must not push them out of the plot.
        "y": [0.995 * edge] * len(x),
        "text": reasons,
        "marker": {"symbol": "x-open", "size": 11, "color": look.colour, "line": {"width": 1.5}},
        "cliponaxis": False,
        "hovertemplate": "%{text}<extra></extra>",
    }


def _reason(item: selection.Failure) -> str:
    return inert(f"{style(item.method).label}, N = {fmt.number(item.resolution, 6)}: {item.reason}")
