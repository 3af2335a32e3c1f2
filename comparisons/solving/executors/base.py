"""The interface of executors, and the serial executor."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from comparisons.solving.forecast import Kind

if TYPE_CHECKING:
    from comparisons.solving.answers import Archive


@dataclass(frozen=True)
class Job:
    """One independent piece of work.

    Attributes
    ----------
    key : str
        Names it, and the file that keeps its answer: the same exactly when the answer is.
    work : callable
        A function of an importable module. What it needs comes in its arguments.
    arguments : tuple
        Picklable, unless the work is done in this process.
    memory : float
        Estimate of the peak memory in bytes that the work takes beyond what a process with all
        packages has; 0 is "little".
    kind : Kind
        What its time depends on.
    archive : Archive, optional
        How a folder keeps its answer.
    """

    key: str
    work: Callable[..., Any]
    arguments: tuple[Any, ...] = ()
    memory: float = 0.0
    kind: Kind = field(default_factory=Kind)
    archive: Archive | None = None


@dataclass(frozen=True)
class Done:
    """The outcome of a job.

    Attributes
    ----------
    job : Job
    value : object
        What the work returned.
    seconds : float
        Wall time of the work, where it was done.
    lost : str
        Why there is no value: the process that did the work was ended, again and again.
    """

    job: Job
    value: Any = None
    seconds: float = float("nan")
    lost: str = ""


class Executor(ABC):
    """Carries out jobs; a user adds some, and goes through what is finished, perhaps adding more.

    A job whose process is killed is tried again, a bounded number of times. An exception that the
    work raises is raised by `finished`.

    Attributes
    ----------
    workers : int
        How many jobs are done at a time.
    """

    workers = 1

    def __init__(self) -> None:
        self._waiting: deque[Job] = deque()

    def add(self, jobs: Iterable[Job]) -> None:
        """Take more jobs; also while `finished` is gone through."""
        self._waiting.extend(jobs)

    @abstractmethod
    def finished(self) -> Iterator[Done]:
        """Yield the jobs in the order in which they are finished, until none is left."""


class SerialExecutor(Executor):
    """Does one job after the other in this process."""

    def finished(self) -> Iterator[Done]:
        """Yield each job when it is done."""
        while self._waiting:
            job = self._waiting.popleft()
            value, seconds = timed(job.work, job.arguments)
            yield Done(job, value, seconds)


def timed(work: Callable[..., Any], arguments: tuple[Any, ...]) -> tuple[Any, float]:
    """Do the work and return its value with its wall time."""
    start = time.perf_counter()
    value = work(*arguments)
    return value, time.perf_counter() - start
