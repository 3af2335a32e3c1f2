"""The process started by `comparisons.isolation.parent`: reads work, writes answers and errors.

Another environment's interpreter runs this file by its path: it imports nothing but NumPy.
"""

from __future__ import annotations

import ctypes
import importlib
import json
import os
import pickle
import runpy
import signal
import sys
import threading
import traceback
from pathlib import Path
from queue import SimpleQueue
from typing import Any, Final, Literal

import numpy as np

Ended = Literal["answered", "raised", "hung", "out of memory", "killed", "malformed"]
ANSWERED: Final = "answered"
RAISED: Final = "raised"
HUNG: Final = "hung"
OUT_OF_MEMORY: Final = "out of memory"
KILLED: Final = "killed"
MALFORMED: Final = "malformed"
# Names of the files that the two processes exchange, and of the JSON part of an answer.
WORK, ANSWER, ERROR, DONE = "work.pickle", "answer.npz", "error.json", "done"
DOCUMENT = "json"

_PR_SET_PDEATHSIG = 1
_LIBRARIES = 8 * 2**30


def main(folder: Path, *, stays: bool) -> None:
    """Do the work of a folder at every call of the parent, once or repeatedly."""
    if sys.platform == "linux":
        # Exit at once, even while compiled code holds the interpreter.
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    # A separate handle of the pipe, in case the work reads or closes standard input.
    pipe = os.dup(0)
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    calls: SimpleQueue[bytes] = SimpleQueue()
    threading.Thread(target=_listen, args=(pipe, calls), daemon=True).start()
    while calls.get():
        _answer(folder)
        if not stays:
            return
        (folder / DONE).touch()


def _answer(folder: Path) -> None:
    """Do the work of a folder, and write its answer or error into the folder."""
    try:
        # The pickle is trusted, as the parent has just written it.
        work, arguments, memory = pickle.loads((folder / WORK).read_bytes())  # noqa: S301
        if memory is not None and sys.platform != "win32":
            import resource

            limit = int(4 * memory + _LIBRARIES)
            _, hard = resource.getrlimit(resource.RLIMIT_AS)
            if hard == resource.RLIM_INFINITY or limit < hard:
                resource.setrlimit(resource.RLIMIT_AS, (limit, hard))
        module, _, name = work.rpartition(":")
        if module.endswith(".py"):
            function = runpy.run_path(module)[name]
        else:
            function = getattr(importlib.import_module(module), name)
        answer = function(*arguments)
    except MemoryError:
        _report(folder, OUT_OF_MEMORY, "no memory left for an allocation")
    except BaseException as error:
        if isinstance(error, SystemExit):
            raise
        frames = traceback.extract_tb(error.__traceback__)
        where = f" (in {frames[-1].name})" if len(frames) > 1 else ""
        name, text = type(error).__name__, str(error)
        _report(folder, RAISED, f"{name}: {text}{where}" if text else f"{name}{where}")
    else:
        try:
            _write(folder / ANSWER, answer)
        except (TypeError, ValueError) as error:
            _report(folder, MALFORMED, f"the answer cannot be transferred: {error}")


def _report(folder: Path, ended: Ended, reason: str) -> None:
    text = json.dumps({"ended": ended, "reason": reason})
    (folder / ERROR).write_text(text, encoding="utf-8")


def _write(path: Path, answer: Any) -> None:
    """Write an answer as npz: arrays unchanged, everything else as one JSON text."""
    if not isinstance(answer, dict) or not all(isinstance(key, str) for key in answer):
        raise TypeError(f"expected a dict with text keys, got {type(answer).__name__}")
    arrays = {key: value for key, value in answer.items() if isinstance(value, np.ndarray)}
    refused = [key for key, value in arrays.items() if value.dtype.kind not in "biufcUS"]
    if refused:
        raise TypeError(f"arrays of objects: {', '.join(refused)}")
    plain_entries = {
        key: value.item() if isinstance(value, np.generic) else value
        for key, value in answer.items()
        if key not in arrays
    }
    members = {f"a.{key}": value for key, value in arrays.items()}
    members[DOCUMENT] = np.array(json.dumps(plain_entries))
    partial = path.with_suffix(".part")
    with partial.open("wb") as file:
        np.savez(file, allow_pickle=False, **members)
    partial.replace(path)


def versions(packages: list[str]) -> dict[str, str]:
    """Return the version of each package of this interpreter, "" where it is not installed."""
    from importlib import metadata

    found = {}
    for name in packages:
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            found[name] = ""
    return found


def _listen(pipe: int, calls: SimpleQueue[bytes]) -> None:
    while call := os.read(pipe, 1):
        calls.put(call)
    os._exit(1)


if __name__ == "__main__":
    main(Path(sys.argv[1]), stays="stays" in sys.argv[2:])
