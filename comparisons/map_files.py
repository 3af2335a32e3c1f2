"""Opens files of measured heights: plain tables here, instrument formats by SurfaceTopography."""

from __future__ import annotations

import contextlib
import io
import re
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import psutil
from numpy.typing import NDArray

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
PLAIN_FORMATS = (".npy", ".csv", ".txt")

# Instruments store signals in the shape of maps; some are even scaled to a length.
_NOT_HEIGHT = re.compile(
    r"phase|amplitude|deflection|error|current|voltage|potential|friction|adhesion|modulus"
    r"|stiffness|dissipation|indentation|intensity|image|input|frequency|mask|quality",
    re.IGNORECASE,
)
# What the treatment of a map holds at its peak: heights, a copy, the fitted trend, the mask.
_ARRAYS_IN_MEMORY = 4


class MapError(ValueError):
    """A measured map cannot be used as asked.

    Attributes
    ----------
    source : str
        The file.
    problems : tuple of str
        Everything that is wrong, one sentence each.
    """

    def __init__(self, source: str, problems: list[str]) -> None:
        super().__init__(f"{source}: " + "; ".join(problems))
        self.source = source
        self.problems = tuple(problems)

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.source, list(self.problems))


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
        Whether the format itself marks undefined points (instruments); in plain tables a NaN may
        as well be a mistake.
    notes : tuple of str
        What was chosen, in sentences for the report.
    """

    shape: tuple[int, int]
    size: Size
    read: Callable[[Window], NDArray[np.float64]]
    holes_marked: bool
    notes: tuple[str, ...]


def open_map(
    path: Path,
    *,
    size: Size | None,
    height_unit: str | None,
    channel: str | int | None,
    window: Window | None,
) -> MapFile:
    """Open a map of any known format.

    Raises
    ------
    MapError
        With every problem of the file that can be seen without reading the heights.
    """
    if path.stat().st_size == 0:
        raise MapError(str(path), ["the file is empty"])
    if path.suffix.lower() in PLAIN_FORMATS:
        return _open_plain(path, size=size, height_unit=height_unit, window=window)
    return _open_instrument(path, size=size, height_unit=height_unit, channel=channel)


def _shorten(error: BaseException, length: int = 200) -> str:
    """Return an error's message on one line; readers put whole files into theirs."""
    text = " ".join(str(error)[: 10 * length].split())
    return text if len(text) <= length else text[:length] + " ..."


def _shape_problems(shape: tuple[int, ...]) -> list[str]:
    if len(shape) != 2:
        return [f"a map has two dimensions, this array has shape {tuple(shape)}"]
    if min(shape) < 2:
        return [f"a map has at least 2 x 2 points, this one {shape[0]} x {shape[1]}"]
    return []


def _memory_problems(points: int) -> list[str]:
    """Refuse what would not fit into 80 % of the free memory, before it is read."""
    need = 8 * _ARRAYS_IN_MEMORY * points
    free = 0.8 * psutil.virtual_memory().available
    if need <= free:
        return []
    return [
        f"{points} points need {need / 1e9:.3g} GB of memory, 80 % of the free memory are "
        f"{free / 1e9:.3g} GB: use a smaller map or, from .npy, a crop"
    ]


# --- plain tables: .npy, .csv, .txt ---------------------------------------------------------


def _open_plain(
    path: Path, *, size: Size | None, height_unit: str | None, window: Window | None
) -> MapFile:
    if size is None or height_unit is None:
        raise MapError(str(path), ["a plain table needs size and height_unit"])
    opener = _open_npy if path.suffix.lower() == ".npy" else _open_text
    array = opener(path, window)
    problems = _shape_problems(array.shape)
    if problems:
        raise MapError(str(path), problems)
    per_metre = UNITS_PER_METRE[height_unit]

    def read(window: Window) -> NDArray[np.float64]:
        x0, y0, nx, ny = window
        return np.array(array[x0 : x0 + nx, y0 : y0 + ny], np.float64, order="C") / per_metre

    note = f"heights in {height_unit} read from {path.name}, first index along x"
    return MapFile(array.shape, size, read, holes_marked=False, notes=(note,))


def _open_npy(path: Path, window: Window | None) -> NDArray[Any]:
    """Map the file into memory after a look at its header: only the crop is ever read."""
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
        raise MapError(source, [f"not a readable .npy file ({_shorten(error)})"]) from error
    problems = _shape_problems(shape)
    if dtype.kind not in "iuf":
        problems.append(f"heights are real numbers, this array holds {dtype}")
    if not problems:
        problems = _memory_problems(window[2] * window[3] if window else shape[0] * shape[1])
    if problems:
        raise MapError(source, problems)
    try:
        return np.load(path, mmap_mode="r", allow_pickle=False)
    except (OSError, ValueError) as error:
        raise MapError(source, [f"not a readable .npy file ({_shorten(error)})"]) from error


def _open_text(path: Path, window: Window | None) -> NDArray[np.float64]:
    """Read numbers separated by comma, semicolon, tab or blanks; # starts a comment."""
    del window  # text has to be parsed from its beginning
    source = str(path)
    try:
        first = _first_data_line(path)
        if not first.strip():
            raise MapError(source, ["the file holds no numbers"])
        delimiter = next((mark for mark in ",;\t" if mark in first), None)
        values = len(first.split(delimiter))
        problems = _memory_problems(values * path.stat().st_size // len(first))
        if problems:
            raise MapError(source, problems)
        return np.loadtxt(path, delimiter=delimiter, ndmin=2, encoding="utf-8-sig")
    except MapError:
        raise
    except (OSError, ValueError) as error:
        tried = "numbers separated by comma, semicolon, tab or blanks, # for comments"
        problem = f"not a plain table ({tried}): {_shorten(error)}"
        raise MapError(source, [problem]) from error


def _first_data_line(path: Path) -> str:
    with path.open(encoding="utf-8-sig") as file:
        return next((line for line in file if line.split("#", 1)[0].strip()), "")


# --- instrument formats ---------------------------------------------------------------------


def _open_instrument(
    path: Path, *, size: Size | None, height_unit: str | None, channel: str | int | None
) -> MapFile:
    reader = _reader(path)
    index, notes = _choose_channel(path, reader, channel)
    info = reader.channels[index]
    problems = _shape_problems(tuple(info.nb_grid_pts))
    problems += _memory_problems(int(np.prod(info.nb_grid_pts)))
    problems += _metadata_problems(info, size, height_unit)
    if problems:
        raise MapError(str(path), problems)
    unit = info.unit or height_unit
    per_metre = UNITS_PER_METRE[unit]
    missing: dict[str, Any] = {} if info.unit else {"unit": unit}
    if info.physical_sizes is None:
        missing["physical_sizes"] = tuple(side * per_metre for side in size)
    else:
        size = tuple(float(side) / per_metre for side in info.physical_sizes)

    def read(window: Window) -> NDArray[np.float64]:
        x0, y0, nx, ny = window
        with _quiet():
            try:
                heights = reader.topography(channel_index=index, **missing).heights()
            except Exception as error:  # each of the many readers raises its own kinds
                problem = f"the heights cannot be read ({_shorten(error)})"
                raise MapError(str(path), [problem]) from error
        part = np.ma.asarray(heights[x0 : x0 + nx, y0 : y0 + ny], np.float64)
        return np.ascontiguousarray(part.filled(np.nan)) / per_metre

    return MapFile(tuple(info.nb_grid_pts), size, read, holes_marked=True, notes=notes)


def _reader(path: Path) -> Any:
    try:
        import SurfaceTopography
    except ImportError as error:
        problem = (
            f"format {path.suffix or 'without a suffix'} needs the optional package "
            "SurfaceTopography: pip install roughline[topography]; without it, "
            f"{', '.join(PLAIN_FORMATS)} are read"
        )
        raise MapError(str(path), [problem]) from error
    with _quiet():
        try:
            return SurfaceTopography.open_topography(str(path))
        except SurfaceTopography.Exceptions.CannotDetectFileFormat as error:
            raise MapError(str(path), [_unknown_format(path, error)]) from error
        except Exception as error:  # each of the many readers raises its own kinds
            raise MapError(str(path), [f"cannot be read ({_shorten(error)})"]) from error


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Silence readers that warn about, or print, parts of a file they do not understand."""
    sink = io.StringIO()
    with (
        warnings.catch_warnings(),
        contextlib.redirect_stdout(sink),
        contextlib.redirect_stderr(sink),
    ):
        warnings.simplefilter("ignore")
        yield


def _unknown_format(path: Path, error: Exception) -> str:
    """Say which formats were tried, and why the one that the suffix promises failed."""
    import SurfaceTopography

    readers = SurfaceTopography.IO.readers
    suffix = path.suffix.lower().lstrip(".")
    reasons = dict(re.findall(r"tried (\w+):\s*(\S[^\n]*)", str(error)))
    likely = [
        f" (as {reader.format()}: {reasons[reader.__name__]})"
        for reader in readers
        if reader.__name__ in reasons
        and suffix in (reader.format(), *(reader.file_extensions() or ()))
    ]
    return (
        f"unknown or damaged{''.join(likely)}: tried the {len(readers)} formats of "
        f"SurfaceTopography {SurfaceTopography.__version__}, "
        + ", ".join(reader.format() for reader in readers)
    )


def _is_height(info: Any) -> bool:
    """Whether a channel holds heights: by its declared kind, its unit and its name."""
    kind = getattr(getattr(info, "data_kind", None), "name", "HEIGHT")
    return (
        info.dim == 2
        and kind == "HEIGHT"
        and (info.unit is None or isinstance(info.unit, str))
        and not _NOT_HEIGHT.search(info.name or "")
    )


def _choose_channel(
    path: Path, reader: Any, wanted: str | int | None
) -> tuple[int, tuple[str, ...]]:
    """Return the index of the channel to read, and what was chosen in words."""
    channels = list(reader.channels)
    listing = ", ".join(f"{info.index} {info.name!r}" for info in channels)
    heights = [i for i, info in enumerate(channels) if _is_height(info)]
    if wanted is None:
        default = reader.default_channel.index
        found = [default] if default in heights else heights
        problem = f"none of its channels holds heights ({listing})"
    else:
        found = [i for i, info in enumerate(channels) if wanted in (info.name, i, str(i))]
        problem = f"has no channel {wanted!r}, only {listing}"
        if found and found[0] not in heights:
            problem = f"channel {wanted!r} does not hold heights; choose another of {listing}"
            found = []
    if not found:
        raise MapError(str(path), [problem])
    note = f"channel {found[0]} {channels[found[0]].name!r} of {path.name} (channels: {listing})"
    return found[0], (note if len(channels) > 1 else f"heights of {path.name}",)


def _metadata_problems(info: Any, size: Size | None, height_unit: str | None) -> list[str]:
    """Say which of size and unit are missing, and which the file has fixed already."""
    problems = []
    if info.unit is not None and info.unit not in UNITS_PER_METRE:
        problems.append(f"its unit {info.unit!r} is not a length that is known here")
    if info.unit is None and height_unit is None:
        problems.append("the file states no unit: give height_unit")
    if info.unit is not None and height_unit is not None:
        problems.append(f"the file states its own unit ({info.unit}): leave out height_unit")
    if info.physical_sizes is None and size is None:
        problems.append("the file states no size: give size")
    if info.physical_sizes is not None and size is not None:
        own = " x ".join(f"{float(side):.6g}" for side in info.physical_sizes)
        problems.append(f"the file states its own size ({own} {info.unit or ''}): leave out size")
    return problems
