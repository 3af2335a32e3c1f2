"""Pages of numbered problems, with their commands, and of all codes."""

import json
import re
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from comparisons.questions.problem_sheets import builtin_sheets
from reports.pages.page import render
from reports.tables.cells import table
from roughline.commands.app import run_command

HERTZ = builtin_sheets()["RL-001"]


@pytest.fixture
def blank(tmp_path, capsys):
    """Return the entry that the command leaves to be filled in."""
    assert run_command(["problems", "rl-001", "--out", str(tmp_path / "sheet")]) == 0
    capsys.readouterr()
    return json.loads((tmp_path / "sheet" / "entry.json").read_text())


@pytest.fixture
def submit(tmp_path, capsys):
    """Return a function that submits an entry, and its code and words."""

    def send(entry, *options):
        path = tmp_path / "mine.json"
        path.write_text(json.dumps(entry))
        code = run_command(["submit", str(path), *options])
        said = capsys.readouterr()
        return code, (said.out + said.err).replace("\N{NARROW NO-BREAK SPACE}", " ")

    return send


def filled(entry, factor=1.0, **more):
    values = {
        name: [factor * value for value in known.values] for name, known in HERTZ.reference.items()
    }
    return entry | {"values": values, "solver": "mine 1.0", "seconds": 0.5} | more


def test_all_sheets_are_listed_and_one_is_printed(capsys):
    assert run_command(["problems"]) == 0
    said = capsys.readouterr().out
    assert all(name in said for name in builtin_sheets())
    assert run_command(["problems", "RL-002"]) == 0
    said = capsys.readouterr().out
    assert "sealed" in said
    assert "wanted" in said


def test_heights_of_a_rough_problem_are_written(tmp_path):
    assert run_command(["problems", "RL-005", "--out", str(tmp_path)]) == 0
    heights = np.loadtxt(tmp_path / "heights.csv", delimiter=",")
    assert heights.shape == (64, 64)
    assert (tmp_path / "scene.toml").is_file()


def test_an_entry_is_judged_and_the_code_says_how(blank, submit):
    code, said = submit(filled(blank))
    assert code == 0
    assert "mine 1.0 on RL-001: within 1 %" in said
    code, said = submit(filled(blank, 1.05))
    assert code == 1
    assert "outside 1 %" in said
    partial = filled(blank)
    partial["values"]["stiffness"] = [None] * 4
    code, said = submit(partial)
    assert code == 1
    assert "no result" in said
    assert submit(blank)[0] == 2


def test_two_boards_of_the_same_entries_are_the_same_bytes(blank, submit, tmp_path):
    entries = [filled(blank), filled(blank, 1.02, solver="fast", seconds=1e-3)]
    pages = []
    for name, order in (("a", entries), ("b", entries[::-1])):
        for entry in order:
            submit(entry, "--leaderboard", str(tmp_path / name))
        pages.append((tmp_path / name / "report.html").read_bytes())
        assert run_command(["leaderboard", str(tmp_path / name)]) == 0
        assert (tmp_path / name / "report.html").read_bytes() == pages[-1]
        elsewhere = tmp_path / f"{name}-page"
        assert run_command(["leaderboard", str(tmp_path / name), "--out", str(elsewhere)]) == 0
        assert (elsewhere / "report.html").read_bytes() == pages[-1]
    assert pages[0] == pages[1]


def test_a_board_does_not_write_over_the_page_of_another_command(blank, submit, tmp_path, capsys):
    submit(filled(blank), "--leaderboard", str(tmp_path / "board"))
    run, file = tmp_path / "run", tmp_path / "file"
    run.mkdir()
    for path in (run / "report.html", run / "claims.json", file):
        path.write_text("others")
    for out, said in ((run, "has claims.json of another command"), (file, "expected a folder")):
        assert run_command(["leaderboard", str(tmp_path / "board"), "--out", str(out)]) == 2
        assert said in " ".join(capsys.readouterr().err.split())
    assert (run / "report.html").read_text() == "others"


def test_texts_of_strangers_are_inert_on_the_page(blank, submit, tmp_path):
    submit(filled(blank, solver="<script>x</script>"), "--leaderboard", str(tmp_path / "board"))
    page = (tmp_path / "board" / "report.html").read_text(encoding="utf-8")
    assert "<script>x</script>" not in page
    assert "&lt;script&gt;x&lt;/script&gt;" in page


def test_every_marker_of_the_plot_is_named_by_its_solver(blank, submit, tmp_path):
    """In print and on a phone nothing hovers; the markers differ, and a wrong one is hollow."""
    board = tmp_path / "board"
    for solver, factor in (("mine 1.0", 1.0), ("theirs 2.0", 1.002), ("wrong 3.0", 1.03)):
        submit(filled(blank, factor, solver=solver), "--leaderboard", str(board))
    page = (board / "report.html").read_text(encoding="utf-8")
    named = re.findall(r'"mode":"markers","name":"([^"]*)".*?"symbol":"([^"]*)"', page)
    assert [name for name, _ in named] == ["mine 1.0", "theirs 2.0", "wrong 3.0"]
    symbols = [symbol for _, symbol in named]
    assert len(set(symbols)) == 3
    assert [symbol.endswith("-open") for symbol in symbols] == [False, False, True]


def test_a_wrong_entry_adds_nothing(blank, submit, tmp_path):
    code, said = submit(filled(blank, version=9), "--leaderboard", str(tmp_path / "board"))
    assert code == 2
    assert "version: expected 1, got 9" in said
    assert not (tmp_path / "board").exists()


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
