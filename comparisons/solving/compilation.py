"""Compilation: apart, so that the first run has the same digits as later ones, and in turn.

Numba's functions may reorder sums, and a helper that was compiled on its own is not, digit for
digit, the copy of it inside a function that calls it. A process that has just compiled uses the
first, one that reads the compiled code from the cache the second: they differ in the last digits.
So whatever is not in the cache yet is compiled by another process, and then read by this one. Numba
keeps compiled code in files, but knows no locks: of several processes that need a function one
compiles it, the others wait and read it.
"""

from __future__ import annotations

import hashlib
from contextlib import ExitStack, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from comparisons.facts.methods import METHODS
from comparisons.geometry.prepare import RoughGeometry
from comparisons.isolation import parent
from comparisons.machine import source_digest, versions
from comparisons.solving.shared import alone
from comparisons.tasks.task import Task

_WORK = "comparisons.solving.compilation:compile_for"
_SECONDS = 900.0
_ENOUGH = 256  # points a side
# Seconds to wait for a process that compiles: the longest functions take a few. One that is stopped
# holds others up so long, for one function, and they compile it themselves.
_PATIENCE = 60.0


def compile_apart(task: Task) -> float:
    """See that all compiled code that a task needs is in the cache; return the seconds it took.

    Of several processes on a machine one compiles, the others wait for it. Where the cache cannot
    be written nothing is done: the task compiles for itself.
    """
    from numba.core.registry import cpu_target

    from comparisons.solving.execution import is_compiled, kind_of
    from reference.contact import descent

    if METHODS[task.method].isolated or is_compiled(task):
        return 0.0
    try:
        # Where Numba keeps the code of the half-space: marks go when the cache goes.
        cache = descent._advance.stats.cache_path
        if cache is None:
            return 0.0
        folder = Path(cache)
        folder.mkdir(parents=True, exist_ok=True)
        # Of this very source, with these packages, on such a processor as Numba's cache names it.
        processor = cpu_target.target_context.codegen().magic_tuple()
        identity = (repr(kind_of(task)), source_digest(), repr(sorted(versions().items())))
        digest = hashlib.sha256("\n".join((*identity, *processor)).encode()).hexdigest()[:16]
        mark = folder / f"roughline-{digest}.compiled"
        if mark.exists():
            return 0.0
        with alone(folder / "roughline.lock"):
            if mark.exists():
                return 0.0
            outcome = parent.run(_WORK, task, seconds=_SECONDS, reuse=_WORK)
            if outcome.ok:
                mark.touch()
            return outcome.seconds
    except OSError:
        return 0.0


def compile_for(task: Task) -> dict[str, bool]:
    """Compile what a task needs, by solving its first realisation in a process of its own.

    A warm-up alone would miss what only some loads need (single precision, late corrections). Of a
    large map every second, fourth ... point does: what it runs does not depend on their number.
    """
    from comparisons.solving.execution import execute

    points, geometry = task.resolution, task.geometry
    if isinstance(geometry, RoughGeometry) and METHODS[task.method].dimension == 3:
        own = geometry.points
        points = min(points, own[0])
        while points > _ENOUGH and not any(n % (2 * own[0] // points) for n in own):
            points //= 2
    alone = replace(task, realisations=task.realisations[:1], with_body=False, resolution=points)
    return {"solved": bool(execute(alone, repeats=1).converged.any())}


def compile_in_turn(folder: Path) -> None:
    """Let this process compile a function only while no other one does.

    Waiting is safe: a function is waited for by those that call it, never the other way round, and
    what calls itself is compiled within its own turn. The locks go with the common folder.
    """
    from numba.core.compiler_lock import global_compiler_lock
    from numba.core.dispatcher import Dispatcher

    compile_now = Dispatcher.compile
    begun: set[Path] = set()

    def compile_alone(self: Any, sig: Any) -> Any:
        with global_compiler_lock, ExitStack() as turn:  # first the lock among our own threads
            code = self.py_func.__code__
            name = f"{self.py_func.__module__}.{self.py_func.__qualname__} {code.co_firstlineno}"
            lock = folder / f"{hashlib.sha256(name.encode()).hexdigest()[:32]}.lock"
            if self.stats.cache_path is not None and lock not in begun:
                with suppress(OSError):  # a full disk has no room for locks
                    turn.enter_context(alone(lock, _PATIENCE))
                begun.add(lock)
                turn.callback(begun.discard, lock)
            return compile_now(self, sig)

    Dispatcher.compile = compile_alone  # type: ignore[method-assign]
