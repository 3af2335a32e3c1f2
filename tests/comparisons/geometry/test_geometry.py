"""Prepared geometry: the same surface for every method, and loads made absolute once."""

import numpy as np
import pytest

from comparisons.geometry.prepare import equivalent_profile, prepare
from comparisons.scene.scene import SceneError


@pytest.fixture
def measured(scene, tmp_path):
    """Return a maker of scenes over a map on disk, as it is (no detrending)."""

    def make(heights, size=(1e-6, 1e-6), force=(0.01, 0.05), relative=True, **surface):
        np.save(tmp_path / "map.npy", heights)
        load = {"values": list(force)} | ({"relative_to": "E* A0 h'"} if relative else {})
        table = {"kind": "map", "file": "map.npy", "size": list(size), "height_unit": "m"}
        return scene(
            tmp_path, surface=table | {"detrend": "none"} | surface, loading={"force": load}
        )

    return make


def smooth_map(nx=24, ny=16):
    x, y = np.meshgrid((np.arange(nx) + 0.5) / nx, (np.arange(ny) + 0.5) / ny, indexing="ij")
    return 1e-8 * (np.sin(5 * x) * np.cos(4 * y) + x * y)


# --- surfaces at any resolution -------------------------------------------------------------


@pytest.mark.parametrize("points", [16, [16, 24]])
def test_a_finer_synthetic_grid_divides_the_native_cells_and_keeps_the_modes(rough, points):
    """Fourier interpolation passes through its points, and adds no roughness of its own.

    1e-12: the round-off of two transforms. The mean square of a band-limited surface below the
    Nyquist modes is the same on any finer grid (Parseval).
    """
    geometry, _ = prepare(rough(points=points, long_cutoff="1 um", short_cutoff="0.25 um"))
    native = geometry.heights(0, 16)
    for factor in (2, 3):
        fine = geometry.heights(0, factor * 16)
        assert fine.shape == tuple(factor * n for n in native.shape)
        if factor == 3:  # the points are the middle ones of nine
            np.testing.assert_allclose(fine[1::3, 1::3], native, atol=1e-12 * np.ptp(native))
        assert np.mean(fine**2) == pytest.approx(np.mean(native**2), rel=1e-12)


def test_a_coarser_grid_takes_points_of_the_surface(rough):
    geometry, _ = prepare(rough(points=[16, 8]))
    native = geometry.heights(2, 16)
    np.testing.assert_array_equal(geometry.heights(2, 4), native[::4, ::4])


def test_realisations_differ_and_are_reproducible(rough):
    geometry, _ = prepare(rough(realisations=3))
    first, second = geometry.heights(0, 16), geometry.heights(1, 16)
    assert not np.allclose(first, second)
    np.testing.assert_array_equal(first, prepare(rough(realisations=3))[0].heights(0, 16))
    other = prepare(rough(seed=4))[0].heights(0, 16)
    assert not np.allclose(first, other)


def test_a_finer_measured_grid_covers_the_same_sides_with_cells_of_the_same_centres(measured):
    """Three cells for one: the middle one has the measured cell's centre, so its height.

    Splines interpolate, so the middle cells agree to round-off; and a plane stays a plane away
    from the border, where the spline takes the surface for its own mirror image.
    """
    heights = smooth_map()
    geometry, _ = prepare(measured(heights))
    fine = geometry.heights(0, 72)
    assert fine.shape == (72, 48)
    assert geometry.spacing(fine) == pytest.approx((1e-6 / 72, 1e-6 / 48), rel=1e-15)
    np.testing.assert_allclose(fine[1::3, 1::3], heights, atol=1e-9 * np.ptp(heights))
    x = np.arange(24.0)[:, None] * np.ones(16) * 1e-9
    plane, _ = prepare(measured(x))
    slope = np.diff(plane.heights(0, 48)[16:-16], axis=0)
    np.testing.assert_allclose(slope, 0.5e-9, rtol=1e-3)


def test_a_finer_measured_grid_is_no_rougher_than_the_surface(measured):
    """Against the smooth function that the map was taken from; spline error falls as h^4 inside."""
    errors = []
    for n in (12, 24):
        geometry, _ = prepare(measured(smooth_map(n, n)))
        inside = slice(n // 2, -n // 2)
        exact = smooth_map(2 * n, 2 * n)
        errors.append(np.abs(geometry.heights(0, 2 * n) - exact)[inside, inside].max())
    assert errors[1] < errors[0] / 8
    assert errors[1] < 1e-3 * np.ptp(smooth_map())


def test_a_periodic_map_of_a_synthetic_surface_is_that_surface(measured, rough):
    """Heights on every grid, and h', to the round-off of the transforms: rows add up to L h' 1e-15.

    The map is read as it is, less its mean, which is zero.
    """
    synthetic, loads = prepare(rough(points=[16, 24], size=["1 um", "1.5 um"], periodic=True))
    native = synthetic.heights(0, 16)
    map_ = measured(native, size=(1e-6, 1.5e-6), periodic=True, detrend="mean")
    geometry, its_loads = prepare(map_)
    assert geometry.treatment[-1] == "mean subtracted"
    assert geometry.rms_slope == pytest.approx(synthetic.rms_slope, rel=1e-12)
    np.testing.assert_allclose(its_loads.values, loads.values, rtol=1e-12)
    for resolution in (16, 32, 64):
        np.testing.assert_allclose(
            geometry.heights(0, resolution),
            synthetic.heights(0, resolution),
            atol=1e-13 * np.ptp(native),
        )


# --- loads ----------------------------------------------------------------------------------


def test_relative_force_of_a_synthetic_surface(rough):
    """F = value E* A0 h', with h' as asked for: amplitudes are fixed, so it holds exactly."""
    scene = rough(points=[32, 16], size=["2 um", "1 um"])
    geometry, loads = prepare(scene)
    scale = scene.effective_modulus * 2e-12 * 0.1
    np.testing.assert_allclose(loads.values, [0.01 * scale, 0.05 * scale], rtol=1e-14)
    assert loads.control == "force"
    # h' is the gradient of what is synthesised, here summed over its modes by finite differences
    # of a 16 times finer grid (error of second order in the cell).
    heights = geometry.heights(0, 32 * 16)
    dx, dy = geometry.spacing(heights)
    across = (np.roll(heights, -1, 0) - heights) / dx
    along = (np.roll(heights, -1, 1) - heights) / dy
    assert np.sqrt(np.mean(across**2) + np.mean(along**2)) == pytest.approx(0.1, rel=5e-3)


def test_relative_force_of_a_surface_given_by_its_height(rough):
    first = rough(points=[32, 16], size=["2 um", "1 um"])
    heights = prepare(first)[0].heights(0, 32)
    rms = float(np.sqrt(np.mean(heights**2)))
    second = rough(points=[32, 16], size=["2 um", "1 um"], rms_slope=None, rms_height=rms)
    np.testing.assert_allclose(prepare(second)[1].values, prepare(first)[1].values, rtol=1e-12)


def test_relative_force_of_a_map(measured):
    """Forward differences: a plane of slopes 0.3 and 0.4 has h' = 0.5 exactly."""
    x = (np.arange(12) * 1e-6 / 12)[:, None]
    y = (np.arange(8) * 2e-6 / 8)[None, :]
    scene = measured(0.3 * x + 0.4 * y, size=(1e-6, 2e-6))
    geometry, loads = prepare(scene)
    assert geometry.rms_slope == pytest.approx(0.5, rel=1e-12)
    nominal = scene.effective_modulus * 2e-12 * 0.5
    np.testing.assert_allclose(loads.values, [0.01 * nominal, 0.05 * nominal], rtol=1e-12)


def test_absolute_loads_stay_as_they_are(rough):
    _, loads = prepare(rough(loading={"mean_gap": ["1 nm", "2 nm"]}))
    assert loads.control == "mean_gap"
    assert loads.values.tolist() == [1e-9, 2e-9]


def test_a_map_that_cannot_be_used_is_a_problem_of_the_scene(measured, scene):
    with pytest.raises(SceneError, match=r"surface.file: .*npy: the map is flat"):
        prepare(measured(np.zeros((8, 8))))
    for factor in (1e200, 1e-200):
        with pytest.raises(SceneError, match=r"surface.file: .*npy: heights over a range of "):
            prepare(measured(factor * smooth_map()))
    holes = smooth_map()
    holes[2, 2] = np.nan
    with pytest.raises(SceneError, match=r"surface.file: .*npy: .*NaN"):
        prepare(measured(holes))
    with pytest.raises(SceneError, match=r"surface.file: nowhere.npy: no such file"):
        prepare(scene(surface={"kind": "map", "file": "nowhere.npy", "size": 1}))


# --- single contacts ------------------------------------------------------------------------


def test_the_contact_is_estimated_from_the_last_load(scene):
    """Hertz: a = sqrt(R d); the grid reaches the geometric overlap sqrt(2 R d), plus 5 % of d."""
    geometry, loads = prepare(scene())
    assert loads.values.tolist() == [1e-6, 2e-6, 4e-6]
    assert geometry.penetration == pytest.approx(4e-6, rel=1e-9)
    assert geometry.contact_radius == pytest.approx(np.sqrt(0.01 * 4e-6), rel=1e-9)
    half = np.sqrt(2 * 0.01 * 1.05 * 4e-6)
    assert geometry.reach == pytest.approx((half, half), rel=1e-9)


def test_a_force_gives_the_same_estimate_as_its_penetration(scene):
    """F = (4/3) E* R^(1/2) d^(3/2)."""
    force = 4 / 3 * scene().effective_modulus * np.sqrt(0.01) * 4e-6**1.5
    geometry, _ = prepare(scene(loading={"force": [force]}))
    assert geometry.penetration == pytest.approx(4e-6, rel=1e-9)


def test_a_sphere_pressed_to_its_equator_is_a_problem_of_the_loading(scene):
    """As d = (a/2) ln((R + a)/(R - a)), at d = 20 R no digit is left between a and R."""
    ball = {"shape": "sphere", "radius": "1 mm"}
    with pytest.raises(SceneError, match="the contact would reach the radius of the sphere"):
        prepare(scene(indenter=ball, loading={"penetration": ["20 mm"]}))
    assert prepare(scene(indenter=ball, loading={"penetration": ["2 mm"]}))


@pytest.mark.parametrize(
    ("indenter", "radius"),
    [
        # Gaussian radius: a^2 = sqrt(Rx Ry) d.
        ({"shape": "ellipsoid", "radius_x": 0.04, "radius_y": 0.01}, np.sqrt(0.02 * 1e-6)),
        # D = (4 A/pi)^(1/2): the circle of equal area.
        ({"shape": "square_punch", "side": 2.0}, np.sqrt(4 / np.pi)),
        ({"shape": "elliptic_punch", "semi_axes": [4.0, 1.0]}, 2.0),
        ({"shape": "cylinder", "radius": 3.0}, 3.0),
        ({"shape": "profile", "r": [0, 1.0, 3.0], "f": [0, 0, 0]}, 3.0),
    ],
)
def test_the_rules_of_the_chapter_for_what_has_no_exact_line(scene, indenter, radius):
    profile = equivalent_profile(scene(indenter=indenter).indenter)
    assert float(profile.contact_radius(1e-6)) == pytest.approx(radius, rel=1e-12)


@pytest.mark.parametrize("interpolation", ["pchip", "linear"])
def test_a_table_of_two_points_is_a_cone_with_a_sharp_edge(scene, interpolation):
    """A slope of 1/1000 up to r = 1 mm: a = (2/pi) d/slope (Sneddon 1965), well inside."""
    table = {"shape": "profile", "r": [0, "1 mm"], "f": [0, "1 um"]}
    table["interpolation"] = interpolation
    geometry, _ = prepare(scene(indenter=table, loading={"penetration": [1e-7]}))
    assert geometry.contact_radius == pytest.approx(2 / np.pi * 1e-4, rel=1e-6)
