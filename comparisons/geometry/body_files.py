"""Meshes of users' bodies, read by meshio: cells and named parts.

Named parts are Gmsh's physical groups, Abaqus' node sets, element sets and surfaces, and the
non-zero entries of arrays in VTU files.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import meshio
import numpy as np

from comparisons.errors import InputError
from comparisons.geometry.abaqus_surfaces import surfaces
from comparisons.geometry.silence import quiet
from comparisons.geometry.unpacking import size_problems
from reference.fem.solid_mesh import KINDS, SolidMesh

SOLIDS = (*KINDS, "hexahedron20")


class BodyError(InputError):
    """A body's file cannot be used; ``problems`` lists why."""

    def __init__(self, problems: list[str]) -> None:
        super().__init__("; ".join(problems))
        self.problems = problems


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
    """Read a mesh and its named parts.

    Raises
    ------
    BodyError
        If the file cannot be read, or its cells are not all of one supported type.
    """
    if not path.is_file():
        raise BodyError([f"file: expected a mesh, got {str(path)!r}, which is no file"])
    problems = [problem for file in (path, *_beside(path)) for problem in _size_problems(file)]
    if problems:
        raise BodyError(problems)
    raw = _read(path)
    solids: Counter[str] = Counter()
    for block in raw.cells:
        if block.dim == 3:
            solids[block.type] += len(block.data)
    if len(solids) != 1 or not set(solids) <= set(SOLIDS):
        came = ", ".join(f"{count} {kind}" for kind, count in solids.items()) or "no volume cells"
        raise BodyError([f"file: expected cells of one kind of {', '.join(SOLIDS)}, got {came}"])
    (kind,) = solids
    cells = np.concatenate([block.data for block in raw.cells if block.type == kind])
    if raw.points.shape[1] != 3 or not np.isfinite(raw.points).all():
        raise BodyError(["file: expected finite coordinates x, y, z of all points"])
    used, numbers = np.unique(cells, return_inverse=True)
    mesh = SolidMesh.from_vtk(kind, raw.points[used], numbers.reshape(cells.shape))
    renumbered = np.full(len(raw.points), -1)
    renumbered[used] = np.arange(len(used))
    parts = dict(_parts(raw, mesh, renumbered))
    for surface in surfaces(path, raw):
        if len(surface.nodes):
            parts[surface.name] = _node_part(mesh, renumbered, surface.nodes)
        else:
            faces = mesh.find(renumbered[surface.corners])
            parts[surface.name] = NamedPart(faces, mesh.nodes_of(faces))
    return BodyFile(mesh, parts)


def _size_problems(path: Path) -> list[str]:
    remedy = "use a coarser mesh"
    return [f"file: {path.name}: {problem}" for problem in size_problems(path, remedy)]


def _beside(path: Path) -> list[Path]:
    """Return the files with the arrays of an XDMF file: ``NAME.h5:/...``."""
    if path.suffix.lower() not in (".xdmf", ".xmf"):
        return []
    text = path.read_text(encoding="utf-8", errors="replace")
    arrays = {path.parent / name.strip() for name in re.findall(r">([^<>:]+):[^<>]+<", text)}
    return sorted(file for file in arrays if file.is_file())


def _read(path: Path) -> meshio.Mesh:
    """Read with meshio, which prints messages and exits the program on failure."""
    try:
        with quiet() as output:
            return meshio.read(path)
    except (Exception, SystemExit) as error:
        lines = [line.strip() for line in output.getvalue().splitlines() if line.strip()]
        reason = lines[0] if isinstance(error, SystemExit) and lines else str(error)
        kind = "" if isinstance(error, SystemExit) else f"{type(error).__name__}: "
        raise BodyError(
            [f"file: {path.name} is no mesh that meshio reads ({kind}{reason})"]
        ) from None


def _parts(
    raw: meshio.Mesh, mesh: SolidMesh, numbers: np.ndarray
) -> Iterator[tuple[str, NamedPart]]:
    """Yield all names with their parts; of equal names the last counts."""
    for name, mask in raw.point_data.items():
        if mask.ndim == 1 and np.isfinite(mask).all():
            yield name, _node_part(mesh, numbers, np.flatnonzero(mask))
    for name, nodes in raw.point_sets.items():
        yield name, _node_part(mesh, numbers, np.asarray(nodes, dtype=np.int64))
    for name, chosen in _cell_groups(raw):
        yield name, _cell_part(raw, mesh, numbers, chosen)


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


def _cell_part(
    raw: meshio.Mesh, mesh: SolidMesh, numbers: np.ndarray, chosen: list[np.ndarray]
) -> NamedPart:
    """Return faces of named triangles and quadrilaterals, and nodes of lines and vertices."""
    faces, nodes, inside = [np.zeros((0, 2), np.int64)], [np.zeros(0, np.int64)], 0
    for block, indices in zip(raw.cells, chosen, strict=True):
        if block.dim == 3 or not len(indices):
            continue
        cells = numbers[block.data[indices]]
        nodes.append(cells[cells >= 0])
        if block.dim == 2:
            corners = cells[:, : 3 if block.type.startswith("triangle") else 4]
            block_faces = mesh.find(corners[(corners >= 0).all(axis=1)])
            inside += len(indices) - len(block_faces)
            faces.append(block_faces)
    block_faces = np.unique(np.concatenate(faces), axis=0)
    return NamedPart(
        block_faces, np.unique(np.concatenate([*nodes, mesh.nodes_of(block_faces)])), inside
    )
