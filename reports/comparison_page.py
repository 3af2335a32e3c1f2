"""The page of two runs side by side: what moved, in value, in error and in time."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

from markupsafe import Markup
from plotly.offline import get_plotlyjs

from comparisons.runs import (
    CHANGED,
    FAST,
    FOUND,
    LOST,
    ONE_SIDED,
    SAME,
    SLOW,
    VERDICT,
    RunComparison,
)
from comparisons.store import write_text
from reports.comparison_figures import comparison_figures
from reports.html import TEMPLATES, content_policy, embedded_json, environment

CLASSES = {
    LOST: "outside",
    CHANGED: "outside",
    VERDICT: "partly",
    SLOW: "not-resolved",
    FOUND: "within",
    FAST: "within",
    ONE_SIDED: "no-result",
    SAME: "within",
}


def write_comparison_page(record: RunComparison, command: str, path: Path) -> None:
    """Write the comparison as one HTML file, atomically."""
    write_text(path, comparison_page(record, command))


def comparison_page(record: RunComparison, command: str) -> str:
    """Return the whole page as text."""
    counts = Counter(kind for change in record.changes for kind in change.kinds)
    figures = comparison_figures(record)
    script = (TEMPLATES / "report.js").read_text(encoding="utf-8")
    library = get_plotlyjs()
    return (
        environment()
        .get_template("comparison.html.j2")
        .render(
            record=record,
            command=command,
            tally=[(word, counts[word]) for word in CLASSES if counts[word]],
            classes=CLASSES,
            notable=[c for c in record.changes if c.kinds not in ((SAME,), (ONE_SIDED,))],
            one_sided=[each for each in record.changes if each.kinds == (ONE_SIDED,)],
            unchanged=[each for each in record.changes if each.kinds == (SAME,)],
            figures=figures,
            policy=content_policy([library, script]),
            style=Markup((TEMPLATES / "report.css").read_text(encoding="utf-8")),  # noqa: S704
            script=Markup(script),  # noqa: S704  our own file
            library=Markup(library),  # noqa: S704  the plotly package's own file
            figure_data={each.key: embedded_json(each.spec) for each in figures},
        )
    )
