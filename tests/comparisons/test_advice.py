"""The sentence of a scene, the verdict, and the small facts that every result carries."""

from __future__ import annotations

import json
import math
import pickle
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from comparisons import machine
from comparisons.advice import advise, time_at_error
from comparisons.errors import InputError
from comparisons.methods import METHODS
from comparisons.scene import builtin_names
from comparisons.store import SceneRecord
from comparisons.suites import SUITES
from comparisons.verdicts import judge
from reports.cli import run_command


def record(rows, method="closed_form", bar=0.0, quantities=("force",), tolerance=0.01):
    """Make a record as a study would, from (method, N, rms, seconds) of each quantity."""
    columns = ("method", "resolution", "rms", "seconds", "quantity")
    table = pd.DataFrame([(*row, "force")[:5] for row in rows], columns=columns)
    verdict = np.where(table["rms"] <= tolerance, "within", "outside")
    measures = table.assign(at="penetration", verdict=verdict) if rows else pd.DataFrame()
    return SceneRecord(
        name="scene",
        title="Scene",
        text="",
        control="penetration",
        quantities=quantities,
        tolerance=tolerance,
        plan={},
        reference={
            "method": method,
            "resolution": 64,
            "text": "The truth.",
            "uncertainty": dict.fromkeys(quantities, bar),
        },
        answer="",
        disagreements=(),
        rows=pd.DataFrame({"method": [method], "resolution": [64], "seconds": [2.0]}),
        measures=measures,
    )


# --- time at equal error --------------------------------------------------------------------


@given(rate=st.floats(0.5, 4), growth=st.floats(1.1, 30), wanted=st.floats(0.0011, 0.99))
def test_between_two_settings_times_and_errors_are_joined_in_logarithms(rate, growth, wanted):
    """Error n^-rate at cost growth^log2(n): a straight line in logarithms, met exactly."""
    n = 2.0 ** np.arange(12)
    errors, seconds = n**-rate, 1e-3 * growth ** np.log2(n)
    found, index = time_at_error(seconds, errors, wanted)
    if errors[-1] > wanted:
        assert math.isnan(found)
        assert index is None
        return
    crossing = wanted ** (-1 / rate)
    assert found == pytest.approx(1e-3 * growth ** np.log2(crossing), rel=1e-9)
    assert errors[index] <= wanted < errors[index - 1]


def test_nothing_is_extrapolated_to_an_error_that_was_never_reached():
    assert time_at_error(np.array([1.0, 2.0]), np.array([0.1, 0.05]), 0.01)[1] is None
    # A coarsest setting that is good enough costs what it costs, not less.
    assert time_at_error(np.array([1.0, 2.0]), np.array([1e-3, 1e-4]), 0.01) == (1.0, 0)
    # An exact answer has no logarithm, and needs none.
    assert time_at_error(np.array([1.0, 4.0]), np.array([0.1, 0.0]), 0.01) == (4.0, 1)


def test_the_sentence_names_the_cheapest_setting_of_each_method_fastest_first():
    rows = [
        ("fem", 4, 0.02, 1.0),
        ("fem", 8, 0.005, 8.0),
        ("reduced", 10, 0.001, 1e-3),
        ("bem_fft", 8, 0.04, 0.01),
    ]
    advice = advise(record(rows))
    said = advice.sentence
    model, fem, fft = (METHODS[name].title for name in ("reduced", "fem", "bem_fft"))
    assert said.startswith(f"For 1\u202f% in force: {model} 1.0\u202fms (N = 10), {fem} ")
    assert "(N = 8)" in said
    assert f"not reached by {fft} (best 4.0\u202f%)" in said
    assert said.endswith("truth: closed form.")
    assert (advice.cheapest.method, advice.cheapest.resolution) == ("reduced", 10)
    assert [each.seconds for each in advice.settings] == [1e-3, 0.01, 1.0, 2.0, 8.0]


def test_the_sentence_admits_what_is_not_known():
    unknown = advise(record([("reduced", 10, 0.2, 1e-3)], "bem_fft", None))
    assert "no method is sure to get there" in unknown.sentence
    assert "its error is not known" in unknown.sentence
    assert unknown.cheapest is None
    assert "Nothing else was run" in advise(record([])).sentence
    nothing = replace(record([]), reference={})
    assert "no truth to compare with" in advise(nothing).sentence


def test_a_setting_whose_bar_is_wider_than_the_question_is_not_called_good_enough():
    rows = record([("fem", 4, 0.004, 1.0), ("bem_fft", 8, 0.02, 0.1)])
    advice = advise(replace(rows, measures=rows.measures.assign(verdict="not resolved")))
    assert "no method is sure to get there" in advice.sentence
    assert "not resolved: " in advice.sentence
    assert advice.cheapest is None or advice.cheapest.is_truth


def test_a_setting_has_to_be_good_in_every_quantity_that_is_asked():
    rows = [
        ("reduced", 10, 0.001, 1e-3, "force"),
        ("reduced", 10, 0.2, 1e-3, "contact_area"),
        ("fem", 4, 0.002, 1.0, "force"),
        ("fem", 4, 0.003, 1.0, "contact_area"),
        ("bem_fft", 8, 0.001, 0.1, "force"),
    ]
    advice = advise(record(rows, quantities=("force", "contact_area")))
    assert advice.cheapest.method == "fem"
    assert "in force and contact area" in advice.sentence
    assert f"not reached by {METHODS['reduced'].title} (best 20\u202f%)" in advice.sentence
    assert f"without all of these: {METHODS['bem_fft'].title}" in advice.sentence


def test_a_truth_that_is_known_well_enough_is_an_answer_itself():
    rows = [("reduced", 10, 0.2, 1e-3)]
    good = advise(record(rows, "bem_fft", 0.004))
    assert "FFT BEM 2.0\u202fs (N = 64, the truth itself)" in good.sentence
    assert good.cheapest.is_truth
    assert advise(record(rows, "bem_fft", 0.04)).cheapest is None


def test_a_user_gets_advice_for_a_tolerance_and_quantities(capsys):
    """A cylinder's force is exact in the reduced model: nothing cheaper can be advised."""
    asked = ["advise", "cylinder", "--tolerance", "2 %", "--quantities", "force", "--json"]
    assert exit_code(asked) == 0
    (found,) = json.loads(capsys.readouterr().out)
    assert found["tolerance"] == 0.02
    assert found["cheapest"]["method"] == "reduced"
    assert found["sentence"].startswith("For 2\u202f% in force: reduced model")
    for wrong in (["--tolerance", "many"], ["--tolerance", "-1"], ["--quantities", "beauty"]):
        assert exit_code(["advise", "cylinder", *wrong]) == 2


exit_code = run_command


# --- verdicts -------------------------------------------------------------------------------


@given(
    errors=st.lists(st.floats(-0.1, 0.1), min_size=1, max_size=6),
    bar=st.floats(0, 0.1),
    tolerance=st.floats(1e-4, 0.1),
)
def test_verdicts_follow_their_definition(errors, bar, tolerance):
    """|e| + u <= t holds, |e| - u > t fails, in between nothing is known."""
    bars = np.full(len(errors), bar)
    worst = max(abs(e) for e in errors)
    if worst + bar <= tolerance:
        expected = "within"
    else:
        expected = "outside" if worst - bar > tolerance else "not resolved"
    assert judge(errors, bars, tolerance) == expected


def test_an_unknown_bar_resolves_nothing_and_no_error_is_no_result():
    assert judge([1e-9], [np.nan], 0.01) == "not resolved"
    assert judge([10.0], [np.nan], 0.01) == "not resolved"
    # A step that could not be compared may be anything: it forbids "within", not "outside".
    assert judge([np.nan, 0.001], [0.0, 0.0], 0.01) == "not resolved"
    assert judge([np.nan, 0.1], [0.0, 0.0], 0.01) == "outside"
    assert judge([np.nan], [0.0], 0.01) == "no result"


# --- small facts ----------------------------------------------------------------------------


def test_suites_hold_built_in_scenes_each_once():
    for members in SUITES.values():
        assert set(members) <= set(builtin_names())
        assert len(set(members)) == len(members)


def test_machine_and_versions_are_one_line_each():
    described, found = machine.machine(1), machine.versions()
    assert described["cores"] >= 1
    assert described["memory"] > 1e8
    assert {"python", "numpy", "scipy", "numba"} <= set(found)
    for text in (machine.machine_text(described), machine.versions_text(found)):
        assert text
        assert "\n" not in text


def test_input_errors_are_value_errors_and_survive_a_pickle():
    again = pickle.loads(pickle.dumps(InputError("wrong")))
    assert isinstance(again, ValueError)
    assert str(again) == "wrong"
