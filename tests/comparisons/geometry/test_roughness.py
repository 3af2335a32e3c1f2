"""Plans state the size and roughness of a surface, and question what no real one has."""

import numpy as np
import pytest

from comparisons.geometry.plausibility import surface_notes
from comparisons.geometry.prepare import RoughGeometry
from comparisons.scene.scene import validated
from comparisons.solving import planning


def notes(size=(1e-6, 1e-6), points=(64, 64), slope=0.1, height=5e-9):
    return surface_notes(RoughGeometry(size, points, False, slope, height))


def plan_of(**surface):
    """Return the plan of a scene on this surface of 1 um x 1 um."""
    tables = {"half_space": {"effective_modulus": 1e11}, "loading": {"force": 1e-6}}
    surface = {"surface": {"size": 1e-6} | surface}
    return planning.plan_scene(validated({"name": "patch"} | tables | surface))[0]


def plan_of_map(folder, heights):
    np.save(folder / "map.npy", heights)
    return plan_of(kind="map", file=str(folder / "map.npy"), height_unit="nm")


def test_size_points_height_and_slope_are_stated():
    (note,) = notes(size=(300e-9, 200e-6), points=(512, 51200))
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
    _, warning = notes(**given)
    assert warning.startswith(f"check the units and the size of the surface: {doubt}")


def test_a_plan_states_the_map_after_its_preparation(tmp_path):
    """A cosine ridge of 2 nm under a tilt: rms height sqrt(2) nm, slope as differences give it."""
    x = np.arange(32) / 32
    ridges = 2 * np.cos(8 * np.pi * x)[:, None] + 50 * x[:, None] * np.ones(32)
    stated = next(n for n in plan_of_map(tmp_path, ridges).notes if n.startswith("surface: "))
    assert stated.startswith("surface: 1.00\u202fµm x 1.00\u202fµm, 32 x 32 points, rms height 1.4")


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
