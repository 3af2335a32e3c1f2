"""The table of changes between two runs."""

from __future__ import annotations

from collections.abc import Sequence

from comparisons import formatting as fmt
from comparisons.results.run_comparison import Change
from reports.tables import cells
from reports.tables.table import Cell, Table, table

TIMES = "time, before → after"


def changes(solves: Sequence[Change]) -> Table:
    """Return the change of each solve; those that make the comparison fail are highlighted."""
    rows = (
        (
            change.scene,
            cells.method(change.method),
            cells.number(str(change.resolution or fmt.MISSING), change.resolution),
            cells.verdict(*change.kinds),
            Cell(change.text, change.text, "wrap"),
            cells.change(*change.errors),
            cells.change(*change.seconds, fmt.duration),
        )
        for change in solves
    )
    heads = ("scene", "method", "N", "what", "in words", "error, before → after", TIMES)
    bad = frozenset(place for place, change in enumerate(solves) if change.bad)
    return table(heads, rows, title="Solves that changed", strong=bad)
