"""Time against error of every method on every hard case; failures stand at the upper edge."""

from __future__ import annotations

from typing import Any

import numpy as np

from comparisons import formatting as fmt
from comparisons.questions.hard_cases.record import HardCasesRecord, OutcomeRecord
from reports.plots.curves import failure_trace
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

# Below the smallest error that a plot of errors distinguishes everything is round-off.
SMALLEST, LARGEST = 1e-12, 1e7
MARGIN = 1.5
SOLVED = ("accurate", "degraded")
CAPTION = (
    "One marker per case, at the error of the force (or of the penetration, where the force is "
    "prescribed), the truth's bar included. Horizontal line: 1 %, above which an answer counts as "
    "degraded. Hollow crosses at the upper edge: refused or lost, the reason on hover; those "
    "without a time stand at the right."
)


def stability(record: HardCasesRecord) -> Figure | None:
    """Return the plot, or None where nothing was solved."""
    solved = [each for each in record.outcomes if each.kind in SOLVED]
    times = np.array([each.seconds for each in solved if each.seconds], dtype=float)
    if not len(times):
        return None
    span = float(times.min()) / MARGIN, float(times.max()) * MARGIN
    total = [_height(each) for each in solved]
    edges = max(SMALLEST, min(total) / MARGIN), min(LARGEST, max(*total, 0.05) * MARGIN)
    names = drawing_order(record.methods)
    data = [_trace(name, [each for each in solved if each.method == name]) for name in names]
    data += _failures(record, names, span, edges[1])
    decades = [float(np.log10(each)) for each in edges]
    across = log_ticks(*span, fmt.duration)
    up = log_ticks(*edges, lambda value: fmt.relative(value, 1))
    spec = {
        "data": [trace for trace in data if trace["x"]],
        "layout": layout(
            axis("time", log=True, range=np.log10(span).tolist(), **across),
            axis("largest error", log=True, range=decades, **up),
            shapes=[_line_at(0.01)],
        ),
    }
    return Figure("stability", "Hard cases: time and error", CAPTION, spec)


def _height(outcome: OutcomeRecord) -> float:
    error = (outcome.error or 0.0) + (outcome.bar or 0.0)
    return float(np.clip(error, SMALLEST, LARGEST))


def _trace(method: str, own: list[OutcomeRecord]) -> dict[str, Any]:
    look = style(method)
    return {
        "type": "scatter",
        "mode": "markers",
        "name": inert(look.label),
        "x": numbers(each.seconds for each in own),
        "y": numbers(_height(each) for each in own),
        "text": [inert(f"{look.label}, {each.title}: {_words(each)}") for each in own],
        "marker": {
            "color": look.colour,
            "symbol": look.symbol,
            "size": max(look.size - 2, 6),
            "opacity": 0.75,
        },
        "cliponaxis": False,
        "hovertemplate": "%{text}<extra></extra>",
    }


def _words(outcome: OutcomeRecord) -> str:
    if outcome.kind not in SOLVED:
        return f"{outcome.kind}: {outcome.reason}"
    text = f"{outcome.kind}, {fmt.relative(outcome.error)} in {fmt.duration(outcome.seconds)}"
    return f"{text}; {outcome.deviation}" if outcome.deviation else text


def _failures(
    record: HardCasesRecord, names: list[str], span: tuple[float, float], high: float
) -> list[dict[str, Any]]:
    """Crosses for what gave no number; methods never meant for a case have not failed."""
    unplaced, found = 0, []
    for name in names:
        own = [e for e in record.outcomes if e.method == name and e.kind in ("refused", "lost")]
        x = []
        for each in own:
            # Without a time: at the right edge, side by side.
            x.append(each.seconds or span[1] / (span[1] / span[0]) ** (0.008 * unplaced))
            unplaced += each.seconds is None
        reasons = [inert(f"{style(name).label}, {each.title}: {_words(each)}") for each in own]
        found.append(failure_trace(name, numbers(x), high, reasons))
    return found


def _line_at(error: float) -> dict[str, Any]:
    return {
        "type": "line",
        "xref": "paper",
        "x0": 0,
        "x1": 1,
        "y0": error,
        "y1": error,
        "line": {"color": MUTED, "width": 1, "dash": "dot"},
    }
