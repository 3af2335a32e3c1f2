"""The modulus of a measured force-depth curve."""

import numpy as np
import pytest

from comparisons.errors import InputError
from comparisons.questions.study import solved_in_memory
from comparisons.results.measured import fit_modulus, modulus_fits, modulus_sentence
from comparisons.results.scene_record import record_scene
from comparisons.solving.planning import plan_all
from reports.plots.curves import measured

MODULUS, RADIUS = 1e9, 1e-3


def hertz(depth, modulus=MODULUS):
    return 4 / 3 * modulus * np.sqrt(RADIUS) * np.maximum(depth, 0.0) ** 1.5


COMPUTED = (np.geomspace(5e-7, 1e-5, 8), hertz(np.geomspace(5e-7, 1e-5, 8)))


def test_the_interval_holds_the_modulus_of_noisy_hertz_as_often_as_it_says():
    """Of 100 fits 95 % contain it: 95 +- 2.2, of which five standard deviations are left."""
    depth, held = np.linspace(2e-7, 9e-6, 60), 0
    for seed in range(100):
        noise = np.random.default_rng(seed).normal(0, 0.01 * hertz(9e-6), len(depth))
        force = hertz(depth - 1e-7, 1.3 * MODULUS) + noise
        fit = fit_modulus((depth, force), COMPUTED, MODULUS, fit_zero=True)
        held += abs(fit.modulus - 1.3 * MODULUS) <= fit.half_width
    assert held >= 84


def test_a_fitted_zero_is_the_depth_at_first_touch():
    depth = np.linspace(0.0, 9e-6, 60)
    data = depth, hertz(depth - 4e-7, 2 * MODULUS)
    moved = fit_modulus(data, COMPUTED, MODULUS, fit_zero=True)
    assert moved.modulus == pytest.approx(2 * MODULUS, rel=1e-6)  # the power law is exact
    assert moved.zero == pytest.approx(4e-7, rel=1e-5)
    # a zero that is wrong and held makes the body softer than it is
    assert fit_modulus(data, COMPUTED, MODULUS).modulus < 1.95 * MODULUS


def test_points_beyond_the_computed_depths_are_no_evidence():
    depth = np.linspace(1e-6, 1e-4, 50)
    assert fit_modulus((depth, 0.0 * depth), COMPUTED, MODULUS).used == 5
    assert fit_modulus((depth + 1e-4, depth), COMPUTED, MODULUS) is None


def test_depths_count_from_the_fitted_first_touch():
    """A body that yields beyond the computed loads: moved by a fifth, none of it is fitted."""
    deepest = COMPUTED[0][-1]
    depth = np.linspace(1e-7, 1.4 * deepest, 141)
    force = np.minimum(hertz(depth), hertz(deepest))
    for shift in (-0.2 * deepest, 0.2 * deepest):
        fit = fit_modulus((depth + shift, force), COMPUTED, MODULUS, fit_zero=True)
        # Where the last of them is counted in or out hangs on the last digit.
        assert fit.used == pytest.approx(np.sum(depth <= deepest), abs=1)
        assert fit.modulus == pytest.approx(MODULUS, rel=1e-5)
        assert fit.zero == pytest.approx(shift, rel=1e-4)


SCENE = {
    "name": "indented",
    "half_space": {"effective_modulus": "1 GPa"},
    "indenter": {"shape": "paraboloid", "radius": "1 mm"},
    "loading": {"penetration": {"from": "0.5 um", "to": "10 um", "steps": 5, "spacing": "log"}},
    "compare": {"measured": "curve.csv", "methods": ["closed_form", "reduced"]},
}


def planned(tmp_path, monkeypatch, text, **tables):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "curve.csv").write_text(text, encoding="utf-8")
    return plan_all((SCENE | tables,), {}, "quick")


def test_a_scene_with_a_measured_curve_says_its_modulus(tmp_path, monkeypatch):
    """Decimal commas, semicolons, units in the heads, a third column: as instruments write."""
    depth = np.linspace(1e-6, 9e-6, 12)
    lines = ["t / s; penetration / nm; force / mN"]
    lines += [
        f"0; {d * 1e9:.6f}; {f * 1e3:.9f}" for d, f in zip(depth, hertz(depth, 1.2e9), strict=True)
    ]
    (plan,) = planned(tmp_path, monkeypatch, "\n".join(lines).replace(".", ","))
    record = record_scene(*solved_in_memory(plan, "quick"))
    fits = modulus_fits(record)
    assert set(fits) == {"reduced", "closed_form"}
    assert fits["reduced"].modulus == pytest.approx(1.2e9, rel=1e-6)
    assert "1.200 \N{PLUS-MINUS SIGN}" in modulus_sentence(record)
    figure = measured(record)
    assert [series.look.label for series in figure.series] == [
        *("measured", "closed form, fitted", "reduced model, fitted")
    ]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("depth,load\n1,2\n", "expected one column penetration"),
        ("penetration / N,force / N\n1,2\n1,2\n1,2\n", "column penetration: "),
        ("penetration,force\n1,2\n", "expected 3 to 20000 points, got 1"),
        ("penetration,force\n1,2\n2,x\n3,4\n", "expected numbers below the first line"),
        ("penetration,force\n1,-2\n2,-2\n3,-4\n", "expected some positive (compressive) forces"),
        ("", "expected one column force"),
    ],
)
def test_a_file_that_is_no_curve_is_told(tmp_path, monkeypatch, text, said):
    with pytest.raises(InputError, match=r"compare\.measured: curve\.csv: ") as error:
        planned(tmp_path, monkeypatch, text)
    assert said in str(error.value)


def test_a_force_that_is_not_proportional_to_the_modulus_is_refused(tmp_path, monkeypatch):
    with pytest.raises(InputError, match=r"compare\.measured: expected an"):
        planned(tmp_path, monkeypatch, "", adhesion={"work": 0.1})


def test_a_force_that_falls_with_the_depth_has_no_modulus():
    depth = np.linspace(0.1, 0.9, 20) * COMPUTED[0][-1]
    assert fit_modulus((depth, depth[::-1] * 1e3), COMPUTED, MODULUS, fit_zero=True) is None
