"""Cache of solved jobs, in a folder or in memory; solves as jobs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from comparisons.errors import LostWorkError, ResultsError
from comparisons.methods.registry import solver_of
from comparisons.solving.execution import execute
from comparisons.solving.jobs import Archive, Done, Job, Kind
from comparisons.tasks.archive import load_solution, save_solution
from comparisons.tasks.solution import REALISATIONS, Solution
from comparisons.tasks.task import Task

# Quantities that every solve gives: claims that ask for different ones of them share it.
ALWAYS = {"force", "penetration", "contact_area"}
SOLUTION = Archive(
    ".npz", save_solution, load_solution, lambda solution: bool(solution.converged.any())
)


class Answers:
    """Answers of jobs that are done, by their keys.

    Parameters
    ----------
    folder : Path, optional
        Where they are written; default: they stay in memory.
    resume : bool
        Take what an earlier run has left in the folder.
    """

    def __init__(self, folder: Path | None = None, *, resume: bool = False) -> None:
        self._folder, self._resume = folder, resume
        # What this run has done; in a folder the answers themselves need not stay in memory.
        self._own: dict[str, Done | None] = {}

    def path(self, job: Job) -> Path | None:
        """Return the file of an answer, None where it is kept in memory."""
        if self._folder is None or job.archive is None:
            return None
        return self._folder / f"{job.key}{job.archive.suffix}"

    def put(self, done: Done) -> Done:
        """Keep an answer and return what of it stays in memory.

        What was lost is tried again by the next run.
        """
        path, archive = self.path(done.job), done.job.archive
        if path is not None and archive is not None and not done.lost:
            archive.save(path, done.value)
            self._own[done.job.key] = None
            return replace(done, value=archive.without_bulk(done.value))
        self._own[done.job.key] = done
        return done

    def get(self, job: Job) -> Done | None:
        """Return the answer of a job, None where it is not known."""
        answer = self._own.get(job.key)
        path = self.path(job)
        if answer is not None or path is None or job.archive is None:
            return answer
        if not path.exists() or not (self._resume or job.key in self._own):
            return None
        try:
            value = job.archive.load(path)
        except ResultsError:
            return None
        return Done(job, value) if job.key in self._own or job.archive.is_final(value) else None


def solve_job(task: Task, work: Callable[[Task], Any]) -> Job:
    """Return a solve as a job of a campaign."""
    memory = solver_of(task).memory(task)
    return Job(task.key, work, (task,), memory, Kind.of(task), SOLUTION)


def curves_of(task: Task) -> Solution:
    """Solve a task for its curves: once, and with fields only where a pressure is compared."""
    solution = execute(task, repeats=1)
    if not task.wants_pressure:
        solution.fields.clear()
    return solution


def curve_job(task: Task) -> Job:
    """Return a solve for its curves as a job."""
    quantities = tuple(sorted(ALWAYS.union(task.quantities)))
    job = solve_job(replace(task, with_body=False, quantities=quantities), curves_of)
    return replace(job, kind=replace(job.kind, timed=False))


def value_of(done: Done) -> Any:
    """Return the answer of a job; LostWorkError where there is none."""
    if done.lost:
        raise LostWorkError(done.lost)
    return done.value


def solve_blocks(tasks: Sequence[Task]) -> Solution:
    """Solve the blocks of realisations of one method at one resolution as one solution."""
    return Solution.concat([execute(task) for task in tasks], axis=REALISATIONS)
