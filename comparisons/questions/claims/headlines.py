"""Headlines and order of the built-in claims, without importing any solver."""

from __future__ import annotations

import math
import re
import tomllib
from dataclasses import dataclass
from pathlib import Path

# Positions of the chapter's sections and figures among its equations.
_PLACES = {
    "19.1.2": 1.5,
    "19.2 ": 8.5,
    "19.3, (5": 17.5,
    "beside 19.3": 17.6,
    "19.4, second": 19.4,
    "beside 19.4": 19.4,
    "Fig. 19.6": 19.5,
    "Fig. 19.8": 29.5,
    "19.5": 31.5,
    "19.7": 37.5,
    "19.8": 38.0,
    "Problem 1": 39.0,
}


@dataclass(frozen=True)
class Headline:
    """Name, source, reading and statement of a claim."""

    id: str
    equation: str
    reading: str
    text: str


def builtin_claims() -> dict[str, Path]:
    """Return the files of the built-in claims by name."""
    return {path.stem: path for path in sorted(Path(__file__).parent.glob("*.toml"))}


def headlines() -> list[Headline]:
    """Return the headlines of the built-in claims in the chapter's order."""
    tables = [tomllib.loads(path.read_text("utf-8")) for path in builtin_claims().values()]
    keys = ("id", "equation", "reading", "text")
    rows = [Headline(*(table.get(key, "") for key in keys)) for table in tables]
    return sorted(rows, key=lambda headline: chapter_order(headline.equation, headline.id))


def chapter_order(equation: str, name: str) -> tuple[float, str]:
    """Return the sort key of claims in the chapter's order; claims from other sources come last.

    >>> equations = ["Fig. 19.6", "(19.10)", "19.3, (5.30)", "mine", "(19.9), (19.11)", "19.2 (a)"]
    >>> sorted(equations, key=lambda equation: chapter_order(equation, "a"))
    ['19.2 (a)', '(19.9), (19.11)', '(19.10)', '19.3, (5.30)', 'Fig. 19.6', 'mine']
    """
    number = re.search(r"\(19\.(\d+)", equation)
    if number:
        return float(number[1]), name
    places = (place for phrase, place in _PLACES.items() if phrase in equation)
    return next(places, math.inf), name
