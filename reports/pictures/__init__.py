"""Rendered pictures of bodies and surfaces; here what a page needs of them without drawing any."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

NOTHING = (
    "No picture: no method stored a pressure map, rough surface or stressed body that can be drawn."
)


@dataclass(frozen=True)
class ColourBar:
    """A colour bar, drawn by the page so that its text follows light and dark mode."""

    label: str
    low: str
    high: str
    palette: str  # "viridis" or "cividis"


@dataclass(frozen=True)
class Picture:
    """A picture, or the note that replaces it if `png` is empty.

    `view` is the same picture as an interactive plotly scene; it needs no renderer.
    """

    png: bytes = b""
    caption: str = ""
    bar: ColourBar | None = None
    note: str = ""
    view: dict[str, Any] | None = field(default=None, repr=False)
