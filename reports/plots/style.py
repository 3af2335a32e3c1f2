"""The look of each method in plots and tables: colour, marker, dash.

Colours that depend on light or dark mode are tokens ("@ink"), resolved by the page's script and by
the printed figures.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from comparisons.facts.methods import CLOSED_FORM, METHODS, MODEL, references, title_of
from comparisons.formatting import count

if TYPE_CHECKING:
    from comparisons.results.record import SceneRecord

# Okabe & Ito, "Color Universal Design" (2008): told apart with any kind of colour vision.
ORANGE, SKY, GREEN, BLUE, VERMILION = "#E69F00", "#56B4E9", "#009E73", "#0072B2", "#D55E00"
PURPLE = "#CC79A7"
INK, MUTED, PEER, TRUTH, CONTACT = "@ink", "@muted", "@peer", "@truth", ORANGE


@dataclass(frozen=True)
class Marker:
    """The names of a marker in both renderers."""

    plotly: str
    matplotlib: str | int


@dataclass(frozen=True)
class Dash:
    """A dash pattern for both renderers; matplotlib measures it in line widths."""

    plotly: str
    matplotlib: Any


SOLID, DASHED = Dash("solid", "-"), Dash("dash", (0, (4, 1.5)))
DOTTED = Dash("dot", (0, (1, 1.2)))
CIRCLE, CROSS = Marker("circle", "o"), Marker("x", "x")


@dataclass(frozen=True)
class Look:
    """Colour, marker and dash; marker sizes differ, so that coinciding points remain visible."""

    label: str
    colour: str
    marker: Marker = CIRCLE
    dash: Dash = SOLID
    size: float = 8.0

    def labelled(self, label: str) -> Look:
        """Return the same look under another name."""
        return replace(self, label=label)

    def at(self, resolution: float) -> str:
        """Return the name with a resolution."""
        return f"{self.label}, N = {count(resolution)}"


# Colour, marker and dash (each for plotly and matplotlib), size.
_LOOKS: dict[str, tuple[str, str, str | int, str, Any, float]] = {
    "closed_form": (INK, "star", "*", "solid", "-", 9),
    "reduced": (VERMILION, "circle", "o", "dash", (0, (4, 1.5)), 6),
    "bem_dense": (SKY, "square", "s", "dot", (0, (1, 1.2)), 10),
    "bem_fft": (BLUE, "diamond", "D", "dashdot", (0, (5, 1.5, 1, 1.5)), 9),
    "fem": (GREEN, "triangle-up", "^", "longdash", (0, (7, 2)), 12),
    "mca": (PURPLE, "hexagon2", "H", "4px,4px", (0, (4, 4)), 10),
    # Other people's codes are grey.
    "tamaas": (PEER, "pentagon", "p", "longdashdot", (0, (7, 1.5, 1, 1.5)), 11),
    "contactmechanics": (PEER, "hexagon", "h", "6px,3px", (0, (5, 2.5)), 8),
    "ngsolve": (PEER, "star-triangle-up", "P", "4px,2px", (0, (3, 1.5)), 9),
    # of rolling and of films, in plans of such scenes only
    "fastsim": ("#882255", "triangle-left", "<", "5px,2px", (0, (4, 2)), 9),
    "hamrock_dowson": ("#661100", "x", "x", "8px,2px", (0, (7, 1.5)), 9),
    "kalker": ("#999933", "triangle-right", ">", "2px,4px", (0, (1.5, 3)), 9),
    # of rough contact, and fits for balls that dent, where a scene names them
    "persson": ("#882255", "diamond-tall", "d", "5px,3px", (0, (4, 3)), 10),
    "persson_xu": ("#332288", "triangle-sw", 6, "3px,3px", (0, (3, 3)), 9),
    "greenwood_williamson": ("#999933", "star-square", "8", "2px,3px", (0, (1.5, 2)), 9),
    "bush_gibson_thomas": ("#AA4499", "star-diamond", "X", "8px,3px", (0, (6, 2.5)), 9),
    "kogut_etsion": ("#882255", "triangle-nw", 4, "6px,2px", (0, (5, 2)), 9),
    "jackson_green": ("#999933", "triangle-ne", 5, "3px,4px", (0, (2, 3)), 9),
    # contacts of other people's codes
    "lammps_hertz": (PEER, "diamond-wide", 7, "2px,2px", (0, (1, 2)), 9),
    "lammps_jkr": (PEER, "star-triangle-down", 10, "3px,2px", (0, (2, 1)), 9),
    "lammps_mdr": (PEER, "triangle-se", 11, "7px,3px", (0, (5, 1)), 9),
    "drake": (PEER, "hourglass", "$D$", "9px,2px", (0, (6, 1)), 10),
    "slippy": (PEER, "circle-cross", "$S$", "11px,2px", (0, (7, 1)), 10),
    "mujoco": (PEER, "octagon", "$M$", "1px,2px", (0, (1, 1)), 10),
}
LOOKS = {
    name: Look(METHODS[name].title, colour, Marker(sign, printed), Dash(dash, on_off), size)
    for name, (colour, sign, printed, dash, on_off, size) in _LOOKS.items()
}
# A user's methods are grey, too; in the order of their names, no two of twelve are alike.
OUTSIDE_MARKERS = (
    *(Marker("triangle-down", "v"), Marker("bowtie", "8")),
    *(Marker("x", "X"), Marker("cross", "d")),
)
OUTSIDE_DASHES = (
    *(Dash("10px,3px,3px,3px", (0, (7, 2, 2, 2))), Dash("2px,5px", (0, (1, 3)))),
    Dash("7px,2px,2px,2px,2px,2px", (0, (5, 1, 1, 1, 1, 1))),
)


def look(method: str, scene: SceneRecord | None = None, among: Iterable[str] = METHODS) -> Look:
    """Return the look of a method; a user's are grey, each with its own marker among the others.

    With a scene, under the name that the method has there, and among the scene's.
    """
    title = scene.title_of(method) if scene else title_of(method)
    if method in LOOKS:
        return LOOKS[method].labelled(title)
    place = sorted({method, *(scene.methods if scene else among)} - {*LOOKS}).index(method)
    marker = OUTSIDE_MARKERS[place % len(OUTSIDE_MARKERS)]
    dash = OUTSIDE_DASHES[place % len(OUTSIDE_DASHES)]
    return Look(title, PEER, marker, dash, 8)


def drawing_order(methods: Iterable[str]) -> list[str]:
    """Return methods in drawing order, later ones on top.

    First the closed form, then our references with the widest markers first, then external methods
    and finally the model under test.
    """
    names = list(methods)
    widest_first = sorted(references(), key=lambda name: -look(name).size)
    first = [name for name in (CLOSED_FORM, *widest_first) if name in names]
    last = [name for name in names if name == MODEL]
    return first + [name for name in names if name not in first + last] + last
