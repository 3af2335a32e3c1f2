"""Fields as VTU files for ParaView, through meshio."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from comparisons.files import write_atomically

if TYPE_CHECKING:
    import meshio


def mesh_of(fields: dict[str, np.ndarray]) -> meshio.Mesh | None:
    """Return the mesh of a solution's fields: the body of a FEM solve, particles, or a surface.

    None where there is neither (lines, closed forms, or pressure not asked for).
    """
    import meshio  # most runs write no such files

    if "mesh_points" in fields:
        # the body; one that came from a file goes back into that file's axes (in metres)
        cells = fields["mesh_cells"]
        kind = "tetra" if cells.shape[1] == 4 else "hexahedron"
        axes = fields.get("mesh_axes", np.eye(3))
        if np.linalg.det(axes) < 0:
            cells = cells[:, [1, 0, 2, 3] if kind == "tetra" else [4, 5, 6, 7, 0, 1, 2, 3]]
        return meshio.Mesh(
            fields["mesh_points"] @ axes + fields.get("mesh_origin", 0.0),
            [(kind, cells)],
            point_data={
                "displacement": fields["mesh_displacement"] @ axes,
                "von_mises": fields["mesh_von_mises"],
            },
        )
    if "particle_places" in fields:
        # one point for each particle, as wide as their spacing
        places = fields["particle_places"]
        data = {
            "displacement": fields["particle_displacement"],
            "von_mises": fields["particle_von_mises"],
            "diameter": np.full(len(places), float(fields["particle_spacing"])),
        }
        return meshio.Mesh(places, [("vertex", np.arange(len(places))[:, None])], point_data=data)
    if "pressure_shape" not in fields:
        return None
    nx, ny = (int(n) for n in fields["pressure_shape"])
    if nx < 2 or ny < 2:
        return None
    number = np.arange(nx * ny).reshape(nx, ny)
    corners = (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:])
    quads = np.stack([corner.ravel() for corner in corners], axis=-1)
    height = fields["heights"].ravel() if "heights" in fields else np.zeros(nx * ny)
    points = np.stack([fields["pressure_x"], fields["pressure_y"], height], axis=-1)
    names = [n for n in ("pressure", "displacement", "gap") if n in fields]
    values = {name: fields[name] for name in names if np.isfinite(fields[name]).all()}
    return meshio.Mesh(points, [("quad", quads)], point_data=values)


def vtu_file(fields: dict[str, np.ndarray]) -> bytes | None:
    """Return the content of a VTU file, or None where the fields have no mesh."""
    mesh = mesh_of(fields)
    if mesh is None:
        return None
    # meshio writes this format to a named file only.
    with tempfile.TemporaryDirectory(prefix="roughline-") as folder:
        path = Path(folder) / "fields.vtu"
        mesh.write(path)
        return path.read_bytes()


def write_fields(path: Path, fields: dict[str, np.ndarray]) -> bool:
    """Write a VTU file atomically; return False where the fields have no mesh."""
    content = vtu_file(fields)
    if content is None:
        return False
    write_atomically(path, lambda stream: stream.write(content))
    return True
