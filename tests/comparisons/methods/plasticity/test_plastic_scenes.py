"""Scenes with [plasticity]: springs, elements, fits, capped pressures of rough surfaces."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from comparisons.formatting import with_unit
from comparisons.methods.registry import solver_for
from comparisons.scene.scene import Scene, load_scene
from comparisons.solving.execution import execute
from comparisons.solving.planning import plan_scene
from comparisons.tasks.solution import Solution
from comparisons.tasks.task import Task
from reference.errors import ConvergenceError
from reference.plastic import Walk

YIELDS = {"yield_stress": "420 MPa"}
CONE = {"shape": "cone", "slope": 0.05}
FIRST = 0.2126e-6  # m, on steel below a ball of 10 mm


def yielding(scene, *depths: float, model: str = "stress", **tables) -> Scene:
    """Return a ball that dents steel to depths in units of d_y."""
    loading = {"penetration": [FIRST * depth for depth in depths]}
    ball = {"plasticity": YIELDS | {"model": model}, "loading": loading}
    asked = {"quantities": ["force", "contact_area", "residual_depth"]}
    return scene(**ball | {"compare": asked} | tables)


def curve(solution: Solution, name: str = "force") -> np.ndarray:
    return solution.quantities[name][0]


@pytest.mark.parametrize("model", ["stress", "elastic_root", "zunker_kamrin", "none"])
def test_no_spring_yields_before_the_half_space_does(scene, solved, model):
    """So what is known of elastic balls is known of these: Hertz's force, and no dent."""
    solution = solved(yielding(scene, 0.1, 0.999, model=model), "reduced", 400)
    modulus = 210e9 / 0.91
    hertz = 4 / 3 * modulus * np.sqrt(0.01) * (FIRST * np.array([0.1, 0.999])) ** 1.5
    assert_allclose(curve(solution), hertz, rtol=1e-3)  # 400 springs
    assert_allclose(curve(solution, "residual_depth"), 0.0)


@pytest.mark.slow
@pytest.mark.parametrize(("asked", "given"), [("force", False), ("equivalent_radius", True)])
def test_only_what_asks_for_the_area_unloads_for_it(scene, asked, given):
    (plan, *_) = plan_scene(yielding(scene, 2))
    answer = execute(Task(plan.scene, plan.geometry, plan.loads, "fem", 3, (asked,)))
    assert ("contact_area" in answer.quantities) == given


@pytest.mark.slow
def test_the_area_is_known_to_a_share_that_does_not_hang_on_how_little_grids_differ(scene, solved):
    """Two and three elements differ by 0.6 % where three are 1.3 % away from six."""
    coarse, middle, fine = (
        solved(yielding(scene, 19, 18), "fem", elements) for elements in (2, 3, 6)
    )
    area = "contact_area"
    error = np.abs(curve(middle, area) / curve(fine, area) - 1)
    change = np.abs(curve(coarse, area) / curve(middle, area) - 1)
    assert (change < error).any()
    assert (error < middle.bars[area][0] + fine.bars[area][0]).all()


@pytest.mark.parametrize("depth", [0.5, 2.0])
def test_first_yield_is_told_as_penetration_force_and_mean_pressure(scene, depth):
    """p0 = 1.613 Y at nu = 0.3: F = pi^3 R^2 p0^3/(6 E*^2) (Johnson 1985, 6.10), F/A = 2 p0/3."""
    (plan,) = plan_scene(yielding(scene, depth))
    (said,) = (m.modelled or m.reason for m in plan.methods if m.method == "closed_form")
    p0, modulus = 1.613 * 420e6, 210e9 / 0.91
    force = np.pi**3 * 0.01**2 * p0**3 / (6 * modulus**2)
    for value, unit in ((FIRST, "m"), (force, "N"), (2 * p0 / 3, "Pa")):
        assert with_unit(value, unit) in said


def test_what_yielded_once_is_no_elastic_ball_any_more(scene, solved):
    """The last load is as small as the first, which the closed form answers."""
    solution = solved(yielding(scene, 0.5, 2, 0.5), "closed_form", 1)
    assert solution.converged[0].tolist() == [True, False, False]


@pytest.mark.slow
def test_round_shapes_dent_too(solved, scene):
    """A cone yields from the start: it has a force and a dent, and no depth of first yield."""
    for shape in (
        CONE,
        {"shape": "rounded_punch", "flat_radius": "0.1 mm", "edge_radius": "10 mm"},
        {"shape": "sphere", "radius": "10 mm"},
    ):
        dented = solved(yielding(scene, 10, indenter=shape), "fem", 3, "first_yield")
        elastic = solved(yielding(scene, 10, indenter=shape, model="none"), "reduced", 100)
        assert 0.1 * curve(elastic) < curve(dented) < curve(elastic)
        assert curve(dented, "residual_depth") > 0
        known = dented.quantities.get("first_yield", [[np.nan]])[0]
        assert np.isnan(known).all() == (shape == CONE)


@pytest.mark.slow
def test_a_dent_that_is_not_found_costs_no_force(solved, scene, monkeypatch):
    def fails(*_):
        raise ConvergenceError("no dent")

    monkeypatch.setattr(Walk, "residual_depth", fails)
    assert (curve(solved(yielding(scene, 2, 3), "fem", 3)) > 0).all()


@pytest.mark.slow
def test_hardening_of_either_law_carries_more(solved, scene):
    soft = curve(solved(yielding(scene, 10), "fem", 3))
    for more in ({"hardening": "10 GPa"}, {"hardening_exponent": 0.2}):
        hard = curve(solved(yielding(scene, 10, plasticity=YIELDS | more), "fem", 3))
        assert hard > 1.01 * soft


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


def test_the_pressure_of_a_surface_that_yields_is_kept_for_its_contact_spots():
    (plan, *_) = plan_scene(rough())
    assert all(task.wants_pressure for task in plan.tasks if task.realisations[0] == 0)


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
