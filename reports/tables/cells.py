"""A table as data: printed texts, sort keys, verdicts and error bars; and the kinds of cells."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from comparisons import formatting as fmt
from comparisons.facts.quantities import quantity
from comparisons.judging.verdicts import NO_RESULT, Verdict
from reports.plots.style import look

if TYPE_CHECKING:
    from comparisons.results.record import SceneRecord

# The tone of every verdict word: good, bad, undecided, partly, no statement.
TONES = {
    **dict.fromkeys(
        ("within", "yes", "holds", "accurate", "found again", "took less time", "same"), "within"
    ),
    **dict.fromkeys(("outside", "no", "fails", "lost", "moved"), "outside"),
    **dict.fromkeys(("not resolved", "not known", "degraded", "took longer"), "not-resolved"),
    **dict.fromkeys(
        ("holds in a range", "holds only as stated", "in part", "refused", "verdict changed"),
        "partly",
    ),
}
NO_TONE = "no-result"


def tone(word: str) -> str:
    """Return the tone of a verdict word, a CSS class of the page.

    >>> tone("holds"), tone("left out"), tone("for F, d only")
    ('within', 'no-result', 'partly')
    """
    return "partly" if word.endswith(" only") else TONES.get(word, NO_TONE)


@dataclass(frozen=True)
class Cell:
    """One cell."""

    text: str  # the printed text
    key: float | str = ""  # the value used for sorting and export
    # CSS classes: "text", "number", "method", "failed", with "wrap" for long texts.
    kind: str = "text"
    method: str = ""  # the method whose colour precedes the text
    bar: float | None = None  # half-width of the error bar if `key` is an error
    title: str = ""  # what is said on hover
    # Verdict words to show instead of the text, each in the colour of its tone.
    badges: tuple[str, ...] = ()


@dataclass(frozen=True)
class Head:
    """A column."""

    text: str
    term: str = ""  # key of its glossary entry
    csv: str = ""  # its name in a CSV file, if the unit varies from cell to cell
    short: str = ""  # its name in papers


@dataclass(frozen=True)
class Table:
    """Column heads and rows of cells."""

    heads: tuple[Head, ...]
    rows: tuple[tuple[Cell, ...], ...]
    # Texts above and below the table.
    title: str = ""
    note: str = ""
    strong: frozenset[int] = frozenset()  # the highlighted rows

    def only(self, *names: str) -> Table:
        """Return the table with these columns, in this order."""
        places = [[head.text for head in self.heads].index(name) for name in names]
        rows = tuple(tuple(row[place] for place in places) for row in self.rows)
        return replace(self, heads=tuple(self.heads[place] for place in places), rows=rows)

    def without(self, *names: str) -> Table:
        """Return the table without these columns."""
        return self.only(*(head.text for head in self.heads if head.text not in names))

    def first(self, count: int) -> Table:
        """Return the table with only its first rows."""
        return replace(self, rows=self.rows[:count])


def table(heads: Iterable[str | Head], rows: Iterable[Sequence[Cell | str]], **more: Any) -> Table:
    """Return a table; plain texts are accepted as heads and cells."""
    columns = tuple(Head(head) if isinstance(head, str) else head for head in heads)
    cells = tuple(
        tuple(Cell(cell, cell) if isinstance(cell, str) else cell for cell in row) for row in rows
    )
    return Table(columns, cells, **more)


def of_columns(columns: Iterable[tuple[Head, Sequence[Cell]]], **more: Any) -> Table:
    """Return a table of its columns, each a head with the cells below it."""
    heads, cells = zip(*columns, strict=True)
    return Table(heads, tuple(zip(*cells, strict=True)), **more)


NOTHING = Cell(fmt.MISSING, float("nan"), "number")


def column(name: str, values: Iterable[float], digits: int = 3) -> tuple[Head, list[Cell]]:
    """Return the column of a quantity, all in one unit."""
    row, numbers = quantity(name), list(values)
    scale = fmt.prefix_for(numbers, row.unit)
    symbol = row.symbol or row.label
    head = Head(row.title(scale.unit), short=f"{symbol} / {scale.unit}" if scale.unit else symbol)
    scaled = (value * scale.factor for value in numbers)
    return head, [number(fmt.number(value, digits), value) for value in scaled]


def method(name: str, label: str = "", scene: SceneRecord | None = None) -> Cell:
    """Return the name of a method, as it is called on the scene, with its colour."""
    text = label or look(name, scene).label
    return Cell(text, text, "method", name)


def number(text: str, key: float) -> Cell:
    """Return a number with its printed text and its sort key."""
    return Cell(text, key, "number")


def count(value: float) -> Cell:
    """Return a whole number."""
    return number(fmt.count(value), value)


def duration(seconds: float) -> Cell:
    """Return a time."""
    return number(fmt.duration(seconds), seconds)


def size(error: float) -> str:
    """Write the size of an error.

    >>> size(0.0123), size(7.7e-14)
    ('1.2\u202f%', 'round-off')
    """
    return "round-off" if error < fmt.ROUND_OFF else fmt.relative(error)


def relative(value: float) -> Cell:
    """Return a share, or the size of an error."""
    return number(fmt.relative(value), value)


def signed_error(value: float) -> Cell:
    """Return a relative error with its sign, without its bar."""
    return number(fmt.signed_error(value), value)


def error(value: float, bar: float, text: str = "") -> Cell:
    """Return a relative error with its bar; `text` is how a verdict prints it."""
    return Cell(text or fmt.plus_minus(value, bar), float(value), "number", bar=float(bar))


def of_verdict(judged: Verdict | None) -> Cell:
    """Return the error with its bar that a verdict stands on, if there is one."""
    if judged is None:
        return NOTHING
    if judged.word == NO_RESULT:
        return replace(NOTHING, title=judged.reason)
    return error(judged.error, judged.uncertainty, judged.number)


def verdict(*badges: str, text: str = "") -> Cell:
    """Return verdict words; `text` is a longer text to print in their place."""
    return Cell(text or ", ".join(badges), badges[0] if badges else "", "text", badges=badges)


def change(
    before: float, after: float, written: Callable[[float], str] = size, of: Iterable[str] = ()
) -> Cell:
    """Return a number before and after, if both are known, and of what it is."""
    if not (fmt.finite(before) and fmt.finite(after)):
        return NOTHING
    named = " → ".join(dict.fromkeys(of))
    told = f"{written(before)} → {written(after)}"
    return Cell(f"{told} ({named})" if named else told, after)
