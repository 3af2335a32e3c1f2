"""An ensemble: very many surfaces of a scene, their curves in Parquet files, and their statistics.

Only files grow with that number, not the memory. A job solves a bundle of consecutive surfaces,
sized by the measured cost of one to take about `TASK_SECONDS`; no result depends on where bundles
are cut. Each file states its surfaces (`comparisons.results.ensemble_folder`): a resumed run solves
the others, `merge` joins the files of several runs.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Unpack

import pandas as pd

from comparisons.errors import InputError, ResultsError
from comparisons.facts.quantities import DISTRIBUTIONS, FIELDS
from comparisons.files import write_table
from comparisons.machine import source_digest
from comparisons.methods.registry import planned_solver
from comparisons.questions.campaign import WHOLE, Campaign, Options, Part, part_text
from comparisons.results import ensemble_folder as bundles
from comparisons.results.folder import Header, Layout, Run
from comparisons.scene.scene import Scene
from comparisons.solving.execution import compile_apart, execute, this_machine, warm_up
from comparisons.solving.inquiries import Inquiry, value_of
from comparisons.solving.jobs import Archive, Job, JobKind
from comparisons.solving.plan import task_of
from comparisons.solving.planning import plan_scene, single_resolution
from comparisons.tasks.solution import REALISATIONS, Solution
from comparisons.tasks.task import Task

# Seconds per bundle: much longer than its scheduling, and little is lost when one is killed.
TASK_SECONDS = 30.0
# The first job is this fraction of a block (1/5): it measures the cost of a surface.
PILOT = 5
# Least number of bundles per worker, so that all have work until the end.
LEAST_BUNDLES = 4
# Most rows of a bundle: 20 MB of curves to transfer.
MOST_ROWS = 150_000


class Ensemble(Campaign[list[bundles.Bundle], bundles.EnsembleResult]):
    """Many surfaces of one scene (its `realisations`), and the folder of their curves.

    A `part` is the Kth of N stretches of them. InputError if pyarrow is missing, or the surface of
    the scene is not random.
    """

    layout = Layout(bundles.RECORD, (bundles.TABLE,), bundles.SURFACES)

    def __init__(
        self, scene: Scene, directory: Path, *, part: Part = WHOLE, **options: Unpack[Options]
    ) -> None:
        super().__init__(directory, **options)
        bundles.parquet()
        if not scene.random:
            raise InputError(f"{scene.name}: expected a random surface, of kind self_affine")
        plan = plan_scene(scene, "full")[0]
        self.scene, self.part, self.loads = scene, part, plan.loads
        self.merged: tuple[Run, ...] = ()  # the runs that the files are from
        self.tasks: dict[str, Task] = {}
        curves = set(plan.scene.compare.quantities) - {*FIELDS, *DISTRIBUTIONS}
        for method in plan.methods:
            if not method.supported:
                continue
            levels = method.resolutions
            if plan.scene.compare.resolutions is None:  # at the surface's own points
                levels = (single_resolution(levels, plan.geometry),)
            for n in levels:
                task = replace(task_of(plan, method.method, n), quantities=tuple(sorted(curves)))
                self.tasks[f"{task.method} {task.resolution}"] = task
        if not self.tasks:
            reasons = "".join(f"\n  {m.method}: {m.reason}" for m in plan.methods)
            raise InputError(f"{scene.name}: no method can solve this scene{reasons}")
        number, parts = part
        total = scene.realisations
        self.surfaces = range((number - 1) * total // parts, number * total // parts)

    def inquiries(self) -> dict[str, Inquiry[list[bundles.Bundle]]]:
        """Return one inquiry per method and resolution."""
        return {name: self._solved(task) for name, task in self.tasks.items()}

    def _solved(self, task: Task) -> Inquiry[list[bundles.Bundle]]:
        """Solve the surfaces that no file has, a few of them first to measure their cost."""
        kept = list(
            bundles.survey(self.directory / bundles.SURFACES).get(identity(task), {}).values()
        )
        block = planned_solver(task).block(task.resolution)
        if not kept and self.surfaces:
            pilot = bundle_job(task, self.surfaces[: -(-block // PILOT)])
            done = yield [pilot]
            kept.append(value_of(done[pilot.key]))
        missing = bundles.gaps(self.surfaces, kept)
        if not missing:
            return kept
        # surfaces of a bundle: if more than a block, whole blocks
        cost = sum(bundle.seconds for bundle in kept) / sum(bundle.count for bundle in kept)
        most = MOST_ROWS // len(self.loads.values)
        even = sum(map(len, missing)) / (LEAST_BUNDLES * self.executor.workers)
        size = max(1, int(min(TASK_SECONDS / max(cost, 1e-9), most, even)))
        size = size if size < block else size // block * block
        jobs = [
            bundle_job(task, stretch[start : start + size])
            for stretch in missing
            for start in range(0, len(stretch), size)
        ]
        done = yield jobs
        return [*kept, *(value_of(done[job.key]) for job in jobs)]

    def record_of(
        self, header: Header, answers: Mapping[str, list[bundles.Bundle]]
    ) -> bundles.EnsembleResult:
        """Return the record and the statistics of all files of the folder."""
        loads = [float(load) for load in self.loads.values]
        files = bundles.survey(self.directory / bundles.SURFACES)
        settings, missing = [], []
        tables = [pd.DataFrame(columns=["method"])]
        for name, task in self.tasks.items():
            own = files.get(identity(task), {})
            if own:
                setting, table = bundles.summary(own, self.loads.control, loads)
                settings.append(setting)
                tables.append(table)
            missing += [
                f"{name}: surfaces {stretch[0]} to {stretch[-1]}"
                for stretch in bundles.gaps(self.surfaces, own.values())
            ]
        record = bundles.EnsembleRecord(
            **header.model_dump(),
            name=self.scene.name,
            text=self.scene.text,
            control=self.loads.control,
            loads=loads,
            surfaces=self.scene.realisations,
            part=part_text(self.part),
            source=source_digest(),
            missing=missing,
            settings=settings,
            runs=self.merged,
        )
        statistics = pd.concat(tables[1:] or tables, ignore_index=True)
        return bundles.EnsembleResult(record, statistics)

    def save(self, record: bundles.EnsembleResult) -> None:
        """Write ensemble.json and statistics.csv; what ends in between leaves a killed run's."""
        file = self.directory / bundles.RECORD
        record.record.model_copy(update={"interrupted": True}).write(file)
        write_table(self.directory / bundles.TABLE, record.statistics)
        record.record.write(file)

    def seconds_before(self) -> float:
        """Return the seconds of the resumed run; ResultsError if the folder holds others."""
        record = bundles.load_ensemble(self.directory)
        if record.surfaces > self.scene.realisations:
            raise ResultsError(
                f"{self.directory} holds {record.surfaces} surfaces: expected at least as many, "
                f"got {self.scene.realisations}; or choose another --out"
            )
        known = {identity(task) for task in self.tasks.values()}
        others = [s for s in record.settings if s.identity not in known]
        if others:
            names = ", ".join(f"{s.method} {s.resolution}" for s in others)
            raise ResultsError(
                f"{self.directory} has surfaces of another scene, method or version ({names}): "
                "choose another --out"
            )
        self.merged = record.runs
        return record.seconds


def identity(task: Task) -> str:
    """Name the setting of a task, whatever the number of surfaces: the key of its first one."""
    surface = task.scene.surface
    assert surface is not None
    single = surface.model_copy(update={"realisations": 1})
    scene = task.scene.model_copy(update={"surface": single})
    return replace(task, scene=scene, realisations=(0,)).key


BUNDLE = Archive(
    bundles.SUFFIX,
    bundles.write_bundle,
    bundles.read_bundle,
    lambda bundle: bool(bundle.lost < bundle.answers),
    bundles.without_curves,
)
# Bytes per load step: twenty quantities, each with the copies made on the way into a file.
_BYTES = 4 * 8 * 20


def bundle_job(task: Task, surfaces: range) -> Job:
    """Return the solve of consecutive surfaces, of which `task` is any one's, as a job."""
    solver = planned_solver(task)
    block = tuple(surfaces[: solver.block(task.resolution)])
    memory = solver.memory(replace(task, realisations=block))
    memory += _BYTES * len(surfaces) * len(task.loads.values)
    kind = replace(JobKind.of(task), realisations=len(surfaces), timed=False)
    named = identity(task)
    setting, _, digest = named.rpartition("-0-")
    key = f"{setting}-{surfaces.start}-{digest}"
    return Job(key, solve_bundle, (task, named, surfaces), memory, kind, BUNDLE)


def solve_bundle(task: Task, identity: str, surfaces: range) -> bundles.Bundle:
    """Solve the surfaces block by block, each once, and keep their curves only."""
    solver = planned_solver(task)
    compilation = compile_apart(task) + warm_up(solver, task)
    size = solver.block(task.resolution)
    parts: list[Solution] = []
    spent = 0.0
    for start in range(0, len(surfaces), size):
        block = replace(task, realisations=tuple(surfaces[start : start + size]))
        begun = time.process_time()
        solution = execute(block, repeats=1)
        spent += time.process_time() - begun
        solution.fields.clear()
        parts.append(solution)
    joined = Solution.concat(parts, axis=REALISATIONS)
    return bundles.Bundle(
        method=task.method,
        resolution=task.resolution,
        identity=identity,
        first=surfaces.start,
        count=len(surfaces),
        answers=joined.converged.size,
        lost=int((~joined.answered).sum()),
        seconds=joined.seconds,
        processor_seconds=spent,
        compile_seconds=compilation,
        machine=this_machine(),
        solution=joined,
    )
