"""Prepared geometry: the same surface for every method, periodic maps, two rough faces."""

import numpy as np
import pytest

from comparisons.geometry.prepare import equivalent_profile, prepare
from comparisons.judging.truth import truths
from comparisons.methods.normal.reduced import line_spectrum
from comparisons.scene.scene import SceneError, load_scene
from reference.contact.press import press
from reference.halfspace import PeriodicOperator
from reference.halfspace.areas import located_area
from reference.loads import Load


def smooth_map(nx=24, ny=16):
    x, y = np.meshgrid((np.arange(nx) + 0.5) / nx, (np.arange(ny) + 0.5) / ny, indexing="ij")
    return 1e-8 * (np.sin(5 * x) * np.cos(4 * y) + x * y)


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
        else:  # of four around it: 0.016 of the height, a quarter of a cell beside it 0.15
            (n, m), rms = native.shape, native.std()
            assert (fine.reshape(n, 2, m, 2).mean(axis=(1, 3)) - native).std() < 0.02 * rms
        assert np.mean(fine**2) == pytest.approx(np.mean(native**2), rel=1e-12)


def test_a_coarser_grid_takes_points_of_the_surface(rough):
    geometry, _ = prepare(rough(points=[16, 8]))
    native = geometry.heights(2, 16)
    np.testing.assert_array_equal(geometry.heights(2, 4), native[::4, ::4])


def test_a_finer_measured_grid_covers_the_same_sides_with_cells_of_the_same_centres(mapped):
    """Three cells for one: the middle one has the measured cell's centre, so its height.

    Splines interpolate, so the middle cells agree to round-off; and a plane stays a plane away
    from the border, where the spline takes the surface for its own mirror image.
    """
    heights = smooth_map()
    geometry, _ = prepare(mapped(heights))
    fine = geometry.heights(0, 72)
    assert fine.shape == (72, 48)
    assert geometry.spacing(fine) == pytest.approx((1e-6 / 72, 1e-6 / 48), rel=1e-15)
    np.testing.assert_allclose(fine[1::3, 1::3], heights, atol=1e-9 * np.ptp(heights))
    x = np.arange(24.0)[:, None] * np.ones(16) * 1e-9
    plane, _ = prepare(mapped(x))
    slope = np.diff(plane.heights(0, 48)[16:-16], axis=0)
    np.testing.assert_allclose(slope, 0.5e-9, rtol=1e-3)


def test_a_finer_measured_grid_is_no_rougher_than_the_surface(mapped):
    """Against the smooth function that the map was taken from; spline error falls as h^4 inside."""
    errors = []
    for n in (12, 24):
        geometry, _ = prepare(mapped(smooth_map(n, n)))
        inside = slice(n // 2, -n // 2)
        exact = smooth_map(2 * n, 2 * n)
        errors.append(np.abs(geometry.heights(0, 2 * n) - exact)[inside, inside].max())
    assert errors[1] < errors[0] / 8
    assert errors[1] < 1e-3 * np.ptp(smooth_map())


def test_a_periodic_map_of_a_synthetic_surface_is_that_surface(mapped, rough):
    """Heights on every grid, and h', to the round-off of the transforms: rows add up to L h' 1e-15.

    The map is read as it is, less its mean, which is zero.
    """
    synthetic, loads = prepare(rough(points=[16, 24], size=["1 um", "1.5 um"], periodic=True))
    native = synthetic.heights(0, 16)
    map_ = mapped(native, size=[1e-6, 1.5e-6], periodic=True, detrend="mean")
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


def test_relative_force_of_a_map(mapped):
    """Forward differences: a plane of slopes 0.3 and 0.4 has h' = 0.5 exactly."""
    x = (np.arange(12) * 1e-6 / 12)[:, None]
    y = (np.arange(8) * 2e-6 / 8)[None, :]
    scene = mapped(0.3 * x + 0.4 * y, size=[1e-6, 2e-6])
    geometry, loads = prepare(scene)
    assert geometry.rms_slope == pytest.approx(0.5, rel=1e-12)
    nominal = scene.effective_modulus * 2e-12 * 0.5
    np.testing.assert_allclose(loads.values, [0.01 * nominal, 0.05 * nominal], rtol=1e-12)


def test_a_map_that_cannot_be_used_is_a_problem_of_the_scene(mapped):
    with pytest.raises(SceneError, match=r"surface.file: .*npy: the map is flat"):
        prepare(mapped(np.zeros((8, 8))))
    for factor in (1e200, 1e-200):
        with pytest.raises(SceneError, match=r"surface.file: .*npy: heights over a range of "):
            prepare(mapped(factor * smooth_map()))


def test_the_contact_is_estimated_from_the_last_load(scene):
    """Hertz: a = sqrt(R d), F = (4/3) E* R^(1/2) d^(3/2).

    The grid reaches the geometric overlap sqrt(2 R d), plus 5 % of d.
    """
    geometry, loads = prepare(scene())
    assert loads.values.tolist() == [1e-6, 2e-6, 4e-6]
    assert geometry.penetration == pytest.approx(4e-6, rel=1e-9)
    assert geometry.contact_radius == pytest.approx(np.sqrt(0.01 * 4e-6), rel=1e-9)
    half = np.sqrt(2 * 0.01 * 1.05 * 4e-6)
    assert geometry.reach == pytest.approx((half, half), rel=1e-9)
    force = 4 / 3 * scene().effective_modulus * np.sqrt(0.01) * 4e-6**1.5
    geometry, _ = prepare(scene(loading={"force": [force]}))
    assert geometry.penetration == pytest.approx(4e-6, rel=1e-9)


def test_a_sphere_pressed_to_its_equator_is_a_problem_of_the_loading(scene):
    """As d = (a/2) ln((R + a)/(R - a)), at d = 20 R no digit is left between a and R."""
    ball = {"shape": "sphere", "radius": "1 mm"}
    told = "penetration 20.0\u202fmm is above 14.0\u202fmm: 14 radii, where the contact would reach"
    with pytest.raises(SceneError, match=told):
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


SIDE, MODULUS, FORCES = 640e-9, 100e9, [1e-6, 1e-5]


def waves(points):
    """Two crossed cosines, 5(cos x + cos y) nm, the peak at the corner."""
    x = 2 * np.pi * np.arange(points) / points
    return 5e-9 * (np.cos(x)[:, None] + np.cos(x))


def sampled(points, force):
    """Return penetration and area from the function itself at this many points a side."""
    heights, spacing = waves(points), (SIDE / points, SIDE / points)
    operator = PeriodicOperator(heights.shape, spacing, MODULUS)
    contact = press(operator, heights.max() - heights, Load("force", force))
    return {"penetration": contact.penetration, "contact_area": located_area(contact)}


@pytest.mark.slow
def test_the_bar_of_crossed_cosines_holds_their_direct_sampling(mapped, solved, planned):
    """32 x 32 points, of which finer grids are made, against 512 x 512 of the function itself.

    1.1946 nm at 10 uN, to 0.05 %: the grids of 128 and 512 differ by a quarter of it. Where the
    period is cut: tests/comparisons/methods/test_map_symmetries.py.
    """
    body = {"half_space": {"effective_modulus": MODULUS}}
    made = mapped(waves(32), {"force": FORCES}, body, size=SIDE, periodic=True)
    levels = planned(made)["bem_fft"].resolutions
    (reference,) = truths({("bem_fft", n): solved(made, "bem_fft", n) for n in levels}, "force")
    assert reference.curves["penetration"][1] == pytest.approx(1.1946e-9, rel=5e-4)
    for step, force in enumerate(FORCES):
        for name, value in sampled(512, force).items():
            error = abs(reference.curves[name][step] / value - 1)
            assert error <= reference.bar(name, "force")[step], (name, force)


FIRST = {"kind": "self_affine", "size": "1 um", "points": 16}
FIRST |= {"hurst": 0.8, "rms_slope": 0.1, "seed": 1}
SECOND = FIRST | {"hurst": 0.5, "rms_slope": 0.05, "seed": 2}
STEEL = {"youngs_modulus": "200 GPa", "poisson_ratio": 0.3}
RUBBER = {"youngs_modulus": "5 GPa", "poisson_ratio": 0.48}
FORCE = {"force": {"values": [0.02, 0.1], "relative_to": "E* A0 h'"}}


def made(first=FIRST, second=SECOND, **tables):
    bodies = {"half_space": STEEL, "surface": first, "surface2": second, "loading": FORCE}
    return load_scene({"name": "two"} | bodies | tables)


@pytest.fixture
def store(tmp_path):
    """Return a function that saves a map of 1 um x 1 um, and returns its table."""

    def save(name: str, heights: np.ndarray, **keys):
        np.save(tmp_path / f"{name}.npy", heights)
        table = {"kind": "map", "file": str(tmp_path / f"{name}.npy"), "height_unit": "nm"}
        return table | {"size": "1 um", "detrend": "none"} | keys

    return save


@pytest.mark.parametrize("periodic", [False, True])
@pytest.mark.parametrize("resolution", [8, 16, 32])
def test_heights_of_the_faces_add_up(periodic, resolution):
    first, second = FIRST | {"periodic": periodic}, SECOND | {"periodic": periodic}
    both, _ = prepare(made(first, second))
    alone = [
        prepare(load_scene({"name": "one", "half_space": STEEL, "surface": face, "loading": FORCE}))
        for face in (first, second)
    ]
    total = sum(geometry.heights(3, resolution) for geometry, _ in alone)
    np.testing.assert_allclose(
        both.heights(3, resolution), total, rtol=0, atol=1e-13 * np.ptp(total)
    )


def test_squares_of_slopes_and_heights_add_up():
    """Random phases: the mean over surfaces; 100 of them know it to 2 %."""
    both, _ = prepare(made())
    assert both.rms_slope == pytest.approx(np.hypot(0.1, 0.05), rel=1e-12)
    variances = [both.heights(k, 16).var() for k in range(100)]
    assert np.mean(variances) == pytest.approx(both.rms_height**2, rel=0.1)


def test_faces_of_the_same_seed_are_no_copies():
    """As copies they would be twice as high, not sqrt(2) times."""
    both, _ = prepare(made(FIRST, FIRST))
    ratios = [np.sqrt(both.heights(k, 16).var()) / both.rms_height for k in range(20)]
    assert np.mean(ratios) == pytest.approx(1.0, rel=0.1)


@pytest.mark.parametrize("method", ["bem_fft", "bem_dense", "fem"])
def test_which_body_is_above_is_no_matter(curves, method):
    """Faces and moduli exchanged: the solvers see the same gap and E*, but for rounding."""
    answers = []
    for first, second, below, above in (
        (FIRST, SECOND, STEEL, RUBBER),
        (SECOND, FIRST, RUBBER, STEEL),
    ):
        quantities = {"quantities": ["penetration", "contact_area", "mean_gap"]}
        scene = made(first, second, half_space=below, counter_body=above, compare=quantities)
        answers.append(curves(scene, method, 16))
    for name in ("penetration", "contact_area", "mean_gap"):
        np.testing.assert_allclose(answers[0][name], answers[1][name], rtol=1e-6)


def test_the_line_has_the_sum_of_the_spectra():
    scene = made()
    both, _ = prepare(scene)
    options = scene.methods.reduced
    parts = []
    for face in (FIRST, SECOND):
        one = load_scene({"name": "one", "half_space": STEEL, "surface": face, "loading": FORCE})
        parts.append(line_spectrum(prepare(one)[0], options.spectrum).power)
    np.testing.assert_allclose(line_spectrum(both, options.spectrum).power, sum(parts), rtol=1e-12)


def test_two_maps_are_one(store):
    """The methods see a map of the sum: its gradient, its spectrum, its highest point."""
    random = np.random.default_rng(3)
    first, second = random.standard_normal((2, 12, 12))
    scene = made(store("a", first), store("b", second))
    both, _ = prepare(scene)
    one = {"name": "one", "half_space": STEEL, "surface": store("c", first + second)}
    single, _ = prepare(load_scene(one | {"loading": FORCE}))
    assert not scene.random
    assert both.rms_slope == pytest.approx(single.rms_slope, rel=1e-12)
    assert both.top(0) == pytest.approx(single.top(0), rel=1e-12)
    np.testing.assert_allclose(both.heights(0, 24), single.heights(0, 24), rtol=1e-10, atol=1e-20)
    rule = scene.methods.reduced.spectrum
    spectra = [line_spectrum(geometry, rule).power for geometry in (both, single)]
    np.testing.assert_allclose(*spectra, rtol=1e-10)
    assert both.digest not in ("", single.digest)


def test_finer_grids_find_no_higher_point_of_a_measured_patch(store):
    """Depths are counted from it: a lattice of a ninth of a point lay up to 1 % of rms too low."""
    table = store("a", np.random.default_rng(5).standard_normal((12, 12)))
    scene = {"name": "one", "half_space": STEEL, "surface": table, "loading": FORCE}
    geometry, _ = prepare(load_scene(scene))
    beyond = geometry.heights(0, 12 * 64).max() - geometry.top(0)
    assert -1e-3 * geometry.rms_height < beyond < 1e-9 * geometry.rms_height


def test_a_map_on_random_surfaces_is_an_ensemble(store):
    ridges = store("a", np.cos(np.arange(16.0))[:, None] + np.zeros(16))
    scene = made(ridges, SECOND | {"realisations": 7})
    assert (scene.random, scene.realisations) == (True, 7)
    both, _ = prepare(scene)
    differences = both.heights(1, 16) - both.heights(0, 16)
    second = load_scene({"name": "s", "half_space": STEEL, "surface": SECOND, "loading": FORCE})
    alone, _ = prepare(second)
    expected = alone.heights(1, 16) - alone.heights(0, 16)
    np.testing.assert_allclose(differences, expected, atol=1e-12 * np.ptp(expected))


def test_faces_that_do_not_match_are_refused_in_words(store):
    with pytest.raises(SceneError) as caught:
        prepare(made(second=SECOND | {"points": [16, 32], "size": ["1 um", "2 um"]}))
    assert "surface2: expected as many points as [surface], 16 x 16, got 16 x 32" in str(
        caught.value
    )
    assert "surface2: expected the sides of [surface]" in str(caught.value)
    relief = np.random.default_rng(1).standard_normal((8, 8))
    with pytest.raises(SceneError, match="no gap is rough"):
        prepare(made(store("a", relief), store("b", -relief)))


def test_faults_of_both_maps_are_told_at_once(store, tmp_path):
    gone = {"kind": "map", "file": "gone.npy", "size": "1 um", "height_unit": "nm"}
    with pytest.raises(SceneError) as caught:
        prepare(made(gone, gone | {"file": "lost.npy"}))
    assert "surface.file: gone.npy" in str(caught.value)
    assert "surface2.file: lost.npy" in str(caught.value)
