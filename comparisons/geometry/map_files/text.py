"""Files that need no other library: .npy, tables of heights, lists x, y, z of a regular grid.

The delimiter and the decimal sign of a text are found from its first lines (`layout_of`).
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from comparisons.geometry.map_files.heights import (
    UNITS_PER_METRE,
    HeightFile,
    memory_problems,
    shape_problems,
)
from comparisons.geometry.reading import FileError, shorten
from comparisons.scene.fields import FORCE, LENGTH, to_si
from comparisons.scene.surface import MeasuredMap

_TRIED = (
    "numbers separated by comma, semicolon, tab or blanks, with a decimal point or, where another "
    "mark separates them, a decimal comma; # for comments"
)
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


def open_plain(path: Path, surface: MeasuredMap) -> HeightFile:
    """Open heights alone, first index along x: a .npy file, or a table of numbers.

    Of the former only the crop is read later. Of a table lines are along x, # starts a comment.
    """
    assert surface.size is not None
    assert surface.height_unit is not None
    comma = ""
    if path.suffix.lower() == ".npy":
        try:
            heights = np.load(path, mmap_mode="r", allow_pickle=False)
        except Exception as error:  # damaged headers raise various types of exceptions
            raise FileError(f"not a readable .npy file ({shorten(error)})") from error
    else:
        try:
            layout = layout_of(path)
            if not layout.first:
                raise FileError("the file holds no numbers")
            values = len(layout.fields(layout.first))
            problems = memory_problems(values * path.stat().st_size // len(layout.first))
            if problems:
                raise FileError(*problems)
            lines = layout.lines(path) if layout.decimal_comma else path
            heights = np.loadtxt(
                lines, delimiter=layout.delimiter, ndmin=2, encoding=layout.encoding
            )
        except FileError:
            raise
        except (OSError, ValueError) as error:
            raise FileError(f"not a plain table ({_TRIED}): {shorten(error)}") from error
        comma = ", with decimal commas" if layout.decimal_comma else ""
    if _lists_a_grid(heights):
        raise FileError(
            "three columns that are x, y and z of a grid: give the file the suffix .xyz"
        )
    note = f"heights in {surface.height_unit} read from {path.name}{comma}, first index along x"
    return HeightFile(heights, surface.size, surface.height_unit, note, holes_marked=False)


def _lists_a_grid(array: NDArray[Any]) -> bool:
    """Whether three columns are a complete regular grid, each point once."""
    if array.ndim != 2 or array.shape[1] != 3 or len(array) < 6 or array.dtype.kind not in "iuf":
        return False
    places = np.asarray(array[:, :2])
    if not np.isfinite(places).all():
        return False
    columns, rows = (len(np.unique(coordinate)) for coordinate in places.T)
    complete = min(columns, rows) >= 2 and columns * rows == len(places)
    return complete and len(np.unique(places, axis=0)) == len(places)


def is_xyz(path: Path) -> bool:
    """Return whether a file is a list of x, y, z, by its suffix or by the last line of a text.

    The last line is used because the first may be a header.
    """
    if path.suffix.lower() == ".xyz":
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


def open_xyz(path: Path, surface: MeasuredMap) -> HeightFile:
    """Read a list of x, y, z.

    Units that the file does not state (``# Lateral units: µm``, ``# Value units: nm``, as Gwyddion
    writes them) must be given, separately for x, y and for z: profilers commonly export micrometres
    beside nanometres. Grid points missing from the list are undefined.
    """
    try:
        layout = layout_of(path)
        with path.open(encoding=layout.encoding) as file:
            comments = [line for line, _ in zip(file, range(layout.header), strict=False)]
    except FileError:
        raise
    except (OSError, UnicodeError) as error:
        raise FileError(f"not a list of x, y, z ({shorten(error)})") from error
    # units are stated in comments of the file or by the scene
    problems, units = [], {}
    for key, coordinates in (("lateral_unit", "x and y"), ("height_unit", "z")):
        in_file = [found[1] for line in comments if (found := _UNIT_LINES[key].match(line))]
        given = getattr(surface, key)
        if not in_file and given is None:
            problems.append(f'the file states no unit of {coordinates}: give {key}, such as "um"')
        elif in_file and given is not None:
            problems.append(
                f"the file states the unit of {coordinates} ({in_file[-1]}): leave out {key}"
            )
        elif in_file and in_file[-1] not in UNITS_PER_METRE:
            problems.append(
                f"its unit of {coordinates}, {in_file[-1]!r}, is not a length that is known here"
            )
        units[key] = in_file[-1] if in_file else given
    if surface.size is not None:
        problems.append("the coordinates in the file state its size: leave out size")
    if surface.channel is not None:
        problems.append(f"channel {surface.channel!r} was given, but a list of x, y, z has none")
    lines = path.stat().st_size // max(1, len(layout.first))
    problems += memory_problems(_ARRAYS * lines // 4)
    if problems:
        raise FileError(*problems)
    try:
        table = np.loadtxt(
            layout.lines(path), delimiter=layout.delimiter, skiprows=layout.header, ndmin=2
        )
    except (OSError, ValueError) as error:
        raise FileError(f"not a list of x, y, z ({shorten(error)})") from error
    if table.shape[1] != 3:
        raise FileError(f"expected lines of three numbers x, y, z, got {table.shape[1]} a line")
    if not np.isfinite(table[:, :2]).all():
        raise FileError("expected finite x and y, got NaN or infinity")
    heights, cells = _on_grid(*table.T)
    lateral, vertical = units["lateral_unit"], units["height_unit"]
    width, length = (
        n * cell / UNITS_PER_METRE[lateral] for n, cell in zip(heights.shape, cells, strict=True)
    )
    comma = ", with decimal commas" if layout.decimal_comma else ""
    note = f"x, y in {lateral} and heights in {vertical} read from {path.name}{comma}"
    return HeightFile(heights, (width, length), vertical, note)


def _on_grid(
    x: NDArray[np.float64], y: NDArray[np.float64], z: NDArray[np.float64]
) -> tuple[NDArray[np.float64], tuple[float, float]]:
    """Return the heights (nx, ny), NaN for missing points, and the sides of a cell."""
    (across, column, even_x), (along, row, even_y) = _spaced(x), _spaced(y)
    problems = [
        f"{name} is not equally spaced: a map is a regular grid of points"
        for name, even in (("x", even_x), ("y", even_y))
        if not even
    ]
    if problems:
        raise FileError(*problems)
    shape = int(column.max()) + 1, int(row.max()) + 1
    problems = shape_problems(shape)
    if shape[0] * shape[1] * _LEAST_SHARE > len(z):
        problems.append(f"{len(z)} points on a grid of {shape[0]} x {shape[1]}: scattered points")
    if problems:
        raise FileError(*problems)
    place = column * shape[1] + row
    twice = int(len(place) - len(np.unique(place)))
    if twice:
        raise FileError(f"{twice} points have the x and y of another point")
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


# Characters at the beginning of a text from which the number format is determined.
_SAMPLE = 65536
_COMMA_NUMBER = re.compile(
    r"[+-]?(?:\d+(?:,\d*)?|,\d+)(?:[eE][+-]?\d+)?|[+-]?(?:nan|inf)", re.IGNORECASE
)


@dataclass(frozen=True)
class NumberLayout:
    """Number format of a text."""

    encoding: str
    first: str  # the first line that is not a comment
    header: int  # number of lines before the first one with numbers only
    delimiter: str | None  # separator of the numbers; None for blanks
    decimal_comma: bool  # whether the decimal sign is a comma

    def fields(self, line: str) -> list[str]:
        """Split a line into numbers with decimal points."""
        return self._pointed(line.split("#", 1)[0].strip()).split(self.delimiter)

    def lines(self, path: Path) -> Iterator[str]:
        """Yield the lines of a text with decimal points."""
        with path.open(encoding=self.encoding) as file:
            yield from map(self._pointed, file)

    def _pointed(self, line: str) -> str:
        return line.replace(",", ".") if self.decimal_comma else line


def layout_of(path: Path) -> NumberLayout:
    """Return the number format of a text.

    Commas are decimal signs if another mark separates the numbers (semicolons, tabs, blanks) and
    all commas are within numbers.
    """
    with path.open("rb") as file:
        marked = file.read(2) in (b"\xff\xfe", b"\xfe\xff")
    encoding = "utf-16" if marked else "utf-8-sig"
    with path.open(encoding=encoding) as file:
        sample = file.read(_SAMPLE).splitlines()
    if len(sample) > 1 and len("\n".join(sample)) >= _SAMPLE - 2:
        sample.pop()  # cut off within the line
    data = [text for line in sample if (text := line.split("#", 1)[0].strip())]
    numeric = [line for line in data if line[0].isdigit() or line[0] in "+-.,;\t"]
    text = "\n".join(numeric or data[:1])
    delimiter: str | None
    for delimiter in (";", "\t", None):
        if delimiter is not None and delimiter not in text:
            continue
        decimal_comma = "," in text
        if not decimal_comma:
            break
        fields = [field.strip() for line in numeric for field in line.split(delimiter)]
        if all(_COMMA_NUMBER.fullmatch(field) for field in fields if field) and (
            delimiter or len(fields) > len(numeric)
        ):
            break
        if delimiter is not None and re.search(r"\d,\d", text) and re.search(r"\d\.\d", text):
            raise FileError(
                "numbers with both points and commas: one of them may be a decimal comma or "
                "a mark of thousands; write decimal points only"
            )
    else:
        delimiter, decimal_comma = ",", False
    layout = NumberLayout(encoding, data[0] if data else "", 0, delimiter, decimal_comma)
    header = next((i for i, line in enumerate(sample) if _all_numbers(layout.fields(line))), 0)
    return NumberLayout(encoding, layout.first, header, delimiter, decimal_comma)


def _all_numbers(fields: list[str]) -> bool:
    """Return whether a line has at least one field and all fields are numbers."""
    try:
        return bool([float(field) for field in fields])
    except ValueError:
        return False


DIMENSIONS = {"penetration": LENGTH, "force": FORCE}
HEADS = "penetration / nm, force / µN"
LARGEST_FILE = 5_000_000  # bytes
FEWEST, MOST = 3, 20_000  # points


def read_curve(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Return measured penetrations and forces in SI units, in the order of the file."""
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
    places, scales, problems = [], [], []
    for name, dimension in DIMENSIONS.items():
        found = [k for k, head in enumerate(heads) if head.strip().lower().startswith(name)]
        if len(found) != 1:
            problems.append(
                f"first line: expected one column {name}, got {len(found)}, as in {HEADS!r}"
            )
            continue
        unit = heads[found[0]].strip()[len(name) :].strip(" /[]()")
        try:
            scales.append(to_si(f"1 {unit}" if unit else 1.0, dimension))
        except ValueError as error:
            problems.append(f"column {name}: {error}")
        places += found
    if problems:
        raise FileError(*problems)
    rows = []
    for line in lines[1:]:
        fields = line.split(layout.delimiter)
        try:
            rows.append([float(fields[place]) for place in places])
        except (ValueError, IndexError):
            raise FileError(f"expected numbers below the first line, got {line[:60]!r}") from None
    values = np.array(rows).reshape(-1, 2)
    if not FEWEST <= len(values) <= MOST:
        raise FileError(f"expected {FEWEST} to {MOST} points, got {len(values)}")
    if not np.isfinite(values).all():
        raise FileError("expected finite numbers only")
    if not values[:, 1].max() > 0:
        raise FileError("expected some positive (compressive) forces")
    depth, force = (values * scales).T
    return depth, force
