"""Tables on a terminal, drawn with rich."""

from __future__ import annotations

import shutil
from io import StringIO

from rich import table as rich
from rich.console import Console
from rich.markup import escape

from reports.tables.table import Table

SHORT = 22  # characters: cells that are not folded, so that long texts give way and no word breaks
LONG_SHARE = 20  # columns left for each column of longer cells


def drawn(table: Table, *, unfolded: bool = False, tight: bool = False) -> rich.Table:
    """Return a table without rules; long cells are wrapped, the first column unless `unfolded`.

    Columns of short cells keep their width, where the terminal has room for them all: the texts
    beside them wrap, between words. A `tight` table has one space between columns.
    """
    result = rich.Table(
        title=escape(table.title),
        title_justify="left",
        box=None,
        pad_edge=False,
        collapse_padding=tight,
    )
    # which columns are not folded: those of short cells, if all of them have room
    widths = [
        max(len(head.text), *(len(row[place].text) for row in table.rows))
        for place, head in enumerate(table.heads)
        if table.rows
    ] or [0] * len(table.heads)
    short = [width <= SHORT for width in widths]
    needed = sum(w if fits else LONG_SHARE for w, fits in zip(widths, short, strict=True))
    room = shutil.get_terminal_size().columns - (1 if tight else 2) * (len(widths) - 1)
    kept = short if needed <= room else [False] * len(widths)
    for head, keep in zip(table.heads, kept, strict=True):
        result.add_column(escape(head.text), overflow="fold", no_wrap=keep)
    if unfolded:
        result.columns[0].no_wrap = True
    for place, row in enumerate(table.rows):
        style = "bold" if place in table.strong else None
        result.add_row(*(escape(cell.text) for cell in row), style=style)
    return result


def plain(table: Table) -> str:
    """Return a table as text."""
    console = Console(width=100, file=StringIO(), emoji=False, color_system=None)
    with console.capture() as told:
        console.print(drawn(table, tight=True))
    return told.get().rstrip()
