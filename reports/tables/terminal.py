"""Tables on a terminal, drawn with rich."""

from __future__ import annotations

from rich import table as rich
from rich.markup import escape

from reports.tables.table import Table


def drawn(table: Table, *, unfolded: bool = False) -> rich.Table:
    """Return a table without rules; long cells are wrapped, the first column unless `unfolded`."""
    result = rich.Table(title=escape(table.title), title_justify="left", box=None, pad_edge=False)
    for head in table.heads:
        result.add_column(escape(head.text), overflow="fold")
    if unfolded:
        result.columns[0].no_wrap = True
    for place, row in enumerate(table.rows):
        style = "bold" if place in table.strong else None
        result.add_row(*(escape(cell.text) for cell in row), style=style)
    return result
