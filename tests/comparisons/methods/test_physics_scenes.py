"""Scenes with friction, memory, sliding, adhesion, inertia: what they say, and what is refused."""

import math
import tomllib
from pathlib import Path

import numpy as np
import pytest

from comparisons.geometry.prepare import prepare
from comparisons.scene.loading import loads_of
from comparisons.scene.physics.tables.viscoelastic import Viscoelastic
from comparisons.scene.scene import SUITES, builtin_folder, builtin_names, load_scene, make_scene
from comparisons.solving.planning import plan_scene

RUBBER = {"model": "standard", "shear_moduli": ["1 MPa", "9 MPa"], "viscosities": "90 kPa s"}
SOFT = {"youngs_modulus": "3 MPa", "poisson_ratio": 0.5}
FRICTION = {"friction": {"coefficient": 0.3}}
PULL = {"force": "10 N", "tangential_force": ["1 N", "-1 N"]}
HISTORY = {"time": [0, "10 ms", "30 ms"], "penetration": [0, "1 um", 0]}
GLUE = {"work": "50 mJ/m^2"}


def test_a_scene_without_these_tables_switches_nothing_on(scene):
    plain = scene()
    assert plain.physics == ()
    loads = loads_of(plain)
    assert (loads.control, loads.axis, loads.is_path) == ("penetration", "penetration", False)
    assert plan_scene(plain)[0].switched_on == ()


def test_a_tangential_path_starts_at_zero_under_the_last_normal_load(scene):
    loading = {"force": ["5 N", "10 N"], "tangential_force": ["1 N", "-1 N"], "substeps": 2}
    loads = loads_of(scene(loading=loading, **FRICTION))
    assert (loads.control, loads.axis, loads.is_path) == ("tangential_force", "step", True)
    assert loads.values.tolist() == [0.5, 1.0, 0.0, -1.0]
    assert loads.normal is not None
    assert loads.normal.control == "force"
    assert loads.normal.values.tolist() == [10.0]


def test_a_history_is_divided_in_load_and_time_alike(scene):
    loads = loads_of(scene(viscoelastic=RUBBER, half_space=SOFT, loading=HISTORY | {"substeps": 2}))
    assert (loads.control, loads.axis) == ("penetration", "time")
    assert loads.times == pytest.approx([0, 0.005, 0.01, 0.02, 0.03], rel=1e-15)
    assert loads.values == pytest.approx([0, 5e-7, 1e-6, 5e-7, 0], abs=1e-22)


SPEEDS = {"from": "1 mm/s", "to": "1 m/s", "steps": 4, "spacing": "log"}
MASS = {"mass": "10 g", "velocity": ["1 cm/s", "1 m/s"]}


@pytest.mark.parametrize(
    ("tables", "axis", "values"),
    [
        ({"adhesion": GLUE, "loading": {"force": ["1 N", "-1 mN", 0]}}, "step", [1.0, -1e-3, 0.0]),
        (
            {"viscoelastic": RUBBER, "sliding": {"speed": SPEEDS}, "loading": {"force": "2 N"}},
            "speed",
            [1e-3, 1e-2, 0.1, 1.0],
        ),
        ({"dynamics": MASS}, "velocity", [0.01, 1.0]),
        (
            {"dynamics": MASS | {"velocity": 0}, "loading": {"time": [0, 1], "force": [0, 1]}},
            "time",
            [0.0, 1.0],
        ),
    ],
)
def test_loads_are_what_the_physics_varies(ball, tables, axis, values):
    """A path that may pull and turn back, a sweep at one load, impacts, a mass at rest."""
    loads = loads_of(ball(**tables))
    assert loads.axis == axis
    assert loads.is_path == (axis in ("step", "time"))
    assert loads.values == pytest.approx(values, rel=1e-14)


@pytest.fixture
def ball():
    def make(**tables):
        data = {"name": "ball", "half_space": SOFT, "indenter": {"shape": "sphere", "radius": 0.01}}
        return make_scene(data | tables, "ball.toml", Path())

    return make


@pytest.mark.parametrize(
    "table",
    [
        {"model": "standard", "shear_moduli": [1e6, 9e6], "relaxation_times": [0.01]},
        {"model": "prony", "shear_moduli": [1e6, 9e6], "viscosities": [9e4]},
    ],
)
def test_viscosities_and_relaxation_times_say_the_same(scene, table):
    own = scene(viscoelastic=RUBBER, half_space=SOFT, loading=HISTORY).viscoelastic
    other = scene(viscoelastic=table, half_space=SOFT, loading=HISTORY).viscoelastic
    assert np.array(own.branches) == pytest.approx(np.array(other.branches), rel=1e-14)
    assert own.long_term_modulus == other.long_term_modulus == 1e6
    assert own.instantaneous_modulus == 1e7


def test_kelvin_voigt_is_a_spring_beside_a_dashpot():
    body = Viscoelastic(model="kelvin_voigt", shear_moduli="1 MPa", relaxation_times="2 ms")
    assert (body.branches, body.dashpot_viscosity) == ((), 2e3)
    assert body.instantaneous_modulus == math.inf


def test_the_bound_on_the_creep_of_a_fluid_is_that_of_maxwell():
    """J(t) = (1 + t/tau)/G for one Maxwell element, so the bound is the creep itself."""
    body = Viscoelastic(model="maxwell", shear_moduli=2e6, relaxation_times=0.5)
    assert body.softest_modulus(3.0) == pytest.approx(2e6 / (1 + 3.0 / 0.5), rel=1e-14)


def test_rubber_is_incompressible_unless_said_otherwise(scene):
    """E* = 2 G0/(1 - nu) = 4 G0, the stiffness of springs in the chapter (19.30)."""
    for half_space in ({"poisson_ratio": 0.5}, SOFT, {"effective_modulus": 4e6}):
        rubber = scene(viscoelastic=RUBBER, half_space=half_space, loading=HISTORY)
        assert rubber.effective_modulus == pytest.approx(4e6, rel=1e-12)
        assert rubber.poisson_ratio == 0.5


def test_the_tangential_modulus_is_the_chapters(scene):
    """G* = 4 G/(2 - nu) (19.18), with G = E/(2(1 + nu))."""
    steel = scene(loading=PULL, **FRICTION)
    shear = 210e9 / (2 * 1.3)
    assert steel.tangential_modulus == pytest.approx(4 * shear / (2 - 0.3), rel=1e-14)


def test_quantities_follow_from_the_physics_and_what_is_prescribed_is_not_compared(scene):
    (plan,) = plan_scene(scene(loading=PULL, **FRICTION))
    assert plan.scene.compare.quantities == ("tangential_force", "tangential_displacement")
    assert plan.compared == ("tangential_displacement",)
    (glued,) = plan_scene(scene(adhesion=GLUE))
    assert glued.compared == ("force", "contact_area", "pull_off_force")


@pytest.mark.parametrize("name", ["fretting-ball", "worn-ball"])
def test_a_scene_that_wears_compares_what_its_methods_give(name):
    """Fretting has friction, too, of whose forces they give none."""
    tables = tomllib.loads((builtin_folder() / f"{name}.toml").read_text(encoding="utf-8"))
    del tables["compare"]["quantities"]
    assert "worn_volume" in load_scene(tables).compare.quantities


def test_a_plain_scene_compares_force_and_penetration_at_each_other(scene):
    (plan,) = plan_scene(scene())
    assert plan.compared == ("force", "penetration", "contact_area")


def test_the_adhesive_estimate_is_jkr(scene):
    """Under no load a^3 = 9 pi w R^2/(2 E*) (Johnson, Kendall & Roberts 1971)."""
    glued = scene(adhesion=GLUE, loading={"force": [0.0]})
    geometry, _ = prepare(glued)
    exact = (9 * math.pi * 0.05 * 1e-4 / (2 * glued.effective_modulus)) ** (1 / 3)
    # The table of radii has steps of 0.9 %; grids are laid out with 5 % to spare.
    assert geometry.contact_radius == pytest.approx(exact, rel=0.01)


def test_the_estimate_of_an_impact_is_hertz(ball):
    """The work of F = (4/3) E* sqrt(R) d^1.5 stops the mass: d^2.5 = 15 m v^2/(16 E* sqrt(R))."""
    hit = ball(
        dynamics={"mass": "10 g", "velocity": [0.5, 1.0]},
        indenter={"shape": "paraboloid", "radius": 0.01},
    )
    geometry, _ = prepare(hit)
    depth = (15 * 0.01 / (16 * hit.effective_modulus * math.sqrt(0.01))) ** 0.4
    # `reduced.motion.elastic_impact.impact_depth` promises to be at most 1 % beyond it.
    assert depth <= geometry.penetration <= 1.01 * depth


def test_a_creeping_contact_is_estimated_with_the_softest_modulus(scene):
    rubber = scene(
        viscoelastic=RUBBER, half_space=SOFT, loading={"time": [0, 1], "force": ["1 N", "1 N"]}
    )
    geometry, _ = prepare(rubber)
    radius = (3 * 0.01 / (4 * 4e6)) ** (1 / 3)
    assert geometry.contact_radius == pytest.approx(radius, rel=1e-3)


def test_the_plan_names_what_is_switched_on_and_what_is_left_out(scene):
    (plan,) = plan_scene(scene(adhesion=GLUE))
    assert plan.switched_on[0][0] == "adhesion"
    assert "(JKR)" in plan.switched_on[0][1]
    left_out = dict(plan.left_out)
    assert left_out["inertia"] == "no [dynamics] in the scene: loading is quasi-static"
    assert not any("geometric overlap" in what for what in left_out)
    assert np.isfinite(plan.geometry.contact_radius)


def test_built_in_scenes_with_physics_are_a_suite():
    scenes = {name: load_scene(name) for name in builtin_names()}
    layered = {name for name, scene in scenes.items() if not scene.half_space.uniform}
    assert {name for name, scene in scenes.items() if scene.physics} | layered == set(
        SUITES["physics"]
    )
