"""The calibration page: coverage and width of the error bars."""

from __future__ import annotations

from pathlib import Path

from comparisons import formatting as fmt
from comparisons.questions.calibration_cases import Case, held, summary
from reports.pages.page import render, write_page
from reports.plots.calibration import covered, widths
from reports.plots.style import look
from reports.tables import cells
from reports.tables.table import Table, table


def write_calibration_report(cases: list[Case], command: str, path: Path) -> None:
    """Write both figures and the tables as one HTML file, atomically."""
    write_page(path, calibration_page(cases, command))


def calibration_page(cases: list[Case], command: str) -> str:
    """Return the whole page as text."""
    reported = [case for case in cases if case.half == "reported"]
    single = [case for case in cases if not case.rough]
    drawn = [covered(_of(single, half="reported")), widths(single)]
    return render(
        "calibration.html.j2",
        {figure.key: figure for figure in drawn},
        command=command,
        figures=drawn,
        halves=[
            (half, kind, summary(part))
            for half in ("reported", "fitting")
            for kind, part in kinds(_of(cases, half=half)).items()
        ],
        parts=parts(reported),
        held=held(cases),
    )


def kinds(cases: list[Case]) -> dict[str, list[Case]]:
    """Return the cases of single contacts, and those of rough surfaces, if there are any."""
    both = {
        "single contacts": [case for case in cases if not case.rough],
        "rough surfaces": [case for case in cases if case.rough],
    }
    return {kind: part for kind, part in both.items() if part}


def _label(key: str, value: str) -> str:
    """Return the name of a part as used in the plots."""
    return look(value).label if key == "method" else value.replace("_", " ")


def _of(cases: list[Case], **facts: str) -> list[Case]:
    return [c for c in cases if all(getattr(c, key) == value for key, value in facts.items())]


def parts(cases: list[Case]) -> Table:
    """Return coverage and width for each quantity and method, and for each shape."""
    rows = []
    for kind, part in kinds(cases).items():
        for names in (("quantity", "method"), ("shape",)):
            for values in dict.fromkeys(tuple(getattr(c, n) for n in names) for c in part):
                facts = dict(zip(names, values, strict=True))
                got = summary(_of(part, **facts))
                label = ", ".join(_label(*fact) for fact in facts.items())
                coverage = cells.number(f"{100 * got.coverage:.1f} %", got.coverage)
                width = cells.number(fmt.number(got.width, 2), got.width)
                rows.append((kind, label, cells.count(got.count), coverage, width))
    return table(("of", "part", "cases", "coverage", "median width"), rows)
