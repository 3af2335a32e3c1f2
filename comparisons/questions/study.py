"""A study: plans solved into a results folder; completed work survives interrupts and kills."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Unpack

import numpy as np

from comparisons.errors import ResultsError
from comparisons.facts.methods import METHODS
from comparisons.files import write_arrays
from comparisons.judging.refinement import enlarged, expected, refinements
from comparisons.judging.verdicts import of_steps, step_at
from comparisons.machine import source_digest
from comparisons.questions.campaign import WHOLE, Campaign, Options, Part, part_text
from comparisons.results import store
from comparisons.results.folder import MAILED, PAGE, Header, Layout, Run
from comparisons.results.record import FIELDS_FOLDER, StudyRecord
from comparisons.results.recording import record_scene
from comparisons.solving.execution import compile_ahead, compile_apart, execute
from comparisons.solving.inquiries import SOLUTION, Inquiry, solve_job
from comparisons.solving.jobs import Done, Job, JobKind, Remaining
from comparisons.solving.plan import Effort, Plan
from comparisons.tasks.shown_loads import SHOWN_ONLY, shown
from comparisons.tasks.solution import REALISATIONS, Solution, Solved, save_solution
from comparisons.tasks.task import Task

_MINUTE = 60.0  # seconds that a refined solve may be expected to take at quick effort
WITH_ALL_FIELDS = replace(SOLUTION, is_final=lambda s: SOLUTION.is_final(s) and s.whole)
SOON_SOLVED = 1.0  # seconds: a shorter solve of lines or of surfaces that no page shows is not kept


class Study(Campaign[None, StudyRecord]):
    """All plans of a run, and the folder of its results.

    Of a `part`, K of N, only these tasks are solved; the folders of all parts are merged
    afterwards. `paraview` writes the fields as VTU, too.
    """

    layout = Layout(
        store.STUDY,
        (store.RESULTS, store.MEASURES, store.DISTRIBUTIONS, store.TO_TAKE, PAGE, MAILED),
        FIELDS_FOLDER,
    )

    def __init__(
        self,
        plans: list[Plan],
        directory: Path,
        *,
        part: Part = WHOLE,
        paraview: bool = False,
        **options: Unpack[Options],
    ) -> None:
        super().__init__(directory, **options)
        self.plans, self.part, self.paraview = plans, part, paraview
        self._solutions: dict[str, Solution] = {}
        self.merged: tuple[Run, ...] = ()  # the runs that the solutions are from
        self._begun = False
        # Scenes whose numbers of surfaces are not chosen yet, and what these will add.
        self._expected: dict[int, list[JobKind]] = {}
        self._own: dict[str, Task] = {}  # tasks of this part that were asked for

    def inquiries(self) -> dict[str, Inquiry[None]]:
        """Return one inquiry per plan; completed plans are refined while others are solved.

        An inquiry only says what to solve next: the solutions come by `received`.
        """
        self._begun = True
        return {plan.scene.name: self._inquiry(k) for k, plan in enumerate(self.plans)}

    def _inquiry(self, index: int) -> Inquiry[None]:
        """Solve a plan: its first surfaces, as many as these ask for, finer grids at full effort.

        Every part of a study solves the first surfaces, so that all choose the same numbers.
        """
        plan, share = self.plans[index], slice(self.part[0] - 1, None, self.part[1])
        counted = {planned.method for planned in plan.methods if planned.numbers}
        first = [task for task in plan.tasks if task.method in counted]
        rest = [task for task in plan.tasks if task.method not in counted]
        self._expected[index] = expected(plan, self.effort)[share]
        yield self._jobs(first + rest[share])
        begun = {task.key for task in plan.tasks}
        self.plans[index] = plan = enlarged(plan, self.solved(plan), self.effort)
        del self._expected[index]
        yield self._jobs([t for t in plan.tasks if t.key not in begun][share])
        if self.effort == "quick" or self.part != WHOLE:
            return
        for finer in refinements(plan, self.solved):
            self.plans[index] = finer
            yield self._jobs([t for t in finer.tasks if t.key not in self._solutions])

    def _jobs(self, tasks: Iterable[Task]) -> list[Job]:
        jobs = {task.key: task for task in tasks}
        self._own.update(jobs)
        finest = _finest(self.plans)
        requested = []
        for task in jobs.values():
            is_finest = task.resolution == finest[task.scene.name, task.method]
            job = solve_job(task, partial(solve_task, finest=is_finest, every_field=self.paraview))
            if task.realisations[0] == 0:
                # An earlier run kept only what its pages showed: less of all but the finest grids.
                path = self._path(task)
                if self.resume and self.paraview and not path.with_suffix(".vtu").exists():
                    path.unlink(missing_ok=True)
                job = replace(job, archive=WITH_ALL_FIELDS) if is_finest else job
            requested.append(job)
        return requested

    def remaining(self) -> Remaining:
        """Return the remaining time; finer grids may follow at full effort."""
        kinds = [kind for kinds in self._expected.values() for kind in kinds]
        left = self.under_way.remaining(kinds)
        refined = self.effort == "full" and self.part == WHOLE
        may_follow = refined and any(
            plan.scene.compare.resolutions is None and plan.scene.name not in self.under_way.ended
            for plan in self.plans
        )
        return replace(left, complete=left.complete and not may_follow)

    def prepare(self) -> None:
        """Compile what the solves need before the first one, beside none of them."""
        missing = [task for key, task in self._own.items() if key not in self._solutions]
        for done in compile_ahead(missing):
            if self.watch is not None:
                self.watch(self, done)

    def received(self, done: Done) -> None:
        """Register a solution; repeatedly killed tasks have no answer at any step."""
        (task,) = done.job.arguments
        self._solutions[task.key] = Solution.lost(task, done.lost) if done.lost else done.value

    def record_of(self, header: Header, answers: Mapping[str, None]) -> StudyRecord:
        """Compare the solutions so far, and return the record to be written.

        That counts into the seconds of the run: proofs can take long. Who interrupts waits for
        none.
        """
        started = time.perf_counter()
        begun = [
            plan
            for plan in self.plans
            if (self.part != WHOLE and self._begun)
            or any(task.key in self._solutions for task in plan.tasks)
        ]
        scenes = []
        for plan in begun:
            fields = {
                (task.method, task.resolution): self._path(task)
                for task in plan.tasks
                if task.realisations[0] == 0 and task.key in self._solutions
            }
            for path in fields.values() if self.paraview else ():
                store.write_fields(path.with_suffix(".vtu"), self._solutions[path.stem].fields)
            prove = not header.interrupted
            scenes.append(record_scene(plan, self.solved(plan), fields, prove=prove))
        seconds = header.seconds + time.perf_counter() - started
        return StudyRecord(
            **header.model_dump() | {"seconds": seconds},
            directory=self.directory,
            scenes=tuple(scenes),
            source=source_digest(),
            part=part_text(self.part),
            runs=self.merged,
        )

    def save(self, record: StudyRecord) -> None:
        """Write study.json, its tables, and those to take away.

        Of a whole run lines and later surfaces are kept only where they are not soon solved again,
        and earlier loads only where a page shows them: on the finest grid of a method.
        """
        store.save_study(record)
        store.write_exports(record)
        tasks = [task for plan in self.plans for task in plan.tasks]
        if record.interrupted or not all(task.key in self._solutions for task in tasks):
            return
        finest = _finest(self.plans)
        for task in tasks:
            solution, path = self._solutions[task.key], self._path(task)
            # What was lost is kept with its reason: `merge` solves only what has no reason.
            soon = solution.seconds < SOON_SOLVED and solution.converged.all()
            if task.realisations[0] > 0:
                if soon:
                    path.unlink(missing_ok=True)
                continue
            lines = METHODS[task.method].dimension == 1 and len(task.realisations) > 1
            thinned = task.resolution < finest[task.scene.name, task.method] and solution.whole
            if thinned:
                solution = without_shown_only(solution)
            if soon and lines:
                write_arrays(path, solution.fields)
            elif thinned and path.exists():  # none of what was lost
                save_solution(path, solution)

    def seconds_before(self) -> float:
        """Return the seconds of the resumed run; ResultsError if scenes would be dropped."""
        record = store.read_study(self.directory)
        dropped = {scene.name for scene in record.scenes} - {p.scene.name for p in self.plans}
        if dropped:
            raise ResultsError(
                f"{self.directory} has results of {', '.join(sorted(dropped))}: include these "
                "scenes, or choose another --out"
            )
        self.merged = record.runs
        return record.seconds

    def lost(self) -> list[tuple[Task, str]]:
        """Return the planned solves without a complete answer, with the first reason."""
        missing = []
        everything = {task.key: task for plan in self.plans for task in plan.tasks}
        for task in (self._own if self._begun else everything).values():
            solution = self._solutions.get(task.key)
            if solution is None:
                missing.append((task, "not done"))
            elif not (answered := solution.answered).all():
                step, row = map(int, np.argwhere(~answered.T)[0])
                reason = solution.reasons.get((row, step), "no answer")
                lost, axis = np.asarray(~answered.all(axis=0)), task.loads.axis
                if not lost.all():
                    first = f"the first is {step_at(axis)} {step + 1}"
                    reason = f"{of_steps(lost, axis)}, {first}: {reason}"
                missing.append((task, reason))
        return missing

    def solution(self, task: Task) -> Solution | None:
        """Return the solution of a task, or None if it is not done."""
        return self._solutions.get(task.key)

    def adopt(self, solutions: Iterable[tuple[Task, Solution]]) -> None:
        """Adopt existing solutions of planned tasks, and write them into the folder."""
        for task, solution in solutions:
            save_solution(self._path(task), solution)
            self._solutions[task.key] = solution

    def _path(self, task: Task) -> Path:
        return self.directory / FIELDS_FOLDER / f"{task.key}.npz"

    def solved(self, plan: Plan) -> Solved:
        """Return the solutions of a plan for which all blocks of realisations are done."""
        return _joined(plan, self._solutions)


def solved_in_memory(
    plan: Plan, effort: Effort, enough: Callable[[Plan, Solved], bool] | None = None
) -> tuple[Plan, Solved]:
    """Solve a plan here as a study would, and return it with the surfaces and grids of the end.

    With `enough` the grids of the truth are refined at quick effort, too, until it says so or the
    next would take more than a minute.
    """
    solutions: dict[str, Solution] = {}

    def solved(wider: Plan) -> Solved:
        for task in wider.tasks:
            if task.key not in solutions:
                solutions[task.key] = solve_task(task)
        return _joined(wider, solutions)

    plan = enlarged(plan, solved(plan), effort)
    if effort == "full" or enough is not None:
        full = effort == "full"
        steps = refinements(plan, solved) if full else refinements(plan, solved, _MINUTE, enough)
        for finer in steps:
            plan = finer
            solved(plan)
    return plan, solved(plan)


def _finest(plans: Iterable[Plan]) -> dict[tuple[str, str], int]:
    return {
        (plan.scene.name, planned.method): max(planned.resolutions, default=0)
        for plan in plans
        for planned in plan.methods
    }


def _joined(plan: Plan, solutions: Mapping[str, Solution]) -> Solved:
    """Return the solutions of the settings all of whose blocks of realisations have one."""
    return {
        setting: Solution.concat([solutions[task.key] for task in tasks], axis=REALISATIONS)
        for setting, tasks in plan.settings.items()
        if all(task.key in solutions for task in tasks)
    }


def solve_task(task: Task, *, finest: bool = True, every_field: bool = False) -> Solution:
    """Solve a task with cached code, so that the compiling process does not matter.

    Fields are transferred of the first surface; those in the body and of earlier loads of the
    `finest` grid of a method; what no page shows of it only where ParaView asks for `every_field`.
    """
    if not (finest or every_field):
        task = replace(task, with_body=False)
    apart = compile_apart(task)
    # The time of an ensemble is measured on its first surfaces again and again, on the rest once.
    first = task.realisations[0] == 0
    solution = execute(task) if first else execute(task, repeats=1)
    solution.compile_seconds += apart
    solution.fields = shown(solution.fields, all_of_them=every_field) if first else {}
    return solution if finest or every_field else without_shown_only(solution)


def without_shown_only(solution: Solution) -> Solution:
    """Return a solution without the fields that pages show of the finest grid alone."""
    fields = {n: v for n, v in solution.fields.items() if not n.startswith(SHOWN_ONLY)}
    return replace(solution, fields=fields, whole=False)
