"""Opening of height maps: tables, coordinate lists, TIFF, HDF5 and instrument formats.

Before a file is read, its unpacked size and the memory of its points are checked.
"""

from __future__ import annotations

from pathlib import Path

from comparisons.geometry.map_files.checks import UNITS_PER_METRE, MapError, MapFile, Stated, Window
from comparisons.geometry.map_files.hdf5 import SUFFIXES, open_hdf5
from comparisons.geometry.map_files.instruments import open_instrument
from comparisons.geometry.map_files.tables import PLAIN_FORMATS, open_plain
from comparisons.geometry.map_files.tiff import is_plain_tiff, open_tiff
from comparisons.geometry.map_files.xyz import is_xyz, open_xyz
from comparisons.geometry.unpacking import size_problems

__all__ = [
    "PLAIN_FORMATS",
    "UNITS_PER_METRE",
    "MapError",
    "MapFile",
    "Stated",
    "Window",
    "open_map",
]

# Bytes below which a file is always read.
REMEDY = "save the heights as .npy, of which only the crop is read"


def open_map(path: Path, stated: Stated) -> MapFile:
    """Open a map of any known format.

    Raises
    ------
    MapError
        Lists all problems of the file that are known without reading the heights.
    """
    if path.stat().st_size == 0:
        raise MapError(str(path), ["the file is empty"])
    if path.suffix.lower() in PLAIN_FORMATS:
        return open_plain(path, stated)
    if path.suffix.lower() in SUFFIXES:
        return open_hdf5(path, stated)
    problems = size_problems(path, REMEDY)
    if problems:
        raise MapError(str(path), problems)
    if is_xyz(path):
        return open_xyz(path, stated)
    if is_plain_tiff(path):
        return open_tiff(path, stated)
    return open_instrument(path, stated)
