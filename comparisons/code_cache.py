"""Where compiled code is kept if neither the package nor the user's home can be written to.

Numba keeps it beside the sources, else in the user's cache, else it refuses to define a function:
a package that an administrator has installed would not even be imported by a user without a home
(batch jobs, containers, web servers). There a folder in the temporary one serves. Cached code is
run when it is read, so that folder must be this user's, and nobody else may write to it.
"""

from __future__ import annotations

import contextlib
import os
import stat
import sys
from pathlib import Path

VARIABLE = "NUMBA_CACHE_DIR"  # inherited by the processes that we start
HOME = Path(__file__).resolve().parent.parent
COMPILED = ("reduced", "reference")  # packages with functions that Numba compiles


def choose_folder() -> None:
    """Name a folder to Numba where it would find none itself; else leave it alone.

    To be called before any function is compiled. Where no folder at all can be written to, Numba's
    own error says so.
    """
    if os.name != "posix":  # homes on Windows can be written to
        return
    folder_set = os.environ.get(VARIABLE)
    if (
        (folder_set and _may_write(Path(folder_set)))
        or _beside_the_sources()
        or _may_write(_of_the_user())
    ):
        return
    with contextlib.suppress(OSError):
        folder = str(_in_the_temporary_folder())
        os.environ[VARIABLE] = folder
        if "numba" in sys.modules:  # has read the variable already
            sys.modules["numba"].config.CACHE_DIR = folder


def _may_write(folder: Path) -> bool:
    """Tell whether files can be made in a folder, which itself may have to be made."""
    for place in (folder, *folder.parents):
        if os.path.exists(place):  # as far as we may look
            return os.path.isdir(place) and os.access(place, os.W_OK | os.X_OK)
    return False


def _beside_the_sources() -> bool:
    folders = (folder for package in COMPILED for folder, _, _ in os.walk(HOME / package))
    return all(
        _may_write(Path(folder) / "__pycache__")
        for folder in folders
        if not folder.endswith("__pycache__")
    )


def _of_the_user() -> Path:
    """Return Numba's folder in the cache of the user."""
    if sys.platform == "darwin":
        return Path(os.path.expanduser("~/Library/Caches/numba"))
    return Path(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")) / "numba"


def _in_the_temporary_folder() -> Path:
    """Return a folder that is ours alone, the same one every time if nobody is in its way.

    Raises
    ------
    OSError
        If no temporary folder can be written to.
    """
    import tempfile

    folder = Path(tempfile.gettempdir()) / f"roughline-{os.getuid()}"
    with contextlib.suppress(FileExistsError):
        folder.mkdir(mode=0o700)
    status = folder.lstat()  # a link is nobody's folder
    ours = stat.S_ISDIR(status.st_mode) and status.st_uid == os.getuid()
    if ours and not status.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
        return folder
    return Path(tempfile.mkdtemp(prefix="roughline-"))
