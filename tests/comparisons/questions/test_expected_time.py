"""How long a plan of full effort would take, from solves on its coarse grids."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from comparisons.questions import expected_time
from comparisons.solving.planning import plan_all

OVERRIDES = {"compare.methods": ["bem_fft"], "compare.quantities": ["force"]}


@pytest.fixture
def solves(monkeypatch):
    """Answer in 10 ms at N = 8, and in 4.7 times the time for each doubling, as FFT BEM grows."""
    asked = []

    def execute(task, repeats):
        asked.append(task.resolution)
        return SimpleNamespace(seconds=0.01 * 4.7 ** (task.resolution.bit_length() - 4))

    monkeypatch.setattr(expected_time, "execute", execute)
    return asked


def test_coarse_grids_are_timed_and_finer_ones_follow_the_growth_of_work(solves):
    (plan,) = plan_all(("square-punch",), OVERRIDES, "full")
    expected = expected_time.expected_time(plan)
    grids = [task.resolution for task in plan.tasks]
    times = [0.01 * 4.7 ** (n.bit_length() - 4) for n in grids]
    assert expected.planned == pytest.approx(sum(times))
    assert expected.refined[0] == (2 * grids[-1], pytest.approx(4.7 * times[-1]))
    assert all(seconds <= 600.0 for _, seconds in expected.refined)
    # no grid is timed beyond the first that takes long enough to be scaled from
    assert all(0.01 * 4.7 ** (n.bit_length() - 4) < 0.2 for n in solves[:-1])
    assert "also FFT BEM at N = " in expected.sentence(plan)


def test_nothing_is_refined_beside_a_closed_form_or_beyond_listed_grids(solves):
    (round_one,) = plan_all(("paraboloid",), {}, "full")
    assert expected_time.expected_time(round_one).refined == ()
    (listed,) = plan_all(("square-punch",), OVERRIDES | {"compare.resolutions": [8]}, "full")
    assert "lists its resolutions" in expected_time.expected_time(listed).sentence(listed)
