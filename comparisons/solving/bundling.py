"""Bundles of surfaces as jobs."""

from __future__ import annotations

import time
from dataclasses import replace

from comparisons.methods.registry import solver_of
from comparisons.solving.compilation import compile_apart
from comparisons.solving.execution import execute, this_machine, warm_up
from comparisons.solving.jobs import Archive, Job, Kind
from comparisons.tasks.bundles import SUFFIX, Bundle, read_bundle, without_curves, write_bundle
from comparisons.tasks.solution import REALISATIONS, Solution
from comparisons.tasks.task import Task

BUNDLE = Archive(
    SUFFIX,
    write_bundle,
    read_bundle,
    lambda bundle: bool(bundle.lost < bundle.answers),
    without_curves,
)
# Bytes per load step: twenty quantities, each with the copies made on the way into a file.
_BYTES = 4 * 8 * 20


def bundle_job(task: Task, identity: str, surfaces: range) -> Job:
    """Return the solve of consecutive surfaces as a job.

    Parameters
    ----------
    task : Task
        The task of any of these surfaces.
    identity : str
        Identity of their setting.
    surfaces : range
    """
    solver = solver_of(task)
    block = tuple(surfaces[: solver.block(task.resolution)])
    memory = solver.memory(replace(task, realisations=block))
    memory += _BYTES * len(surfaces) * len(task.loads.values)
    setting = f"{task.scene.name}-{task.method}-{task.resolution}"
    kind = Kind(task.scene.name, task.method, task.resolution, len(surfaces))
    key = f"{setting}-{surfaces.start}-{identity}"
    return Job(key, solve_bundle, (task, identity, surfaces), memory, kind, BUNDLE)


def solve_bundle(task: Task, identity: str, surfaces: range) -> Bundle:
    """Solve the surfaces block by block, each once, and keep their curves only."""
    solver = solver_of(task)
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
    return Bundle(
        method=task.method,
        resolution=task.resolution,
        identity=identity,
        first=surfaces.start,
        count=len(surfaces),
        answers=joined.converged.size,
        lost=int((~joined.converged).sum()),
        seconds=joined.seconds,
        processor_seconds=spent,
        compile_seconds=compilation,
        machine=this_machine(),
        solution=joined,
    )
