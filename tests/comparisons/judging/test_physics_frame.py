"""Paths, histories and speeds through the whole chain, with methods made for these tests."""

import math

import numpy as np
import pytest

import roughline
from comparisons.judging.metrics import relative_error
from comparisons.judging.uncertainty import grid_uncertainty
from comparisons.methods import NoAnswerError, Row, Solver, Step, needed
from comparisons.methods.normal.reduced import ReducedProfile
from comparisons.methods.registry import SOLVERS, solver_for
from comparisons.questions.study import Study, solved_in_memory
from comparisons.results.advice import advise
from comparisons.results.recording import over_own_value, record_scene
from comparisons.results.store import load_study
from comparisons.scene.scene import load_scene
from comparisons.solving.execution import execute
from comparisons.solving.planning import plan_scene

FRICTION = {"friction": {"coefficient": 0.5}}
LOOP = {"force": "10 N", "tangential_force": ["4 N", "-4 N", "4 N"], "substeps": 3}


class Sheared(Solver):
    """A spring of stiffness k to every side, off by one per cent at N = 1, by 1/N % at N."""

    physics = frozenset({"friction"})
    levels = (10, 20, 40)
    calls = 0

    def __init__(self, scene):
        super().__init__(scene)
        needed(scene.indenter, "a spring under an indenter")

    def resolutions(self, geometry):
        return self.levels

    def rows(self, task):
        Sheared.calls += 1
        yield Row(lambda loads: self.steps(task, loads))

    def steps(self, task, loads):
        error = 0.0 if self.name == "closed_form" else 0.01 / task.resolution
        (force,) = task.loads.normal.values
        for load in loads:
            if abs(load) > 0.5 * force:
                raise NoAnswerError("it slides away")
            yield Step({"tangential_displacement": 1e-6 * load * (1 + error), "force": force})


class ShearedTruth(Sheared):
    """Exact."""

    name, levels = "closed_form", (1,)


class ShearedModel(Sheared):
    """In three resolutions."""

    name = "reduced"


@pytest.fixture
def sheared(monkeypatch):
    """Give friction a truth, and a reduced model in three resolutions."""
    for name in ("bem_fft", "fem"):
        plain = tuple(maker for maker in SOLVERS[name] if not maker.physics)
        monkeypatch.setitem(SOLVERS, name, plain)
    for made in (ShearedTruth, ShearedModel):
        plain = tuple(maker for maker in SOLVERS[made.name] if not maker.physics)
        monkeypatch.setitem(SOLVERS, made.name, (*plain, made))


@pytest.mark.usefixtures("sheared")
def test_a_solver_takes_exactly_the_scenes_of_its_physics(scene):
    pulled = scene(loading=LOOP, **FRICTION)
    assert isinstance(solver_for("reduced", pulled), ShearedModel)
    assert isinstance(solver_for("reduced", scene()), ReducedProfile)
    glued = scene(loading=LOOP, adhesion={"work": 0.05}, **FRICTION)
    assert solver_for("reduced", glued).reason == "does not model [friction] and [adhesion]"
    (plan,) = plan_scene(pulled)
    assert {method.method for method in plan.methods if method.supported} == {
        "closed_form",
        "reduced",
    }


@pytest.mark.usefixtures("sheared")
def test_errors_along_a_path_are_relative_to_its_largest_value(scene):
    result = roughline.compare(scene(loading=LOOP, **FRICTION)).record
    rows = result.setting_rows("reduced", 10)
    load = rows["tangential_force"]
    expected = 0.001 * load / 4.0
    # errors in rows are rounded to single precision, by half of its last digit
    assert rows["error_tangential_displacement"] == pytest.approx(expected, rel=6e-8)
    assert np.ptp(rows["tangential_force"]) == 8.0
    (verdict,) = [verdict for verdict in result.verdicts if verdict.resolution == 10]
    assert verdict.at == "step"
    assert verdict.when.endswith(", over the largest value of the path")
    assert abs(verdict.error) == pytest.approx(0.001, rel=1e-9)


@pytest.mark.usefixtures("sheared")
def test_a_step_that_fails_ends_its_path_and_all_keep_their_loads(scene):
    loading = {"force": "10 N", "tangential_force": ["4 N", "8 N", "2 N"]}
    result = roughline.compare(scene(loading=loading, **FRICTION)).record
    rows = result.setting_rows("reduced", 40)
    assert list(rows["converged"]) == [True, False, False]
    assert list(rows["tangential_force"]) == [4.0, 8.0, 2.0]
    assert list(rows["reason"]) == ["", "it slides away", "it slides away"]


@pytest.mark.usefixtures("sheared")
@pytest.mark.parametrize(
    ("force", "tolerance", "hidden"),
    # 0.1 N is a fortieth of the largest load: 20 % there are 0.5 % of the largest value
    [
        (0.1, 0.01, "(outside 1\u202f% over its own: +20\u202f% at step 1)"),
        (0.1, 0.3, ""),
        (3.0, 0.01, ""),
        (0.1, 0.001, ""),  # outside anyway
    ],
)
def test_an_error_of_small_loads_that_the_largest_value_hides_is_told(
    scene, monkeypatch, force, tolerance, hidden
):
    steps = Sheared.steps

    def shifted(self, task, loads):
        shift = 0.0 if self.name == "closed_form" else 0.02
        yield from steps(self, task, np.asarray(loads) + shift)

    monkeypatch.setattr(Sheared, "steps", shifted)
    loading = {"force": "10 N", "tangential_force": [force, 4.0]}
    asked = {"quantities": ["tangential_displacement"], "tolerance": tolerance}
    result = roughline.compare(scene(loading=loading, compare=asked, **FRICTION)).record
    (verdict,) = (verdict for verdict in result.verdicts if verdict.resolution == 40)
    assert (verdict.word == "outside") == (tolerance < 0.005)
    assert ("its own" in verdict.when) == bool(hidden)
    assert hidden in verdict.when


@pytest.mark.parametrize(("bar", "told"), [(0.0049, {}), (0.004, {"own_step": 0})])
def test_what_the_bar_of_a_small_value_covers_is_not_told(bar, told):
    """0.5 % of the largest value are 20 % of a fortieth; with these bars 0.4 or 4 % remain."""
    errors, bars, values = np.array([0.005, 0.0]), np.array([bar, 0.0]), np.array([0.1, 4.0])
    found = over_own_value(errors, bars, values, 0.01)
    assert found == ({"own_error": pytest.approx(0.2)} | told if told else {})


@pytest.mark.usefixtures("sheared")
def test_the_bar_of_a_path_covers_its_error_where_the_values_pass_zero(scene):
    (plan,) = plan_scene(scene(loading=LOOP, **FRICTION))
    solved = solved_in_memory(plan, "quick")[1]
    without = {key: part for key, part in solved.items() if key[0] == "reduced"}
    curves = np.array(
        [without["reduced", n].quantities["tangential_displacement"][0] for n in (10, 20, 40)]
    )
    sizes = np.full(curves.shape[1], np.abs(curves).max())
    bar = grid_uncertainty(np.array([10, 20, 40]), curves, sizes=sizes)
    truth = solved["closed_form", 1].quantities["tangential_displacement"][0]
    error = np.abs(relative_error(curves[-1], truth, path=True))
    assert np.isfinite(bar).all()
    assert (bar >= error * (1 - 1e-9)).all()


@pytest.mark.usefixtures("sheared")
def test_a_path_that_raises_is_not_cut_in_halves(scene, monkeypatch):
    """The second half of a path cannot begin anew, so it must not be solved by itself."""

    def raises(self, task):
        Sheared.calls += 1
        raise ValueError("no way")

    monkeypatch.setattr(Sheared, "solve", raises)
    monkeypatch.setattr(Sheared, "calls", 0)
    (plan,) = plan_scene(scene(loading=LOOP, **FRICTION))
    solution = execute(plan.tasks[0])
    assert not solution.converged.any()
    assert Sheared.calls == 1
    assert "no way" in solution.reasons[0, 0]


@pytest.mark.usefixtures("sheared")
def test_the_record_says_along_what_was_compared_and_survives_a_folder(scene, tmp_path):
    (plan,) = plan_scene(scene(loading=LOOP, **FRICTION))
    record = record_scene(*solved_in_memory(plan, "quick"))
    assert (record.control, record.along, record.is_path) == ("tangential_force", "step", True)
    assert record.quantities == ("tangential_displacement",)
    assert "reached" not in advise(record).sentence
    Study([plan], tmp_path / "out").run()
    (again,) = load_study(tmp_path / "out").scenes
    assert (again.along, again.quantities) == ("step", ("tangential_displacement",))
    assert again.plan.switched_on[0][0] == "Coulomb friction"


def test_sizes_along_a_path_leave_unknown_steps_unknown():
    error = relative_error(np.array([1.0, 2.0, 3.0]), np.array([0.0, math.nan, 4.0]), path=True)
    assert error[0] == 0.25
    assert math.isnan(error[1])
    assert error[2] == -0.25


@pytest.mark.parametrize(
    ("creeps", "name"),
    [
        # slip all over from a creep of 0.2 % on: nothing sticks
        ({"creep": [0.001, 0.1]}, "stick_area"),
        ({"creep": 0.001, "lateral_creep": [0.0, 0.001]}, "lateral_force"),
    ],
)
def test_a_step_at_which_all_answers_are_zero_is_right(creeps, name):
    """The other step is judged, and decides; both errors are beside it in the rows."""
    ball = load_scene("rolling-ball", {"rolling": creeps, "compare.quantities": [name, "traction"]})
    asked = {"resolutions": [6, 9, 12], "tolerance": 0.9}
    record = roughline.compare(ball, "reduced", "bem_fft", **asked).record
    (verdict,) = (
        v for v in record.verdicts if (v.method, v.resolution, v.quantity) == ("reduced", 12, name)
    )
    assert (verdict.word, verdict.lacking) == ("within", "")
    rows = record.setting_rows("reduced", 12)
    (zero,) = np.flatnonzero(rows[name] == 0)
    assert rows[f"error_{name}"][zero] == 0 != verdict.error
    # where all grids say zero they say how well, and not what the other step's do: its per cents
    assert rows[f"reference_uncertainty_{name}"][zero] < 1e-6  # residuals of the solver
    assert verdict.step == 1 - zero
