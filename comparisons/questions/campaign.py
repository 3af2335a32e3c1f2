"""A campaign: a question that takes many solves, and the folder of its answer.

A study, claims, hard cases, a calibration and a check are campaigns. Each says only two things:

- `inquiries`: generators of jobs (`comparisons.solving.inquiries`), one for each scene, claim, case
  or shape. A job is picklable and hashed (`Job.key`), so it does not matter who does it, nor when.
- `answer`: the record, from the header and from what the inquiries have returned so far.

The rest is here, once. `run` opens the folder (`comparisons.results.folder`), takes from it what a
killed run has left, hands the jobs to an executor, tells a watcher how far it is and how long the
rest takes, and saves the record - also after an interrupt or when work is lost, before it raises.
Answers are written by this process alone: workers need no common file system.
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
from comparisons.results.folder import Layout, open_folder
from comparisons.results.header import Header
from comparisons.results.store import SceneRecord
from comparisons.solving.answers import Answers
from comparisons.solving.execution import THREADS
from comparisons.solving.executors import Executor, executor_for
from comparisons.solving.forecast import Remaining
from comparisons.solving.inquiries import Inquiries, Inquiry
from comparisons.solving.jobs import Done
from comparisons.solving.planning import Effort

A = TypeVar("A")
R = TypeVar("R")
Watch = Callable[["Campaign[Any, Any]", Done | None], None]
ADVICE = "what was solved is kept: --resume goes on, --workers 1 needs less memory"


class Options(TypedDict, total=False):
    """What every campaign can be told; see `Campaign`."""

    command: str
    effort: Effort
    workers: int
    resume: bool
    overwrite: bool
    executor: Executor | None
    watch: Watch | None


class Campaign(ABC, Generic[A, R]):
    """A question with the folder of its answer.

    Parameters
    ----------
    directory : Path
        Created when the run starts. A folder with results needs `resume` or `overwrite`; one
        without solves to be kept is written anew. Nothing is written without a `layout`.
    command : str
        The command line, for the report.
    effort : {"quick", "full"}
    workers : int
        Processes; each solves on one thread.
    resume, overwrite : bool
        Go on with what is there; or start anew.
    executor : Executor, optional
        Carries out the jobs; default: `workers` processes here.
    watch : callable, optional
        Called with the campaign and what was done last (None at the start).
    """

    layout: ClassVar[Layout | None] = None

    def __init__(self, directory: Path = Path(), **options: Unpack[Options]) -> None:
        self.directory, self.command = directory, options.get("command", "")
        self.effort: Effort = options.get("effort", "quick")
        self.resume, self.overwrite = options.get("resume", False), options.get("overwrite", False)
        self.workers, self.executor = options.get("workers", 1), options.get("executor")
        self.watch = options.get("watch")
        now = datetime.datetime.now(datetime.UTC).astimezone()
        self._created = now.isoformat(timespec="seconds")
        self._inquiries: Inquiries[A] = Inquiries()

    @abstractmethod
    def inquiries(self) -> Mapping[str, Inquiry[A]]:
        """Return what is asked, under names that differ."""

    @abstractmethod
    def answer(self, header: Header, answers: Mapping[str, A]) -> R:
        """Return the record of what is answered so far."""

    def save(self, record: R) -> None:
        """Write a record into the folder."""

    def seconds_before(self) -> float | None:
        """Return the time of the run that is resumed, None where there is none."""
        return None

    def received(self, done: Done) -> None:
        """Take note of an answer, kept or new."""

    def so_far(self, done: Done) -> SceneRecord | None:
        """Return what is solved so far of the scene of a job, None where there is no scene."""
        return None

    @property
    def counts(self) -> tuple[int, int]:
        """How many jobs are done, and how many there are so far: refinements add some."""
        return self._inquiries.counts

    def remaining(self) -> Remaining:
        """Return how long the rest takes, by the measured costs of like jobs."""
        return self._inquiries.remaining()

    def run(self) -> R:
        """Solve what is not solved yet, and return the record that is in the folder then.

        Raises
        ------
        ResultsError
            If the folder is used and neither `resume` nor `overwrite` was said.
        KeyboardInterrupt, LostWorkError
            After writing what was done.
        """
        started = time.perf_counter()
        executor = self.executor or executor_for(self.workers)
        spent = self._open()
        stopped: KeyboardInterrupt | LostWorkError | None = None
        try:
            for done in self._inquiries_with(executor).ask(self.inquiries()):
                if self.watch is not None:
                    self.watch(self, done)
        except (KeyboardInterrupt, LostWorkError) as error:
            stopped = error
        lost = [f"{name}: {reason}" for name, reason in self._inquiries.lost.items()]
        if lost and stopped is None:
            advice = [ADVICE] if self.layout is not None and self.layout.answers else []
            stopped = LostWorkError("\n".join([*lost, *advice]))
        seconds = spent + time.perf_counter() - started
        record = self.record(seconds, interrupted=stopped is not None)
        self.save(record)
        if stopped is not None:
            raise stopped
        return record

    def record(self, seconds: float, *, interrupted: bool = False) -> R:
        """Return the record of what is answered so far, with its header."""
        header = Header(
            created=self._created,
            command=self.command,
            effort=self.effort,
            seconds=seconds,
            machine=machine(THREADS),
            versions=versions(),
            interrupted=interrupted,
        )
        return self.answer(header, self._inquiries.answers)

    def _open(self) -> float:
        """Make the folder ready; return the seconds of the run that is resumed."""
        if self.layout is None:
            return 0.0
        spent = self.seconds_before() if self.resume else None
        anew = self.overwrite or not self.layout.answers
        open_folder(self.directory, self.layout, resume=self.resume, overwrite=anew)
        if spent is None and self.layout.answers:
            # Killed before its end, a run leaves a folder that says so, and that is known as ours.
            self.save(self.record(0.0, interrupted=True))
        return spent or 0.0

    def _inquiries_with(self, executor: Executor) -> Inquiries[A]:
        answers = None
        if self.layout is not None and self.layout.answers:
            answers = Answers(self.directory / self.layout.answers, resume=self.resume)
        self._inquiries = Inquiries(executor, answers, self.received)
        return self._inquiries
