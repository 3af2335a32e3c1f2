"""A measured curve of force over penetration: a table whose first line names columns and units.

Decimal commas, semicolons and tabs are read as in tables of heights; further columns are ignored.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from comparisons.geometry.map_files.numbers_in_text import NumberLayout, layout_of
from comparisons.geometry.reading import FileError
from comparisons.scene.units import FORCE, LENGTH, to_si

DIMENSIONS = {"penetration": LENGTH, "force": FORCE}
HEADS = "penetration / nm, force / µN"
LARGEST_FILE = 5_000_000  # bytes
FEWEST, MOST = 3, 20_000  # points


@dataclass(frozen=True)
class MeasuredCurve:
    """Penetration depths and forces in SI units, in the order of the file."""

    penetration: np.ndarray
    force: np.ndarray


def read_curve(path: Path) -> MeasuredCurve:
    """Read a measured curve.

    Raises
    ------
    FileError
        If columns, units or numbers are not those of a curve.
    """
    try:
        if path.stat().st_size > LARGEST_FILE:
            raise FileError(f"expected a file of at most {LARGEST_FILE / 1e6:g} MB")
        layout = layout_of(path)
        lines = [text for line in layout.lines(path) if (text := line.split("#", 1)[0].strip())]
    except FileError:
        raise
    except (OSError, ValueError) as error:
        raise FileError(str(error)) from error
    heads = re.split(r"[;\t,]", lines[0]) if lines else []
    columns, problems = _columns(heads)
    if problems:
        raise FileError(*problems)
    values = np.array([_row(layout, line, columns) for line in lines[1:]]).reshape(-1, 2)
    scales = [scale for _, scale in columns.values()]
    problems = _problems(values)
    if problems:
        raise FileError(*problems)
    return MeasuredCurve(*(values * scales).T)


def _columns(heads: list[str]) -> tuple[dict[str, tuple[int, float]], list[str]]:
    """Return position and SI factor of both columns, and the problems of the first line."""
    columns, problems = {}, []
    for name, dimension in DIMENSIONS.items():
        places = [k for k, head in enumerate(heads) if head.strip().lower().startswith(name)]
        if len(places) != 1:
            problems.append(
                f"first line: expected one column {name}, got {len(places)}, as in {HEADS!r}"
            )
            continue
        unit = heads[places[0]].strip()[len(name) :].strip(" /[]()")
        try:
            columns[name] = places[0], to_si(f"1 {unit}" if unit else 1.0, dimension)
        except ValueError as error:
            problems.append(f"column {name}: {error}")
    return columns, problems


def _row(layout: NumberLayout, line: str, columns: dict[str, tuple[int, float]]) -> list[float]:
    fields = line.split(layout.delimiter)
    try:
        return [float(fields[place]) for place, _ in columns.values()]
    except (ValueError, IndexError):
        raise FileError(f"expected numbers below the first line, got {line[:60]!r}") from None


def _problems(values: np.ndarray) -> list[str]:
    if not FEWEST <= len(values) <= MOST:
        return [f"expected {FEWEST} to {MOST} points, got {len(values)}"]
    if not np.isfinite(values).all():
        return ["expected finite numbers only"]
    return [] if values[:, 1].max() > 0 else ["expected some positive (compressive) forces"]
