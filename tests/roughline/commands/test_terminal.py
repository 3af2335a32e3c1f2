"""What the command line prints: tables for people, text as it is."""

from dataclasses import replace
from pathlib import Path

import pytest

from comparisons.facts.quantities import quantity
from comparisons.questions.claims.record import FAILS, HOLDS, STORED, load_claims_record
from comparisons.questions.single import solve_scene
from comparisons.questions.study import Study
from comparisons.results.finding import finding
from comparisons.results.rows import NO_ROWS
from comparisons.scene.scene import load_scene
from comparisons.solving.planning import plan_scene
from roughline.commands import terminal

# Everything that a markup language of terminals might take for its own.
HOSTILE = "[red]ball[/red] [/] [bold [link=x] :smile: \x1b[31m"
CHANGES = {
    "title": HOSTILE,
    "loading": {"penetration": [1e-6, 2e-6]},
    "compare": {"methods": ["closed_form", "reduced", "bem_fft"], "resolutions": [4, 8]},
}


@pytest.fixture(autouse=True)
def wide(monkeypatch):
    """Let no cell of a table be folded."""
    monkeypatch.setenv("COLUMNS", "250")


@pytest.fixture
def plans():
    return plan_scene(load_scene("paraboloid", {"name": "ball"} | CHANGES))


@pytest.fixture
def record(plans, tmp_path):
    return Study(plans, tmp_path / "out").run()


def task_of(plans):
    return plans[0].tasks[0]


def test_titles_are_printed_as_they_are(capsys, plans, record, tmp_path):
    """Neither taken for markup nor allowed to send escape codes to the terminal."""
    terminal.print_plans(plans)
    planned = capsys.readouterr().out
    path = tmp_path / "ball.toml"
    path.write_text(plans[0].scene.text, encoding="utf-8")
    terminal.print_solution(solve_scene(str(path), "closed_form"))
    solved = capsys.readouterr().out
    printed = "[red]ball[/red] [/] [bold [link=x] :smile: \N{REPLACEMENT CHARACTER}[31m"
    for text in (planned, solved):
        assert printed in " ".join(text.split())  # a title may be folded
        assert "\x1b" not in text


def test_reasons_and_sentences_are_printed_as_they_are(capsys, plans, record):
    (scene,) = record.scenes
    reference = replace(scene.reference, text="[/] truth.")
    odd = replace(scene, reference=reference, verdicts=(), rows=NO_ROWS)
    odd = replace(odd, disagreements=("[/red] they differ",))
    lost = [(task_of(plans), f"[/bold] broke {k}") for k in range(14)] * 2
    terminal.print_study(record.model_copy(update={"scenes": (odd,)}), lost, verbose=True)
    told = capsys.readouterr().out
    assert "ball: [/] truth." in told
    assert "ball: [/red] they differ" in told
    assert told.count("lost: ball, closed_form, N = 1: [/bold] broke") == terminal.MANY  # each once
    assert f"... and {14 - terminal.MANY} more lost solves" in told


def test_what_is_true_of_several_plans_is_said_once(capsys, plans):
    """A map and its patch share most of their notes."""
    (plan,) = plans
    shared = replace(plan, notes=("both bodies are elastic",))
    terminal.print_plans([shared, replace(shared, notes=(*shared.notes, "cropped"))])
    told = capsys.readouterr().out
    assert told.count("note: both bodies") == told.count("left out: comparison of pressures") == 1
    assert told.count("note: cropped") == told.count("and as above") == 1


def test_a_plan_says_which_resolutions_were_left_out(capsys, plans):
    (plan,) = plans
    some = replace(plan.methods[3], reason="left out 8: needs about 9 GB, and 1 GB are free")
    terminal.print_plans([replace(plan, methods=(*plan.methods[:3], some))])
    assert "[left out 8: needs about 9 GB, and 1 GB are free]" in capsys.readouterr().out


def test_a_study_is_its_quantities_the_finding_and_the_report(capsys, record, monkeypatch):
    """80 columns: the words of the page; few quantities are all printed, however few scenes."""
    monkeypatch.setenv("COLUMNS", "80")
    terminal.print_study(record, [])
    told = capsys.readouterr().out
    lines = told.splitlines()
    assert all(len(line) <= 80 for line in lines[:-1])  # the path is in one piece
    assert len(lines) < 20
    for item in record.scenes[0].verdicts_on():
        assert any(quantity(item.quantity).label in line and item.word in line for line in lines)
    (row,) = finding(record.scenes)
    for text in (row.scenes, row.use, row.error, row.cost, row.instead):
        assert set(text.split()) <= set(told.split())
    assert str(record.directory / "report.html") in told


def test_many_scenes_are_told_in_25_lines(capsys, record):
    """Lines of scenes give way to the finding; 8 rows at most, whatever the families."""
    (scene,) = record.scenes
    named = [replace(scene, name=f"ball-{number}") for number in range(40)]
    terminal.print_study(record.model_copy(update={"scenes": tuple(named)}), [])
    told = capsys.readouterr().out
    assert len(told.splitlines()) <= 25
    assert "axisymmetric bodies (40 scenes)" in told


def test_of_many_claims_the_culprits_are_named(capsys, monkeypatch):
    """A terminal counts what is as expected; a log of a run in CI has a line for each.

    The stored run is counted everywhere: its page has all.
    """
    every = load_claims_record(STORED)
    odd = next(claim for claim in every.claims if claim.verdict == FAILS)
    rest = [claim for claim in every.claims if claim is not odd]
    odd = odd.model_copy(update={"expected": HOLDS})
    record = every.model_copy(update={"claims": [odd, *rest]})
    monkeypatch.setenv("COLUMNS", "1000")
    for is_terminal, took in (("0", ""), ("1", ""), ("0", "the stored run took ")):
        monkeypatch.setenv("TTY_COMPATIBLE", is_terminal)
        terminal.print_claims(record, Path("report.html"), took)
        told = capsys.readouterr().out
        assert "fails, expected holds" in told
        lines = told.replace("\x1b[0m", "").splitlines()
        for text in (text for claim in rest for text in claim.disagreements):
            assert sum(line.endswith(f": {text}") for line in lines) == 1  # of all claims at once
        assert odd.id in told
        rows = {claim.id for claim in rest}.intersection(told.split())
        assert len(rows) == (len(rest) if (is_terminal, took) == ("0", "") else 0)
    assert f"{len(record.claims)} claims: " in told
    assert "report.html  (the stored run took " in told


def test_a_solution_is_printed_in_prefixed_units(capsys):
    """Hertz at d = 1 um under R = 10 mm, steel: F = 4/3 E* R^(1/2) d^(3/2) = 30.7692 N."""
    result = solve_scene("paraboloid", "closed_form")
    terminal.print_solution(result)
    lines = capsys.readouterr().out.splitlines()
    heading = next(line for line in lines if "penetration depth d / µm" in line)
    assert "force F / kN" in heading
    first = lines[lines.index(heading) + 1].split()
    force = 4 / 3 * 210e9 / 0.91 * 0.1 * 1e-9 / 1e3
    assert float(first[0]) == pytest.approx(1.0, rel=1e-5)
    assert float(first[1]) == pytest.approx(force, rel=1e-5)
    assert any("resolution 1" in line for line in lines)


def test_a_narrow_terminal_breaks_no_word(capsys, record, monkeypatch):
    """Of a table on 40 columns every cell would be broken: a scene is a line of words instead."""
    monkeypatch.setenv("COLUMNS", "40")
    terminal.print_study(record, [])
    lines = capsys.readouterr().out.splitlines()
    assert {"within", "Reduced", "model"} <= set(" ".join(lines).split())
    assert max(map(len, lines[:-1])) <= 40  # the path of the report is in one piece
