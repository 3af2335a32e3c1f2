"""The sentence of a scene, the verdict, and the small facts that every result carries."""

from __future__ import annotations

import math
import pickle

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from comparisons import machine
from comparisons.answer import answer, time_at_error
from comparisons.errors import InputError
from comparisons.methods import METHODS
from comparisons.reference import Reference
from comparisons.scene import builtin_names
from comparisons.suites import SUITES
from comparisons.verdicts import judge


def truth(method, bar):
    curve, bars = {"force": np.arange(1.0, 4.0)}, {"force": np.full(3, bar)}
    return Reference(method, 8, curve, bars, bars, "The truth.")


EXACT = truth("closed_form", 1e-12)


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


def measured(rows):
    columns = ("method", "resolution", "rms", "seconds")
    table = pd.DataFrame(rows, columns=columns)
    verdict = np.where(table["rms"] <= 0.01, "within", "outside")
    return table.assign(quantity="force", at="penetration", verdict=verdict)


def test_the_sentence_names_the_cheapest_setting_of_each_method_fastest_first():
    table = measured(
        [
            ("fem", 4, 0.02, 1.0),
            ("fem", 8, 0.005, 8.0),
            ("reduced", 10, 0.001, 1e-3),
            ("bem_fft", 8, 0.04, 0.01),
        ]
    )
    said = answer(("force",), "penetration", 0.01, table, EXACT)
    model, fem, fft = (METHODS[name].title for name in ("reduced", "fem", "bem_fft"))
    assert said.startswith(f"For 1\u202f% in force: {model} 1.0\u202fms (N = 10), {fem} ")
    assert "(N = 8)" in said
    assert f"not reached by {fft} (best 4.0\u202f%)" in said
    assert said.endswith("truth: closed form.")


def test_the_sentence_admits_what_is_not_known():
    unknown = truth("bem_fft", np.nan)
    table = measured([("reduced", 10, 0.2, 1e-3)])
    said = answer(("force",), "penetration", 0.01, table, unknown)
    assert "no method is sure to get there" in said
    assert "its error is not known" in said
    empty = answer(("force",), "penetration", 0.01, pd.DataFrame(), EXACT)
    assert "Nothing else was run" in empty
    assert "no truth to compare with" in answer(("force",), "force", 0.01, table, None)


def test_a_setting_whose_bar_is_wider_than_the_question_is_not_called_good_enough():
    table = measured([("fem", 4, 0.004, 1.0), ("bem_fft", 8, 0.02, 0.1)])
    said = answer(("force",), "penetration", 0.01, table.assign(verdict="not resolved"), EXACT)
    assert "no method is sure to get there" in said
    assert "not resolved: " in said


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
