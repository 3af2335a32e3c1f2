"""Executors of independent jobs: this process, local processes, or a cluster.

A study, a run of claims, a calibration and the hard cases are lists of independent jobs. Each
executor takes jobs at any time (`add`) and gives their results as they come (`finished`); what a
job finds does not depend on the executor, on the number of workers, or on the order.
"""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from typing import Any

from comparisons.solving.jobs import Done, Job


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

    def end(self) -> None:  # noqa: B027  (one that starts nothing ahead has nothing to end)
        """End what is under way, before `finished` is gone through."""

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


def executor_for(workers: int = 1, scheduler: str | None = None) -> Executor:
    """Return what carries out the work: a cluster, processes here, or this process.

    Parameters
    ----------
    workers : int
        Processes here, each on one thread; 1 works in this process.
    scheduler : str, optional
        Address of a running ``dask.distributed`` scheduler; its workers are used, none here.
    """
    if scheduler is not None:
        from comparisons.solving.cluster import ClusterExecutor

        return ClusterExecutor(scheduler)
    if workers == 1:
        return SerialExecutor()
    from comparisons.solving.processes import ProcessExecutor

    return ProcessExecutor(workers)
