"""Results that several jobs need: one process of a run computes each, the others read it.

Jobs are independent, and processes share no memory, so what two jobs have in common (an ensemble of
surfaces pressed at one load) every process would compute for itself. A function marked `shared`
keeps its results in the process, and in a folder that the processes of a run on one machine have
in common. Elsewhere (a cluster, one process) the folder is missing, and each computes its own.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import pickle
import tempfile
from collections.abc import Callable, Iterable, Iterator
from functools import lru_cache, update_wrapper
from pathlib import Path
from typing import Any, Generic, ParamSpec, TypeVar, cast

import numpy as np

# Seconds between two looks at a lock that another process holds.
_PAUSE = 0.02


@contextlib.contextmanager
def alone(path: Path, seconds: float = -1.0) -> Iterator[None]:
    """Hold a lock; wait while another process holds it, at most for some seconds, then go on."""
    from filelock import FileLock

    lock = FileLock(path)
    with contextlib.suppress(OSError):  # the time is over, a disk is full, some systems have none
        lock.acquire(seconds, poll_interval=_PAUSE)
    try:
        yield
    finally:
        lock.release()


def busy(path: Path) -> bool:
    """Return whether another process holds a lock."""
    from filelock import FileLock, Timeout

    try:
        with FileLock(path).acquire(0.0):
            return False
    except Timeout:
        return True
    except OSError:
        return False  # no lock can be held there


P = ParamSpec("P")
R = TypeVar("R")
VARIABLE = "ROUGHLINE_SHARED"  # environment: the folder


@lru_cache(maxsize=1)
def _folder() -> tempfile.TemporaryDirectory[str]:
    return tempfile.TemporaryDirectory(prefix="roughline-shared-")


def folder() -> str:
    """Return the folder of this process and those that it starts; it goes when this one ends."""
    return _folder().name


class Shared(Generic[P, R]):
    """A function whose results the processes of a run share; `maxsize` stay in a process's memory.

    Its arguments must be hashable, and their ``repr`` must tell them apart: numbers, texts, frozen
    dataclasses of these. Its results are picklable; no caller may change them. They travel as all
    else does among our own processes, through a folder that only this user can open.
    """

    def __init__(self, function: Callable[P, R], maxsize: int) -> None:
        self._function = function
        kept = lru_cache(maxsize)(self._looked_up)
        self._kept: Callable[..., R] = kept
        self.cache_clear = kept.cache_clear  # forgets what this process has in memory
        update_wrapper(self, function)

    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> R:
        """Return the result, computed here, earlier, or by another process."""
        return self._kept(*args, **kwargs)

    def over(self, several: Iterable[tuple[Any, ...]]) -> list[R]:
        """Return the results for several tuples of arguments; what others do comes last."""
        arguments = list(several)
        results: dict[tuple[Any, ...], R] = {}
        waiting = []
        for call in dict.fromkeys(arguments):
            path = self._path(call, {})
            if path is not None and not path.exists() and busy(_lock(path)):
                waiting.append(call)
            else:
                results[call] = self._kept(*call)
        for call in waiting:
            results[call] = self._kept(*call)
        return [results[call] for call in arguments]

    def _looked_up(self, *args: P.args, **kwargs: P.kwargs) -> R:
        path = self._path(args, kwargs)
        if path is None:
            return self._function(*args, **kwargs)
        with contextlib.ExitStack() as held:
            with contextlib.suppress(OSError):  # a full disk may have no room for a lock either
                held.enter_context(alone(_lock(path)))
            if path.exists():
                return cast("R", pickle.loads(path.read_bytes()))  # noqa: S301 (our own process's)
            result = self._function(*args, **kwargs)
            # Whole or not at all: a process may be ended at any time, a disk be full.
            part = path.with_suffix(f".{os.getpid()}")
            try:
                part.write_bytes(pickle.dumps(result))
                part.replace(path)
            except OSError:  # the others compute their own
                with contextlib.suppress(OSError):
                    part.unlink()
        return result

    def _path(self, args: tuple[Any, ...], kwargs: dict[str, Any]) -> Path | None:
        """Return the file of a result, None where there is no common folder."""
        common = os.environ.get(VARIABLE, "")
        if not common or not Path(common).is_dir():
            return None
        name = f"{self._function.__module__}.{self._function.__qualname__}"
        plain = tuple(_plain(value) for value in args)
        named = sorted((key, _plain(value)) for key, value in kwargs.items())
        identity = repr((name, plain, named))
        return Path(common) / hashlib.sha256(identity.encode()).hexdigest()[:32]


def shared(maxsize: int = 64) -> Callable[[Callable[P, R]], Shared[P, R]]:
    """Share the results of a function among the processes of a run; see `Shared`."""
    return lambda function: Shared(function, maxsize)


def _lock(path: Path) -> Path:
    return path.with_suffix(".lock")


def _plain(value: Any) -> Any:
    """Return a number of NumPy's, on its own or in tuples, as Python's that equals it."""
    if isinstance(value, tuple):
        return tuple(_plain(part) for part in value)
    return value.item() if isinstance(value, np.generic) else value
