"""The style of printed figures: column widths, fonts, colours on white.

The files contain no dates and no random names, so that identical results give identical bytes.
"""

from __future__ import annotations

from base64 import b64encode
from contextlib import AbstractContextManager
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from comparisons.errors import InputError
from comparisons.facts.quantities import quantity
from reports.plots.style import INK, MUTED, PEER, TRUTH

try:
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
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


class PaperFigure(Figure):
    """A matplotlib figure saved to journal requirements and displayed in notebooks."""

    def savefig(self, fname: Any, **options: Any) -> None:
        """Save in roughline's style, without dates; the suffix determines the format."""
        kind = options.get("format") or Path(fname).suffix.lstrip(".")
        with house_style():
            options.setdefault("metadata", _METADATA.get(kind))
            super().savefig(fname, **options)

    def _repr_html_(self) -> str:
        stream = BytesIO()
        self.savefig(stream, format="png", dpi=150)
        data = b64encode(stream.getvalue()).decode("ascii")
        width = round(self.get_figwidth() * 110)
        style = f"width:{width}px;max-width:100%;background:#fff"
        return f'<img alt="plot of results" style="{style}" src="data:image/png;base64,{data}">'


def house_style() -> AbstractContextManager[None]:
    """Return a context in which figures are created and drawn in roughline's style."""
    return mpl.rc_context(_RC)


def new_figure(width: float = COLUMN, height: float = HEIGHT) -> PaperFigure:
    """Return an empty figure of the given size in millimetres."""
    figure = PaperFigure(figsize=(width * _MILLIMETRE, height * _MILLIMETRE))
    FigureCanvasAgg(figure)
    return figure


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
