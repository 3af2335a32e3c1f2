"""Compiled functions: of several processes that need one, one compiles it, the others read it.

Numba keeps compiled code in files, but knows no locks: processes that need a function at the same
time each compile it.
"""

from __future__ import annotations

import hashlib
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any

from numba.core.compiler_lock import global_compiler_lock
from numba.core.dispatcher import Dispatcher

from comparisons.solving.locks import alone

# Seconds to wait for a process that compiles: the longest functions take a few. One that is stopped
# holds others up so long, for one function, and they compile it themselves.
_PATIENCE = 60.0

_compile = Dispatcher.compile


def compile_in_turn(folder: Path) -> None:
    """Let this process compile a function only while no other one does.

    Waiting is safe: a function is waited for by those that call it, never the other way round, and
    what calls itself is compiled within its own turn.

    Parameters
    ----------
    folder : Path
        What the processes have in common, for locks; they go with it.
    """
    begun: set[Path] = set()

    def compile_alone(self: Any, sig: Any) -> Any:
        with global_compiler_lock, ExitStack() as turn:  # first the lock among our own threads
            lock = folder / f"{_digest(self.py_func)}.lock"
            if self.stats.cache_path is not None and lock not in begun:
                with suppress(OSError):  # a full disk has no room for locks
                    turn.enter_context(alone(lock, _PATIENCE))
                begun.add(lock)
                turn.callback(begun.discard, lock)
            return _compile(self, sig)

    Dispatcher.compile = compile_alone  # type: ignore[method-assign]


def _digest(function: Any) -> str:
    name = f"{function.__module__}.{function.__qualname__} {function.__code__.co_firstlineno}"
    return hashlib.sha256(name.encode()).hexdigest()[:32]
