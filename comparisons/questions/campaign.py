"""A campaign: a question that needs many solves, and the folder of its record.

A study, claims, hard cases, a calibration and a check are campaigns: each defines its `inquiries`,
generators of jobs by scene, claim, case or shape, and the record of what they found (`record_of`).
`run` opens the folder, reuses what jobs of a killed run returned, passes the others to an executor,
tells a watcher, and saves the record, also after an interrupt or lost work, before it raises. Only
this process writes, so workers need no common file system.
"""

from __future__ import annotations

import datetime
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, ClassVar, Generic, TypedDict, TypeVar, Unpack

from comparisons.errors import LostWorkError
from comparisons.machine import machine, versions
from comparisons.results.folder import Header, Layout, held, open_folder
from comparisons.solving.execution import THREADS
from comparisons.solving.inquiries import Inquiries, Inquiry
from comparisons.solving.jobs import Done, Executor, Remaining, SerialExecutor
from comparisons.solving.plan import Effort

A = TypeVar("A")
R = TypeVar("R")
# Part of a campaign divided among several machines: index and number of parts.
Part = tuple[int, int]
WHOLE: Part = (1, 1)


def part_text(part: Part) -> str:
    """Return a part as "K/N", nothing for the whole."""
    return "" if part == WHOLE else "{}/{}".format(*part)


Watch = Callable[["Campaign[Any, Any]", Done | None], None]
ADVICE = "completed solves are kept: use --resume to continue, --workers 1 to save memory"


class Options(TypedDict, total=False):
    """Options of all campaigns."""

    command: str  # the command line, for the report
    effort: Effort
    # Continue from existing results, or replace them: a folder that has any needs one of both.
    resume: bool
    overwrite: bool
    executor: Executor  # carries out the jobs; default: this process
    watch: Watch | None  # called with the campaign and the last job done (None at the start)


class Campaign(ABC, Generic[A, R]):
    """A question with the folder of its record, which is created when the run starts.

    A folder without reusable solves is replaced.
    """

    layout: ClassVar[Layout]

    def __init__(self, directory: Path, **options: Unpack[Options]) -> None:
        self.directory, self.command = directory, options.get("command", "")
        self.effort: Effort = options.get("effort", "quick")
        self.resume, self.overwrite = options.get("resume", False), options.get("overwrite", False)
        self.executor = options.get("executor") or SerialExecutor()
        self.watch = options.get("watch")
        self.saved: R | None = None  # the last record that was written
        now = datetime.datetime.now(datetime.UTC).astimezone()
        self._created = now.isoformat(timespec="seconds")
        self.under_way: Inquiries[A] = Inquiries()

    @abstractmethod
    def inquiries(self) -> Mapping[str, Inquiry[A]]:
        """Return the inquiries by unique names."""

    @abstractmethod
    def record_of(self, header: Header, answers: Mapping[str, A]) -> R:
        """Return the record of the answers so far."""

    @abstractmethod
    def save(self, record: R) -> None:
        """Write a record into the folder."""

    def seconds_before(self) -> float:
        """Return the seconds of the resumed run."""
        return 0.0

    def prepare(self) -> None:
        """Prepare for the first jobs, which are known now, where this process does them."""

    def received(self, done: Done) -> None:
        """Register the outcome of a job, kept or new."""

    def remaining(self) -> Remaining:
        """Return the remaining time, estimated from the measured costs of similar jobs."""
        return self.under_way.remaining()

    def run(self) -> R:
        """Run the remaining jobs, and return the record written to the folder.

        ResultsError if the folder cannot be used (`open_folder`). KeyboardInterrupt, LostWorkError
        after writing the completed work.
        """
        kept = self.layout.kept
        with held(self.directory):
            started = time.perf_counter()
            begun = (self.directory / self.layout.record).exists()
            # seconds of the run that this one resumes
            spent = self.seconds_before() if self.resume and begun else None
            anew = self.overwrite or not kept
            open_folder(self.directory, self.layout, resume=self.resume, overwrite=anew)
            if spent is None and kept:
                # A killed run's folder is marked as incomplete and as written by roughline.
                self._save(self.record(0.0, interrupted=True))
            stopped: KeyboardInterrupt | LostWorkError | None = None
            try:
                folder = self.directory / kept if kept else None
                self.under_way = Inquiries(
                    self.executor, folder, resume=self.resume, received=self.received
                )
                for done in self.under_way.ask(self.inquiries()):
                    if self.watch is not None:
                        self.watch(self, done)
                    if done is None and self.executor.is_here:
                        self.prepare()
            except (KeyboardInterrupt, LostWorkError) as error:
                stopped = error
            lost = [f"{name}: {reason}" for name, reason in self.under_way.lost.items()]
            if lost and stopped is None:
                advice = [ADVICE] if kept else []
                stopped = LostWorkError("\n".join([*lost, *advice]))
            seconds = (spent or 0.0) + time.perf_counter() - started
            record = self.record(seconds, interrupted=stopped is not None)
            self._save(record)
            if stopped is not None:
                raise stopped
            return record

    def _save(self, record: R) -> None:
        self.save(record)
        self.saved = record

    def record(self, seconds: float, *, interrupted: bool = False) -> R:
        """Return the record of the answers so far, with its header."""
        header = Header(
            created=self._created,
            command=self.command,
            effort=self.effort,
            seconds=seconds,
            machine=machine(THREADS),
            versions=versions(),
            interrupted=interrupted,
        )
        return self.record_of(header, self.under_way.answers)
