"""Merging of runs from several machines: the union of their answers by key.

Runs of a study bring parts of the realisations, other methods or scenes; runs of an ensemble bring
files of surfaces. All must be from the same version of roughline and of its packages as here.
"""

from __future__ import annotations

import os
import shutil
import time
from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from comparisons.errors import InputError, ResultsError
from comparisons.facts.methods import METHODS, NOT_ASKED
from comparisons.judging.refinement import refinements
from comparisons.machine import source_digest, versions
from comparisons.questions.ensemble import Ensemble
from comparisons.questions.study import Study, solve_task
from comparisons.results import ensemble_folder as ensembles
from comparisons.results.folder import Header, PartHeader, Run, filled
from comparisons.results.record import FIELDS_FOLDER, SceneRecord, StudyRecord
from comparisons.results.run_comparison import MOVED
from comparisons.results.store import STUDY, load_study
from comparisons.scene.scene import Scene, parse_scene, validated
from comparisons.solving.cluster import differences
from comparisons.solving.plan import Plan
from comparisons.solving.planning import plan_from
from comparisons.tasks.solution import Solution, load_solution
from comparisons.tasks.task import Task

# Keys that may differ between the scenes of two runs: methods and resolutions.
FREE = ("methods", "resolutions")
NOT_REFINED = "full: merged runs are not refined; continue with roughline run --full --resume"


def merge(directories: Iterable[Path], out: Path, command: str = "", files: Path = Path()) -> Study:
    """Write a new or empty folder with the solutions of several runs, complete or not.

    A solve in two runs must have the same values in both (`MOVED`); what no run has, `Study.lost`
    lists. `files` has the maps and meshes that scenes name. InputError lists all differences.
    """
    with filled(out, STUDY) as folder:
        runs = [load_study(path) for path in directories]
        _refuse("these runs cannot be merged:", _unlike(runs))
        plans: dict[str, list[Plan]] = {}
        answers: dict[str, tuple[StudyRecord, Solution]] = {}
        conflicts: list[str] = []
        for run in runs:
            for record in run.scenes:
                scene = parse_scene(record.text, f"{run.directory}: {record.name}", files.resolve())
                plan = plan_from(scene, record.plan, run.effort)
                plans.setdefault(record.name, []).append(plan)
                for task in plan.tasks:
                    solution = _kept(run, record, task)
                    if solution is None:
                        continue
                    other, first = answers.setdefault(task.key, (run, solution))
                    if solution.converged.sum() > first.converged.sum():
                        answers[task.key] = run, solution
                    change = _difference(first, solution)
                    if change > MOVED:
                        one_sided = "; a value is known to one of them only"
                        conflicts.append(
                            f"{scene.name}, {task.method} {task.resolution}, realisations from "
                            f"{task.realisations[0]}: {other.directory} and {run.directory} "
                            f"differ{one_sided if change == np.inf else f' by {change:.1e}'}"
                        )
        joined = [_joined(several, conflicts) for several in plans.values()]
        _refuse("these runs contradict each other:", conflicts)
        study = Study([plan for plan in joined if plan is not None], folder, command=command)
        study.effort = "full" if runs[0].effort == "full" else "quick"
        tasks = [task for plan in study.plans for task in plan.tasks]
        study.adopt((task, answers[task.key][1]) for task in tasks if task.key in answers)
        started = time.perf_counter()
        if study.effort == "full":
            # the notes of a complete run on the refinement of its reference
            for index, plan in enumerate(study.plans):
                if any(study.solution(task) is None for task in plan.tasks):
                    continue
                final = next(refinements(plan, study.solved), plan)
                if final.methods == plan.methods:
                    notes = tuple(dict.fromkeys(final.notes))
                    study.plans[index] = replace(final, notes=notes)
                else:
                    study.plans[index] = replace(plan, notes=(*plan.notes, NOT_REFINED))
        study.merged = _parts(runs)
        spent = sum(run.seconds for run in runs) + time.perf_counter() - started
        # An interrupted run lists only the scenes that it had started; there may be more.
        interrupted = any(run.interrupted for run in runs)
        study.save(study.record(spent).model_copy(update={"interrupted": interrupted}))
    study.directory = out
    return study


def merge_ensembles(
    directories: Iterable[Path], out: Path, command: str = ""
) -> ensembles.EnsembleResult:
    """Write a folder with the surfaces of several parts; files are linked or copied as they are.

    They are of one scene, complete or not. InputError lists all differences; nothing is written
    then.
    """
    with filled(out, ensembles.RECORD) as folder:
        runs = {path: ensembles.load_ensemble(path) for path in directories}
        problems = []
        if len(runs) < 2:
            problems.append(f"expected two different folders or more, got {len(runs)}")
        first = next(iter(runs), None)
        for path, run in runs.items():
            problems += _other_versions(path, run)
            if first is not None and run.text != runs[first].text:
                problems.append(f"{path}: expected the scene and the number of surfaces of {first}")
        _refuse("these ensembles cannot be merged:", problems)
        bundles = [
            item
            for path in runs
            for several in ensembles.survey(path / ensembles.SURFACES).values()
            for item in several.items()
        ]
        bundles.sort(key=lambda item: (item[1].identity, item[1].first))
        _refuse(
            "surfaces are in more than one folder:",
            (
                f"{before} and {path}: both have surface {later.first}"
                for (before, earlier), (path, later) in pairwise(bundles)
                if earlier.identity == later.identity and later.first < earlier.end
            ),
        )
        (folder / ensembles.SURFACES).mkdir()
        for path, _ in bundles:
            target = folder / ensembles.SURFACES / path.name
            try:  # nobody changes a file in place
                os.link(path, target)
            except OSError:  # another file system
                shutil.copyfile(path, target)
        last = max(runs.values(), key=lambda run: run.created)
        header = {name: getattr(last, name) for name in Header.model_fields} | {
            "command": command,
            "seconds": sum(run.seconds for run in runs.values()),
            "interrupted": any(run.interrupted for run in runs.values()),
        }
        ensemble = Ensemble(parse_scene(last.text, last.name, Path()), folder)
        ensemble.merged = _parts(runs.values())
        merged = ensemble.record_of(Header(**header), {})
        ensemble.save(merged)
    return merged


def _parts(runs: Iterable[PartHeader]) -> tuple[Run, ...]:
    """Return the runs; one that was merged before is told as those that it was merged from."""
    return tuple(
        part
        for run in runs
        for part in run.runs or [Run(run.created, run.command, run.seconds, run.machine)]
    )


def _refuse(what: str, problems: Iterable[str]) -> None:
    listed = list(problems)
    if listed:
        raise InputError("\n  ".join([what, *listed]))


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
        yield from _other_versions(run.directory, run)
        if run.effort != runs[0].effort:
            yield f"{run.directory}: a {run.effort} run, the first one is {runs[0].effort}"


def _other_versions(directory: Path, run: PartHeader) -> list[str]:
    """Return the packages, and the source of roughline, of a run that are not those here."""
    theirs = {**run.versions, "roughline's source": (run.source or "not recorded")[:12]}
    ours = versions() | {"roughline's source": source_digest()[:12]}
    return [f"{directory}: {difference}" for difference in differences(ours, theirs)]


def _kept(run: StudyRecord, record: SceneRecord, task: Task) -> Solution | None:
    """Return the solution of a task in a run; None where it is in another run, or lost."""
    try:
        return load_solution(run.directory / FIELDS_FOLDER / f"{task.key}.npz")
    except ResultsError:
        rows = record.setting_rows(task.method, task.resolution)
        lost = set(rows["realisation"][~rows["converged"]]) & set(map(str, task.realisations))
        if run.part or run.interrupted or not len(rows) or lost:
            return None
        return solve_task(task)  # it was not kept, because that is soon done


def _difference(first: Solution, second: Solution) -> float:
    """Return the largest difference relative to the largest value; inf where one has no value."""
    both = first.converged & second.converged
    most = 0.0
    for name in set(first.quantities) & set(second.quantities):
        a, b = first.quantities[name][both], second.quantities[name][both]
        known = np.isfinite(a)
        if (known != np.isfinite(b)).any():
            return np.inf
        size = np.abs(a[known]).max(initial=0.0)
        if size > 0:
            most = max(most, float(np.abs(a - b)[known].max() / size))
    return most


def _joined(plans: list[Plan], conflicts: list[str]) -> Plan | None:
    """Return one plan with all methods and resolutions of the plans of a scene."""
    scene = _scene([plan.scene for plan in plans], conflicts)
    if scene is None:
        return None
    methods = []
    for name in METHODS:
        alike = [m for plan in plans for m in plan.methods if m.method == name]
        done = [method for method in alike if method.supported]
        if done:
            levels = tuple(sorted({n for method in done for n in method.resolutions}))
            numbers = {
                level: number
                for method in done
                for level, number in zip(method.resolutions, method.numbers, strict=False)
            }
            counted = tuple(numbers[n] for n in levels) if set(numbers) == set(levels) else ()
            methods.append(replace(done[0], resolutions=levels, numbers=counted))
        elif alike:
            methods.append(next((m for m in alike if m.reason != NOT_ASKED), alike[0]))
    return replace(
        plans[0],
        scene=scene,
        methods=tuple(methods),
        left_out=tuple(dict.fromkeys(effect for plan in plans for effect in plan.left_out)),
        notes=tuple(dict.fromkeys(note for plan in plans for note in plan.notes)),
        switched_on=tuple(dict.fromkeys(physics for plan in plans for physics in plan.switched_on)),
    )


def _scene(scenes: list[Scene], conflicts: list[str]) -> Scene | None:
    """Return the scene with all methods and resolutions, and register conflicts between scenes."""
    first = scenes[0]
    fixed = [
        scene.model_dump(mode="json", exclude={"compare": set(FREE), "methods": True})
        for scene in scenes
    ]
    options: dict[str, Any] = {}
    for scene, keys in zip(scenes, fixed, strict=True):
        chosen = scene.methods.model_dump(exclude_defaults=True)
        clash = [key for key in chosen if options.setdefault(key, chosen[key]) != chosen[key]]
        if keys != fixed[0]:
            conflicts.append(
                f"{first.name}: the scenes differ in more than methods and resolutions"
            )
        if clash:
            conflicts.append(f"{first.name}: other options of {', '.join(clash)}")
        if keys != fixed[0] or clash:
            return None
    compare = first.compare
    for key in FREE:
        choices = [getattr(scene.compare, key) for scene in scenes]
        union = tuple(dict.fromkeys(v for choice in choices if choice is not None for v in choice))
        ordered = tuple(sorted(union)) if key == "resolutions" else union
        compare = compare.model_copy(update={key: None if None in choices else ordered})
    tables = first.model_dump(exclude_none=True, exclude_defaults=True)
    tables |= {"compare": compare.model_dump(exclude_none=True, exclude_defaults=True)}
    tables |= {"methods": options, "directory": first.directory}
    return validated({name: table for name, table in tables.items() if table != {}})
