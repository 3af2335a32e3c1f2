"""Writing and reading of the results folder of a study.

Layout of a folder::

    results.csv      one row per scene, method, resolution, realisation and load step
    measures.csv     one row per scene, method, resolution, quantity: rms and largest error
                     (rows of all tables have the hash of their scene's text)
    study.json       what was asked, plans, references, machine, versions
    fields/KEY.npz   arrays of one finished task (also what --resume finds)
    fields/*.vtu     the same fields for ParaView, where asked for
    pictures/*.png   the pictures of the report, by the digest of what they show

Every file is written to a temporary name beside it and then renamed, so a killed run leaves
whole files or none. Nothing is ever unpickled.
"""

from __future__ import annotations

import hashlib
import json
import tomllib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache, wraps
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import numpy as np
import pandas as pd

from comparisons.errors import ResultsError
from comparisons.files import read_arrays, write_table, write_text
from comparisons.results.checks import field_problems, parse_study, table_problems, with_columns
from comparisons.scene.physics.absolute_loads import PATHS

RESULTS = "results.csv"
MEASURES = "measures.csv"
DISTRIBUTIONS = "distributions.csv"
STUDY = "study.json"
FIELDS = "fields"
# The tables by what they hold, and the column by which a row is known as its scene's.
TABLES = {RESULTS: "rows", MEASURES: "measures", DISTRIBUTIONS: "distributions"}
HASH = "scene_hash"
# Beginnings of the columns of errors, bars and times.
SHORT = ("error_", "reference_uncertainty", "seconds", "setup_seconds", "compile_seconds")
STUDY_KEYS = (
    *("created", "command", "effort", "seconds", "machine", "versions", "interrupted"),
    *("source", "part", "runs"),
)
SCENE_KEYS = (
    *("name", "title", "text", "control", "quantities", "tolerance", "plan"),
    *("reference", "answer", "disagreements", "axis"),
)


# What is missing is written as nothing: a scene or a method may well be called "nan" or "null".
_AS_WRITTEN: dict[str, Any] = {
    "keep_default_na": False,
    "na_values": [""],
    "dtype": dict.fromkeys(("scene", "method", "quantity", "at", HASH), str),
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


@dataclass(frozen=True, eq=False)
class SceneRecord:
    """The results of a study for one scene.

    A record is equal to itself only, and does not change: what is derived from it is kept with it
    (`once`).

    Attributes
    ----------
    name, title : str
    text : str
        The scene as TOML, with every quantity in SI units.
    control : str
        The prescribed quantity: "penetration", "force", "mean_gap", "tangential_force", "speed" ...
    axis : str
        Along what steps are compared, where that is not `control`: "step" of a path, "time".
    quantities : tuple of str
        What was compared.
    tolerance : float
        The relative error asked for.
    plan : dict
        ``methods`` (list of {method, supported, reason, resolutions, modelled, numbers}),
        ``left_out`` (list of {what, why}), ``notes`` (list of str); ``switched_on`` (list of
        {what, how}).
    reference : dict
        ``method``, ``resolution``, ``text`` (one sentence), ``uncertainty`` ({quantity: relative
        95 % half-width, rms over the load steps, or None where unknown}) and ``bars`` ({quantity
        that it gives: its widest ``bar`` on the very same surfaces, and the ``step`` of it}),
        ``footnotes`` (disagreements that are small against the tolerance, in words).
    answer : str
        One sentence: the cheapest setting of each method within the tolerance.
    disagreements : tuple of str
        References that differ by more than their bars and a fifth of the tolerance, in words.
    rows, measures : DataFrame
        The scene's part of results.csv and measures.csv.
    fields : dict
        (method, resolution) -> path of the npz with the fields of realisation 0 at the last load.
    distributions : DataFrame
        The scene's part of distributions.csv.
    """

    name: str
    title: str
    text: str
    control: str
    quantities: tuple[str, ...]
    tolerance: float
    plan: dict[str, Any]
    reference: dict[str, Any]
    answer: str
    disagreements: tuple[str, ...]
    rows: pd.DataFrame
    measures: pd.DataFrame
    fields: dict[tuple[str, int], Path] = field(default_factory=dict)
    axis: str = ""
    distributions: pd.DataFrame = field(default_factory=pd.DataFrame)

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
        planned = (m for m in self.plan.get("methods", []) if m.get("method") == method)
        return next((str(m.get("title") or "") for m in planned), "")

    def load_fields(self, method: str, resolution: int) -> dict[str, np.ndarray]:
        """Return the stored arrays of one solution, or an empty dict where there are none.

        Raises
        ------
        ResultsError
            If they are not such arrays.
        """
        path = self.fields.get((method, int(resolution)))
        if path is None or not path.exists():
            return {}
        return dict(_checked_fields(path, path.stat().st_mtime_ns))


# The plots of a scene, drawn one after the other, need the same few files; all would fill memory.
@lru_cache(maxsize=8)
def _checked_fields(path: Path, changed: int) -> Mapping[str, np.ndarray]:
    """Return the arrays of a file as it was at its last change.

    Raises
    ------
    ResultsError
    """
    fields = read_arrays(path)
    problems = field_problems(fields)
    if problems:
        raise ResultsError(f"{path}: damaged results ({'; '.join(problems)})")
    return fields


@dataclass(frozen=True)
class StudyRecord:
    """A whole results folder.

    Attributes
    ----------
    directory : Path
    created : str
        ISO date and time of the run.
    command : str
        The command line that made it.
    effort : str
        "quick" or "full".
    seconds : float
        Wall time of the study, with that of the runs it resumed.
    machine : dict
        ``system``, ``processor``, ``cores``, ``memory`` (bytes), ``threads``.
    versions : dict
        Package name -> version.
    scenes : tuple of SceneRecord
    interrupted : bool
        True where the run was stopped before all solves were done.
    source : str
        Digest of roughline's own source.
    part : str
        "K/N" where only this part of the tasks was solved here.
    runs : tuple of dict
        The runs that were merged: ``created``, ``command``, ``seconds``, ``machine`` of each.
    """

    directory: Path
    created: str
    command: str
    effort: str
    seconds: float
    machine: dict[str, Any]
    versions: dict[str, str]
    scenes: tuple[SceneRecord, ...]
    interrupted: bool = False
    source: str = ""
    part: str = ""
    runs: tuple[dict[str, Any], ...] = ()


def save_study(record: StudyRecord) -> None:
    """Write study.json and the tables of a study (fields are there already)."""
    root = record.directory
    for name, kind in TABLES.items():
        table = _stacked(record.scenes, kind)
        # Eight digits of errors, bars and times do, and make a quarter of the file less; absurd
        # ones are beyond the range of single precision.
        short = [c for c in table if c.startswith(SHORT) and not (table[c].abs() > 1e37).any()]
        table = table.astype(dict.fromkeys(short, np.float32))
        if len(table) or name != DISTRIBUTIONS:
            write_table(root / name, table)
    document = {name: getattr(record, name) for name in STUDY_KEYS}
    document["scenes"] = [_scene_document(scene, root) for scene in record.scenes]
    write_text(root / STUDY, json.dumps(document, indent=1, allow_nan=False))


def load_study(directory: str | Path) -> StudyRecord:
    """Read a results folder back.

    Raises
    ------
    ResultsError
        If the folder holds no finished study, or its files cannot be read.
    """
    root = Path(directory)
    try:
        document = parse_study((root / STUDY).read_text(encoding="utf-8"))
        tables, problems = {}, []
        for name, kind in TABLES.items():
            if name == DISTRIBUTIONS and not (root / name).exists():
                tables[kind] = pd.DataFrame(columns=["scene"])
                continue
            table = with_columns(pd.read_csv(root / name, **_AS_WRITTEN), kind)
            found = table_problems(table, kind) or _foreign(table, document["scenes"])
            problems += [f"{name}: {problem}" for problem in found]
            tables[kind] = table.drop(columns=HASH, errors="ignore")
        if problems:
            raise ValueError("; ".join(problems))
        scenes = tuple(_scene_record(item, root, tables) for item in document["scenes"])
        return StudyRecord(
            directory=root,
            scenes=scenes,
            **{name: document[name] for name in document if name != "scenes"},
        )
    except NotADirectoryError as error:
        raise ResultsError(f"{root}: expected a results folder, got a file") from error
    except FileNotFoundError as error:
        raise ResultsError(
            f"{root}: no results of roughline here ({Path(error.filename).name} is missing)"
        ) from error
    except (ValueError, KeyError, TypeError, OSError) as error:
        raise ResultsError(f"{root}: damaged results ({error})") from error


def _stacked(scenes: Iterable[SceneRecord], kind: str) -> pd.DataFrame:
    """Return the tables of all scenes as one, each row with the hash of its scene."""
    tables = [(getattr(scene, kind), _hash(scene.text)) for scene in scenes]
    filled = [table.assign(**{HASH: digest}) for table, digest in tables if len(table)]
    return pd.concat(filled, ignore_index=True) if filled else pd.DataFrame(columns=["scene"])


def _hash(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:12]


def _foreign(table: pd.DataFrame, scenes: list[dict[str, Any]]) -> list[str]:
    """Return which rows are of another run; earlier versions wrote no hash.

    A run that was killed before its end has rows and no scene yet.
    """
    if HASH not in table or not scenes:
        return []
    hashes = {scene["name"]: _hash(scene["text"]) for scene in scenes}
    others = table[table[HASH] != table["scene"].map(hashes)]
    return [
        f"rows of another scene {name} than {STUDY} has: run it again with --resume or --overwrite"
        for name in others["scene"].unique()
    ]


def _scene_document(scene: SceneRecord, root: Path) -> dict[str, Any]:
    document = {name: getattr(scene, name) for name in SCENE_KEYS}
    document["fields"] = [
        [method, resolution, path.relative_to(root).as_posix()]
        for (method, resolution), path in scene.fields.items()
    ]
    return document


def _scene_record(
    document: dict[str, Any], root: Path, tables: dict[str, pd.DataFrame]
) -> SceneRecord:
    values = dict(document)
    values["quantities"] = tuple(values["quantities"])
    values["disagreements"] = tuple(values["disagreements"])
    values["fields"] = {
        (method, int(resolution)): _inside(root, name)
        for method, resolution, name in values["fields"]
    }
    name = values["name"]
    own = {kind: _own(table, name) for kind, table in tables.items()}
    return SceneRecord(**own, **values)


def _own(table: pd.DataFrame, scene: str) -> pd.DataFrame:
    """Return the rows of a scene in a few blocks: pages take thousands of selections of them.

    A table that was read from a file has a block for each column, and its texts in one of Arrow's.
    """
    rows = table[table["scene"] == scene].reset_index(drop=True)
    texts = rows.select_dtypes("string").columns
    return rows.astype(dict.fromkeys(texts, object)).copy()


def _inside(root: Path, name: str) -> Path:
    """Refuse names that lead out of the folder: results may come from strangers."""
    path = (root / name).resolve()
    if not path.is_relative_to(root.resolve()):
        raise ResultsError(f"{name!r} leads out of {root}")
    return path
