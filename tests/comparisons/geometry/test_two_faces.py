"""Two rough bodies: the sum of their faces is what presses."""

import numpy as np
import pytest

from comparisons.geometry.prepare import prepare
from comparisons.methods.normal.reduced_lines import line_spectrum
from comparisons.scene.scene import SceneError, load_scene
from comparisons.solving.execution import execute
from comparisons.solving.plan import task_of
from comparisons.solving.planning import plan_scene

FIRST = {
    "kind": "self_affine",
    "hurst": 0.8,
    "size": "1 um",
    "points": 16,
    "rms_slope": 0.1,
    "seed": 1,
}
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
def test_which_body_is_above_is_no_matter(method):
    """Faces and moduli exchanged: the solvers see the same gap and E*, but for rounding."""
    answers = []
    for first, second, below, above in (
        (FIRST, SECOND, STEEL, RUBBER),
        (SECOND, FIRST, RUBBER, STEEL),
    ):
        quantities = {"quantities": ["penetration", "contact_area", "mean_gap"]}
        scene = made(first, second, half_space=below, counter_body=above, compare=quantities)
        (plan,) = plan_scene(scene)
        answers.append(execute(task_of(plan, method, 16), 1).quantities)
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
