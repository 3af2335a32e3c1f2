"""Third-party code in a separate Python process, with limits on time and memory.

Peers (Tamaas, ContactMechanics, NGSolve) and user-supplied methods may raise, hang, crash the
interpreter, exhaust the memory, or return invalid answers. None of this affects a study: the caller
receives either an answer or a reason in plain words.

The contract
------------
- **Work** is a function of an importable module, named ``"package.module:function"``, and its
  arguments (anything picklable: scenes, tasks, arrays). The function and its module are imported in
  the separate process only.
- It **returns** a dict with text keys. A value is a NumPy array of numbers, booleans or text, or
  any JSON value (None, numbers, text, lists and dicts of them). Answers are transferred as npz and
  JSON, never as pickles, and therefore cannot run code in the caller. NaN and infinities are
  refused unless the caller passes ``finite=False`` (solutions mark failed steps with NaN).
- It runs in a new ``sys.executable``, or the interpreter that the caller names (no fork, so no
  inherited threads, locks or compiled code), with one thread for OpenMP, BLAS and Numba, the import
  path of the caller, and an empty working directory of its own, which goes with it. Standard error
  is kept for the reason; standard output is discarded. A caller may keep the process under a name
  for its next call (``reuse``), unless it gave no answer.
- **Limits**: wall-clock seconds and bytes of resident memory of the process with its children,
  both including start-up and imports. On systems that support it, the address space is also
  limited, to four times the memory plus 8 GiB for the libraries, so that one excessive allocation
  fails at once.
- **No orphans**: the process and its descendants, those that detached themselves by forking twice
  as well (they inherit an environment variable), are killed at its end, when a limit is exceeded,
  on Ctrl-C, and on any exception in the caller; if the caller is killed, the process exits by
  itself, and detached descendants stay. Ctrl-C in a terminal reaches the caller only.
- Times for comparison are measured inside the work: `Outcome.seconds` includes the start of Python
  and all imports.
"""

from __future__ import annotations

import atexit
import contextlib
import json
import os
import pickle
import signal
import subprocess
import sys
import tempfile
import threading
import time
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np
import psutil

from comparisons.isolation import ONE_THREAD, child
from comparisons.isolation.child import (
    ANSWER,
    ANSWERED,
    DOCUMENT,
    DONE,
    ERROR,
    HUNG,
    KILLED,
    MALFORMED,
    OUT_OF_MEMORY,
    WORK,
    Ended,
)

OWN = "own"  # the folder that the work starts in
MARK = "ROUGHLINE_WORK"  # environment: the folder, by which all descendants are known
# Seconds between checks of the memory (at first, later), and for a killed process to end.
_SHORTEST_LOOK, _LOOK, _FAREWELL = 0.002, 0.05, 10.0


@dataclass(frozen=True)
class Limits:
    """Limits on the wall-clock seconds of work and the bytes of resident memory of its process."""

    seconds: float
    memory: float


@dataclass(frozen=True)
class Outcome:
    """Outcome of isolated work."""

    # "answered", "raised", "hung" (time limit), "out of memory" (limit passed, or MemoryError),
    # "killed" (the process ended by a signal or by exiting), "malformed" (the answer is missing,
    # unreadable, not a dict, or not finite).
    ended: Ended
    # Return value of the work; empty unless `ended` is "answered".
    answer: dict[str, Any] = field(default_factory=dict)
    reason: str = ""  # reason for a missing answer, in plain words; empty if there is an answer
    # Wall-clock time from start to end, and the largest measured resident memory in bytes.
    seconds: float = float("nan")
    memory: float = 0.0

    @property
    def ok(self) -> bool:
        """Whether there is an answer."""
        return self.ended == ANSWERED


def run(
    work: str,
    *arguments: Any,
    seconds: float | None = None,
    memory: float | None = None,
    finite: bool = True,
    reuse: str = "",
    python: str = "",
) -> Outcome:
    """Call a function in a separate process and return the outcome, see the contract of the module.

    `seconds` of wall clock and bytes of resident `memory` are limits (None: no limit); `finite`
    refuses an answer that holds NaN or infinities. Under the name `reuse` the process is kept for
    the next call while it gives answers. Failures of the work do not raise: the outcome has them.

    `python` is the interpreter of another environment. It needs NumPy and what the work imports;
    our packages are not seen there, so `work` is ``"/path/to/script.py:function"``, and arguments
    are plain Python (another NumPy may not read our arrays).

    >>> run("json:loads", '{"force": 2.5}', seconds=60).answer
    {'force': 2.5}
    >>> run("json:loads", "no JSON", seconds=60).ended
    'raised'
    """
    module, colon, function = work.rpartition(":")
    problems = []
    if not (colon and module and function.isidentifier()):
        problems.append(f"work: expected 'module:function', got {work!r}")
    for name, limit in {"seconds": seconds, "memory": memory}.items():
        if limit is not None and not limit > 0:
            problems.append(f"{name}: expected a positive limit, got {limit!r}")
    if problems:
        raise ValueError("; ".join(problems))
    while True:
        process = _waiting.pop(reuse, None)
        if process is None or not process.is_ours():
            try:
                process = _Process(stays=bool(reuse), python=python)
            except _NoInterpreterError as error:
                return Outcome(KILLED, reason=str(error))
        outcome = None
        try:
            outcome = process.call((work, arguments, memory), seconds, finite)
        finally:
            if reuse and outcome is not None and outcome.ok:
                _waiting[reuse] = process
            else:
                process.end()
        # what is out of memory after several calls may be so by leftovers of the earlier ones
        if outcome.ended != OUT_OF_MEMORY or process.calls == 1:
            return outcome


class _NoInterpreterError(Exception):
    """What the user names as an interpreter does not start."""


class _Process:
    """A new process, with the folder for its work and answers."""

    def __init__(self, *, stays: bool, python: str) -> None:
        self.calls = 0
        self._stays = stays
        self._caller = os.getpid()
        # A detached descendant may still write there; that is not an error.
        self._holder = tempfile.TemporaryDirectory(prefix="roughline-", ignore_cleanup_errors=True)
        self._folder = Path(self._holder.name)
        root = str(Path(__file__).resolve().parents[2])
        paths = [root, *(str(Path(path).absolute()) for path in sys.path if path)]
        environment = os.environ | dict.fromkeys(ONE_THREAD, "1")
        environment[MARK] = self._mark = str(self._folder)
        environment["PYTHONPATH"] = os.pathsep.join(dict.fromkeys(paths))
        flags = ["stays"] if stays else []
        # Of another environment nothing of ours may hide a package: a file, and no import path.
        own_module = ["-P", "-m", "comparisons.isolation.child"]
        start = [python, "-I", child.__file__] if python else [sys.executable, *own_module]
        # Whatever the work writes by a bare name is its own, and goes with the process.
        own = self._folder / OWN
        own.mkdir()
        try:
            with (self._folder / "stderr").open("wb") as errors:
                self._process = subprocess.Popen(  # noqa: S603 (our own module)
                    [*start, str(self._folder), *flags],
                    # The process exits when the pipe closes, starts work when it receives a byte.
                    stdin=subprocess.PIPE,
                    stdout=subprocess.DEVNULL,
                    stderr=errors,
                    env=environment,
                    cwd=own,
                    start_new_session=True,  # Ctrl-C in the terminal reaches the parent only
                )
        except OSError as error:
            self._holder.cleanup()
            if not python:
                raise
            raise _NoInterpreterError(f"{python}: {error.strerror}") from error

    def is_ours(self) -> bool:
        """Return whether the process is alive and was started by this one, not before a fork."""
        return self._caller == os.getpid() and self._process.poll() is None

    def call(self, task: tuple[Any, ...], seconds: float | None, finite: bool) -> Outcome:
        """Send (work, arguments, memory), and wait for the answer or the end of the process."""
        self.calls += 1
        for name in (ANSWER, ERROR, DONE):
            (self._folder / name).unlink(missing_ok=True)
        (self._folder / WORK).write_bytes(pickle.dumps(task))
        start, memory = time.perf_counter(), task[-1]
        assert self._process.stdin is not None
        with contextlib.suppress(BrokenPipeError):  # it has ended, which is detected at once
            self._process.stdin.write(b"!")
            self._process.stdin.flush()
        done = self._folder / DONE if self._stays else None
        stopped, peak = _watch(self._process, done, start, seconds, memory)
        spent = time.perf_counter() - start
        if stopped:
            limit = f"{seconds:.3g} s" if stopped == HUNG else f"{(memory or 0) / 1e9:.3g} GB"
            problem = "no answer within" if stopped == HUNG else "more memory than"
            return Outcome(stopped, {}, f"{problem} {limit}", spent, peak)
        ended, answer, reason = _read(self._folder, self._process.poll() or 0, finite)
        return Outcome(ended, answer, reason, spent, peak)

    def end(self) -> None:
        """Kill the process and remove its folder."""
        if self._caller == os.getpid():
            # kill the process and its descendants; Ctrl-C takes effect afterwards
            with _interrupts_wait():
                try:
                    children = psutil.Process(self._process.pid).children(recursive=True)
                except psutil.NoSuchProcess:
                    children = []
                if hasattr(os, "killpg"):
                    # The process group outlives its leader while any child remains.
                    with contextlib.suppress(ProcessLookupError, PermissionError):
                        os.killpg(self._process.pid, signal.SIGKILL)
                for descendant in children:
                    with contextlib.suppress(psutil.NoSuchProcess):
                        descendant.kill()
                if self._process.poll() is None:
                    self._process.kill()
                self._process.wait(_FAREWELL)
                # What has forked twice, into a session of its own, is nobody's child by now.
                for other in psutil.process_iter():
                    # another user's tells nothing, nor one that has ended
                    with contextlib.suppress(psutil.Error, OSError):
                        if other.environ().get(MARK) == self._mark:
                            children.append(other)
                            other.kill()
                # Processes that are still ending may write into the folder, which is removed next.
                psutil.wait_procs(children, _FAREWELL)
                if self._process.stdin is not None:
                    self._process.stdin.close()
            self._holder.cleanup()


# Processes kept between calls, by name.
_waiting: dict[str, _Process] = {}


@atexit.register
def _end_waiting() -> None:
    while _waiting:
        _waiting.popitem()[1].end()


@contextlib.contextmanager
def _interrupts_wait() -> Iterator[None]:
    """Defer Ctrl-C, and a TERM that is taken for one, until after the block."""
    handlers = {
        number: handler
        for number in (signal.SIGINT, signal.SIGTERM)
        if callable(handler := signal.getsignal(number))
    }
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    pressed: list[tuple[int, FrameType | None]] = []
    for number in handlers:
        signal.signal(number, lambda number, frame: pressed.append((number, frame)))
    try:
        yield
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
    for last, frame in pressed[-1:]:
        handlers[signal.Signals(last)](last, frame)


def _watch(
    process: subprocess.Popen[bytes],
    done: Path | None,
    start: float,
    seconds: float | None,
    memory: float | None,
) -> tuple[Ended | None, float]:
    """Wait until the process ends or writes `done`; return the exceeded limit and the peak memory.

    The limit is None if none was exceeded. To find all descendants is dear: without a limit of
    memory it takes a fiftieth of the time.
    """
    peak, look, again = 0.0, _SHORTEST_LOOK, start
    while True:
        try:
            process.wait(look)
        except subprocess.TimeoutExpired:
            now = time.perf_counter()
            if memory is not None or now >= again:
                resident = 0.0
                with contextlib.suppress(psutil.NoSuchProcess, psutil.AccessDenied):
                    leader = psutil.Process(process.pid)
                    for member in (leader, *leader.children(recursive=True)):
                        with contextlib.suppress(psutil.NoSuchProcess, psutil.AccessDenied):
                            resident += member.memory_info().rss
                peak, after = max(peak, resident), time.perf_counter()
                again = after + 50 * (after - now)
        else:
            return None, peak
        if done is not None and done.exists():
            return None, peak
        if memory is not None and peak > memory:
            return OUT_OF_MEMORY, peak
        if seconds is not None and time.perf_counter() - start > seconds:
            return HUNG, peak
        look = min(2 * look, _LOOK)


def _read(folder: Path, code: int, finite: bool) -> tuple[Ended, dict[str, Any], str]:
    """Return how the work ended, its answer, and the reason for a missing answer."""
    try:
        error = json.loads((folder / ERROR).read_text(encoding="utf-8"))
        return error["ended"], {}, error["reason"]
    except (OSError, ValueError, KeyError, TypeError):
        pass
    if code != 0:
        text = f"the process ended with exit code {code}"
        if code < 0:
            try:
                name = signal.Signals(-code).name
            except ValueError:
                name = str(-code)
            text = f"the process was ended by signal {name}"
            if name == "SIGKILL":
                text += ", which the system sends when memory runs out"
        # the last line that it wrote
        errors = (folder / "stderr").read_text(encoding="utf-8", errors="replace")
        lines = errors.strip().splitlines()
        return KILLED, {}, f"{text}: {lines[-1][:200]}" if lines else text
    try:
        with np.load(folder / ANSWER, allow_pickle=False) as stored:
            answer: dict[str, Any] = json.loads(str(stored[DOCUMENT]))
            arrays = {name: stored[name] for name in stored.files if name.startswith("a.")}
        answer |= {name.removeprefix("a."): value for name, value in arrays.items()}
    except FileNotFoundError:
        return MALFORMED, {}, "the process ended without an answer"
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as problem:
        return MALFORMED, {}, f"the answer cannot be read: {problem}"
    wrong = [name for name, value in answer.items() if finite and not _is_finite(value)]
    if wrong:
        return MALFORMED, {}, f"the answer is not finite: {', '.join(wrong)}"
    return ANSWERED, answer, ""


def _is_finite(value: Any) -> bool:
    if isinstance(value, np.ndarray):
        return value.dtype.kind not in "fc" or bool(np.isfinite(value).all())
    if isinstance(value, dict):
        return all(_is_finite(entry) for entry in value.values())
    if isinstance(value, list):
        return all(_is_finite(entry) for entry in value)
    return not isinstance(value, float) or bool(np.isfinite(value))
