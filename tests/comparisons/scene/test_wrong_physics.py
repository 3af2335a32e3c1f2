"""Tables of physics that make no sense: every fault is told with its path, all at once."""

import tomllib

import pytest

from comparisons.geometry.prepare import prepare
from comparisons.scene.scene import SceneError, builtin_folder, load_scene, override

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
