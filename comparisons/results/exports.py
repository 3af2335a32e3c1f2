"""To take away, never read back: curves and verdicts as tables, fields for ParaView (VTU)."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from comparisons.facts.quantities import CURVES, NORMAL, in_order, quantity
from comparisons.files import write_atomically, write_table
from comparisons.results.record import SceneRecord, StudyRecord
from comparisons.results.rows import Rows
from comparisons.results.store import stacked

if TYPE_CHECKING:
    import meshio


MEASURES, TO_TAKE = "measures.csv", "curves.csv"
# Of a setting: what its solves cost. Of a verdict: its numbers.
COST = (
    *("surfaces", "seconds", "setup_seconds", "seconds_all", "setup_seconds_all"),
    *("unknowns", "memory", "machine"),
)
NUMBERS = (
    *("uncertainty", "word", "step", "low", "high"),
    *("single_low", "single_high", "single_step", "outside_band"),
)


def write_exports(record: StudyRecord) -> None:
    """Write measures.csv and curves.csv."""
    tables = [measures(scene) for scene in record.scenes]
    write_table(record.directory / MEASURES, stacked(record, tables))
    tables = [curves(scene) for scene in record.scenes]
    if tables:
        write_table(record.directory / TO_TAKE, pd.concat(tables, ignore_index=True))


def measures(scene: SceneRecord) -> pd.DataFrame:
    """Return a row for each verdict of a method that gives the quantity, with its setting's cost.

    ``error`` is that at the step that decides (NaN: the distance of two fields has no sign),
    ``maximum`` its size; ``reason`` is the first one why a step has no answer.
    """
    table = []
    for item in scene.verdicts:
        if not (item.resolution and item.counts and item.offered):
            continue
        rows = scene.setting_rows(item.method, item.resolution)
        table.append(
            {"scene": scene.name, "method": item.method, "resolution": item.resolution}
            | {name: rows[name][-1] for name in COST}
            | {
                "converged": rows["converged"].all(),
                "reason": next(filter(None, rows["reason"]), ""),
            }
            | {"quantity": item.quantity, "at": item.at}
            | {"rms": item.rms, "maximum": abs(item.error)}
            | {"error": item.error if item.signed else np.nan}
            | {name: getattr(item, name) for name in NUMBERS}
            | {"single_step": item.single_step if item.single_step >= 0 else np.nan}
        )
    return Rows.of(pd.DataFrame(table).rename(columns={"word": "verdict"})).frame()


def curves(scene: SceneRecord) -> pd.DataFrame:
    """Return the answers of each method at its finest resolution, in SI units; NaN where lost.

    Columns are ``scene``, ``step`` (from 0), the prescribed load, and ``method:quantity / unit``:
    the methods in the order of every legend, the quantities in theirs. Of random surfaces these
    are the means.
    """
    along = scene.drawn_along
    names = in_order({*NORMAL, "contact_area", *scene.quantities} & {*CURVES, *NORMAL} - {along})
    found = {name: scene.curve(name) for name in scene.methods}
    found = {name: rows for name, rows in found.items() if len(rows)}
    steps = np.unique(np.concatenate([[], *(rows["step"] for rows in found.values())]))

    def at_steps(rows: Rows, name: str) -> np.ndarray:
        values = np.full(len(steps), np.nan)
        values[np.searchsorted(steps, rows["step"])] = rows[name]
        return values

    columns = {"scene": [scene.name] * len(steps), "step": steps.astype(int)}
    if found:
        known = np.array([at_steps(rows, along) for rows in found.values()])
        first = np.argmax(np.isfinite(known), axis=0)
        columns[_titled(along)] = known[first, np.arange(len(steps))]
    for method, rows in found.items():
        for name in names:
            values = at_steps(rows, name)
            if np.isfinite(values).any():
                columns[f"{method}:{_titled(name)}"] = values
    return pd.DataFrame(columns)


def _titled(name: str) -> str:
    unit = quantity(name).unit
    return f"{name} / {unit}" if unit else name


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
