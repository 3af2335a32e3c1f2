"""Heights of a map in metres, from any format.

A reader `open_...(path, surface)` returns a `HeightFile`, or raises a FileError that lists all that
is wrong; the checks of its points, and the cut to the crop, are here, once for all formats.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from comparisons.geometry.reading import FileError, read_apart
from comparisons.machine import MEMORY_SHARE, free_memory
from comparisons.scene.surface import MeasuredMap

PLAIN_FORMATS = (".npy", ".csv", ".txt")
HDF5_FORMATS = (".h5", ".hdf5")
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


@dataclass(frozen=True)
class HeightFile:
    """The heights of an opened file."""

    # (nx, ny), heights in the unit of the file, first index along x; undefined points are NaN.
    # Slices are read only when taken, where the format allows it.
    values: Any
    size: tuple[float, float]  # side lengths of the whole file in metres
    unit: str  # unit of the values
    note: str  # choices made on reading, as a sentence for the report
    # Whether the format marks undefined points (instruments); in plain tables a NaN may be a
    # mistake.
    holes_marked: bool = True


@dataclass(frozen=True)
class Heights:
    """The heights of a crop in metres, as read or as treated, and what is known of its file."""

    # (nx, ny), first index along x. As read NaN where undefined; treated positive towards the
    # half-space (peaks touch first), C-contiguous and read-only.
    heights: NDArray[np.float64]
    size: tuple[float, float]  # side lengths of the crop
    cell: tuple[float, float]  # those of the cell of a point
    treatment: tuple[str, ...]  # processing steps in order
    holes_marked: bool


def read_heights(path: Path, surface: MeasuredMap) -> Heights:
    """Read the crop of a map of any known format, or the whole map.

    Tables and lists of numbers are read here, all other formats in a process of limited memory.
    """
    from comparisons.geometry.map_files.text import is_xyz

    if path.stat().st_size == 0:
        raise FileError("the file is empty")
    suffix = path.suffix.lower()
    if suffix in PLAIN_FORMATS or (suffix not in HDF5_FORMATS and is_xyz(path)):
        return Heights(**cut(path, surface))
    remedy = "save the heights as .npy, of which only the crop is read"
    answer = read_apart(f"{__name__}:cut", path, surface, remedy=remedy)
    pairs = {name: tuple(answer[name]) for name in ("size", "cell", "treatment")}
    return Heights(**answer | pairs)


def cut(path: Path, surface: MeasuredMap) -> dict[str, Any]:
    """Open a file, check its points and return the crop: the fields of `Heights`."""
    # Optional libraries are imported in the process that reads.
    from comparisons.geometry.map_files import libraries, text

    suffix = path.suffix.lower()
    if suffix in PLAIN_FORMATS:
        file = text.open_plain(path, surface)
    elif suffix in HDF5_FORMATS:
        file = libraries.open_hdf5(path, surface)
    elif text.is_xyz(path):
        file = text.open_xyz(path, surface)
    elif libraries.is_plain_tiff(path):
        file = libraries.open_tiff(path, surface)
    else:
        file = libraries.open_instrument(path, surface)
    shape = tuple(int(points) for points in file.values.shape)
    problems = shape_problems(shape)
    if file.values.dtype.kind not in "iuf":
        problems.append(f"heights are real numbers, this file holds {file.values.dtype}")
    if problems:
        raise FileError(*problems)
    x0, y0, nx, ny = surface.crop or (0, 0, *shape)
    if x0 + nx > shape[0] or y0 + ny > shape[1]:
        assert surface.crop is not None
        raise FileError(
            f"crop {list(surface.crop)} reaches beyond the {shape[0]} x {shape[1]} points"
        )
    # Of packed HDF5, whole chunks are unpacked.
    chunk = getattr(file.values, "chunks", None) or (0,)
    problems = memory_problems(nx * ny + int(np.prod(chunk)))
    if problems:
        raise FileError(*problems)
    heights = np.array(file.values[x0 : x0 + nx, y0 : y0 + ny], np.float64, order="C")
    heights /= UNITS_PER_METRE[file.unit]
    return {
        "heights": heights,
        "size": (file.size[0] * (nx / shape[0]), file.size[1] * (ny / shape[1])),
        "cell": (file.size[0] / shape[0], file.size[1] / shape[1]),
        "treatment": (file.note,),
        "holes_marked": file.holes_marked,
    }


def stated_problems(surface: MeasuredMap, what: str) -> list[str]:
    """Return the problems of size and units for a file that holds heights alone."""
    problems = []
    if surface.size is None:
        problems.append(f"size is needed: {what} does not state its side lengths")
    if surface.height_unit is None:
        problems.append(f"height_unit is needed: {what} does not state its unit")
    if surface.lateral_unit is not None:
        problems.append(f"lateral_unit was given, but size states the lengths of {what}")
    return problems


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
