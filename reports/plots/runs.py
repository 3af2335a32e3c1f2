"""Figures of two runs side by side: errors and times before and after."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from comparisons import formatting as fmt
from comparisons.results.runs import BAD, Change, RunComparison
from reports.plots.style import (
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

ERRORS = (
    "One marker per solve: its largest error against its run's truth, before and after. On the "
    "line nothing changed; above it the error grew. Hollow markers: what the table lists first."
)
TIMES = (
    "One marker per solve: its time before and after. Above the line it became slower; readings "
    "scatter by some 20 %. Hollow markers: what the table lists first."
)
MARGIN = 1.6
# Errors below are round-off, and a plot of their ratios would show noise.
SMALLEST = 1e-12

Pair = tuple[float, float]


def comparison_figures(record: RunComparison) -> list[Figure]:
    """Return the plots; one that would be empty is left out."""
    found = [
        _figure(record, "errors", "Error before and after", ERRORS, _errors, _error_label),
        _figure(record, "times", "Time before and after", TIMES, lambda c: c.seconds, fmt.duration),
    ]
    return [each for each in found if each is not None]


def _errors(change: Change) -> Pair:
    before, after = change.errors
    return max(before, SMALLEST), max(after, SMALLEST)


def _error_label(value: object) -> str:
    return fmt.relative(value, 1)


def _figure(
    record: RunComparison,
    key: str,
    title: str,
    caption: str,
    pair: Callable[[Change], Pair],
    label: Callable[[object], str],
) -> Figure | None:
    shown = [each for each in record.changes if all(np.isfinite(v) and v > 0 for v in pair(each))]
    if not shown:
        return None
    values = np.array([pair(each) for each in shown])
    span = float(values.min()) / MARGIN, float(values.max()) * MARGIN
    decades = np.log10(span).tolist()
    ticks = log_ticks(*span, label)
    names = drawing_order({each.method for each in shown})
    word = title.split()[0].lower()
    spec = {
        "data": [_trace(n, [c for c in shown if c.method == n], pair, label) for n in names],
        "layout": layout(
            axis(f"{word} before", log=True, range=decades, **ticks),
            axis(f"{word} after", log=True, range=decades, **ticks),
            shapes=[_diagonal(span)],
        ),
    }
    return Figure(key, title, caption, spec)


def _trace(
    method: str,
    own: list[Change],
    pair: Callable[[Change], Pair],
    label: Callable[[object], str],
) -> dict[str, Any]:
    look = style(method)
    texts = [
        f"{look.label}, {c.scene}, N = {c.resolution}: "
        f"{label(pair(c)[0])} before, {label(pair(c)[1])} after; {c.text}"
        for c in own
    ]
    symbols = [
        f"{look.symbol}-open" if any(k in BAD for k in c.kinds) else look.symbol for c in own
    ]
    return {
        "type": "scatter",
        "mode": "markers",
        "name": inert(look.label),
        "x": numbers(pair(c)[0] for c in own),
        "y": numbers(pair(c)[1] for c in own),
        "text": [inert(text) for text in texts],
        "marker": {"color": look.colour, "symbol": symbols, "size": look.size, "opacity": 0.8},
        "cliponaxis": False,
        "hovertemplate": "%{text}<extra></extra>",
    }


def _diagonal(span: Pair) -> dict[str, Any]:
    return {
        "type": "line",
        "x0": span[0],
        "y0": span[0],
        "x1": span[1],
        "y1": span[1],
        "layer": "below",
        "line": {"color": MUTED, "width": 1, "dash": "dot"},
    }
