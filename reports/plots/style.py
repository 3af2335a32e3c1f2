"""The look of every plot: one colour, marker and dash per method, axes, bands.

Colours that depend on light or dark are tokens ("@ink"); the page's script replaces them when it
draws and again when the reader's preference changes. Figures are plain dicts of plotly.js, so the
plotly package is needed only for the script itself.
"""

from __future__ import annotations

import html
import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from comparisons import formatting as fmt

# Okabe & Ito, "Color Universal Design" (2008): told apart with any kind of colour vision.
BLACK, ORANGE, SKY, GREEN = "#000000", "#E69F00", "#56B4E9", "#009E73"
YELLOW, BLUE, VERMILION, PURPLE = "#F0E442", "#0072B2", "#D55E00", "#CC79A7"
INK, MUTED, GRID, CONTACT = "@ink", "@muted", "@grid", ORANGE
LOG_SPAN = 15.0  # loads spread wider than this are drawn on logarithmic axes


@dataclass(frozen=True)
class MethodStyle:
    """How a method looks on every plot: sizes nest, so coinciding markers all stay visible."""

    label: str
    colour: str
    symbol: str
    dash: str
    size: float


STYLES = {
    "closed_form": MethodStyle("closed form", INK, "star", "solid", 9),
    "reduced": MethodStyle("reduced model", VERMILION, "circle", "dash", 6),
    "bem_dense": MethodStyle("dense BEM", SKY, "square", "dot", 10),
    "bem_fft": MethodStyle("FFT BEM", BLUE, "diamond", "dashdot", 9),
    "fem": MethodStyle("FEM", GREEN, "triangle-up", "longdash", 12),
}
# Other people's codes are grey.
PEER_STYLES = {
    "tamaas": MethodStyle("Tamaas", "@peer", "pentagon", "longdashdot", 11),
    "contactmechanics": MethodStyle("ContactMechanics", "@peer", "hexagon", "6px,3px", 8),
    "ngsolve": MethodStyle("NGSolve", "@peer", "star-triangle-up", "4px,2px", 9),
}
PEER_SYMBOLS = ("triangle-down", "bowtie", "x", "cross")
# Later ones are drawn on top: the widest markers first, the model under test last.
DRAWING_ORDER = ("closed_form", "fem", "bem_dense", "bem_fft")


@dataclass(frozen=True)
class Figure:
    """One plot of the page.

    Attributes
    ----------
    key, title, caption : str
        Plain text.
    spec : dict
        plotly's data and layout; `frames` where a load slider moves it (`load_frames`).
    quantity : str
        The columns that it shows, separated by spaces: what the page's choice of a quantity
        keeps. Always shown where empty.
    """

    key: str
    title: str
    caption: str
    spec: dict[str, Any] = field(repr=False)
    quantity: str = ""

    @property
    def moves(self) -> bool:
        """Whether a load slider moves the plot."""
        return "frames" in self.spec


def style(method: str) -> MethodStyle:
    """Return a method's style; methods of other people are grey, with a marker of their own."""
    known = STYLES | PEER_STYLES
    if method in known:
        return known[method]
    symbol = PEER_SYMBOLS[sum(method.encode()) % len(PEER_SYMBOLS)]
    return MethodStyle(method.replace("_", " "), "@peer", symbol, "longdashdot", 8)


def drawing_order(methods: Iterable[str]) -> list[str]:
    """Return methods in the order in which their curves are laid over each other."""
    names = list(methods)
    last = [name for name in names if name == "reduced"]
    first = [name for name in DRAWING_ORDER if name in names]
    return first + [name for name in names if name not in first + last] + last


def inert(text: object) -> str:
    """Make text harmless inside plotly, which reads a little HTML in names and hovers."""
    return html.escape(str(text), quote=False)


def numbers(values: Iterable[object], factor: float = 1.0) -> list[float | None]:
    """Return scaled values with six digits, None (a gap in the curve) where there is none."""
    return [
        float(f"{float(value) * factor:.6g}") if fmt.finite(value) else None  # type: ignore[arg-type]
        for value in values
    ]


def short_numbers(values: Iterable[object]) -> list[float | None]:
    """Return values with four digits, which is what a profile on a screen can show."""
    return [float(f"{float(v):.4g}") if fmt.finite(v) else None for v in values]  # type: ignore[arg-type]


def colour_with_alpha(colour: str, alpha: float) -> str:
    """Return a light version of a method's colour for bands; tokens keep theirs in the page."""
    if colour.startswith("@"):
        return f"{colour}-band"
    red, green, blue = (int(colour[i : i + 2], 16) for i in (1, 3, 5))
    return f"rgba({red},{green},{blue},{alpha})"


def band(
    x: Sequence[object], low: Sequence[object], high: Sequence[object], colour: str, alpha: float
) -> list[dict[str, Any]]:
    """Return a filled band between two curves, silent under the mouse."""
    kept = [
        (a, b, c)
        for a, b, c in zip(x, low, high, strict=True)
        if a is not None and b is not None and c is not None
    ]
    if len(kept) < 2:
        return []
    return [
        {
            "type": "scatter",
            "x": [a for a, _, _ in kept] + [a for a, _, _ in reversed(kept)],
            "y": [b for _, b, _ in kept] + [c for _, _, c in reversed(kept)],
            "fill": "toself",
            "fillcolor": colour_with_alpha(colour, alpha),
            "line": {"width": 0},
            "mode": "lines",
            "hoverinfo": "skip",
            "showlegend": False,
        }
    ]


def axis(title: str, *, log: bool = False, **more: Any) -> dict[str, Any]:
    """Return an axis with its title; logarithmic ones show decades as plain numbers."""
    return {"title": {"text": title}, "type": "log" if log else "linear"} | more


def axis_words(name: str, unit: str) -> str:
    """Return the title of a quantity's axis; plotly sets what follows an underscore lower.

    >>> axis_words("pull_off_force", "mN")
    'pull-off force F<sub>off</sub> / mN'
    """
    title, symbol = inert(fmt.axis_title(name, unit)), fmt.quantity(name).symbol
    return title.replace(symbol, re.sub(r"_(\w+)", r"<sub>\1</sub>", symbol)) if symbol else title


def value_axis(title: str, values: np.ndarray, log: bool) -> dict[str, Any]:
    """Return the axis of a quantity: from zero if linear, with ticks at 1, 2 and 5 if not."""
    known = values[np.isfinite(values) & (values > 0)]
    if not log or not len(known):
        return axis(title, rangemode="tozero")
    low, high = np.log10(known.min()), np.log10(known.max())
    margin = max(0.06 * (high - low), 0.05)
    ticks = log_ticks(10 ** (low - margin), 10 ** (high + margin), lambda v: fmt.number(v, 1))
    return axis(title, log=True, range=[float(low - margin), float(high + margin)], **ticks)


def log_ticks(low: float, high: float, label: Any, most: int = 8) -> dict[str, Any]:
    """Return ticks inside `low` to `high` with worded labels: 1-2-5, or whole decades if many."""
    first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
    stride = max(1, math.ceil((last - first + 1) / most))
    steps = (1, 2, 5) if 3 * (last - first) <= most + 2 else (1,)
    values = [
        float(f"{step}e{power}") for power in range(first, last + 1, stride) for step in steps
    ]
    values = [value for value in values if 0.999 * low <= value <= 1.001 * high]
    return {"tickvals": values, "ticktext": [label(value) for value in values]}


def layout(xaxis: dict[str, Any], yaxis: dict[str, Any], **more: Any) -> dict[str, Any]:
    """Return the layout all plots share; fonts, grid and paper come from the page."""
    return {"xaxis": xaxis, "yaxis": yaxis} | more


def wants_log(values: Iterable[object], span: float = LOG_SPAN) -> bool:
    """Tell whether positive values spread so wide that only a logarithmic axis shows them all.

    >>> wants_log([1, 2, 5]), wants_log([1e-7, 1e-5]), wants_log([0.0, 1.0])
    (False, True, False)
    """
    known = np.array([float(v) for v in values if fmt.finite(v)])  # type: ignore[arg-type]
    return bool(len(known) and known.min() > 0 and known.max() / known.min() > span)
