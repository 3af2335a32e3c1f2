"""Pivoting against an oracle that never pivots, and where blocks of changes would cycle."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from reference.contact.pivot import compliance, pivot
from reference.errors import ConvergenceError


def body(n, seed, *, skew=False):
    """Return a positive definite matrix (symmetric or not) and gaps, some infinite, some equal."""
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(n, max(1, n // 2)))
    matrix = root @ root.T + 10.0 ** rng.uniform(-3, 1) * np.eye(n)
    if skew:
        turn = rng.normal(size=(n, n))
        matrix += turn - turn.T
    gap = np.round(np.abs(rng.normal(size=n)), rng.integers(1, 6))
    gap[rng.random(n) < 0.1] = np.inf
    gap[0] = 0.0
    return matrix, gap, rng.random(n) < rng.random()


@given(st.integers(1, 60), st.integers(0, 10**6), st.booleans(), st.sampled_from([1.0, 1e-9, 1e9]))
def test_nothing_overlaps_nothing_is_pulled_in_any_unit(n, seed, skew, unit):
    """Certified apart from the solver, for symmetric and other matrices; 1e-10 of the terms."""
    matrix, gap, start = body(n, seed, skew=skew)
    found = pivot(compliance(matrix), unit * gap, start & np.isfinite(gap), unit)
    clearance = matrix @ found.pressures + unit * gap - unit
    noise = 1e-10 * (np.abs(matrix) @ found.pressures).max()
    assert found.pressures.min() >= 0
    assert clearance.min() >= -noise
    assert np.abs(clearance[found.pressures > 0]).max() <= noise


@given(st.integers(1, 40), st.integers(0, 10**6))
def test_the_depth_of_a_force_has_that_force(n, seed):
    """Force control and its depth prescribed are one contact; slopes are that of a fixed set."""
    matrix, gap, start = body(n, seed)
    start &= np.isfinite(gap)
    by_force = pivot(compliance(matrix), gap, start, 2.0, per_depth=0.0, per_pressure=1.0)
    assert by_force.pressures.sum() == pytest.approx(2.0, rel=1e-10)
    by_depth = pivot(compliance(matrix), gap, start, by_force.depth)
    np.testing.assert_allclose(by_depth.pressures, by_force.pressures, atol=2e-8)
    inside = by_force.active
    slope = np.linalg.solve(matrix[np.ix_(inside, inside)], np.ones(inside.sum())).sum()
    assert by_force.slope == pytest.approx(slope, rel=1e-8)


# All changes at once return to the contact set of three rounds before.
CYCLING = np.array([[4.0, 5.0, -5.0], [-5.0, 4.0, 5.0], [5.0, -5.0, 4.0]])


@pytest.mark.parametrize("force", [0.0, 1.0])
def test_blocks_that_cycle_give_way_to_single_changes(force):
    """Positive definite, far from symmetric: the next point is wrong whenever one is pressed."""
    gap, start = np.zeros(3), np.array([True, False, False])
    found = pivot(
        compliance(CYCLING), gap, start, 1.0, per_depth=1.0 - force, per_pressure=force, patience=99
    )
    assert np.count_nonzero(found.history) > 1
    np.testing.assert_allclose(CYCLING @ found.pressures, found.depth, rtol=1e-12)


def test_blocks_that_undo_each_other_are_noticed():
    """Every block changes back and forth; the history shows the single changes that end it."""
    matrix, gap, _ = body(30, 4)
    expected = pivot(compliance(matrix), gap, np.isfinite(gap), 1.0)
    calls = []

    def back_and_forth(tension, overlap):
        calls.append(1)
        return tension & ~tension

    found = pivot(compliance(matrix), gap, np.isfinite(gap), 1.0, changes=back_and_forth)
    assert len(calls) == 1
    np.testing.assert_allclose(found.pressures, expected.pressures, atol=1e-12)


def test_too_few_rounds_and_overflows_are_errors_with_a_history():
    """A limit of one round, and gaps whose sum is beyond the largest number."""
    matrix, gap, start = body(30, 4)
    with pytest.raises(ConvergenceError, match="not found in 1 rounds") as caught:
        pivot(compliance(matrix), gap, start & np.isfinite(gap), 1.0, max_rounds=1)
    assert caught.value.history[0] > 0
    with pytest.raises(ConvergenceError, match="overflow"):
        pivot(compliance(1e-200 * np.eye(2)), np.zeros(2), np.ones(2, bool), 1e200)
