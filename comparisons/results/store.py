"""Writing and reading of the results folder of a study; tables and fields to take away.

Layout of a folder::

    results.csv      one row per scene, method, resolution, realisation and load step
    study.json       what was asked, plans, references, verdicts, machine, versions
    measures.csv     the verdicts as a table, with the cost of each setting: never read back
                     (rows of all tables have the hash of their scene's text)
    fields/KEY.npz   arrays of one finished task (also what --resume finds)
    fields/*.vtu     the same fields for ParaView, where asked for
    pictures/*.png   the pictures of the report, by the digest of what they show

Every file is written to a temporary name beside it and then renamed, so a killed run leaves
whole files or none. Nothing is ever unpickled.
"""

from __future__ import annotations

import hashlib
import re
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from pydantic import ValidationError

from comparisons.errors import ResultsError
from comparisons.facts.quantities import CURVES, NORMAL, in_order, quantity
from comparisons.files import write_atomically, write_table
from comparisons.machine import source_digest
from comparisons.results import rows
from comparisons.results.folder import RECORDS
from comparisons.results.record import SceneRecord, StudyRecord
from comparisons.results.rows import NO_ROWS, Rows
from comparisons.scene.problems import first_problems

if TYPE_CHECKING:
    import meshio

RESULTS = "results.csv"
DISTRIBUTIONS = "distributions.csv"
STUDY = "study.json"
# The tables that are read: what they hold, and the columns that they must have.
TABLES = {RESULTS: ("rows", rows.ROWS), DISTRIBUTIONS: ("distributions", rows.DISTRIBUTIONS)}
# The column by which a row is known as its scene's.
HASH = "scene_hash"
# What is missing is written as nothing: a scene or a method may well be called "nan" or "null".
_AS_WRITTEN: dict[str, Any] = {
    "keep_default_na": False,
    "na_values": [""],
    "dtype": dict.fromkeys((*rows.TEXTS, HASH), str),
    "low_memory": False,
}


def save_study(record: StudyRecord) -> None:
    """Write study.json and the tables that are read back (fields are there already).

    A kill in between leaves an interrupted run, never tables beside the verdicts of another state.
    """
    root = record.directory
    begun = record.model_copy(update={"scenes": (), "interrupted": True})
    begun.write(root / STUDY)
    for name, (kind, _) in TABLES.items():
        table = stacked(record, [getattr(scene, kind).frame() for scene in record.scenes])
        if len(table) or name != DISTRIBUTIONS:
            write_table(root / name, table)
    record.write(root / STUDY)


def stacked(record: StudyRecord, tables: list[pd.DataFrame]) -> pd.DataFrame:
    """Return the tables of all scenes as one, each row with the hash of its scene."""
    several = zip(tables, record.scenes, strict=True)
    filled = [t.assign(**{HASH: _hash(scene.text)}) for t, scene in several if len(t)]
    return pd.concat(filled, ignore_index=True) if filled else pd.DataFrame(columns=["scene"])


def read_study(root: Path) -> StudyRecord:
    """Read study.json alone, without the tables; ResultsError as `load_study`."""
    try:
        text = (root / STUDY).read_text(encoding="utf-8")
        record = StudyRecord.model_validate_json(text, strict=True, context=root)
        return record.model_copy(update={"directory": root})
    except ValidationError as error:
        problems = first_problems(error, STUDY)
        source = re.search(r'^ "source": "([0-9a-f]{64})"', text, re.MULTILINE)
        another = source is not None and source[1] != source_digest()
        said = "written by another version of roughline" if another else "damaged results"
        raise ResultsError(f"{root}: {said} ({problems})") from error
    except NotADirectoryError as error:
        raise ResultsError(f"{root}: expected a results folder, got a file") from error
    except FileNotFoundError as error:
        others = "".join(f", {name} is there" for name in RECORDS if (root / name).exists())
        said = "no results of `roughline run` here" if others else "no results of roughline here"
        raise ResultsError(f"{root}: {said} ({STUDY} is missing{others})") from error
    except (ValueError, OSError) as error:
        raise ResultsError(f"{root}: damaged results ({error})") from error


def load_study(directory: str | Path) -> StudyRecord:
    """Read a results folder back; ResultsError where it has no finished study, or a damaged one."""
    root = Path(directory)
    record = read_study(root)
    hashes = {scene.name: _hash(scene.text) for scene in record.scenes}
    tables, problems = {}, []
    for name, (kind, columns) in TABLES.items():
        try:
            table = pd.read_csv(root / name, **_AS_WRITTEN)
            tables[kind] = Rows.of(table.drop(columns=HASH, errors="ignore"), columns)
            if HASH in table and hashes:  # a run killed before its end has rows and no scene yet
                others = table["scene"][table[HASH] != table["scene"].map(hashes)].unique()
                again = "run it again with --resume or --overwrite"
                problems += [
                    f"{name}: rows of another scene {other} than {STUDY} has: {again}"
                    for other in others
                ]
        except FileNotFoundError:
            tables[kind] = NO_ROWS
            if name != DISTRIBUTIONS and record.scenes:  # a run that ended at once has none
                problems.append(f"{name} is missing")
        except (ValueError, OSError) as error:
            problems.append(f"{name}: {error}")
    if problems:
        raise ResultsError(f"{root}: damaged results ({'; '.join(problems)})")
    scenes = []
    for scene in record.scenes:
        own: dict[str, Any] = {k: t.where(t["scene"] == scene.name) for k, t in tables.items()}
        scenes.append(replace(scene, **own))
    return record.model_copy(update={"scenes": tuple(scenes)})


def _hash(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:12]


MEASURES, TO_TAKE = "measures.csv", "curves.csv"
NEVER = "never"  # a surface leaves the band of single lines
# Of a setting: what its solves cost. Of a verdict: its numbers.
COST = (
    *("surfaces", "seconds", "setup_seconds", "seconds_all", "setup_seconds_all"),
    *("unknowns", "memory", "machine"),
)
NUMBERS = (
    *("uncertainty", "word", "step", "steps", "low", "high"),
    *("single_low", "single_high", "single_step"),
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

    ``error`` is that at the step that decides (NaN: it has no sign), ``maximum`` its size.
    """
    table = []
    for item in scene.verdicts:
        if not (item.resolution and item.counts and item.offered):
            continue
        solved = scene.setting_rows(item.method, item.resolution)
        table.append(
            {"scene": scene.name, "method": item.method, "resolution": item.resolution}
            | {name: solved[name][-1] for name in COST}
            | {
                "converged": solved["converged"].all(),
                "reason": next(filter(None, solved["reason"]), ""),
            }
            | {"quantity": item.quantity, "at": item.at}
            | {"rms": item.rms, "maximum": abs(item.error)}
            | {"error": item.error if item.signed else np.nan}
            | {name: getattr(item, name) for name in NUMBERS}
            | {"single_step": item.single_step if item.single_step >= 0 else np.nan}
            | {"outside_band": _listed(item.outside_band)}
        )
    return Rows.of(pd.DataFrame(table).rename(columns={"word": "verdict"})).frame()


def _listed(steps: tuple[int, ...] | None) -> str:
    """Return load steps as a column has them, "" where there can be none."""
    return "" if steps is None else " ".join(map(str, steps)) or NEVER


def curves(scene: SceneRecord) -> pd.DataFrame:
    """Return the answers of each method at its finest resolution, in SI units; NaN where lost.

    Columns are ``scene``, ``step`` (from 0), the prescribed load, and ``method:quantity / unit``.
    """
    along = scene.drawn_along
    names = in_order({*NORMAL, "contact_area", *scene.quantities} & {*CURVES, *NORMAL} - {along})
    found = {name: scene.curve(name) for name in scene.methods}
    found = {name: solved for name, solved in found.items() if len(solved)}
    planned = scene.rows.where(np.isfinite(scene.rows["step"]))
    steps, first = np.unique(planned["step"], return_index=True)

    def at_steps(solved: Rows, name: str) -> np.ndarray:
        values = np.full(len(steps), np.nan)
        values[np.searchsorted(steps, solved["step"])] = solved[name]
        return values

    columns = {"scene": [scene.name] * len(steps), "step": steps.astype(int)}
    known = np.array([*(at_steps(s, along) for s in found.values()), planned[along][first]])
    first = np.argmax(np.isfinite(known), axis=0)
    columns[_titled(along)] = known[first, np.arange(len(steps))]
    for method, solved in found.items():
        for name in names:
            values = at_steps(solved, name)
            if np.isfinite(values).any():
                columns[f"{method}:{_titled(name)}"] = values
    return pd.DataFrame(columns)


def _titled(name: str) -> str:
    unit = quantity(name).unit
    return f"{name} / {unit}" if unit else name


def mesh_of(fields: dict[str, np.ndarray]) -> meshio.Mesh | None:
    """Return the mesh of a solution's fields: a body, particles or a surface; None of neither."""
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
