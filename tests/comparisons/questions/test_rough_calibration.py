"""Bars of rough surfaces against a grid eight times finer."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from comparisons.judging.uncertainty import SHARE_RULE, share_uncertainty
from comparisons.questions.calibration_cases import Case
from comparisons.questions.rough_calibration import FITTING, LEVELS, QUANTITIES, REPORTED, TRUTH
from comparisons.questions.shares import ROUGH, fitted_rule, scaled, with_rule
from reports.pages.calibration import calibration_page


def case(name: str, error: float, half: str = "fitting", levels=LEVELS, kind="free") -> Case:
    """Return a case whose last change is 10 % of the finer value, at one load."""
    curves = np.array([[1.2], [1.1], [1.0]])[-len(levels) :]
    errors, beside = np.array([error]), np.zeros(1)
    return Case(half, "a", "bem_fft", "force", name, kind, levels, errors, curves, beside)


def test_the_truth_is_eight_times_finer_and_the_halves_share_no_surface():
    assert 8 * LEVELS[-1] == TRUTH
    assert not set(FITTING) & set(REPORTED)
    kinds = [(s.get("hurst"), str(s.get("crop"))) for s in (*FITTING.values(), *REPORTED.values())]
    assert len(set(kinds[: len(FITTING)]) & set(kinds[len(FITTING) :])) == 0


@pytest.mark.parametrize("kind", ["free", "periodic"])
def test_the_bar_is_a_factor_times_the_last_change(kind):
    """10 % of change from N to 2 N; a step from N to 4 N changes three times as much (order 1)."""
    for name in QUANTITIES:
        factor = SHARE_RULE.factor((name, kind))
        assert case(name, 0.0, kind=kind).bar == pytest.approx(0.1 * factor)
        wide = np.array([32, 64, 256]), np.array([[1.1], [1.1], [1.0]])
        assert share_uncertainty(*wide, (name, kind))[0] == pytest.approx(0.1 * factor / 3)


def test_two_grids_have_a_wider_bar_for_no_third_tells_whether_their_change_is_small_by_chance():
    three, two = case("mean_gap", 0.0), case("mean_gap", 0.0, levels=LEVELS[1:])
    assert two.bar == pytest.approx(SHARE_RULE.two * three.bar)
    # 8 % before: second order at best leaves 2 % of change, third 1 %, however small the last one
    for quantity, left in ((("stiffness", "free"), 0.02), (("mean_gap", "free"), 0.01)):
        lucky = share_uncertainty(np.array(LEVELS), np.array([[1.08], [1.0], [1.0]]), quantity)
        assert lucky[0] == pytest.approx(left * SHARE_RULE.factor(quantity))


def test_a_counted_area_beside_the_located_one_is_what_its_bar_is_from():
    """Cells 6 % too many: 0.45 of 0.06^1.5; a change that is much larger: a third of it.

    And on 64 cells a side two strips of 0.175 cells, four where there is a rim.
    """
    area = replace(case("contact_area", 0.0, kind="periodic"), counted=np.array([1.06]))
    assert area.bar == pytest.approx(0.1 / 3)
    close, strip = replace(area, curves=np.array([[1.0], [1.0], [1.0]])), 0.17465 / 64
    assert close.bar == pytest.approx(0.45 * 0.06**1.5 + 2 * strip)
    assert replace(close, kind="free").bar - close.bar == pytest.approx(2 * strip)


def test_other_widths_are_those_of_all_bars_whatever_their_rule():
    made = [case(name, 0.05) for name in QUANTITIES]
    made.append(replace(case("contact_area", 0.05), counted=np.array([1.06])))
    for before, after in zip(made, scaled(made, 1.2), strict=True):
        assert after.bar == pytest.approx(1.2 * before.bar)


def test_one_grid_leaves_the_bar_unknown():
    bar = share_uncertainty(np.array([32]), np.ones((1, 2)), ("stiffness", "free"))
    assert np.isnan(bar).all()


def test_the_fit_takes_the_smallest_factor_that_covers():
    """Errors of 17 % of the change ask for a factor of 1.7; the reported half has no say.

    Raised by its margin; with two grids errors of 34 % ask for twice that.
    """
    three = [case("stiffness", 0.169), case("stiffness", 0.01), case("stiffness", 9.0, "reported")]
    two = [case("stiffness", 0.339, levels=LEVELS[1:])]
    rule = fitted_rule([*three, *two])
    assert rule.factor(("stiffness", "free")) == pytest.approx(ROUGH[1] * 1.7)
    assert rule.two == 2.0
    assert with_rule(three[0], rule).bar == pytest.approx(0.17 * ROUGH[1])
    for name in QUANTITIES:  # of what there are no cases, or none that is covered
        other = (name, "periodic")
        assert rule.factor(other) == pytest.approx(SHARE_RULE.factor(other))
    assert fitted_rule([case("mean_gap", 9.0)]) == SHARE_RULE


def test_the_page_tells_rough_surfaces_apart():
    made = [case(name, 0.05, half) for name in QUANTITIES for half in ("reported", "fitting")]
    single = [replace(part, kind="cells") for part in made]
    page = calibration_page([*single, *made], "roughline calibrate")
    assert "Rough surfaces, reported half: the bar covers the true error in 100.0 % of 4" in page
    assert "Single contacts, reported half: the bar" in page
