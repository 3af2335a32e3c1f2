"""Execution of one task: warm code, time, peak memory; solver failures raise no exception.

Numba's functions may reorder sums, and a helper that was compiled on its own is not, digit for
digit, the copy of it inside a function that calls it: the first is used by a process that has just
compiled, the second by one that reads the cache. So that both have the same digits, whatever is not
in the cache is compiled by another process. Of several that need a function one compiles it, the
others wait: Numba's files know no locks.
"""

from __future__ import annotations

import ctypes
import hashlib
import os
import statistics
import sys
import time
import warnings
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, suppress
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import psutil
from threadpoolctl import ThreadpoolController

from comparisons.errors import is_interrupt
from comparisons.facts.methods import METHODS
from comparisons.geometry.prepare import RoughGeometry
from comparisons.isolation import parent
from comparisons.machine import machine, machine_text, source_digest, versions
from comparisons.methods.registry import planned_solver
from comparisons.methods.runner import in_words, run
from comparisons.methods.solver import Solver
from comparisons.methods.user.external import add_announced
from comparisons.solving.jobs import REPEAT_SECONDS, REPEATS, Done, Job, JobKind
from comparisons.solving.shared import alone
from comparisons.tasks.shown_loads import earlier_fields
from comparisons.tasks.solution import Solution
from comparisons.tasks.stresses import FROM_PRESSURE, pressure_quantities
from comparisons.tasks.task import Task

# A worker starts with the methods of the process that hands out the work.
add_announced()

THREADS = 1
_CLEAR_PEAK = Path("/proc/self/clear_refs")
_STATUS = Path("/proc/self/status")
# Kinds of tasks that are compiled in this process, and the seconds that took.
_compiled: dict[tuple[object, ...], float] = {}


def execute(task: Task, repeats: int | None = None) -> Solution:
    """Solve a task on one thread, with its times and its peak memory.

    The time is the median of repeats on warm code, until `repeats` (default REPEATS) or a tenth of
    a second; compilation is counted apart. Memory is the rise of the process's peak during the
    first solve. A method in a process of its own measures all that there. One that raises anything
    but a keyboard interrupt costs its own rows, a step with NaN or inf itself: marked with the
    reason.
    """
    most = REPEATS if repeats is None else repeats
    try:
        solver = planned_solver(task)
        if METHODS[task.method].isolated:
            solution = _solve(solver, task)
            _add_fields(task, solution)
            solution.machine = this_machine()
            return solution
        with _pools(len(sys.modules)).limit(limits=THREADS):
            compile_seconds = warm_up(solver, task)
            if isinstance(task.geometry, RoughGeometry) and METHODS[task.method].dimension == 3:
                # Heights are made before the clock starts: they are the input, not the work.
                for realisation in task.realisations:
                    task.geometry.heights(realisation, task.resolution)
                    task.geometry.top(realisation)
            before = _reset_peak()
            start = time.perf_counter()
            solution = _solve(solver, task)
            times, setups = [time.perf_counter() - start], [solution.setup_seconds]
            memory = peak_memory() - before
            answered = solution.converged.any()
            while answered and len(times) < most and sum(times) < REPEAT_SECONDS:
                start = time.perf_counter()
                again = _solve(solver, task)
                times.append(time.perf_counter() - start)
                setups.append(again.setup_seconds)
            _add_fields(task, solution)
    except Exception as error:  # the study carries on
        if is_interrupt(error):
            raise KeyboardInterrupt from error
        return Solution.lost(task, in_words(error))
    finally:
        if isinstance(task.geometry, RoughGeometry):
            task.geometry.forget()
    solution.seconds = statistics.median(times)
    solution.setup_seconds = statistics.median(setups)
    solution.compile_seconds = compile_seconds
    solution.memory = memory
    solution.machine = this_machine()
    return solution


@lru_cache(maxsize=1)
def _pools(modules: int) -> ThreadpoolController:
    """Return the libraries that have threads; they are sought when more modules are imported."""
    return ThreadpoolController()


@lru_cache(maxsize=1)
def this_machine() -> str:
    """Return the machine as the rows of results name it."""
    return machine_text(machine(THREADS))


def _add_fields(task: Task, solution: Solution) -> None:
    """Compute what follows from pressures, and fields: without these a picture is missing only."""
    pressures, solution.pressures = solution.pressures, {}
    if not FROM_PRESSURE.isdisjoint(task.quantities):
        for index, build in pressures.items():
            if solution.converged[index]:
                read = pressure_quantities(task.scene, task.quantities, build())
                values, bars = ({name: known[i] for name, known in read.items()} for i in (0, 1))
                solution.put(index, values, bars)
    steps = {step: build for (row, step), build in pressures.items() if row == 0}
    compute, solution.body_fields = solution.body_fields, None
    last = solution.fields
    with suppress(ValueError, ArithmeticError, MemoryError, RuntimeError):
        solution.fields = last | earlier_fields(steps, solution.converged.shape[1], last)
    if compute is not None:
        with suppress(ValueError, ArithmeticError, MemoryError, RuntimeError):
            solution.fields |= compute()


def _solve(solver: Solver[Any], task: Task) -> Solution:
    """Solve; warnings of arithmetic are passed on only if every step has an answer."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", RuntimeWarning)
        solution = run(solver, task)
    if solution.converged.all():
        for warning in caught:
            warnings.warn_explicit(
                warning.message, warning.category, warning.filename, warning.lineno
            )
    return solution


def kind_of(task: Task) -> tuple[object, ...]:
    """Return the key that tasks with the same compiled code share."""
    rough = task.geometry if isinstance(task.geometry, RoughGeometry) else None
    kind = (rough is not None, rough is not None and rough.periodic, task.loads.control)
    return (task.method, *kind, tuple(sorted(task.scene.physics)), task.options.changed())


def warm_up(solver: Solver[Any], task: Task) -> float:
    """Compile once per process and kind of scene; return how long it took the first time."""
    key = kind_of(task)
    if key not in _compiled:
        start = time.perf_counter()
        solver.warm_up(task)
        _compiled[key] = time.perf_counter() - start
        return _compiled[key]
    return 0.0


def _reset_peak() -> float:
    """Give back freed memory, reset the process's peak to the present use and return it, or NaN."""
    if sys.platform != "linux":
        return float("nan")
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
    if trim is not None:
        trim(0)
    try:
        _CLEAR_PEAK.write_text("5")
    except OSError:
        return float("nan")
    return float(psutil.Process().memory_info().rss)


def peak_memory() -> float:
    """Return the peak resident memory of this process since its reset, in bytes, or NaN."""
    try:
        lines = _STATUS.read_text().splitlines()
    except OSError:
        return float("nan")
    peak_lines = [line for line in lines if line.startswith("VmHWM")]
    return 1024.0 * float(peak_lines[0].split()[1]) if peak_lines else float("nan")


_WORK = "comparisons.solving.execution:compile_for"
_LOCK = "roughline.lock"
_SECONDS = 900.0
_ENOUGH = 256  # points a side
_MANY = 4  # kinds
# Seconds to wait for a process that compiles: the longest functions take a few. One that is stopped
# holds others up so long, for one function, and they compile it themselves.
_PATIENCE = 60.0


def compile_apart(task: Task) -> float:
    """See that all compiled code of a task is in the cache, if it can be; return the seconds."""
    mark = _mark(task)
    if mark is None or mark.exists():
        return 0.0
    try:
        with alone(mark.with_name(_LOCK)):
            if mark.exists():
                return 0.0
            outcome = parent.run(_WORK, task, seconds=_SECONDS, reuse=_WORK)
            if outcome.ok:
                mark.touch()
            return outcome.seconds
    except OSError:
        return 0.0


def compile_ahead(tasks: Sequence[Task]) -> Iterator[Done]:
    """Let two processes compile what tasks need before the first is solved; yield what each took.

    `compile_apart` does what they leave, and the kinds of a small run, which would not repay the
    second process. Rough lines come first: they take longest, and share no code with grids.
    """
    own = [task for task in reversed(tasks) if not METHODS[task.method].user_made]
    kinds = {kind_of(task): task for task in own}.values()
    cold = {mark: task for task in kinds if (mark := _mark(task)) and not mark.exists()}
    if len(cold) < _MANY or os.cpu_count() == 1:
        return
    lines_first = sorted(cold.items(), key=lambda item: METHODS[item[1].method].dimension)
    with suppress(OSError, ImportError):  # some systems have no locks that processes share
        from comparisons.solving.processes import ProcessExecutor

        with alone(lines_first[0][0].with_name(_LOCK)), ExitStack() as at_the_end:
            executor = ProcessExecutor(2)
            at_the_end.callback(executor.end, idle=True)
            executor.add(
                Job(str(mark), compile_for, (task,), kind=JobKind.of(task))
                for mark, task in lines_first
                if not mark.exists()
            )
            for done in executor.finished():
                if not done.lost:
                    Path(done.job.key).touch()
                    yield replace(done, compile_seconds=done.seconds)


def _mark(task: Task) -> Path | None:
    """Return the file that is there once the code of such tasks is cached, if it has to be."""
    from numba.core.registry import cpu_target

    from reference.contact import descent

    if METHODS[task.method].isolated or kind_of(task) in _compiled:
        return None
    # Where Numba keeps the code of the half-space: marks go when the cache goes.
    cache = descent._advance.stats.cache_path
    if cache is None:
        return None
    folder = Path(cache)
    with suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
    # Of this very source, with these packages, on such a processor as Numba's cache names it.
    processor = cpu_target.target_context.codegen().magic_tuple()
    identity = (repr(kind_of(task)), source_digest(), repr(sorted(versions().items())))
    digest = hashlib.sha256("\n".join((*identity, *processor)).encode()).hexdigest()[:16]
    return folder / f"roughline-{digest}.compiled"


def compile_for(task: Task) -> dict[str, Any]:
    """Compile what a task needs, by solving its first realisation in a process of its own.

    A warm-up alone would miss what only some loads need (single precision, late corrections). Of a
    large map every second, fourth ... point does: what it runs does not depend on their number.
    """
    points, geometry = task.resolution, task.geometry
    if isinstance(geometry, RoughGeometry) and METHODS[task.method].dimension == 3:
        own = geometry.points
        points = min(points, own[0])
        while points > _ENOUGH and not any(n % (2 * own[0] // points) for n in own):
            points //= 2
    first = replace(task, realisations=task.realisations[:1], with_body=False, resolution=points)
    execute(first, repeats=1)
    return {}


def compile_in_turn(folder: Path) -> None:
    """Let this process compile a function only while no other one does.

    Waiting is safe: a function is waited for by those that call it, never the other way round.
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
