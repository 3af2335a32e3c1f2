"""Notes beside a result: bars of 95 %, agreement by chance, and what a time is the time of."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import roughline
from comparisons import formatting as fmt
from comparisons.judging.truth import Reference
from comparisons.questions.problem_sheets import sheet_of
from comparisons.results.advice import advise
from comparisons.results.finding import NOT_KNOWN, YES, family, finding
from comparisons.results.record import SceneRecord
from comparisons.results.recording import record_scene
from comparisons.results.rows import Rows
from comparisons.scene.scene import load_scene
from comparisons.solving.plan import PlanRecord, task_of
from comparisons.solving.planning import plan_scene
from comparisons.tasks.solution import Solution
from reports.tables.card import card, not_known_here
from reports.tables.problems import sheet_text


def record(name, method):
    scene = load_scene(name)
    return SceneRecord(
        *(name, name, scene.text, "force", scene.compare.quantities, 0.01),
        *(PlanRecord(), Reference(method, 1, ""), (), "", ()),
    )


@pytest.mark.parametrize(
    ("name", "called"),
    [
        ("paraboloid", "exact"),  # a closed form leaves no bar but that of the model
        ("square-punch", "u is a 95 % half-width, by calibration; of contact pressure an estimate"),
        ("rough-free", "u is a 95 % half-width, by calibration"),
        ("friction-steel", "no calibration covers such scenes"),
        ("coated-ball", "no calibration covers such scenes"),
        ("sliding-rough", "no calibration covers such scenes"),
    ],
)
def test_only_what_is_calibrated_is_called_so(name, called):
    method = "closed_form" if name == "paraboloid" else "bem_fft"
    assert called in record(name, method).confidence


def test_a_problem_sheet_calls_95_per_cent_what_is_calibrated():
    """The square punch is; a ball under a coating would not be; closed forms are exact."""
    square, ball = (sheet_of(name) for name in ("RL-003", "RL-001"))
    assert "95 % half-width of its error, by calibration" in sheet_text(square)
    assert "exact to its digits" in sheet_text(ball)
    layers = {"half_space": {"thickness": "1 mm"}}
    coated = square.model_copy(update={"tables": square.tables | layers})
    assert "no calibration covers" in sheet_text(coated)
    assert "95 %" not in sheet_text(coated)


def test_what_is_pressed_is_named_once_whatever_lies_below():
    """A finding named rough surfaces on layers and, once more, on rough surfaces."""
    coated = {"half_space": {"layers": [{}]}}
    names = {
        "rough surfaces on layered and graded half-spaces": coated | {"surface": {}},
        "bodies on layered and graded half-spaces": coated,
        "contacts with friction on rough surfaces": {"friction": {}, "surface": {}},
        "rough surfaces": {"surface": {}},
    }
    assert list(names) == [family(SimpleNamespace(tables=tables)) for tables in names.values()]


ASKED = {
    "compare.methods": ["reduced", "bem_fft"],
    "compare.resolutions": [16, 32, 64],
    "compare.quantities": ["penetration"],
    "compare.tolerance": 0.9,  # whatever the line says is within
}


def solved(load):
    force = {"values": [load], "relative_to": "E* A0 h'"}
    scene = load_scene("rough-patch", ASKED | {"loading": {"force": force}})
    return roughline.compare(scene).record


@pytest.mark.parametrize(
    ("load", "reasons"),
    [
        (2e-5, ["F/(E* A₀ h') = 2.00×10⁻⁵, below 0.001", ", fewer than 30"]),
        # a patch of four waves a side has 16 summits
        (0.01, [", fewer than 30", "one surface of the many that its spectrum allows"]),
    ],
)
def test_within_by_chance_is_no_recommendation(load, reasons):
    """Of one surface that touches at few summits; each reason is said, with what claims know."""
    record = solved(load)
    assert [item.word for item in record.verdicts_on()] == ["within"]
    (row,) = finding([record])
    assert (row.use, row.cost) == (NOT_KNOWN, "–")
    assert "reduced" not in {setting.method for setting in advise(record).reaching()}
    assert "reduced model (within by chance" in advise(record).sentence
    said = not_known_here(record)
    assert all(reason in said for reason in reasons)
    assert "claim rough-penetration" in said
    outside = tuple(replace(item, word="outside") for item in record.verdicts)
    assert not_known_here(replace(record, verdicts=outside)) == ""  # nothing agrees: no chance


def test_a_card_gives_the_true_values_of_all_that_was_asked_with_their_bars():
    """By the reference; the prescribed force is no finding of it and has no bar."""
    record = solved(0.3)
    told = dict(card(record))
    bar = fmt.relative_range(record.reference.known_to("penetration"))
    depth = record.curve("bem_fft")["penetration"][-1]
    assert told["penetration depth"] == f"{fmt.with_unit(depth, 'm')} ± {bar}"
    assert "±" not in told["force"]
    assert told["true values by"].startswith("FFT BEM, N = ")
    assert "; ± of discretisation alone; of one surface" in told["true values by"]


def test_what_the_reference_lacks_is_no_yes_and_what_is_prescribed_decides_nothing():
    """Of a worn punch the closed form has no largest depth; F is held, and the volume is k F s."""
    names = ["penetration", "force", "worn_volume", "wear_depth"]
    asked = {"quantities": names, "resolutions": [10]}
    record = roughline.compare("worn-punch", "closed_form", "reduced", **asked).record
    assert "force" not in record.quantities
    (row,) = finding([record])
    assert (row.use, row.error[:2]) == ("for d only", "d ")


def test_a_model_that_takes_longer_than_a_solver_is_not_needed():
    """Lines that take a microsecond are worth it, lines that take an hour are not."""
    record = solved(0.3)
    table = record.rows.frame()
    lines = table["method"] == "reduced"

    def cost(seconds):
        times = table["seconds_all"].where(~lines, seconds)
        (row,) = finding([replace(record, rows=Rows.of(table.assign(seconds_all=times)))])
        return row.cost

    (grid,) = (item for item in advise(record).reaching() if item.method == "bem_fft")
    solver = f"{fmt.duration(grid.seconds)} (N = {grid.resolution})"
    assert cost(3600.0).startswith(f"no need: the 3-D solver is cheaper ({solver} against ")
    assert cost(1e-6).endswith("×")


def test_merged_contacts_are_few_and_no_chance():
    """At F = 0.3 E* A0 h' more than a third of the patch touches, in one piece or two."""
    record = solved(0.3)
    assert (record.reference.chance, finding([record])[0].use) == ("", YES)
    assert not_known_here(record) == ""


LINES = 101


@pytest.fixture
def ensemble(rough):
    """Surfaces of area 1 in 1 s each at 16, 2 s at 32, 4 s of fem; lines of area 1.2 to 1.8."""
    (plan,) = plan_scene(rough(realisations=30, loading={"force": [1e-6]}))

    def solution(method, resolution, areas, seconds):
        task = task_of(plan, method, resolution, tuple(range(len(areas))))
        curves = {"force": np.full((len(areas), 1), 1e-6), "contact_area": areas[:, None]}
        found = Solution.of(task, curves)
        found.seconds, found.setup_seconds = seconds * len(areas), 0.25 * seconds * len(areas)
        return found

    solved = {
        ("bem_fft", 16): solution("bem_fft", 16, np.ones(30), 1.0),
        ("bem_fft", 32): solution("bem_fft", 32, np.ones(5), 2.0),
        ("fem", 16): solution("fem", 16, np.ones(3), 4.0),
        ("reduced", 16): solution("reduced", 16, np.linspace(1.2, 1.8, LINES), 1e-3),
    }
    return record_scene(plan, solved)


def test_the_time_of_a_mean_is_that_of_all_solves_it_stands_on(ensemble):
    """A mean on a fine grid stands on the coarse ones; one of elements on those of the grid."""
    whole = {key: ensemble.cost(*key) for key in (("bem_fft", 32), ("fem", 16), ("reduced", 16))}
    assert whole["bem_fft", 32].seconds == pytest.approx(30 + 5 * 2)
    assert whole["bem_fft", 32].setup_seconds == pytest.approx(0.25 * 40)
    assert whole["fem", 16].seconds == pytest.approx(30 + 3 * 4)
    assert whole["reduced", 16].seconds == pytest.approx(LINES * 1e-3)
    assert whole["bem_fft", 32].single_seconds == pytest.approx(2.0)
    assert whole["bem_fft", 32].solves == "30 + 5 surfaces"
    assert whole["fem", 16].solves == "3 surfaces beside those of FFT BEM"
    # every solve of the scene once
    assert ensemble.spent == pytest.approx(30 + 5 * 2 + 3 * 4 + LINES * 1e-3)


def test_the_time_of_one_line_stands_beside_the_errors_of_single_lines(ensemble):
    """The mean errs by 50 %; of lines from +20 to +80 %, 90 % lie between +23 and +77 %."""
    (line,) = [s for s in advise(ensemble).settings if (s.method, s.resolution) == ("reduced", 16)]
    (verdict,) = [v for v in line.verdicts if v.quantity == "contact_area"]
    assert verdict.error == pytest.approx(0.5)
    assert verdict.single == "+23 to +77\u202f%"
    assert (verdict.single_low, verdict.single_high) == pytest.approx((0.23, 0.77))
    assert "takes 1.0\u202fms" in advise(ensemble).single
    assert "contact area +23 to +77\u202f%." in advise(ensemble).single


def test_a_method_that_is_compared_with_itself_is_marked(ensemble):
    marks = {(s.method, s.resolution): s.brief for s in advise(ensemble).settings}
    assert marks["bem_fft", 16].startswith("FFT BEM* ")
    assert not marks["bem_fft", 32].startswith("FFT BEM* ")  # the truth
    assert "FFT BEM 30\u202fs (N = 16, 30 surfaces, same method as the reference)" in (
        advise(ensemble).sentence
    )


def test_elements_that_repeat_from_cell_to_cell_have_a_name_of_their_own(ensemble):
    """They cost as much as boundary elements; a block of elements ten times as much."""
    (block,) = plan_scene(load_scene("paraboloid", {"compare.methods": ["fem", "bem_fft"]}))
    titles = {planned.method: planned.title for planned in block.methods}
    assert titles["fem"] == ""  # the usual one, FEM
    assert ensemble.title_of("fem") == "FFT FEM"
    assert "FFT FEM 42\u202fs" in advise(ensemble).sentence
