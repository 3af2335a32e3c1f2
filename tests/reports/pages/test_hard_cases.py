"""The command `hard-cases` and its page: all outcomes shown, failures plotted, input distrusted."""

import json

import pytest

from comparisons.errors import LostWorkError, ResultsError
from comparisons.methods.normal.reduced import ReducedProfile
from comparisons.methods.registry import SOLVERS
from comparisons.questions.hard_cases import case as files
from comparisons.questions.hard_cases.case import HardCasesRecord, OutcomeRecord, load_record
from comparisons.results.folder import PAGE
from comparisons.solving.jobs import SerialExecutor
from reports.pages.hard_cases import hard_cases_page, stability
from reports.plots.interactive import spec
from roughline.commands.app import run_command


def outcome(case="ball", method="reduced", kind="accurate", **more):
    numbers = {"error": 1e-3, "area_error": 0.01, "bar": 1e-4, "seconds": 0.01, "resolution": 40}
    if kind not in ("accurate", "degraded"):
        numbers = {"error": None, "area_error": None, "bar": None, "seconds": None, "resolution": 0}
    fixed = {"case": case, "title": case.title(), "method": method, "kind": kind, "reason": ""}
    rest = {"lost": [], "expected": "accurate, error at most 1 %", "deviation": ""}
    return OutcomeRecord(**fixed | numbers | rest | more)


@pytest.fixture
def record():
    def make(*outcomes, **more):
        settings = {
            "created": "2026-01-01T12:00:00+00:00",
            "command": "roughline hard-cases",
            "effort": "quick",
            "seconds": 1.0,
            "machine": {"processor": "abacus", "cores": 2},
            "versions": {"numpy": "2.0"},
            "interrupted": False,
            "hard": {},
        }
        return HardCasesRecord(**settings | more, outcomes=list(outcomes))

    return make


@pytest.fixture
def hard_cases(tmp_path):
    """Return a runner of the command on a few cases; it gives the exit code and the folder."""

    def run(*arguments):
        folder = tmp_path / "out"
        return run_command(["hard-cases", *arguments, "--out", str(folder)]), folder

    return run


FEW = ("--case", "load-one", "--case", "profile-hollow", "--case", "nu-0-5")


def test_the_command_writes_table_record_and_page_which_is_written_anew(
    hard_cases, capsys, tmp_path
):
    code, folder = hard_cases("reduced", "closed_form", *FEW, "--json", str(tmp_path / "own.json"))
    assert code == 0
    assert {part.name for part in folder.iterdir()} == {*(files.RECORD, files.TABLE, PAGE)}
    assert "every outcome is as the catalogue expects" in capsys.readouterr().out
    document = json.loads((tmp_path / "own.json").read_text())
    assert document == json.loads((folder / files.RECORD).read_text())
    kinds = {(part["case"], part["method"]): part["kind"] for part in document["outcomes"]}
    assert kinds["load-one", "reduced"] == "accurate"
    assert kinds["profile-hollow", "closed_form"] == "refused"
    assert len(kinds) == 6
    (folder / PAGE).unlink()
    assert run_command(["report", str(folder)]) == 0
    assert "Poisson" in (folder / PAGE).read_text()


def test_an_unexpected_outcome_is_exit_code_one(hard_cases, monkeypatch, capsys):
    class Soft(ReducedProfile):
        def solve(self, task):
            solution = super().solve(task)
            solution.quantities["force"] *= 0.9
            return solution

    monkeypatch.setitem(SOLVERS, "reduced", (Soft,))
    code, folder = hard_cases("reduced", *FEW)
    assert code == 1
    assert "degraded instead of accurate" in capsys.readouterr().out
    assert "Not as expected" in (folder / PAGE).read_text()


def test_an_interrupted_run_keeps_what_is_done(hard_cases, monkeypatch, capsys):
    class Stopped(ReducedProfile):
        def solve(self, task):
            if task.scene.name == "load-twins-force":
                raise KeyboardInterrupt
            return super().solve(task)

    monkeypatch.setitem(SOLVERS, "reduced", (Stopped,))
    code, folder = hard_cases("reduced", "--case", "load-one", "--case", "load-twins-force")
    assert code == 3
    # this command has no --resume to speak of
    assert capsys.readouterr().err == "solved 0 of 4\ninterrupted\n"
    kept = load_record(folder)
    assert kept.interrupted
    assert (folder / PAGE).is_file()
    assert [item.case for item in kept.outcomes] == ["load-one"]


def test_a_lost_cluster_is_told_with_its_reason(hard_cases, monkeypatch, capsys):
    def lost(executor):
        raise LostWorkError("the scheduler is gone")

    monkeypatch.setattr(SerialExecutor, "finished", lost)
    code, folder = hard_cases("reduced", "--case", "load-one")
    assert code == 3
    assert capsys.readouterr().err == "solved 0 of 2\nthe scheduler is gone\n"
    assert load_record(folder).interrupted


def test_failures_are_hollow_crosses_at_the_upper_edge(record):
    """Lost and refused ones; a method never meant for a case has not failed."""
    figure = stability(
        record(
            outcome(),
            outcome("ring", kind="refused", reason="hollow"),
            outcome("rough", kind="lost", reason="no luck"),
            outcome("map", kind="not for", reason="no form"),
        )
    )
    solved, failed = spec(figure)["data"]
    assert solved["y"] == [pytest.approx(1.1e-3)]
    assert failed["marker"]["symbol"] == "x-open"
    assert [text.partition(": ")[2] for text in failed["text"]] == [
        "refused: hollow",
        "lost: no luck",
    ]
    low, high = spec(figure)["layout"]["yaxis"]["range"]
    assert all(y == pytest.approx(10**high, rel=0.01) for y in failed["y"])
    assert low < high
    assert len(set(failed["x"])) == 2


def test_round_off_is_an_arrow_and_the_axis_has_one_unit(record):
    """An error of 1e-13 is no value: 1 ppm and 1e-12 on one axis squeezed all others."""
    figure = stability(record(outcome(), outcome("exact", error=1e-13, bar=0.0)))
    _, arrows = spec(figure)["data"]
    assert arrows["marker"]["symbol"] == "arrow-down"
    ticks = spec(figure)["layout"]["yaxis"]["ticktext"]
    assert ticks[0].startswith("\u2264")
    assert all(text.endswith("%") for text in ticks)


def test_without_a_solution_there_is_no_plot(record):
    assert stability(record(outcome(kind="lost", reason="x"))) is None
    assert "<table" in hard_cases_page(record(outcome(kind="lost", reason="x")))


def test_the_head_of_a_method_tells_what_all_its_solves_took(record):
    several = outcome(seconds=0.5), outcome("cone", seconds=1.5), outcome(method="fem", kind="lost")
    head = hard_cases_page(record(*several)).split("<thead>")[1].split("</thead>")[0]
    assert head.count("2.0\u202fs<") == 1
    assert head.count('class="muted"') == 1  # nothing of what took no time


def test_names_and_reasons_cannot_inject_html(record):
    evil = '<script>alert(1)</script>"onload="x'
    page = hard_cases_page(
        record(
            outcome(),
            outcome(evil, method=evil, kind="lost", reason=evil, deviation=evil, expected=evil),
            outcome(evil, method=evil, title=evil),
            command=evil,
        )
    )
    assert "<script>alert" not in page
    assert '"onload="' not in page


def test_a_refusal_of_all_methods_is_said_once(record):
    shown = [outcome("ring", m, "refused", reason="hollow profiles") for m in ("reduced", "fem")]
    assert hard_cases_page(record(*shown)).count("hollow profiles") == 1


@pytest.mark.parametrize("text", ["", "{", '{"outcomes": 3}', "[]", "\udcff"])
def test_damaged_records_are_refused(tmp_path, text):
    (tmp_path / files.RECORD).write_bytes(text.encode(errors="surrogateescape"))
    with pytest.raises(ResultsError, match="damaged results"):
        load_record(tmp_path)
    assert run_command(["report", str(tmp_path)]) == 2
