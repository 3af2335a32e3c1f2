"""Heights in a dataset of an HDF5 file, as the Contact Mechanics Challenge publishes its surfaces.

Read by h5py (optional extra ``challenge``; ``topography`` brings it, too). Only the crop is read:
65536 x 65536 points in double precision are 34 GB.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from comparisons.geometry.map_files.heights import HeightFile, stated_problems
from comparisons.geometry.reading import FileError, shorten
from comparisons.scene.surface import MeasuredMap


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
