"""The command line: its commands and exit codes, one clear message each, nothing written astray."""

import csv
import json
import os
import shutil
import signal
import subprocess
import sys
import time
import tomllib
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from comparisons.facts.methods import METHODS
from comparisons.methods.normal.reduced import ReducedProfile
from comparisons.methods.registry import SOLVERS
from comparisons.questions import study as study_module
from comparisons.questions.claims.claim import load_claims
from comparisons.questions.hard_cases.case import catalogue
from comparisons.results import store
from comparisons.results.store import load_study
from comparisons.scene.scene import SUITES, builtin_names, load_scene
from roughline.commands import app as cli
from roughline.commands.app import run_command

ROOT = Path(__file__).parents[3]
BALL = """
name = "steel-ball"
title = "Steel ball on a half-space"
[half_space]
youngs_modulus = "210 GPa"
poisson_ratio = 0.3
[indenter]
shape = "paraboloid"
radius = "10 mm"
[loading]
penetration = [1e-6, 2e-6]
[compare]
methods = ["closed_form", "reduced", "bem_fft"]
resolutions = [6, 12]
"""
MAP = """
name = "measured"
[half_space]
effective_modulus = "1 GPa"
[surface]
kind = "map"
file = "map.npy"
size = "1 um"
height_unit = "nm"
[loading]
penetration = ["1 nm"]
"""


@pytest.fixture
def roughline(tmp_path, monkeypatch, capsys):
    """Run a command in an empty folder; return its exit code, what it printed and complained."""
    monkeypatch.chdir(tmp_path)
    # Wide enough that no table cell is folded.
    monkeypatch.setenv("COLUMNS", "250")
    # Compiled here: digits are not compared with those of another process.
    monkeypatch.setattr(study_module, "compile_apart", lambda task: 0.0)
    monkeypatch.setattr(study_module, "compile_ahead", lambda tasks: ())

    def run(*arguments):
        capsys.readouterr()
        code = run_command([str(argument) for argument in arguments])
        told = capsys.readouterr()
        return SimpleNamespace(code=code, out=told.out, err=told.err)

    return run


@pytest.fixture
def ball(tmp_path):
    (tmp_path / "ball.toml").write_text(BALL)
    return "ball.toml"


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Run the ball's scene as a whole, once for all that look at its folder."""
    home = tmp_path_factory.mktemp("whole")
    (home / "ball.toml").write_text(BALL)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(home)
        assert run_command(["run", "ball.toml", "--out", "o", "--no-pictures"]) == 0
    return home / "o"


@pytest.fixture
def copied(whole, tmp_path):
    return shutil.copytree(whole, tmp_path / "o")


@pytest.mark.parametrize("kind", ["ball", "map", "punch", "rough", "cone"])
def test_a_new_scene_file_can_be_planned_and_is_never_overwritten(roughline, tmp_path, kind):
    np.savetxt(tmp_path / "heights.csv", np.random.default_rng(1).normal(size=(16, 16)))
    assert roughline("new", kind).code == 0
    planned = roughline("run", f"{kind}.toml", "--plan", "--tolerance", "2%")
    assert planned.code == 0, planned.err
    again = roughline("new", kind)
    assert (again.code, again.err) == (2, f"{kind}.toml: exists; choose another name\n")


def test_loads_that_no_method_answers_still_make_a_page(roughline, tmp_path, ball):
    """10^300 m: every solve is lost, told, and the exit code says so."""
    told = roughline("run", ball, "--loads", "penetration=1e300 m", "--out", "o", "--no-pictures")
    assert told.code == 1
    assert "Traceback" not in told.err
    assert (tmp_path / "o" / "report.html").exists()


def table(path):
    with Path(path).open(newline="", encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


def files(folder):
    return {path.relative_to(folder).as_posix() for path in Path(folder).rglob("*")}


# One of each kind: read, validated, of a file beside it, of its size, of its loads. What else is
# wrong with a scene: tests/comparisons/scene.
SCENES = {
    "nu = 0.6": (BALL.replace("0.3", "0.6"), "half_space.poisson_ratio: expected a number with"),
    "NaN in the map": (MAP.replace("map.npy", "holes.npy"), "surface.file: holes.npy: "),
    "binary": (b"\x7fELF\x00\xff", "not a readable text file"),
    "huge points": (
        load_scene("rough-patch").text.replace("    16,", "    1048576,"),
        "surface.points: expected arrays that fit into 80% of the free memory",
    ),
    "beyond the shape": (
        BALL.replace("paraboloid", "sphere").replace("[1e-6, 2e-6]", '["1 m"]'),
        "loading.penetration: ",
    ),
}


@pytest.mark.parametrize("command", ["run", "solve"])
@pytest.mark.parametrize("wrong", SCENES)
def test_a_wrong_scene_is_one_clear_message_and_nothing_is_written(
    roughline, tmp_path, command, wrong
):
    content, expected = SCENES[wrong]
    (tmp_path / "s.toml").write_bytes(content if isinstance(content, bytes) else content.encode())
    heights = np.random.default_rng(0).normal(size=(16, 16))
    heights[3, 4] = np.nan
    np.save(tmp_path / "holes.npy", heights)
    before = files(tmp_path)
    # Of the dense solver alone, so that each scene would be quick if it were let through.
    options = ["--out", "out"] if command == "run" else ["--method", "bem_dense", "--csv", "t.csv"]
    result = roughline(command, "s.toml", *options)
    assert result.code == 2
    assert expected in result.err
    assert "Traceback" not in result.err
    assert result.err.count(expected) == 1
    assert result.out == ""
    assert files(tmp_path) == before


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["run", "nowhere.toml"], "no such file"),
        (["run", "paraboloid", "paraboloid"], "paraboloid: expected different names"),
        (["run", "paraboloid", "--workers", "0"], "--workers: expected 1 to "),
        (["run", "paraboloid", "--workers", "2", "--scheduler", "tcp://a:1"], "at most one"),
        (
            ["run", "paraboloid", "--part", "6/5"],
            "expected K/N with K from 1 to N, such as 2/5, got",
        ),
        (["run", "paraboloid", "--part", "1/" + "9" * 5000], "got '1/999"),
        (["run", "paraboloid", "--loads", "forse=1 N"], "forse: unknown key; did you mean force"),
        (["run", "paraboloid", "--loads", "1 N"], "CONTROL=VALUE"),
        (["run", "paraboloid", "--loads", "penetration=0,2um"], "expected positive finite values"),
        (["plan"], "did you mean `roughline run --plan`?"),
        (["methods"], "did you mean `roughline list methods`?"),
        (["scenes"], "did you mean `roughline list scenes`?"),
        (["run", "paraboloid", "--quantities", "contact_aera"], "did you mean contact_area or"),
        (
            ["run", "adhesive-ball", "rubber-ball", "--methods", "fem"],
            "rubber-ball: no method asked for can solve this scene\n  fem: does not",
        ),
        # once, not for each scene of the suite
        (["run", "--methods", "fem,magic"], "got 'magic'"),
        (["run", "--methods", ""], "compare.methods.0: expected"),
        (["run", "--option", "fem.contact=glue"], "methods.fem.contact: expected 'active_set'"),
        (["run", "--option", "fem.contact"], "--option: expected METHOD.KEY=VALUE"),
        (["run", "--option", "a.b.c=1"], "--option: expected METHOD.KEY=VALUE"),
        (["run", "cone", "--set", "indenter.slope"], "--set: expected KEY=VALUE"),
        (["run", "cone", "--set", "indenter.slop=1"], "indenter.slop: unknown key"),
        (["new", "bal"], "new: expected ball, map, punch, rough or the name of a built-in scene"),
        (["run", "--frobnicate"], "frobnicate"),
        (["solve", "paraboloid"], "method"),
        (["solve", "paraboloid", "--method", "magic"], "--method: expected one of closed_form,"),
        (["solve", "paraboloid", "--method", "fem", "--resolution", "1"], "expected at least 2"),
        (["solve", "paraboloid", "--method", "fem", "--resolution", "1.5"], "a whole number"),
        (["solve", "cylinder", "--method", "kalker"], "no [rolling]"),
        (["claims", "--quick", "--full"], "expected one of --full and --quick, got both"),
        (["advise", "cylinder", "--tolerance", "-5%"], "a positive finite number, got -0.05"),
        (["solve", "paraboloid", "--method", "reduced", "--vtu", "x.vtu"], "no field on a mesh"),
        (
            ["solve", "paraboloid", "--method", "fem", "--csv", "t.vtu", "--vtu", "t.vtu"],
            "--csv and --vtu: expected two files, got t.vtu twice",
        ),
        (
            ["solve", "paraboloid", "--method", "reduced", "--json", "--csv", "t.csv"],
            "--json and --csv: expected at most one",
        ),
        (
            ["solve", "paraboloid", "--method", "bem_fft", "--resolution", "500000"],
            "bem_fft cannot solve this scene at resolution 500000: needs about",
        ),
        (["list", "hardcases"], "got 'hardcases'; did you mean hard-cases?"),
        (["list", "wishes"], "list: expected one of scenes, methods, claims, hard-cases, got"),
        (["report", "nowhere"], "no results of roughline here"),
        (["frobnicate"], "frobnicate"),
        (["compare", "a", "b", "--slower", "0.5"], "slower: expected a number above 1, got 0.5"),
        (["compare", "a", "b", "--tolerance", "-1"], "tolerance: expected a number above 0, got"),
        (["claims", "punch-squar"], "did you mean punch-square or"),
        (["hard-cases", "reduced", "--case", "cups"], "did you mean cusp?"),
        (["bench", "nothing"], "expected one of reduced, bem"),
        (["hard-cases", "nastran", "--case", "moon"], "'nastran'"),
        (["hard-cases", "nastran", "--case", "moon"], "'moon'"),
        (["paper", "nowhere", "--out", "o"], "no results of roughline here"),
        (["problems", "RL-000"], "'RL-000'"),
    ],
)
def test_a_wrong_command_is_one_clear_message_and_nothing_is_written(
    roughline, tmp_path, arguments, expected
):
    result = roughline(*arguments)
    assert result.code == 2
    said = result.err + result.out
    assert expected in said
    assert said.count(expected) == 1 or ":" not in expected
    assert "Traceback" not in said
    assert files(tmp_path) == set()


def test_an_entry_that_was_filled_in_is_not_written_anew(roughline, tmp_path):
    assert roughline("problems", "RL-001", "--out", "p").code == 0
    (tmp_path / "p/entry.json").write_text("mine")
    assert "choose another folder" in roughline("problems", "RL-001", "--out", "p").err
    assert (tmp_path / "p/entry.json").read_text() == "mine"


@pytest.mark.parametrize(
    "words",
    [
        ("rough-theories", "--loads", "mean_gap=1 um"),
        ("plastic-ball", "--quantities", "residual_depth"),
    ],
)
def test_options_are_held_against_the_scene_that_they_change(roughline, words):
    """A paraboloid has no mean gap, and leaves no dent: what is right here was refused for it."""
    assert roughline("run", *words, "--plan").code == 0
    told = f"{words[1]}:\n"  # the option that is wrong, not one of the others given
    right = ("--tolerance", "5%", "--methods", "bem_fft", "--plan")
    assert roughline("run", "paraboloid", *words[1:], *right).err.startswith(told)
    several = roughline("run", words[0], "paraboloid", "sphere", *words[1:], "--plan").err
    assert several.startswith(told)
    assert several.endswith(" (in paraboloid, sphere)\n")
    assert several.count("\n") == 2


def test_problems_of_options_and_of_the_file_are_told_apart(roughline, tmp_path):
    """What an option mends is none, and what it brings is told beside what the file has."""
    (tmp_path / "a.toml").write_text(BALL.replace("10 mm", "-10 mm"))
    nonsense = ("--methods", "nonsense", "--plan")
    (tmp_path / "unloaded.toml").write_text(
        BALL.replace("[loading]\npenetration = [1e-6, 2e-6]\n", "")
    )
    mended = roughline("run", "unloaded.toml", "--loads", "force=1 N", *nonsense).err
    assert "nonsense" in mended
    assert "loading" not in mended.partition("\n")[2]
    both = roughline("run", "a.toml", *nonsense).err
    assert "a.toml:\n  indenter.radius: " in both
    assert "--methods:\n  compare.methods" in both


def test_problems_of_all_files_come_at_once(roughline, tmp_path):
    (tmp_path / "a.toml").write_text(SCENES["nu = 0.6"][0])
    (tmp_path / "b.toml").write_text(BALL.replace("10 mm", "-10 mm"))
    result = roughline("run", "a.toml", "b.toml", "c.toml")
    assert result.code == 2
    for part in ("a.toml:", "nu <= 0.5", "b.toml:", "indenter.radius", "c.toml:", "no such file"):
        assert part in result.err


STICKY = BALL.replace(
    "[loading]", "[adhesion]\nwork = 0.05\n[friction]\ncoefficient = 0.3\n[loading]"
)
STICKY = STICKY.replace("penetration = [1e-6, 2e-6]", "force = 1\ntangential_force = 0.1")
STICKY = STICKY.partition("[compare]")[0]


@pytest.mark.parametrize(
    "command", [["run"], ["run", "--plan"], ["advise"], ["run", "adhesive-ball"]], ids=" ".join
)
def test_a_scene_that_no_method_can_do_is_refused_with_every_reason(roughline, tmp_path, command):
    """Adhesion with friction: methods have one or the other, none both. Nothing is solved."""
    (tmp_path / "sticky.toml").write_text(STICKY)
    result = roughline(*command, "sticky.toml")
    assert result.code == 2
    assert "steel-ball: no method can solve this scene" in result.err
    assert "reduced, bem_fft: does not model [friction] and [adhesion] in one scene" in result.err
    assert files(tmp_path) == {"sticky.toml"}


def test_a_method_that_can_do_some_of_the_scenes_is_planned_for_them(roughline):
    result = roughline("run", "adhesive-ball", "paraboloid", "--methods", "fem", "--plan")
    assert result.code == 0
    assert "does not model [adhesion]" in result.out


def test_a_file_in_the_place_of_a_folder(roughline, tmp_path, ball):
    (tmp_path / "file").write_text("mine")
    before = files(tmp_path)
    for arguments in (
        ["run", ball, "--out", "file"],
        ["run", ball, "--out", "file/below"],
        ["report", "file"],
        ["solve", ball, "--method", "reduced", "--csv", "file/t.csv"],
    ):
        result = roughline(*arguments)
        assert result.code == 2
        assert "file" in result.err
    assert (tmp_path / "file").read_text() == "mine"
    assert files(tmp_path) == before


def test_solve_prints_one_json_object_of_the_contract(roughline, ball):
    result = roughline("solve", ball, "--method", "bem_fft", "--resolution", "8", "--json")
    assert (result.code, result.err) == (0, "")
    document = json.loads(result.out)
    assert document["scene"] == "steel-ball"
    assert document["method"] == "bem_fft"
    assert document["resolution"] == 8
    assert document["converged"] is True
    assert document["unknowns"] > 100
    assert 0 <= document["setup_seconds"] <= document["seconds"]
    for name in ("iterations", "violation", "penetration", "force", "contact_area"):
        assert len(document[name]) == 2
    assert max(document["violation"]) <= 1e-8  # the default tolerance of the solver


def test_json_has_the_pressure_of_the_last_step_over_r_or_over_x_and_y(roughline):
    document = json.loads(roughline("solve", "paraboloid", "--method", "reduced", "--json").out)
    r, p = (np.array(document["pressure"][key]) for key in ("r", "p"))
    assert (np.diff(r) > 0).all()
    mean = document["force"][-1] / document["contact_area"][-1]
    assert p.max() == pytest.approx(1.5 * mean, rel=1e-3)
    patch = ("solve", "rough-patch", "--method", "bem_fft", "--resolution", "16", "--json")
    document = json.loads(roughline(*patch).out)
    assert set(document["pressure"]) == {"x", "y", "p"}
    assert len(document["pressure"]["p"]) == 16 * 16


def test_json_of_an_ensemble_has_means_and_standard_errors(roughline, tmp_path):
    several = load_scene("rough-patch", {"surface.realisations": 3})
    (tmp_path / "patch.toml").write_text(several.text)
    solve = ("solve", "patch.toml", "--method", "bem_fft", "--resolution", "16", "--json")
    document = json.loads(roughline(*solve).out)
    assert document["realisations"] == 3
    assert document["resolution"] == 16
    for name in ("contact_area", "penetration", "mean_gap"):
        assert len(document[name]) == len(document[f"{name}_stderr"]) == 5
        assert min(document[f"{name}_stderr"]) > 0


def test_threads_change_no_digit_and_are_no_more_than_the_cores(roughline, ball, monkeypatch):
    monkeypatch.setattr("os.cpu_count", lambda: 2)
    command = ("solve", ball, "--method", "bem_fft", "--resolution", "8", "--json", "--threads")
    alone, shared = (json.loads(roughline(*command, number).out) for number in ("1", "2"))
    assert shared["force"] == alone["force"]
    for number in ("0", "3"):
        result = roughline(*command, number)
        assert result.code == 2
        assert "--threads: expected 1 to 2" in result.err


def test_solve_writes_a_table(roughline, tmp_path, ball):
    result = roughline("solve", ball, "--method", "closed_form", "--csv", "sub/t.csv")
    assert (result.code, result.out, result.err) == (0, "", "")
    rows = table("sub/t.csv")
    assert [row["step"] for row in rows] == ["0", "1"]
    hertz = 4 / 3 * 210e9 / 0.91 * 0.1 * 2e-6**1.5
    assert float(rows[1]["force"]) == pytest.approx(hertz, rel=1e-12)
    assert files(tmp_path) == {"ball.toml", "sub", "sub/t.csv"}


def test_solve_questions_a_doubtful_scene(roughline, tmp_path, ball):
    text = (tmp_path / "ball.toml").read_text().replace("210 GPa", "210 Pa")
    (tmp_path / "soft.toml").write_text(text)
    result = roughline("solve", "soft.toml", "--method", "reduced", "--json")
    assert result.code == 0
    assert "check the units of the scene: E* = 231" in result.err


def test_options_of_the_method_with_or_without_its_name(roughline):
    options = (["--option", "stress=local"], ["--option", "reduced.stress=local"], [])
    solve = ("solve", "paraboloid", "--method", "reduced", "--json")
    result = [json.loads(roughline(*solve, *option).out)["pressure"] for option in options]
    assert result[0] == result[1]
    assert result[0] != result[2]
    several = ["--option", "stress=local", "--option", 'edges="nodal"']
    assert roughline(*solve, *several).code == 0


def test_a_lost_solve_is_code_1_with_the_reason(roughline, ball, monkeypatch):
    class Broken(ReducedProfile):
        def solve(self, task):
            raise RuntimeError("out of springs")

    monkeypatch.setitem(SOLVERS, "reduced", (Broken,))
    result = roughline("solve", ball, "--method", "reduced", "--json")
    assert result.code == 1
    assert "out of springs" in result.err
    assert json.loads(result.out)["converged"] is False
    result = roughline("run", ball, "--out", "out", "--no-pictures")
    assert result.code == 1
    assert "lost: steel-ball, reduced, N = 6: RuntimeError: out of springs" in result.out
    assert Path("out/report.html").exists()

    class Shallow(ReducedProfile):
        def solve(self, task):
            solution = super().solve(task)
            solution.fail((0, 1), "too deep")
            return solution

    monkeypatch.setitem(SOLVERS, "reduced", (Shallow,))
    told = roughline("run", ball, "--out", "shallow", "--no-pictures").out
    partly = "1 of 2 load steps, the first is load step 2: too deep"
    assert f"lost: steel-ball, reduced, N = 6: {partly}" in told


def test_run_writes_everything_into_its_folder_and_is_silent_elsewhere(roughline, tmp_path, ball):
    """Default folder roughline-results/NAME; a line of progress where it goes into a log."""
    result = roughline("run", ball, "--no-pictures")
    assert result.code == 0
    last = result.err.splitlines()[-1]
    assert last.startswith("solved 5 of 5, ")
    assert last.endswith(", done: steel-ball")
    folder = tmp_path / "roughline-results" / "steel-ball"
    assert {"results.csv", "measures.csv", "study.json", "report.html", "fields"} <= files(folder)
    top = {path.name for path in tmp_path.iterdir()}
    assert top == {"ball.toml", "roughline-results"}
    assert "roughline-results/steel-ball/report.html" in result.out
    assert "within 1" in result.out
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert "Steel ball on a half-space" in page


@pytest.mark.parametrize(
    ("scenes", "name"),
    [(["cone"], "cone"), (["cone", "cylinder"], "cone+cylinder"), (["single"], "single")],
)
def test_the_default_folder_is_named_after_what_is_run(
    roughline, tmp_path, monkeypatch, scenes, name
):
    """A run that is stopped at once has its folder, too."""

    def stop(task):
        raise KeyboardInterrupt

    monkeypatch.setattr(study_module, "execute", stop)
    result = roughline("run", *scenes, "--methods", "closed_form", "--no-pictures")
    assert result.code == 3
    assert [path.name for path in (tmp_path / "roughline-results").iterdir()] == [name]


def test_what_the_command_says_goes_before_the_scene(roughline, tmp_path, ball):
    """Loads, tolerance, quantities, methods and their options; into the folder that is named."""
    asked = ("--loads", "force=1 N, 10 N", "--tolerance", "2%", "--quantities", "contact_area")
    methods = ("--methods", "closed_form, reduced", "--option", "reduced.edges=nodal")
    run = roughline("run", ball, *asked, *methods, "--out", "a/b", "--no-pictures")
    assert run.code == 0
    (scene,) = load_study(tmp_path / "a/b").scenes
    assert (scene.control, scene.tolerance, scene.quantities) == ("force", 0.02, ("contact_area",))
    solved = scene.rows.where(scene.rows["converged"])
    assert solved["force"].tolist() == pytest.approx([1.0, 10.0] * (len(solved["force"]) // 2))
    options = {row["method"]: row["options"] for row in table("a/b/results.csv") if row["step"]}
    assert options == {"closed_form": "", "reduced": "edges=nodal"}
    assert not (tmp_path / "roughline-results").exists()


def test_a_second_interrupt_while_the_first_is_dealt_with_is_still_code_3(
    roughline, ball, monkeypatch
):
    def stop(*_):
        raise KeyboardInterrupt

    command = ("run", ball, "--out", "o", "--no-pictures", "--methods", "closed_form")
    with monkeypatch.context() as patch:
        patch.setattr(study_module, "execute", stop)
        patch.setattr(store, "save_study", stop)
        assert roughline(*command).code == 3
    assert roughline(*command, "--resume").code == 0


def test_a_plan_names_what_is_done_what_is_not_and_why_and_solves_nothing(
    roughline, tmp_path, monkeypatch
):
    def never(task):
        raise AssertionError("--plan must not solve")

    monkeypatch.setattr(study_module, "execute", never)
    result = roughline("run", "square-punch", "rough-periodic", "--plan")
    assert result.code == 0
    for part in (
        "not run: no closed form is known for a square punch",
        "32, 64, 128",
        "left out: the surface beyond the geometric overlap",
        "not run: the kernel (19.3) is for a free half-space",
        "to begin with, ",
        " surfaces at 64, ",
    ):
        assert part in result.out
    assert "note: quick" not in roughline("run", "rough-periodic", "--plan", "--full").out
    assert roughline("run", "rough-periodic", "--plan", "--quick").out in result.out
    assert files(tmp_path) == set()


def test_without_arguments_the_quick_suite_is_run(roughline):
    result = roughline("run", "--plan")
    assert result.code == 0
    for name in SUITES["quick"]:
        assert f"({name})" in result.out


@pytest.mark.slow
def test_files_beside_the_scene_are_found_from_anywhere_and_never_written_to(
    roughline, tmp_path, monkeypatch
):
    (tmp_path / "data").mkdir()
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "data" / "m.toml").write_text(MAP)
    np.save(tmp_path / "data" / "map.npy", np.random.default_rng(0).normal(size=(16, 16)))
    before = files(tmp_path / "data")
    monkeypatch.chdir(tmp_path / "elsewhere")
    result = roughline("run", "../data/m.toml", "--methods", "bem_fft", "--no-pictures")
    assert result.code == 0
    assert files(tmp_path / "data") == before
    assert Path("roughline-results/measured/results.csv").exists()


def test_report_writes_the_page_anew(roughline, copied):
    page = copied / "report.html"
    page.unlink()
    result = roughline("report", "o", "--no-pictures")
    assert (result.code, result.out.strip()) == (0, "o/report.html")
    assert page.stat().st_size > 1000


def test_lists_name_what_is_built_in(roughline):
    for what, names in (
        *(("scenes", builtin_names()), ("methods", METHODS)),
        *(("hard-cases", catalogue()), ("claims", [claim.id[:10] for claim in load_claims()])),
    ):
        told = roughline("list", what)
        assert told.code == 0
        assert all(name in told.out for name in names)
        if what == "scenes":
            (row,) = [line for line in told.out.splitlines() if line.startswith("paraboloid ")]
            assert "quick, single" in row
    overview = roughline("list").out.split()
    assert [overview[overview.index(word) - 1] for word in ("methods", "scenes")] == [
        str(len(METHODS)),
        str(len(builtin_names())),
    ]


COMMANDS = {"run", "solve", "list", "advise", "claims", "hard-cases", "check", "report"}
COMMANDS |= {"compare", "bench"}


def test_help_lists_the_commands_and_each_has_a_page(roughline):
    result = roughline("--help")
    assert result.code == 0
    # Commands stand first in the lines of their box.
    words = {line.split()[1] for line in result.out.splitlines() if len(line.split()) > 2}
    assert words >= COMMANDS
    for command in COMMANDS:
        page = roughline(command, "--help")
        assert page.code == 0
        assert f"Usage: roughline {command}" in page.out
        assert "docs/" not in page.out  # a path of the repository, which an installation has not


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        (["run", "\x1b[31mred.toml"], 2),
        (["run", "cone", "--methods", "closed_form", "--no-pictures", "--out", "o\x1b[31mred"], 0),
        (["report", "\x1b[31mred"], 2),
        (["check", "cone", "--baseline", "\x1b[31mred"], 2),
    ],
)
def test_a_file_name_does_not_command_the_terminal(roughline, tmp_path, arguments, code):
    """ESC [31m turns what follows red; other sequences move the cursor or name the window."""
    (tmp_path / "\x1b[31mred.toml").write_text("x = [")
    result = roughline(*arguments)
    assert result.code == code
    said = result.out + result.err
    assert "\N{REPLACEMENT CHARACTER}[31mred" in said
    assert "\x1b" not in said


ENVIRONMENT = os.environ | {"PYTHONPATH": str(ROOT), "COLUMNS": "200"}


PROGRAM = ("-m", "roughline")


def started(*arguments, cwd):
    """Start Python with these arguments; both outputs are pipes."""
    return subprocess.Popen(
        [sys.executable, *arguments],
        cwd=cwd,
        env=ENVIRONMENT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


@pytest.mark.slow
def test_a_closed_output_is_no_traceback_and_gets_no_file(tmp_path):
    """``roughline solve ... >&-``: a file that is opened next would have the number of stdout."""
    words = [sys.executable, "-m", "roughline", "solve", "paraboloid", "--method", "closed_form"]
    done = subprocess.run(
        ["sh", "-c", 'exec "$@" --vtu none.vtu >&-', "sh", *words],
        cwd=tmp_path,
        env=ENVIRONMENT,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert "has no field on a mesh" in done.stderr


def test_the_exit_code_of_the_program_is_that_of_the_command(tmp_path):
    for words, code, said in (["scenes"], 0, "paraboloid"), (["wishes"], 2, "wishes"):
        with started(*PROGRAM, "list", *words, cwd=tmp_path) as process:
            told, complained = process.communicate(timeout=120)
        assert process.returncode == code
        assert said in (complained if code else told)
    assert files(tmp_path) == set()


def test_the_version_is_that_of_the_project(capsys):
    text = (Path(cli.__file__).parents[2] / "pyproject.toml").read_text(encoding="utf-8")
    assert cli.run_command(["--version"]) == 0
    assert capsys.readouterr().out.strip() == tomllib.loads(text)["project"]["version"]


@pytest.mark.slow
@pytest.mark.usefixtures("interruptible")
@pytest.mark.parametrize("module", ["cyclopts.exceptions", "pydantic", "scipy.linalg", "skfem"])
def test_control_c_while_packages_are_imported_is_code_3(tmp_path, module):
    """Whichever import it meets; before our first line, Python itself answers."""
    words = ("-X", "importtime", *PROGRAM, "run", "paraboloid", "--plan")
    with started(*words, cwd=tmp_path) as process:
        for line in process.stderr:
            if line.endswith(f" {module}\n"):
                break
        process.send_signal(signal.SIGINT)
        said = process.stderr.read()
    assert process.returncode == 3
    assert "Traceback" not in said
    assert "interrupted" in said


@pytest.mark.slow
@pytest.mark.usefixtures("interruptible")
@pytest.mark.parametrize("press", [signal.SIGINT, signal.SIGTERM])
def test_control_c_and_term_are_code_3_and_what_is_done_can_be_gone_on_with(tmp_path, press):
    """A real signal, sent once the first solve of a long run is on disk."""
    process = started(*PROGRAM, "run", "single", "--out", "o", "--no-pictures", cwd=tmp_path)
    deadline = time.monotonic() + 60
    while not list(tmp_path.glob("o/fields/*.npz")) and time.monotonic() < deadline:
        time.sleep(0.05)
    process.send_signal(press)
    _, complaint = process.communicate(timeout=60)
    assert process.returncode == 3, complaint
    assert complaint.endswith("interrupted; finished solves are kept, continue with --resume\n")
    assert load_study(tmp_path / "o").interrupted
    assert (tmp_path / "o" / "report.html").exists()


INTERRUPT = """
import os, signal, sys, time
from roughline import __main__
from roughline.commands import app as cli

def interrupt(*arguments, **options):
    os.kill(os.getpid(), signal.SIGINT)
"""

# What becomes of a ctrl-C, whose traceback nobody should see.
INTERRUPTED = {
    "another comes while it is told": """
class Interrupting:
    def write(self, text):
        interrupt()
        return sys.__stderr__.write(text)

    def flush(self):
        sys.__stderr__.flush()

cli.app = interrupt
sys.stderr = Interrupting()
""",
    "a library gives up": """
def cli_app(*arguments, **options):
    try:
        interrupt()
    except KeyboardInterrupt:
        raise SystemExit(1)

cli.app = cli_app
""",
    "an extension that was loading forgets it": """
def cli_app(*arguments, **options):
    try:
        interrupt()
    except KeyboardInterrupt:
        pass
    raise ImportError

cli.app = cli_app
""",
    "a destructor swallows it": """
class Gone:
    __del__ = interrupt

def cli_app(*arguments, **options):
    Gone()
    time.sleep(600)

cli.app = cli_app
""",
}
INTERRUPTED["it comes again before the hook has ended"] = """
class Hasty(__main__.threading.Timer):
    first = True

    def start(self):
        super().start()
        if Hasty.first:
            Hasty.first = False
            time.sleep(0.2)

__main__.threading.Timer = Hasty
""" + INTERRUPTED["a destructor swallows it"]

FAULT_AFTER_INTERRUPT = """
import os, signal, sys
from comparisons.questions import study
from roughline import __main__
from roughline.commands import everyday

done = []

def stop(task):
    done.append(task)
    os.kill(os.getpid(), signal.SIGINT)

def fail(*arguments, **options):
    if done:
        raise FAULT

study.execute = stop
study.compile_apart = lambda task: 0.0
study.compile_ahead = lambda tasks: ()
PLACE = fail
sys.argv = "roughline run paraboloid --methods closed_form --out o --no-pictures".split()
__main__.main()
"""

INTERRUPTED_AND_BUSY = """
def busy(*arguments, **options):
    try:
        print("started", flush=True)
        time.sleep(600)
    finally:
        time.sleep(600)

cli.app = busy
"""
MAIN = "__main__.main()\n"


@pytest.mark.usefixtures("interruptible")
@pytest.mark.parametrize("becomes", INTERRUPTED)
def test_control_c_is_code_3_whatever_becomes_of_it(tmp_path, becomes):
    with started("-c", INTERRUPT + INTERRUPTED[becomes] + MAIN, cwd=tmp_path) as process:
        _, said = process.communicate(timeout=120)
    assert (process.returncode, said) == (3, "interrupted\n")


@pytest.mark.usefixtures("interruptible")
@pytest.mark.parametrize(
    ("place", "fault", "code", "end"),
    [
        ("study.store.save_study", "ValueError('a bug')", 1, "ValueError: a bug\n"),
        pytest.param(
            *("everyday._write_study", "OSError(28, 'disk full')"),
            *(2, "cannot read or write: [Errno 28] disk full\n"),
            marks=pytest.mark.slow,
        ),
    ],
)
def test_what_fails_after_a_control_c_is_told(tmp_path, place, fault, code, end):
    """An interrupt explains only what it was made into."""
    program = FAULT_AFTER_INTERRUPT.replace("PLACE", place).replace("FAULT", fault)
    with started("-c", program, cwd=tmp_path) as process:
        _, said = process.communicate(timeout=120)
    assert (process.returncode, said.endswith(end)) == (code, True), said
    assert ("Traceback" in said) == (code == 1)


@pytest.mark.usefixtures("interruptible")
def test_a_later_control_c_ends_a_program_that_is_long_in_ending(tmp_path):
    with started("-c", INTERRUPT + INTERRUPTED_AND_BUSY + MAIN, cwd=tmp_path) as process:
        assert process.stdout.readline() == "started\n"
        while process.poll() is None:
            process.send_signal(signal.SIGINT)
            time.sleep(0.1)
        said = process.stderr.read()
    assert (process.returncode, said) == (3, "interrupted again: ended at once\n")


@pytest.mark.slow
@pytest.mark.parametrize(
    "arguments", [["solve", "paraboloid", "--method", "closed_form", "--json"], ["list", "scenes"]]
)
def test_a_reader_that_goes_away_is_no_error(tmp_path, arguments):
    """As in roughline ... | head -1; tables of rich have a mind of their own about it."""
    with started(*PROGRAM, *arguments, cwd=tmp_path) as process:
        process.stdout.close()
        complaint = process.stderr.read()
        process.wait(timeout=120)
    assert complaint == ""
    assert process.returncode == 0


def test_deep_keys_are_refused_before_they_cost_memory(roughline, tmp_path):
    """The TOML parser is quadratic in the parts of a dotted key."""
    (tmp_path / "deep.toml").write_text("a" + ".a" * 50_000 + " = 1\n")
    result = roughline("solve", "deep.toml", "--method", "reduced")
    assert result.code == 2
    assert "keys of at most" in result.err


@pytest.mark.slow
def test_two_runs_of_one_scene_are_the_same_and_a_changed_model_is_not(roughline, ball):
    """A scaled force in results.csv stands for a model that was changed between the runs."""
    options = ["--methods", "closed_form,reduced", "--no-pictures"]
    for folder in ("a", "b"):
        assert roughline("run", ball, *options, "--out", folder).code == 0
    compare = ("compare", "a", "b", "--slower", "1e9")  # times are another matter
    same = roughline(*compare)
    assert same.code == 0
    assert "None of 3 solves in both runs changed an answer" in same.out
    page = Path("roughline-results/comparison-a-b/comparison.html")
    assert "None of 3 solves in both runs changed an answer" in page.read_text(encoding="utf-8")
    rows = pd.read_csv("b/results.csv")
    rows.loc[rows["method"] == "reduced", "force"] *= 1.002
    rows.to_csv("b/results.csv", index=False)
    kept = roughline("compare", "a", "missing", "--out", page.parent)  # before anything is read
    assert kept.code == 2
    assert f"{page} exists already: use --overwrite" in kept.err
    assert "force moved by" not in page.read_text(encoding="utf-8")
    moved = roughline(*compare, "--overwrite", "--static")
    assert moved.code == 1
    mailed = page.with_name("comparison-static.html").read_text(encoding="utf-8")
    assert "force moved by" in mailed
    assert "<script" not in mailed
    assert "force moved by +0.20" in moved.out
    assert "force moved by" in page.read_text(encoding="utf-8")
    assert '"reduced model, changed"' in page.read_text(encoding="utf-8")  # no worse than before
    assert roughline(*compare, "--tolerance", "1%", "--out", "c").code == 0
    loads = ("--loads", "force=7 N")
    assert roughline("run", ball, *options, *loads, "--out", "d").code == 0
    apart = roughline("compare", "a", "d")
    assert (apart.code, "Nothing in both runs" in apart.out) == (1, True)


def test_a_claim_is_tested_again_without_a_word_and_spares_the_folder_of_all(roughline, tmp_path):
    """In the default folder answers of this version are used again, under hashes of everything."""
    (tmp_path / "roughline-results/claims").mkdir(parents=True)
    (tmp_path / "roughline-results/claims/claims.json").write_text("all of them")
    arguments = ("claims", "friction-law-force", "--workers", "1")
    first = roughline(*arguments)
    again = roughline(*arguments)
    assert (first.code, again.code) == (0, 0)
    record = tmp_path / "roughline-results/claims-friction-law-force/claims.json"
    assert len(json.loads(record.read_text())["claims"]) == 1
    assert (tmp_path / "roughline-results/claims/claims.json").read_text() == "all of them"
    assert roughline(*arguments, "--out", str(record.parent)).code == 2
