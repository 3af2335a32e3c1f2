"""Independent jobs: their outcome, forecasts of their time, and what carries them out.

A study, a run of claims, a calibration and the hard cases are lists of jobs. An executor (this
process, local processes, a cluster) takes jobs at any time (`add`) and gives their results as they
come (`finished`); what a job finds does not depend on the executor, on the number of workers, or on
the order.
"""

from __future__ import annotations

import math
import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from comparisons.facts.methods import METHODS, Method, Sort, Usual

if TYPE_CHECKING:
    # Processes that only carry out jobs start in a third of the time without the scenes.
    from comparisons.tasks.task import Task

# Solves that are timed are repeated up to so many times, within so many seconds.
REPEATS, REPEAT_SECONDS = 3, 0.1
# Seconds of usual solves at the usual pace with which the first jobs, often tiny, are averaged.
AS_USUAL = 0.1


@dataclass(frozen=True)
class JobKind:
    """The properties on which the time of a job depends."""

    # What is solved and how; of a measurement that is no scene, the claim and the experiment.
    scene: str = ""
    method: str = ""
    resolution: int = 1
    realisations: int = 1
    # Whether a short solve is repeated for its time: on the first surfaces of an ensemble.
    timed: bool = False
    sort: Sort = "single"

    @classmethod
    def of(cls, task: Task) -> JobKind:
        """Return the kind of a solve."""
        scene, of = task.scene, task.realisations
        # at other ranges equilibria are traced instead, and a flat face lets go as a whole
        ball = scene.adhesion is not None and scene.adhesion.short_range
        ball = ball and scene.indenter is not None and not scene.indenter.flat
        sort: Sort = "rough" if scene.rough else "single"
        if scene.physics or scene.body or not scene.half_space.uniform:
            sort = "adhesive" if ball else "other"
        return cls(scene.name, task.method, task.resolution, len(of), of[0] == 0, sort)

    @property
    def usual(self) -> Usual | None:
        """What a surface or a contact usually takes; None where nobody knows."""
        known = METHODS[self.method].usual if self.method in METHODS else {}
        return known.get(self.sort, known.get("single") if self.sort == "adhesive" else None)

    @property
    def usual_seconds(self) -> float:
        """What such a job usually takes; where nobody knows, how that grows."""
        usual = self.usual or Usual(growth=METHODS.get(self.method, Method("")).growth)
        return usual.at(self.resolution) * self.realisations

    @property
    def groups(self) -> Iterator[tuple[str | int, ...]]:
        """The groups of like jobs that it is in: from its own setting to all with a usual time."""
        yield self.scene, self.method, self.sort, self.resolution
        yield self.scene, self.method, self.sort
        if self.sort != "other":  # what a plate of rubber takes says nothing of a film of oil
            yield self.method, self.sort
        if self.usual is not None:
            yield ()


@dataclass(frozen=True)
class Archive:
    """How a folder keeps the value of a job."""

    suffix: str
    save: Callable[[Path, Any], None]  # ``save(path, value)``, atomically
    load: Callable[[Path], Any]  # ``load(path)``; raises ResultsError for a torn file
    # Whether the value of an earlier run is taken: what broke it may have been mended since.
    is_final: Callable[[Any], bool]
    # What of a value stays in memory once it is written; default: all.
    without_bulk: Callable[[Any], Any] = lambda value: value


@dataclass(frozen=True)
class Job:
    """One independent piece of work."""

    key: str  # names it, and the file that keeps its value: the same exactly when the value is
    # A function of an importable module. What it needs comes in its arguments.
    work: Callable[..., Any]
    arguments: tuple[Any, ...] = ()  # picklable, unless the work is done in this process
    # Estimate of the peak memory in bytes that the work takes beyond what a process with all
    # packages has; 0 is "little".
    memory: float = 0.0
    kind: JobKind = field(default_factory=JobKind)  # what its time depends on
    archive: Archive | None = None  # how a folder keeps its value


@dataclass(frozen=True)
class Done:
    """The outcome of a job."""

    job: Job
    value: Any = None  # what the work returned
    seconds: float = float("nan")  # wall time of the work, where it was done
    compile_seconds: float = 0.0  # those of them in which code was compiled
    # Why there is no value: the process that did the work was ended, again and again.
    lost: str = ""


@dataclass(frozen=True)
class Remaining:
    """Remaining seconds, whether jobs may take much longer, and `pace`: time over the usual one."""

    seconds: float
    complete: bool
    pace: float = 1.0


@dataclass
class _Spent:
    """Of some jobs: their number, the seconds beside their solves and in these, the usual ones."""

    jobs: int = 1
    beside: float = 0.0
    solving: float = AS_USUAL
    usual: float = AS_USUAL


class Forecast:
    """The remaining time of jobs: their usual time, times the pace of those most like them."""

    def __init__(self) -> None:
        self._done: dict[tuple[str | int, ...], _Spent] = {(): _Spent()}

    def learn(self, kind: JobKind, seconds: float, solving: float = math.inf) -> None:
        """Record the cost of a job without compilation, and the time of one of its solves."""
        if not math.isfinite(seconds):
            return
        seconds = max(seconds, 0.0)
        solving = solving if solving < seconds else seconds  # of what is lost NaN
        for group in kind.groups:
            done = self._done.setdefault(group, _Spent(0, 0.0, 0.0, 0.0))
            done.jobs += 1
            done.beside += max(seconds - _repeated(solving, kind), 0.0)
            done.solving += solving
            done.usual += kind.usual_seconds

    def cost(self, kind: JobKind) -> float | None:
        """Return the estimated seconds of a job, or None if unknown."""
        like = next((self._done[group] for group in kind.groups if group in self._done), None)
        if like is None:
            return None
        pace = like.solving / like.usual
        return like.beside / like.jobs + _repeated(pace * kind.usual_seconds, kind)

    def remaining(self, kinds: Iterable[JobKind], workers: int) -> Remaining:
        """Return the remaining time; complete if one of each method and sort was done."""
        asked = list(kinds)
        estimates = [cost for cost in map(self.cost, asked) if cost is not None]
        # One worker has the longest job, however many workers there are.
        seconds = max(sum(estimates) / workers, max(estimates, default=0.0))
        complete = all((kind.method, kind.sort) in self._done for kind in asked)
        return Remaining(seconds, complete, self._done[()].solving / self._done[()].usual)


def _repeated(solving: float, kind: JobKind) -> float:
    return max(solving, min(REPEATS * solving, REPEAT_SECONDS)) if kind.timed else solving


class Executor(ABC):
    """Carries out jobs; a user adds some, and goes through what is finished, perhaps adding more.

    A job whose process is killed is tried again, a bounded number of times. An exception that the
    work raises is raised by `finished`.
    """

    workers = 1  # how many jobs are done at a time
    # Whether this process does them, so that a compilation would spoil the times of the others.
    is_here = False

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

    is_here = True

    def finished(self) -> Iterator[Done]:
        """Yield each job when it is done."""
        while self._waiting:
            job = self._waiting.popleft()
            yield Done(job, *timed(job.work, job.arguments))


def timed(work: Callable[..., Any], arguments: tuple[Any, ...]) -> tuple[Any, float, float]:
    """Do the work; return its value, its wall time, and what of it was compilation."""
    start = time.perf_counter()
    value = work(*arguments)
    return value, time.perf_counter() - start, getattr(value, "compile_seconds", 0.0)


def executor_for(workers: int = 1, scheduler: str | None = None) -> Executor:
    """Return a cluster (a dask scheduler's address), processes of one thread, or this process."""
    if scheduler is not None:
        from comparisons.solving.cluster import ClusterExecutor

        return ClusterExecutor(scheduler)
    if workers == 1:
        return SerialExecutor()
    from comparisons.solving.processes import ProcessExecutor

    return ProcessExecutor(workers)
