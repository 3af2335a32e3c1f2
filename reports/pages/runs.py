"""The comparison page of two runs: changes in value, error and time."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

from comparisons.files import write_text
from comparisons.results.runs import (
    CHANGED,
    FAST,
    LOST,
    ONE_SIDED,
    RECOVERED,
    SAME,
    SLOW,
    VERDICT,
    RunComparison,
)
from reports.pages.page import render
from reports.plots.runs import comparison_figures
from reports.tables.runs import changes

KINDS = (LOST, CHANGED, VERDICT, SLOW, RECOVERED, FAST, ONE_SIDED, SAME)


def write_comparison_page(record: RunComparison, command: str, path: Path) -> None:
    """Write the comparison as one HTML file, atomically."""
    write_text(path, comparison_page(record, command))


def comparison_page(record: RunComparison, command: str) -> str:
    """Return the whole page as text."""
    counts = Counter(kind for change in record.changes for kind in change.kinds)
    figures = comparison_figures(record)
    return render(
        "comparison.html.j2",
        {figure.key: figure for figure in figures},
        record=record,
        command=command,
        tally=[(word, counts[word]) for word in KINDS if counts[word]],
        notable=changes(
            [
                change
                for change in record.changes
                if change.kinds not in ((SAME,), (ONE_SIDED,)) and not change.only_timed
            ]
        ),
        timed=changes([change for change in record.changes if change.only_timed]),
        one_sided=changes([change for change in record.changes if change.kinds == (ONE_SIDED,)]),
        unchanged=changes([change for change in record.changes if change.kinds == (SAME,)]),
        figures=figures,
    )
