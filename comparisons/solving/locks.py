"""Locks among the processes of a machine, where the system knows such locks."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterator
from pathlib import Path
from typing import IO

# Seconds between two looks at a lock that is not waited for without end.
_PAUSE = 0.02


@contextlib.contextmanager
def alone(path: Path, seconds: float | None = None) -> Iterator[IO[bytes]]:
    """Hold a lock; wait while another process holds it. One that ends lets go.

    After some seconds, if any, go on without it: one that is stopped does not let go.
    """
    with path.open("wb") as stream:
        with contextlib.suppress(ImportError, OSError):  # some shared file systems have none
            _hold(stream, seconds)
        yield stream


def _hold(stream: IO[bytes], seconds: float | None) -> None:
    import fcntl

    if seconds is None:
        fcntl.flock(stream, fcntl.LOCK_EX)
        return
    last = time.monotonic() + seconds
    while time.monotonic() < last:
        with contextlib.suppress(BlockingIOError):
            fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return
        time.sleep(_PAUSE)


def busy(path: Path) -> bool:
    """Return whether another process holds a lock."""
    try:
        import fcntl
    except ImportError:
        return False
    try:
        with path.open("wb") as stream:
            fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        pass  # no lock can be held there
    return False
