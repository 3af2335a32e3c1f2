"""TIFF images whose pixels are heights, except for instrument formats based on TIFF."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from comparisons.geometry.map_files.heights import (
    HeightFile,
    memory_problems,
    shape_problems,
    stated_problems,
)
from comparisons.geometry.reading import FileError, quiet, shorten
from comparisons.scene.surface import MeasuredMap

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
