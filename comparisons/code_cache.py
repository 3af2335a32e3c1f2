"""Where compiled code is kept: in a folder named by a digest of all compiled sources.

Numba compiles a function anew when its own file has changed, but not when a function that it calls
in another file has: after an update the old number would come, or an error about a name that is
gone. With the digest in the name nothing old is found. Cached code is run when it is read, so the
folder must be this user's, and nobody else may write to it. Users without a home (batch jobs,
containers, web servers) get one in the temporary folder.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import shutil
import stat
import sys
import time
from pathlib import Path

VARIABLE = "NUMBA_CACHE_DIR"  # inherited by the processes that we start
HOME = Path(__file__).resolve().parent.parent
COMPILED = ("reduced", "reference")  # packages with functions that Numba compiles
NAME = "numba-"  # of the folder, before the digest
# Seconds after which the code of sources that nobody has used is removed.
_UNUSED = 30 * 86400.0


def choose_folder() -> None:
    """Name the folder to Numba; one that is in the environment already is the parent of ours.

    To be called before any function is compiled. Where no folder at all can be written to, Numba
    keeps its own places, or says so.
    """
    chosen = os.environ.get(VARIABLE, "")
    parent = Path(chosen).parent if Path(chosen).name.startswith(NAME) else Path(chosen)
    with contextlib.suppress(OSError):
        if not (chosen and _may_write(parent)):  # the cache of the user
            if sys.platform == "darwin":
                caches = os.path.expanduser("~/Library/Caches")
            else:
                caches = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
            parent = Path(caches) / "roughline"
        if not _may_write(parent):
            parent = _in_the_temporary_folder()
        # Compiled functions call functions of files with Numba only, and use no constants of others
        # (a test reads their imports).
        digest = hashlib.sha256()
        for package in COMPILED:
            for path in sorted((HOME / package).rglob("*.py")):
                content = path.read_bytes()
                if b"numba" in content:
                    digest.update(path.relative_to(HOME).as_posix().encode() + b"\0" + content)
        folder = parent / f"{NAME}{digest.hexdigest()[:16]}"
        folder.mkdir(parents=True, exist_ok=True)
        os.utime(folder)
        os.environ[VARIABLE] = str(folder)
        if "numba" in sys.modules:  # has read the variable already
            sys.modules["numba"].config.CACHE_DIR = str(folder)
        for other in parent.glob(f"{NAME}*"):
            if time.time() - other.stat().st_mtime > _UNUSED:
                shutil.rmtree(other, ignore_errors=True)


def _may_write(folder: Path) -> bool:
    """Tell whether files can be made in a folder, which itself may have to be made."""
    for place in (folder, *folder.parents):
        if os.path.exists(place):  # as far as we may look
            return os.path.isdir(place) and os.access(place, os.W_OK | os.X_OK)
    return False


def _in_the_temporary_folder() -> Path:
    """Return a folder that is ours alone, the same one every time if nobody is in its way."""
    import tempfile

    if os.name != "posix":  # temporary folders are the user's own
        return Path(tempfile.gettempdir()) / "roughline"
    folder = Path(tempfile.gettempdir()) / f"roughline-{os.getuid()}"
    with contextlib.suppress(FileExistsError):
        folder.mkdir(mode=0o700)
    status = folder.lstat()  # a link is nobody's folder
    ours = stat.S_ISDIR(status.st_mode) and status.st_uid == os.getuid()
    if ours and not status.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
        return folder
    return Path(tempfile.mkdtemp(prefix="roughline-"))
