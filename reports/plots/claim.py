"""The evidence of a claim as a picture: its error along the parameter, against the tolerance."""

from __future__ import annotations

from typing import Any

import numpy as np

from comparisons import formatting as fmt
from comparisons.judging.verdicts import NOT_RESOLVED, OUTSIDE, WITHIN
from comparisons.questions.claims.record import ClaimRecord, PointRecord
from comparisons.questions.claims.wording import value
from reports.plots.curves import (
    NOTE_MARGIN,
    error_axis,
    error_range,
    tolerance_line,
    tolerance_note,
)
from reports.plots.style import BLUE, GREEN, VERMILION, Figure, axis, inert, layout, numbers

CAPTION = (
    "Size of the error with its 95 % bar at every value measured; the shaded stretch is where the "
    "claim holds, and its edges are known to the distance of the next marks."
)
MARKS = {
    WITHIN: ("within", GREEN, "circle"),
    OUTSIDE: ("outside", VERMILION, "x"),
    NOT_RESOLVED: ("not resolved", BLUE, "circle-open"),
}


def evidence(claim: ClaimRecord) -> Figure | None:
    """Return the error against the varied parameter, None where nothing varies."""
    points = [p for p in claim.points if p.parameter is not None and p.error is not None]
    if len(points) < 2:
        return None
    sizes = np.array([abs(p.error or 0.0) for p in points])
    low, high = error_range(sizes, claim.tolerance)
    traces = [_marks([p for p in points if p.word == word], word, low) for word in MARKS]
    shapes = [_stretch(each.low, each.high) for each in claim.ranges]
    spec = {
        "data": [trace for trace in traces if trace["x"]],
        "layout": layout(
            axis(claim.parameter, log=claim.spacing == "log"),
            error_axis(low, high, "relative error, size"),
            margin=NOTE_MARGIN,
            shapes=[*shapes, tolerance_line(claim.tolerance)],
            annotations=[tolerance_note(claim.tolerance)],
        ),
    }
    return Figure("evidence", f"Error against {claim.parameter}", CAPTION, spec)


def _marks(points: list[PointRecord], word: str, low: float) -> dict[str, Any]:
    """Return the points of one word; errors below the axis stand on its edge."""
    name, colour, symbol = MARKS[word]
    sizes = [max(abs(p.error or 0.0), low) for p in points]
    bars = [p.uncertainty or 0.0 for p in points]
    return {
        "type": "scatter",
        "mode": "markers",
        "name": name,
        "x": numbers([p.parameter for p in points]),
        "y": numbers(sizes),
        "error_y": {
            "type": "data",
            "symmetric": False,
            "array": numbers(bars),
            # A bar that reaches zero ends at the foot of a logarithmic axis.
            "arrayminus": numbers([min(b, 0.999 * s) for b, s in zip(bars, sizes, strict=True)]),
            "thickness": 1,
            "color": colour,
        },
        "marker": {"color": colour, "symbol": symbol, "size": 9},
        "hovertext": [_hover(p) for p in points],
        "hoverinfo": "text",
    }


def _hover(point: PointRecord) -> str:
    lines = [f"{value(point.parameter or 0.0)}: {fmt.plus_minus(point.error, point.uncertainty)}"]
    lines += [f"{key}: {detail(given)}" for key, given in point.details.items()]
    return "<br>".join(inert(line) for line in lines)


def detail(given: float | str | None) -> str:
    """Return one detail of a measurement as text."""
    return given if isinstance(given, str) else fmt.number(given)


def _stretch(low: float, high: float) -> dict[str, Any]:
    """Shade where the claim holds; a single point is a line."""
    return {  # shapes take values on a logarithmic axis, too: only annotations take logarithms
        "type": "rect",
        "yref": "paper",
        "x0": low,
        "x1": high,
        "y0": 0,
        "y1": 1,
        "line": {"width": 1, "color": "rgba(0,158,115,0.4)"},
        "fillcolor": "rgba(0,158,115,0.12)",
        "layer": "below",
    }
