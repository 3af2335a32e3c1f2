"""A results folder: its lock, ownership, existing results, leftovers of a kill, records' header."""

from __future__ import annotations

import contextlib
import datetime
import errno
import os
import re
import tempfile
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError

from comparisons.errors import ResultsError
from comparisons.files import write_text

PAGE, MAILED = "report.html", "report-static.html"
# Held by the process that writes the folder, whom it names.
LOCK = ".roughline.lock"
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
    """What a command writes into its folder."""

    record: str  # the file that makes a folder known as this command's
    tables: tuple[str, ...] = (PAGE,)  # written beside it
    kept: str = ""  # folder of jobs' values, which `--resume` finds; "" where nothing is kept


@contextlib.contextmanager
def held(directory: Path) -> Iterator[None]:
    """Keep other processes out of a folder, created if missing, while a command writes into it.

    A process may hold a folder several times, one within the other. The system takes the lock from
    a process that is killed. ResultsError if another process holds the folder, or it is a file.
    """
    from filelock import FileLock, Timeout

    if directory.exists() and not directory.is_dir():
        raise ResultsError(f"{directory}: expected a folder for the results, got a file")
    new = not directory.exists()
    directory.mkdir(parents=True, exist_ok=True)
    path = directory.resolve() / LOCK
    lock = FileLock(path, timeout=0.0, is_singleton=True)
    try:
        lock.acquire()
    except Timeout as error:
        holder = ""
        with contextlib.suppress(OSError):
            holder = path.read_text(encoding="utf-8").strip()
        raise ResultsError(f"{directory}: in use by {holder or 'another process'}") from error
    except OSError as error:
        if error.errno not in (errno.ENOLCK, errno.ENOTSUP):  # file systems without locks
            raise
    try:
        if lock.lock_counter == 1:
            now = datetime.datetime.now(datetime.UTC).astimezone().isoformat(" ", "seconds")
            # A full disk takes no name; on Windows others read no locked file.
            with contextlib.suppress(OSError):
                path.write_text(f"process {os.getpid()} since {now}", encoding="utf-8")
        yield
    finally:
        if lock.lock_counter == 1:
            with contextlib.suppress(OSError):  # Windows deletes no open file
                path.unlink()
                if new:
                    directory.rmdir()  # where nothing was written
        lock.release()


def open_folder(directory: Path, layout: Layout, *, resume: bool, overwrite: bool) -> None:
    """Make a folder that is held ready for a run.

    A used one needs `resume` or `overwrite`, which deletes the values of jobs, and must have no
    results of others: ResultsError, and nothing is changed. What a killed run left is deleted in
    any case.
    """
    if resume and overwrite:
        raise ResultsError("--resume and --overwrite: expected at most one")
    used = is_used(directory)
    if used and not (resume or overwrite):
        state = "has results already" if (directory / layout.record).exists() else "is not empty"
        raise ResultsError(
            f"{directory} {state}: use --resume to continue, --overwrite to replace "
            "it, or --out for another folder"
        )
    kept = directory / layout.kept
    if used:  # nothing of others is touched
        if layout.kept and kept.is_symlink():
            raise ResultsError(f"{kept}: expected a folder, got a link to another place")
        foreign = [name for name in (*layout.tables, *RECORDS) if (directory / name).exists()]
        if foreign and layout.record not in foreign:
            raise ResultsError(
                f"{directory} has {', '.join(foreign)} that roughline has not written, or another "
                "of its commands: choose another --out"
            )
    kept.mkdir(parents=True, exist_ok=True)
    clear_leftovers(directory, {*layout.tables, layout.record})
    if layout.kept:
        clear_leftovers(kept, ())
        for old in kept.iterdir() if overwrite else ():
            if OWN_FILE.fullmatch(old.name):
                old.unlink()


def is_used(directory: Path) -> bool:
    """Return whether a folder holds anything besides its lock."""
    return any(path.name != LOCK for path in directory.iterdir())


@contextlib.contextmanager
def filled(out: Path, record: str) -> Iterator[Path]:
    """Yield a new folder, whose files move to `out`, the record last; or ResultsError."""
    with held(out):
        if is_used(out):
            raise ResultsError(f"{out}: expected a new or empty folder for the merged results")
        with tempfile.TemporaryDirectory(prefix=".merged.", dir=out) as name:
            folder = Path(name) / out.resolve().name  # the name by which it describes itself
            folder.mkdir()
            yield folder
            for path in sorted(folder.iterdir(), key=lambda path: path.name == record):
                path.replace(out / path.name)


def clear_leftovers(folder: Path, names: Iterable[str]) -> None:
    """Delete the temporary files of a killed run: those meant for `names`, or for jobs."""
    for path in folder.iterdir():
        leftover = LEFTOVER.fullmatch(path.name)
        if leftover and (leftover["meant"] in names or OWN_FILE.fullmatch(leftover["meant"])):
            path.unlink()


class Form(BaseModel):
    """Types as JSON has them; keys that a later version adds are kept."""

    model_config = ConfigDict(strict=True, extra="allow", frozen=True, allow_inf_nan=False)


@dataclass(frozen=True)
class Run:
    """A run that was merged with others."""

    created: str
    command: str
    seconds: float
    machine: dict[str, str | int | float | None]


class Header(Form):
    """A run of a campaign."""

    # ISO date and time of the run; the command line; "quick" or "full".
    created: str
    command: str
    effort: str
    seconds: float  # wall time, with that of the runs it resumed
    # Where it ran, with which packages.
    machine: dict[str, str | int | float | None]
    versions: dict[str, str]
    interrupted: bool  # True where it was stopped before all was done

    def write(self, file: Path) -> None:
        """Write the record, atomically."""
        write_text(file, self.model_dump_json(indent=1) + "\n")


class PartHeader(Header):
    """A run that may be a part of a whole, or have been merged of parts."""

    source: str = ""  # digest of roughline's own source
    part: str = ""  # "K/N" where only this part was solved here
    runs: tuple[Run, ...] = ()  # the runs that were merged


Record = TypeVar("Record", bound=Header)


def read_record(form: type[Record], file: Path, missing: str) -> Record:
    """Read a record; ResultsError where it is damaged, or there is none (said as `missing`)."""
    try:
        return form.model_validate_json(file.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise ResultsError(missing) from error
    except (ValidationError, OSError, UnicodeDecodeError) as error:
        first = " ".join(str(error).splitlines()[:3])
        raise ResultsError(f"{file}: damaged results ({first})") from error
