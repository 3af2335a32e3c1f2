"""Single-threaded processes on this machine that share the available memory.

The processes are joblib's (loky): started afresh, used again, and gone when this process is. If
the system ends one (SIGKILL, most often because memory ran out), loky gives up all of them and
cannot say whose job it was. All that were under way are then tried again, each with the machine
to itself: the one that ends its process again is the culprit, the others lose nothing.
"""

from __future__ import annotations

import os
import re
import shutil
import signal
import sys
import threading
import time
from collections import Counter, deque
from collections.abc import Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Future, wait
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from joblib.externals.loky import get_reusable_executor, process_executor
from joblib.externals.loky.process_executor import ProcessPoolExecutor

from comparisons.isolation import ONE_THREAD
from comparisons.machine import MEMORY_SHARE, free_memory
from comparisons.solving.jobs import Done, Executor, Job, timed
from comparisons.solving.shared import VARIABLE as SHARED
from comparisons.solving.shared import folder

# How often a job is tried whose process is ended.
ATTEMPTS = 3
# Bytes of a process with all packages loaded (measured: 0.35 GB, a good half of it shared with
# the others).
PROCESS = 4e8
# Bytes that a process may have come to keep (imported packages, compiled code, results for later
# jobs) before loky replaces it by a new one, which would do all that again: these, if all cores'
# processes together leave half of the memory free. loky's 3e8 are fewer than some experiments
# import.
_KEPT = 1e9
# Seconds without work after which a process ends: planning may take some.
_IDLE = 60
# Seconds between looks whether the process that handed out the work still lives.
_LOOK = 0.5
# Jobs given to each process: the next one waits there while this process plans.
_AHEAD = 2
# Seconds that handing over the work may take at most, should loky's thread be gone.
_HAND_OVER = 1.0
_SIGNAL = re.compile(r"SIG[A-Z0-9]+|EXIT\(\d+\)")


class ProcessExecutor(Executor):
    """Does several jobs at a time, each in a process with one thread.

    Half of them are given the first of the jobs that wait, the others the last: neighbours need the
    same shared results, for which one would have to wait for the other. While a method is used for
    the first time, which compiles it, jobs of other methods come before more of its own. Jobs whose
    estimated memory does not fit beside what is running wait until it does, or until they are
    alone. The bytes to hand out are by default 80 % of what is free when nothing is under way.
    """

    def __init__(self, workers: int, memory: float | None = None) -> None:
        super().__init__()
        self.workers = workers
        self._memory = memory
        self._tried: Counter[str] = Counter()
        self._suspects: deque[Job] = deque()
        self._running: dict[Future[Any], Job] = {}
        self._pool: ProcessPoolExecutor | None = None  # that of the last job
        self._budget = 0.0
        self._from_the_end = False
        self._used: set[str] = set()  # methods that some process has compiled

    def add(self, jobs: Iterable[Job]) -> None:
        """Take more jobs and start what may start: processes work while others are planned."""
        super().add(jobs)
        self._start()

    def finished(self) -> Iterator[Done]:
        """Yield jobs as their processes finish them; on any exception the processes end."""
        try:
            while self._waiting or self._suspects or self._running:
                self._start()
                ended, _ = wait(self._running, return_when=FIRST_COMPLETED)
                for future in ended:
                    job = self._running.pop(future)
                    try:
                        answer = future.result()
                    except BrokenExecutor as error:
                        self._tried[job.key] += 1
                        if self._tried[job.key] < ATTEMPTS:
                            self._suspects.append(job)
                            continue
                        signals = sorted(set(_SIGNAL.findall(str(error))))
                        lost = f"its process was killed {ATTEMPTS} times"
                        lost += f" ({', '.join(signals)})" if signals else ""
                        lost += ", most likely for lack of memory" if "SIGKILL" in signals else ""
                        yield Done(job, lost=lost)
                    else:
                        self._used.add(job.kind.method)
                        yield Done(job, *answer)
        finally:
            self.end()

    def end(self, *, idle: bool = False) -> None:
        """End the processes in the middle of their work; where they are `idle`, too, if asked.

        loky forgets what it was given and then looks for what it has not handed to a process yet: a
        KeyError in its thread. So first all is handed over, which takes it milliseconds.
        """
        if self._pool is None or not (self._running or idle):
            return
        end = time.monotonic() + _HAND_OVER
        while time.monotonic() < end and not all(
            future.running() or future.done() for future in self._running
        ):
            time.sleep(0.001)
        self._running.clear()
        self._pool.shutdown(wait=True, kill_workers=True)

    def _start(self) -> None:
        if not self._running:
            memory = self._memory
            self._budget = MEMORY_SHARE * free_memory() if memory is None else memory
        while len(self._running) < _AHEAD * self.workers:
            job = self._next(self._budget)
            if job is None:
                return
            try:
                with _deaf_to_control_c():
                    self._pool = _processes(self.workers)
                    self._running[self._pool.submit(timed, job.work, job.arguments)] = job
            except BrokenExecutor:
                # An idle process was ended just now: nobody's fault, and the next pool is whole.
                self._waiting.appendleft(job)
                return

    def _next(self, budget: float) -> Job | None:
        """Return a job that may start beside what is running, taken off its queue."""
        if self._suspects:
            return None if self._running else self._suspects.popleft()
        if any(self._tried[job.key] for job in self._running.values()):
            return None
        # the first that fits, of a method that is compiled if there is one
        memory = budget - sum(job.memory + PROCESS for job in self._running.values())
        compiling = {job.kind.method for job in self._running.values()} - self._used
        places, place = range(len(self._waiting)), None
        for at in reversed(places) if self._from_the_end else places:
            if self._running and self._waiting[at].memory + PROCESS > memory:
                continue
            place = at if place is None else place
            if self._waiting[at].kind.method not in compiling:
                place = at
                break
        if place is None:
            return None
        self._from_the_end = not self._from_the_end
        job = self._waiting[place]
        del self._waiting[place]
        return job


def _processes(workers: int) -> ProcessPoolExecutor:
    """Return the processes; new ones where they were broken, or know other methods."""
    from comparisons.methods.user.external import VARIABLE, announced

    return get_reusable_executor(
        max_workers=workers,
        timeout=_IDLE,
        initializer=_begin,
        initargs=(os.getpid(), folder()),
        env=dict.fromkeys(ONE_THREAD, "1") | {VARIABLE: announced(), SHARED: folder()},
    )


@contextmanager
def _deaf_to_control_c() -> Iterator[None]:
    """Start processes that a ctrl-C does not reach, by this thread's mask: this one ends them."""
    if sys.platform == "win32":
        yield
        return
    from multiprocessing import resource_tracker  # there is none on Windows

    # loky starts it with the first process, and in CPython 3.11 it lifts the mask as it starts.
    resource_tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _begin(parent: int, common: str) -> None:
    """Prepare a process; it ends, and clears up, when the one that hands out the work is killed."""
    from comparisons.solving.execution import compile_in_turn  # loads Numba

    kept = min(_KEPT, free_memory() / (2 * (os.cpu_count() or 1)))
    process_executor._MAX_MEMORY_LEAK_SIZE = max(process_executor._MAX_MEMORY_LEAK_SIZE, int(kept))
    compile_in_turn(Path(common))
    threading.Thread(target=_follow, args=(parent, common), daemon=True).start()


def _follow(parent: int, common: str) -> None:
    while os.getppid() == parent:
        time.sleep(_LOOK)
    # its folder of shared results; several processes may be at it
    shutil.rmtree(common, ignore_errors=True)
    os._exit(1)
