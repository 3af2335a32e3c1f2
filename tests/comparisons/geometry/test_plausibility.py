"""Scenes that are no contact mechanics are questioned: units, slopes, roughness."""

import numpy as np
import pytest

from comparisons.geometry.plausibility import surface_notes
from comparisons.geometry.prepare import RoughGeometry
from comparisons.reasons import CHECK
from comparisons.scene.scene import builtin_names, load_scene, validated
from comparisons.solving import planning
from comparisons.solving.plan import Roughness
from comparisons.solving.planning import plan_scene


def notes(shape=None, loading=None, **half_space):
    data = {
        "name": "ball",
        "half_space": half_space,
        "indenter": shape or {"shape": "paraboloid", "radius": 0.01},
        "loading": loading or {"force": 1e3},
        "compare": {"methods": ["closed_form"]},
    }
    (plan,) = plan_scene(validated(data))
    return plan.notes


def checks(*args, **tables):
    return [note for note in notes(*args, **tables) if note.startswith(CHECK)]


def test_a_modulus_without_its_unit_is_questioned_and_steel_is_not():
    """210 Pa for 210 GPa: Hertz, a = (3 F R/(4 E*))^(1/3) = 319 mm, d = a^2/R = 10.2 m."""
    units, slopes = checks(youngs_modulus=210, poisson_ratio=0.3)
    assert "E* = 231\u202fPa is softer than any gel (1.00\u202fkPa)" in units
    assert "deeper than wide" in units
    (stiff,) = checks(effective_modulus=210e12)
    assert "E* = 210\u202fTPa is stiffer than diamond (2.00\u202fTPa)" in stiff
    assert checks(youngs_modulus="210 GPa", poisson_ratio=0.3) == []
    assert (
        "d/a = 31.9 (a/R of a paraboloid), penetration 10.2\u202fm over contact radius 319"
        in slopes
    )


@pytest.mark.parametrize(("depth", "told"), [(0.089, False), (0.091, True)])
def test_slopes_are_questioned_from_three_tenths_on(depth, told):
    """d/a = a/R = sqrt(d/R) of a paraboloid."""
    result = checks(loading={"penetration": 0.01 * depth}, effective_modulus=1e9)
    assert bool(result) == told
    assert all(note.startswith("check the slopes: ") for note in result)


@pytest.mark.parametrize(("depth", "told"), [(0.0099, 0), (0.0101, 1), (0.0899, 1), (0.0901, 0)])
def test_strains_that_are_not_small_are_noted_from_a_tenth_on_until_they_are_questioned(
    depth, told
):
    """d/a = a/R = sqrt(d/R) of a paraboloid: 0.1 at 0.01, 0.3 at 0.09."""
    result = notes(loading={"penetration": 0.01 * depth}, effective_modulus=1e9)
    assert sum(note.startswith("small strains: d/a = ") for note in result) == told


def test_wear_is_no_strain():
    """A punch: d/a = F/(2 E* a^2) = 0.0013 before it wears, 0.41 with k F s/(pi a^3)."""
    changes = {
        "half_space.effective_modulus": "39 GPa",
        "wear.sliding_distance": "1.3 m",
        "compare.methods": ["closed_form"],
    }
    (plan,) = plan_scene(load_scene("worn-punch", changes))
    assert plan.doubts == []
    (plan,) = plan_scene(load_scene("worn-punch", changes | {"loading.force": "10 kN"}))
    (doubt,) = plan.doubts
    assert doubt.startswith("small strains: d/a = 0.128 ")


@pytest.mark.parametrize(("mass", "ratio"), [("30 g", "0.225"), ("300 g", "0.378")])
def test_an_impact_on_rubber_strains_it_as_its_duration_lets_it_relax(mass, ratio):
    """The closed form reaches d/a = 0.223 and 0.370; with the long-term modulus 0.382 and 0.60."""
    tables = {
        "name": "ball",
        "half_space": {"poisson_ratio": 0.5},
        "indenter": {"shape": "sphere", "radius": "20 mm"},
        "viscoelastic": {
            "model": "prony",
            "shear_moduli": ["0.5 MPa", "2 MPa", "5 MPa"],
            "relaxation_times": ["1 s", "1 ms"],
        },
        "dynamics": {"mass": mass, "velocity": "2 m/s"},
        "compare": {"methods": ["closed_form"]},
    }
    (plan,) = plan_scene(validated(tables))
    (doubt,) = plan.doubts
    assert f"d/a = {ratio} " in doubt


@pytest.mark.parametrize(
    ("scene", "changes", "said"),
    [
        (
            "adhesive-ball",
            {"adhesion.work": "3178 J/m^2"},  # E* R/(2 pi): a = R at d = 0
            "g(a)/a = 0.997 (a/R of a paraboloid), the line's profile g at the contact radius",
        ),
        (
            "soft-ball-film",
            {"half_space.effective_modulus": "230 GPa"},
            # Johnson 1985, (4.24): (6 F E*^2/(pi^3 R^2))^(1/3)
            "constant viscosity: under 274\u202fMPa",
        ),
        ("rolling-ball", {"rolling.creep": 2.0}, "a creep of 2.00 is 200\u202f% of the speed"),
        # mild steel on mild steel has K = 0.007 (Archard & Hirst 1956), which is no 1/Pa
        ("worn-punch", {"wear.coefficient": 7e-3}, "wear coefficient of 0.00700/Pa is more than"),
        (
            "plastic-ball",
            {"plasticity.hardening": "500 GPa"},
            "a hardening of 500\u202fGPa is steeper than E = 210\u202fGPa",
        ),
    ],
)
def test_adhesion_creep_wear_and_hardening_beyond_any_material_are_questioned(scene, changes, said):
    (plan,) = plan_scene(load_scene(scene, changes | {"compare.methods": ["reduced"]}))
    (doubt,) = plan.doubts
    assert said in doubt


@pytest.mark.slow
def test_of_the_built_in_scenes_those_with_steep_flanks_are_questioned():
    questioned = {
        name
        for name in builtin_names()
        for plan in plan_scene(load_scene(name))
        for doubt in plan.doubts
        if doubt.startswith(CHECK)
    }
    assert questioned == {"sphere"}


def notes_on(size=(1e-6, 1e-6), points=(64, 64), slope=0.1, height=5e-9):
    return surface_notes(RoughGeometry(size, points, False, slope, height))


def plan_of(**surface):
    tables = {"half_space": {"effective_modulus": 1e11}, "loading": {"force": 1e-6}}
    surface = {"surface": {"size": 1e-6} | surface}
    return planning.plan_scene(validated({"name": "patch"} | tables | surface))[0]


def plan_of_map(folder, heights):
    np.save(folder / "map.npy", heights)
    return plan_of(kind="map", file=str(folder / "map.npy"), height_unit="nm")


def test_size_points_height_and_slope_are_stated():
    (note,) = notes_on(size=(300e-9, 200e-6), points=(512, 51200))
    assert note == (
        "surface: 300\u202fnm x 200\u202fµm, 512 x 51\u202f200 points, "
        "rms height 5.00\u202fnm, rms slope h' = 0.1"
    ).replace("0.1", "0.100")


@pytest.mark.parametrize(
    ("given", "doubt"),
    [
        ({"slope": 13.2}, "an rms slope of 13.2 is steeper than 1"),
        ({"slope": 1e-8}, "an rms slope of 1.00×10⁻⁸ is less than 1×10⁻⁶"),
        ({"size": (0.5e-9, 1e-6), "points": (2, 4096)}, "a side of 500\u202fpm is less than"),
        ({"size": (960.0, 960.0)}, "a side of 960\u202fm is more than 1.00\u202fm"),
        ({"size": (1e-6, 50e-6)}, "points are 50.0 times farther apart along one side"),
    ],
)
def test_implausible_surfaces_are_questioned_in_one_sentence(given, doubt):
    _, warning = notes_on(**given)
    assert warning.startswith(f"check the units and the size of the surface: {doubt}")


def test_a_plan_states_the_map_after_its_preparation(tmp_path):
    """A cosine ridge of 2 nm under a tilt: rms height sqrt(2) nm, slope as differences give it."""
    x = np.arange(32) / 32
    ridges = 2 * np.cos(8 * np.pi * x)[:, None] + 50 * x[:, None] * np.ones(32)
    stated = next(n for n in plan_of_map(tmp_path, ridges).notes if n.startswith("surface: "))
    assert stated.startswith("surface: 1.00\u202fµm x 1.00\u202fµm, 32 x 32 points, rms height 1.4")


def test_points_far_off_their_neighbours_are_counted_and_noise_is_not(tmp_path):
    """White noise of 1 nm: a spike counts once, whatever its height, and on the rim, too."""
    heights = np.random.default_rng(3).standard_normal((64, 64))
    assert not any("spikes" in note for note in plan_of_map(tmp_path, heights).notes)
    heights[[10, 40, 0], [20, 50, 30]] += [30.0, 3000.0, -30.0]
    (told,) = [note for note in plan_of_map(tmp_path, heights).notes if "spikes" in note]
    upwards = "3 of the points (2 upwards, the highest of the map among them)"
    assert told.startswith(f"far off their neighbours: {upwards}, by up to 3.00\u202fµm")


def test_noise_is_where_the_spectrum_is_flat_and_a_fractal_surface_has_none():
    """C2D = q^-3.6 + q1^-3.6: twice the floor at q1, a sixth of the largest wavenumber.

    Rings scatter by 15 %, as means over some 40 modes do.
    """
    q = np.geomspace(1e6, 6e7, 60)
    rings = np.random.default_rng(2).normal(1.0, 0.15, q.size)
    for floor, wavelength in ((1e7**-3.6, 2 * np.pi / 1e7), (0.0, 0.0)):
        known = Roughness(tuple(q), tuple((q**-3.6 + floor) * rings), 1e-9, 0.1, 1e6, 10.0)
        # between two of 60 rings, and a scatter of 15 % in a density that falls as q^-1.8 there
        assert known.noise_wavelength == pytest.approx(wavelength, rel=0.2)


@pytest.mark.parametrize("dust", [0.0, 20.0])
def test_one_spot_far_above_all_else_is_pointed_at(tmp_path, dust):
    """Waves of 2 nm, rms 1 nm; a grain of 20 nm on the third row, a cell from its end."""
    x = 2 * np.pi * np.arange(32) / 32
    heights = np.cos(4 * x)[:, None] + np.cos(4 * x)
    heights[2, 31] += dust
    told = [n for n in plan_of_map(tmp_path, heights).doubts if n.startswith("check the highest")]
    assert len(told) == (1 if dust else 0)
    if dust:
        assert "at 62.5\u202fnm and 969\u202fnm from the corner" in told[0]


def test_synthetic_surfaces_state_the_height_that_follows_from_the_slope():
    """The height of (19.22), the same for all realisations: amplitudes are fixed."""
    plan = plan_of(kind="self_affine", hurst=0.8, points=32, rms_slope=0.1)
    assert any(note.endswith("rms slope h' = 0.100") for note in plan.notes)
    for realisation in (0, 3):
        heights = plan.geometry.heights(realisation, 32)
        assert heights.std() == pytest.approx(plan.geometry.rms_height, rel=1e-10)
