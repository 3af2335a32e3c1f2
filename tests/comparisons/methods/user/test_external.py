"""Methods from outside: judged like ours, trusted with nothing, costing only their own rows."""

import json
import os
from dataclasses import replace
from importlib import metadata
from pathlib import Path

import numpy as np
import pytest

import roughline
from comparisons.errors import InputError
from comparisons.facts.methods import GROUP, METHODS
from comparisons.isolation import parent
from comparisons.isolation.parent import Limits
from comparisons.judging.truth import truths
from comparisons.judging.verdicts import worst
from comparisons.methods import method, registry
from comparisons.methods.user import external
from comparisons.methods.user.external import (
    Origin,
    add_announced,
    add_methods,
    register,
    user_method,
    user_methods,
)
from comparisons.questions.claims.claim import about_method, load_claims
from comparisons.questions.claims.runner import _repeats
from comparisons.questions.hard_cases.case import catalogue
from comparisons.questions.hard_cases.run import outcomes
from comparisons.questions.single import solve_scene
from comparisons.questions.study import Study, solved_in_memory
from comparisons.results.record import StudyRecord
from comparisons.results.recording import record_scene
from comparisons.results.store import load_study
from comparisons.scene.scene import load_scene
from comparisons.solving import external_work
from comparisons.solving.execution import execute
from comparisons.solving.inquiries import answer_of
from comparisons.solving.jobs import executor_for
from comparisons.solving.plan import task_of
from comparisons.solving.planning import plan_scene
from comparisons.tasks.solution import Solution, arrays_of
from reports.pages.study import page
from reports.tables.judged import summary_lines, verdict_table
from roughline.commands.app import run_command
from roughline.commands.terminal import print_study

EXAMPLE = Path(__file__).resolve().parents[4] / "docs" / "examples" / "winkler.py"

# Each of these does one bad thing on every scene; `fine` is exact for the paraboloid.
BAD = '''
import os, time
import numpy as np
from comparisons.methods import method

def hertz(task, load, realisation):
    """Hertz."""
    radius = task.geometry.indenter.radius
    return {"force": 4 / 3 * task.scene.effective_modulus * radius**0.5 * load**1.5}

fine = method("fine", resolutions=(1,))(hertz)

@method("nan", resolutions=(1,))
def nan(task, load, realisation):
    """NaN at the second load."""
    force = hertz(task, load, realisation)["force"]
    return {"force": force if load != task.loads.values[1] else np.nan}

@method("raises", resolutions=(1,))
def raises(task, load, realisation):
    """An error that no method should raise."""
    raise KeyError("lost my keys")

@method("hangs", resolutions=(1,))
def hangs(task, load, realisation):
    """Never comes back."""
    time.sleep(1000)

@method("greedy", resolutions=(1,))
def greedy(task, load, realisation):
    """A hundred times the memory: a gigabyte for a few numbers."""
    kept = [np.ones(10**6) for _ in range(125)]
    return {"force": float(kept[0][0])}

@method("dies", resolutions=(1,))
def dies(task, load, realisation):
    """Takes the interpreter with it."""
    os._exit(7)
'''


pytestmark = pytest.mark.usefixtures("methods_restored")


@pytest.fixture
def bad(tmp_path):
    path = tmp_path / "bad.py"
    path.write_text(BAD)
    return path


def test_a_force_by_depth_under_force_control_is_told():
    """It takes the force for a depth: what it returns is not the force that was prescribed."""

    @method("by_depth", resolutions=(1,))
    def by_depth(task, load, realisation):
        return {"force": task.scene.effective_modulus * load}

    roughline.add_method(by_depth)
    scene = roughline.load_scene("paraboloid", {"loading": {"force": ["1 N", "2 N"]}})
    (reason, *_) = roughline.solve(scene, "by_depth").reasons
    assert "is prescribed: the load given is the force; return what follows from it" in reason


@pytest.mark.slow
def test_the_example_is_judged_by_a_hard_case():
    """Springs of E*/a per area under a paraboloid: F = pi E* R d^2/a, at d = 1 um 3/4 pi Hertz.

    a is the radius at the only load, so F/F_Hertz = (pi R d^2 / sqrt(R d)) / (4/3 sqrt(R) d^1.5)
    = 3 pi/4: an error of 135.6 %; the overlap has twice the contact area.
    """
    assert add_methods([EXAMPLE]) == []
    assert METHODS["winkler"].title == "Winkler foundation"
    (outcome,) = answer_of(outcomes(catalogue()["load-one"], ["winkler"], full=True))
    assert outcome.kind == "degraded"
    assert outcome.error == pytest.approx(3 * np.pi / 4 - 1, rel=1e-3)
    assert outcome.area_error == pytest.approx(1.0, rel=0.01)
    assert (outcome.expected, outcome.deviation) == ("", "")
    (refused,) = answer_of(outcomes(catalogue()["rough-steep"], ["winkler"], full=True))
    assert (refused.kind, refused.reason) == (
        "not for",
        "indenters under prescribed penetration only",
    )


@pytest.mark.slow
def test_a_file_with_a_method_for_rough_surfaces_is_solved(tmp_path):
    """The bearing area at a depth below the highest point, by the surface's own heights."""
    path = tmp_path / "bearing.py"
    path.write_text(
        "from comparisons.methods import method\n"
        "@method('bearing', resolutions=(16,))\n"
        "def bearing(task, load, realisation):\n"
        "    heights = task.geometry.heights(realisation, task.resolution)\n"
        "    share = (heights > heights.max() - load).mean()\n"
        "    return {'penetration': load, 'contact_area': share * task.geometry.area}\n"
    )
    assert roughline.add_method(path) == ["bearing"]
    changes = {"surface.points": 16, "loading": {"penetration": "1 nm"}}
    scene = roughline.load_scene("rough-free", changes)
    solution = roughline.solve(scene, "bearing")
    assert solution.converged
    assert 0 < solution["contact_area"][0] < 0.5e-12  # of 1 µm², above the mean plane


@pytest.mark.slow
def test_misbehaving_methods_cost_only_their_own_rows(bad, tmp_path, capsys):
    """In a study: the reduced model's rows are what they are without them."""
    limits = ["--method-seconds", "15", "--method-gigabytes", "0.6"]
    names = ["fine", "nan", "raises", "hangs", "greedy", "dies"]
    arguments = ["run", "paraboloid", "--no-pictures", "--out", str(tmp_path / "out")]
    arguments += ["--methods", ",".join(["closed_form", "reduced", *names])]
    assert run_command([*arguments, "--method-file", str(bad), *limits]) == 1
    assert "lost" in capsys.readouterr().out
    rows = load_study(tmp_path / "out").scenes[0].rows.frame()
    planned = rows["reason"] != "not asked for"
    lost = rows[~rows["converged"] & planned].groupby("method")
    steps = rows[rows["method"] == "fine"]["step"].nunique()
    assert lost.size().to_dict() == {n: 1 if n == "nan" else steps for n in names[1:]}
    reasons = lost["reason"].first()
    assert reasons["nan"] == "force came out as nan"
    assert "lost my keys" in reasons["raises"]
    assert reasons["hangs"].startswith("hung: no answer within 15 s")
    assert reasons["greedy"].startswith("out of memory")
    assert "exit code 7" in reasons["dies"]
    ours = rows[rows["method"].isin(["reduced", "fine"])]
    assert ours["converged"].all()
    assert ours["error_force"].abs().max() < 1e-12
    assert "lost my keys" in (tmp_path / "out" / "report.html").read_text()


@pytest.mark.slow
def test_workers_know_the_methods_of_the_command_line(tmp_path):
    """Also those that an earlier study of this process started, before it had the method."""

    def solved(name):
        plans = plan_scene(load_scene("paraboloid", {"compare.methods": ["closed_form", name]}))
        return Study(plans, tmp_path / name, executor=executor_for(2)).run().scenes[0].rows

    solved("reduced")
    assert add_methods([EXAMPLE]) == []
    rows = solved("winkler")
    assert rows["converged"][rows["method"] == "winkler"].all()


def test_a_method_that_always_hangs_is_asked_a_few_times_only(monkeypatch):
    calls = []

    def hang(work, *arguments, **limits):
        calls.append(work)
        return parent.Outcome("hung", reason="no answer within 1 s")

    monkeypatch.setattr(parent, "run", hang)
    method = user_method(Origin("file:x", "slow", "slow", 3, "", 1.0, 1e9))
    scenes = [
        load_scene(name) for name in ("paraboloid", "cone", "sphere", "cylinder", "ellipsoid-2")
    ]
    reasons = [method.plan(scene)["reason"] for scene in scenes]
    assert len(calls) == external.MOST_STUCK
    assert "hung: no answer within 1 s" in reasons[0]
    assert "not asked again" in reasons[-1]


@pytest.fixture
def task():
    register(Origin("file:x", "other", "other", 3, "", 1.0, 1e9))
    plan = plan_scene(load_scene("paraboloid", {"compare.methods": ["reduced"]}))[0]
    return task_of(plan, "other", 10)


@pytest.fixture
def answered(monkeypatch, task):
    """Return a solver of the task by a process that answers what a test says."""

    def solve(change) -> Solution:
        solution = Solution.empty(task)
        for step in range(len(task.loads.values)):
            solution.put((0, step), {"force": 1.0 + step})
        arrays = arrays_of(solution)
        change(arrays)
        answer = parent.Outcome("answered", answer=arrays)
        monkeypatch.setattr(parent, "run", lambda *a, **k: answer)
        return execute(task)

    return solve


STEPS = 7


@pytest.mark.parametrize(
    ("name", "value", "reason"),
    [
        ("solution.q.force", np.ones(3), "force: expected 7 numbers, got an array of shape (3,)"),
        (
            "solution.q.force",
            np.full((1, STEPS), "x"),
            "force: expected 7 numbers, got an array of shape (1, 7) of <U1",
        ),
        ("solution.q.<b>", np.ones((1, STEPS)), "unknown quantity '<b>'"),
        ("solution.converged", np.ones((1, STEPS)), "converged: expected an array of shape (1, 7)"),
        (
            "solution.iterations",
            np.ones((2, 2), dtype=int),
            "iterations: expected an array of shape (1, 7), got an array of shape (2, 2)",
        ),
        ("solution.violation", None, "malformed answer"),
        ("solution.json", np.array("{"), "malformed answer"),
        ("solution.json", np.array('{"unknowns": "many"}'), "malformed answer"),
    ],
)
def test_a_malformed_answer_is_the_reason_of_lost_steps(answered, name, value, reason):
    def change(arrays):
        arrays.pop(name) if value is None else arrays.update({name: value})

    solution = answered(change)
    assert not solution.converged.any()
    assert all(reason in why for why in solution.reasons.values())


ODD = """
import numpy as np
from comparisons.methods.solver import method

def returning(name, value):
    def step(task, load, realisation):
        return value
    step.__module__ = __name__
    return method(name, resolutions=(1,))(step)

array = returning("array", {"force": np.ones((3, 4))})
nothing = returning("nothing", None)
listed = returning("listed", [1.0, 2.0])
complex_ = returning("complex_", {"force": 1j})
empty = returning("empty", {})
"""


@pytest.mark.slow
def test_a_function_that_returns_no_numbers_is_told_what_was_expected(monkeypatch, tmp_path):
    monkeypatch.setattr(registry, "SOLVERS", dict(registry.SOLVERS))
    file = tmp_path / "odd.py"
    file.write_text(ODD)
    add_methods([file])
    reasons = {
        name: solve_scene("paraboloid", name).reasons
        for name in ("array", "nothing", "listed", "complex_", "empty")
    }
    assert reasons == {
        name: [f"{name} at resolution 1: {reason}"]
        for name, reason in {
            "array": "force: expected a number, got an array of shape (3, 4)",
            "nothing": "expected numbers by quantity, got None",
            "listed": "expected numbers by quantity, got a list of 2",
            "complex_": "force: expected a number, got a complex",
            "empty": "expected numbers by quantity, got an empty dict",
        }.items()
    }


def test_fields_of_other_names_or_sizes_are_dropped(answered):
    """Only a whole pressure field is shown; a name could be that of a file, or of a heights map."""
    fields = {name: np.ones(4) for name in external.FIELDS}
    good = answered(lambda arrays: arrays.update(fields | {"heights": np.ones((2, 2))}))
    assert good.converged.all()
    assert good.quantities["force"][0, 0] == 1.0
    assert set(good.fields) == set(external.FIELDS)
    torn = answered(lambda arrays: arrays.update(fields | {"pressure": np.ones(3)}))
    assert torn.fields == {}


def test_reasons_are_short_printable_and_about_steps_that_exist(answered):
    def chatter(arrays):
        document = json.loads(str(arrays["solution.json"]))
        long = "\x1b[31m\nno" + "x" * 10_000
        document["reasons"] = [[0, 0, long], [5, 5, "elsewhere"]]
        arrays["solution.json"] = np.array(json.dumps(document))
        arrays["solution.converged"][0, 0] = False

    reasons = answered(chatter).reasons
    assert set(reasons) == {(0, 0)}
    assert len(reasons[0, 0]) <= external.LONGEST_TEXT
    assert reasons[0, 0].isprintable()


@pytest.mark.parametrize(
    "levels", [[], [0], [2.5], ["4"], "444", [True], list(range(1, 100)), [2**40]]
)
def test_resolutions_are_a_few_whole_numbers(monkeypatch, levels):
    answer = parent.Outcome("answered", answer={"ok": True, "resolutions": levels})
    monkeypatch.setattr(parent, "run", lambda *a, **k: answer)
    method = user_method(Origin("file:x", "odd", "odd", 3, "", 1.0, 1e9))
    plan = method.plan(load_scene("paraboloid"))
    assert not plan["ok"]
    assert "resolutions" in plan["reason"]


def test_a_method_from_outside_is_never_the_truth(task):
    """Nor does it disagree as a reference: it is judged."""
    solution = Solution.empty(task)
    solution.put((0, 0), {"force": 1.0})
    assert truths({("other", 10): solution}, "penetration") == []


def test_claims_are_judged_about_a_method_from_outside(task):
    """Those on scenes; what the chapter's model is expected to do is not expected of it."""
    result = about_method(load_claims(), "other")
    assert result
    told = {(claim.method, claim.expected, claim.experiment, claim.theorem) for claim in result}
    assert told == {("other", None, None, "")}
    assert _repeats(result[0], "quick").endswith("--quick --method other --method-file x")
    with pytest.raises(InputError, match="--method: expected one of"):
        about_method(load_claims(), "nobody")


@pytest.mark.slow
def test_a_method_from_outside_is_given_only_scenes_whose_physics_it_knows(
    tmp_path, scene, planned, solved
):
    """One step at a time: a spring of 2 G* a (19.18), along a path that passes zero."""
    file = tmp_path / "sticks.py"
    file.write_text(
        "from comparisons.methods import method\n"
        "@method('sticks', resolutions=(1,), physics={'friction'})\n"
        "def sticks(task, load, realisation):\n"
        "    'Nothing slips.'\n"
        "    stiffness = 2 * task.scene.tangential_modulus * task.geometry.contact_radius\n"
        "    return {'tangential_displacement': load / stiffness}\n"
    )
    assert add_methods([file]) == []
    loading = {"force": "10 N", "tangential_force": ["1 N", 0, "-1 N"]}
    pulled = scene(loading=loading, friction={"coefficient": 0.5})
    solution = solved(pulled, "sticks")
    assert solution.path
    moved = solution.quantities["tangential_displacement"][0]
    assert moved[1] == 0
    assert moved[2] == -moved[0] < 0
    refused = planned(scene(adhesion={"work": 0.05}))["sticks"]
    assert (refused.supported, refused.reason) == (False, "does not model [adhesion]")


@pytest.fixture
def described(monkeypatch, tmp_path):
    def describe(file="m.py", text="", **result):
        usual = {"name": "other", "title": "Other", "dimension": 3}
        done = parent.Outcome("answered", answer={"methods": json.dumps([usual | result])})
        monkeypatch.setattr(parent, "run", lambda *a, **k: done)
        (tmp_path / file).write_text(text)
        return tmp_path / file

    return describe


@pytest.mark.parametrize(
    ("document", "reason"),
    [
        ({"name": "../../etc"}, "expected a-z, 0-9 and _"),
        ({"name": "<script>"}, "expected a-z, 0-9 and _"),
        ({"name": "x" * 50}, "expected a-z, 0-9 and _"),
        ({"name": 3}, "expected a-z, 0-9 and _"),
        ({"name": "reduced"}, "'reduced' is a method of roughline's own"),
        ({"dimension": 2}, "dimension: expected 1 or 3, got 2"),
        ({"physics": ["magic"]}, "physics: expected tables among"),
        ({"physics": {"friction": 1}}, "physics: expected tables among"),
    ],
)
def test_a_method_may_not_call_itself_anything(described, document, reason):
    before = dict(METHODS)
    with pytest.raises(InputError, match="--method-file") as caught:
        add_methods([described(**document)])
    assert reason in str(caught.value)
    assert before == METHODS


def test_titles_are_short_and_printable(described):
    add_methods([described(title="\x1b[2J" + "<b>" * 100)])
    assert METHODS["other"].title.isprintable()
    assert len(METHODS["other"].title) == 60


def test_two_files_may_not_bring_the_same_name(described):
    with pytest.raises(InputError, match="another method is called 'other' already"):
        add_methods([described("a.py"), described("b.py")])


def test_files_that_do_not_exist_are_all_listed(tmp_path):
    with pytest.raises(InputError) as caught:
        add_methods([tmp_path / "a.py", tmp_path / "b.py"])
    assert str(caught.value).count("no such file") == 2


def test_workers_are_told_in_their_environment(described):
    file = described()
    add_methods([file], Limits(5, 1e9))
    del METHODS["other"], registry.SOLVERS["other"]
    add_announced()
    (made,) = user_methods()
    assert (made.name, made.origin.seconds, made.origin.memory) == ("other", 5, 1e9)
    assert "other" in METHODS
    assert str(file) in os.environ[external.VARIABLE]


def test_a_changed_file_is_another_method(described):
    """--resume must not take the results of an older version."""
    keys = []
    for text in ("first", "second"):
        add_methods([described(text=text)])
        plan = plan_scene(load_scene("paraboloid", {"compare.methods": ["reduced"]}))[0]
        keys.append(task_of(plan, "other", 10).key)
    assert keys[0] != keys[1]


def test_installed_packages_bring_methods_and_a_broken_one_is_left_out(monkeypatch):
    """The group `roughline.methods`; a package that fails must not stop other commands."""
    points = metadata.EntryPoints(
        metadata.EntryPoint(name, f"{name}:Method", GROUP) for name in ("good", "torn")
    )
    monkeypatch.setattr(metadata, "entry_points", lambda **which: points.select(**which))

    def describe(work, source, **limits):
        if source == "entry:torn":
            return parent.Outcome("raised", reason="ImportError: torn")
        result = [{"name": "good", "title": "Good", "dimension": 1}]
        return parent.Outcome("answered", answer={"methods": json.dumps(result)})

    monkeypatch.setattr(parent, "run", describe)
    assert add_methods() == ["the installed method 'torn': raised: ImportError: torn"]
    assert [made.origin.source for made in user_methods()] == ["entry:good"]


def test_a_file_without_a_method_says_what_is_expected(tmp_path):
    file = tmp_path / "empty.py"
    file.write_text("from comparisons.methods import Solver\nprint('imported')\n")
    with pytest.raises(ValueError, match="no method in the file: expected a function under"):
        external_work.describe(f"file:{file}")


def test_classes_and_functions_are_found_and_imported_ones_are_not(tmp_path):
    file = tmp_path / "two.py"
    file.write_text(
        "from comparisons.methods import Solver, method\n"
        "from comparisons.methods.normal.reduced import ReducedProfile\n"
        "class Own(Solver):\n    name = 'own'\n    dimension = 1\n"
        "class Base(Solver):\n    name = ''\n"
        "@method('step', physics={'sliding'})\ndef step(task, load, realisation):\n"
        "    return {}\n"
    )
    document = json.loads(external_work.describe(f"file:{file}")["methods"])
    assert document == [
        {"name": "own", "title": "", "dimension": 1},
        {"name": "step", "title": "step", "dimension": 3, "physics": ["sliding"]},
    ]


def test_where_a_method_has_no_answer_is_told_with_each_of_its_verdicts(capsys, tmp_path):
    """Hertz at light loads, nothing above: no bar is too wide, and no error is known there.

    Solved in this process: starting one of its own is tested above, and takes seconds.
    """
    (tmp_path / "shy.py").write_text(
        "from comparisons.methods import method\n"
        "@method('shy', title='Shy', resolutions=(1,))\n"
        "def shy(task, load, realisation):\n"
        "    if load > task.loads.values[2]:\n"
        "        raise ValueError('too deep')\n"
        "    radius = task.scene.indenter.radius\n"
        "    return {'force': 4 / 3 * task.scene.effective_modulus * radius**0.5 * load**1.5}\n"
    )
    registry.add_class(external_work._method(f"file:{tmp_path / 'shy.py'}", "shy"))
    few = ("closed_form", "reduced", "shy")
    scene = roughline.compare("paraboloid", *few, quantities=["force", "contact_area"]).record
    force, _ = scene.verdicts_on("shy")
    reason = f"no answer at {scene.steps - 3} of {scene.steps} load steps"
    assert (force.word, force.reason) == ("not resolved", reason)
    assert force.text.endswith(reason)
    assert force.because.endswith(f"but {reason}")
    assert verdict_table([scene], "shy").rows[0][3].text == f"not resolved 1\u202f%, {reason}"
    assert summary_lines([scene]).rows[1][3].text == f"round-off, {reason}"
    header = {"created": "", "command": "", "effort": "quick", "machine": {}, "versions": {}}
    study = StudyRecord(seconds=1.0, scenes=(scene,), **header)
    print_study(study, [])
    assert capsys.readouterr().out.count("\nShy") == 2  # its verdicts, and a finding of its own
    whole = page(study, with_pictures=False)
    cells, why = (
        whole.split(f'id="{table}-table"')[1].split("</table>")[0]
        for table in ("verdict", "scene-1-why")
    )
    assert reason in cells
    assert "force, Shy</th>" in why
    assert reason in why
    assert "Shy: not computed, so not part of the answer: contact area." in whole
    assert whole.count("ot computed, so") == 1  # the reduced model gives all
    heading = whole.split('id="scene-1-title"')[1].split("</summary>")[0]
    assert "reduced model: " in heading
    assert f'Shy: <span class="told">{force.text}<' in heading
    del METHODS["shy"]  # the page needs its record alone
    assert (
        page(study.model_copy(update={"scenes": (replace(scene),)}), with_pictures=False) == whole
    )


@pytest.mark.parametrize("last", [False, True])
def test_a_lost_load_is_no_reason_for_a_pressure_that_is_not_computed(last):
    """Pressures are compared at the last load: only where that is lost may it be the reason."""
    few = {"compare.methods": ["closed_form", "reduced", "bem_fft"], "compare.resolutions": [8]}
    plan, solved = solved_in_memory(plan_scene(load_scene("paraboloid", few))[0], "quick")
    solution = solved["reduced", 8]
    solution.fields = {}
    solution.fail((0, -1 % solution.converged.size if last else 0), "ValueError: my own bug")
    solution.refuse_nan()
    told = record_scene(plan, solved).verdicts_on("reduced")
    (pressure,) = (item for item in told if item.quantity == "pressure")
    reason = "ValueError: my own bug" if last else "not computed by the method"
    assert (pressure.word, pressure.reason, pressure.offered) == ("no result", reason, last)
    headline = worst(told)
    assert (headline.quantity == "pressure") == last
    assert last or headline.reason.startswith("no answer at 1 of ")


def test_a_method_that_breaks_while_it_plans_is_an_error_not_a_refusal(monkeypatch):
    """A typing error in `refuses` used to leave the method out, with exit code 0.

    That of an installed package, which nobody asked for, is left out still.
    """
    outcomes = {
        "mine": parent.Outcome("raised", reason="AttributeError: no attribute 'indentor'"),
        "odd": parent.Outcome("answered", answer={"ok": True, "resolutions": [0]}),
    }
    monkeypatch.setattr(parent, "run", lambda work, source, name, *a, **k: outcomes[name])
    for source in ("file:x", "entry:x"):
        for name in outcomes:
            register(Origin(source, name, name, 3, "", 1.0, 1e9))
        scene = load_scene("paraboloid", {"compare.methods": ["closed_form", *outcomes]})
        if source == "file:x":
            with pytest.raises(InputError) as caught:
                plan_scene(scene)
            first, second = str(caught.value).splitlines()
            assert first.startswith("--method-file: mine: paraboloid: planning raised: Attribute")
            assert second.endswith("malformed answer: resolutions are [0]")
    refused = {method.method: method.reason for method in plan_scene(scene)[0].methods}
    assert "planning raised" in refused["mine"]
