"""Work in a separate Python process, with limits on time and memory: for code that is not ours.

Peers (Tamaas, ContactMechanics, NGSolve) and methods that users bring may raise, hang, crash the
interpreter, eat the memory, or answer with nonsense. Here none of that reaches a study: the
caller gets either an answer or a reason in plain words.

The contract
------------
- **Work** is a function of an importable module, named ``"package.module:function"``, and its
  arguments (anything picklable: scenes, tasks, arrays). Whatever the function needs to import it
  imports itself, in its own process; the module that holds it is imported there too.
- It **returns** a dict with text keys. A value is a NumPy array of numbers, booleans or text, or
  whatever JSON knows (None, numbers, text, lists and dicts of them). It travels as npz and JSON,
  never as a pickle: what comes back cannot run code here. NaN and infinities are refused unless
  the caller says ``finite=False`` (solutions mark failed steps with NaN).
- It runs in ``sys.executable`` started afresh (no fork: no inherited threads, locks or compiled
  code), with one thread for OpenMP, BLAS and Numba, the caller's working directory, its import
  path, its standard error kept for the reason, its standard output discarded. A caller may keep
  the process under a name for its next call (``reuse``); one that gave no answer is never kept.
- **Limits**: wall-clock seconds and bytes of resident memory of the process with its children,
  both including start-up and imports. Address space is limited too, to four times the memory and
  8 GiB for the libraries, where the system knows such limits, so that one absurd allocation
  fails at once.
- **No orphans**: the process and its children are killed when a limit is passed, on ctrl-C, on
  any exception in the caller; and when the caller itself is killed, the process ends by itself.
  Ctrl-C in a terminal reaches the caller only.
- Times that are to be compared are taken inside the work: `Outcome.seconds` contains the start of
  Python and all imports.
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
from typing import Any, Final, Literal

import numpy as np
import psutil

Ended = Literal["answered", "raised", "hung", "out of memory", "killed", "malformed"]
ANSWERED: Final = "answered"
RAISED: Final = "raised"
HUNG: Final = "hung"
OUT_OF_MEMORY: Final = "out of memory"
KILLED: Final = "killed"
MALFORMED: Final = "malformed"
# Names of the files through which the two processes speak, and of the JSON part of an answer.
WORK, ANSWER, ERROR, DONE = "work.pickle", "answer.npz", "error.json", "done"
DOCUMENT = "json"
ONE_THREAD = (
    *("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"),
    *("VECLIB_MAXIMUM_THREADS", "BLIS_NUM_THREADS", "NUMEXPR_NUM_THREADS"),
)
# Seconds between looks at the memory (at first, later), and that a killed process may take to go.
_SHORTEST_LOOK, _LOOK, _FAREWELL = 0.002, 0.05, 10.0
_LIBRARIES = 8 * 2**30


@dataclass(frozen=True)
class Limits:
    """Wall-clock seconds of work, and bytes of resident memory of its process."""

    seconds: float
    memory: float


@dataclass(frozen=True)
class Outcome:
    """How isolated work ended.

    Attributes
    ----------
    ended : str
        "answered", "raised", "hung" (time limit), "out of memory" (limit passed, or MemoryError),
        "killed" (the process died: a signal, or an exit of its own), "malformed" (the answer is
        missing, unreadable, no dict, or not finite).
    answer : dict
        What the work returned; empty unless `ended` is "answered".
    reason : str
        Why there is no answer, in plain words for a table; empty with one.
    seconds, memory : float
        Wall-clock time from start to end, and the largest resident memory seen, in bytes.
    """

    ended: Ended
    answer: dict[str, Any] = field(default_factory=dict)
    reason: str = ""
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
) -> Outcome:
    """Call a function in a process of its own, and say how it ended. See the module's contract.

    Parameters
    ----------
    work : str
        ``"package.module:function"``.
    *arguments
        Its positional arguments, picklable.
    seconds, memory : float, optional
        Limits: wall-clock seconds, bytes of resident memory. None is no limit.
    finite : bool
        Refuse an answer that holds NaN or infinities.
    reuse : str
        A name under which the process is kept for the next call, as long as it answers; by
        default it ends after this one.

    Raises
    ------
    ValueError
        If `work` names no function, or a limit is not positive. Failures of the work raise
        nothing.

    Examples
    --------
    >>> run("json:loads", '{"force": 2.5}', seconds=60).answer
    {'force': 2.5}
    >>> run("json:loads", "no JSON", seconds=60).ended
    'raised'
    """
    _check(work, seconds, memory)
    process = _waiting.pop(reuse, None)
    if process is None or not process.is_ours():
        process = _Process(stays=bool(reuse))
    outcome = None
    try:
        outcome = process.call((work, arguments, memory), seconds, finite)
    finally:
        if reuse and outcome is not None and outcome.ok:
            _waiting[reuse] = process
        else:
            process.end()
    if outcome.ended == OUT_OF_MEMORY and process.calls > 1:
        # Perhaps for what earlier calls have left there.
        return run(work, *arguments, seconds=seconds, memory=memory, finite=finite, reuse=reuse)
    return outcome


def address_space(memory: float) -> int:
    """Return the limit of address space, in bytes, that goes with a limit of memory."""
    return int(4 * memory + _LIBRARIES)


def _check(work: str, seconds: float | None, memory: float | None) -> None:
    module, colon, function = work.partition(":")
    problems = []
    if not (colon and module and function.isidentifier()):
        problems.append(f"work: expected 'module:function', got {work!r}")
    for name, limit in {"seconds": seconds, "memory": memory}.items():
        if limit is not None and not limit > 0:
            problems.append(f"{name}: expected a positive limit, got {limit!r}")
    if problems:
        raise ValueError("; ".join(problems))


class _Process:
    """A process started afresh, and the folder through which its work and its answers go."""

    def __init__(self, *, stays: bool) -> None:
        self.calls = 0
        self._stays = stays
        self._caller = os.getpid()
        # One that has escaped from its parent may go on writing there: no error of ours.
        self._holder = tempfile.TemporaryDirectory(prefix="roughline-", ignore_cleanup_errors=True)
        self._folder = Path(self._holder.name)
        root = str(Path(__file__).resolve().parents[2])
        paths = [root, *(path for path in sys.path if path)]
        environment = os.environ | dict.fromkeys(ONE_THREAD, "1")
        environment["PYTHONPATH"] = os.pathsep.join(dict.fromkeys(paths))
        flags = ["stays"] if stays else []
        with (self._folder / "stderr").open("wb") as errors:
            self._process = subprocess.Popen(  # noqa: S603 (our own interpreter and module)
                [
                    sys.executable,
                    "-P",
                    "-m",
                    "comparisons.isolation.child",
                    str(self._folder),
                    *flags,
                ],
                # The open pipe tells the process that we live; it ends itself when the pipe
                # closes. A byte tells it that there is work.
                stdin=subprocess.PIPE,
                stdout=subprocess.DEVNULL,
                stderr=errors,
                env=environment,
                start_new_session=True,  # ctrl-C in the terminal is ours alone
            )

    def is_ours(self) -> bool:
        """Tell whether it lives, and was started by this process, not by one that we copy."""
        return self._caller == os.getpid() and self._process.poll() is None

    def call(self, task: tuple[Any, ...], seconds: float | None, finite: bool) -> Outcome:
        """Hand over (work, arguments, memory), and wait for the answer or the end."""
        self.calls += 1
        for name in (ANSWER, ERROR, DONE):
            (self._folder / name).unlink(missing_ok=True)
        (self._folder / WORK).write_bytes(pickle.dumps(task))
        start, memory = time.perf_counter(), task[-1]
        assert self._process.stdin is not None
        with contextlib.suppress(BrokenPipeError):  # it has ended: that is seen at once
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
        """Leave nothing of it behind."""
        if self._caller == os.getpid():
            _kill(self._process)
            self._holder.cleanup()


# Processes between two calls, by the name under which they are kept.
_waiting: dict[str, _Process] = {}


@atexit.register
def _end_waiting() -> None:
    while _waiting:
        _waiting.popitem()[1].end()


def _kill(process: subprocess.Popen[bytes]) -> None:
    """End the process and all it has started; a ctrl-C waits until they are gone."""
    with _interrupts_wait():
        try:
            children = psutil.Process(process.pid).children(recursive=True)
        except psutil.NoSuchProcess:
            children = []
        if hasattr(os, "killpg"):
            # The session's group outlives its leader while any child of it is left.
            with contextlib.suppress(ProcessLookupError, PermissionError):
                os.killpg(process.pid, signal.SIGKILL)
        for descendant in children:
            with contextlib.suppress(psutil.NoSuchProcess):
                descendant.kill()
        if process.poll() is None:
            process.kill()
        process.wait(_FAREWELL)
        # What is still ending may still be writing into the folder, which goes next.
        psutil.wait_procs(children, _FAREWELL)
        if process.stdin is not None:
            process.stdin.close()


@contextlib.contextmanager
def _interrupts_wait() -> Iterator[None]:
    """Let a ctrl-C take effect after the block."""
    handler = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or not callable(handler):
        yield
        return
    pressed: list[tuple[int, FrameType | None]] = []
    signal.signal(signal.SIGINT, lambda number, frame: pressed.append((number, frame)))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, handler)
    if pressed:
        handler(*pressed[-1])


def _watch(
    process: subprocess.Popen[bytes],
    done: Path | None,
    start: float,
    seconds: float | None,
    memory: float | None,
) -> tuple[Ended | None, float]:
    """Wait until the process ends or says `done`; return the limit that was passed, and the peak.

    The limit is None where none was passed; the peak is that of memory.
    """
    peak, look = 0.0, _SHORTEST_LOOK
    while True:
        try:
            process.wait(look)
        except subprocess.TimeoutExpired:
            peak = max(peak, _resident(process.pid))
        else:
            return None, peak
        if done is not None and done.exists():
            return None, peak
        if memory is not None and peak > memory:
            return OUT_OF_MEMORY, peak
        if seconds is not None and time.perf_counter() - start > seconds:
            return HUNG, peak
        look = min(2 * look, _LOOK)


def _resident(pid: int) -> float:
    total = 0.0
    with contextlib.suppress(psutil.NoSuchProcess, psutil.AccessDenied):
        process = psutil.Process(pid)
        for member in (process, *process.children(recursive=True)):
            with contextlib.suppress(psutil.NoSuchProcess, psutil.AccessDenied):
                total += member.memory_info().rss
    return total


def _read(folder: Path, code: int, finite: bool) -> tuple[Ended, dict[str, Any], str]:
    """Return how the work ended by itself, its answer, and the reason where there is none."""
    try:
        error = json.loads((folder / ERROR).read_text(encoding="utf-8"))
        return error["ended"], {}, error["reason"]
    except (OSError, ValueError, KeyError, TypeError):
        pass
    if code != 0:
        return KILLED, {}, _death(code, folder / "stderr")
    try:
        answer = _load(folder / ANSWER)
    except FileNotFoundError:
        return MALFORMED, {}, "the process ended without an answer"
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as problem:
        return MALFORMED, {}, f"the answer cannot be read: {problem}"
    wrong = [name for name, value in answer.items() if finite and not _is_finite(value)]
    if wrong:
        return MALFORMED, {}, f"the answer is not finite: {', '.join(wrong)}"
    return ANSWERED, answer, ""


def _load(path: Path) -> dict[str, Any]:
    with np.load(path, allow_pickle=False) as stored:
        answer: dict[str, Any] = json.loads(str(stored[DOCUMENT]))
        arrays = {name: stored[name] for name in stored.files if name != DOCUMENT}
    return answer | {name.removeprefix("a."): value for name, value in arrays.items()}


def _is_finite(value: Any) -> bool:
    if isinstance(value, np.ndarray):
        return value.dtype.kind not in "fc" or bool(np.isfinite(value).all())
    if isinstance(value, dict):
        return all(_is_finite(entry) for entry in value.values())
    if isinstance(value, list):
        return all(_is_finite(entry) for entry in value)
    return not isinstance(value, float) or bool(np.isfinite(value))


def _death(code: int, errors: Path) -> str:
    """Say what ended a process, with the last line that it wrote."""
    if code < 0:
        try:
            name = signal.Signals(-code).name
        except ValueError:
            name = str(-code)
        text = f"the process was ended by signal {name}"
        if name == "SIGKILL":
            text += ", which the system sends when memory runs out"
    else:
        text = f"the process ended itself with exit code {code}"
    lines = errors.read_text(encoding="utf-8", errors="replace").strip().splitlines()
    return f"{text}: {lines[-1][:200]}" if lines else text
