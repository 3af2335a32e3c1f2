"""Cell types shared by the tables."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from comparisons import formatting as fmt
from reports.plots.style import look
from reports.tables.table import Cell

if TYPE_CHECKING:
    from comparisons.results.record import SceneRecord

NOTHING = Cell(fmt.MISSING, float("nan"), "number")


def method(name: str, label: str = "", scene: SceneRecord | None = None) -> Cell:
    """Return the name of a method, as it is called on the scene, with its colour."""
    text = label or look(name, scene).label
    return Cell(text, text, "method", name)


def number(text: str, key: float) -> Cell:
    """Return a number with its printed text and its sort key."""
    return Cell(text, key, "number")


def count(value: float) -> Cell:
    """Return a whole number."""
    return number(fmt.count(value), value)


def duration(seconds: float) -> Cell:
    """Return a time."""
    return number(fmt.duration(seconds), seconds)


def relative(value: float) -> Cell:
    """Return a share, or the size of an error."""
    return number(fmt.relative(value), value)


def signed_error(value: float) -> Cell:
    """Return a relative error with its sign, without its bar."""
    return number(fmt.signed_error(value), value)


def error(value: float, bar: float, text: str = "") -> Cell:
    """Return a relative error with its bar; `text` is how a verdict prints it."""
    return Cell(text or fmt.plus_minus(value, bar), float(value), "number", bar=float(bar))


def verdict(*badges: str, text: str = "") -> Cell:
    """Return verdict words; `text` is a longer text to print in their place."""
    return Cell(text or ", ".join(badges), badges[0] if badges else "", "text", badges=badges)


def change(before: float, after: float, written: Callable[[float], str] = fmt.relative) -> Cell:
    """Return a number before and after, if both are known."""
    if not (fmt.finite(before) and fmt.finite(after)):
        return NOTHING
    return Cell(f"{written(before)} \N{RIGHTWARDS ARROW} {written(after)}", after)
