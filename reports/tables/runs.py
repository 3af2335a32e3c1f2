"""The table of changes between two runs."""

from __future__ import annotations

from collections.abc import Sequence

from comparisons import formatting as fmt
from comparisons.results.runs import Change
from reports.tables import cells
from reports.tables.table import Cell, Table, table

TIMES = "time, before → after"


def changes(shown: Sequence[Change]) -> Table:
    """Return the change of each solve; those that make the comparison fail are highlighted."""
    rows = (
        (
            each.scene,
            cells.method(each.method),
            cells.number(str(each.resolution or fmt.MISSING), each.resolution),
            cells.verdict(*each.kinds),
            Cell(each.text, each.text, "wrap"),
            cells.change(*each.errors),
            cells.change(*each.seconds, fmt.duration),
        )
        for each in shown
    )
    heads = ("scene", "method", "N", "what", "in words", "error, before → after", TIMES)
    bad = frozenset(place for place, each in enumerate(shown) if each.bad)
    return table(heads, rows, title="Solves that changed", strong=bad)
