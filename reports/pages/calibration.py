"""The page of the calibration: coverage and width of the bars."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from comparisons import formatting as fmt
from comparisons.files import write_text
from comparisons.questions.calibration import Case, Summary, summary
from reports.pages.page import render
from reports.plots.curves import error_axis
from reports.plots.style import INK, Figure, drawing_order, inert, layout, numbers, style

SMALLEST = 1e-8  # errors below are the arithmetic's of the solvers


def write_calibration_report(found: list[Case], command: str, path: Path) -> None:
    """Write both figures and the tables as one HTML file, atomically."""
    write_text(path, calibration_page(found, command))


def calibration_page(found: list[Case], command: str) -> str:
    """Return the whole page as text."""
    reported = [case for case in found if case.half == "reported"]
    drawn = [covered(reported), widths(found)]
    return render(
        "calibration.html.j2",
        {each.key: each.spec for each in drawn},
        command=command,
        figures=drawn,
        halves=[(half, summary(_of(found, half=half))) for half in ("reported", "fitting")],
        rows=rows(reported),
    )


def _label(key: str, value: str) -> str:
    """Return a part's name as the plots have it."""
    return style(value).label if key == "method" else value.replace("_", " ")


def _of(found: list[Case], **wanted: str) -> list[Case]:
    return [c for c in found if all(getattr(c, key) == value for key, value in wanted.items())]


def rows(found: list[Case]) -> list[tuple[str, str, Summary]]:
    """Return coverage and width for each method, each quantity and each shape."""
    return [
        (key, _label(key, value), summary(_of(found, **{key: value})))
        for key in ("method", "quantity", "shape")
        for value in dict.fromkeys(getattr(case, key) for case in found)
    ]


def covered(found: list[Case]) -> Figure:
    """Return bar against true error: points above the line are covered."""
    traces = [_points(_of(found, method=name), name) for name in drawing_order(_methods(found))]
    errors = np.array([max(case.error, SMALLEST) for case in found])
    bars = np.array([max(case.bar, SMALLEST) for case in found])
    low = 10.0 ** np.floor(np.log10(min(errors.min(), bars.min())))
    high = 10.0 ** np.ceil(np.log10(max(errors.max(), bars.max())))
    lines = [_line(low, high, factor, name) for factor, name in ((1, "bar = error"), (10, "10 ×"))]
    spec = {
        "data": [*lines, *traces],
        "layout": layout(
            error_axis(low, high, "true error (rms over the loads)"),
            error_axis(low, high, "bar (95 %)"),
        ),
    }
    caption = (
        "Each mark is one quantity of one series of resolutions on a shape that had no part in "
        "fixing the estimator. Above the solid line the bar covers the true error; at the dashed "
        "line it is ten times as wide."
    )
    return Figure("covered", "Does the bar cover the true error?", caption, spec)


def _points(found: list[Case], method: str) -> dict[str, Any]:
    look = style(method)
    return {
        "type": "scatter",
        "mode": "markers",
        "name": look.label,
        "x": numbers([max(case.error, SMALLEST) for case in found]),
        "y": numbers([max(case.bar, SMALLEST) for case in found]),
        "marker": {"color": look.colour, "symbol": look.symbol, "size": 6, "opacity": 0.7},
        "hovertext": [_hover(case) for case in found],
        "hoverinfo": "text",
    }


def _hover(case: Case) -> str:
    what = f"{case.shape}, {case.quantity.replace('_', ' ')}"
    levels = ", ".join(map(str, case.resolutions))
    numbers_ = f"error {fmt.relative(case.error)}, bar {fmt.relative(case.bar)}"
    return "<br>".join(inert(line) for line in (what, f"N = {levels}", numbers_))


def _line(low: float, high: float, factor: float, name: str) -> dict[str, Any]:
    return {
        "type": "scatter",
        "mode": "lines",
        "name": name,
        "x": [low, high],
        "y": [factor * low, factor * high],
        "line": {"color": INK, "width": 1, "dash": "solid" if factor == 1 else "dash"},
        "hoverinfo": "skip",
    }


def widths(found: list[Case]) -> Figure:
    """Return the share of cases whose bar is at most k times the error, against k."""
    data = []
    for half, dash in (("reported", "solid"), ("fitting", "dot")):
        ratios = np.sort([c.bar / max(c.error, 1e-16) for c in _of(found, half=half)])
        share = (np.arange(len(ratios)) + 1) / len(ratios)
        data.append(
            {
                "type": "scatter",
                "mode": "lines",
                "line": {"shape": "hv", "dash": dash, "width": 2, "color": style("bem_fft").colour},
                "name": f"{half} half",
                "x": numbers(np.clip(ratios, 0.1, 1e4)),
                "y": numbers(share, 100),
            }
        )
    ticks = {"tickvals": [0.1, 1, 10, 100, 1000], "ticktext": ["0.1", "1", "10", "100", "1000"]}
    xaxis = {"title": {"text": "width: bar over true error"}, "type": "log", "range": [-1, 3]}
    spec = {
        "data": data,
        "layout": layout(
            xaxis | ticks,
            {"title": {"text": "share of the cases / %"}, "type": "linear", "range": [0, 100]},
            shapes=[_guide(1.0), _guide(10.0)],
        ),
    }
    caption = (
        "Share of the cases whose bar is narrower than so many times the true error. Left of 1 the "
        "bar misses: at most 5 % may lie there. The median should be left of 10."
    )
    return Figure("widths", "How wide are the bars?", caption, spec)


def _guide(x: float) -> dict[str, Any]:
    place = {"type": "line", "yref": "paper", "x0": x, "x1": x, "y0": 0, "y1": 1}
    return place | {"line": {"color": INK, "width": 1, "dash": "dot"}}


def _methods(found: list[Case]) -> list[str]:
    return list(dict.fromkeys(case.method for case in found))
