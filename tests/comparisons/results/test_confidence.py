"""Bars are called 95 % only where calibration holds them against true errors."""

from types import SimpleNamespace

import pytest

from comparisons.judging.reference import Reference
from comparisons.questions.problems.sheet import sheet_of
from comparisons.results.decisions import confidence
from comparisons.results.finding import family
from comparisons.results.store import SceneRecord
from comparisons.scene.scene import load_scene
from comparisons.solving.plan_record import PlanRecord
from reports.tables.problems import sheet_text


def record(name, method="bem_fft"):
    scene = load_scene(name)
    return SceneRecord(
        *(name, name, scene.text, "force", scene.compare.quantities, 0.01),
        *(PlanRecord(), Reference(method, 1, ""), (), "", ()),
    )


@pytest.mark.parametrize(
    ("name", "called"),
    [
        ("square-punch", "u is a 95 % half-width, by calibration; of contact pressure an estimate"),
        ("rough-free", "u is a 95 % half-width over the loads (92 % at one load), by calibration"),
        ("friction-steel", "no calibration covers such scenes"),
        ("coated-ball", "no calibration covers such scenes"),
        ("sliding-rough", "no calibration covers such scenes"),
    ],
)
def test_only_what_is_calibrated_is_called_so(name, called):
    assert called in confidence(record(name))


def test_a_problem_sheet_calls_95_per_cent_what_is_calibrated():
    """The square punch is; a ball under a coating would not be; closed forms are exact."""
    square, ball = (sheet_of(name) for name in ("RL-003", "RL-001"))
    assert "95 % half-width of its error, by calibration" in sheet_text(square)
    assert "exact to its digits" in sheet_text(ball)
    layers = {"half_space": {"thickness": "1 mm"}}
    coated = square.model_copy(update={"tables": square.tables | layers})
    assert "no calibration covers" in sheet_text(coated)
    assert "95 %" not in sheet_text(coated)


def test_a_closed_form_leaves_no_bar_but_that_of_the_model():
    assert "exact" in confidence(record("paraboloid", "closed_form"))


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
