"""Speed against error: what an answer of a given accuracy costs with each method."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from comparisons import formatting as fmt
from comparisons.results import selection
from comparisons.results.decisions import equal_at
from comparisons.results.store import SceneRecord
from reports.plots.curves import (
    NOTE_MARGIN,
    error_axis,
    error_range,
    failure_trace,
    tolerance_line,
    tolerance_note,
)
from reports.plots.style import (
    INK,
    MUTED,
    Figure,
    axis,
    drawing_order,
    inert,
    layout,
    log_ticks,
    numbers,
    style,
)

GUIDES = ((1e-3, "1 ms"), (1.0, "1 s"), (60.0, "1 min"))
CAPTION = (
    "Largest relative error over all load steps against the time for the whole scene: down and "
    "left is better. One marker per resolution N; hollow: without the set-up that another list of "
    "loads could reuse. Dashed: the front that no method beats. Horizontal line: the tolerance "
    "asked for."
)


def speed(scene: SceneRecord) -> list[Figure]:
    """Return error against time, one figure per compared quantity."""
    found = [_figure(scene, points, *key) for key, points in timed_points(scene).items()]
    return [figure for figure in found if figure is not None]


def timed_points(scene: SceneRecord) -> dict[tuple[str, str], pd.DataFrame]:
    """Return (quantity, equal load) -> one row per setting with its error and time, but the truth.

    The load held equal is the one that verdicts are given at.
    """
    table = selection.compared_measures(scene)
    at = np.array(selection.words(table, "at"))
    found = {}
    for name in dict.fromkeys(str(each) for each in table["quantity"]):
        judged = (table["quantity"] == name).to_numpy() & (at == equal_at(scene, name))
        found[name, equal_at(scene, name)] = _timed(scene, table[judged])
    return found


def _timed(scene: SceneRecord, part: pd.DataFrame) -> pd.DataFrame:
    known = np.isfinite(selection.column(part, "seconds"))
    known &= np.isfinite(selection.column(part, "maximum"))
    points = part[known]
    truth = np.array(
        [
            selection.is_reference(scene, method, level)
            for method, level in zip(
                points["method"], selection.column(points, "resolution"), strict=True
            )
        ],
        dtype=bool,
    )
    return points[~truth]


def _figure(scene: SceneRecord, points: pd.DataFrame, name: str, at: str) -> Figure | None:
    if points.empty:
        return None
    times = selection.column(points, "seconds")
    low, high = error_range(selection.column(points, "maximum"), scene.tolerance)
    span = time_range(scene, points)
    data: list[dict[str, Any]] = [
        *_floor(scene, name, points, span, low),
        _front(times, selection.column(points, "maximum"), span[1], low),
    ]
    for method in drawing_order(dict.fromkeys(points["method"])):
        data += _method_traces(method, points[points["method"] == method], low)
    data += _failure_traces(scene, span, high)
    spec = {"data": data, "layout": _layout(scene, span, low, high)}
    equal = f" at equal {fmt.quantity(at).words}" if at in fmt.QUANTITIES else ""
    title = f"Error of {fmt.quantity(name).words}{equal}"
    return Figure(f"speed-{name}", title, CAPTION, spec, name)


def time_range(scene: SceneRecord, points: pd.DataFrame) -> tuple[float, float]:
    """Return the ends of a time axis on which every solve has a place."""
    lost = [item.seconds for item in selection.failures(scene)]
    total = selection.column(points, "seconds")
    rest = total - np.nan_to_num(selection.column(points, "setup_seconds"))
    times = np.concatenate([total, rest, lost, reference_cost(scene)])
    times = times[np.isfinite(times) & (times > 0)]
    if not len(times):
        return 1e-3, 1.0
    low, high = np.log10(times.min()), np.log10(times.max())
    margin = max(0.06 * (high - low), 0.3)
    return float(10 ** (low - margin)), float(10 ** (high + margin))


def _layout(
    scene: SceneRecord, span: tuple[float, float], low: float, high: float
) -> dict[str, Any]:
    inside = [(value, text) for value, text in GUIDES if span[0] < value < span[1]]
    shapes = [tolerance_line(scene.tolerance)] + [
        {
            "type": "line",
            "yref": "paper",
            "y0": 0,
            "y1": 1,
            "x0": value,
            "x1": value,
            "layer": "below",
            "line": {"color": MUTED, "width": 1, "dash": "dot"},
        }
        for value, _ in inside
    ]
    notes = [tolerance_note(scene.tolerance)] + [
        {
            "x": float(np.log10(value)),
            "yref": "paper",
            "y": 1.0,
            "yanchor": "bottom",
            "yshift": 5,
            "text": text,
            "showarrow": False,
            "font": {"size": 11, "color": MUTED},
        }
        for value, text in inside
    ]
    ticks = log_ticks(*span, lambda value: fmt.with_unit(value, "s", 1), most=6)
    limits = [float(np.log10(edge)) for edge in span]
    return layout(
        axis("time for the whole scene", log=True, range=limits, tickangle=0, **ticks),
        error_axis(low, high, "largest error |e|"),
        shapes=shapes,
        annotations=notes,
        margin=NOTE_MARGIN,
    )


def _method_traces(method: str, points: pd.DataFrame, low: float) -> list[dict[str, Any]]:
    points = points.sort_values("resolution")
    look = style(method)
    total = selection.column(points, "seconds")
    setup = np.nan_to_num(selection.column(points, "setup_seconds"))
    shown = numbers(np.maximum(selection.column(points, "maximum"), low))
    hover = [_hover(look.label, row) for row in points.to_dict("records")]
    base = {
        "type": "scatter",
        "text": hover,
        "hovertemplate": "%{text}<extra></extra>",
        "cliponaxis": False,
        "legendgroup": inert(method),
    }
    filled = base | {
        "mode": "lines+markers",
        "name": inert(look.label),
        "x": numbers(total),
        "y": shown,
        "line": {"color": look.colour, "dash": look.dash, "width": 1.5},
        "marker": {"color": look.colour, "symbol": look.symbol, "size": 9},
    }
    if not (setup > 0).any():
        return [filled]
    rest = np.where((setup > 0) & (total > setup), total - setup, np.nan)
    hollow = base | {
        "mode": "markers",
        "name": inert(f"{look.label}, without set-up"),
        "showlegend": False,
        "x": numbers(rest),
        "y": shown,
        "marker": {
            "color": look.colour,
            "symbol": f"{look.symbol}-open",
            "size": 8,
            "line": {"width": 1.3},
        },
    }
    return [hollow, filled]


def _hover(label: str, row: dict[str, Any]) -> str:
    parts = [
        inert(f"{label}, N = {fmt.number(row.get('resolution'), 6)}"),
        f"largest error {fmt.plus_minus(row.get('maximum'), row.get('uncertainty'))}",
        f"rms {fmt.relative(row.get('rms'))}",
        f"time {fmt.duration(row.get('seconds'))}, "
        f"of which set-up {fmt.duration(row.get('setup_seconds'))}",
        f"unknowns {fmt.count(row.get('unknowns'))}",
    ]
    return "<br>".join(parts)


def pareto_front(times: np.ndarray, errors: np.ndarray) -> tuple[list[float], list[float]]:
    """Return the least errors that given times buy, as the corners of a staircase.

    >>> pareto_front(np.array([1.0, 2.0, 3.0]), np.array([0.1, 0.2, 0.01]))
    ([1.0, 3.0], [0.1, 0.01])
    """
    order = np.lexsort((errors, times))
    best, x, y = np.inf, [], []
    for index in order:
        if errors[index] < best:
            best = errors[index]
            x.append(float(times[index]))
            y.append(float(best))
    return x, y


def _front(times: np.ndarray, errors: np.ndarray, end: float, low: float) -> dict[str, Any]:
    x, y = pareto_front(times, np.maximum(errors, low))
    return {
        "type": "scatter",
        "mode": "lines",
        "name": "front",
        "x": numbers([*x, end]),
        "y": numbers([*y, y[-1]]),
        "line": {"color": MUTED, "width": 1.5, "dash": "dash", "shape": "hv"},
        "hoverinfo": "skip",
    }


def _floor(
    scene: SceneRecord, name: str, points: pd.DataFrame, span: tuple[float, float], low: float
) -> list[dict[str, Any]]:
    """Shade the errors that the reference cannot tell from zero, and mark what it cost."""
    bar = truth_bar(scene, name, points)
    if bar <= low:
        return []
    shade = {
        "type": "scatter",
        "mode": "lines",
        "x": [span[0], span[1], span[1], span[0]],
        "y": [low, low, bar, bar],
        "fill": "toself",
        "fillcolor": "@truth-band",
        "line": {"width": 0},
        "hoverinfo": "skip",
        "showlegend": False,
    }
    return [shade, *_reference_marker(scene, span, bar)]


def truth_bar(scene: SceneRecord, name: str, points: pd.DataFrame) -> float:
    """Return how well the truth is known: the reference's bar, else the widest of the settings."""
    known = (scene.reference.get("uncertainty") or {}).get(name)
    if fmt.finite(known):
        return float(known)  # type: ignore[arg-type]
    bars = selection.column(points, "uncertainty")
    return float(np.nanmax(bars)) if np.isfinite(bars).any() else 0.0


def _reference_marker(
    scene: SceneRecord, span: tuple[float, float], bar: float
) -> list[dict[str, Any]]:
    method, level = selection.reference(scene)
    cost = reference_cost(scene)
    if not len(cost) or not span[0] < cost[0] < span[1]:
        return []
    look = style(method)
    return [
        {
            "type": "scatter",
            "mode": "markers",
            "name": inert(f"reference ({look.label})"),
            "x": numbers(cost),
            "y": [bar],
            "text": [
                inert(
                    f"the reference, N = {fmt.number(level, 6)}: {fmt.duration(cost[0])}, "
                    f"known to {fmt.relative(bar)}"
                )
            ],
            "hovertemplate": "%{text}<extra></extra>",
            "marker": {
                "color": look.colour,
                "symbol": look.symbol,
                "size": 9,
                "line": {"color": INK, "width": 2},
            },
        }
    ]


def reference_cost(scene: SceneRecord) -> np.ndarray:
    """Return the time of the reference, none where it is not known."""
    method, level = selection.reference(scene)
    rows = selection.curve(scene, method, level if np.isfinite(level) else None)
    return selection.column(rows, "seconds")[:1]


def _failure_traces(
    scene: SceneRecord, span: tuple[float, float], high: float
) -> list[dict[str, Any]]:
    """Crosses at the top: at their time where it is known, else at the right edge, side by side."""
    lost = selection.failures(scene)
    unplaced, found = 0, []
    for method in dict.fromkeys(item.method for item in lost):
        # One cross per setting: the load steps it lost all cost the same time.
        own = {item.resolution: item for item in lost if item.method == method}
        x, reasons = [], []
        for item in own.values():
            if np.isfinite(item.seconds) and span[0] < item.seconds < span[1]:
                x.append(item.seconds)
            else:
                x.append(span[1] / (span[1] / span[0]) ** (0.04 * unplaced))
                unplaced += 1
            reasons.append(
                inert(f"{style(method).label}, N = {fmt.number(item.resolution, 6)}: {item.reason}")
            )
        found.append(failure_trace(method, numbers(x), high, reasons))
    return found
