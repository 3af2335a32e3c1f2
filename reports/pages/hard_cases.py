"""The hard-cases page: the stability table, and time against error with failures."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

from comparisons.files import write_text
from comparisons.formatting import ROUND_OFF
from comparisons.questions.hard_cases.record import HardCasesRecord, OutcomeRecord
from reports.pages.page import render
from reports.plots.hard_cases import stability

KINDS = ("accurate", "degraded", "refused", "not for", "left out", "lost")


def write_hard_cases_report(record: HardCasesRecord, path: Path) -> None:
    """Write the stability table as one HTML file, atomically."""
    write_text(path, hard_cases_page(record))


def hard_cases_page(record: HardCasesRecord) -> str:
    """Return the whole page as text."""
    figure = stability(record)
    cases: dict[str, dict[str, OutcomeRecord]] = {}
    for outcome in record.outcomes:
        cases.setdefault(outcome.case, {})[outcome.method] = outcome
    counts = Counter(outcome.kind for outcome in record.outcomes)
    return render(
        "hard_cases.html.j2",
        {figure.key: figure} if figure else {},
        record=record,
        cases=cases,
        figure=figure,
        tally=[(word, counts[word]) for word in KINDS if counts[word]],
        round_off=ROUND_OFF,
    )
