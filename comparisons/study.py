"""A study: plans in, a results folder out. Killed, it resumes; interrupted, it keeps its work."""

from __future__ import annotations

import datetime
import re
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

from joblib import Parallel, delayed

from comparisons.archive import joined, load_solution, save_solution
from comparisons.execution import THREADS, execute
from comparisons.machine import machine, versions
from comparisons.methods import Solution, Task
from comparisons.methods.external import adopt, announced
from comparisons.planning import Plan
from comparisons.record import record_scene
from comparisons.reference import Solved
from comparisons.refinement import refined
from comparisons.store import (
    FIELDS,
    MEASURES,
    RESULTS,
    STUDY,
    ResultsError,
    SceneRecord,
    StudyRecord,
    load_study,
    save_study,
)
from comparisons.vtu import write_fields

# Names that tasks give to their files; nothing else in a folder is ours to delete.
OWN_FILE = re.compile(r"[a-z0-9-]+-[a-z_0-9]+-\d+-\d+-[0-9a-f]{12}\.(npz|vtu)")
Progress = Callable[[int, int, Task | None], None]


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
    """

    plans: list[Plan]
    directory: Path
    command: str = ""
    effort: str = "quick"
    workers: int = 1
    resume: bool = False
    overwrite: bool = False
    progress: Progress | None = None
    _solutions: dict[str, Solution] = field(default_factory=dict)

    def run(self) -> StudyRecord:
        """Solve what is not solved yet, compare, and write the folder.

        Raises
        ------
        ResultsError
            If the folder is used and neither `resume` nor `overwrite` was said.
        KeyboardInterrupt
            After writing what was done.
        """
        start = time.perf_counter()
        created = datetime.datetime.now(datetime.UTC).astimezone().isoformat(timespec="seconds")
        self._open_directory()
        interrupted: KeyboardInterrupt | None = None
        try:
            self._solve(self.plans)
            if self.effort == "full":
                for index, plan in enumerate(self.plans):
                    self.plans[index] = refined(
                        plan, self._solved, lambda each: self._solve([each])
                    )
        except KeyboardInterrupt as error:
            interrupted = error
        record = StudyRecord(
            directory=self.directory,
            created=created,
            command=self.command,
            effort=self.effort,
            seconds=time.perf_counter() - start,
            machine=machine(THREADS),
            versions=versions(),
            scenes=tuple(self._scene_record(plan) for plan in self.plans if self._solved(plan)),
            interrupted=interrupted is not None,
        )
        save_study(record)
        if interrupted is not None:
            raise interrupted
        return record

    def lost(self) -> list[tuple[Task, str]]:
        """Return the planned solves that have no complete answer, with the first reason."""
        missing = []
        for plan in self.plans:
            for task in plan.tasks:
                solution = self._solutions.get(task.key)
                if solution is None:
                    missing.append((task, "not done"))
                elif not solution.converged.all():
                    missing.append((task, next(iter(solution.reasons.values()), "no answer")))
        return missing

    def _open_directory(self) -> None:
        if self.directory.exists() and not self.directory.is_dir():
            raise ResultsError(f"{self.directory}: expected a folder for the results, got a file")
        if self.resume and self.overwrite:
            raise ResultsError("--resume and --overwrite: expected at most one of them")
        used = self.directory.exists() and any(self.directory.iterdir())
        if used and not (self.resume or self.overwrite):
            raise ResultsError(
                f"{self.directory} is in use: say --resume to go on with it, --overwrite to start "
                "anew, or --out for another folder"
            )
        if used:
            self._check_ownership()
        fields = self.directory / FIELDS
        fields.mkdir(parents=True, exist_ok=True)
        if self.overwrite:
            for old in fields.iterdir():
                if OWN_FILE.fullmatch(old.name):
                    old.unlink()

    def _check_ownership(self) -> None:
        """Refuse folders that are not ours, and a resume that would drop other scenes."""
        fields, study = self.directory / FIELDS, self.directory / STUDY
        if fields.is_symlink():
            raise ResultsError(f"{fields}: expected a folder, got a link to elsewhere")
        names = (RESULTS, MEASURES, "report.html")
        foreign = [name for name in names if (self.directory / name).exists()]
        if foreign and not study.exists():
            raise ResultsError(
                f"{self.directory} has {', '.join(foreign)} that roughline has not written"
            )
        if not (self.resume and study.exists()):
            return
        kept = {scene.name for scene in load_study(self.directory).scenes}
        dropped = kept - {plan.scene.name for plan in self.plans}
        if dropped:
            raise ResultsError(
                f"{self.directory} has results of {', '.join(sorted(dropped))}: name these scenes "
                "too, or choose another --out"
            )

    def _solve(self, plans: list[Plan]) -> None:
        tasks = [task for plan in plans for task in plan.tasks]
        tasks = [task for task in tasks if task.key not in self._solutions]
        todo = [task for task in tasks if not self._restore(task)]
        done = len(tasks) - len(todo)
        self._report(done, len(tasks), None)
        for task, solution in self._executed(todo):
            save_solution(self._path(task), solution)
            self._solutions[task.key] = solution
            done += 1
            self._report(done, len(tasks), task)

    def _executed(self, todo: list[Task]) -> Iterator[tuple[Task, Solution]]:
        if self.workers == 1:
            yield from ((task, execute(task)) for task in todo)
            return
        pool = Parallel(n_jobs=self.workers, return_as="generator_unordered", batch_size=1)
        yield from pool(delayed(_with_task)(task, announced()) for task in todo)

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

    def _report(self, done: int, total: int, task: Task | None) -> None:
        if self.progress is not None:
            self.progress(done, total, task)

    def _solved(self, plan: Plan) -> Solved:
        """Return the solutions of a plan whose blocks of realisations are all done."""
        blocks: dict[tuple[str, int], list[Solution | None]] = {}
        for task in plan.tasks:
            done = self._solutions.get(task.key)
            blocks.setdefault((task.method, task.resolution), []).append(done)
        solved: Solved = {}
        for planned, parts in blocks.items():
            complete = [part for part in parts if part is not None]
            if len(complete) == len(parts):
                solved[planned] = joined(complete)
        return solved

    def _scene_record(self, plan: Plan) -> SceneRecord:
        fields = {
            (task.method, task.resolution): self._path(task)
            for task in plan.tasks
            if task.realisations[0] == 0 and task.key in self._solutions
        }
        for path in fields.values():
            write_fields(path.with_suffix(".vtu"), self._solutions[path.stem].fields)
        return record_scene(plan, self._solved(plan), fields)


def _with_task(task: Task, methods: str) -> tuple[Task, Solution]:
    adopt(methods)
    return task, execute(task)
