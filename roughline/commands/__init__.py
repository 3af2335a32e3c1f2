"""The command line. What others have written (names of files, titles) must not command it."""

from __future__ import annotations

import shlex
import sys
import unicodedata
from typing import TextIO

_UNKNOWN = "\N{REPLACEMENT CHARACTER}"
_LAYOUT = "\n\t"


def printable(text: str) -> str:
    r"""Return text without characters that control (ESC), turn its direction, or are none.

    >>> printable("a\x1b[31mred.toml:\n\tnot valid")
    'a\ufffd[31mred.toml:\n\tnot valid'
    """
    return "".join(
        _UNKNOWN if unicodedata.category(c).startswith("C") and c not in _LAYOUT else c
        for c in text
    )


def typed(without: str = "") -> str:
    """Return the command as it was typed, for records and pages."""
    return shlex.join(["roughline", *(word for word in sys.argv[1:] if word != without)])


def say(text: object, stream: TextIO | None = None) -> None:
    """Print a text, by default on standard output, so that a terminal takes it for one."""
    print(printable(str(text)), file=stream or sys.stdout)
