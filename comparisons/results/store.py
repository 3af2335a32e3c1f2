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
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from pydantic import TypeAdapter, ValidationError

from comparisons.errors import ResultsError
from comparisons.files import write_table, write_text
from comparisons.machine import source_digest
from comparisons.results import rows
from comparisons.results.record import StudyRecord
from comparisons.results.rows import NO_ROWS, Rows
from comparisons.scene.problems import first_problems

RESULTS = "results.csv"
DISTRIBUTIONS = "distributions.csv"
STUDY = "study.json"
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
