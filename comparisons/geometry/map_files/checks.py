"""Common parts of all map formats: the opened file, units, checks before reading."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from comparisons.machine import MEMORY_SHARE, free_memory

Window = tuple[int, int, int, int]
Size = tuple[float, float]

# Units per metre, so that heights are divided by an exact number and rounded once.
UNITS_PER_METRE = {
    "m": 1.0,
    "cm": 1e2,
    "mm": 1e3,
    "um": 1e6,
    "µm": 1e6,  # micro sign
    "\u03bcm": 1e6,  # Greek letter
    "nm": 1e9,
    "Å": 1e10,  # letter A with ring
    "\u212b": 1e10,  # angstrom sign
    "A": 1e10,
    "pm": 1e12,
}
# Arrays held at the peak of processing: heights, a copy, the fitted trend, the mask.
_ARRAYS_IN_MEMORY = 4


class MapError(ValueError):
    """A measured map cannot be used as asked.

    Attributes
    ----------
    source : str
        The file.
    problems : tuple of str
        All problems, one sentence per problem.
    """

    def __init__(self, source: str, problems: list[str]) -> None:
        super().__init__(f"{source}: " + "; ".join(problems))
        self.source = source
        self.problems = tuple(problems)

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.source, list(self.problems))


@dataclass(frozen=True)
class Stated:
    """Properties of a file that the scene states because the file does not.

    Attributes
    ----------
    size : tuple of float, optional
        Side lengths of the whole file in metres.
    height_unit, lateral_unit : str, optional
        Units of heights and of lengths along x and y if the file does not state them.
    channel : str, optional
        Channel of an instrument file, or page of a TIFF.
    window : tuple of int, optional
        The crop (x0, y0, nx, ny), to read no more than necessary.
    """

    size: Size | None = None
    height_unit: str | None = None
    lateral_unit: str | None = None
    channel: str | None = None
    window: Window | None = None


@dataclass(frozen=True)
class MapFile:
    """An opened map, checked but not yet read.

    Attributes
    ----------
    shape : tuple of int
        Points along x and y of the whole file.
    size : tuple of float
        Side lengths of the whole file in metres.
    read : callable
        Heights of a window (x0, y0, nx, ny) in metres; undefined points are NaN.
    holes_marked : bool
        Whether the format marks undefined points (instruments); in plain tables a NaN may be a
        mistake.
    notes : tuple of str
        Choices made on reading, as sentences for the report.
    """

    shape: tuple[int, int]
    size: Size
    read: Callable[[Window], NDArray[np.float64]]
    holes_marked: bool
    notes: tuple[str, ...]


def windows_of(
    heights: NDArray[Any], units_per_metre: float
) -> Callable[[Window], NDArray[np.float64]]:
    """Return the `read` function of a map in memory or mapped into memory."""

    def read(window: Window) -> NDArray[np.float64]:
        x0, y0, nx, ny = window
        part = np.array(heights[x0 : x0 + nx, y0 : y0 + ny], np.float64, order="C")
        return part / units_per_metre

    return read


def shorten(error: BaseException, length: int = 200) -> str:
    """Return the message of an error on one line; readers may quote whole files in it."""
    text = " ".join(str(error)[: 10 * length].split())
    return text if len(text) <= length else text[:length] + " ..."


def shape_problems(shape: tuple[int, ...]) -> list[str]:
    """Return the problems of an array that is not two-dimensional with at least 2 x 2 points."""
    if len(shape) != 2:
        return [f"a map has two dimensions, this array has shape {tuple(shape)}"]
    if min(shape) < 2:
        return [f"a map has at least 2 x 2 points, this one {shape[0]} x {shape[1]}"]
    return []


def memory_problems(points: int) -> list[str]:
    """Return the problem of a map that needs more than 80 % of the free memory."""
    need = 8 * _ARRAYS_IN_MEMORY * points
    free = MEMORY_SHARE * free_memory()
    if need <= free:
        return []
    return [
        f"{points} points need {need / 1e9:.3g} GB of memory, 80 % of the free memory are "
        f"{free / 1e9:.3g} GB: use a smaller map or, from .npy or .h5, a crop"
    ]
