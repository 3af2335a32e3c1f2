"""The catalogue of hard cases: each method does on each case what the catalogue says.

Expectations bound the error against a closed form, or against a trusted solution together with
its bar; refusals are asserted by their words. Times do not matter here, so nothing is repeated.
"""

import numpy as np
import pytest

from comparisons.facts.methods import BUILT_IN, METHODS
from comparisons.methods.normal.reduced import ReducedProfile
from comparisons.methods.registry import SOLVERS
from comparisons.questions.hard_cases.case import Expected, catalogue
from comparisons.questions.hard_cases.run import LEFT_OUT, expectation_text, outcomes
from comparisons.solving.inquiries import answer_of

OURS = tuple(name for name in BUILT_IN if not METHODS[name].peer)
# Paths, histories and speeds that take more than a second of solving: .ci/nightly has them, .ci/run
# the others.
LONG = {
    *("adhesion-afm", "adhesion-again", "adhesion-no-load"),
    *("edge-off-nodes", "edge-on-nodes"),
    *("friction-next-to-sliding", "friction-reversals", "friction-steel-rigid"),
    *("impact-beyond-the-sphere", "impact-decades", "impact-overdamped", "impact-sticky"),
    *("impact-table", "memory-easy", "memory-eighteen-decades", "memory-imprint-of-a-fluid"),
    *("memory-nanoseconds", "memory-retreat-slows", "sliding-creeping", "sliding-racing"),
    *("sliding-dashpot", "sliding-twelve-decades", "layer-of-a-thousandth", "rolling-braking"),
    *("plasticity-pumped", "plasticity-thousandfold", "plasticity-flow", "impact-thousand-bounces"),
    *("film-six-decades", "film-wavy", "film-rubber-of-one-pascal", "film-starved"),
    *("plasticity-rubber", "plasticity-hardly-any", "rubber-on-a-rigid-base", "needle"),
    *("rough-fine", "depth-beyond-table", "coating-a-thousand-times-as-hard", "friction-auxetic"),
}


def assert_as_said(results):
    """No crash, no NaN, no silent wrong number: what the catalogue says, with a reason if none."""
    assert {result.method: result.deviation for result in results if result.deviation} == {}
    numbers = [result for result in results if result.kind in ("accurate", "degraded")]
    assert np.isfinite([[result.error, result.bar, result.seconds] for result in numbers]).all()
    assert all(result.reason for result in results if result not in numbers)


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in catalogue() if name not in LONG])
def test_methods_do_what_the_catalogue_says(name):
    """The cheap pairs of method and case, which .ci/run has."""
    results = answer_of(outcomes(catalogue()[name], OURS, full=False))
    assert [result.method for result in results] == list(OURS)
    left_out = {result.method for result in results if result.kind == LEFT_OUT}
    assert left_out == catalogue()[name].slow & {*OURS}
    assert_as_said(results)


def pairs_left(name):
    return [method for method in OURS if name in LONG or method in catalogue()[name].slow]


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in catalogue() if pairs_left(name)])
def test_methods_do_what_the_catalogue_says_in_full(name):
    """Together with the test above every pair, each once."""
    results = answer_of(outcomes(catalogue()[name], pairs_left(name), full=True))
    assert [result.method for result in results] == pairs_left(name)
    assert LEFT_OUT not in {result.kind for result in results}
    assert_as_said(results)


def test_the_long_cases_are_in_the_catalogue():
    assert set(catalogue()) >= LONG


def scaled(factor, name="force"):
    def change(solution):
        solution.quantities[name] *= factor

    return change


def finite(solution):
    for values in solution.quantities.values():
        values[:] = np.nan_to_num(values, nan=1.0, posinf=1.0, neginf=1.0)
    solution.quantities.setdefault("energy", np.ones(solution.converged.shape))


def careless(_):
    np.array([1e300]) * 1e300


def broken(_):
    raise RuntimeError("no luck")


def silent(solution):
    del solution.quantities["force"]


@pytest.mark.parametrize(
    ("name", "change", "kind", "told"),
    [
        # 2 parts in a thousand are within 1 %, and far outside what is expected
        ("load-one", scaled(1.002), "accurate", "error 0.2"),
        ("load-one", scaled(1.5), "degraded", "degraded instead of accurate"),
        ("load-absurd-penetration", finite, "accurate", "lost steps () instead of (2,)"),
        ("load-one", scaled(1.1**0.5, "equivalent_radius"), "accurate", "area off by 10"),
        ("load-one", careless, "accurate", "it warns"),
        ("load-one", broken, "lost", "lost instead of accurate: no luck"),
        ("load-one", silent, "lost", "lost instead of accurate: gives no force"),
    ],
)
def test_no_fault_of_a_method_is_silent(monkeypatch, name, change, kind, told):
    class Altered(ReducedProfile):
        def solve(self, task):
            solution = super().solve(task)
            change(solution)
            return solution

    monkeypatch.setitem(SOLVERS, "reduced", (Altered,))
    (outcome,) = answer_of(outcomes(catalogue()[name], ["reduced"], full=True))
    assert outcome.kind == kind
    deviation, _, reason = told.partition(": ")
    assert deviation in outcome.deviation
    assert reason in outcome.reason


@pytest.mark.slow
def test_the_bar_of_the_truth_counts_against_the_claim():
    """The truth of the punch is known to 0.01 %: nobody can be shown to be closer than that."""
    case = catalogue()["edge-on-nodes"]
    expected = {"bem_fft": Expected(accurate=2e-5)}
    tight = case.model_copy(update={"expected": expected, "resolutions": {"bem_fft": 64}})
    (outcome,) = answer_of(outcomes(tight, ["bem_fft"], full=True))
    assert outcome.error < 2e-5
    assert "instead of at most 20" in outcome.deviation


def test_expectations_read_as_sentences():
    assert (
        expectation_text(Expected(accurate=0.01))
        == "accurate, error at most 1.0\N{NARROW NO-BREAK SPACE}%"
    )
    partly = Expected(degraded=0.5, text="came out as inf", lost=(2,), why="few cells")
    assert expectation_text(partly).endswith("no answer at step 3: came out as inf (few cells)")
