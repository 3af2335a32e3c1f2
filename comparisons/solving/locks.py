"""Locks among the processes of a machine, where the file system knows them."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path

# Seconds between two looks at a lock that another process holds.
_PAUSE = 0.02


@contextlib.contextmanager
def alone(path: Path, seconds: float = -1.0) -> Iterator[None]:
    """Hold a lock; wait while another process holds it. One that ends lets go.

    After some seconds, if any, go on without it: one that is stopped does not let go.
    """
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
