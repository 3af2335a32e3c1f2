"""A figure as data: axes, curves, bands and marks, which plotly and matplotlib draw.

All values are those of the results, in SI units; an axis says in which unit it shows them. Texts
are plain: each renderer makes them harmless in its own way.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from comparisons import formatting as fmt
from comparisons.facts.quantities import quantity
from reports.plots.style import INK, MUTED, SOLID, TRUTH, Dash, Look

NO_SCALE = fmt.Scale(1.0, "")


@dataclass(frozen=True)
class Axis:
    """One axis.

    Attributes
    ----------
    title : str
        Its words; those of a quantity come from `quantity`.
    symbol, of : str
        The title's symbol, and what it speaks of: the page says so above the plot and takes the
        symbol, print has to say it beside the axis.
    quantity : str
        The column whose words and symbol are the title.
    scale : comparisons.formatting.Scale
        The unit that it shows, and the factor from SI units.
    log : bool
    limits : tuple of float, optional
        Its ends, in SI units.
    ticks : tuple of (value, text)
        In SI units; none: the renderer's own.
    """

    title: str = ""
    symbol: str = ""
    of: str = ""
    quantity: str = ""
    scale: fmt.Scale = NO_SCALE
    log: bool = False
    limits: tuple[float, float] | None = None
    ticks: tuple[tuple[float, str], ...] = ()

    @property
    def label(self) -> str:
        """The title as plain text, with symbol and unit."""
        if self.quantity:
            return quantity(self.quantity).title(self.scale.unit)
        words = f"{self.title} {self.symbol}".strip()
        return f"{words} / {self.scale.unit}" if self.scale.unit else words


@dataclass(frozen=True)
class Series:
    """Points that belong together.

    Attributes
    ----------
    look : Look
        Its label is the name in the legend.
    x, y : numpy.ndarray
        NaN is a gap.
    line, marks : bool
        Whether points are joined, and marked.
    hollow : bool or numpy.ndarray
        Which markers are only an outline.
    bars : numpy.ndarray, optional
        Half-widths of error bars upwards.
    hover : str or tuple of str, optional
        A line above the coordinates, or the whole text of each point; none: silent.
    group : str
        Series of one group are hidden together on the page.
    legend : bool
        Whether the legend names it; print leaves out what only a caption explains.
    size, width : float
        Of the markers (0: the look's own) and of the line, in pixels of the page.
    stairs : bool
        Joined by steps: a value holds until the next.
    outlined : bool
        Markers have a rim in the colour of the text.
    faint : float
        Opacity of the markers.
    digits : int
        How many significant digits the page keeps.
    """

    look: Look
    x: np.ndarray
    y: np.ndarray
    line: bool = True
    marks: bool = True
    hollow: bool | np.ndarray = False
    bars: np.ndarray | None = None
    hover: str | tuple[str, ...] | None = None
    group: str = ""
    legend: bool = True
    size: float = 0.0
    width: float = 2.0
    stairs: bool = False
    outlined: bool = False
    faint: float = 1.0
    digits: int = 6


@dataclass(frozen=True)
class Band:
    """What lies between two curves over x; `sideways`: between two curves over y."""

    along: np.ndarray
    low: np.ndarray
    high: np.ndarray
    colour: str = TRUTH
    opacity: float = 0.3
    label: str = ""
    sideways: bool = False


@dataclass(frozen=True)
class Level:
    """A horizontal line; its label stands beside the plot."""

    value: float
    label: str = ""
    colour: str = INK
    dash: Dash = SOLID


@dataclass(frozen=True)
class Guide:
    """An upright dotted line with a text above the plot."""

    value: float
    text: str = ""
    colour: str = MUTED


@dataclass(frozen=True)
class Stretch:
    """A part of the axis to the right, shaded over the whole height."""

    low: float
    high: float
    colour: str
    label: str


@dataclass(frozen=True)
class Map:
    """Values on a grid, the first index along x; NaN is a gap, and `highest` ends the colours."""

    x: np.ndarray
    y: np.ndarray
    values: np.ndarray
    symbol: str = ""
    scale: fmt.Scale = NO_SCALE
    highest: float = 0.0


@dataclass(frozen=True)
class Figure:
    """One plot.

    Attributes
    ----------
    key, title, caption : str
    x, y : Axis
    bands, series, levels, guides, stretches
        What is drawn, the later on top.
    map : Map, optional
    legend : bool
        Whether there is one.
    quantity : str
        The columns that it shows, separated by spaces: what the page's choice of a quantity
        keeps. Always shown where empty.
    earlier : tuple of Figure
        The same plot at the loads before, for the page's slider: alike but for values.
    """

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
    quantity: str = ""
    earlier: tuple[Figure, ...] = field(default=(), repr=False)

    @property
    def moves(self) -> bool:
        """Whether a load slider moves the plot."""
        return bool(self.earlier)

    @property
    def clipped(self) -> bool:
        """Whether markers end at the frame: limits of logarithmic axes hold every point."""
        return not (self.x.log or self.y.log)
