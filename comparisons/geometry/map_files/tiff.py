"""TIFF images whose pixels are heights, except for instrument formats based on TIFF."""

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
    memory_problems,
    shape_problems,
    shorten,
    windows_of,
)
from comparisons.geometry.silence import quiet

SUFFIXES = (".tif", ".tiff")
# Park Systems stores heights in private tags beside a picture; this tag marks its files.
_PARK_SYSTEMS = 50432


def is_plain_tiff(path: Path) -> bool:
    """Return whether a file is a TIFF image, but not of an instrument format."""
    with path.open("rb") as file:
        magic = file.read(4)
    if path.suffix.lower() not in SUFFIXES or magic[:2] not in (b"II", b"MM"):
        return False
    with quiet(), _opened(path) as image:
        return not len(image.pages) or _PARK_SYSTEMS not in image.pages[0].tags


def open_tiff(path: Path, stated: Stated) -> MapFile:
    """Open one page of a TIFF: x to the right, y upwards, pixels in `height_unit`.

    Raises
    ------
    MapError
        If size or unit is missing, or the page is a picture instead of a map.
    """
    with quiet(), _opened(path) as image:
        pages = len(image.pages)
        number = _page_number(path, pages, stated.channel)
        page = image.pages[number]
        problems = _page_problems(page)
        if stated.size is None:
            problems.append("size is needed: a TIFF image does not state its side lengths")
        if stated.height_unit is None:
            problems.append("height_unit is needed: a TIFF image does not state its unit")
        if stated.lateral_unit is not None:
            problems.append("lateral_unit was given, but size states the lengths of a TIFF image")
        if problems:
            raise MapError(str(path), problems)
        pixels = _pixels(path, page)
    assert stated.size is not None
    assert stated.height_unit is not None
    # The first line of an image is at the top.
    heights = np.flip(pixels.T, axis=1)
    kind = "" if pixels.dtype.kind == "f" else f", whole numbers ({pixels.dtype}) taken as heights"
    position = f"page {number} of " if pages > 1 else ""
    note = (
        f"heights in {stated.height_unit} read from {position}{path.name}{kind}, x to the right, "
        "y upwards"
    )
    read = windows_of(heights, UNITS_PER_METRE[stated.height_unit])
    return MapFile(heights.shape, stated.size, read, holes_marked=True, notes=(note,))


def _opened(path: Path) -> Any:
    try:
        import tifffile
    except ImportError as error:
        problem = "TIFF needs the optional package tifffile: pip install roughline[topography]"
        raise MapError(str(path), [problem]) from error
    try:
        return tifffile.TiffFile(path)
    except (tifffile.TiffFileError, OSError, ValueError, LookupError) as error:
        raise MapError(str(path), [f"not a readable TIFF image ({shorten(error)})"]) from error


def _page_number(path: Path, pages: int, page: str | None) -> int:
    if pages == 0:
        raise MapError(str(path), ["not a readable TIFF image (it has no page)"])
    listing = f"pages 0 to {pages - 1}"
    if page is None and pages == 1:
        return 0
    if page is None:
        raise MapError(str(path), [f"the image has {listing}: choose one as channel"])
    if str(page) not in map(str, range(pages)):
        raise MapError(str(path), [f"has no page {page!r}, only {listing}"])
    return int(page)


def _page_problems(page: Any) -> list[str]:
    kind = np.dtype(page.dtype or "V")
    if page.samplesperpixel != 1 or page.photometric == 3 or page.colormap is not None:
        return ["a picture in colours, no map: export the heights themselves, as 32-bit TIFF"]
    if kind.kind not in "iuf" or kind.itemsize < 2:
        return [
            f"pixels of {8 * kind.itemsize} bits ({kind}) are a picture, no map: export the "
            "heights themselves, as 32-bit TIFF"
        ]
    return shape_problems(page.shape) or memory_problems(int(np.prod(page.shape, dtype=object)))


def _pixels(path: Path, page: Any) -> NDArray[Any]:
    try:
        return np.asarray(page.asarray())
    except Exception as error:  # decoders raise various types of exceptions
        raise MapError(str(path), [f"the pixels cannot be read ({shorten(error)})"]) from error
