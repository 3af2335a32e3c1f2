"""A table as data: what is printed, what it is sorted by, and what is a verdict or an error."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

# The tone of every word that judges: good, bad, neither yet, of a part only, nothing to say.
TONES = {
    **dict.fromkeys(("within", "holds", "accurate", "found again", "faster", "same"), "within"),
    **dict.fromkeys(("outside", "fails", "lost", "moved"), "outside"),
    **dict.fromkeys(("not resolved", "degraded", "slower"), "not-resolved"),
    **dict.fromkeys(("holds in a range", "refused", "verdict changed"), "partly"),
}
NO_TONE = "no-result"


def tone(word: str) -> str:
    """Return the tone of a word, a class of the page's styles.

    >>> tone("holds"), tone("left out")
    ('within', 'no-result')
    """
    return TONES.get(word, NO_TONE)


@dataclass(frozen=True)
class Cell:
    """One cell.

    Attributes
    ----------
    text : str
        What is printed.
    key : float or str
        What it is sorted by and saved as.
    kind : str
        Classes of the page: "text", "number", "method", "failed", with "wrap" for long texts.
    method : str
        The method whose colour stands before the text.
    bar : float, optional
        The half-width of the bar of an error, which `key` is: papers print both in their own way.
    badges : tuple of str
        The words of which the text consists, each in the colour of its tone.
    """

    text: str
    key: float | str = ""
    kind: str = "text"
    method: str = ""
    bar: float | None = None
    badges: tuple[str, ...] = ()


@dataclass(frozen=True)
class Head:
    """A column.

    Attributes
    ----------
    text : str
    term : str
        The glossary's term behind it.
    csv : str
        Its name in a CSV file, where its unit differs from cell to cell.
    short : str
        What papers call it.
    """

    text: str
    term: str = ""
    csv: str = ""
    short: str = ""


@dataclass(frozen=True)
class Table:
    """Heads and rows of cells.

    Attributes
    ----------
    heads : tuple of Head
    rows : tuple of tuple of Cell
    title, note : str
        Above and below it.
    strong : frozenset of int
        The rows to look at first.
    """

    heads: tuple[Head, ...]
    rows: tuple[tuple[Cell, ...], ...]
    title: str = ""
    note: str = ""
    strong: frozenset[int] = frozenset()

    def only(self, *names: str) -> Table:
        """Return the table with these columns, in this order."""
        places = [[head.text for head in self.heads].index(name) for name in names]
        rows = tuple(tuple(row[place] for place in places) for row in self.rows)
        return replace(self, heads=tuple(self.heads[place] for place in places), rows=rows)

    def without(self, *names: str) -> Table:
        """Return the table without these columns."""
        return self.only(*(head.text for head in self.heads if head.text not in names))

    def first(self, count: int) -> Table:
        """Return the table with its first rows only."""
        return replace(self, rows=self.rows[:count])


def table(heads: Iterable[str | Head], rows: Iterable[Sequence[Cell | str]], **more: Any) -> Table:
    """Return a table; texts stand for heads and cells without anything special."""
    columns = tuple(Head(head) if isinstance(head, str) else head for head in heads)
    cells = tuple(
        tuple(Cell(cell, cell) if isinstance(cell, str) else cell for cell in row) for row in rows
    )
    return Table(columns, cells, **more)
