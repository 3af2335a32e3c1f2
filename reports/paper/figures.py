"""Figures for papers: single columns, a page-wide overview of a scene, one of all verdicts.

In column widths, with fonts and colours for white paper. The files contain no dates and no random
names, so that identical results give identical bytes.
"""

from __future__ import annotations

import re
import textwrap
from base64 import b64encode
from collections.abc import Sequence
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from string import ascii_lowercase
from typing import TYPE_CHECKING, Any

import numpy as np

from comparisons.errors import InputError
from comparisons.facts.methods import ours
from comparisons.facts.quantities import in_order, quantity
from comparisons.judging.verdicts import NO_RESULT
from comparisons.results.finding import deciding
from comparisons.results.record import SceneRecord
from reports.plots.axes import DOWN, log_axis, log_ticks
from reports.plots.curves import printed_curves
from reports.plots.errors import errors
from reports.plots.figure import Axis, Figure, Guide, Series
from reports.plots.pressure import pressures
from reports.plots.speed import speed
from reports.plots.style import CROSS, INK, MUTED, PEER, TRUTH, Look, Marker, look

try:
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure as Drawing
except ModuleNotFoundError as error:
    raise InputError("figures need matplotlib: pip install 'roughline[paper]'") from error

if TYPE_CHECKING:
    from matplotlib.typing import RcKeyType

COLUMN, PAGE = 85.0, 180.0  # widths in mm of one column and of a page with two
HEIGHT = 62.0
FORMATS = ("pdf", "svg", "png")
_MILLIMETRE = 1 / 25.4
_SPACE = "\N{NO-BREAK SPACE}"  # a label is broken into lines, but never before its unit
_COLOURS = {INK: "#1a1a1a", MUTED: "#707070", PEER: "#767676", TRUTH: "#8a8a8a"}
_RC: dict[RcKeyType, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 7.5,
    "mathtext.fontset": "dejavusans",
    "axes.labelsize": 7.5,
    "axes.linewidth": 0.6,
    "axes.grid": True,
    "grid.color": "#e3e3e3",
    "grid.linewidth": 0.4,
    "axes.axisbelow": True,
    "xtick.labelsize": 7,
    "ytick.labelsize": 7,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "xtick.top": True,
    "ytick.right": True,
    "lines.linewidth": 1.0,
    "lines.markersize": 3.5,
    "legend.fontsize": 7,
    "legend.frameon": False,
    "legend.handlelength": 2.4,
    "figure.constrained_layout.use": True,
    # Type 42 embeds whole outlines, which publishers ask for; in SVG letters become outlines.
    "pdf.fonttype": 42,
    "svg.fonttype": "path",
    "svg.hashsalt": "roughline",
    "savefig.dpi": 300,
}
# No dates, and no version of the library: they would make equal figures differ.
_METADATA = {
    "pdf": {"Creator": None, "Producer": None, "CreationDate": None},
    "svg": {"Creator": None, "Date": None},
    "png": {"Software": None},
}
# Symbols whose plain form is not their printed one.
_SYMBOLS = {
    "√(A/π)": r"\sqrt{A/\pi}",
    "k/E*": r"k/E^{*}",
    "ū": r"\bar{u}",
    "Fₓ": r"F_x",
    "uₓ": r"u_x",
    "kₓ": r"k_x",
    "v₀": r"v_0",
    "µ": r"\mu",
    "∫p dA": r"\int p\,\mathrm{d}A",
}
LONGEST_LABEL = 32
MARKER_SIZE = 0.38  # points of print for a pixel of the page


class PaperFigure(Drawing):
    """A matplotlib figure saved to journal requirements and displayed in notebooks."""

    def savefig(self, fname: Any, **options: Any) -> None:
        """Save in roughline's style, without dates; the suffix determines the format."""
        kind = options.get("format") or Path(fname).suffix.lstrip(".")
        with mpl.rc_context(_RC):
            options.setdefault("metadata", _METADATA.get(kind))
            super().savefig(fname, **options)

    def _repr_html_(self) -> str:
        stream = BytesIO()
        self.savefig(stream, format="png", dpi=150)
        data = b64encode(stream.getvalue()).decode("ascii")
        width = round(self.get_figwidth() * 110)
        style = f"width:{width}px;max-width:100%;background:#fff"
        return f'<img alt="plot of results" style="{style}" src="data:image/png;base64,{data}">'


def colour(name: str) -> str:
    """Return a colour of the report as printed on white."""
    return _COLOURS.get(name, name)


def axis_label(name: str, unit: str) -> str:
    """Return "words symbol / unit" with the symbol in math mode.

    >>> axis_label("restitution", "")
    'coefficient of restitution $e$'
    """
    row = quantity(name)
    symbol = _SYMBOLS.get(row.symbol, row.symbol)
    if "_" in symbol and not symbol.startswith("\\") and symbol not in _SYMBOLS.values():
        base, _, below = symbol.partition("_")
        symbol = rf"{base}_\mathrm{{{below}}}"
    label = literal(row.label)
    text = f"{label} ${symbol}$" if symbol else label
    return f"{text}{_SPACE}/{_SPACE}{unit}" if unit else text


def literal(text: str) -> str:
    """Return text escaped for matplotlib, because results may contain arbitrary names."""
    return text.replace("$", r"\$")


def file_name(*names: str) -> str:
    """Return names joined to a safe file name of letters, digits and hyphens.

    >>> file_name("../ball", "contact_area")
    'ball-contact-area'
    """
    parts = (re.sub("[^a-z0-9]+", "-", name.lower()).strip("-") for name in names)
    return "-".join(part for part in parts if part)[:150]


def panels(scene: SceneRecord) -> dict[str, Figure]:
    """Return the plots available for a scene, with their file names.

    The pressure over radius or x is that at the last load, where a folder has it.
    """
    drawn = {
        file_name(figure.quantity, figure.x.quantity): figure for figure in printed_curves(scene)
    }
    for figure in pressures(scene):
        if figure.series:  # no map
            drawn["pressure"] = figure
    return drawn | {file_name(figure.key): figure for figure in (*errors(scene), *speed(scene))}


def single(figure: Figure) -> PaperFigure:
    """Return a plot as a single-column figure (85 mm)."""
    return _sheet([figure])


def overview(scene: SceneRecord) -> PaperFigure | None:
    """Return a lettered, page-wide figure (180 mm) of curves, error and cost, or None.

    Error and cost are those of the quantity that decides the verdict of the scene. Of a single
    load there is the cost alone, of that quantity and another one.
    """
    decisive = deciding(scene)
    name = decisive.quantity if decisive else ""
    chosen = printed_curves(scene)[:2]
    for figures in (errors(scene), speed(scene)):
        ordered = sorted(figures, key=lambda figure: figure.quantity != name)
        chosen += ordered[: 1 if chosen else 2]
    return sheet(chosen)


def sheet(figures: Sequence[Figure]) -> PaperFigure | None:
    """Return plots as a page-wide figure, lettered if there are several; None without any."""
    height = 12.0 + 58.0 * ((len(figures) + 1) // 2)
    return _sheet(figures, PAGE, height, columns=min(2, len(figures))) if figures else None


def verdict_figure(scenes: Sequence[SceneRecord]) -> PaperFigure | None:
    """Return the page-wide figure of all verdicts, or None where nothing was asked for."""
    figure = verdict_map(scenes)
    return _sheet([figure], PAGE, 24.0 + 4.6 * len(figure.y.ticks)) if figure else None


def _sheet(
    drawn: Sequence[Figure], width: float = COLUMN, height: float = HEIGHT, columns: int = 1
) -> PaperFigure:
    """Return plots in rows, lettered if there are several columns, under one legend."""
    with mpl.rc_context(_RC):
        paper = PaperFigure(figsize=(width * _MILLIMETRE, height * _MILLIMETRE))
        FigureCanvasAgg(paper)
        cells = paper.add_gridspec(-(-len(drawn) // columns), columns)
        for place, figure in enumerate(drawn):
            axes = paper.add_subplot(cells[divmod(place, columns)])
            draw(axes, figure)
            if columns > 1:
                axes.set_title(
                    f"({ascii_lowercase[place]})", loc="left", fontsize=8, fontweight="bold"
                )
        # Each name once, methods first.
        entries: dict[str, Any] = {}
        for axes in paper.axes:
            for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
                entries.setdefault(label, handle)
        first = [literal(look(method).label) for method in ours()]
        labels = sorted(
            entries, key=lambda name: first.index(name) if name in first else len(first)
        )
        for rows in range(1, len(labels) + 1):  # as few as the width allows
            legend = paper.legend(
                [entries[label] for label in labels],
                labels,
                loc="outside upper center",
                ncols=-(-len(labels) // rows),  # rows of equal length
                columnspacing=1.2,
            )
            if legend.get_window_extent().width <= paper.bbox.width or rows == len(labels):
                break
            legend.remove()
    return paper


def draw(axes: Any, figure: Figure) -> None:
    """Draw a figure on matplotlib axes: shading, lines and markers, then the axes."""
    across, up = figure.x.scale.factor, figure.y.scale.factor
    axes.set(xscale="log" if figure.x.log else "linear", yscale="log" if figure.y.log else "linear")
    for stretch in figure.stretches:
        shade = {"color": colour(stretch.colour), "alpha": 0.12, "lw": 0.5}
        axes.axvspan(
            stretch.low * across, stretch.high * across, **shade, label=literal(stretch.label)
        )
    for band in figure.bands:
        fill = axes.fill_betweenx if band.sideways else axes.fill_between
        along, height = (up, across) if band.sideways else (across, up)
        style = {"color": colour(band.colour), "alpha": band.opacity, "lw": 0}
        ends = band.along * along, band.low * height, band.high * height
        fill(*ends, **style, label=literal(band.label) or None)
    for series in figure.series:
        # What only a caption explains is the page's; what lies below the axis is an arrow, too.
        if series.legend or series.look.marker is DOWN:
            _draw_series(axes, series, figure)
    for level in figure.levels:
        style = {"color": colour(level.colour), "lw": 0.7, "ls": level.dash.matplotlib}
        axes.axhline(level.value * up, **style, label=literal(level.label) or None)
    for guide in figure.guides:
        if not guide.text:  # else the ticks say it, too
            axes.axvline(
                guide.value * across, color=colour(guide.colour), lw=0.6, ls=":", zorder=0.5
            )
    if figure.x.limits:
        axes.set_xlim(*np.multiply(figure.x.limits, across))
    if figure.y.limits:
        axes.set_ylim(*np.multiply(figure.y.limits, up))
    for drawn, axis in ((axes.xaxis, figure.x), (axes.yaxis, figure.y)):
        if axis.log or axis.ticks:
            # Of a logarithmic axis without ticks of its own: plain numbers at 1, 2 and 5.
            ticks = axis.ticks or log_ticks(drawn.get_view_interval(), lambda value: f"{value:g}")
            factor = axis.scale.factor if axis.ticks else 1.0
            drawn.set_ticks([value * factor for value, _ in ticks], [text for _, text in ticks])
            drawn.set_ticks([], minor=True)
    axes.set_xlabel(_title(figure.x))
    lines = textwrap.wrap(_title(figure.y), LONGEST_LABEL, break_long_words=False)
    axes.set_ylabel("\n".join(lines))
    if figure.x.quantity == "step":
        axes.xaxis.get_major_locator().set_params(integer=True)


def _draw_series(axes: Any, series: Series, figure: Figure) -> None:
    look = series.look
    x, y = series.x * figure.x.scale.factor, series.y * figure.y.scale.factor
    if not np.isfinite(x * y).any():
        return  # an empty line that is not clipped would have its place at the origin
    ink = colour(look.colour)
    rim = colour("@ink") if series.outlined else ink
    # An outline hides the line that it stands on, but a ring not the mark that it stands around.
    inside = "white" if series.line else "none"
    (line,) = axes.plot(
        *(x, y),
        color=ink,
        linestyle=look.dash.matplotlib if series.line else "none",
        linewidth=series.width / 2,
        drawstyle="steps-post" if series.stairs else "default",
        marker=look.marker.matplotlib if series.marks else "",
        markersize=MARKER_SIZE * (series.size or look.size),
        markerfacecolor=inside if np.any(series.hollow) else ink,
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


def _title(axis: Axis) -> str:
    if axis.quantity:
        return axis_label(axis.quantity, axis.scale.unit)
    return literal(f"{axis.title} of {axis.of}" if axis.of else axis.label)


LOW, HIGH = 1e-3, 1e3  # of error over tolerance: what lies beyond is an arrow at the edge
VERDICTS_CAPTION = (
    "Largest |e| over all load steps at equal prescribed load, with its bar u, over the tolerance "
    "that was asked for; a marker for each quantity, hollow where the model is too low. Left of "
    "the dotted line with the whole bar: within. Arrows: beyond the axis. Crosses: no result."
)
MARKERS = (
    *(Marker("circle", "o"), Marker("square", "s"), Marker("triangle-up", "^")),
    *(Marker("diamond", "D"), Marker("triangle-down", "v"), Marker("pentagon", "p")),
    *(Marker("star", "*"), Marker("hexagon", "h"), Marker("cross", "P")),
)
UNDER, OVER = Marker("arrow-left", 4), Marker("arrow-right", 5)
SPREAD = 0.7  # of a row, over which its markers stand


def verdict_map(scenes: Sequence[SceneRecord]) -> Figure | None:
    """Return error over tolerance of the leading method of each scene, or None without scenes.

    Of one scene each quantity has a row, with its error.
    """
    every = [scene.verdicts_on(scene.judged_methods[0]) for scene in scenes]
    rows = [tuple(item for item in row if item.counts and item.offered) for row in every]
    labels = [scene.name for scene in scenes]
    if len(scenes) == 1:
        labels = [item.text for item in rows[0]]
        rows = [(item,) for item in rows[0]]
    names = in_order({item.quantity for row in rows for item in row})
    if not names:
        return None
    ink = look(scenes[0].judged_methods[0]).colour
    # Of each quantity markers, bars, arrows at both edges, and crosses.
    series: list[Series] = []
    for number, name in enumerate(names):
        items = [
            (height + SPREAD * ((place + 0.5) / len(row) - 0.5), item)
            for height, row in enumerate(rows)
            for place, item in enumerate(row)
            if item.quantity == name
        ]
        known = [(height, item) for height, item in items if item.word != NO_RESULT]
        heights = np.array([height for height, _ in known])
        sizes = np.array([abs(item.error) / item.tolerance for _, item in known])
        bars = np.nan_to_num([item.uncertainty / item.tolerance for _, item in known])
        low = np.array([item.error < 0 for _, item in known], dtype=bool)
        hover = tuple(f"{item.text}\n{item.because}: {item.word}" for _, item in known)
        inside = np.where((sizes > LOW) & (sizes < HIGH), sizes, np.nan)
        style = Look(quantity(name).label, ink, MARKERS[number % len(MARKERS)], size=9)
        series.append(Series(style, inside, heights, line=False, hollow=low, hover=hover))
        # The bars are one line with gaps.
        ends = np.clip([np.maximum(sizes - bars, 0.0), sizes + bars, sizes], LOW, HIGH)
        ends[2] = np.nan
        nameless = style.labelled("")
        along = ends.T.ravel(), np.repeat(heights, 3)
        series.append(Series(nameless, *along, marks=False, width=1.2))
        for marker, edge, beyond in ((UNDER, LOW, sizes <= LOW), (OVER, HIGH, sizes >= HIGH)):
            arrows = np.where(beyond, edge, np.nan)
            series.append(Series(replace(nameless, marker=marker), arrows, heights, line=False))
        lost = np.array([height for height, item in items if item.word == NO_RESULT])
        crossed = replace(style, label="no result" if len(lost) else "", marker=CROSS)
        series.append(Series(crossed, np.full(len(lost), 0.8 * HIGH), lost, line=False))
    ticks = tuple((float(number), label) for number, label in enumerate(labels))
    return Figure(
        "verdicts",
        "Error over tolerance of all scenes",
        VERDICTS_CAPTION,
        log_axis("(|e| ± u) / tolerance", (LOW, HIGH), most=9),
        Axis("", limits=(len(rows) - 0.5, -0.5), ticks=ticks),
        tuple(series),
        guides=(Guide(1.0, colour=INK),),
    )
