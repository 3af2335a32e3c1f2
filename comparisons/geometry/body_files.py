"""Meshes of users' bodies, read by meshio in a process of limited memory: cells and named parts.

Named parts are Gmsh's physical groups, Abaqus' node sets, element sets and surfaces, and the
non-zero entries of arrays in VTU files.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from comparisons.geometry.reading import FileError, quiet, read_apart
from reference.fem.solid_mesh import KINDS, SolidMesh

if TYPE_CHECKING:
    import meshio

SOLIDS = (*KINDS, "hexahedron20")


@dataclass(frozen=True, eq=False)
class NamedPart:
    """A named part: faces (k, 2) of the mesh, and nodes on or beside them."""

    faces: np.ndarray
    nodes: np.ndarray
    inside: int = 0


@dataclass(frozen=True, eq=False)
class BodyFile:
    """The mesh in the coordinates and unit of the file, with its named parts."""

    mesh: SolidMesh
    parts: dict[str, NamedPart]


def read_body(path: Path) -> BodyFile:
    """Read a mesh and its named parts."""
    if not path.is_file():
        raise FileError(f"file: expected a mesh, got {str(path)!r}, which is no file")
    try:
        answer = read_apart(f"{__name__}:mesh_of", path, remedy="use a coarser mesh")
    except FileError as error:
        raise FileError(*(f"file: {problem}" for problem in error.problems)) from error
    mesh = SolidMesh(KINDS[answer["kind"]], answer["points"], answer["cells"])
    parts = {
        name: NamedPart(answer[f"{k}.faces"], answer[f"{k}.nodes"], inside)
        for k, (name, inside) in enumerate(answer["parts"])
    }
    return BodyFile(mesh, parts)


def mesh_of(path: Path) -> dict[str, Any]:
    """Return the arrays of `read_body`; runs in a process of its own."""
    import meshio

    try:
        with quiet() as output:
            raw = meshio.read(path)
    except (Exception, SystemExit) as error:  # it prints messages and exits the program
        lines = [line.strip() for line in output.getvalue().splitlines() if line.strip()]
        reason = lines[0] if isinstance(error, SystemExit) and lines else str(error)
        kind = "" if isinstance(error, SystemExit) else f"{type(error).__name__}: "
        raise FileError(f"{path.name} is no mesh that meshio reads ({kind}{reason})") from None
    solids: Counter[str] = Counter()
    for block in raw.cells:
        if block.dim == 3:
            solids[block.type] += len(block.data)
    if len(solids) != 1 or not set(solids) <= set(SOLIDS):
        came = ", ".join(f"{count} {kind}" for kind, count in solids.items()) or "no volume cells"
        raise FileError(f"expected cells of one kind of {', '.join(SOLIDS)}, got {came}")
    (kind,) = solids
    cells = np.concatenate([block.data for block in raw.cells if block.type == kind])
    if raw.points.shape[1] != 3 or not np.isfinite(raw.points).all():
        raise FileError("expected finite coordinates x, y, z of all points")
    used, places = np.unique(cells, return_inverse=True)
    mesh = SolidMesh.from_vtk(kind, raw.points[used], places.reshape(cells.shape))
    renumbered = np.full(len(raw.points), -1)
    renumbered[used] = np.arange(len(used))
    # all names with their parts; of equal names the last counts
    parts: dict[str, NamedPart] = {}
    for name, mask in raw.point_data.items():
        if mask.ndim == 1 and np.isfinite(mask).all():
            parts[name] = _node_part(mesh, renumbered, np.flatnonzero(mask))
    for name, nodes in raw.point_sets.items():
        parts[name] = _node_part(mesh, renumbered, np.asarray(nodes, dtype=np.int64))
    for name, chosen in _cell_groups(raw):
        # faces of named triangles and quadrilaterals, nodes of lines and vertices
        found, touched, inside = [np.zeros((0, 2), np.int64)], [np.zeros(0, np.int64)], 0
        for block, indices in zip(raw.cells, chosen, strict=True):
            if block.dim == 3 or not len(indices):
                continue
            of_block = renumbered[block.data[indices]]
            touched.append(of_block[of_block >= 0])
            if block.dim == 2:
                corners = of_block[:, : 3 if block.type.startswith("triangle") else 4]
                found.append(mesh.find(corners[(corners >= 0).all(axis=1)]))
                inside += len(indices) - len(found[-1])
        faces = np.unique(np.concatenate(found), axis=0)
        nodes = np.unique(np.concatenate([*touched, mesh.nodes_of(faces)]))
        parts[name] = NamedPart(faces, nodes, inside)
    for name, numbers in surfaces(path, raw):
        if numbers.ndim == 1:
            parts[name] = _node_part(mesh, renumbered, numbers)
        else:
            faces = mesh.find(renumbered[numbers])
            parts[name] = NamedPart(faces, mesh.nodes_of(faces))
    answer = {"kind": mesh.kind.name, "points": mesh.points, "cells": mesh.cells}
    answer["parts"] = [(name, part.inside) for name, part in parts.items()]
    for k, part in enumerate(parts.values()):
        answer |= {f"{k}.faces": part.faces, f"{k}.nodes": part.nodes}
    return answer


def _cell_groups(raw: meshio.Mesh) -> Iterator[tuple[str, list[np.ndarray]]]:
    """Yield the names of cell groups, with the selected cells of every block."""
    empty = np.zeros(0, dtype=np.int64)
    for name, blocks in raw.cell_data.items():
        if name.startswith("gmsh:") or any(np.ndim(block) != 1 for block in blocks):
            continue
        yield name, [np.flatnonzero(block) for block in blocks]
    for name, blocks in raw.cell_sets.items():
        if not name.startswith("gmsh:"):
            chosen = [empty if block is None else np.asarray(block, np.int64) for block in blocks]
            yield name, chosen
    tags = raw.cell_data.get("gmsh:physical")
    if tags is None:
        return
    names = {(int(dim), int(tag)): name for name, (tag, dim) in raw.field_data.items()}
    groups = {
        (b.dim, int(t))
        for b, block_tags in zip(raw.cells, tags, strict=True)
        for t in set(block_tags)
    }
    for dim, tag in sorted(groups - {(b.dim, 0) for b in raw.cells}):
        pairs = zip(raw.cells, tags, strict=True)
        chosen = [
            np.flatnonzero(block_tags == tag) if b.dim == dim else empty for b, block_tags in pairs
        ]
        yield names.get((dim, tag), str(tag)), chosen


def _node_part(mesh: SolidMesh, numbers: np.ndarray, nodes: np.ndarray) -> NamedPart:
    """Return the named nodes, and the faces with all corners among them."""
    nodes = numbers[nodes]
    inside = np.zeros(len(mesh.points), dtype=bool)
    inside[nodes[nodes >= 0]] = True
    return NamedPart(mesh.faces_within(inside), np.flatnonzero(inside))


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


def surfaces(path: Path, raw: meshio.Mesh) -> Iterator[tuple[str, np.ndarray]]:
    """Yield the surfaces of an Abaqus file, which meshio does not read: only its mesh and sets.

    Names with the corners (k, 3 or 4) of faces, or with nodes (k,), as point numbers of the file.

        *SURFACE, NAME=top, TYPE=ELEMENT
        _top_S2, S2

    (Abaqus Analysis User's Guide, "Element-based surface definition"). Abaqus/CAE writes surfaces
    with such generated sets, of elements or of nodes. Those that list element numbers are skipped.
    """
    if path.suffix.lower() != ".inp":
        return
    # the name, type and data lines of every *SURFACE
    text = path.read_text(encoding="utf-8", errors="replace")
    definitions: list[tuple[str, str, list[list[str]]]] = []
    keyword, rows = "", list[list[str]]()
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
                definitions.append((values["NAME"], values.get("TYPE", "ELEMENT").upper(), rows))
        keyword, rows = line.strip(), []
    for name, kind, rows in definitions:
        if kind == "NODE":
            sets = {
                key.upper(): np.asarray(nodes, np.int64) for key, nodes in raw.point_sets.items()
            }
            pieces = [sets.get(row[0].upper()) for row in rows]
        else:
            pieces = [_corners(raw, *row) for row in rows]
        known = [piece for piece in pieces if piece is not None]
        if known and len(known) == len(pieces):
            yield name, np.concatenate(known)


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
