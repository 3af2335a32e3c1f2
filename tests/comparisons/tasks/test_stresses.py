"""Peak pressure, stresses inside and pressures at earlier loads, as every method gives them."""

import numpy as np
import pytest
from scipy.special import ellipe, ellipeinc, ellipk, ellipkinc

from comparisons.facts.quantities.rows import HALF_AXES
from comparisons.judging.truth import candidate
from comparisons.methods.normal import grid
from comparisons.results.record import field_problems
from comparisons.solving.execution import execute
from comparisons.solving.plan import task_of
from comparisons.solving.planning import plan_scene
from comparisons.tasks import stresses
from comparisons.tasks.shown_loads import MOST_STEPS, at_step, shown, shown_steps, stored_steps
from reference import closed_form as forms

PEAK = {"quantities": ["pressure", "pressure_peak"]}
INSIDE = ["shear_max", "shear_max_depth", "von_mises_max", "von_mises_depth"]
NAMES = ["pressure_mean", "pressure_peak", "shear_max", "von_mises_max", "von_mises_depth"]


@pytest.fixture
def quantities(curves):
    """Return what a method gives at the last load, for which N is chosen."""
    return lambda *asked: {name: values[-1] for name, values in curves(*asked).items()}


@pytest.mark.slow
def test_every_method_finds_what_hertz_says_of_a_ball(scene, quantities):
    """p0 = 3 F/(2 pi a^2); 0.310 p0 of shear and 0.620 p0 of von Mises, 0.48 a deep, at nu = 0.3.

    Closed form and springs are laid on 32 cells per radius: 3e-4. On 16 cells stresses err by
    1.2e-3, the largest of the pressures by a quarter of a cell's square, 1e-3; four elements per
    radius by per cents.
    """
    table = {"youngs_modulus": 210e9, "poisson_ratio": 0.3}
    ball = scene(half_space=table, compare={"quantities": ["force", *NAMES]})
    for method, resolution, share in (
        *(("closed_form", 1, 1e-3), ("reduced", 100, 1e-3)),
        *(("bem_fft", 16, 5e-3), ("fem", 4, 0.05)),
    ):
        got = quantities(ball, method, resolution)
        radius = np.sqrt(got["contact_area"] / np.pi)
        mean = got["force"] / (np.pi * radius**2)
        assert got["pressure_mean"] == pytest.approx(mean)
        assert got["pressure_peak"] == pytest.approx(1.5 * mean, rel=share)
        assert got["shear_max"] == pytest.approx(0.310 * 1.5 * mean, rel=share)
        assert got["von_mises_max"] == pytest.approx(0.620 * 1.5 * mean, rel=share)
        assert got["von_mises_depth"] == pytest.approx(0.481 * radius, rel=0.02 + share)


def test_what_is_unbounded_below_a_sharp_edge_or_tip_is_not_given(scene, quantities):
    for indenter in ({"shape": "cylinder", "radius": 1e-2}, {"shape": "cone", "slope": 0.1}):
        sharp = scene(indenter=indenter, compare={"quantities": NAMES})
        assert set(NAMES) & set(quantities(sharp, "closed_form")) == {"pressure_mean"}


def test_the_peak_is_that_of_all_cells_where_fields_are_means_over_blocks(
    scene, solved, quantities, monkeypatch
):
    """As it is on maps of more than 2^20 cells, on a small one."""
    rough = {"kind": "self_affine", "size": 1e-3, "points": 32, "hurst": 0.8, "rms_height": 1e-6}
    patch = scene(surface=rough, loading={"pressure": 1e8}, compare=PEAK)
    whole = quantities(patch, "bem_fft", 32)["pressure_peak"]
    monkeypatch.setattr(grid, "MOST_POINTS", 256)
    monkeypatch.setattr(grid, "SIDE", 16)
    solution = solved(patch, "bem_fft", 32)
    # a field is kept in single precision, where it is kept
    assert solution.quantities["pressure_peak"][0, -1] == pytest.approx(whole, rel=1e-6)
    assert solution.fields["pressure"].max() < 0.9 * whole


def test_of_a_rough_surface_cells_and_waves_give_the_stress(scene, quantities):
    """A light load, periodic and on a free patch: stresses are of the order of pressures."""
    rough = {"kind": "self_affine", "size": 1e-3, "points": 16, "hurst": 0.8, "rms_height": 1e-6}
    for periodic in (True, False):
        table = rough | {"seed": 1, "periodic": periodic}
        patch = scene(surface=table, loading={"pressure": 1e8}, compare={"quantities": NAMES})
        got = quantities(patch, "bem_fft", 16)
        assert got["pressure_peak"] > got["pressure_mean"] > 1e8
        # principal stresses differ by no more than the largest pressure, but at edges
        assert 0.2 < got["von_mises_max"] / got["pressure_peak"] < 1.0
        assert got["shear_max"] == pytest.approx(got["von_mises_max"] / np.sqrt(3), rel=0.16)


@pytest.mark.parametrize(
    ("method", "resolution", "share"),
    [("bem_fft", 16, 2e-3), ("bem_dense", 8, 5e-3), ("fem", 4, 1e-3)],
)
def test_half_axes_of_an_ellipse_are_those_of_hertz(scene, quantities, method, resolution, share):
    """R_y/R_x = ((b/a)^2 E - K)/(K - E) (Johnson 1985, 4.28), b along y; no ball has them."""
    shape = {"shape": "ellipsoid", "radius_x": 1e-2, "radius_y": 3e-2}
    oval = scene(indenter=shape, compare={"quantities": ["force", *HALF_AXES]})
    exact, found = quantities(oval, "closed_form"), quantities(oval, method, resolution)
    short, long = (exact[name] for name in HALF_AXES)
    E, K = (of(1 - (short / long) ** 2) for of in (ellipe, ellipk))
    assert ((long / short) ** 2 * E - K) / (K - E) == pytest.approx(3.0)
    assert np.pi * short * long == pytest.approx(exact["contact_area"])
    for name in HALF_AXES:
        assert found[name] == pytest.approx(exact[name], rel=share)
    ball = scene(compare={"quantities": ["force"]})
    assert not {*HALF_AXES} & {*quantities(ball, "closed_form")}


def closed_form(scene, **tables):
    """Return what the closed form knows at one load: name -> (value, its relative bar)."""
    asked = {"quantities": ["pressure_peak", *INSIDE]}
    (plan,) = plan_scene(scene(loading={"penetration": 1e-6}, compare=asked, **tables))
    solution = execute(task_of(plan, "closed_form", 1), 1)
    truth = candidate({("closed_form", 1): solution}, "closed_form", "penetration")
    return {name: (truth.curves[name][0], truth.bar(name)[0]) for name in asked["quantities"]}


def below_ellipse(z, a, b, nu):
    """Return the principal stresses below the centre of Hertz's ellipse, a > b, p0 = 1.

    Johnson 1985, eq. (4.46); Sackfield & Hills 1983.
    """
    e2, zeta = 1 - (b / a) ** 2, z / a
    T, angle = np.sqrt((b**2 + z**2) / (a**2 + z**2)), np.arctan2(1, zeta)
    F, E, k = ellipkinc(angle, e2), ellipeinc(angle, e2), (a / b) ** 2
    x = -(1 - T) / 2 + zeta * (F - E) + nu * (1 - k * T + zeta * (k * E - F))
    y = 0.5 / T + 0.5 - T * k + zeta * (k * E - F) + nu * (-1 + T + zeta * (F - E))
    return b / (a * e2) * np.array([2 * x, 2 * y, -(1 - T**2) / T])


@pytest.mark.parametrize(
    ("nu", "slender"), [(0.25, 2.0), (0.3, 1.0), (0.3, 10.0), (0.4, 2.0), (0.5, 10.0)]
)
def test_bars_of_a_closed_form_cover_what_hertz_says_below_its_centre(scene, nu, slender):
    """At these ratios both stresses are largest on the axis, or beside it by less than the bar.

    Bars of a fifth of a per cent to a half tell verdicts of one per cent; of depths, twice that.
    The peak lies in the centre, where the pressure is taken.
    """
    shape = {"shape": "ellipsoid", "radius_x": slender * 1e-2, "radius_y": 1e-2}
    table = {"youngs_modulus": 1e9, "poisson_ratio": nu}
    known = closed_form(scene, indenter=shape, half_space=table)
    form = forms.ellipsoid(slender * 1e-2, 1e-2 * (1 - 1e-9), 1e9 / (1 - nu**2))
    a, b = form.semi_axes(1e-6)
    peak = form.pressure(0.0, 0.0, 1e-6)
    z = np.linspace(0.01, 2, 20_001) * b
    stress = peak * below_ellipse(z, a, b, nu)
    shear = np.ptp(stress, axis=0) / 2
    mises = np.sqrt(np.sum((stress - np.roll(stress, 1, axis=0)) ** 2, axis=0) / 2)
    assert known["pressure_peak"] == pytest.approx((peak, 0.0), rel=1e-8, abs=1e-8)
    for curve, name in (shear, "shear_max"), (mises, "von_mises_max"):
        value, bar = known[name]
        assert abs(curve.max() / value - 1) < bar < 5e-3
        depth, bar = known[INSIDE[INSIDE.index(name) + 1]]
        assert abs(z[curve.argmax()] / depth - 1) < bar < 2e-2


@pytest.mark.slow
@pytest.mark.parametrize("nu", [0.0, 0.3])
@pytest.mark.parametrize(
    "shape",
    [
        {"shape": "power_law", "exponent": 1.1, "coefficient": 0.1},
        {"shape": "power_law", "exponent": 6.0, "coefficient": 1e10},
        {"shape": "rounded_punch", "flat_radius": 1e-4, "edge_radius": 1e-3},
        {"shape": "rounded_punch", "flat_radius": 1e-3, "edge_radius": 1e-3},
    ],
    ids=["pointed", "flattened", "rounded", "sharp"],
)
def test_bars_grow_where_stresses_are_near_a_tip_an_edge_or_the_surface(
    scene, monkeypatch, shape, nu
):
    """Against four times as many cells, whose errors are a fourth or less."""
    tables = {"indenter": shape, "half_space": {"youngs_modulus": 1e9, "poisson_ratio": nu}}
    known = closed_form(scene, **tables)
    monkeypatch.setattr(stresses, "_CELLS", 128)
    fine = closed_form(scene, **tables)
    for name in INSIDE:
        value, bar = known[name]
        assert np.isnan(bar) or abs(fine[name][0] / value - 1) < bar


@pytest.fixture
def pressed(scene, solved):
    def press(method, *depths):
        asked = {"loading": {"penetration": depths}, "compare": {"quantities": ["pressure"]}}
        made = scene(half_space={"effective_modulus": 1e9}, **asked)
        return solved(made, method, {"closed_form": 1, "fem": 2}.get(method, 10))

    return press


@pytest.mark.parametrize("method", ["closed_form", "reduced", "bem_fft", "bem_dense", "fem"])
def test_every_method_stores_hertz_pressure_at_every_load(pressed, method):
    """p0 = 2 E* a/(pi R), a = sqrt(R d): each step's peak within the grid's own error (10 %)."""
    solution = pressed(method, 2e-6, 4e-6, 8e-6)
    assert stored_steps(solution.fields) == [0, 1]
    for step, depth in enumerate((2e-6, 4e-6)):
        fields = at_step(solution.fields, step)
        a = np.sqrt(0.01 * depth)
        peak = 2 * 1e9 * a / (np.pi * 0.01)
        assert np.max(fields["pressure"]) == pytest.approx(peak, rel=0.1)
        touching = np.hypot(fields["pressure_x"], fields["pressure_y"])[fields["pressure"] > 0]
        assert touching.max() == pytest.approx(a, rel=0.25)
    assert field_problems(solution.fields) == []


def test_loads_over_decades_are_stored_from_grids_of_their_own(pressed):
    """Contact radii a factor of 100 apart are solved on different grids; each keeps its own."""
    fields = at_step(pressed("bem_fft", 1e-9, 1e-6, 1e-5).fields, 0)
    a = np.sqrt(0.01 * 1e-9)
    assert np.abs(fields["pressure_x"]).max() < 2 * a
    assert np.max(fields["pressure"]) == pytest.approx(2e9 * a / (np.pi * 0.01), rel=0.1)


def test_at_most_eight_steps_are_shown_and_always_the_last():
    for count in range(1, 40):
        steps = shown_steps(count)
        assert len(steps) == len(set(steps)) == min(count, MOST_STEPS)
        assert steps[-1] == count - 1


def test_a_torn_step_is_told(pressed):
    torn = pressed("closed_form", 2e-6, 4e-6).fields | {"step.0.pressure": np.ones(3)}
    assert any(field_problem.startswith("step 0") for field_problem in field_problems(torn))


def test_pages_get_coarse_colours_on_an_offset_and_earlier_pressures_in_single_precision():
    """Heights of 100 nm on 1 mm keep their shape: half a step of the range, and float32."""
    heights = 1e-3 + 1e-7 * np.linspace(0, 1, 500) ** 2
    pressure = 1e9 * np.linspace(0, 1, 500, dtype=np.float32)
    fields = shown({"heights": heights, "step.0.pressure": pressure})
    rounding = 2e-7 * 1e-3 / 2
    np.testing.assert_allclose(fields["heights"], heights, rtol=0, atol=1e-7 / 8192 + rounding)
    assert len(np.unique(fields["heights"])) > 300
    np.testing.assert_array_equal(fields["step.0.pressure"], pressure)
