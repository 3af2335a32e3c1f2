"""The pages of claims, hard cases, two runs compared and the arena: same script, same care."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from comparisons.questions.claims.record import STORED, load_claims_record
from comparisons.questions.hard_cases.case import HardCasesRecord, OutcomeRecord
from comparisons.results.rows import Rows
from comparisons.results.run_comparison import compare_runs
from reports.pages.claims import claims_page
from reports.pages.hard_cases import hard_cases_page
from reports.pages.page import render
from reports.pages.runs import comparison_page
from reports.tables import cells
from reports.tables.cells import table


def of_claims(study) -> str:
    """Return the page of some claims of the stored run: holding, failing, in a range."""
    record = load_claims_record(STORED)
    return claims_page(record.model_copy(update={"claims": record.claims[:6]}))


def of_hard_cases(study) -> str:
    kinds = ("accurate", "degraded", "refused", "lost", "not for", "left out")
    common = {"lost": [], "expected": "accurate", "deviation": "", "reason": "why & how"}
    none = dict.fromkeys(("error", "area_error", "bar", "seconds"))
    known = {"error": 1e-3, "area_error": 0.01, "bar": 1e-4, "seconds": 0.01}
    outcomes = [
        OutcomeRecord(
            case=f"case-{number}", title=f"Case {number}", method=method, kind=kind,
            resolution=8, **common, **(known if number < 2 else none),
        )
        for number, kind in enumerate(kinds)
        for method in ("reduced", "fem")
    ]  # fmt: skip
    record = HardCasesRecord(
        created="2026-01-01T12:00:00+00:00", command="roughline hard-cases", effort="quick",
        seconds=1.0, machine={"processor": "abacus", "cores": 2}, versions={"numpy": "2.0"},
        interrupted=False, hard={}, outcomes=outcomes,
    )  # fmt: skip
    return hard_cases_page(record)


def of_two_runs(study) -> str:
    """Return the page of a study before and after FEM became a thousand times slower."""
    scene = study.scenes[0]
    slower = np.where(scene.rows["method"] == "fem", 1000.0, scene.rows["seconds"])
    changed = replace(scene, rows=Rows.of(scene.rows.frame().assign(seconds=slower)))
    later = study.model_copy(update={"scenes": (changed, *study.scenes[1:])})
    return comparison_page(compare_runs(study, later, 1e-6, 1.5), "roughline compare A B")


def of_the_arena(study) -> str:
    """Return the page of codes; its heads are wider than a phone."""
    heads = ("case", "code", "quantity", "largest error", "within 1 %?", "time")
    error, time = cells.error(0.02, 0.001), cells.duration(1.0)
    rows = [
        ("ball on steel", cells.method(method), "force", error, cells.verdict("outside"), time)
        for method in ("reduced", "fem")
    ]
    return render("arena.html.j2", {}, tables={"Solved here": table(heads, rows)})


@pytest.fixture(scope="module", params=[of_claims, of_hard_cases, of_two_runs, of_the_arena])
def report(request, study, tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("pages") / "report.html"
    path.write_text(request.param(study), encoding="utf-8")
    return path


@pytest.mark.slow
def test_drawn_saved_and_readable_in_light_dark_and_on_a_phone(visit, serious_faults, tmp_path):
    """No request, no complaint, no serious fault; nothing to scroll sideways for."""
    with visit() as seen:
        page = seen.page
        seen.unfold()
        assert serious_faults(page) == []
        seen.draw_all()
        table = seen.save(".table-tools button", tmp_path)
        assert table.read_text(encoding="utf-8-sig").count("\n") > 2
        if page.locator(".figure-tools button").count():
            drawing = seen.save(".figure-tools button:has-text('SVG')", tmp_path)
            assert "<svg" in drawing.read_text(encoding="utf-8")
        assert serious_faults(page, dark=True) == []
        page.set_viewport_size({"width": 390, "height": 844})
        seen.wait("document.documentElement.scrollWidth <= 390")  # plots follow a little later
        assert seen.requests == []
        assert seen.complaints == []
