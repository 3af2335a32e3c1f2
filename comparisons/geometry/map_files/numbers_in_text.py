"""Number format of text files: delimiter and decimal sign."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from comparisons.geometry.reading import FileError

# Characters at the beginning of a text from which the number format is determined.
_SAMPLE = 65536
_COMMA_NUMBER = re.compile(
    r"[+-]?(?:\d+(?:,\d*)?|,\d+)(?:[eE][+-]?\d+)?|[+-]?(?:nan|inf)", re.IGNORECASE
)


@dataclass(frozen=True)
class NumberLayout:
    """Number format of a text.

    Attributes
    ----------
    first : str
        The first line that is not a comment.
    header : int
        Number of lines before the first one with numbers only.
    delimiter : str or None
        Separator of the numbers; None for blanks.
    decimal_comma : bool
        Whether the decimal sign is a comma.
    """

    encoding: str
    first: str
    header: int
    delimiter: str | None
    decimal_comma: bool

    def fields(self, line: str) -> list[str]:
        """Split a line into numbers with decimal points."""
        return self._pointed(line.split("#", 1)[0].strip()).split(self.delimiter)

    def lines(self, path: Path) -> Iterator[str]:
        """Yield the lines of a text with decimal points."""
        with path.open(encoding=self.encoding) as file:
            yield from map(self._pointed, file)

    def _pointed(self, line: str) -> str:
        return line.replace(",", ".") if self.decimal_comma else line


def layout_of(path: Path) -> NumberLayout:
    """Return the number format of a text.

    Commas are decimal signs if another mark separates the numbers (semicolons, tabs, blanks) and
    all commas are within numbers.
    """
    with path.open("rb") as file:
        marked = file.read(2) in (b"\xff\xfe", b"\xfe\xff")
    encoding = "utf-16" if marked else "utf-8-sig"
    with path.open(encoding=encoding) as file:
        sample = file.read(_SAMPLE).splitlines()
    if len(sample) > 1 and len("\n".join(sample)) >= _SAMPLE - 2:
        sample.pop()  # cut off within the line
    data = [text for line in sample if (text := line.split("#", 1)[0].strip())]
    delimiter, decimal_comma = _separation(data)
    layout = NumberLayout(encoding, data[0] if data else "", 0, delimiter, decimal_comma)
    header = next((i for i, line in enumerate(sample) if _all_numbers(layout.fields(line))), 0)
    return NumberLayout(encoding, layout.first, header, delimiter, decimal_comma)


def _separation(lines: list[str]) -> tuple[str | None, bool]:
    """Return the delimiter, and whether commas are decimal signs."""
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
            raise FileError(
                "numbers with both points and commas: one of them may be a decimal comma or "
                "a mark of thousands; write decimal points only"
            )
    return ",", False


def _all_numbers(fields: list[str]) -> bool:
    """Return whether a line has at least one field and all fields are numbers."""
    try:
        return bool([float(field) for field in fields])
    except ValueError:
        return False
