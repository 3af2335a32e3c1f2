"""Work of an isolated process on a user-supplied method; only this module imports its code.

Every function here is work for `comparisons.isolation.parent`: it runs in a process of its own.
"""

from __future__ import annotations

import importlib.util
import inspect
import json
import sys
from functools import lru_cache
from importlib import metadata
from pathlib import Path
from typing import Any

from comparisons.facts.methods import GROUP
from comparisons.geometry.prepare import prepare
from comparisons.methods import registry
from comparisons.methods.solver import Refused, Solver
from comparisons.scene.scene import Scene
from comparisons.solving.execution import execute
from comparisons.tasks.solution import arrays_of
from comparisons.tasks.task import Task


def describe(source: str) -> dict[str, Any]:
    """Return name, title, dimension and physics of every method of a source, as one JSON text."""
    descriptions = [
        {"name": method.name, "title": method.title, "dimension": method.dimension}
        | ({"physics": sorted(method.physics)} if method.physics else {})
        for method in _methods(source)
    ]
    return {"methods": json.dumps(descriptions)}


def plan(source: str, name: str, scene: Scene) -> dict[str, Any]:
    """Return what a method would do with a scene."""
    try:
        solver = _method(source, name)(scene)
    except Refused as reason:
        return {"ok": False, "reason": str(reason)}
    geometry, _ = prepare(scene)
    return {
        "ok": True,
        "reason": str(solver.note),
        "resolutions": [int(n) for n in solver.resolutions(geometry)],
        "model": str(solver.model(geometry)),
    }


def solve(source: str, name: str, task: Task) -> dict[str, Any]:
    """Return the solution of a task, with its times taken here, on warm code."""
    method = _method(source, name)
    registry.add_class(method)
    refused = registry.planned_solver(task).refusal(task)
    if refused:
        raise ValueError(refused)
    return arrays_of(execute(task))


def _method(source: str, name: str) -> type[Solver[Any]]:
    (solver,) = [method for method in _methods(source) if method.name == name]
    return solver


@lru_cache(maxsize=1)
def _methods(source: str) -> list[type[Solver[Any]]]:
    """Return the methods of ``file:PATH`` or ``entry:NAME``; loaded once."""
    kind, _, where = source.partition(":")
    if kind == "entry":
        (point,) = metadata.entry_points(group=GROUP, name=where)
        solver = point.load()
        if not _is_method(solver):
            raise TypeError(f"expected a class derived from Solver, got {solver!r:.60}")
        return [solver]
    path = Path(where)
    name = "roughline_method_file"
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise ValueError(f"expected a Python file, got {path.name}")
    # The file's neighbours can be imported, as from a script.
    sys.path.insert(0, str(path.parent))
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    solvers = [solver for solver in vars(module).values() if _is_method(solver)]
    solvers = [solver for solver in solvers if solver.__module__ == module.__name__]
    if not solvers:
        raise ValueError(
            "no method in the file: expected a function under @method(name), or a class derived "
            "from comparisons.methods.Solver that has a name"
        )
    return solvers


def _is_method(value: object) -> bool:
    return inspect.isclass(value) and issubclass(value, Solver) and bool(value.name)
