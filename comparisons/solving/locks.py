"""Locks among the processes of a machine, where the system knows such locks."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import IO


@contextlib.contextmanager
def alone(path: Path) -> Iterator[IO[bytes]]:
    """Hold a lock; wait while another process holds it. One that ends lets go."""
    with path.open("wb") as stream:
        with contextlib.suppress(ImportError, OSError):  # some shared file systems have none
            import fcntl

            fcntl.flock(stream, fcntl.LOCK_EX)
        yield stream


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
