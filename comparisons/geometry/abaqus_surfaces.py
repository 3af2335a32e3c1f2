"""Surfaces of Abaqus files, which meshio does not read: faces of element sets, and node sets.

    *SURFACE, NAME=top, TYPE=ELEMENT
    _top_S2, S2

(Abaqus Analysis User's Guide, "Element-based surface definition"). Abaqus/CAE writes surfaces with
such generated sets. Surfaces that list element numbers are skipped.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import meshio
import numpy as np

# Corners of the faces S1, S2, ... of solid elements, numbered from 0.
FACES = {
    "tetra": ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)),
    "hexahedron": (
        (0, 1, 2, 3),
        (4, 7, 6, 5),
        (0, 4, 5, 1),
        (1, 5, 6, 2),
        (2, 6, 7, 3),
        (3, 7, 4, 0),
    ),
}


class Surface(NamedTuple):
    """The corners (k, 3 or 4) of its faces, or its nodes, as point numbers of the file."""

    name: str
    corners: np.ndarray
    nodes: np.ndarray


def surfaces(path: Path, raw: meshio.Mesh) -> Iterator[Surface]:
    """Yield the surfaces of an Abaqus file; meshio has read its mesh and sets."""
    if path.suffix.lower() != ".inp":
        return
    for name, kind, rows in _definitions(path.read_text(encoding="utf-8", errors="replace")):
        by_nodes = kind == "NODE"
        pieces = [_nodes(raw, row[0]) if by_nodes else _corners(raw, *row) for row in rows]
        corners = [piece for piece in pieces if piece is not None]
        if not corners or len(corners) < len(pieces):
            continue
        joined, none = np.concatenate(corners), np.zeros((0, 3), dtype=np.int64)
        yield Surface(name, none, joined) if by_nodes else Surface(name, joined, none.ravel())


def _definitions(text: str) -> Iterator[tuple[str, str, list[list[str]]]]:
    """Yield the name, type and data lines of every *SURFACE."""
    keyword, rows = "", []
    for line in [*text.splitlines(), "*END"]:
        if line.startswith("**") or not line.strip():
            continue
        if not line.startswith("*"):
            rows.append([cell.strip() for cell in line.strip().rstrip(",").split(",")])
            continue
        head, _, options = keyword.partition(",")
        if head.strip().upper() == "*SURFACE":
            parameters = dict(
                option.partition("=")[::2] for option in options.replace(" ", "").split(",")
            )
            values = {key.upper(): value.strip('"') for key, value in parameters.items()}
            if "NAME" in values:
                yield values["NAME"], values.get("TYPE", "ELEMENT").upper(), rows
        keyword, rows = line.strip(), []


def _nodes(raw: meshio.Mesh, chosen: str) -> np.ndarray | None:
    sets = {key.upper(): value for key, value in raw.point_sets.items()}
    nodes = sets.get(chosen.upper())
    return None if nodes is None else np.asarray(nodes, dtype=np.int64)


def _corners(raw: meshio.Mesh, chosen: str, face: str = "") -> np.ndarray | None:
    """Return the corners of one face of all elements of a set, or None if there is no such set."""
    sets = {key.upper(): value for key, value in raw.cell_sets.items()}
    if chosen.upper() not in sets:
        return None
    corners = []
    for block, chosen_cells in zip(raw.cells, sets[chosen.upper()], strict=False):
        if chosen_cells is None or not len(chosen_cells):
            continue
        faces = FACES.get(block.type.rstrip("0123456789"), ())
        number = face.upper().removeprefix("S")
        if not number.isdigit() or not 1 <= int(number) <= len(faces):
            return None
        corners.append(block.data[np.asarray(chosen_cells)][:, list(faces[int(number) - 1])])
    return np.concatenate(corners) if corners else None
