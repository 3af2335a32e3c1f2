"""Rough scenes with [plasticity]: pressure capped at a hardness, lines with capped springs."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from comparisons.methods.registry import solver_for
from comparisons.scene.scene import Scene, load_scene
from comparisons.solving.execution import execute
from comparisons.solving.planning import plan_scene
from comparisons.tasks.task import Task

COARSE = {"surface.points": 32, "surface.short_cutoff": "12.5 um", "surface.realisations": 2}
QUANTITIES = ("force", "contact_area", "penetration", "residual_depth", "plastic_share")


def rough(name: str = "plastic-rough", **changes) -> Scene:
    """Return the built-in scene on a coarse grid, or another one that yields."""
    base = COARSE if name == "plastic-rough" else {"plasticity.yield_stress": "1 GPa"}
    return load_scene(name, base | {key.replace("__", "."): v for key, v in changes.items()})


@pytest.mark.parametrize(
    ("scene", "resolution"),
    [
        (rough(), 64),
        (rough(surface__periodic=False), 32),
        (rough("measured-map", compare__quantities=["contact_area"]), None),
    ],
)
def test_surfaces_and_maps_yield_and_keep_a_dent(solved, scene, resolution):
    (plan, *_) = plan_scene(scene)
    grid = solved(scene, "bem_fft", resolution or plan.geometry.points[0]).quantities
    assert_allclose(grid["force"][0], plan.loads.values, rtol=1e-6)
    assert (grid["plastic_share"] <= 1).all()
    assert grid["plastic_share"].max() > 0.2
    # what was dented stays so, and no mean pressure is above the hardness
    assert (np.diff(grid["residual_depth"], axis=1) >= 0).all()
    assert grid["residual_depth"][:, -1].min() > 0
    hardness = scene.plasticity.hardness
    assert (grid["force"] <= 1.02 * hardness * grid["contact_area"]).all()


def test_soft_surfaces_touch_on_force_over_hardness(solved):
    soft = rough(plasticity__yield_stress="50 MPa", loading__force={"values": [1e-4, 4e-4]})
    soft = load_scene(soft, {"loading.force.relative_to": "E* A0 h'"})
    grid = solved(soft, "bem_fft", 64).quantities
    # E* h'/H = 49; some 20 and 80 cells touch, so that a cell is 5 and 1.3 per cent
    hard = grid["force"] / soft.plasticity.hardness
    assert (np.abs(grid["contact_area"] / hard - 1) < [[0.05, 0.013]]).all()
    line = solved(soft, "reduced", 64).quantities
    # by (19.37) parabolas in full yield have (pi/4) H, and contacts of lines nearly so
    mean = line["force"].sum() / line["contact_area"].sum() / soft.plasticity.hardness
    assert_allclose(mean, np.pi / 4, rtol=0.12)


@pytest.mark.parametrize("method", ["bem_fft", "reduced"])
def test_hard_surfaces_are_elastic(solved, method):
    load = {"loading__force": {"values": [0.02], "relative_to": "E* A0 h'"}}
    hard = solved(rough(plasticity__yield_stress="1e6 GPa", **load), method, 32).quantities
    tables = rough(**load).model_dump(exclude_defaults=True)
    del tables["plasticity"], tables["compare"]
    elastic = solved(load_scene(tables), method, 32).quantities
    for name in ("contact_area", "penetration"):
        assert_array_equal(hard[name], elastic[name])
    assert not hard["plastic_share"].any()


def test_unloading_leaves_the_dent_in_the_picture(solved):
    fields = solved(rough(), "bem_fft", 32, "pressure").fields
    assert fields["dent"].max() > 0
    assert (fields["gap"] > -1e-6 * fields["dent"].max()).all()


def test_more_force_than_the_hardness_carries_is_lost_with_the_reason():
    (plan, *_) = plan_scene(rough(loading__force="1 kN"))
    task = Task(plan.scene, plan.geometry, plan.loads, "bem_fft", 32, QUANTITIES)
    assert "the hardness carries less" in execute(task).reasons[0, 0]


def test_model_text_says_how_lines_yield():
    for changes, words in (
        ({}, "radius of their contact"),
        ({"methods__reduced__stress": "local"}, "radius of their own curvature"),
        ({"plasticity__model": "elastic_root"}, "elastic part of"),
        ({"plasticity__model": "none"}, "stay elastic"),
        ({"plasticity__hardening": "1 GPa"}, "hardening is left out"),
    ):
        scene = rough(**changes)
        (plan, *_) = plan_scene(scene)
        assert words in solver_for("reduced", scene).model(plan.geometry)
