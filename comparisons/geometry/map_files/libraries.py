"""Files that optional libraries read: formats of instruments, TIFF images, HDF5.

Instruments by SurfaceTopography and images by tifffile (extra ``topography``). HDF5, as which the
Contact Mechanics Challenge publishes its surfaces, by h5py (extra ``challenge``; ``topography``
brings it, too): only the crop is read, as 65536 x 65536 points in double precision are 34 GB.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from comparisons.geometry.map_files.heights import (
    UNITS_PER_METRE,
    HeightFile,
    memory_problems,
    shape_problems,
    stated_problems,
)
from comparisons.geometry.reading import FileError, quiet, shorten
from comparisons.scene.surface import MeasuredMap

# Instruments also store signals as maps; some are even scaled to a length.
_NOT_HEIGHT = re.compile(
    r"phase|amplitude|deflection|error|current|voltage|potential|friction|adhesion|modulus"
    r"|stiffness|dissipation|indentation|intensity|image|input|frequency|mask|quality",
    re.IGNORECASE,
)


def open_instrument(path: Path, surface: MeasuredMap) -> HeightFile:
    """Read a file in any format of SurfaceTopography."""
    try:
        import SurfaceTopography
    except ImportError as error:
        raise FileError(
            f"format {path.suffix or 'without a suffix'} needs the optional package "
            "SurfaceTopography: pip install roughline[topography]; without it, "
            ".npy, .csv, .txt and .xyz are read"
        ) from error
    with quiet():
        try:
            reader = SurfaceTopography.open_topography(str(path))
        except SurfaceTopography.Exceptions.CannotDetectFileFormat as error:
            raise FileError(_unknown_format(path, error)) from error
        except Exception as error:  # the many readers raise various types of exceptions
            raise FileError(f"cannot be read ({shorten(error)})") from error
    # the channel
    channels = list(reader.channels)
    listing = ", ".join(f"{info.index} {info.name!r}" for info in channels)
    maps = [  # of heights, by declared type, unit and name
        i
        for i, info in enumerate(channels)
        if info.dim == 2
        and getattr(getattr(info, "data_kind", None), "name", "HEIGHT") == "HEIGHT"
        and (info.unit is None or isinstance(info.unit, str))
        and not _NOT_HEIGHT.search(info.name or "")
    ]
    if surface.channel is None:
        default = reader.default_channel.index
        candidates = [default] if default in maps else maps
        problem = f"none of its channels holds heights ({listing})"
    else:
        candidates = [
            i for i, info in enumerate(channels) if surface.channel in (info.name, str(i))
        ]
        problem = f"has no channel {surface.channel!r}, only {listing}"
        if candidates and candidates[0] not in maps:
            problem = (
                f"channel {surface.channel!r} does not hold heights; choose another of {listing}"
            )
            candidates = []
    if not candidates:
        raise FileError(problem)
    index = candidates[0]
    note = f"heights of {path.name}"
    if len(channels) > 1:
        note = f"channel {index} {channels[index].name!r} of {path.name} (channels: {listing})"
    info = reader.channels[index]
    problems = shape_problems(tuple(info.nb_grid_pts))
    problems += memory_problems(int(np.prod(info.nb_grid_pts, dtype=object)))
    problems += _metadata_problems(info, surface)
    # The reader labels all lengths with one unit; without it, heights and sides may have different
    # units.
    unit = info.unit or surface.height_unit
    size = surface.size
    if info.physical_sizes is not None:
        lateral = UNITS_PER_METRE.get(info.unit or surface.lateral_unit or "")
        sides = tuple(info.physical_sizes)
        size = None
        if lateral is not None and len(sides) == 2:
            size = float(sides[0]) / lateral, float(sides[1]) / lateral
    if problems or unit not in UNITS_PER_METRE or size is None:
        raise FileError(*problems)
    missing: dict[str, Any] = {} if info.unit else {"unit": unit}
    if info.physical_sizes is None:
        missing["physical_sizes"] = tuple(side * UNITS_PER_METRE[unit] for side in size)
    with quiet():
        try:
            heights = reader.topography(channel_index=index, **missing).heights()
        except Exception as error:  # the many readers raise various types of exceptions
            raise FileError(f"the heights cannot be read ({shorten(error)})") from error
    values = np.ma.asarray(heights, np.float64).filled(np.nan)
    return HeightFile(values, size, unit, note)


def _unknown_format(path: Path, error: Exception) -> str:
    """Return a message with the formats tried and the failure of the suffix's format."""
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


def _metadata_problems(info: Any, stated: MeasuredMap) -> list[str]:
    """Return the problems with size and units: missing, or stated twice."""
    problems = []
    if info.unit is not None and info.unit not in UNITS_PER_METRE:
        problems.append(f"its unit {info.unit!r} is not a supported unit of length")
    if info.unit is None and stated.height_unit is None:
        problems.append("the file states no unit: give height_unit")
    problems += [
        f"the file states its own unit ({info.unit}): leave out {key}"
        for key in ("height_unit", "lateral_unit")
        if info.unit is not None and getattr(stated, key) is not None
    ]
    file_size = " x ".join(f"{float(side):.6g}" for side in info.physical_sizes or ())
    if file_size and info.unit is None and stated.lateral_unit is None:
        problems.append(f"the file states a size ({file_size}) without a unit: give lateral_unit")
    if file_size and stated.size is not None:
        problems.append(
            f"the file states its own size ({file_size} {info.unit or ''}): leave out size"
        )
    if not file_size and stated.size is None:
        problems.append("the file states no size: give size")
    if not file_size and stated.lateral_unit is not None:
        problems.append("lateral_unit was given, but the file has no lengths along x and y")
    return problems


# Park Systems stores heights in private tags beside a picture; this tag marks its files.
_PARK_SYSTEMS = 50432


def is_plain_tiff(path: Path) -> bool:
    """Return whether a file is a TIFF image, but not of an instrument format."""
    with path.open("rb") as file:
        magic = file.read(2)
    if path.suffix.lower() not in (".tif", ".tiff") or magic not in (b"II", b"MM"):
        return False
    with quiet(), _image(path) as image:
        return not len(image.pages) or _PARK_SYSTEMS not in image.pages[0].tags


def open_tiff(path: Path, surface: MeasuredMap) -> HeightFile:
    """Read one page of a TIFF: x to the right, y upwards, pixels in `height_unit`."""
    with quiet(), _image(path) as image:
        pages = len(image.pages)
        if pages == 0:
            raise FileError("not a readable TIFF image (it has no page)")
        listing = f"pages 0 to {pages - 1}"
        if surface.channel is None and pages > 1:
            raise FileError(f"the image has {listing}: choose one as channel")
        number = surface.channel or "0"
        if number not in map(str, range(pages)):
            raise FileError(f"has no page {number!r}, only {listing}")
        page = image.pages[int(number)]
        kind = np.dtype(page.dtype or "V")
        if page.samplesperpixel != 1 or page.photometric == 3 or page.colormap is not None:
            problems = [
                "a picture in colours, no map: export the heights themselves, as 32-bit TIFF"
            ]
        elif kind.kind not in "iuf" or kind.itemsize < 2:
            problems = [
                f"pixels of {8 * kind.itemsize} bits ({kind}) are a picture, no map: export the "
                "heights themselves, as 32-bit TIFF"
            ]
        else:
            points = int(np.prod(page.shape, dtype=object))
            problems = shape_problems(page.shape) or memory_problems(points)
        problems += stated_problems(surface, "a TIFF image")
        if problems:
            raise FileError(*problems)
        try:
            pixels = np.asarray(page.asarray())
        except Exception as error:  # decoders raise various types of exceptions
            raise FileError(f"the pixels cannot be read ({shorten(error)})") from error
    assert surface.size is not None
    assert surface.height_unit is not None
    whole = pixels.dtype.kind != "f"
    taken = f", whole numbers ({pixels.dtype}) taken as heights" if whole else ""
    position = f"page {number} of " if pages > 1 else ""
    note = (
        f"heights in {surface.height_unit} read from {position}{path.name}{taken}, x to the right, "
        "y upwards"
    )
    # The first line of an image is at the top.
    return HeightFile(np.flip(pixels.T, axis=1), surface.size, surface.height_unit, note)


def _image(path: Path) -> Any:
    try:
        import tifffile
    except ImportError as error:
        needed = "TIFF needs the optional package tifffile: pip install roughline[topography]"
        raise FileError(needed) from error
    try:
        return tifffile.TiffFile(path)
    except (tifffile.TiffFileError, OSError, ValueError, LookupError) as error:
        raise FileError(f"not a readable TIFF image ({shorten(error)})") from error


def open_hdf5(path: Path, surface: MeasuredMap) -> HeightFile:
    """Open the only map of an HDF5 file, or the one that `channel` names; first index along x.

    Only what is in this very file counts: no links to others, no heights kept in others.
    """
    try:
        import h5py
    except ImportError:
        needed = "HDF5 needs the optional package h5py: pip install roughline[challenge]"
        raise FileError(needed) from None
    problems = stated_problems(surface, "a dataset of an HDF5 file")
    if problems:
        raise FileError(*problems)
    assert surface.size is not None
    assert surface.height_unit is not None
    maps: dict[str, Any] = {}

    def note_map(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset) and item.ndim == 2:
            maps[name] = item

    try:
        h5py.File(path, "r").visititems(note_map)  # each item once, also in circles
    except (OSError, RuntimeError) as error:
        raise FileError(f"not a readable HDF5 file ({shorten(error)})") from error
    name = surface.channel if surface.channel is not None or len(maps) != 1 else next(iter(maps))
    if name not in maps:
        wanted = "one map" if name is None else f"the map {name!r}"
        listed = ", ".join(map(repr, maps)) or "none"
        raise FileError(f"expected {wanted}, the two-dimensional datasets are {listed}")
    if maps[name].is_virtual or maps[name].external:
        raise FileError("its heights are in other files: copy them into one")
    note = f"heights in {surface.height_unit} read from {path.name}: {name}, first index along x"
    return HeightFile(maps[name], surface.size, surface.height_unit, note, holes_marked=False)
