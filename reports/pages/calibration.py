"""The calibration page: coverage and width of the error bars."""

from __future__ import annotations

from pathlib import Path

from comparisons import formatting as fmt
from comparisons.files import write_text
from comparisons.questions.calibration import Case, summary
from reports.pages.page import render
from reports.plots.calibration import covered, widths
from reports.plots.style import look
from reports.tables import cells
from reports.tables.table import Table, table


def write_calibration_report(cases: list[Case], command: str, path: Path) -> None:
    """Write both figures and the tables as one HTML file, atomically."""
    write_text(path, calibration_page(cases, command))


def calibration_page(cases: list[Case], command: str) -> str:
    """Return the whole page as text."""
    reported = [case for case in cases if case.half == "reported"]
    drawn = [covered(reported), widths(cases)]
    return render(
        "calibration.html.j2",
        {figure.key: figure for figure in drawn},
        command=command,
        figures=drawn,
        halves=[(half, summary(_of(cases, half=half))) for half in ("reported", "fitting")],
        parts=parts(reported),
    )


def _label(key: str, value: str) -> str:
    """Return the name of a part as used in the plots."""
    return look(value).label if key == "method" else value.replace("_", " ")


def _of(cases: list[Case], **facts: str) -> list[Case]:
    return [c for c in cases if all(getattr(c, key) == value for key, value in facts.items())]


def parts(cases: list[Case]) -> Table:
    """Return coverage and width for each method, each quantity and each shape."""
    rows = []
    for key in ("method", "quantity", "shape"):
        for value in dict.fromkeys(getattr(case, key) for case in cases):
            got = summary(_of(cases, **{key: value}))
            coverage = cells.number(f"{100 * got.coverage:.1f} %", got.coverage)
            width = cells.number(fmt.number(got.width, 2), got.width)
            rows.append((key, _label(key, value), cells.count(got.count), coverage, width))
    return table(("by", "part", "cases", "coverage", "median width"), rows)
