"""Merging of runs from several machines: parts of the realisations, other methods or scenes."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from comparisons.errors import InputError, ResultsError
from comparisons.facts.methods import METHODS, NOT_ASKED
from comparisons.judging.refinement import refinements
from comparisons.machine import source_digest, versions
from comparisons.questions.study import Study, solve_task
from comparisons.results.folder import filled
from comparisons.results.runs import MOVED
from comparisons.results.selection import setting_rows
from comparisons.results.store import FIELDS, STUDY, Run, StudyRecord, load_study
from comparisons.scene.scene import Scene, parse_scene, validated
from comparisons.solving.plan import Plan
from comparisons.solving.plan_record import MethodPlan
from comparisons.solving.planning import plan_from
from comparisons.tasks.archive import load_solution
from comparisons.tasks.solution import Solution
from comparisons.tasks.task import Task

# Keys that may differ between the scenes of two runs: methods and resolutions.
FREE = ("methods", "resolutions")
NOT_REFINED = "full: merged runs are not refined; continue with roughline run --full --resume"
_Solve = tuple[str, str, int, tuple[int, ...]]


@dataclass
class _Merge:
    """Solutions of the runs by scene, and all reasons against merging them."""

    plans: dict[str, list[Plan]] = field(default_factory=dict)
    solutions: dict[_Solve, tuple[str, Solution]] = field(default_factory=dict)
    conflicts: list[str] = field(default_factory=list)


def merge(directories: Iterable[Path], out: Path, command: str = "", files: Path = Path()) -> Study:
    """Write a results folder with the solutions of several runs.

    The runs must be from the same version of roughline and of its packages as installed here. A
    solve in two runs must have the same values in both (to 1e-5, the tolerance of iterations).

    Parameters
    ----------
    directories : iterable of Path
        Folders written by `roughline run`, complete or not.
    out : Path
        A new or empty folder. It appears once it is complete.
    command : str
        The command line, for the report.
    files : Path
        Folder of the files (maps, meshes) named in the scenes.

    Returns
    -------
    Study
        The merged study; `lost` lists solves missing from all runs.

    Raises
    ------
    InputError
        Lists all differences and errors.
    """
    with filled(out, STUDY) as folder:
        runs = [load_study(path) for path in directories]
        problems = list(_unlike(runs))
        if problems:
            raise InputError("\n  ".join(["these runs cannot be merged:", *problems]))
        merged = _Merge()
        for run in runs:
            _gather(run, files, merged)
        plans = [_merged(name, plans, merged.conflicts) for name, plans in merged.plans.items()]
        if merged.conflicts:
            raise InputError("\n  ".join(["these runs contradict each other:", *merged.conflicts]))
        study = Study([p for p in plans if p is not None], folder, command=command)
        study.effort = "full" if runs[0].effort == "full" else "quick"
        _write(study, merged, runs)
    study.directory = out
    return study


def _unlike(runs: list[StudyRecord]) -> Iterator[str]:
    """Yield the differences between entire runs."""
    if len(runs) < 2:
        yield f"expected two runs or more, got {len(runs)}"
    places = [run.directory.resolve() for run in runs]
    for run in runs:
        if places.count(run.directory.resolve()) > 1:
            yield f"{run.directory}: named more than once"
        if not run.scenes:
            yield f"{run.directory}: ended before it was written; --resume finishes it"
        yield from other_versions(run.directory, run.versions, run.source)
        if run.effort != runs[0].effort:
            yield f"{run.directory}: a {run.effort} run, the first one is {runs[0].effort}"


def other_versions(directory: Path, packages: Mapping[str, str], source: str) -> Iterator[str]:
    """Yield the packages, and the source of roughline, of a run that are not those here."""
    run_versions = {**packages, "roughline's source": source or "not recorded"}
    own_versions = versions() | {"roughline's source": source_digest()}
    for name in dict.fromkeys([*own_versions, *run_versions]):
        pair = [release.get(name, "nothing")[:12] for release in (run_versions, own_versions)]
        if pair[0] != pair[1]:
            yield f"{directory}: {name}: {pair[0]}, here {pair[1]}"


def _gather(run: StudyRecord, files: Path, merged: _Merge) -> None:
    """Read the plans of a run and all its complete solutions."""
    for record in run.scenes:
        scene = parse_scene(record.text, f"{run.directory}: {record.name}", files.resolve())
        plan = plan_from(scene, record.plan, run.effort)
        merged.plans.setdefault(record.name, []).append(plan)
        for task in plan.tasks:
            try:
                solution = load_solution(run.directory / FIELDS / f"{task.key}.npz")
            except ResultsError:
                rows = setting_rows(record, task.method, task.resolution)
                if run.part or run.interrupted or not len(rows) or not rows["converged"].all():
                    continue  # in another run, or lost, which is reported at the end
                solution = solve_task(task)  # it was not kept, because that is soon done
            _add(task, solution, str(run.directory), merged)


def _add(task: Task, solution: Solution, run: str, merged: _Merge) -> None:
    key = _solve(task)
    where, first = merged.solutions.setdefault(key, (run, solution))
    if first is solution:
        return
    if solution.converged.sum() > first.converged.sum():
        merged.solutions[key] = run, solution
    change = _difference(first, solution)
    if change > MOVED:
        merged.conflicts.append(
            f"{task.scene.name}, {task.method} {task.resolution}, realisations from "
            f"{task.realisations[0]}: {where} and {run} differ by {change:.1e}"
        )


def _solve(task: Task) -> _Solve:
    return task.scene.name, task.method, task.resolution, task.realisations


def _difference(first: Solution, second: Solution) -> float:
    """Return the largest difference of a quantity, relative to its largest value."""
    both = first.converged & second.converged
    most = 0.0
    for name in set(first.quantities) & set(second.quantities):
        a, b = first.quantities[name][both], second.quantities[name][both]
        size = np.abs(a).max(initial=0.0)
        if size > 0:
            most = max(most, float(np.abs(a - b).max() / size))
    return most


def _merged(name: str, plans: list[Plan], conflicts: list[str]) -> Plan | None:
    """Return one plan with all methods and resolutions of the plans of a scene."""
    scene = _scene(name, [plan.scene for plan in plans], conflicts)
    if scene is None:
        return None
    methods = [
        _method([m for plan in plans for m in plan.methods if m.method == method])
        for method in METHODS
        if any(m.method == method for plan in plans for m in plan.methods)
    ]
    return replace(
        plans[0],
        scene=scene,
        methods=tuple(methods),
        left_out=tuple(dict.fromkeys(effect for plan in plans for effect in plan.left_out)),
        notes=tuple(dict.fromkeys(note for plan in plans for note in plan.notes)),
        switched_on=tuple(dict.fromkeys(physics for plan in plans for physics in plan.switched_on)),
    )


def _scene(name: str, scenes: list[Scene], conflicts: list[str]) -> Scene | None:
    """Return the scene with all compared quantities, and register conflicts between the scenes."""
    options: dict[str, Any] = {}
    for scene in scenes:
        same = _fixed(scene) == _fixed(scenes[0])
        chosen = scene.methods.model_dump(exclude_defaults=True)
        clash = [key for key in chosen if options.setdefault(key, chosen[key]) != chosen[key]]
        if not same:
            conflicts.append(f"{name}: the scenes differ in more than methods and resolutions")
        if clash:
            conflicts.append(f"{name}: other options of {', '.join(clash)}")
        if not same or clash:
            return None
    compare = scenes[0].compare
    for key in FREE:
        choices = [getattr(scene.compare, key) for scene in scenes]
        union = tuple(dict.fromkeys(v for choice in choices if choice is not None for v in choice))
        ordered = tuple(sorted(union)) if key == "resolutions" else union
        compare = compare.model_copy(update={key: None if None in choices else ordered})
    tables = scenes[0].model_dump(exclude_none=True, exclude_defaults=True)
    tables |= {"compare": compare.model_dump(exclude_none=True, exclude_defaults=True)}
    tables |= {"methods": options, "directory": scenes[0].directory}
    return validated({name: table for name, table in tables.items() if table != {}})


def _fixed(scene: Scene) -> dict[str, Any]:
    """Return the keys of a scene that must be the same in all runs."""
    return scene.model_dump(mode="json", exclude={"compare": set(FREE), "methods": True})


def _method(plans: list[MethodPlan]) -> MethodPlan:
    done = [method for method in plans if method.supported]
    if not done:
        return next((method for method in plans if method.reason != NOT_ASKED), plans[0])
    levels = tuple(sorted({n for method in done for n in method.resolutions}))
    numbers = {
        level: number
        for method in done
        for level, number in zip(method.resolutions, method.numbers, strict=False)
    }
    counted = tuple(numbers[level] for level in levels) if set(numbers) == set(levels) else ()
    return replace(done[0], resolutions=levels, numbers=counted)


def _settled(plan: Plan, study: Study) -> Plan:
    """Return the plan with the notes of a complete run on the refinement of its reference."""
    if any(study.solution(task) is None for task in plan.tasks):
        return plan
    try:
        next(refinements(plan, study.solved))
    except StopIteration as end:
        final: Plan = end.value
        return replace(final, notes=tuple(dict.fromkeys(final.notes)))
    return replace(plan, notes=(*plan.notes, NOT_REFINED))


def _write(study: Study, merged: _Merge, runs: list[StudyRecord]) -> None:
    tasks = [task for plan in study.plans for task in plan.tasks]
    study.adopt((t, merged.solutions[_solve(t)][1]) for t in tasks if _solve(t) in merged.solutions)
    started = time.perf_counter()
    if study.effort == "full":
        study.plans = [_settled(plan, study) for plan in study.plans]
    spent = sum(run.seconds for run in runs)
    record = study.record(spent)
    parts: list[Run] = []
    for run in runs:
        parts += run.runs or [Run(run.created, run.command, run.seconds, run.machine)]
    seconds = spent + time.perf_counter() - started
    # An interrupted run lists only the scenes that it had started; there may be more.
    interrupted = any(run.interrupted for run in runs)
    study.save(replace(record, seconds=seconds, runs=tuple(parts), interrupted=interrupted))
