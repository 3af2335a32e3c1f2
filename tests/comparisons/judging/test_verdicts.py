"""The one rule: within, outside or not resolved, and the load step that decides."""

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from comparisons.judging.verdicts import judged

# Binary fractions, of which sums and differences are exact: also at the boundaries.
error = st.one_of(st.integers(-64, 64).map(lambda k: k / 64), st.sampled_from([math.nan, math.inf]))
bar = st.one_of(st.integers(0, 64).map(lambda k: k / 64), st.just(math.nan))


@given(
    steps=st.lists(st.tuples(error, bar), min_size=1, max_size=5),
    tolerance=st.integers(1, 63).map(lambda k: k / 64),
)
@example(steps=[(0.25, 0.25)], tolerance=0.5)  # |e| + u = t holds
@example(steps=[(0.75, 0.25)], tolerance=0.5)  # |e| - u = t does not fail
@example(steps=[(0.25, 0.2500001)], tolerance=0.5)
@example(steps=[(-0.7500001, 0.25)], tolerance=0.5)
@example(steps=[(10.0, math.nan)], tolerance=0.01)  # an unknown bar resolves nothing
@example(steps=[(math.nan, 0.0), (0.001, 0.0)], tolerance=0.01)  # a lost step may be anything
@example(steps=[(math.nan, 0.0), (0.1, 0.0)], tolerance=0.01)  # but outside is outside
def test_a_verdict_is_that_of_the_step_it_stands_on(steps, tolerance):
    """Outside is the surest miss, |e| - u > t; else the widest reach, |e| + u <= t, decides."""
    known = {k: (abs(e), u) for k, (e, u) in enumerate(steps) if math.isfinite(e)}
    least = {k: e - u for k, (e, u) in known.items() if not math.isnan(u)}
    reach = {k: math.inf if math.isnan(u) else e + u for k, (e, u) in known.items()}
    if not known:
        word = "no result"
    elif any(miss > tolerance for miss in least.values()):
        word = "outside"
    elif len(known) == len(steps) and max(reach.values()) <= tolerance:
        word = "within"
    else:
        word = "not resolved"
    told = judged(*np.array(steps).T, tolerance)
    assert told.word == word
    if known:
        ranks = least if word == "outside" else reach
        assert ranks[told.step] == max(ranks.values())
        assert told.error == steps[told.step][0]


@pytest.mark.parametrize(
    ("errors", "bars", "step"),
    [
        ([0.002, 0.004, 0.003], [np.nan, 0.0, np.nan], 2),  # of unknown bars the larger error
        ([0.01, 0.01 * (1 + 1e-15)], [0.0, 0.0], 0),  # alike: the same step on every processor
    ],
)
def test_between_steps_that_are_alike_the_larger_error_or_the_first_decides(errors, bars, step):
    assert judged(errors, bars, 0.02).step == step
