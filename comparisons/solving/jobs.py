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

from comparisons.facts.methods import METHODS, dimension_of, growth

if TYPE_CHECKING:
    # Processes that only carry out jobs start in a third of the time without the scenes.
    from comparisons.tasks.task import Task

# Solves that are timed are repeated up to so many times, within so many seconds.
REPEATS, REPEAT_SECONDS = 3, 0.1
# Seconds of a solve that do not grow with the grid, and the most by which what exceeds them grew at
# a doubling: meshes and dense matrices of single contacts are too small for their law.
OVERHEAD, STEEPEST = 0.1, 16.0


@dataclass(frozen=True)
class Kind:
    """The properties on which the time of a job depends."""

    # What is solved and how; of a measurement that is no scene, the claim and the experiment.
    scene: str = ""
    method: str = ""
    resolution: int = 1
    realisations: int = 1
    # Whether a short solve is repeated for its time: on the first surfaces of an ensemble.
    timed: bool = False
    rough: bool = False
    # Of an adhesive contact that is taken apart: seconds over the fourth power of the resolution.
    apart: float | None = None

    @classmethod
    def of(cls, task: Task) -> Kind:
        """Return the kind of a solve."""
        scene, of = task.scene, task.realisations
        setting = scene.name, task.method, task.resolution, len(of), of[0] == 0, scene.rough
        # at other ranges equilibria are traced instead, and a flat face lets go as a whole
        ball = scene.adhesion is not None and scene.adhesion.short_range
        ball = ball and scene.indenter is not None and not scene.indenter.flat
        return cls(*setting, METHODS[task.method].adhesive if ball else None)

    @property
    def surface_growth(self) -> float:
        """Factor of the time of a rough surface (line) with twice as many points a side."""
        # by any method it takes about as long as it has points
        return 2.0 if dimension_of(self.method) == 1 else 4.0

    @property
    def usual_seconds(self) -> float | None:
        """What such a job once took; of rough surfaces as they have points. None: unknown."""
        row = METHODS.get(self.method)
        if self.apart is not None:
            return self.apart * self.resolution**4
        if row is None or row.surface is None or not self.rough:
            return None if row is None else row.seconds
        doublings = math.log2(self.resolution / 64)
        return row.surface * self.realisations * self.surface_growth**doublings


@dataclass(frozen=True)
class Archive:
    """How a folder keeps an answer."""

    suffix: str
    save: Callable[[Path, Any], None]  # ``save(path, answer)``, atomically
    load: Callable[[Path], Any]  # ``load(path)``; raises ResultsError for a torn file
    # Whether an answer of an earlier run is taken: what broke it may have been mended since.
    is_final: Callable[[Any], bool]
    # What of an answer stays in memory once it is written; default: all.
    without_bulk: Callable[[Any], Any] = lambda answer: answer


@dataclass(frozen=True)
class Job:
    """One independent piece of work."""

    key: str  # names it, and the file that keeps its answer: the same exactly when the answer is
    # A function of an importable module. What it needs comes in its arguments.
    work: Callable[..., Any]
    arguments: tuple[Any, ...] = ()  # picklable, unless the work is done in this process
    # Estimate of the peak memory in bytes that the work takes beyond what a process with all
    # packages has; 0 is "little".
    memory: float = 0.0
    kind: Kind = field(default_factory=Kind)  # what its time depends on
    archive: Archive | None = None  # how a folder keeps its answer


@dataclass(frozen=True)
class Done:
    """The outcome of a job."""

    job: Job
    value: Any = None  # what the work returned
    seconds: float = float("nan")  # wall time of the work, where it was done
    # Why there is no value: the process that did the work was ended, again and again.
    lost: str = ""


@dataclass(frozen=True)
class Remaining:
    """Remaining seconds, and whether they are complete: False if jobs may take much longer."""

    seconds: float
    complete: bool


@dataclass
class _Cost:
    """What jobs took beside their solves, what solving all their surfaces once took, and counts."""

    beside: float = 0.0
    solving: float = 0.0
    realisations: int = 0
    jobs: int = 0


@dataclass
class Forecast:
    """Measured costs of jobs by scene, method and resolution.

    The cost of a job is estimated from jobs with the same scene, method and resolution; else from
    those at the nearest resolution, the solving scaled as from there in other scenes, or by the
    growth of the method's work; else from what such a job usually takes (`facts.methods`), times
    the pace: what jobs of the method, else all jobs, took so far over what they usually take.
    For a method from outside it is unknown until a job of it is done.
    """

    _costs: dict[tuple[str, str, bool], dict[int, _Cost]] = field(default_factory=dict)
    # By methods: what their jobs took, and what such jobs usually take.
    _paces: dict[str, tuple[float, float]] = field(default_factory=dict)

    def learn(self, kind: Kind, seconds: float, solving: float = math.inf) -> None:
        """Record the cost of a job without compilation, and the time of one of its solves."""
        if not math.isfinite(seconds):
            return
        costs = self._costs.setdefault((kind.scene, kind.method, kind.rough), {})
        cost = costs.setdefault(kind.resolution, _Cost())
        seconds = max(seconds, 0.0)
        solving = solving if solving < seconds else seconds  # of what is lost NaN
        cost.beside += max(seconds - _repeated(solving, kind), 0.0)
        cost.solving += solving
        cost.realisations += kind.realisations
        cost.jobs += 1
        taken, usually = self._paces.get(kind.method, (0.0, 0.0))
        if (usual := kind.usual_seconds) is None:
            self._paces[kind.method] = taken + seconds, usually + 1.0
        else:  # jobs that are short beside the overhead say little of the pace
            self._paces[kind.method] = taken + seconds + OVERHEAD, usually + usual + OVERHEAD

    def cost(self, kind: Kind) -> float | None:
        """Return the estimated seconds of a job, or None if unknown."""
        if (own := self._costs.get((kind.scene, kind.method, kind.rough))) is None:
            usual, of_method = kind.usual_seconds, self._paces.get(kind.method)
            if usual is None and of_method is None:
                return None
            timed = [pace for name, pace in self._paces.items() if Kind(method=name).usual_seconds]
            taken, usually = of_method or (sum(pace[side] for pace in timed) for side in (0, 1))
            return (usual or 1.0) * (taken / usually if usually else 1.0)
        nearest = min(own, key=lambda n: abs(math.log(n / kind.resolution)))
        cost = own[nearest]
        solving = cost.solving / cost.realisations * kind.realisations
        alike = [c for key, c in self._costs.items() if key[1:] == (kind.method, kind.rough)]
        both = [c for c in alike if nearest in c and kind.resolution in c]
        here, there = (
            sum(c[n].solving / c[n].realisations for c in both) for n in (nearest, kind.resolution)
        )
        if here > 0.0:
            solving *= there / here
        else:
            grown = STEEPEST if kind.apart is not None else min(growth(kind.method), STEEPEST)
            grown = kind.surface_growth if kind.rough else grown
            grown **= math.log2(kind.resolution / nearest)
            solving += max(solving - OVERHEAD, 0.0) * (grown - 1.0)
        return cost.beside / cost.jobs + _repeated(solving, kind)

    def remaining(self, kinds: Iterable[Kind], workers: int) -> Remaining:
        """Return the remaining time of jobs, divided among the workers.

        It is complete if of each job's method another was done: on rough surfaces if it is on one;
        else on this scene, or at as fine a resolution.
        """
        asked = list(kinds)
        estimates = [cost for cost in map(self.cost, asked) if cost is not None]
        # One worker has the longest job, however many workers there are.
        seconds = max(sum(estimates) / workers, max(estimates, default=0.0))
        finest: dict[tuple[str, bool], int] = {}
        for (_, method, rough), costs in self._costs.items():
            finest[method, rough] = max(finest.get((method, rough), 0), *costs)
        complete = all(
            (kind.scene, kind.method, kind.rough) in self._costs
            or finest.get((kind.method, kind.rough), 0) >= (1 if kind.rough else kind.resolution)
            for kind in asked
        )
        return Remaining(seconds, complete)


def _repeated(solving: float, kind: Kind) -> float:
    """Return the seconds of a solve with its repeats."""
    return max(solving, min(REPEATS * solving, REPEAT_SECONDS)) if kind.timed else solving


class Executor(ABC):
    """Carries out jobs; a user adds some, and goes through what is finished, perhaps adding more.

    A job whose process is killed is tried again, a bounded number of times. An exception that the
    work raises is raised by `finished`.
    """

    workers = 1  # how many jobs are done at a time

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
    """Return a cluster (by the address of a dask scheduler), processes here, or this process.

    Processes work on one thread each.
    """
    if scheduler is not None:
        from comparisons.solving.cluster import ClusterExecutor

        return ClusterExecutor(scheduler)
    if workers == 1:
        return SerialExecutor()
    from comparisons.solving.processes import ProcessExecutor

    return ProcessExecutor(workers)
