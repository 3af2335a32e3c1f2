"""What a watched run tells, and to whom."""

import shutil
from pathlib import Path
from types import SimpleNamespace

import pytest

from comparisons.facts.methods import METHODS
from comparisons.questions.study import Study
from comparisons.scene.scene import load_scene
from comparisons.solving.jobs import Remaining
from comparisons.solving.planning import plan_scene
from roughline.commands import progress as live
from roughline.commands.app import run_command

WINKLER = Path(__file__).parents[3] / "docs" / "examples" / "winkler.py"


@pytest.fixture
def plans():
    compared = {"compare.methods": ["closed_form", "bem_fft"], "compare.resolutions": [6, 12, 24]}
    return plan_scene(load_scene("paraboloid", compared))


def watched(plans, folder):
    with live.watching() as watch:
        Study(plans, folder, watch=watch).run()


@pytest.mark.slow
@pytest.mark.parametrize("terminal", ["0", "1"])
def test_a_pipe_and_a_terminal_that_cannot_move_its_cursor_get_plain_lines(
    plans, tmp_path, capsys, monkeypatch, terminal
):
    monkeypatch.setenv("TTY_COMPATIBLE", terminal)
    monkeypatch.setenv("TTY_INTERACTIVE", "0")
    watched(plans, tmp_path / "out")
    told = capsys.readouterr()
    assert told.out == ""
    lines = [line for line in told.err.splitlines() if "compiled" not in line]
    assert all(line.startswith("solved ") for line in lines)
    assert lines[0].startswith("solved 0 of 4")
    assert lines[-1] == "solved 4 of 4, done: paraboloid"
    assert "\x1b" not in told.err


def test_a_terminal_gets_a_bar(plans, tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("TTY_COMPATIBLE", "1")
    monkeypatch.setenv("TTY_INTERACTIVE", "1")
    watched(plans, tmp_path / "out")
    told = capsys.readouterr()
    assert told.out == ""
    assert "solved 4 of 4" in told.err
    assert "\x1b[" in told.err


@pytest.mark.parametrize(
    ("done", "rest", "report", "words"),
    [
        (1, Remaining(90.0, True), 0.0, "solved 1 of 3, about 90\u202fs left"),
        (1, Remaining(90.0, False), 0.0, "solved 1 of 3, at least 90\u202fs left"),
        (1, Remaining(0.0, False), 0.0, "solved 1 of 3"),
        (3, Remaining(0.0, True), 4.0, "solved 3 of 3, the report takes about 4.0\u202fs"),
    ],
)
def test_the_remaining_time_says_whether_it_is_all(done, rest, report, words):
    run = SimpleNamespace(under_way=SimpleNamespace(counts=(done, 3)), remaining=lambda: rest)
    assert live.progress(run, report) == words


@pytest.mark.slow
def test_parts_on_the_command_line_merge(tmp_path, capsys):
    options = ["--methods", "closed_form,reduced", "--no-pictures"]
    folders = [tmp_path / f"part-{k}" for k in (1, 2)]
    for k, folder in enumerate(folders, start=1):
        words = ["run", "paraboloid", "--part", f"{k}/2", "--out", str(folder), *options]
        assert run_command(words) == 0
    merged = tmp_path / "merged"
    names = [str(folder) for folder in folders]
    assert run_command(["merge", *names, "--out", str(merged), "--no-pictures"]) == 0
    assert (merged / "report.html").exists()
    assert run_command(["merge", *names, "--out", str(merged)]) == 2
    assert "expected a new or empty folder" in capsys.readouterr().err
    page = (merged / "report.html").read_text(encoding="utf-8")
    assert "<dt>merged run 2</dt>" in page
    assert "<strong>Part" not in page
    assert "<strong>Part 2/2</strong>" in (folders[1] / "report.html").read_text(encoding="utf-8")
    copy = tmp_path / "copy"
    shutil.copytree(folders[0], copy)
    alone = ["merge", names[0], str(copy), "--out", str(tmp_path / "half"), "--no-pictures"]
    assert run_command(alone) == 1  # what no run has is told
    assert "not done" in capsys.readouterr().out


@pytest.mark.slow
@pytest.mark.usefixtures("methods_restored")
def test_parts_with_a_method_from_outside_merge_where_it_is_named(tmp_path, capsys):
    names = [str(tmp_path / f"part-{k}") for k in (1, 2)]
    words = ["--method-file", str(WINKLER), "--no-pictures"]
    for k, name in enumerate(names, start=1):
        more = ["--part", f"{k}/2", "--out", name, "--methods", "closed_form,reduced,winkler"]
        assert run_command(["run", "paraboloid", *more, *words]) == 0
    METHODS.pop("winkler")
    capsys.readouterr()
    assert run_command(["merge", *names, "--out", str(tmp_path / "a"), "--no-pictures"]) == 2
    assert "winkler" in capsys.readouterr().err
    assert run_command(["merge", *names, "--out", str(tmp_path / "b"), *words]) == 0
