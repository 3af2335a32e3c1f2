"""Compilation in a separate process, so that the first run has the same digits as later ones.

Numba's functions may reorder sums, and a helper that was compiled on its own is not, digit for
digit, the copy of it inside a function that calls it. A process that has just compiled uses the
first, one that reads the compiled code from the cache the second: they differ in the last digits.
So whatever is not in the cache yet is compiled by another process, and then read by this one.
"""

from __future__ import annotations

import hashlib
from dataclasses import replace
from pathlib import Path
from typing import Any

from comparisons.facts.methods import METHODS
from comparisons.isolation import parent
from comparisons.machine import source_digest, versions
from comparisons.solving.locks import alone
from comparisons.tasks.task import Task

_WORK = "comparisons.solving.compilation:compile_for"
_SECONDS = 900.0


def compile_apart(task: Task) -> float:
    """See that all compiled code that a task needs is in the cache.

    Of several processes on a machine one compiles, the others wait for it. Where the cache cannot
    be written nothing is done: the task compiles for itself.

    Returns
    -------
    float
        Seconds that it took; 0 where nothing was to be done.
    """
    from comparisons.solving.execution import is_compiled, kind_of

    if METHODS[task.method].isolated or is_compiled(task):
        return 0.0
    try:
        folder = _cache_folder()
        mark = folder / f"roughline-{_digest(kind_of(task))}.compiled"
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

    A warm-up alone would miss what only some loads need (single precision, late corrections).
    """
    from comparisons.solving.execution import execute

    alone = replace(task, realisations=task.realisations[:1], with_body=False)
    return {"solved": bool(execute(alone, repeats=1).converged.any())}


def _cache_folder() -> Path:
    """Return where Numba keeps the code of the half-space: marks go when the cache goes."""
    from reference.contact import descent

    cache = descent._advance.stats.cache_path
    if cache is None:
        raise OSError("the code of the half-space is not kept")
    folder = Path(cache)
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def _digest(kind: tuple[Any, ...]) -> str:
    """Name a kind of task of this very source, with these packages, on such a processor."""
    from numba.core.registry import cpu_target

    identity = (repr(kind), source_digest(), repr(sorted(versions().items())))
    processor = cpu_target.target_context.codegen().magic_tuple()  # as Numba's cache names it
    return hashlib.sha256("\n".join((*identity, *processor)).encode()).hexdigest()[:16]
