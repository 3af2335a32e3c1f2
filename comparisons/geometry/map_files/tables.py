"""Plain tables of heights: .npy, .csv, .txt."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from comparisons.geometry.map_files.checks import (
    UNITS_PER_METRE,
    MapError,
    MapFile,
    Stated,
    Window,
    memory_problems,
    shape_problems,
    shorten,
    windows_of,
)
from comparisons.geometry.map_files.numbers_in_text import NumberLayout, layout_of
from comparisons.geometry.map_files.xyz import holds_grid

PLAIN_FORMATS = (".npy", ".csv", ".txt")
TRIED = (
    "numbers separated by comma, semicolon, tab or blanks, with a decimal point or, where another "
    "mark separates them, a decimal comma; # for comments"
)


def open_plain(path: Path, stated: Stated) -> MapFile:
    """Open a plain table, whose first index runs along x.

    Raises
    ------
    MapError
        If size or unit is missing, or the file is not a table of numbers.
    """
    if stated.size is None or stated.height_unit is None:
        raise MapError(str(path), ["a plain table needs size and height_unit"])
    if path.suffix.lower() == ".npy":
        array, written = _open_npy(path, stated.window), ""
    else:
        layout = _layout(path)
        array = _read_text(path, layout)
        written = ", with decimal commas" if layout.decimal_comma else ""
    problems = shape_problems(array.shape) or _coordinate_problems(array)
    if problems:
        raise MapError(str(path), problems)
    unit = stated.height_unit
    note = f"heights in {unit} read from {path.name}{written}, first index along x"
    read = windows_of(array, UNITS_PER_METRE[unit])
    return MapFile(array.shape, stated.size, read, holes_marked=False, notes=(note,))


def _coordinate_problems(array: NDArray[Any]) -> list[str]:
    if array.shape[1] != 3 or array.shape[0] < 6 or not holds_grid(array[:, 0], array[:, 1]):
        return []
    return ["three columns that are x, y and z of a grid: give the file the suffix .xyz"]


def _open_npy(path: Path, window: Window | None) -> NDArray[Any]:
    """Map a .npy file into memory after checking its header; only the crop is read."""
    source = str(path)
    try:
        with path.open("rb") as file:
            version = np.lib.format.read_magic(file)
            header = {
                (1, 0): np.lib.format.read_array_header_1_0,
                (2, 0): np.lib.format.read_array_header_2_0,
            }.get(version, np.lib.format.read_array_header_2_0)
            shape, _, dtype = header(file)
    except (OSError, ValueError) as error:
        raise MapError(source, [f"not a readable .npy file ({shorten(error)})"]) from error
    problems = shape_problems(shape)
    if dtype.kind not in "iuf":
        problems.append(f"heights are real numbers, this array holds {dtype}")
    if not problems:
        problems = memory_problems(window[2] * window[3] if window else shape[0] * shape[1])
    if problems:
        raise MapError(source, problems)
    try:
        return np.load(path, mmap_mode="r", allow_pickle=False)
    except (OSError, ValueError) as error:
        raise MapError(source, [f"not a readable .npy file ({shorten(error)})"]) from error


def _layout(path: Path) -> NumberLayout:
    try:
        layout = layout_of(path)
    except (OSError, UnicodeError) as error:
        raise MapError(str(path), [f"not a plain table ({TRIED}): {shorten(error)}"]) from error
    if not layout.first:
        raise MapError(str(path), ["the file holds no numbers"])
    return layout


def _read_text(path: Path, layout: NumberLayout) -> NDArray[np.float64]:
    """Read a table of numbers; # starts a comment."""
    values = len(layout.fields(layout.first))
    problems = memory_problems(values * path.stat().st_size // len(layout.first))
    if problems:
        raise MapError(str(path), problems)
    try:
        lines = layout.lines(path) if layout.decimal_comma else path
        return np.loadtxt(lines, delimiter=layout.delimiter, ndmin=2, encoding=layout.encoding)
    except (OSError, ValueError) as error:
        raise MapError(str(path), [f"not a plain table ({TRIED}): {shorten(error)}"]) from error
