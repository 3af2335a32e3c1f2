"""Heights in a dataset of an HDF5 file, as the Contact Mechanics Challenge publishes its surfaces.

Read by h5py (optional extra ``challenge``; ``topography`` brings it, too). Only the crop is read:
65536 x 65536 points in double precision are 34 GB.
"""

from __future__ import annotations

import math
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
)

SUFFIXES = (".h5", ".hdf5")


def open_hdf5(path: Path, stated: Stated) -> MapFile:
    """Open the only map of an HDF5 file, or the one that `channel` names; first index along x.

    Raises
    ------
    MapError
        If h5py, size or unit is missing, or the file has no such map of numbers.
    """
    try:
        import h5py
    except ImportError:
        problem = "HDF5 needs the optional package h5py: pip install roughline[challenge]"
        raise MapError(str(path), [problem]) from None
    if stated.size is None or stated.height_unit is None:
        raise MapError(str(path), ["a dataset of an HDF5 file needs size and height_unit"])
    try:
        with h5py.File(path, "r") as file:
            name = _chosen(path, file, h5py, stated.channel)
            problems = _problems(file[name], stated.window)
            shape = tuple(file[name].shape)
    except OSError as error:
        raise MapError(str(path), [f"not a readable HDF5 file ({shorten(error)})"]) from error
    if problems:
        raise MapError(str(path), problems)
    per_metre = UNITS_PER_METRE[stated.height_unit]

    def read(window: Window) -> NDArray[np.float64]:
        x0, y0, nx, ny = window
        try:
            with h5py.File(path, "r") as file:
                part = np.asarray(file[name][x0 : x0 + nx, y0 : y0 + ny], np.float64)
        except OSError as error:
            raise MapError(str(path), [f"not readable ({shorten(error)})"]) from error
        return part / per_metre

    note = f"heights in {stated.height_unit} read from {path.name}: {name}, first index along x"
    return MapFile(shape, stated.size, read, holes_marked=False, notes=(note,))


def _chosen(path: Path, file: Any, h5py: Any, channel: str | None) -> str:
    """Return the name of the map, with its groups; only what is in this very file counts."""
    names: list[str] = []

    def note_map(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset) and item.ndim == 2:
            names.append(name)

    file.visititems(note_map)  # no soft or external links, each item once
    if channel is not None and channel in names:
        return channel
    if channel is None and len(names) == 1:
        return names[0]
    listed = ", ".join(map(repr, names)) or "none"
    wanted = "one map" if channel is None else f"the map {channel!r}"
    raise MapError(str(path), [f"expected {wanted}, the two-dimensional datasets are {listed}"])


def _problems(dataset: Any, window: Window | None) -> list[str]:
    """Return what speaks against reading a dataset; of packed ones, whole chunks are unpacked."""
    problems = shape_problems(dataset.shape)
    if dataset.dtype.kind not in "iuf":
        problems.append(f"heights are real numbers, this dataset holds {dataset.dtype}")
    if dataset.is_virtual or dataset.external:
        problems.append("its heights are in other files: copy them into one")
    if problems:
        return problems
    points = window[2] * window[3] if window else math.prod(dataset.shape)
    return memory_problems(points + math.prod(dataset.chunks or (0,)))
