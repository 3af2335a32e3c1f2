"""Preparation of a results folder: ownership, existing results, leftovers of a killed run."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from comparisons.errors import ResultsError

PAGE = "report.html"
# What a folder says of itself to archives (`comparisons.results.crate`).
CRATE, CODEMETA = "ro-crate-metadata.json", "codemeta.json"
# What tells a folder of one command from those of the others.
RECORDS = ("study.json", "claims.json", "hard-cases.json", "calibration.csv", "ensemble.json")
# Names that jobs give to their files; nothing else in a folder is ours to delete.
OWN_FILE = re.compile(
    r"[a-z0-9-]+-[a-z_0-9]+-\d+-\d+-[0-9a-f]{12}\.(npz|vtu|parquet)|[a-z0-9-]+-[0-9a-f]{16}\.json"
)
# What a process that was killed while it wrote leaves beside the file it meant to write.
LEFTOVER = re.compile(r"\.(?P<meant>.+)\.[a-z0-9_]{8}")


@dataclass(frozen=True)
class Layout:
    """What a command writes into its folder.

    Attributes
    ----------
    record : str
        The file that makes a folder known as this command's.
    tables : tuple of str
        Written beside it.
    answers : str
        Folder of answers, which `--resume` finds; "" where nothing is kept.
    """

    record: str
    tables: tuple[str, ...] = (PAGE,)
    answers: str = ""


def open_folder(directory: Path, layout: Layout, *, resume: bool, overwrite: bool) -> None:
    """Make a folder ready for a run.

    A used one needs `resume` or `overwrite`, and must have no results of others. Overwriting
    deletes old answers; temporary files that a killed run left are deleted in any case; other
    people's files are spared.

    Raises
    ------
    ResultsError
        If the folder cannot be used as asked; nothing is changed then.
    """
    if directory.exists() and not directory.is_dir():
        raise ResultsError(f"{directory}: expected a folder for the results, got a file")
    if resume and overwrite:
        raise ResultsError("--resume and --overwrite: expected at most one")
    used = directory.exists() and any(directory.iterdir())
    if used and not (resume or overwrite):
        state = "has results already" if (directory / layout.record).exists() else "is not empty"
        raise ResultsError(
            f"{directory} {state}: use --resume to continue, --overwrite to replace "
            "it, or --out for another folder"
        )
    if used:
        _check_ownership(directory, layout)
    answers = directory / layout.answers
    answers.mkdir(parents=True, exist_ok=True)
    clear_leftovers(directory, {*layout.tables, layout.record, CRATE, CODEMETA})
    if layout.answers:
        clear_leftovers(answers, ())
        for old in answers.iterdir() if overwrite else ():
            if OWN_FILE.fullmatch(old.name):
                old.unlink()


def clear_leftovers(folder: Path, names: Iterable[str]) -> None:
    """Delete the temporary files of a killed run: those meant for `names`, or for answers."""
    for path in folder.iterdir():
        leftover = LEFTOVER.fullmatch(path.name)
        if leftover and (leftover["meant"] in names or OWN_FILE.fullmatch(leftover["meant"])):
            path.unlink()


def _check_ownership(directory: Path, layout: Layout) -> None:
    """Refuse folders that have results of others."""
    answers = directory / layout.answers
    if layout.answers and answers.is_symlink():
        raise ResultsError(f"{answers}: expected a folder, got a link to another place")
    foreign = [
        name for name in (*layout.tables, *RECORDS, CRATE, CODEMETA) if (directory / name).exists()
    ]
    if foreign and layout.record not in foreign:
        raise ResultsError(
            f"{directory} has {', '.join(foreign)} that roughline has not written, or another of "
            "its commands: choose another --out"
        )
