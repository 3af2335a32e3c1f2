"""The Python interface: its names, what they return, and what a notebook shows of it."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest

import roughline
from comparisons.questions.single import solve_scene
from roughline.commands.app import run_command

BALL = {
    "name": "ball",
    "half_space": {"youngs_modulus": "210 GPa", "poisson_ratio": 0.3},
    "indenter": {"shape": "paraboloid", "radius": "10 mm"},
    "loading": {"penetration": ["1 um", "2 um", "4 um"]},
    "compare": {"quantities": ["force", "contact_area"]},
}
HOSTILE = '<script>alert(1)</script> & "quotes"'


@pytest.fixture(scope="module")
def found():
    scene = roughline.load_scene(BALL, {"title": HOSTILE})
    return roughline.compare(scene, "closed_form", "reduced", resolutions=[10, 20])


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("study") / "run"
    methods = ["closed_form", "reduced"]
    return roughline.Study([BALL, "cone"], folder, methods=methods).run()


def test_importing_the_package_imports_nothing_heavy(python):
    """Under 0.3 s is asked for; what is certain on any machine is what has not been imported."""
    code = "import roughline, sys; print(sorted(sys.modules))"
    loaded = python("-c", code).stdout
    assert "'roughline'" in loaded
    for heavy in ("numpy", "pandas", "pydantic", "numba", "matplotlib", "comparisons", "reports"):
        assert f"'{heavy}'" not in loaded, heavy


def test_every_name_that_is_promised_is_there_and_documented():
    for name in roughline.__all__:
        assert getattr(roughline, name).__doc__, name
    assert set(roughline.__all__) <= set(dir(roughline))
    with pytest.raises(AttributeError, match="no attribute 'sovle'"):
        roughline.sovle  # noqa: B018


def test_a_scene_is_the_same_from_tables_text_file_and_scene(tmp_path):
    scene = roughline.load_scene(BALL)
    (tmp_path / "ball.toml").write_text(scene.text, encoding="utf-8")
    again = [scene.text, tmp_path / "ball.toml", str(tmp_path / "ball.toml"), scene]
    assert {roughline.load_scene(part).text for part in again} == {scene.text}


def test_arrays_are_loads_and_changes_leave_what_they_are_made_from_alone():
    depths = np.geomspace(1e-6, 1e-5, 5)
    scene = roughline.load_scene(BALL | {"loading": {"penetration": depths}})
    np.testing.assert_allclose(scene.loading.penetration.values, depths, rtol=1e-15)
    changed = roughline.load_scene(scene, {"indenter.radius": "5 mm"})
    assert (scene.indenter.radius, changed.indenter.radius) == (0.01, 0.005)
    roughline.load_scene(BALL, {"indenter.radius": "5 mm"})
    assert BALL["indenter"]["radius"] == "10 mm"


@pytest.mark.parametrize(
    "source",
    ["no-such-scene", "name = 1\n[indenter]\n", {"name": "A", "foo": 1}],
    ids=["name", "text", "tables"],
)
def test_what_is_wrong_with_a_scene_is_told_as_on_the_command_line(source, tmp_path, capsys):
    with pytest.raises(roughline.InputError) as told:
        roughline.load_scene(source)
    if source == "no-such-scene":
        argument = source
    else:
        argument = str(tmp_path / "scene.toml")
        text = source if isinstance(source, str) else 'name = "A"\nfoo = 1\n'
        Path(argument).write_text(text, encoding="utf-8")
    assert run_command(["solve", argument, "--method", "reduced"]) == 2
    printed = capsys.readouterr().err.strip().splitlines()
    assert str(told.value).splitlines()[1:] == printed[1:]


@pytest.mark.parametrize(
    ("ask", "told"),
    [
        (lambda _: roughline.compare(BALL, tolerance=2.0), r"compare\.tolerance"),
        (lambda _: roughline.compare(BALL, quantities=["weight"]), r"compare\.quantities\.0"),
        (lambda _: roughline.solve("cone", "reduced", rule="guess"), r"methods\.reduced\.rule"),
        (lambda _: roughline.solve("cone", "no_such_method"), "expected one of closed_form"),
        (lambda _: roughline.solve(None, "reduced"), "expected a name, .* got None"),
        (lambda _: roughline.solve(["sphere"], "reduced"), "expected a name, .* got a list of 1"),
        (lambda _: roughline.load_scene("cone", ["a"]), "changes:\n.*a dict .* got a list of 1"),
        (lambda _: roughline.Study("cone", "nowhere", changes="a"), "changes:\n.* got a str"),
        (lambda _: roughline.Study("cone", "x", changes={"unit": 1}), "changes:\n  unit: unknown"),
        (lambda _: roughline.Study([], "nowhere"), "expected at least one scene"),
        (lambda used: roughline.Study(BALL, used).run(), "has results already"),
        (lambda used: roughline.Study(BALL, used, workers=0), "--workers: expected 1 to"),
        (lambda used: roughline.Study([BALL, BALL], used), "two scenes have this one"),
        (lambda used: roughline.compare_runs(used, used, tolerance=0), "a number above 0, got 0"),
        (lambda _: roughline.add_method("nowhere.py"), "no such file"),
    ],
)
def test_what_is_wrong_with_a_question_is_told(ask, told, results):
    with pytest.raises(roughline.InputError, match=told):
        ask(results.folder)


def test_solve_is_the_solve_of_the_command_line(capsys):
    """The very same numbers."""
    solution = roughline.solve("paraboloid", "closed_form")
    assert run_command(["solve", "paraboloid", "--method", "closed_form", "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert solution["force"].tolist() == printed["force"]
    assert solution.table()["force"].tolist() == printed["force"]
    with pytest.raises(KeyError, match="expected one of penetration, force"):
        solution["fource"]


def test_options_of_a_method_are_keywords():
    """(19.17) with half the radius is wrong for a cone by a factor pi/4 in force."""
    right, printed = (
        roughline.solve("cone", "reduced", 20, rule=rule)["force"]
        for rule in ("mdr", "half_radius")
    )
    np.testing.assert_allclose(printed / right, np.pi / 4, rtol=1e-9)


def test_pressure_and_files_of_a_solve(tmp_path):
    solution = roughline.solve(BALL, "closed_form", fields=True)
    assert set(solution.pressure) == {"r", "p"}
    with pytest.raises(roughline.InputError, match="pressure: solve with fields=True"):
        _ = roughline.solve(BALL, "closed_form").pressure
    roughline.solve(BALL, "fem", 4, fields=True).to_vtu(tmp_path / "body.vtu")
    assert "von_mises" in (tmp_path / "body.vtu").read_text(encoding="utf-8", errors="replace")


def test_an_answer_is_named_arrays_with_units():
    """Pressures on the cells of a patch carry the force (stored in single precision)."""
    xarray = pytest.importorskip("xarray")
    solution = roughline.solve("rough-patch", "bem_fft", 16, fields=True)
    arrays = solution.to_xarray()
    assert arrays.force.attrs == {"long_name": "force", "units": "N"}
    np.testing.assert_array_equal(arrays.contact_area, solution["contact_area"])
    cell = float(arrays.x[1] - arrays.x[0]) * float(arrays.y[1] - arrays.y[0])
    carried = cell * arrays.pressure.sum(("x", "y"))
    np.testing.assert_allclose(carried, arrays.force, rtol=1e-6)
    assert xarray.Dataset.from_dict(arrays.to_dict()).identical(arrays)
    round_one = roughline.solve(BALL, "closed_form", fields=True).to_xarray()
    highest = 1.5 * round_one.force / round_one.contact_area  # Hertz
    np.testing.assert_allclose(round_one.pressure.max("point"), highest, rtol=1e-3)
    assert "pressure" not in roughline.solve(BALL, "closed_form").to_xarray()


def test_without_xarray_the_way_to_get_it_is_told(monkeypatch):
    monkeypatch.setitem(sys.modules, "xarray", None)
    with pytest.raises(roughline.InputError, match=r"pip install 'roughline\[xarray\]'"):
        roughline.solve(BALL, "closed_form").to_xarray()


@pytest.mark.slow
def test_pressures_are_those_of_the_whole_contact_at_every_load():
    """Elements solve a quarter: 4 points for each but those on the planes of symmetry."""
    solution = roughline.solve("ellipsoid-2", "fem", 4, fields=True)
    assert list(solution.pressures) == list(range(len(solution["force"])))
    for field, radius in zip(
        solution.pressures.values(), np.sqrt(solution["contact_area"] / np.pi), strict=True
    ):
        pressed = field["p"] > 0
        x, y = field["x"][pressed], field["y"][pressed]
        assert len(set(zip(x, y, strict=True))) == len(x)
        np.testing.assert_allclose([x.min(), y.min()], [-x.max(), -y.max()], rtol=1e-9)
        # sides of an ellipse of that area, longer along x
        assert x.max() > radius > y.max()
        assert x.max() * y.max() == pytest.approx(radius**2, rel=0.3)
    solution.plot("pressure")


@pytest.mark.slow
def test_pressures_are_plotted_from_the_folder_of_a_study(results):
    """In Hertz' contact all methods have 1.5 times the mean pressure in the middle."""
    pytest.importorskip("matplotlib")
    (name, *_) = results.names
    (axes,) = results[name].plot("pressure").axes
    for line in axes.lines:
        assert max(line.get_ydata()) == pytest.approx(1.5, rel=1e-3)
    with pytest.raises(roughline.InputError, match="kept in the folder of a Study"):
        roughline.compare(BALL).plot("pressure")


@pytest.mark.parametrize(
    ("scene", "method"),
    [("paraboloid", "closed_form"), ("paraboloid", "bem_fft"), ("paraboloid", "fem")],
)
def test_the_pressure_along_a_line_is_hertz_and_symmetric(scene, method):
    """p0 sqrt(1 - (x/a)^2): to 2 % of p0 inside 0.9 a, whose rim cells of the grid cut."""
    solution = roughline.solve(scene, method, fields=True)
    line = solution.pressure_along("y")
    y, p = line.to_numpy().T
    assert (np.diff(y) > 0).all()
    np.testing.assert_allclose(y + y[::-1], 0.0, atol=1e-9 * np.ptp(y))
    force, a = solution["force"][-1], np.sqrt(solution["contact_area"][-1] / np.pi)
    peak, inside = 1.5 * force / (np.pi * a**2), np.abs(y) < 0.9 * a
    exact = peak * np.sqrt(1 - (y[inside] / a) ** 2)
    np.testing.assert_allclose(p[inside], exact, atol=0.02 * peak)
    with pytest.raises(roughline.InputError, match="axis: expected 'x' or 'y', got 'z'"):
        solution.pressure_along("z")


@pytest.mark.parametrize("scene", ["cylinder", "square-punch", "elliptic-punch"])
def test_the_pressure_along_a_flat_punch_ends_at_its_edge(scene):
    """Cells on the rim reach beyond the face, where nothing presses."""
    solution = roughline.solve(scene, "bem_fft", 10, fields=True)
    x, p = solution.pressure_along("x").to_numpy().T
    (half, _) = solution.scene.indenter.reach(0.0)
    assert np.abs(x).max() <= half
    assert (p > 0).all()


def test_the_line_of_a_rough_patch_goes_through_its_middle():
    """Cells next to the middle of a patch: two of its rows, whose mean it is."""
    solution = roughline.solve("rough-patch", "bem_fft", 16, fields=True)
    p = solution.pressure["p"].reshape(16, 16)
    line = solution.pressure_along("x")["p / Pa"].to_numpy()
    np.testing.assert_allclose(line, p[:, 7:9].mean(axis=1), rtol=1e-12)


def test_a_comparison_says_which_method_is_good_enough_and_what_it_costs(found):
    """The reduced model is exact for a paraboloid (Popov & Hess 2015)."""
    assert found.verdict == "within"
    assert found.cheapest.method == "reduced"
    assert found.judged().error < 1e-9
    assert found.answer.startswith("For 1")
    assert found.lost == []
    table = found.table()
    assert set(table["method"]) == {"reduced"}
    assert set(table["resolution"]) == {10, 20}
    assert len(found.steps()) == 3 * 3  # the closed form once, the model twice, three loads


def test_a_plan_tells_what_is_left_out():
    planned = roughline.plan(BALL, "reduced", "fem")
    methods = set(planned.table().query("supported")["method"])
    assert methods == {"closed_form", "reduced", "fem"}
    assert "comparison of pressures" in planned.left_out


def test_whoever_has_a_plan_shows_what_it_questions():
    soft = roughline.load_scene(BALL, {"half_space.youngs_modulus": 210})
    shown = (
        roughline.plan(soft, "reduced"),
        roughline.solve(soft, "reduced"),
        roughline.compare(soft, "reduced", quantities=["force"]),
    )
    for one in shown:
        assert any(note.startswith("check the units") for note in one.notes)
        assert "check the units of the scene: E* = 231" in repr(one)


def test_a_study_is_a_folder_that_is_read_back(results):
    again = roughline.load_results(results.folder)
    assert again.names == ["ball", "cone"]
    assert [part.verdict for part in again] == ["within", "within"]
    assert again["cone"].verdict == "within"
    assert set(again.table()["scene"]) == {"ball", "cone"}
    assert again.lost == {}
    with pytest.raises(KeyError, match="expected one of ball, cone"):
        again["sphere"]


def test_a_study_writes_its_report(results):
    page = results.report(pictures=False)
    assert page.read_text(encoding="utf-8").startswith("<!DOCTYPE html>")


def test_a_run_with_a_changed_model_has_moved(results, tmp_path):
    """The printed rule R1 = R/2 lowers the cone's force by 1 - pi/4 = 21.5 %."""
    changed = roughline.Study(
        [BALL, "cone"],
        tmp_path / "changed",
        methods=["closed_form", "reduced"],
        changes={"methods.reduced.rule": "half_radius"},
    ).run()
    assert roughline.compare_runs(results, results.folder).failed == ()
    moved = roughline.compare_runs(results, changed, slower=1e9)
    table = moved.table().set_index(["scene", "method"])
    assert {(c.scene, c.method) for c in moved.failed} == {("cone", "reduced")}
    force = table[table["quantity"] == "force"]["change"]
    np.testing.assert_allclose(force, np.pi / 4 - 1, rtol=1e-6)
    told = "cone: the scene differs (plain numbers are SI): methods.reduced.rule: "
    assert told + "not given → 'half_radius'" in moved.notes


def test_a_claim_of_your_own_is_a_dict():
    """A cone with half the radius of curvature everywhere, g = 2 f, errs by pi/4 - 1."""
    claim = {
        "id": "my-cone",
        "text": "Half the radius will do for a cone, too.",
        "equation": "mine",
        "scene": "cone",
        "changes": {"methods.reduced.rule": "half_radius"},
        "quantity": "force",
        "measure": "maximum",
        "tolerance": 0.05,
        "refuted_by": "an error beyond 5 %",
    }
    judged = roughline.check_claim(claim)
    assert judged.verdict == "fails"
    np.testing.assert_allclose(judged.table()["error"], np.pi / 4 - 1, rtol=1e-6)
    assert judged.as_expected
    with pytest.raises(roughline.InputError, match="tolerance: expected, but missing"):
        roughline.check_claim({k: v for k, v in claim.items() if k != "tolerance"})


def twice(name, factor):
    @roughline.method(name, title="Hertz, scaled", resolutions=(1,))
    def step(task, load, realisation):
        """Hertz' force, times a factor."""
        exact = solve_scene(task.scene, "closed_form").columns()["force"]
        depths = task.loads.values
        return {"force": factor * exact[np.argmin(np.abs(depths - load))]}

    return step


@pytest.mark.usefixtures("methods_restored")
def test_a_method_of_a_notebook_is_judged_and_can_be_mended():
    """Cells are run again: the second definition replaces the first. It is never the truth."""
    for factor, word in ((2.0, "outside"), (1.001, "within")):
        assert roughline.add_method(twice("scaled", factor)) == ["scaled"]
        found = roughline.compare(BALL, "closed_form", "scaled", quantities=["force"])
        assert found.judged("scaled").word == word
        np.testing.assert_allclose(found.judged("scaled").error, factor - 1, rtol=1e-9)
    alone = roughline.compare(BALL, "scaled")
    assert alone.reference.startswith("The reference is the closed form")
    with pytest.raises(roughline.InputError, match="a method of roughline's own"):
        roughline.add_method(twice("reduced", 1.0))


@pytest.mark.usefixtures("methods_restored")
def test_an_added_method_runs_where_a_scene_names_others_not_beside_those_of_a_call(tmp_path):
    roughline.add_method(twice("scaled", 2.0))
    named = roughline.load_scene(BALL, {"compare.methods": ["closed_form", "reduced"]})

    def planned(plan):
        return plan.table().query("supported").method.tolist()

    assert planned(roughline.plan(named)) == ["closed_form", "reduced", "scaled"]
    assert planned(roughline.Study(named, tmp_path).plan) == ["closed_form", "reduced", "scaled"]
    assert planned(roughline.plan(named, "reduced")) == ["closed_form", "reduced"]
    study = roughline.Study(named, tmp_path, methods=["reduced"])
    assert planned(study.plan) == ["closed_form", "reduced"]


def test_a_notebook_shows_verdicts_in_words_and_colours_and_nothing_hostile(found):
    shown = found._repr_html_()
    assert "<script>" not in shown
    assert "&lt;script&gt;alert(1)&lt;/script&gt; &amp;" in shown
    assert "within</span>" in shown
    assert "color:#00624a" in shown
    assert "round-off" in shown  # the error, as it reads best
    assert len(shown) < 6000


def test_everything_has_a_short_form_for_notebooks_and_terminals(found, results):
    claim = roughline.check_claim("friction-law-force")
    told = [
        (roughline.solve(BALL, "reduced", 10), "force F / "),
        (roughline.plan(BALL), "Left out: "),
        (results, "ball"),
        (roughline.compare_runs(results, results), "in both runs changed an answer or a verdict"),
        (claim, "holds</span>"),
    ]
    for part, text in told:
        assert text in part._repr_html_()
        assert len(part._repr_html_()) < 20_000
        assert repr(part)
    assert "holds" in repr(claim)
    assert "reduced model within" in repr(found)
