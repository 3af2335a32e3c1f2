"""Writing and reading of the results folder of a study.

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
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache, wraps
from pathlib import Path
from typing import Annotated, Any, Literal, ParamSpec, TypeVar

import numpy as np
import pandas as pd
from pydantic import (
    ConfigDict,
    Field,
    FiniteFloat,
    PlainSerializer,
    PlainValidator,
    TypeAdapter,
    ValidationError,
    ValidationInfo,
)

from comparisons.errors import ResultsError
from comparisons.files import read_arrays, write_table, write_text
from comparisons.judging.reference import Reference
from comparisons.judging.verdicts import Verdict
from comparisons.machine import source_digest
from comparisons.results import rows
from comparisons.results.folder import Run
from comparisons.results.rows import NO_ROWS, Rows
from comparisons.scene.physics.absolute_loads import PATHS
from comparisons.scene.problems import first_problems
from comparisons.solving.plan_record import PlanRecord
from comparisons.tasks.shown_loads import NAMES, at_step, stored_steps

RESULTS = "results.csv"
DISTRIBUTIONS = "distributions.csv"
STUDY = "study.json"
FIELDS = "fields"
# The tables that are read: what they hold, and the columns that they must have.
TABLES = {
    RESULTS: ("rows", rows.ROWS),
    DISTRIBUTIONS: ("distributions", rows.DISTRIBUTIONS),
}
# The column by which a row is known as its scene's.
HASH = "scene_hash"
# Beginnings of the columns of errors, bars and times.
SHORT = ("error_", "reference_uncertainty", "seconds", "setup_seconds", "compile_seconds")
# What is missing is written as nothing: a scene or a method may well be called "nan" or "null".
_AS_WRITTEN: dict[str, Any] = {
    "keep_default_na": False,
    "na_values": [""],
    "dtype": dict.fromkeys((*rows.TEXTS, HASH), str),
    "low_memory": False,
}


P = ParamSpec("P")
T = TypeVar("T")


def once(function: Callable[P, T]) -> Callable[P, T]:
    """Evaluate a function of a record, and of plain values, once per record and values.

    A page and a terminal ask for the same verdicts hundreds of times. What was answered lives as
    long as the record; callers do not change it.
    """

    @wraps(function)
    def kept(*args: P.args, **more: P.kwargs) -> T:
        record, *values = args
        answers = vars(record).setdefault("_answers", {})
        key = (function, *values, *more.items())
        if key not in answers:
            answers[key] = function(*args, **more)
        answer: T = answers[key]
        return answer

    return kept


def _written(files: dict[tuple[str, int], Path]) -> list[tuple[str, int, str]]:
    return [(*setting, f"{FIELDS}/{path.name}") for setting, path in files.items()]


def _read(files: Any, info: ValidationInfo) -> dict[tuple[str, int], Path]:
    """Return the paths of files; refuse names that lead out: results may come from strangers."""
    root = Path(info.context or "")
    try:
        paths = {(str(m), int(n)): (root / name).resolve() for m, n, name in files}
    except TypeError as error:
        raise ValueError("expected lists of a method, a resolution and a file") from error
    for path in paths.values():
        if not path.is_relative_to(root.resolve()):
            raise ValueError(f"{path.name!r} leads out of {root}")
    return paths


# (method, resolution) -> file; in JSON a list of method, resolution and name.
Files = Annotated[dict[tuple[str, int], Path], PlainValidator(_read), PlainSerializer(_written)]


@dataclass(frozen=True, eq=False)
class SceneRecord:
    """The results of a study for one scene: the same object after a run and read from a folder.

    A record is equal to itself only, and does not change: what is derived from it is kept with it
    (`once`).
    """

    __pydantic_config__ = ConfigDict(arbitrary_types_allowed=True)

    name: str
    title: str
    text: str  # the scene as TOML, with every quantity in SI units
    # The prescribed quantity: "penetration", "force", "mean_gap", "tangential_force", "speed" ...
    control: str
    quantities: tuple[str, ...]  # what was compared
    tolerance: Annotated[float, Field(gt=0, lt=1)]  # the relative error asked for
    plan: PlanRecord
    reference: Reference
    verdicts: tuple[Verdict, ...]  # of every setting, at each equal load
    answer: str  # one sentence: the cheapest setting of each method within the tolerance
    # References that differ by more than their bars and a fifth of the tolerance, in words.
    disagreements: tuple[str, ...]
    # (method, resolution) -> path of the npz with the fields of realisation 0 at the last load.
    fields: Files = field(default_factory=dict)
    # Along what steps are compared, where that is not `control`: "step" of a path, "time".
    axis: str = ""
    # The scene's part of results.csv and of distributions.csv.
    rows: Annotated[Rows, Field(exclude=True)] = NO_ROWS
    distributions: Annotated[Rows, Field(exclude=True)] = NO_ROWS

    @cached_property
    def tables(self) -> dict[str, Any]:
        """What `text` says, however it is laid out; the text itself where it is no TOML."""
        try:
            return tomllib.loads(self.text)
        except tomllib.TOMLDecodeError:
            return {"text": self.text}

    def __getstate__(self) -> dict[str, Any]:
        """Leave out what is derived: another process derives it again."""
        return {name: value for name, value in vars(self).items() if name != "_answers"}

    @property
    def along(self) -> str:
        """The column along which steps are compared."""
        return self.axis or self.control

    @property
    def is_path(self) -> bool:
        """Whether errors and bars are relative to the largest value along the steps."""
        return self.along in PATHS

    def called(self, method: str) -> str:
        """Return what a method is called here, where that is not its usual title; else ""."""
        return next((item.title for item in self.plan.methods if item.method == method), "")

    def load_fields(self, method: str, resolution: int) -> dict[str, np.ndarray]:
        """Return the stored arrays of one solution, or an empty dict where there are none."""
        path = self.fields.get((method, int(resolution)))
        if path is None or not path.exists():
            return {}
        return dict(_checked_fields(path, path.stat().st_mtime_ns))


# The plots of a scene, drawn one after the other, need the same few files; all would fill memory.
@lru_cache(maxsize=8)
def _checked_fields(path: Path, changed: int) -> Mapping[str, np.ndarray]:
    """Return the arrays of a file as it was at its last change."""
    fields = read_arrays(path)
    problems = field_problems(fields)
    if problems:
        raise ResultsError(f"{path}: damaged results ({'; '.join(problems)})")
    return fields


@dataclass(frozen=True)
class StudyRecord:
    """A whole results folder."""

    created: str  # ISO date and time of the run
    command: str  # the command line that made it
    effort: Literal["quick", "full"]
    seconds: FiniteFloat  # wall time of the study, with that of the runs it resumed
    # ``system``, ``processor``, ``cores``, ``memory`` (bytes), ``threads``.
    machine: dict[str, str | int | float | None]
    versions: dict[str, str]  # package name -> version
    scenes: tuple[SceneRecord, ...]
    interrupted: bool = False  # True where the run was stopped before all solves were done
    source: str = ""  # digest of roughline's own source
    part: str = ""  # "K/N" where only this part of the tasks was solved here
    runs: tuple[Run, ...] = ()  # the runs that were merged
    directory: Annotated[Path, Field(exclude=True)] = Path()


_FORM = TypeAdapter(StudyRecord)


def save_study(record: StudyRecord) -> None:
    """Write study.json and the tables that are read back (fields are there already).

    A kill in between leaves an interrupted run, never tables beside the verdicts of another state.
    """
    root = record.directory
    begun = replace(record, scenes=(), interrupted=True)
    write_text(root / STUDY, _FORM.dump_json(begun, indent=1).decode())
    for name, (kind, _) in TABLES.items():
        table = stacked(record, [getattr(scene, kind).frame() for scene in record.scenes])
        if len(table) or name != DISTRIBUTIONS:
            write_table(root / name, table)
    write_text(root / STUDY, _FORM.dump_json(record, indent=1).decode())


def stacked(record: StudyRecord, tables: list[pd.DataFrame]) -> pd.DataFrame:
    """Return the tables of all scenes as one, each row with the hash of its scene."""
    several = zip(tables, record.scenes, strict=True)
    filled = [t.assign(**{HASH: _hash(scene.text)}) for t, scene in several if len(t)]
    table = pd.concat(filled, ignore_index=True) if filled else pd.DataFrame(columns=["scene"])
    # Eight digits of errors, bars and times do, and make a quarter of the file less; absurd
    # ones are beyond the range of single precision.
    short = [c for c in table if c.startswith(SHORT) and not (table[c].abs() > 1e37).any()]
    return table.astype(dict.fromkeys(short, np.float32))


def read_study(root: Path) -> StudyRecord:
    """Read study.json alone, without the tables; ResultsError as `load_study`."""
    try:
        text = (root / STUDY).read_text(encoding="utf-8")
        return replace(_FORM.validate_json(text, strict=True, context=root), directory=root)
    except ValidationError as error:
        problems = first_problems(error, STUDY)
        source = re.search(r'^ "source": "([0-9a-f]{64})"', text, re.MULTILINE)
        another = source is not None and source[1] != source_digest()
        said = "written by another version of roughline" if another else "damaged results"
        raise ResultsError(f"{root}: {said} ({problems})") from error
    except NotADirectoryError as error:
        raise ResultsError(f"{root}: expected a results folder, got a file") from error
    except FileNotFoundError as error:
        raise ResultsError(f"{root}: no results of roughline here ({STUDY} is missing)") from error
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
            if name != DISTRIBUTIONS:
                problems.append(f"{name} is missing")
        except (ValueError, OSError) as error:
            problems.append(f"{name}: {error}")
    if problems:
        raise ResultsError(f"{root}: damaged results ({'; '.join(problems)})")
    scenes = []
    for scene in record.scenes:
        own: dict[str, Any] = {k: t.where(t["scene"] == scene.name) for k, t in tables.items()}
        scenes.append(replace(scene, **own))
    return replace(record, scenes=tuple(scenes))


def _hash(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:12]


# Arrays that belong together: of one dimension and one length.
TOGETHER = (
    ("profile_x", "profile_height"),
    ("line_x", "line_height"),
    ("pressure_x", "pressure_y", "pressure", "pressure_weight"),
    ("pressure", "displacement", "gap"),
)
SCALARS = ("penetration", "profile_spacing", "line_penetration", "particle_spacing")
POINTS = ("mesh_points", "mesh_displacement", "particle_places", "particle_displacement")
# Arrays with a row for each particle.
PARTICLES = ("particle_places", "particle_displacement", "particle_von_mises")


def field_problems(fields: dict[str, np.ndarray]) -> list[str]:
    """Return what is wrong with the arrays of one solution, at the last load and before."""
    problems = _problems_at_one_load(fields)
    for step in stored_steps(fields) if not problems else ():
        own = {name: value for name, value in at_step(fields, step).items() if name in NAMES}
        earlier = _problems_at_one_load(own)
        problems += [f"step {step}: {problem}" for problem in earlier]
    return problems


def _problems_at_one_load(fields: dict[str, np.ndarray]) -> list[str]:
    names = {name for group in TOGETHER for name in group} | {*SCALARS, *POINTS}
    arrays = {name: value for name, value in fields.items() if name in names}
    problems = [
        f"{name}: expected numbers"
        for name, value in arrays.items()
        if value.dtype.kind not in "iuf"
    ]
    problems += [
        f"{name}: expected one number"
        for name in SCALARS
        if name in arrays and arrays[name].size != 1
    ]
    problems += [
        f"{name}: expected points (n, 3)"
        for name in POINTS
        if name in arrays and (arrays[name].ndim != 2 or arrays[name].shape[1] != 3)
    ]
    for group in TOGETHER:
        shapes = {arrays[name].shape for name in group if name in arrays}
        if len(shapes) > 1 or any(len(shape) != 1 or shape == (0,) for shape in shapes):
            problems.append(f"{', '.join(group)}: expected lists of one length")
    # the arrays that say how others are laid out
    shape = fields.get("pressure_shape")
    if shape is not None and (
        shape.shape != (2,)
        or shape.dtype.kind not in "iu"
        or int(np.prod(shape)) != fields.get("pressure", np.empty(0)).size
    ):
        problems.append("pressure_shape: expected the two numbers of cells of the pressure")
    heights = fields.get("heights")
    if heights is not None:
        size, contact = fields.get("size"), fields.get("contact")
        if heights.ndim != 2 or heights.dtype.kind not in "iuf" or min(heights.shape) < 1:
            problems.append("heights: expected a map of numbers")
        if size is None or size.shape != (2,) or size.dtype.kind not in "iuf":
            problems.append("size: expected two numbers")
        if contact is not None and contact.shape != heights.shape:
            problems.append("contact: expected a map like that of the heights")
    if len({np.shape(fields[name])[:1] for name in PARTICLES if name in fields}) > 1:
        problems.append(f"{', '.join(PARTICLES)}: expected a row for each particle")
    cells, points = fields.get("mesh_cells"), fields.get("mesh_points")
    if cells is not None and (
        cells.ndim != 2
        or cells.dtype.kind not in "iu"
        or points is None
        or not ((cells >= 0) & (cells < len(points))).all()
    ):
        problems.append("mesh_cells: expected numbers of mesh points")
    return problems
