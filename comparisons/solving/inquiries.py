"""Inquiries: questions that request solves step by step and return an answer.

An inquiry is a generator. It yields the jobs it needs next, receives their answers by key, may
request more (to refine a reference or bisect a boundary), and returns its own answer. `Inquiries`
runs many of them concurrently; a job requested several times is done once.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Generic, TypeVar

from comparisons.errors import LostWorkError
from comparisons.solving.answers import Answers, curve_job, value_of
from comparisons.solving.executors import Executor, SerialExecutor
from comparisons.solving.jobs import Done, Forecast, Job, Remaining
from comparisons.solving.plan import Plan
from comparisons.tasks.solution import REALISATIONS, Solution, Solved

A = TypeVar("A")
Inquiry = Generator[Sequence[Job], Mapping[str, Done], A]


@dataclass
class _Wait(Generic[A]):
    """An inquiry that cannot go on before some jobs are done."""

    name: str
    inquiry: Inquiry[A]
    answers: dict[str, Done]
    missing: set[str] = field(default_factory=set)


class Inquiries(Generic[A]):
    """Inquiries under way.

    Parameters
    ----------
    executor : Executor, optional
        Carries out the jobs; default: one after the other, here.
    answers : Answers, optional
        What is done already, and where answers go; default: memory.
    received : callable, optional
        Called with every answer, kept or new, before the inquiries get it.

    Attributes
    ----------
    answers : dict
        What inquiries have returned, by their names.
    lost : dict
        Why others came to no answer: the process of a job was ended again and again.
    """

    def __init__(
        self,
        executor: Executor | None = None,
        answers: Answers | None = None,
        received: Callable[[Done], None] | None = None,
    ) -> None:
        self.answers: dict[str, A] = {}
        self.lost: dict[str, str] = {}
        self._executor, self._answers = executor or SerialExecutor(), answers or Answers()
        self._received = received
        self._forecast = Forecast()
        self._open: dict[str, Job] = {}
        self._done: set[str] = set()
        self._waiting: dict[str, list[_Wait[A]]] = {}

    @property
    def counts(self) -> tuple[int, int]:
        """How many jobs are done, and how many there are so far: inquiries may ask for more."""
        return len(self._done), len(self._done) + len(self._open)

    def remaining(self) -> Remaining:
        """Return the remaining time, estimated from the measured costs of similar jobs."""
        kinds = [job.kind for job in self._open.values()]
        return self._forecast.remaining(kinds, self._executor.workers)

    def ask(self, inquiries: Mapping[str, Inquiry[A]]) -> Iterator[Done | None]:
        """Go through inquiries side by side; yield None at the start, then each job that is done.

        LostWorkError ends it where all work is taken away, as with a scheduler that is gone.
        """
        try:
            for name, inquiry in inquiries.items():
                self._go_on(name, inquiry)
            yield None
        except BaseException:
            self._executor.end()
            raise
        for outcome in self._executor.finished():
            done = self._answers.put(outcome)
            key = done.job.key
            compilation = float(getattr(done.value, "compile_seconds", 0.0))
            solving = float(getattr(done.value, "seconds", math.inf))
            self._forecast.learn(done.job.kind, done.seconds - compilation, solving)
            del self._open[key]
            self._receive(done)
            for wait in self._waiting.pop(key):
                wait.answers[key] = done
                wait.missing.discard(key)
                if not wait.missing:
                    self._go_on(wait.name, wait.inquiry, wait.answers)
            yield done

    def _go_on(
        self, name: str, inquiry: Inquiry[A], answers: Mapping[str, Done] | None = None
    ) -> None:
        """Let an inquiry ask until it has to wait, or has its answer."""
        try:
            while True:
                jobs = next(inquiry) if answers is None else inquiry.send(answers)
                wait = _Wait(name, inquiry, {})
                for job in jobs:  # the answers that are kept
                    done = None if job.key in self._open else self._answers.get(job)
                    if done is not None:
                        wait.answers[job.key] = done
                        if job.key not in self._done:
                            self._receive(done)
                missing = {job.key: job for job in jobs if job.key not in wait.answers}
                if missing:
                    wait.missing.update(missing)
                    for key, job in missing.items():
                        self._waiting.setdefault(key, []).append(wait)
                        if key not in self._open:
                            self._open[key] = job
                            self._executor.add([job])
                    return
                answers = wait.answers
        except StopIteration as end:
            self.answers[name] = end.value
        except LostWorkError as error:
            self.lost[name] = str(error)

    def _receive(self, done: Done) -> None:
        self._done.add(done.job.key)
        if self._received is not None:
            self._received(done)


def answer_of(inquiry: Inquiry[A]) -> A:
    """Answer one inquiry here and now; LostWorkError where a job has no answer."""
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
    missing = {s: [*map(curve_job, tasks)] for s, tasks in plan.settings.items() if s not in solved}
    done = yield [job for jobs in missing.values() for job in jobs]
    for setting, jobs in missing.items():
        solutions: list[Solution] = [value_of(done[job.key]) for job in jobs]
        solved[setting] = Solution.concat(solutions, axis=REALISATIONS)
    return solved
