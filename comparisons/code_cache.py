"""Where compiled code is kept, and that it is not older than its sources.

Numba keeps it beside the sources, else in the user's cache, else it refuses to define a function:
a package that an administrator has installed would not even be imported by a user without a home
(batch jobs, containers, web servers). There a folder in the temporary one serves. Cached code is
run when it is read, so that folder must be this user's, and nobody else may write to it.

Numba compiles a function anew when its own file has changed, but not when a function that it calls
in another file has: after an update the old number would come, or an error about a name that is
gone. So what is older than any file that its module imports is removed first.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import re
import stat
import sys
from collections.abc import Iterator
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


def remove_outdated() -> None:
    """Remove compiled functions that are older than a file which their module imports.

    To be called before any of them is loaded, after `choose_folder`.
    """
    changed = dict(_sources())
    compiled = [
        (folder / f"{index.name.partition('.')[0]}.py", Path(index.path), index.stat().st_mtime_ns)
        for folder in {path.parent for path in changed}
        for place in _places(folder)
        for index in _files(place, ".nbi")
    ]
    newest = max(changed.values(), default=0)
    if all(made > newest for _, _, made in compiled):
        return  # nearly always: nothing has to be read
    imported = {path: _imported(path) & changed.keys() for path in changed}
    for path, index, made in compiled:
        if path not in changed or made <= max(changed[file] for file in _reached(path, imported)):
            for file in index.parent.glob(f"{index.stem}.*nb[ic]"):
                file.unlink(missing_ok=True)


def _sources() -> Iterator[tuple[Path, int]]:
    for package in COMPILED:
        for folder, _, _ in os.walk(HOME / package):
            for file in _files(Path(folder), ".py"):
                yield Path(file.path), file.stat().st_mtime_ns


def _files(folder: Path, ending: str) -> Iterator[os.DirEntry[str]]:
    with contextlib.suppress(OSError), os.scandir(folder) as files:
        yield from (file for file in files if file.name.endswith(ending))


def _places(folder: Path) -> Iterator[Path]:
    """Return where Numba may keep compiled functions of a folder (numba/core/caching.py)."""
    digest = hashlib.sha1(str(folder).encode(), usedforsecurity=False).hexdigest()
    yield folder / "__pycache__"
    yield _of_the_user() / f"{folder.name}_{digest}"
    if os.environ.get(VARIABLE):
        yield Path(os.environ[VARIABLE]) / f"{folder.name}_{digest}"


_IMPORT = re.compile(rf"^from ((?:{'|'.join(COMPILED)})[\w.]*) import (\([^)]*\)|.*)", re.MULTILINE)


def _imported(source: Path) -> set[Path]:
    """Return what may be the files of the modules that a file imports from our packages."""
    files = set()
    for module, names in _IMPORT.findall(source.read_text(encoding="utf-8")):
        place = HOME.joinpath(*module.split("."))
        files |= {place.with_suffix(".py"), place / "__init__.py"}
        files |= {place / f"{name}.py" for name in re.findall(r"\w+", names)}
    return files


def _reached(source: Path, imported: dict[Path, set[Path]]) -> set[Path]:
    """Return a file with all that it imports, directly or through others."""
    reached, waiting = {source}, [source]
    while waiting:
        new = imported[waiting.pop()] - reached
        reached |= new
        waiting.extend(new)
    return reached


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
