"""How files are written, whole or not at all, never in place of what is no file; TOML is read.

In a results folder a name is ours: whatever stands there is replaced, a link as well, since results
come from strangers and must not lead out of their folder. A name that a user gives is theirs: a
link stays and its target is replaced, a pipe or a device (``/dev/stdout``) is written through.
Tables are CSV with every digit, arrays are npz that nobody ever unpickles, documents plain JSON.
"""

from __future__ import annotations

import errno
import io
import math
import os
import re
import stat
import sys
import tempfile
import tomllib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np

from comparisons.errors import ResultsError

if TYPE_CHECKING:
    import pandas as pd

Write = Callable[[BinaryIO], object]
_MOST_LINKS = 40


def write_atomically(path: Path, write: Write) -> None:
    """Call ``write`` on a temporary file beside `path`, then rename it to `path`.

    A file that is replaced hands its permissions on. OSError names the file.
    """
    temporary = ""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, temporary = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.parent)
        with os.fdopen(handle, "wb") as stream:
            write(stream)
            stream.flush()
            os.fsync(stream.fileno())
        # mkstemp makes private files; results are meant to be read by others.
        try:
            replaced = path.lstat().st_mode
        except FileNotFoundError:
            replaced = 0
        if stat.S_ISREG(replaced):
            permissions = replaced & 0o777
        else:  # those of any new file of this process
            umask = os.umask(0)
            os.umask(umask)
            permissions = 0o666 & ~umask
        Path(temporary).chmod(permissions)
        Path(temporary).replace(path)
    except BaseException as error:
        if temporary:
            Path(temporary).unlink(missing_ok=True)
        _name(error, path)
        raise


def write_named(path: Path, write: Write) -> None:
    """Write to what a user named: a file atomically, a pipe or a device through it.

    A link stays: the file that it leads to is replaced. OSError has the name that was given.
    """
    try:
        descriptor = _own_descriptor(path)
        if descriptor is not None:
            # A shell may have sent it to a file in which it goes on writing: no other file will do.
            for stream in (sys.stdout, sys.stderr):
                stream.flush()
            with os.fdopen(os.dup(descriptor), "wb") as target:
                write(target)
        elif path.exists() and not path.is_file():
            with path.open("wb") as target:
                write(target)
        else:
            write_atomically(Path(os.path.realpath(path)), write)
    except OSError as error:
        _name(error, path)
        raise


def write_text(path: Path, text: str) -> None:
    """Write a text file atomically (UTF-8)."""
    write_atomically(path, lambda stream: stream.write(text.encode()))


def write_named_text(path: Path, text: str) -> None:
    """Write a text (UTF-8) to what a user named."""
    write_named(path, lambda stream: stream.write(text.encode()))


def _own_descriptor(path: Path) -> int | None:
    """Return the number of the open file of this process that a path such as /dev/stdout names."""
    # Folders that list the open files of this very process (Linux; macOS and BSD).
    listing = (f"/proc/{os.getpid()}/fd", "/dev/fd")
    for _ in range(_MOST_LINKS):
        folder = os.path.realpath(path.parent)
        if folder in listing and path.name.isdecimal():
            return int(path.name)
        if not path.is_symlink():
            return None
        path = Path(folder) / path.readlink()
    raise OSError(errno.ELOOP, os.strerror(errno.ELOOP), str(path))


def _name(error: BaseException, path: Path) -> None:
    """Let an error of the system name the file that was asked for, not a temporary one."""
    if isinstance(error, OSError) and error.errno is not None:
        error.filename = str(path)
        del error.filename2  # None would be told, too


def write_table(path: Path, table: pd.DataFrame) -> None:
    """Write a data frame as CSV, atomically and with every digit."""
    write_text(path, table_text(table))


def table_text(table: pd.DataFrame) -> str:
    """Return a data frame as CSV."""
    return table.to_csv(index=False, lineterminator="\n")


def write_arrays(path: Path, arrays: Mapping[str, np.ndarray]) -> None:
    """Write named arrays as a compressed npz, atomically."""
    packed = io.BytesIO()  # which is there still when an interrupted archive closes itself
    try:
        np.savez_compressed(packed, allow_pickle=False, **arrays)
    except ValueError as error:
        if isinstance(error.__context__, KeyboardInterrupt):  # a member was just being opened
            raise KeyboardInterrupt from error
        raise
    write_atomically(path, lambda stream: stream.write(packed.getbuffer()))


def read_arrays(path: Path) -> dict[str, np.ndarray]:
    """Read an npz without ever unpickling; ResultsError for a torn file or other contents."""
    try:
        with np.load(path, allow_pickle=False) as archive:
            return {name: archive[name] for name in archive.files}
    except Exception as error:  # zipfile, zlib, numpy and the OS each raise their own
        raise ResultsError(f"{path}: not a readable array file ({error})") from error


def plain(value: Any) -> Any:
    """Return JSON's types; NaN and infinities, which JSON does not know, become None.

    >>> plain({"a": np.array([1.0, np.nan]), "b": (np.float64(2.0), "c")})
    {'a': [1.0, None], 'b': [2.0, 'c']}
    """
    if isinstance(value, dict):
        return {key: plain(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(entry) for entry in value]
    if isinstance(value, (np.ndarray, np.generic)):
        return plain(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


LARGEST_FILE = 10_000_000
# The parser's time and memory grow with the square of the parts of a dotted key.
DEEPEST_KEY = 20
KEYS = re.compile(r"^[ \t]*\[{0,2}((?:[\w\"'-]+[ \t]*\.[ \t]*)+)", re.MULTILINE)


def read_toml(file: Path) -> dict[str, Any]:
    """Read the tables of a file; ValueError where it is too large, no text, or no TOML."""
    try:
        if file.stat().st_size > LARGEST_FILE:
            raise ValueError(f"expected at most {LARGEST_FILE} bytes")
        text = file.read_bytes().decode("utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise ValueError(f"not a readable text file ({error})") from error
    return parse_toml(text)


def parse_toml(text: str) -> dict[str, Any]:
    """Read tables from text."""
    if any(key.count(".") > DEEPEST_KEY for key in KEYS.findall(text)):
        raise ValueError(f"expected keys of at most {DEEPEST_KEY + 1} parts")
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise ValueError(f"not valid TOML: {error}") from error
