"""How a text writes its numbers: what separates them, and whether decimals follow a comma."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from comparisons.geometry.map_files.checks import MapError

# Characters from the beginning of a text that show how its numbers are written.
_SAMPLE = 65536
_COMMA_NUMBER = re.compile(
    r"[+-]?(?:\d+(?:,\d*)?|,\d+)(?:[eE][+-]?\d+)?|[+-]?(?:nan|inf)", re.IGNORECASE
)


@dataclass(frozen=True)
class NumberLayout:
    """How the numbers of a text are written.

    Attributes
    ----------
    first : str
        The first line that is no comment.
    header : int
        Lines before the first one that holds nothing but numbers.
    delimiter : str or None
        What separates the numbers; None for blanks.
    decimal_comma : bool
        Whether a comma stands in the place of the decimal point.
    """

    encoding: str
    first: str
    header: int
    delimiter: str | None
    decimal_comma: bool

    def fields(self, line: str) -> list[str]:
        """Split a line into its numbers, written with decimal points."""
        return self._pointed(line.split("#", 1)[0].strip()).split(self.delimiter)

    def lines(self, path: Path) -> Iterator[str]:
        """Yield the lines of a text with decimal points."""
        with path.open(encoding=self.encoding) as file:
            yield from map(self._pointed, file)

    def _pointed(self, line: str) -> str:
        return line.replace(",", ".") if self.decimal_comma else line


def layout_of(path: Path) -> NumberLayout:
    """Return how the numbers of a text are written.

    Commas are decimal where something else separates the numbers (semicolons, tabs, blanks) and
    all of them stand within numbers.

    Raises
    ------
    MapError
        If numbers have both points and commas, so that either may stand for thousands.
    OSError, UnicodeError
        If the file is no readable text.
    """
    encoding = encoding_of(path)
    with path.open(encoding=encoding) as file:
        sample = file.read(_SAMPLE).splitlines()
    if len(sample) > 1 and len("\n".join(sample)) >= _SAMPLE - 2:
        sample.pop()  # cut off within the line
    data = [text for line in sample if (text := line.split("#", 1)[0].strip())]
    delimiter, decimal_comma = _separation(path, data)
    layout = NumberLayout(encoding, data[0] if data else "", 0, delimiter, decimal_comma)
    header = next((i for i, line in enumerate(sample) if _all_numbers(layout.fields(line))), 0)
    return NumberLayout(encoding, layout.first, header, delimiter, decimal_comma)


def encoding_of(path: Path) -> str:
    """Return the encoding that a text's first bytes announce; UTF-8 where they do not."""
    with path.open("rb") as file:
        start = file.read(2)
    return "utf-16" if start in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig"


def _separation(path: Path, lines: list[str]) -> tuple[str | None, bool]:
    """Return the delimiter, and whether commas are decimal."""
    numeric = [line for line in lines if line[0].isdigit() or line[0] in "+-.,;\t"]
    text = "\n".join(numeric or lines[:1])
    for mark in (";", "\t", None):
        if mark is not None and mark not in text:
            continue
        if "," not in text:
            return mark, False
        fields = [field.strip() for line in numeric for field in line.split(mark)]
        if all(_COMMA_NUMBER.fullmatch(field) for field in fields if field) and (
            mark or len(fields) > len(numeric)
        ):
            return mark, True
        if mark is not None and re.search(r"\d,\d", text) and re.search(r"\d\.\d", text):
            raise MapError(
                str(path),
                [
                    "numbers with both points and commas: one of them may be a decimal comma or "
                    "a mark of thousands; write decimal points only"
                ],
            )
    return ",", False


def _all_numbers(fields: list[str]) -> bool:
    """Whether every field of a line is a number, and there is one."""
    try:
        return bool([float(field) for field in fields])
    except ValueError:
        return False
