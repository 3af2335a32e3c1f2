"""Reading of untrusted TOML files."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

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
