"""Closed forms of adhesion: known pull-offs, relations between formulas, Maugis' limits."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from reference import closed_form
from reference.closed_form.adhesive import (
    AdhesiveForm,
    MaugisForm,
    strength_of,
)

W, E = 0.02, 1.7
FORMS = {
    "paraboloid": (AdhesiveForm(closed_form.paraboloid(2.0, E), W), (0.2, 1.0)),
    "cone": (AdhesiveForm(closed_form.cone(0.3, E), W), (0.05, 2.0)),
    "quartic": (AdhesiveForm(closed_form.power_law(4, 0.3, E), W), (0.2, 1.5)),
    "sphere": (AdhesiveForm(closed_form.sphere(1.0, E), W), (0.1, 0.9)),
    "rounded": (AdhesiveForm(closed_form.rounded_punch(1.0, 2.0, E), W), (1.001, 3.0)),
}


def test_pull_off_of_a_paraboloid():
    """-(3/2) pi w R, -(5/6) pi w R; contact radii (9 pi w R^2/(8 E*))^(1/3) and a ninth inside."""
    form = FORMS["paraboloid"][0]
    for control, share, ninth in (("force", -1.5, 9), ("penetration", -5 / 6, 1)):
        a = form.pull_off(control)
        assert float(form.force(a)) == pytest.approx(share * np.pi * W * 2.0, rel=1e-13)
        assert a == pytest.approx(np.cbrt(ninth * np.pi * W * 4.0 / (8 * E)), rel=1e-13)


def test_zero_load_of_a_paraboloid():
    """a^3 = 9 pi w R^2/(2 E*) at F = 0, four times that of pull-off (Johnson 1985, sec. 5.5)."""
    form = FORMS["paraboloid"][0]
    assert form.snap_in("force") ** 3 == pytest.approx(4.5 * np.pi * W * 4.0 / E, rel=1e-13)
    assert float(form.penetration(form.snap_in())) == pytest.approx(0, abs=1e-14)


@pytest.mark.parametrize("name", list(FORMS))
def test_the_contact_is_lost_at_the_lowest_load(name):
    """The fold is where a search finds the minimum (xatol 1e-9: the load to its square)."""
    form, bounds = FORMS[name]
    for control, law in (("force", form.force), ("penetration", form.penetration)):
        minimum = minimize_scalar(law, bounds=bounds, method="bounded", options={"xatol": 1e-9})
        assert form.pull_off(control) == pytest.approx(minimum.x, rel=1e-5)
        assert float(law(form.pull_off(control))) == pytest.approx(minimum.fun, rel=1e-12)


@pytest.mark.parametrize("name", list(FORMS))
def test_without_adhesion_force_follows_depth(name):
    """dF0/da = 2 E* a dd0/da for every contact; central differences of 1e-5 err by 1e-9."""
    form, (low, high) = FORMS[name][0]._laws, FORMS[name][1]
    a = np.linspace(low, high, 7)[1:-1]
    step = 1e-5
    depth_rate = (form.depth(a + step) - form.depth(a - step)) / (2 * step)
    load_rate = (form.load(a + step) - form.load(a - step)) / (2 * step)
    np.testing.assert_allclose(depth_rate, form.rate(a), rtol=1e-7)
    np.testing.assert_allclose(load_rate, 2 * E * a * form.rate(a), rtol=1e-7)


def test_a_flat_punch_is_a_rounded_one_of_a_sharp_edge():
    """As the edge radius goes to zero, pull-off tends to Kendall's from below."""
    kendall = AdhesiveForm(closed_form.cylinder(1.0, E), W)
    exact = float(kendall.force(kendall.pull_off()))
    assert exact == pytest.approx(-np.sqrt(8 * np.pi * E * W), rel=1e-14)
    result = []
    for edge in (1e-2, 1e-4, 1e-6):
        form = AdhesiveForm(closed_form.rounded_punch(1.0, edge, E), W)
        result.append(float(form.force(form.pull_off())) / exact - 1)
    assert result[0] > result[1] > result[2] > 0
    assert result[2] < 1e-3


def test_maugis_of_short_range_is_johnson_kendall_roberts():
    """Pull-off forces and depths approach as 1/lambda^2 and faster."""
    jkr = AdhesiveForm(closed_form.paraboloid(2.0, E), W)
    for control in ("force", "penetration"):
        errors = []
        for parameter in (5.0, 20.0):
            form = MaugisForm(2.0, E, W, strength_of(2.0, E, W, parameter))
            ratio = form.force(form.pull_off(control)) / jkr.force(jkr.pull_off(control))
            errors.append(float(ratio) - 1)
        assert 0 < errors[1] < 1e-3
        assert errors[0] / errors[1] > 12


def test_maugis_of_long_range_is_derjaguin_muller_toporov():
    """Pull-off tends to -2 pi w R as lambda goes to zero, the force to Hertz's less that."""
    form = MaugisForm(2.0, E, W, strength_of(2.0, E, W, 1e-3))
    assert float(form.force(form.pull_off())) == pytest.approx(-2 * np.pi * W * 2.0, rel=2e-3)
    a = 3 * form.units()[0]
    hertz = 4 / 3 * E * a**3 / 2.0
    assert float(form.force(a)) == pytest.approx(hertz - 2 * np.pi * W * 2.0, rel=2e-3)


def test_faults_are_named():
    with pytest.raises(ValueError, match="work must be"):
        AdhesiveForm(closed_form.sphere(1.0, 1.0), 0.0)
    with pytest.raises(ValueError, match="above 1/2"):
        AdhesiveForm(closed_form.power_law(0.5, 1.0, 1.0), 1.0)
    with pytest.raises(ValueError, match="control must be"):
        FORMS["cone"][0].pull_off("time")
