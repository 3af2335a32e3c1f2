"""A figure as data: axes, curves, bands and markers, drawn by plotly or matplotlib.

All values are in SI units; each axis states its display unit. Texts are plain; each renderer
escapes them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from comparisons import formatting as fmt
from comparisons.facts.quantities import quantity
from reports.plots.style import INK, MUTED, SOLID, TRUTH, Dash, Look

NO_SCALE = fmt.Scale(1.0, "")


@dataclass(frozen=True)
class Axis:
    """One axis."""

    # Words, symbol, and the quantity that they refer to: the page names it above the plot and uses
    # the symbol; print names it on the axis.
    title: str = ""
    symbol: str = ""
    of: str = ""
    quantity: str = ""  # the column that provides words and symbol in place of these
    scale: fmt.Scale = NO_SCALE  # display unit, and factor from SI units
    log: bool = False
    # In SI units; ticks are (value, text). If empty, the renderer's own.
    limits: tuple[float, float] | None = None
    ticks: tuple[tuple[float, str], ...] = ()

    @property
    def label(self) -> str:
        """The title as plain text, with symbol and unit."""
        if self.quantity:
            return quantity(self.quantity).title(self.scale.unit)
        name = f"{self.title} {self.symbol}".strip()
        return f"{name} / {self.scale.unit}" if self.scale.unit else name


@dataclass(frozen=True)
class Series:
    """A series of points; NaN is a gap."""

    look: Look  # its label is the legend entry
    x: np.ndarray
    y: np.ndarray
    line: bool = True
    marks: bool = True
    hollow: bool | np.ndarray = False  # which markers are drawn as outlines
    bars: np.ndarray | None = None  # half-widths of the error bars along y
    # A line above the coordinates, or the full text for each point; if None, no hover text.
    hover: str | tuple[str, ...] | None = None
    group: str = ""  # series of one group are hidden together on the page
    # Whether it is in the legend; print leaves out series that only the caption explains.
    legend: bool = True
    # Of the markers (0: that of the look) and of the line, in pixels of the page.
    size: float = 0.0
    width: float = 2.0
    stairs: bool = False  # join points by steps; each value holds until the next
    outlined: bool = False  # outline markers in the colour of the text
    faint: float = 1.0  # opacity of the markers
    digits: int = 6  # number of significant digits on the page
    # Markers are arrows on the page, each pointing away from the point before it.
    directed: bool = False


@dataclass(frozen=True)
class Band:
    """The area between two curves over x, or over y if `sideways`."""

    along: np.ndarray
    low: np.ndarray
    high: np.ndarray
    colour: str = TRUTH
    opacity: float = 0.3
    label: str = ""
    sideways: bool = False


@dataclass(frozen=True)
class Level:
    """A horizontal line with a label next to the plot."""

    value: float
    label: str = ""
    colour: str = INK
    dash: Dash = SOLID


@dataclass(frozen=True)
class Guide:
    """A vertical dotted line with a label above the plot."""

    value: float
    text: str = ""
    colour: str = MUTED


@dataclass(frozen=True)
class Stretch:
    """An interval of the horizontal axis, shaded over the full height."""

    low: float
    high: float
    colour: str
    label: str


@dataclass(frozen=True)
class Map:
    """Values on a grid, first index along x; NaN is a gap, `highest` ends the colour scale.

    With `contacts`, values from 0.9 on are contacts, whole ones at 1, on heights in grey. If
    `signed`, colours run from `-highest` to `highest`.
    """

    x: np.ndarray
    y: np.ndarray
    values: np.ndarray
    symbol: str = ""
    scale: fmt.Scale = NO_SCALE
    highest: float = 0.0
    contacts: bool = False
    signed: bool = False


@dataclass(frozen=True)
class Figure:
    """One plot; what lies in it is drawn from the bands on, the later on top."""

    key: str
    title: str
    caption: str
    x: Axis = field(repr=False)
    y: Axis = field(repr=False)
    series: tuple[Series, ...] = field(default=(), repr=False)
    bands: tuple[Band, ...] = field(default=(), repr=False)
    levels: tuple[Level, ...] = field(default=(), repr=False)
    guides: tuple[Guide, ...] = field(default=(), repr=False)
    stretches: tuple[Stretch, ...] = field(default=(), repr=False)
    map: Map | None = field(default=None, repr=False)
    legend: bool = True
    # The columns shown, separated by spaces, for the page's menu of quantities. If empty, the
    # figure is always shown.
    quantity: str = ""
    # The same plot at the earlier loads, for the page's slider; only the values differ.
    earlier: tuple[Figure, ...] = field(default=(), repr=False)

    @property
    def names(self) -> int:
        """How many names stand in the legend."""
        return len({s.look.label for s in self.series if s.legend} - {""}) if self.legend else 0

    @property
    def clipped(self) -> bool:
        """Whether markers are clipped at the frame; logarithmic axes contain all points."""
        return not (self.x.log or self.y.log)


def line(look: Look, x: np.ndarray, y: np.ndarray, width: float = 2.0) -> Series:
    """Return a curve without markers, named on hover."""
    return Series(look, x, y, marks=False, hover=look.label, width=width)


def moving(figures: Sequence[Figure]) -> Figure:
    """Return the figure of the last load with the earlier ones attached."""
    return replace(figures[-1], earlier=tuple(figures[:-1]))


MOST_PIXELS = 80


def map_figure(
    key: str,
    title: str,
    caption: str,
    frames: Sequence[Map],
    quantity: str,
    axes: tuple[Axis, Axis] = (Axis("x"), Axis("y")),
) -> Figure:
    """Return the map of the last load with those of the earlier ones; lengths have one unit."""
    last = frames[-1]
    scale = fmt.prefix_for(np.concatenate([last.x, last.y]), "m")
    x, y = (
        Axis(axis.title, axis.symbol, scale=scale, limits=outer(centres))
        for axis, centres in zip(axes, (last.x, last.y), strict=True)
    )
    return moving([Figure(key, title, caption, x, y, map=m, quantity=quantity) for m in frames])


def outer(centres: np.ndarray) -> tuple[float, float]:
    """Return the range between the outer edges of the first and last pixels."""
    half = (centres[-1] - centres[0]) / max(len(centres) - 1, 1) / 2
    return float(centres[0] - half), float(centres[-1] + half)


def coarsened(
    x: np.ndarray, y: np.ndarray, values: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Reduce a map to `MOST_PIXELS` a side at most, each with the largest value, of any sign."""
    step = int(np.ceil(max(values.shape) / MOST_PIXELS))
    if step == 1:
        return x, y, values
    padded = np.pad(values, [(0, -side % step) for side in values.shape])
    blocks = padded.reshape(padded.shape[0] // step, step, padded.shape[1] // step, step)
    x, y = (
        np.array([axis[i : i + step].mean() for i in range(0, len(axis), step)]) for axis in (x, y)
    )
    highest, lowest = blocks.max(axis=(1, 3)), blocks.min(axis=(1, 3))
    return x, y, np.where(highest >= -lowest, highest, lowest)
