"""Tables of physics: what they say, and every fault told with its path, all at once."""

import math
import tomllib
from pathlib import Path

import numpy as np
import pytest

from comparisons.geometry.prepare import prepare
from comparisons.scene.loading import loads_of
from comparisons.scene.physics.tables.viscoelastic import Viscoelastic
from comparisons.scene.scene import (
    SUITES,
    SceneError,
    builtin_folder,
    builtin_names,
    load_scene,
    make_scene,
    override,
)
from comparisons.solving.planning import plan_scene

STEEL = {"youngs_modulus": "210 GPa", "poisson_ratio": 0.3}
SOFT = {"youngs_modulus": "3 MPa", "poisson_ratio": 0.5}
ALIKE = {"shear_modulus": "80.77 GPa", "poisson_ratio": 0.3}
PAIR = {"counter_body": SOFT, "half_space": SOFT}
UNSPLIT = {"half_space": {"effective_modulus": 1e9}}
LAYER = {"thickness": 0, "youngs_modulus": "soft", "poisson_ratio": 0.51}
STRANGE = {"yield_stress": -1, "hardening_exponent": 2, "model": "best", "cap": 1}
SOLID = {"model": "standard", "shear_moduli": ["1 MPa", "9 MPa"], "viscosities": "90 kPa s"}
PRONY = {"model": "prony", "shear_moduli": [1e6, 2e6], "relaxation_times": [1, 2]}
RUBBER = {"viscoelastic": SOLID}
MASS = {"dynamics": {"mass": 1, "velocity": 1}}
PUNCH = {"shape": "cylinder", "radius": 0.01}
WAVE = {"amplitude": 1e-6, "wavelength": 1e-3}
PULL = {"force": "10 N", "tangential_force": ["1 N", "-1 N"]}
HISTORY = {"time": [0, "10 ms", "30 ms"], "penetration": [0, "1 um", 0]}
FRICTION = {"friction": {"coefficient": 0.3}}
GLUE = {"adhesion": {"work": "50 mJ/m^2"}}
SLIDES = {"sliding": {"speed": 1}}
ROUGHNESS = {"rms_height": 1e-6, "longest": 1e-3, "shortest": 1e-5}
BODY = {"file": "a.msh", "length_unit": "m", "contact_surface": "a", "supports": {"b": "x"}}
FACE = {"kind": "self_affine", "hurst": 0.8, "size": "1 um", "points": 16, "rms_slope": 0.1}
WRONG = {
    "paraboloid": [
        ({"loading": PULL}, "loading.tangential_force: expected a [friction] table"),
        (FRICTION, "friction: expected loading.tangential_force"),
        (RUBBER, "viscoelastic: expected loading.time"),
        (SLIDES, "sliding: expected [viscoelastic]"),
        ({"loading": {"time": [1], "force": [1]}}, "loading.time: expected [viscoelastic] or"),
        ({"loading": {"force": [1], "substeps": 3}}, "loading.substeps: expected a path"),
        ({"loading": {"force": [0, -1]}}, "loading.force: expected positive finite values"),
        ({"loading": PULL} | UNSPLIT | FRICTION, "E or G with nu: tangential contact needs two"),
        ({"loading": PULL, "counter_body": SOFT, **FRICTION}, "counter_body: expected no [fric"),
        (
            {"loading": PULL, "half_space": STEEL, "counter_body": ALIKE, **FRICTION},
            'drop counter_body, halve E, set friction.coupling = "none"',
        ),
        (PAIR | {"wear": {"coefficient": 1e-13}}, "presses like both: drop counter_body"),
        (GLUE | SLIDES | RUBBER, "adhesion: expected no [sliding] beside it"),
        (RUBBER | {"loading": HISTORY | {"time": [0, 1]}}, "one for each of the 3 loads, got 2"),
        (
            RUBBER | {"half_space": SOFT, "loading": {"time": [0, 1], "force": [1, -1]}},
            "loading.force: expected no negative force without [adhesion]",
        ),
        (RUBBER | {"loading": HISTORY}, "alone, or a shear modulus of 1e+06 Pa or 1e+07 Pa"),
        (MASS | {"loading": {"penetration": [1e-6]}}, "its times (loading.time) with [dynamics]"),
        (
            {"dynamics": {"mass": 1, "velocity": 0}, "loading": {"time": [0, 1]}},
            "dynamics.velocity: expected above zero, or a loading.force",
        ),
        (
            {
                "friction": {"coefficient": -1, "law": "coulomb"},
                "adhesion": {"work": "50 mJ", "range": "-1 nm"},
                "viscoelastic": SOLID | {"shear_moduli": [1e6], "viscosities": [1e3, 1e3]},
                "loading": {"penetration": "1 um", "time": [0.0, 0.0]},
            },
            "friction.coefficient: expected a positive finite number, got -1",
            "friction.law: unknown key",
            "adhesion.work: expected a unit of kg s^-2",
            "adhesion.range: expected a not negative finite length, got '-1 nm'",
            "viscoelastic: shear_moduli: expected 2 of them, got 1; viscosities: expected 1",
            "loading.time: expected strictly increasing times",
            "friction: expected no [viscoelastic] beside it",
            "friction: expected loading.tangential_force or loading.tangential_displacement",
        ),
        (
            {"viscoelastic": PRONY, "loading": {"penetration": ["1 um"], "time": [1]}},
            "expected 1, one for each dashpot, got 2; the moduli begin with the long-term G0",
        ),
        (
            {"compare.quantities": ["restitution", "friction_coefficient", "worn_volume"]},
            "restitution: expected [dynamics] in the scene",
            "friction_coefficient: expected [friction] or [sliding] in the scene",
            "worn_volume: expected [wear] in the scene",
        ),
        ({"rolling": {"creep": 0.1}, "loading": {"force": 1.0}}, "rolling: expected [friction]"),
        ({"loading": {"force": 1, "squeeze_speed": 1e-3}}, "there is no film"),
        ({"surface2": FACE}, "surface2: expected a [surface] beside it"),
        ({"loading": None}, "loading: expected, but missing"),
        (
            {"counter_body.thickness": 1},
            "counter_body.thickness: expected it in [half_space] alone",
        ),
        (
            RUBBER | {"half_space": SOFT, "loading": {"time": [0, 1], "force": [0, 0]}},
            "loading.force: expected at least one positive force",
        ),
        ({"half_space.layers": []}, "half_space.layers: expected at least one layer"),
        (
            {"viscoelastic": PRONY | {"shear_moduli": [1, 0, 1]}, "loading": HISTORY},
            "shear_moduli: expected positive moduli, but for G0",
        ),
        (PAIR | {"indenter": PUNCH}, "an elastic punch is not a half-space"),
        (PAIR | {"body": BODY}, "the indenter of a meshed body is rigid"),
        ({"counter_body": {"youngs_modulus": 1e9}}, "counter_body: expected youngs_modulus and"),
        (UNSPLIT | {"half_space.thickness": 1.0}, "two elastic constants"),
        (
            {
                "half_space.thickness": -1,
                "half_space.layers": [LAYER],
                "half_space.grading": {"exponent": 1.0, "depth": "1 mm"},
                "counter_body": {"effective_modulus": 1e9},
                **FRICTION,
            },
            "half_space.thickness: expected a positive finite length, got -1",
            "half_space.layers.0.thickness: expected a positive",
            "half_space.layers.0.youngs_modulus",
            "half_space.layers.0.poisson_ratio: expected a number with -1 < nu <= 0.5, got 0.51",
            "half_space.grading.exponent: expected a number with -1 < k < 1",
            "half_space.grading: expected no layers and thickness beside it",
            "counter_body: expected none beside half_space.layers",
            "half_space.layers: expected no [friction]",
        ),
    ],
    "plastic-ball": [
        (
            UNSPLIT | {"plasticity": STRANGE, "loading": {"mean_gap": 1e-6}} | FRICTION,
            *("yield_stress", "hardening_exponent", "model", "cap", "nu:", "no [friction]"),
        ),
        (
            {"plasticity.hardening": 1e9, "plasticity.hardening_exponent": 0.1},
            "one of hardening and hardening_exponent",
        ),
        ({"loading": {"force": [1.0, -1.0]}}, "no negative force"),
    ],
    "rolling-ball": [
        (
            {
                "rolling": {"creep": [0.1, 0.1], "lateral_creep": "fast", "spin": "1 m"},
                "loading": {"force": 1.0, "tangential_force": 0.1},
                **GLUE,
            },
            *("strictly increasing creeps", "lateral_creep", "spin"),
            *("tangential_force: expected none", "no [adhesion]"),
        ),
        ({"rolling": {"creep": [1, 2], "lateral_creep": [1, 2]}}, "one value beside several"),
    ],
    "soft-ball-film": [
        (
            {"lubrication.viscosity": 0, "lubrication.waviness": {"amplitude": 0, "wavelength": 1}},
            *("viscosity: expected a positive", "amplitude: expected a positive"),
        ),
        ({"lubrication.speed": None}, "expected speed or loading.squeeze_speed, got none"),
        ({"loading.squeeze_speed": 1}, "or loading.squeeze_speed, got both"),
        ({"loading": {"penetration": 1e-6}}, "expected a force with"),
        ({"lubrication.speed": [2, 1]}, "strictly increasing"),
        (
            {"lubrication.slide_to_roll": 1, "lubrication.speed": 1, "lubrication.waviness": WAVE},
            "expected 2: a rough ball that moves",
        ),
        ({"lubrication.roughness": ROUGHNESS}, "expected from 1 to 16 times shortest"),
    ],
    "worn-ball": [
        ({"wear.coefficient": 0}, "expected a positive finite wear coefficient"),
        ({"wear.coefficient": "1 mm"}, "wear.coefficient"),
        ({"wear.amplitude": "1 um"}, "sliding_distance, or amplitude and cycles"),
        ({"wear.sliding_distance": [0.1, 0.05]}, "strictly increasing"),
        (FRICTION, "all of the contact slips"),
        ({"loading.force": [1.0, 2.0]}, "expected one load with [wear]"),
        ({"loading.force": {"from": 1.0, "to": 2.0, "steps": 3}}, "[wear], which is held, got 3"),
        ({"plasticity": {"yield_stress": 1e9}}, "wear on a half-space that yields"),
    ],
    "worn-rough": [({"loading.force.values": [0.01, 0.02]}, "expected one load with [wear]")],
    "fretting-ball": [
        ({"friction.coupling": "full"}, 'friction.coupling: expected "none"'),
        ({"friction": None}, "wear.amplitude: expected [friction]"),
        ({"wear.cycles": None}, "sliding_distance, or amplitude and cycles"),
        ({"loading.tangential_force": [1.0]}, "whose motion is in its own table"),
        (UNSPLIT, "E or G with nu"),
    ],
    "rough-patch": [({"surface2": FACE | {"periodic": True}}, "both surfaces periodic, or both")],
}


def changed(source, changes):
    """Return the tables of a built-in scene with other keys, by path; None takes a key away."""
    tables = tomllib.loads((builtin_folder() / f"{source}.toml").read_text(encoding="utf-8"))
    for path, value in changes.items():
        *folders, last = path.split(".")
        inside = tables
        for folder in folders if value is None else ():
            inside = inside[folder]
        if value is None:
            del inside[last]
        else:
            override(tables, path, value)
    return tables


@pytest.mark.parametrize("source", WRONG)
def test_what_makes_no_sense_is_refused_with_the_reason(source):
    for changes, *reasons in WRONG[source]:
        with pytest.raises(SceneError) as caught:
            load_scene(changed(source, changes))
        told = "\n".join(caught.value.problems)
        for reason in reasons:
            assert reason in told, (changes, told)


@pytest.mark.parametrize(
    ("below", "young"),
    [
        (STEEL, (1 - 0.3**2) / ((1 - 0.3**2) / 210 + (1 - 0.2**2) / 70)),  # in GPa
        ({"shear_modulus": "80 GPa", "poisson_ratio": 0.25}, 0.9375 / (0.75 / 160 + 0.96 / 70)),
        ({"effective_modulus": "230 GPa"}, None),
        (STEEL | {"layers": [STEEL | {"thickness": 1e-6}]}, None),
    ],
)
def test_one_body_is_advised_in_place_of_two_where_it_first_yields_at_the_same_load(below, young):
    """E' = (1 - nu^2)/(1/E1* + 1/E2*), nu that of the body that yields."""
    glass = {"youngs_modulus": "70 GPa", "poisson_ratio": 0.2}
    changes = {"half_space": below, "counter_body": glass, "plasticity": {"yield_stress": 1e9}}
    with pytest.raises(SceneError) as caught:
        load_scene(changed("paraboloid", changes))
    told = "\n".join(caught.value.problems)
    assert "counter_body: expected no [plasticity] beside it" in told
    assert ("drop counter_body" in told) == (young is not None)
    if young is not None:
        assert f'half_space.youngs_modulus = "{young:.5g} GPa"' in told


def test_a_meniscus_inside_the_contact_is_refused():
    """Hertz: (3 x 0.2 N x 10 mm/(4 x 1 MPa))^(1/3) = 1.145 mm."""
    inside = load_scene("soft-ball-film", {"lubrication.meniscus": "1.1447 mm"})
    with pytest.raises(SceneError, match=r"1.14470\u202fmm, got a radius of 1.14471\u202fmm$"):
        prepare(inside)
    assert prepare(load_scene("soft-ball-film", {"lubrication.meniscus": "1.1448 mm"}))


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
    loads = loads_of(scene(viscoelastic=SOLID, half_space=SOFT, loading=HISTORY | {"substeps": 2}))
    assert (loads.control, loads.axis) == ("penetration", "time")
    assert loads.times == pytest.approx([0, 0.005, 0.01, 0.02, 0.03], rel=1e-15)
    assert loads.values == pytest.approx([0, 5e-7, 1e-6, 5e-7, 0], abs=1e-22)


SPEEDS = {"from": "1 mm/s", "to": "1 m/s", "steps": 4, "spacing": "log"}
STRIKES = {"mass": "10 g", "velocity": ["1 cm/s", "1 m/s"]}


@pytest.mark.parametrize(
    ("tables", "axis", "values"),
    [
        (GLUE | {"loading": {"force": ["1 N", "-1 mN", 0]}}, "step", [1.0, -1e-3, 0.0]),
        (
            {"viscoelastic": SOLID, "sliding": {"speed": SPEEDS}, "loading": {"force": "2 N"}},
            "speed",
            [1e-3, 1e-2, 0.1, 1.0],
        ),
        ({"dynamics": STRIKES}, "velocity", [0.01, 1.0]),
        (
            {"dynamics": STRIKES | {"velocity": 0}, "loading": {"time": [0, 1], "force": [0, 1]}},
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
    own = scene(viscoelastic=SOLID, half_space=SOFT, loading=HISTORY).viscoelastic
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
        rubber = scene(viscoelastic=SOLID, half_space=half_space, loading=HISTORY)
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
    (glued,) = plan_scene(scene(**GLUE))
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
    glued = scene(**GLUE, loading={"force": [0.0]})
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
        viscoelastic=SOLID, half_space=SOFT, loading={"time": [0, 1], "force": ["1 N", "1 N"]}
    )
    geometry, _ = prepare(rubber)
    radius = (3 * 0.01 / (4 * 4e6)) ** (1 / 3)
    assert geometry.contact_radius == pytest.approx(radius, rel=1e-3)


def test_the_plan_names_what_is_switched_on_and_what_is_left_out(scene):
    (plan,) = plan_scene(scene(**GLUE))
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
