"""Verdicts over what a statement leaves open: no choice that is not shown decides one."""

from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest

from comparisons.errors import ProblemsError
from comparisons.judging.verdicts import OUTSIDE, WITHIN
from comparisons.questions.claims import runner
from comparisons.questions.claims.claim import load_claims, make_claim
from comparisons.questions.claims.record import (
    FAILS,
    HOLDS,
    IN_A_RANGE,
    ONLY_AS_STATED,
    STORED,
    load_claims_record,
    verdict_of,
)
from comparisons.questions.claims.runner import drawn, judge_claim, measured_under, shares
from comparisons.questions.experiments import EXPERIMENTS, Experiment
from comparisons.questions.experiments.experiment import Share
from comparisons.solving.inquiries import answer_of, together
from reports.plots.claims import boundary_map, evidence

EDGE = 3.7
OPEN = {
    "path": "y",
    "name": "length y",
    "stated": 1,
    "from": 0.5,
    "to": 8,
    "reason": "It is not said.",
}
DATA = {
    "id": "a-law",
    "text": "The law holds.",
    "equation": "(1)",
    "experiment": "made-up",
    "tolerance": 0.01,
    "refuted_by": "An error beyond 1 %.",
}


def law(monkeypatch, error, **more):
    """Return a claim whose error is `error` of x, y and the kind of boundary."""

    def run(effort, *, x=1.0, y=1.0, kind="free"):
        return Share(error(x, y, kind), 1e-6, {}, "error")

    monkeypatch.setitem(EXPERIMENTS, "made-up", Experiment("made-up", "A law.", "x", run))
    return make_claim(DATA | {"nuisance": [OPEN]} | more, "a.toml", Path())


def test_a_claim_that_no_draw_confirms_holds_only_as_stated(monkeypatch):
    """Of quick effort's two draws none is within, either: too few to tell."""
    claim = law(monkeypatch, lambda x, y, kind: 0.02 * (y != 1), expected=ONLY_AS_STATED)
    assert judge_claim(claim, "full").verdict == ONLY_AS_STATED
    quick = judge_claim(claim, "quick")
    assert quick.verdict == IN_A_RANGE
    assert not quick.differs
    wide = claim.model_copy(update={"draws": 0, "expected": IN_A_RANGE})
    record = judge_claim(wide, "full")
    assert record.verdict == ONLY_AS_STATED
    assert record.differs


def test_a_measurement_that_serves_twice_costs_once(monkeypatch):
    """Along a nuisance parameter and in the rows of a map what is stated is measured again."""
    claim = law(
        monkeypatch,
        lambda x, y, kind: 0.02 if y > EDGE else 0.0,
        vary={"from": 1, "to": 2, "steps": 2},
        map={"up": "y", "rows": 3},
        draws=0,
    )
    asked = set()

    def a_second(name, value, effort, parameters):
        arguments = EXPERIMENTS[name].arguments(value, parameters)
        asked.add(tuple(sorted(arguments.items())))
        return replace(EXPERIMENTS[name].measure(value, effort, **parameters), seconds=1.0)

    monkeypatch.setattr(runner, "measure_experiment", a_second)
    record = judge_claim(claim, "full")
    lines = [record.points, *(line.points for line in [*record.nuisances, *record.map.rows])]
    assert record.seconds == len(asked) < sum(map(len, lines))
    assert {point.seconds for line in lines for point in line} == {1.0}


def test_a_claim_within_up_to_an_edge_holds_in_a_range_and_says_where_it_ends(monkeypatch):
    claim = law(monkeypatch, lambda x, y, kind: 0.02 if y > EDGE else 0.0)
    record = judge_claim(claim, "full")
    assert record.verdict == IN_A_RANGE
    (line,) = record.nuisances
    (stretch,) = line.ranges
    assert stretch.high <= EDGE <= stretch.above
    assert stretch.above - stretch.high < (8 - 1) / 2**3 + 1e-9
    assert f"length y (1 above): within from 0.5 to {stretch.high:.4g}" in record.sentence
    assert "8 draws" in record.sentence


def test_what_two_parameters_do_together_is_seen_by_the_draws(monkeypatch):
    """Each end alone is within; the corner of both is not."""
    second = OPEN | {"path": "kind", "name": "boundary", "stated": "free"}
    del second["from"], second["to"]
    second["values"] = ["free", "periodic"]
    claim = law(
        monkeypatch,
        lambda x, y, kind: 0.02 if y > 2 and x > 1.2 and kind == "periodic" else 0.0,
        nuisance=[OPEN, second],
        vary={"from": 1, "to": 2, "steps": 2},
    )
    record = judge_claim(claim, "full")
    assert {point.word for line in record.nuisances for point in line.points} == {"within"}
    assert any(point.word == "outside" for point in record.draws)
    assert record.verdict == IN_A_RANGE
    assert "periodic" in record.sentence


def test_a_claim_that_no_choice_decides_keeps_its_verdict(monkeypatch):
    assert judge_claim(law(monkeypatch, lambda *_: 0.0), "full").verdict == HOLDS
    assert judge_claim(law(monkeypatch, lambda *_: 0.5), "full").verdict == FAILS


def test_a_reading_that_works_saves_a_claim_from_failing(monkeypatch):
    """Not "fails": a choice that the statement allows makes it right."""
    reading = {"path": "kind", "name": "reading", "stated": "free", "reason": "Both are said."}
    reading |= {"values": ["free", "other"], "labels": ["as a whole", "in parts"]}
    claim = law(monkeypatch, lambda x, y, kind: 0.3 * (kind == "free"), nuisance=[reading])
    record = judge_claim(claim, "full")
    assert record.verdict == IN_A_RANGE
    said = "reading (as a whole above): as a whole +30\u202f% (outside), in parts "
    assert said in record.sentence


def test_draws_fill_the_range_and_are_the_same_every_day(monkeypatch):
    claim = law(monkeypatch, lambda *_: 0.0, draws=16)
    sample = shares(claim, "full")
    np.testing.assert_array_equal(sample, shares(claim, "full"))
    # of a Sobol sample, every sixteenth of the range has its draw
    assert set(np.floor(sample[:, 0] * 16)) == set(range(16))
    assert len(shares(claim, "quick")) == 2


RANGE = {"from": 0.1, "to": 20, "steps": 4, "spacing": "log"}


@pytest.mark.parametrize(
    ("outside", "lines", "draws", "mapped"),
    [
        (lambda x, y: x > 1, 0, 0, False),
        (lambda x, y: y > 6, 1, 0, False),
        (lambda x, y: x > 6 and y < 1 and y != 0.5, 1, 2, False),
        (lambda x, y: False, 1, 2, True),
    ],
    ids=["along its own parameter", "along what is left open", "in a draw", "nowhere"],
)
def test_a_quick_run_measures_no_more_once_a_claim_holds_in_a_range(
    monkeypatch, outside, lines, draws, mapped
):
    """What the statement leaves open, draws of it and the map, in this order; in full all three.

    Of the two draws the first has y = 0.7 and x = 10.
    """
    monkeypatch.setattr(runner, "shares", lambda *_: np.array([[0.027, 0.87], [0.5, 0.5]]))
    claim = law(
        monkeypatch, lambda x, y, kind: 0.02 * outside(x, y), vary=RANGE, map={"up": "y", "rows": 2}
    )
    record = judge_claim(claim, "quick")
    found = len(record.nuisances), len(record.draws), record.map is not None
    assert found == (lines, draws, mapped)
    full = judge_claim(claim, "full")
    assert (len(full.nuisances), len(full.draws), full.map is not None) == (1, 2, True)
    assert ("a full run finds" in record.sentence) == outside(20, 1)


def test_a_map_has_a_boundary_in_every_row(monkeypatch):
    """X y <= 4 within: at y the boundary is 4/y."""
    claim = law(
        monkeypatch,
        lambda x, y, kind: 0.02 * (x * y > 4),
        vary={"from": 0.1, "to": 20, "steps": 4, "spacing": "log", "bisections": 8},
        map={"up": "y", "rows": 3},
    )
    record = judge_claim(claim, "full")
    assert [row.number for row in record.map.rows] == [0.5, 4.25, 8.0]
    for row in record.map.rows:
        (stretch,) = row.ranges
        assert stretch.high <= 4 / row.number <= stretch.above
    figure = boundary_map(record)
    assert [series.look.label for series in figure.series] == ["within", "outside", "boundary"]
    assert np.isfinite(figure.series[-1].x).sum() == 6
    assert evidence(record, record.nuisances[0]) is not None


def test_rows_of_a_map_that_agree_are_told_once(monkeypatch):
    """X <= 4 within at every y: one range for all rows, not the same words three times."""
    claim = law(
        monkeypatch,
        lambda x, y, kind: 0.02 * (x > 4),
        vary={"from": 1, "to": 10, "steps": 4, "bisections": 0},
        map={"up": "y", "rows": 3},
    )
    assert (
        "by length y: 0.5, 4.25, 8: from 1 to 4 (not at 7)." in judge_claim(claim, "full").sentence
    )


def test_no_boundary_is_drawn_beside_a_point_that_is_not_resolved(monkeypatch):
    """Within at 1, open at 3 and 5 (a bar of 0.1): no boundary; outside at 10: one from 1 on."""

    def run(effort, *, x=1.0, y=1.0):
        error = 0.0 if x < 2 else 0.05 if x < 8 else 0.5 * y
        return Share(error, 1e-6 if x < 2 else 0.1, {}, "error")

    monkeypatch.setitem(EXPERIMENTS, "made-up", Experiment("made-up", "A law.", "x", run))
    varied = {"from": 1, "to": 10, "steps": 4, "bisections": 0}
    data = DATA | {
        "nuisance": [OPEN | {"from": 0.01, "stated": 0.01}],
        "map": {"up": "y", "rows": 2},
    }
    record = judge_claim(make_claim(data | {"vary": varied}, "a.toml", Path()), "full")
    boundary = boundary_map(record).series[-1]
    # at y = 0.01 all from 3 on is open; at 8 the last point is outside
    np.testing.assert_array_equal(boundary.x, [1, 10, np.nan])
    np.testing.assert_array_equal(boundary.y, [8, 8, 8])


@pytest.mark.parametrize(("stated", "word"), [(0.2, "within"), (0.05, "outside")])
def test_an_estimate_is_judged_by_its_order_of_magnitude(monkeypatch, stated, word):
    """A fifth of the truth is within a factor of 10, a twentieth is not; so are 5 and 20 times."""
    for ratio in (stated, 1 / stated):
        claim = law(
            monkeypatch, lambda *_, ratio=ratio: ratio - 1, nuisance=[], factor=10, tolerance=9
        )
        assert f"{word} a factor of 10" in judge_claim(claim, "full").sentence


def test_what_is_wrong_in_a_nuisance_is_told(monkeypatch):
    for wrong, said in (
        ({"stated": 9}, "between from and to"),
        ({"values": [1, 2]}, "either values, or from and to"),
        ({"to": 0.1}, "from < to"),
    ):
        with pytest.raises(ProblemsError, match=said):
            law(monkeypatch, lambda *_: 0.0, nuisance=[OPEN | wrong])
    with pytest.raises(ProblemsError, match="different nuisance parameters"):
        law(monkeypatch, lambda *_: 0.0, nuisance=[OPEN, OPEN])
    with pytest.raises(ProblemsError, match="a map of vary and a nuisance"):
        law(monkeypatch, lambda *_: 0.0, map={"up": "y"})
    with pytest.raises(ProblemsError, match="citation"):
        law(monkeypatch, lambda *_: 0.0, says="literature")


@lru_cache(maxsize=1)
def sampled():
    """Return twelve of the claims that leave numbers open, drawn with a seed, and their records."""
    claims = [claim for claim in load_claims() if claim.nuisance and claim.draws]
    chosen = np.random.default_rng(16).choice(len(claims), 12, replace=False)
    told = {claim.id: claim for claim in load_claims_record(STORED).claims}
    return [(claims[place], told[claims[place].id]) for place in chosen]


@pytest.mark.slow
@pytest.mark.parametrize("place", range(12))
def test_twenty_other_draws_of_what_is_left_open_give_the_recorded_verdict(place):
    """Another seed; of the bars of a quick run only what they resolve counts."""
    claim, told = sampled()[place]
    # a quick run takes an eighth of the draws
    more = claim.model_copy(update={"draws": 8 * 20})
    under = measured_under(more, "quick", {})
    sample = shares(more, "quick", seed=2026)
    draws = answer_of(together(drawn(more, share, under) for share in sample))
    assert len(draws) == 20
    # quick effort does not tell a claim that holds only as stated from one that holds in a range
    recorded = IN_A_RANGE if told.verdict == ONLY_AS_STATED else told.verdict
    if told.verdict == ONLY_AS_STATED:
        assert WITHIN not in [draw.word for draw in draws]
    words = [point.word for point in told.measured]
    for draw in draws:
        if draw.word in (WITHIN, OUTSIDE):
            assert verdict_of([*words, draw.word]) == recorded, draw
