"""What an isolated process does with a method from outside: the only place that imports its code.

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

from comparisons.geometry.prepare import prepare
from comparisons.methods import METHODS, Method, Task
from comparisons.scene.method_names import GROUP
from comparisons.scene.scene import Scene
from comparisons.solving.execution import execute
from comparisons.tasks.archive import arrays_of


def describe(source: str) -> dict[str, Any]:
    """Return name, title, dimension and physics of every method of a source, as one JSON text."""
    found = [
        {"name": each.name, "title": each.title, "dimension": each.dimension}
        | ({"physics": sorted(each.physics)} if each.physics else {})
        for each in _methods(source)
    ]
    return {"methods": json.dumps(found)}


def plan(source: str, name: str, scene: Scene) -> dict[str, Any]:
    """Return what a method would do with a scene."""
    method = _method(source, name)
    support = method.supports(scene)
    found: dict[str, Any] = {"ok": bool(support.ok), "reason": str(support.reason)}
    if not support.ok:
        return found
    geometry, _ = prepare(scene)
    levels = tuple(int(n) for n in method.resolutions(scene, geometry))
    found["resolutions"] = list(levels)
    found["model"] = str(method.model(scene, geometry))
    found["usual"] = int(method.usual(levels, geometry))
    return found


def solve(source: str, name: str, task: Task, repeats: int) -> dict[str, Any]:
    """Return the solution of a task, with its times taken here, on warm code."""
    method = _method(source, name)
    refused = method.refused(task)
    if refused:
        raise ValueError(refused)
    METHODS[name] = method
    return arrays_of(execute(task, repeats))


def _method(source: str, name: str) -> Method:
    (found,) = [each for each in _methods(source) if each.name == name]
    return found


@lru_cache(maxsize=1)
def _methods(source: str) -> list[Method]:
    """Return the methods of ``file:PATH`` or ``entry:NAME``, as instances; loaded once."""
    kind, _, where = source.partition(":")
    if kind == "entry":
        (point,) = metadata.entry_points(group=GROUP, name=where)
        return [_instance(point.load())]
    module = _module(Path(where))
    own = [
        value
        for value in vars(module).values()
        if isinstance(value, Method)
        or (
            inspect.isclass(value)
            and issubclass(value, Method)
            and value.__module__ == module.__name__
            and value.name
        )
    ]
    if not own:
        raise ValueError(
            "no method in the file: expected a function under @method(name), or a class derived "
            "from comparisons.methods.Method that has a name"
        )
    return [_instance(each) for each in own]


def _instance(found: Any) -> Method:
    instance = found() if inspect.isclass(found) else found
    if not isinstance(instance, Method):
        raise TypeError(f"expected a Method, got {type(instance).__name__}")
    return instance


def _module(path: Path) -> Any:
    name = "roughline_method_file"
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise ValueError(f"expected a Python file, got {path.name}")
    # The file's neighbours can be imported, as from a script.
    sys.path.insert(0, str(path.parent))
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module
