"""The page of all codes: what is not installed is said and costs its own rows."""

from importlib import import_module
from pathlib import Path

import pytest

from reports.pages.page import render
from reports.tables.cells import table

EXAMPLES = Path(__file__).parents[3] / "docs" / "examples"


@pytest.fixture
def arena(monkeypatch):
    monkeypatch.syspath_prepend(EXAMPLES)
    return import_module("arena")


@pytest.mark.slow
def test_a_missing_code_is_said_and_the_others_stand_on_the_page(arena, monkeypatch):
    for code in ("DRAKE", "KRATOS"):
        monkeypatch.setenv(f"ROUGHLINE_PYTHON_{code}", "/nowhere/python")
    loads = {"loading": {"penetration": [1e-6]}}
    ball = ("paraboloid", loads, ("force",), ("closed_form", "reduced", "drake"))
    monkeypatch.setattr(arena, "CASES", {"ball": ball})
    missing = []
    rows = table(arena.HEADS, arena.solved(missing))
    drake, kratos = missing
    assert drake.startswith("ball: no Drake: asked in ROUGHLINE_PYTHON_DRAKE=/nowhere/python")
    assert kratos.startswith("no Kratos: asked in ROUGHLINE_PYTHON_KRATOS=/nowhere/python")
    (cells,) = ([cell.text for cell in row] for row in rows.rows)
    assert cells[:5] == ["ball", "reduced model", "force", "round-off", "within"]
    page = render("arena.html.j2", {}, tables={"Solved here": rows})
    assert "reduced model" in page
    assert "default-src &#39;none&#39;" in page


def test_an_error_is_judged_with_the_bar_of_the_truth(arena):
    """|e| + u <= 1 % is within, |e| - u > 1 % outside."""
    words = [arena.row("", "", "", error, 0.002, 0.0)[4].text for error in (0.005, -0.009, 0.02)]
    assert words == ["within", "not resolved", "outside"]
