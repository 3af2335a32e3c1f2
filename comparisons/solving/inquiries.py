"""Inquiries: questions that request solves step by step and return an answer.

An inquiry is a generator. It yields the jobs it needs next, receives their outcomes by key, may
request more (to refine a reference or bisect a boundary), and returns its answer. `Inquiries` runs
many of them concurrently; a job requested several times is done once, and its outcome is kept in a
folder or in memory.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Generic, TypeVar

from comparisons.errors import LostWorkError, ResultsError
from comparisons.methods.registry import planned_solver
from comparisons.solving.execution import execute
from comparisons.solving.jobs import (
    Archive,
    Done,
    Executor,
    Forecast,
    Job,
    JobKind,
    Remaining,
    SerialExecutor,
)
from comparisons.solving.plan import Plan
from comparisons.tasks.solution import REALISATIONS, Solution, Solved, load_solution, save_solution
from comparisons.tasks.task import Task

A = TypeVar("A")
Inquiry = Generator[Sequence[Job], Mapping[str, Done], A]


@dataclass
class _Wait(Generic[A]):
    """An inquiry that cannot go on before some jobs are done."""

    name: str
    inquiry: Inquiry[A]
    outcomes: dict[str, Done]
    missing: set[str] = field(default_factory=set)


class Inquiries(Generic[A]):
    """Inquiries under way.

    Jobs are carried out by the executor (default: one after the other, here). Outcomes are kept by
    the keys of their jobs in a `folder`, where `resume` finds those of earlier runs, or in memory;
    `received` gets every outcome, kept or new, before the inquiries.
    """

    def __init__(
        self,
        executor: Executor | None = None,
        folder: Path | None = None,
        *,
        resume: bool = False,
        received: Callable[[Done], None] | None = None,
    ) -> None:
        self.answers: dict[str, A] = {}  # of the inquiries that have ended
        # Why the others came to no answer: the process of a job was ended again and again.
        self.lost: dict[str, str] = {}
        self._executor, self._received = executor or SerialExecutor(), received
        self._folder, self._resume = folder, resume
        # What this run has done; in a folder the values themselves need not stay in memory.
        self._own: dict[str, Done | None] = {}
        self._forecast = Forecast()
        self._open: dict[str, Job] = {}
        self._done: set[str] = set()
        self._waiting: dict[str, list[_Wait[A]]] = {}

    @property
    def counts(self) -> tuple[int, int]:
        """How many jobs are done, and how many there are so far: inquiries may ask for more."""
        return len(self._done), len(self._done) + len(self._open)

    @property
    def ended(self) -> tuple[str, ...]:
        """The names of the inquiries that are answered, or lost."""
        return (*self.answers, *self.lost)

    def remaining(self, expected: Iterable[JobKind] = ()) -> Remaining:
        """Return the remaining time, with that of jobs that are expected to be asked for."""
        kinds = [*expected, *(job.kind for job in self._open.values())]
        return self._forecast.remaining(kinds, self._executor.workers)

    def ask(self, inquiries: Mapping[str, Inquiry[A]]) -> Iterator[Done | None]:
        """Go through inquiries side by side; yield None, then each job that is done."""
        try:
            for name, inquiry in inquiries.items():
                self._go_on(name, inquiry)
            yield None
        except BaseException:
            self._executor.end()
            raise
        for outcome in self._executor.finished():
            done = self._keep(outcome)
            key = done.job.key
            solving = float(getattr(done.value, "seconds", math.inf))
            self._forecast.learn(done.job.kind, done.seconds - done.compile_seconds, solving)
            del self._open[key]
            self._receive(done)
            for wait in self._waiting.pop(key):
                wait.outcomes[key] = done
                wait.missing.discard(key)
                if not wait.missing:
                    self._go_on(wait.name, wait.inquiry, wait.outcomes)
            yield done

    def _go_on(
        self, name: str, inquiry: Inquiry[A], outcomes: Mapping[str, Done] | None = None
    ) -> None:
        """Let an inquiry ask until it has to wait, or has its answer."""
        try:
            while True:
                jobs = next(inquiry) if outcomes is None else inquiry.send(outcomes)
                wait = _Wait(name, inquiry, {})
                for job in jobs:  # the outcomes that are kept
                    done = None if job.key in self._open else self._kept(job)
                    if done is not None:
                        wait.outcomes[job.key] = done
                        if job.key not in self._done:
                            self._receive(done)
                missing = {job.key: job for job in jobs if job.key not in wait.outcomes}
                if missing:
                    wait.missing.update(missing)
                    for key, job in missing.items():
                        self._waiting.setdefault(key, []).append(wait)
                        if key not in self._open:
                            self._open[key] = job
                            self._executor.add([job])
                    return
                outcomes = wait.outcomes
        except StopIteration as end:
            self.answers[name] = end.value
        except LostWorkError as error:
            self.lost[name] = str(error)

    def _receive(self, done: Done) -> None:
        self._done.add(done.job.key)
        if self._received is not None:
            self._received(done)

    def _keep(self, done: Done) -> Done:
        """Keep an outcome, but what was lost, and return what of it stays in memory."""
        job, archive = done.job, done.job.archive
        if self._folder is None or archive is None or done.lost:
            self._own[job.key] = done
            return done
        archive.save(self._folder / f"{job.key}{archive.suffix}", done.value)
        self._own[job.key] = None
        return replace(done, value=archive.without_bulk(done.value))

    def _kept(self, job: Job) -> Done | None:
        """Return the outcome of a job, None where it is not known."""
        known, archive = self._own.get(job.key), job.archive
        if known is not None or self._folder is None or archive is None:
            return known
        path = self._folder / f"{job.key}{archive.suffix}"
        if not path.exists() or not (self._resume or job.key in self._own):
            return None
        try:
            value = archive.load(path)
        except ResultsError:
            return None
        return Done(job, value) if job.key in self._own or archive.is_final(value) else None


def answer_of(inquiry: Inquiry[A]) -> A:
    """Answer one inquiry here and now; LostWorkError where a job has no value."""
    inquiries: Inquiries[A] = Inquiries()
    for _ in inquiries.ask({"": inquiry}):
        pass
    for reason in inquiries.lost.values():
        raise LostWorkError(reason)
    return inquiries.answers[""]


def together(inquiries: Iterable[Inquiry[A]]) -> Inquiry[list[A]]:
    """Go through inquiries in step, as one, and return their answers in order."""
    several = list(inquiries)
    answers: dict[int, A] = {}
    pending: dict[int, Sequence[Job]] = {}

    def go_on(index: int, done: Mapping[str, Done] | None = None) -> None:
        inquiry = several[index]
        try:
            pending[index] = next(inquiry) if done is None else inquiry.send(done)
        except StopIteration as end:
            pending.pop(index, None)
            answers[index] = end.value

    for index in range(len(several)):
        go_on(index)
    while pending:
        done = yield [job for jobs in pending.values() for job in jobs]
        for index in list(pending):
            go_on(index, done)
    return [answers[index] for index in range(len(several))]


def curves(plan: Plan, earlier: Solved | None = None) -> Inquiry[Solved]:
    """Solve every method and resolution of a plan for its curves, but those that are known."""
    solved = dict(earlier or {})
    missing: dict[tuple[str, int], list[Job]] = {}
    for setting, tasks in plan.settings.items():
        for task in tasks if setting not in solved else ():
            quantities = tuple(sorted(ALWAYS.union(task.quantities)))
            job = solve_job(replace(task, with_body=False, quantities=quantities), curves_of)
            job = replace(job, kind=replace(job.kind, timed=False))
            missing.setdefault(setting, []).append(job)
    done = yield [job for jobs in missing.values() for job in jobs]
    for setting, jobs in missing.items():
        solutions: list[Solution] = [value_of(done[job.key]) for job in jobs]
        solved[setting] = Solution.concat(solutions, axis=REALISATIONS)
    return solved


# Quantities that every solve gives: claims that ask for different ones of them share it.
ALWAYS = {"force", "penetration", "contact_area"}
SOLUTION = Archive(
    ".npz", save_solution, load_solution, lambda solution: bool(solution.converged.any())
)


def solve_job(task: Task, work: Callable[[Task], Any]) -> Job:
    """Return a solve as a job of a campaign."""
    memory = planned_solver(task).memory(task)
    return Job(task.key, work, (task,), memory, JobKind.of(task), SOLUTION)


def curves_of(task: Task) -> Solution:
    """Solve a task for its curves: once, and with fields only where a pressure is compared."""
    solution = execute(task, repeats=1)
    if not task.wants_pressure:
        solution.fields.clear()
    return solution


def value_of(done: Done) -> Any:
    """Return the value of a job; LostWorkError where there is none."""
    if done.lost:
        raise LostWorkError(done.lost)
    return done.value
