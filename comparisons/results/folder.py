"""A results folder before a run: is it free, is it ours, and what has a killed run left there."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

from comparisons.errors import ResultsError
from comparisons.results.store import FIELDS, MEASURES, RESULTS, STUDY
from comparisons.results.study_checks import parse_study

# Names that tasks give to their files; nothing else in a folder is ours to delete.
OWN_FILE = re.compile(r"[a-z0-9-]+-[a-z_0-9]+-\d+-\d+-[0-9a-f]{12}\.(npz|vtu)")
# What a process that was killed while it wrote leaves beside the file it meant to write.
LEFTOVER = re.compile(r"\.(?P<meant>.+)\.[a-z0-9_]{8}")
TABLES = (RESULTS, MEASURES, "report.html")


def open_folder(directory: Path, scenes: Iterable[str], *, resume: bool, overwrite: bool) -> None:
    """Make a folder ready for a study.

    A used one needs `resume` or `overwrite`, must be roughline's own, and must not lose scenes by
    being resumed. Overwriting deletes old solutions; temporary files that a killed run left are
    deleted in any case; other people's files are spared.

    Raises
    ------
    ResultsError
        If the folder cannot be used as asked; nothing is changed then.
    """
    if directory.exists() and not directory.is_dir():
        raise ResultsError(f"{directory}: expected a folder for the results, got a file")
    if resume and overwrite:
        raise ResultsError("--resume and --overwrite: expected at most one of them")
    used = directory.exists() and any(directory.iterdir())
    if used and not (resume or overwrite):
        what = "has results already" if (directory / STUDY).exists() else "is not empty"
        raise ResultsError(
            f"{directory} {what}: say --resume to go on with it, --overwrite to start "
            "anew, or --out for another folder"
        )
    if used:
        _check_ownership(directory, set(scenes), resume=resume)
    fields = directory / FIELDS
    fields.mkdir(parents=True, exist_ok=True)
    clear_leftovers(directory, {*TABLES, STUDY})
    clear_leftovers(fields)
    if overwrite:
        for old in fields.iterdir():
            if OWN_FILE.fullmatch(old.name):
                old.unlink()


def clear_leftovers(
    folder: Path, names: Iterable[str] = (), pattern: re.Pattern[str] = OWN_FILE
) -> None:
    """Delete the temporary files of a killed run: those meant for `names` or `pattern`."""
    known = set(names)
    for path in folder.iterdir():
        found = LEFTOVER.fullmatch(path.name)
        if found and (found["meant"] in known or pattern.fullmatch(found["meant"])):
            path.unlink()


def _check_ownership(directory: Path, scenes: set[str], *, resume: bool) -> None:
    """Refuse folders that are not ours, and a resume that would drop other scenes."""
    fields, study = directory / FIELDS, directory / STUDY
    if fields.is_symlink():
        raise ResultsError(f"{fields}: expected a folder, got a link to elsewhere")
    foreign = [name for name in TABLES if (directory / name).exists()]
    if foreign and not study.exists():
        raise ResultsError(f"{directory} has {', '.join(foreign)} that roughline has not written")
    if not (resume and study.exists()):
        return
    try:
        document = parse_study(study.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise ResultsError(f"{directory}: damaged results ({error})") from error
    dropped = {scene["name"] for scene in document["scenes"]} - scenes
    if dropped:
        raise ResultsError(
            f"{directory} has results of {', '.join(sorted(dropped))}: name these scenes "
            "too, or choose another --out"
        )
