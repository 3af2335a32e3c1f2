"""The experiments on (19.1) find what closed forms say of it, and refuse what has no meaning."""

from __future__ import annotations

import math

import pytest

from comparisons.errors import InputError
from comparisons.questions.experiments import EXPERIMENTS


def measure(name, value, effort="quick", **parameters):
    return EXPERIMENTS[name].measure(value, effort, **parameters)


def test_a_block_creeps_and_lacks_friction_as_the_law_says():
    """At half the limit tan(pi/4) v0; (2/pi) arctan(v0/V) of the friction; 4/pi v0/V of the way."""
    assert measure("regularised-block", 200.0).error == pytest.approx(1 / 200, rel=1e-12)
    lacking = measure("regularised-block", 200.0, quantity="kinetic").error
    assert lacking == pytest.approx(-2 / math.pi * math.atan(1 / 200), rel=1e-12)
    way = measure("regularised-block", 1e4, quantity="way")
    # the next term of the way is of the order v0^2 log v0
    assert way.error == pytest.approx(4 / math.pi * 1e-4, rel=2e-3)
    assert way.uncertainty < 1e-3 * way.error


def test_the_bars_of_quick_runs_hold_what_full_runs_find():
    """Twice as many steps: the change lies inside the bar of the coarser run, or near round-off."""
    for name, value in (("regularised-stick-slip", 1e3), ("regularised-belt", 1.2)):
        quick, full = (measure(name, value, effort) for effort in ("quick", "full"))
        assert abs(quick.error - full.error) <= quick.uncertainty + full.uncertainty


def test_without_a_difference_of_frictions_the_law_still_damps_the_swing():
    """Friction that rises with the speed takes energy; a smaller v0 takes less."""
    coarse = measure("regularised-belt", 1.0, speed_ratio=1e2).error
    fine = measure("regularised-belt", 1.0, speed_ratio=1e4).error
    assert coarse < fine < 0


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["explicit_euler", "runge_kutta_4"])
def test_the_step_of_theory_is_the_step_found(scheme):
    measured = measure("explicit-friction-step", 0.8, scheme=scheme)
    assert abs(measured.error) < 1e-3 + measured.uncertainty


def test_what_has_no_meaning_is_refused():
    for name, value, parameters in (
        ("regularised-block", -1.0, {}),
        ("regularised-block", 10.0, {"load": 1.0}),
        ("regularised-block", 10.0, {"quantity": "speed"}),
        ("regularised-stick-slip", 10.0, {"limit": 2.0}),
        ("regularised-belt", 0.5, {}),
        ("explicit-friction-step", 1.5, {}),
    ):
        with pytest.raises(InputError, match=name):
            measure(name, value, **parameters)
