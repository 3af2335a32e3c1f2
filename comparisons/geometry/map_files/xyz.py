"""Coordinate lists x, y, z of a regular grid, one point per line."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from comparisons.geometry.map_files.checks import (
    UNITS_PER_METRE,
    MapError,
    MapFile,
    Stated,
    memory_problems,
    shape_problems,
    shorten,
    windows_of,
)
from comparisons.geometry.map_files.numbers_in_text import NumberLayout, layout_of

SUFFIX = ".xyz"
# Bytes at the end of a file from which a list with three numbers per line is recognised.
_TAIL = 4096
# Fractions of a step: coordinates closer than the first are equal up to rounding; those farther
# from a regular grid than the second are not on it.
_SAME, _OFF_GRID = 0.01, 0.1
# If the file contains a smaller fraction of a grid, its points count as scattered.
_LEAST_SHARE = 0.5
# Arrays of all points at the peak of reading: three columns, their order, two indices.
_ARRAYS = 8
_UNIT_LINES = {
    "lateral_unit": re.compile(r"#\s*Lateral units?:\s*(\S+)", re.IGNORECASE),
    "height_unit": re.compile(r"#\s*Value units?:\s*(\S+)", re.IGNORECASE),
}


def is_xyz(path: Path) -> bool:
    """Return whether a file is a list of x, y, z, by its suffix or by the last line of a text.

    The last line is used because the first may be a header.
    """
    if path.suffix.lower() == SUFFIX:
        return True
    with path.open("rb") as file:
        file.seek(max(0, path.stat().st_size - _TAIL))
        # In text with two bytes per character, every other byte is zero.
        lines = file.read().replace(b"\0", b"").split(b"\n")
    last = next((line for line in reversed(lines) if line.strip()), b"")
    if len(last) > 200:
        return False
    fields = re.split(rb"[\s,;]+", last.strip())
    return len(fields) == 3 and all(re.fullmatch(rb"[-+.\deE]+", field) for field in fields)


def open_xyz(path: Path, stated: Stated) -> MapFile:
    """Open a list of x, y, z.

    Units that the file does not state (``# Lateral units: µm``, ``# Value units: nm``, as Gwyddion
    writes them) must be given, separately for x, y and for z: profilers commonly export micrometres
    beside nanometres. Grid points missing from the list are undefined.

    Raises
    ------
    MapError
        If units are missing or the points are not on a regular grid.
    """
    try:
        layout = layout_of(path)
        file_units = _own_units(path, layout)
    except (OSError, UnicodeError) as error:
        raise MapError(str(path), [f"not a list of x, y, z ({shorten(error)})"]) from error
    problems, units = _unit_problems(file_units, stated)
    if stated.channel is not None:
        problems.append(f"channel {stated.channel!r} was given, but a list of x, y, z has none")
    lines = path.stat().st_size // max(1, len(layout.first))
    problems += memory_problems(_ARRAYS * lines // 4)
    if problems:
        raise MapError(str(path), problems)
    x, y, z = _columns(path, layout)
    heights, cells = _on_grid(path, x, y, z)
    lateral, vertical = (units[key] for key in _UNIT_LINES)
    sides = [
        n * cell / UNITS_PER_METRE[lateral] for n, cell in zip(heights.shape, cells, strict=True)
    ]
    written = ", with decimal commas" if layout.decimal_comma else ""
    note = f"x, y in {lateral} and heights in {vertical} read from {path.name}{written}"
    return MapFile(
        heights.shape,
        (sides[0], sides[1]),
        windows_of(heights, UNITS_PER_METRE[vertical]),
        holes_marked=True,
        notes=(note,),
    )


def _own_units(path: Path, layout: NumberLayout) -> dict[str, str]:
    """Return the units stated in comments before the first number."""
    units = {}
    with path.open(encoding=layout.encoding) as file:
        for line, _ in zip(file, range(layout.header), strict=False):
            for key, pattern in _UNIT_LINES.items():
                if match := pattern.match(line):
                    units[key] = match[1]
    return units


def _unit_problems(file_units: dict[str, str], stated: Stated) -> tuple[list[str], dict[str, str]]:
    problems, units = [], dict(file_units)
    for key, coordinates in (("lateral_unit", "x and y"), ("height_unit", "z")):
        unit = getattr(stated, key)
        if key not in file_units and unit is None:
            problems.append(f'the file states no unit of {coordinates}: give {key}, such as "um"')
        elif key in file_units and unit is not None:
            problems.append(
                f"the file states the unit of {coordinates} ({file_units[key]}): leave out {key}"
            )
        elif key in file_units and file_units[key] not in UNITS_PER_METRE:
            problems.append(
                f"its unit of {coordinates}, {file_units[key]!r}, is not a length that is known "
                "here"
            )
        units.setdefault(key, unit)
    if stated.size is not None:
        problems.append("the coordinates in the file state its size: leave out size")
    return problems, units


def _columns(path: Path, layout: NumberLayout) -> NDArray[np.float64]:
    try:
        table = np.loadtxt(
            layout.lines(path), delimiter=layout.delimiter, skiprows=layout.header, ndmin=2
        )
    except (OSError, ValueError) as error:
        problem = f"not a list of x, y, z ({shorten(error)})"
        raise MapError(str(path), [problem]) from error
    if table.shape[1] != 3 or not np.isfinite(table[:, :2]).all():
        problem = f"expected lines of three numbers x, y, z, got {table.shape[1]} a line"
        if table.shape[1] == 3:
            problem = "expected finite x and y, got NaN or infinity"
        raise MapError(str(path), [problem])
    return table.T


def _on_grid(
    path: Path, x: NDArray[np.float64], y: NDArray[np.float64], z: NDArray[np.float64]
) -> tuple[NDArray[np.float64], tuple[float, float]]:
    """Return the heights (nx, ny), NaN for missing points, and the sides of a cell."""
    (across, column, even_x), (along, row, even_y) = _spaced(x), _spaced(y)
    problems = [
        f"{name} is not equally spaced: a map is a regular grid of points"
        for name, even in (("x", even_x), ("y", even_y))
        if not even
    ]
    if problems:
        raise MapError(str(path), problems)
    shape = int(column.max()) + 1, int(row.max()) + 1
    problems = shape_problems(shape)
    if shape[0] * shape[1] * _LEAST_SHARE > len(z):
        problems.append(f"{len(z)} points on a grid of {shape[0]} x {shape[1]}: scattered points")
    if problems:
        raise MapError(str(path), problems)
    place = column * shape[1] + row
    twice = int(len(place) - len(np.unique(place)))
    if twice:
        raise MapError(str(path), [f"{twice} points have the x and y of another point"])
    heights = np.full(shape[0] * shape[1], np.nan)
    heights[place] = z
    return heights.reshape(shape), (across, along)


def _spaced(values: NDArray[np.float64]) -> tuple[float, NDArray[np.int64], bool]:
    """Return the mean step of values, their grid positions, and whether the steps are equal."""
    levels = np.unique(values)
    if len(levels) < 2:
        return 0.0, np.zeros(len(values), np.int64), True
    gaps = np.diff(levels)
    distinct = int((gaps > _SAME * gaps.max()).sum()) + 1
    step = float((levels[-1] - levels[0]) / (distinct - 1))
    place = (values - levels[0]) / step
    index = np.rint(place).astype(np.int64)
    return step, index, bool(np.abs(place - index).max() <= _OFF_GRID)


def holds_grid(x: NDArray[np.float64], y: NDArray[np.float64]) -> bool:
    """Return whether numbers are the coordinates of a complete regular grid, each point once."""
    if not (np.isfinite(x).all() and np.isfinite(y).all()):
        return False
    columns, rows = len(np.unique(x)), len(np.unique(y))
    if min(columns, rows) < 2 or columns * rows != len(x):
        return False
    return len(np.unique(np.stack([x, y]), axis=1).T) == len(x)
