"""Reading of files by other people's libraries: in a process of limited memory and time.

A packed file of a few megabytes may unpack to any size, whatever its directory says, and a damaged
one may crash or stall its reader. Nothing of that reaches the caller's process.
"""

from __future__ import annotations

import contextlib
import importlib
import io
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from comparisons.errors import InputError
from comparisons.formatting import with_unit
from comparisons.isolation import parent
from comparisons.machine import MEMORY_SHARE, free_memory

# Bytes that a reader may take, a map of 16 000 x 16 000 points with two copies; and seconds.
MOST_MEMORY, MOST_SECONDS = 8e9, 600.0
_PACKED_WHOLE = {
    b"\x1f\x8b": "gzip",
    b"BZh": "bzip2",
    b"\xfd7zXZ\0": "xz",
    b"(\xb5/\xfd": "zstandard",
    b"7z\xbc\xaf\x27\x1c": "7z",
}


class FileError(InputError):
    """A file cannot be used; `problems` lists all reasons."""

    @property
    def problems(self) -> tuple[str, ...]:
        """One sentence per problem."""
        return self.args

    def __str__(self) -> str:
        return "; ".join(self.problems)


def read_apart(reader: str, path: Path, *arguments: Any, remedy: str) -> dict[str, Any]:
    """Call ``"package.module:function"`` in a process of its own, with the path and the arguments.

    Return its dict of arrays and plain values. `remedy` is the advice where the file needs too much
    memory or time.
    """
    with path.open("rb") as file:
        start = file.read(8)
    for magic, packer in _PACKED_WHOLE.items():
        if start.startswith(magic):
            raise FileError(f"compressed by {packer}: unpack it first")
    limit = min(MOST_MEMORY, MEMORY_SHARE * free_memory())
    outcome = parent.run(
        f"{__name__}:answer_of",
        *(reader, path.absolute(), *arguments),
        seconds=MOST_SECONDS,
        memory=limit,
        finite=False,  # NaN marks undefined points
        reuse="files",
    )
    if outcome.ended == parent.OUT_OF_MEMORY:
        free = "" if limit == MOST_MEMORY else ", 80 % of the free memory"
        size, most = (with_unit(number, "B") for number in (path.stat().st_size, limit))
        raise FileError(
            f"this file of {size} needs more than {most} of memory{free}, to be read: {remedy}"
        )
    if outcome.ended == parent.HUNG:
        raise FileError(f"not read within {MOST_SECONDS:g} s: {remedy}")
    if not outcome.ok:
        raise FileError(f"cannot be read ({shorten(outcome.reason)})")
    if "problems" in outcome.answer:
        raise FileError(*outcome.answer["problems"])
    return outcome.answer


def answer_of(reader: str, path: Path, *arguments: Any) -> dict[str, Any]:
    """Call a reader; FileError becomes an answer. Runs in the process of `read_apart`."""
    module, _, name = reader.partition(":")
    try:
        answer: dict[str, Any] = getattr(importlib.import_module(module), name)(path, *arguments)
    except FileError as error:
        return {"problems": list(error.problems)}
    return answer


def shorten(error: BaseException | str) -> str:
    """Return the message of an error on one line; readers may quote whole files in it."""
    length = 200
    text = " ".join(str(error)[: 10 * length].split())
    return text if len(text) <= length else text[:length] + " ..."


@contextlib.contextmanager
def quiet() -> Iterator[io.StringIO]:
    """Silence a reader; the yielded text receives its output and unhandled log messages."""
    output = io.StringIO()
    with (
        warnings.catch_warnings(),
        contextlib.redirect_stdout(output),
        contextlib.redirect_stderr(output),
    ):
        warnings.simplefilter("ignore")
        yield output
