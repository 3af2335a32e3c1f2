"""The contract of an executor, and the one that needs no other process."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Job:
    """One independent piece of work.

    Attributes
    ----------
    key : str
        Names it; different for each job of an executor.
    work : callable
        A function of an importable module. What it needs comes in its arguments.
    arguments : tuple
        Picklable, unless the work is done in this process.
    memory : float
        Estimate of the peak memory in bytes that the work takes beyond what a process with all
        packages has; 0 is "little".
    """

    key: str
    work: Callable[..., Any]
    arguments: tuple[Any, ...] = ()
    memory: float = 0.0


@dataclass(frozen=True)
class Done:
    """What became of a job.

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

    def in_order(self, jobs: Sequence[Job]) -> list[Done]:
        """Do all of the jobs and return what became of them in their own order."""
        self.add(jobs)
        found = {done.job.key: done for done in self.finished()}
        return [found[job.key] for job in jobs]

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
