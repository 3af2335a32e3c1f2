"""Merging of the parts of an ensemble, in memory that does not grow with the surfaces."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterable, Iterator
from itertools import pairwise
from pathlib import Path

from comparisons.errors import InputError
from comparisons.questions.ensemble import Ensemble, result_of
from comparisons.questions.merging import other_versions
from comparisons.results.ensemble import (
    RECORD,
    SURFACES,
    EnsembleRecord,
    EnsembleResult,
    load_ensemble,
    save_ensemble,
    survey,
)
from comparisons.results.folder import filled
from comparisons.results.header import Header
from comparisons.scene.scene import parse_scene
from comparisons.tasks.bundles import Bundle


def are_ensembles(directories: Iterable[Path]) -> bool:
    """Return whether any of the folders holds an ensemble."""
    return any((directory / RECORD).exists() for directory in directories)


def merge_ensembles(directories: Iterable[Path], out: Path, command: str = "") -> EnsembleResult:
    """Write a folder with the surfaces of several parts; files are linked or copied as they are.

    Parameters
    ----------
    directories : iterable of Path
        Folders written by `roughline ensemble` with one scene, complete or not.
    out : Path
        A new or empty folder. It appears once it is complete.
    command : str

    Raises
    ------
    InputError
        Listing all differences; nothing is written then.
    """
    with filled(out, RECORD) as folder:
        runs = {path: load_ensemble(path) for path in directories}
        problems = list(_unlike(runs))
        if problems:
            raise InputError("\n  ".join(["these ensembles cannot be merged:", *problems]))
        settings = [bundles for path in runs for bundles in survey(path / SURFACES).values()]
        clashes = list(_clashes([item for bundles in settings for item in bundles.items()]))
        if clashes:
            raise InputError("\n  ".join(["surfaces are in more than one folder:", *clashes]))
        (folder / SURFACES).mkdir()
        for path in (path for bundles in settings for path in bundles):
            _copy(path, folder / SURFACES / path.name)
        first = next(iter(runs.values()))
        ensemble = Ensemble(parse_scene(first.text, first.name, Path()), folder)
        merged = result_of(ensemble, _header(runs, command), runs=_parts(runs))
        save_ensemble(folder, merged)
    return merged


def _unlike(runs: dict[Path, EnsembleRecord]) -> Iterator[str]:
    """Yield why the runs cannot be merged."""
    if len(runs) < 2:
        yield f"expected two different folders or more, got {len(runs)}"
    first = next(iter(runs.values()), None)
    for folder, run in runs.items():
        yield from other_versions(folder, run.versions, run.source)
        if first is not None and run.text != first.text:
            yield f"{folder}: expected the scene and the number of surfaces of {next(iter(runs))}"


def _clashes(files: list[tuple[Path, Bundle]]) -> Iterator[str]:
    """Yield the files that share a surface."""
    files.sort(key=lambda item: (item[1].identity, item[1].first))
    for (before, earlier), (path, later) in pairwise(files):
        if earlier.identity == later.identity and later.first < earlier.end:
            yield f"{before} and {path}: both have surface {later.first}"


def _copy(source: Path, target: Path) -> None:
    """Link a file, which nobody changes in place; copy it to another file system."""
    try:
        os.link(source, target)
    except OSError:
        shutil.copyfile(source, target)


def _header(runs: dict[Path, EnsembleRecord], command: str) -> Header:
    """Return what is true of all runs together: the last one's time, the sum of durations."""
    last = max(runs.values(), key=lambda run: run.created)
    header = {name: getattr(last, name) for name in Header.model_fields}
    header |= {"command": command, "seconds": sum(run.seconds for run in runs.values())}
    return Header(**header | {"interrupted": any(run.interrupted for run in runs.values())})


def _parts(runs: dict[Path, EnsembleRecord]) -> tuple[dict[str, object], ...]:
    parts: list[dict[str, object]] = []
    for run in runs.values():
        header = {name: getattr(run, name) for name in ("created", "command", "seconds", "machine")}
        parts += run.runs or [header]
    return tuple(parts)
