"""The calibration page: coverage and width of the error bars."""

from __future__ import annotations

from pathlib import Path

from comparisons.files import write_text
from comparisons.questions.calibration_cases import Case, at_loads, held, summary
from comparisons.questions.shares import fitted_rule
from reports.pages.page import render
from reports.plots.calibration import covered, widths
from reports.tables.calibration import by_quantity, by_shape, kinds, other_widths, rule


def write_calibration_report(cases: list[Case], command: str, path: Path) -> None:
    """Write both figures and the tables as one HTML file, atomically."""
    write_text(path, calibration_page(cases, command))


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
            (half, kind, summary(part), at_loads(part))
            for half in ("reported", "fitting")
            for kind, part in kinds(_of(cases, half=half)).items()
        ],
        parts=[*by_quantity(reported), *by_shape(reported)],
        rule=rule(fitted_rule(cases)),
        widths=other_widths(cases),
        held=held(cases),
    )


def _of(cases: list[Case], **facts: str) -> list[Case]:
    return [c for c in cases if all(getattr(c, key) == value for key, value in facts.items())]
