"""A study: plans in, a results folder out. Killed, it resumes; interrupted, it keeps its work."""

from __future__ import annotations

import datetime
import time
from collections.abc import Callable, Generator, Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from comparisons.errors import LostWorkError, ResultsError
from comparisons.judging.refinement import refinements
from comparisons.machine import machine, source_digest, versions
from comparisons.methods.registry import solver_of
from comparisons.results.folder import open_folder
from comparisons.results.record import record_scene
from comparisons.results.store import FIELDS, STUDY, SceneRecord, StudyRecord, save_study
from comparisons.results.study_checks import parse_study
from comparisons.results.vtu import write_fields
from comparisons.solving.compilation import compile_apart
from comparisons.solving.execution import THREADS, execute
from comparisons.solving.executors import Done, Executor, Job, executor_for
from comparisons.solving.forecast import Forecast, Remaining
from comparisons.solving.planning import Plan
from comparisons.tasks.archive import load_solution, save_solution
from comparisons.tasks.solution import REALISATIONS, Solution, Solved
from comparisons.tasks.task import Task

Progress = Callable[[int, int, Task | None], None]
# A part of a study that several machines share: which one, of how many.
Part = tuple[int, int]
WHOLE: Part = (1, 1)


@dataclass
class Study:
    """All plans of a run, and where the results go.

    Parameters
    ----------
    plans : list of Plan
    directory : Path
        Created when the run starts. A folder with results needs `resume` or `overwrite`.
    command : str
        The command line, for the report.
    effort : str
        "quick" or "full".
    workers : int
        Processes; each solves on one thread.
    resume, overwrite : bool
        Go on with what is there; or start anew.
    progress : callable, optional
        Called with (done, total, task just finished).
    executor : Executor, optional
        Carries out the solves; default: `workers` processes here.
    part : (int, int)
        Solve only part K of N of the tasks; the folders of all parts are merged afterwards.
    watch : callable, optional
        Called with the study and the task just finished (None at the start): a watcher asks for
        `remaining` and `so_far`.
    """

    plans: list[Plan]
    directory: Path
    command: str = ""
    effort: str = "quick"
    workers: int = 1
    resume: bool = False
    overwrite: bool = False
    progress: Progress | None = None
    executor: Executor | None = None
    part: Part = WHOLE
    watch: Callable[[Study, Task | None], None] | None = None
    _solutions: dict[str, Solution] = field(default_factory=dict)
    _asked: dict[str, tuple[Task, int]] = field(default_factory=dict)
    _missing: dict[int, set[str]] = field(default_factory=dict)
    _refining: dict[int, Generator[Plan, None, Plan]] = field(default_factory=dict)
    _forecast: Forecast = field(default_factory=Forecast)
    _workers: int = 1
    _merged: tuple[dict[str, Any], ...] = ()
    _created: str = field(
        default_factory=lambda: (
            datetime.datetime.now(datetime.UTC).astimezone().isoformat(timespec="seconds")
        )
    )

    def run(self) -> StudyRecord:
        """Solve what is not solved yet, compare, and write the folder.

        Raises
        ------
        ResultsError
            If the folder is used and neither `resume` nor `overwrite` was said.
        KeyboardInterrupt, LostWorkError
            After writing what was done.
        """
        start, spent = time.perf_counter(), 0.0
        executor = self.executor or executor_for(self.workers)
        names = [plan.scene.name for plan in self.plans]
        open_folder(self.directory, names, resume=self.resume, overwrite=self.overwrite)
        if self.resume and (self.directory / STUDY).exists():
            document = parse_study((self.directory / STUDY).read_text(encoding="utf-8"))
            self._merged = tuple(document.get("runs", ()))
            spent = float(document["seconds"])
        else:
            # Killed before its end, a run leaves a folder that says so, and that is known as ours.
            save_study(self._record(0.0, scenes=(), interrupted=True))
        interrupted: KeyboardInterrupt | LostWorkError | None = None
        try:
            self._solve(executor)
        except (KeyboardInterrupt, LostWorkError) as error:
            interrupted = error
        seconds = spent + time.perf_counter() - start
        record = self.record(seconds, interrupted=interrupted is not None)
        save_study(record)
        if interrupted is not None:
            raise interrupted
        return record

    def record(self, seconds: float, *, interrupted: bool = False) -> StudyRecord:
        """Compare what is solved, and return it as it is written."""
        begun = [
            plan
            for plan in self.plans
            if self._is_part or any(task.key in self._solutions for task in plan.tasks)
        ]
        scenes = [self._scene_record(plan) for plan in begun]
        return self._record(seconds, tuple(scenes), interrupted=interrupted)

    def _record(
        self, seconds: float, scenes: tuple[SceneRecord, ...], *, interrupted: bool
    ) -> StudyRecord:
        return StudyRecord(
            directory=self.directory,
            created=self._created,
            command=self.command,
            effort=self.effort,
            seconds=seconds,
            machine=machine(THREADS),
            versions=versions(),
            scenes=scenes,
            interrupted=interrupted,
            source=source_digest(),
            part=f"{self.part[0]}/{self.part[1]}" if self._is_part else "",
            runs=self._merged,
        )

    def lost(self) -> list[tuple[Task, str]]:
        """Return the planned solves that have no complete answer, with the first reason."""
        missing = []
        for task in self._own_tasks():
            solution = self._solutions.get(task.key)
            if solution is None:
                missing.append((task, "not done"))
            elif not solution.converged.all():
                missing.append((task, next(iter(solution.reasons.values()), "no answer")))
        return missing

    @property
    def counts(self) -> tuple[int, int]:
        """How many tasks are done, and how many there are so far: refinements add some."""
        return len(self._solutions), len(self._asked)

    def remaining(self) -> Remaining:
        """Return how long the rest takes, by the measured costs of like tasks."""
        open_tasks = [task for key, (task, _) in self._asked.items() if key not in self._solutions]
        return self._forecast.remaining(open_tasks, self._workers)

    def so_far(self, task: Task) -> SceneRecord:
        """Compare what is solved so far of the scene of a task."""
        (plan,) = [each for each in self.plans if each.scene.name == task.scene.name]
        return record_scene(plan, self.solved(plan))

    def solution(self, task: Task) -> Solution | None:
        """Return what was found for a task, None where it is not done."""
        return self._solutions.get(task.key)

    def adopt(self, solutions: Iterable[tuple[Task, Solution]]) -> None:
        """Take solutions from elsewhere for tasks of the plans, and write them into the folder."""
        for task, solution in solutions:
            save_solution(self._path(task), solution)
            self._solutions[task.key] = solution

    @property
    def _is_part(self) -> bool:
        return self.part[1] > 1

    def _own_tasks(self) -> Iterator[Task]:
        """Yield the tasks of this part, each scene's in the order of its plan."""
        number, parts = self.part
        for index, task in enumerate(task for plan in self.plans for task in plan.tasks):
            if index % parts == number - 1:
                yield task

    def _solve(self, executor: Executor) -> None:
        """Solve all plans; one whose tasks are done is refined while the others go on."""
        self._workers = executor.workers
        own = {task.key for task in self._own_tasks()}
        for index, plan in enumerate(self.plans):
            self._missing[index] = set()
            if self.effort == "full" and not self._is_part:
                self._refining[index] = refinements(plan, self.solved)
            self._ask(index, executor, [task for task in plan.tasks if task.key in own])
        self._report(None)
        for index in range(len(self.plans)):
            self._go_on(index, executor)
        for done in executor.finished():
            task, index = self._asked[done.job.key]
            self._keep(task, done)
            self._missing[index].discard(task.key)
            self._report(task)
            self._go_on(index, executor)
            self._workers = executor.workers

    def _ask(self, index: int, executor: Executor, tasks: Iterable[Task]) -> None:
        """Restore what is in the folder, and let the rest be solved."""
        for task in tasks:
            if task.key in self._asked:
                continue
            self._asked[task.key] = (task, index)
            if not self._restore(task):
                self._missing[index].add(task.key)
                memory = solver_of(task).memory(task)
                executor.add([Job(task.key, solve_task, (task,), memory)])

    def _go_on(self, index: int, executor: Executor) -> None:
        """Refine the truth of a scene whose tasks are all done, as long as nothing is to solve."""
        while not self._missing[index] and index in self._refining:
            try:
                self.plans[index] = next(self._refining[index])
            except StopIteration as end:
                self.plans[index] = end.value
                del self._refining[index]
            else:
                self._ask(index, executor, self.plans[index].tasks)

    def _keep(self, task: Task, done: Done) -> None:
        solution = Solution.lost(task, done.lost) if done.lost else done.value
        save_solution(self._path(task), solution)
        self._solutions[task.key] = solution
        self._forecast.learn(task, done.seconds - solution.compile_seconds)

    def _restore(self, task: Task) -> bool:
        """Take a solution from the folder if a whole one is there.

        One without a single answer is tried again: what broke it may have been mended.
        """
        path = self._path(task)
        if not self.resume or not path.exists():
            return False
        try:
            solution = load_solution(path)
        except ResultsError:
            return False
        if solution.converged.any():
            self._solutions[task.key] = solution
        return task.key in self._solutions

    def _path(self, task: Task) -> Path:
        return self.directory / FIELDS / f"{task.key}.npz"

    def _report(self, task: Task | None) -> None:
        if self.progress is not None:
            self.progress(*self.counts, task)
        if self.watch is not None:
            self.watch(self, task)

    def solved(self, plan: Plan) -> Solved:
        """Return the solutions of a plan whose blocks of realisations are all done."""
        blocks: dict[tuple[str, int], list[Solution | None]] = {}
        for task in plan.tasks:
            done = self._solutions.get(task.key)
            blocks.setdefault((task.method, task.resolution), []).append(done)
        solved: Solved = {}
        for planned, parts in blocks.items():
            complete = [part for part in parts if part is not None]
            if len(complete) == len(parts):
                solved[planned] = Solution.concat(complete, axis=REALISATIONS)
        return solved

    def _scene_record(self, plan: Plan) -> SceneRecord:
        fields = {
            (task.method, task.resolution): self._path(task)
            for task in plan.tasks
            if task.realisations[0] == 0 and task.key in self._solutions
        }
        for path in fields.values():
            write_fields(path.with_suffix(".vtu"), self._solutions[path.stem].fields)
        return record_scene(plan, self.solved(plan), fields)


def solve_task(task: Task) -> Solution:
    """Solve a task with code from the cache, so that it does not matter who compiled it.

    Fields are shown of the first surface only: those of other blocks need not travel.
    """
    apart = compile_apart(task)
    solution = execute(task)
    solution.compile_seconds += apart
    if task.realisations[0] > 0:
        solution.fields.clear()
    return solution
