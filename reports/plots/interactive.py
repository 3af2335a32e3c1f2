"""Figures for the page as plain dicts for plotly.js, without the Python package plotly.

plotly interprets some HTML in names and hover texts, so all texts are escaped. A plot with a load
slider has one frame per load, with the differences of each trace and the layout from the last load.
"""

from __future__ import annotations

import base64
import html
import re
from collections.abc import Iterable
from typing import Any

import numpy as np

from comparisons import formatting as fmt
from comparisons.facts.quantities import quantity
from reports.plots.figure import Axis, Band, Figure, Map, Series
from reports.plots.style import BLUE, CONTACT, VERMILION

LARGEST_CODE = 2**16 - 1
NOTE_MARGIN = {"l": 60, "r": 52, "t": 30, "b": 50}  # room for "asked 1 %" on the right
FEW_TICKS = 6  # of them none need be turned
TALL = 28  # characters that fit beside a plot on one line
# Heights in grey, contacts above them in one colour, paler where little of a block touches.
CONTACTS = {
    "colorscale": [[0, "#303030"], [0.86, "#e0e0e0"], [0.88, "#f5dfb0"], [1, CONTACT]],
    "showscale": False,
    "hoverinfo": "skip",
    "hovertemplate": None,
}
# Of differences: too low in blue, too high in vermilion; grey keeps contacts apart from gaps.
SIGNED = [[0, BLUE], [0.5, "#b8b8b8"], [1, VERMILION]]
TOKENS = ("@ink", "@peer", "@truth")  # their light versions are the page's own


def spec(figure: Figure) -> dict[str, Any]:
    """Return data and layout of a figure, and the frames of its load slider, if any."""
    traces, layout = _traces(figure), _layout(figure)
    last = {"data": traces, "layout": layout}
    if not figure.earlier:
        return last
    frames = []
    for frame in (*figure.earlier, figure):
        moved = [
            {key: value for key, value in trace.items() if value != final.get(key)}
            for trace, final in zip(_traces(frame), traces, strict=True)
        ]
        frames.append({"data": moved, "layout": {"shapes": _shapes(frame)} if frame.levels else {}})
    return last | {"frames": frames}


def _traces(figure: Figure) -> list[dict[str, Any]]:
    drawn = [_map(figure.map, figure)] if figure.map else []
    drawn += [_band(band, figure) for band in figure.bands]
    return drawn + [_series(series, figure) for series in figure.series]


def _series(series: Series, figure: Figure) -> dict[str, Any]:
    look, x, y = series.look, figure.x.scale, figure.y.scale
    trace: dict[str, Any] = {
        "type": "scatter",
        "mode": "+".join(["lines"] * series.line + ["markers"] * series.marks),
        "name": inert(look.label),
        "x": numbers(series.x, x.factor, series.digits),
        "y": numbers(series.y, y.factor, series.digits),
    }
    if series.line:
        line = {"color": look.colour, "dash": look.dash.plotly, "width": series.width}
        trace["line"] = line | ({"shape": "hv"} if series.stairs else {})
    if series.marks:
        hollow = np.asarray(series.hollow)
        signs = [look.marker.plotly + "-open" * bool(is_open) for is_open in np.atleast_1d(hollow)]
        marker: dict[str, Any] = {
            "color": look.colour,
            "symbol": signs if hollow.ndim else signs[0],
            "size": series.size or look.size,
        }
        if hollow.any() or hollow.ndim:  # filled ones beside hollow ones are of one size
            marker["line"] = {"width": 1.5, "color": look.colour}
        if series.outlined:
            marker["line"] = {"width": 2, "color": "@ink"}
        if series.directed:
            marker |= {"symbol": "arrow", "angleref": "previous"}
        trace["marker"] = marker | ({"opacity": series.faint} if series.faint < 1.0 else {})
        trace["cliponaxis"] = figure.clipped
    if not (series.legend and look.label):
        trace["showlegend"] = False
    if series.group:
        trace["legendgroup"] = inert(series.group)
    if series.bars is not None:
        up = numbers(series.bars, y.factor)
        trace["error_y"] = {"type": "data", "array": up, "thickness": 1.2, "width": 4}
        if figure.y.log:
            # A bar that reaches zero ends at the foot of a logarithmic axis.
            down = numbers(np.minimum(series.bars, 0.999 * np.abs(series.y)), y.factor)
            trace["error_y"] |= {"symmetric": False, "arrayminus": down}
    if series.hover is None:
        return trace | {"hoverinfo": "skip"}
    if isinstance(series.hover, str):
        units = zip("xy", (x.unit, y.unit), strict=True)
        where = "<br>".join(f"%{{{name}:.3g}} {unit}".strip() for name, unit in units)
        return trace | {"hovertemplate": f"{lines(series.hover)}<br>{where}<extra></extra>"}
    texts = [lines(text) for text in series.hover]
    return trace | {"text": texts, "hovertemplate": "%{text}<extra></extra>"}


def _band(band: Band, figure: Figure) -> dict[str, Any]:
    """Return a filled polygon without hover text."""
    keep = np.isfinite(band.along) & np.isfinite(band.low) & np.isfinite(band.high)
    along, low, high = (
        np.asarray(values, dtype=float)[keep] for values in (band.along, band.low, band.high)
    )
    if len(along) < 2:
        along = low = high = np.empty(0)
    outline = np.concatenate([along, along[::-1]]), np.concatenate([low, high[::-1]])
    right, up = reversed(outline) if band.sideways else outline
    return {
        "type": "scatter",
        "x": numbers(right, figure.x.scale.factor),
        "y": numbers(up, figure.y.scale.factor),
        "fill": "toself",
        "fillcolor": _light(band.colour, band.opacity),
        "line": {"width": 0},
        "mode": "lines",
        "hoverinfo": "skip",
        "showlegend": False,
    }


def _light(colour: str, opacity: float) -> str:
    """Return a light version of a colour; tokens are resolved in the page."""
    if colour in TOKENS:
        return f"{colour}-band"
    red, green, blue = (int(colour[i : i + 2], 16) for i in (1, 3, 5))
    return f"rgba({red},{green},{blue},{opacity})"


def _map(drawn: Map, figure: Figure) -> dict[str, Any]:
    # plotly's rows run along y, ours along x.
    z = (drawn.values * drawn.scale.factor).T
    unit = drawn.scale.unit
    label = f"{drawn.symbol} / {unit}" if unit else drawn.symbol
    trace: dict[str, Any] = {
        "type": "heatmap",
        "x": numbers(drawn.x, figure.x.scale.factor),
        "y": numbers(drawn.y, figure.y.scale.factor),
        "z": coded_map(z, signed=drawn.signed) if z.size else [],
        "colorscale": "Viridis",
        "colorbar": {"title": {"text": inert(label), "side": "right"}, "thickness": 14, "xpad": 18},
        "hoverongaps": False,
        "hovertemplate": f"{inert(drawn.symbol)} = %{{z:.3g}} {unit}<extra></extra>",
        "zmin": 0,
        "zmax": float(f"{drawn.highest * drawn.scale.factor:.3g}"),
    }
    if drawn.contacts:
        return trace | CONTACTS
    return trace | ({"colorscale": SIGNED, "zmin": -trace["zmax"]} if drawn.signed else {})


def coded_map(values: np.ndarray, *, signed: bool = False) -> dict[str, Any]:
    """Return a map of positive values (NaN: a gap) in 16-bit codes, a third of its size as JSON.

    A value is its code times the step, less the highest value if signed; code 0 is a gap, and the
    smallest values have code 1.
    """
    known = np.isfinite(values) if signed else np.nan_to_num(values) > 0
    highest = float(np.abs(values[known]).max(initial=0.0))
    step = (1 + signed) * highest / LARGEST_CODE if highest > 0 else 1.0
    codes = np.round((np.where(known, values, 0.0) + signed * highest) / step)
    codes = np.where(known, np.clip(codes, 1, LARGEST_CODE), 0)
    text = base64.b64encode(codes.astype("<u2").tobytes()).decode()
    coded = {"codes": text, "shape": list(values.shape), "step": float(f"{step:.6g}")}
    return coded | ({"below": float(f"{highest:.6g}")} if signed else {})


def _layout(figure: Figure) -> dict[str, Any]:
    """Return the figure's own part of the layout; fonts, grid and background come from the page."""
    layout: dict[str, Any] = {"xaxis": _axis(figure.x), "yaxis": _axis(figure.y)}
    layout["yaxis"]["title"]["text"] = _upright(_title(figure.y), figure.y.label)
    if figure.x.ticks:  # turned, they end at their tick: plotly hides what passes the right end
        few = len(figure.x.ticks) <= FEW_TICKS
        layout["xaxis"] |= {"tickangle": 0} if few else {"autotickangles": [0, -30, -90]}
    if figure.map:
        for name in ("xaxis", "yaxis"):
            layout[name] |= {"constrain": "domain", "showgrid": False}
        layout["yaxis"]["scaleanchor"] = "x"
    layout["shapes"] = _shapes(figure)
    # Labels of levels stand in the right margin, where no marker can cover them; those of guides
    # above the plot. Only annotations take logarithms on a logarithmic axis.
    layout["annotations"] = [
        {
            "xref": "paper",
            "x": 1.01,
            "y": float(np.log10(level.value)),
            "text": inert(level.label).replace(": ", "<br>"),
            "showarrow": False,
            "xanchor": "left",
            "yanchor": "middle",
            "align": "left",
            "font": {"size": 11, "color": level.colour},
        }
        for level in figure.levels
        if level.label
    ]
    if layout["annotations"]:
        layout["margin"] = NOTE_MARGIN
    for guide in figure.guides:
        if guide.text:
            place = guide.value * figure.x.scale.factor
            note = {
                "x": float(np.log10(place) if figure.x.log else place),
                "yref": "paper",
                "y": 1.0,
                "yanchor": "bottom",
                "yshift": 5,
                "text": inert(guide.text),
                "showarrow": False,
                "font": {"size": 11, "color": guide.colour},
            }
            layout["annotations"].append(note)
    if not figure.legend:
        layout["showlegend"] = False
    return {key: value for key, value in layout.items() if value or key == "showlegend"}


def _shapes(figure: Figure) -> list[dict[str, Any]]:
    """Return shaded intervals (a single point is a line), levels and guides."""
    across, up = figure.x.scale.factor, figure.y.scale.factor
    over_height = {"yref": "paper", "y0": 0, "y1": 1, "layer": "below"}
    shapes: list[dict[str, Any]] = []
    for stretch in figure.stretches:
        ends = {"x0": stretch.low * across, "x1": stretch.high * across}
        rim = {"width": 1, "color": _light(stretch.colour, 0.4)}
        fill = {"line": rim, "fillcolor": _light(stretch.colour, 0.12)}
        shapes.append({"type": "rect"} | over_height | ends | fill)
    for level in figure.levels:
        if np.isfinite(y := level.value * up):
            pen = {"color": level.colour, "width": 1, "dash": level.dash.plotly}
            over_width = {"xref": "paper", "x0": 0, "x1": 1, "y0": y, "y1": y}
            shapes.append({"type": "line"} | over_width | {"line": pen})
    for guide in figure.guides:
        x, pen = guide.value * across, {"color": guide.colour, "width": 1, "dash": "dot"}
        shapes.append({"type": "line"} | over_height | {"x0": x, "x1": x, "line": pen})
    return shapes


def _axis(axis: Axis) -> dict[str, Any]:
    layout: dict[str, Any] = {
        "title": {"text": _title(axis)},
        "type": "log" if axis.log else "linear",
    }
    if axis.limits:
        limits = np.array(axis.limits) * axis.scale.factor
        layout["range"] = [float(end) for end in (np.log10(limits) if axis.log else limits)]
    elif axis.quantity:
        layout["rangemode"] = "tozero"
    if axis.ticks:
        layout["tickvals"] = numbers([value for value, _ in axis.ticks], axis.scale.factor)
        layout["ticktext"] = [text for _, text in axis.ticks]
        if not axis.log:  # names in place of numbers; long ones on two lines, for phones
            names = [inert(text).replace(": ", "<br>") for _, text in axis.ticks]
            layout |= {"ticktext": names, "automargin": True, "zeroline": False}
    return layout


def _title(axis: Axis) -> str:
    """Return the title of an axis with HTML subscripts for plotly.

    >>> _title(Axis(quantity="pull_off_force", scale=fmt.Scale(1e3, "mN")))
    'largest pull F<sub>off</sub> / mN'
    """
    title, symbol = inert(axis.label), quantity(axis.quantity).symbol
    return title.replace(symbol, re.sub(r"_(\w+)", r"<sub>\1</sub>", symbol)) if symbol else title


def _upright(title: str, label: str) -> str:
    """Return the title of a vertical axis, on two lines if a plot on a phone is lower than it.

    >>> _upright("depth left after unloading d / m", "depth left after unloading d / m")
    'depth left after<br>unloading d / m'
    """
    if len(label) <= TALL:
        return title
    breaks = [match.start() for match in re.finditer(" (?![^<]*>)", title)]
    half = min(breaks, key=lambda place: abs(place - len(label) / 2), default=None)
    return title if half is None else f"{title[:half]}<br>{title[half + 1 :]}"


def inert(text: object) -> str:
    """Escape text for plotly, which interprets some HTML in names and hover texts."""
    return html.escape(str(text), quote=False)


def lines(text: str) -> str:
    """Return escaped text with line breaks."""
    return inert(text).replace("\n", "<br>")


def numbers(values: Iterable[object], factor: float = 1.0, digits: int = 6) -> list[float | None]:
    """Return scaled, rounded values, with None (a gap in the curve) for missing ones."""
    given = values if isinstance(values, np.ndarray) else np.array([*values], dtype=object)
    if given.dtype == object:
        given = np.array([value if fmt.finite(value) else np.nan for value in given], dtype=float)
    scaled = np.asarray(given, dtype=float).ravel() * factor
    form = f"%.{digits}g"
    return [
        float(form % value) if known else None
        for value, known in zip(scaled.tolist(), np.isfinite(scaled).tolist(), strict=True)
    ]
