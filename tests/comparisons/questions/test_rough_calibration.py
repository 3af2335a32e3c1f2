"""Bars of rough surfaces against a grid eight times finer."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from comparisons.judging.uncertainty import ROUGH_RULE, rough_uncertainty
from comparisons.questions.calibration_cases import Case
from comparisons.questions.rough_calibration import (
    FITTING,
    LEVELS,
    QUANTITIES,
    REPORTED,
    TRUTH,
    fitted_factors,
    with_rule,
)
from reports.pages.calibration import calibration_page


def case(name: str, error: float, half: str = "fitting") -> Case:
    """Return a case whose last change is 10 % of the finer value, at one load."""
    curves = np.array([[1.1], [1.0]])
    bars = rough_uncertainty(np.array(LEVELS), curves, name)
    errors, beside = np.array([error]), np.zeros(1)
    return Case(
        half, "a", "bem_fft", "force", name, LEVELS, errors, bars, curves, beside, rough=True
    )


def test_the_truth_is_eight_times_finer_and_the_halves_share_no_surface():
    assert 8 * LEVELS[-1] == TRUTH
    assert not set(FITTING) & set(REPORTED)
    kinds = [(s.get("hurst"), str(s.get("crop"))) for s in (*FITTING.values(), *REPORTED.values())]
    assert len(set(kinds[: len(FITTING)]) & set(kinds[len(FITTING) :])) == 0


def test_the_bar_is_a_factor_times_the_last_change():
    """10 % of change from N to 2 N; a step from N to 4 N changes three times as much (order 1)."""
    for name in QUANTITIES:
        factor = ROUGH_RULE.factor(name)
        assert case(name, 0.0).bar == pytest.approx(0.1 * factor)
        wide = rough_uncertainty(np.array([32, 128]), np.array([[1.1], [1.0]]), name)
        assert wide[0] == pytest.approx(0.1 * factor / 3)


def test_one_grid_leaves_the_bar_unknown():
    assert np.isnan(rough_uncertainty(np.array([32]), np.ones((1, 2)), "stiffness")).all()


def test_the_fit_takes_the_smallest_factor_that_covers():
    """Errors of 17 % of the change ask for a factor of 1.7; the reported half has no say."""
    made = [case("stiffness", 0.169), case("stiffness", 0.01), case("stiffness", 9.0, "reported")]
    assert fitted_factors(made) == {"stiffness": 1.7}
    assert fitted_factors([case("mean_gap", 9.0)]) == {}
    wider = replace(ROUGH_RULE, factors=(("stiffness", 4.0),))
    assert with_rule(made[0], wider).bar == pytest.approx(0.4)


def test_the_page_tells_rough_surfaces_apart():
    made = [case(name, 0.05, half) for name in QUANTITIES for half in ("reported", "fitting")]
    single = [replace(each, rough=False, resolutions=(8, 16)) for each in made]
    page = calibration_page([*single, *made], "roughline calibrate")
    assert "Rough surfaces, reported half: the bar covers the true error in 100.0 % of 4" in page
    assert "Single contacts, reported half: the bar" in page
