"""Scenes that are no contact mechanics are questioned: missing units, slopes that are not small."""

import pytest

from comparisons.geometry.plausibility import CHECK
from comparisons.scene.scene import builtin_names, load_scene, validated
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


def test_a_modulus_without_its_unit_is_questioned():
    """210 Pa for 210 GPa: Hertz, a = (3 F R/(4 E*))^(1/3) = 319 mm, d = a^2/R = 10.2 m."""
    units, slopes = checks(youngs_modulus=210, poisson_ratio=0.3)
    assert "E* = 231\u202fPa is softer than any gel (1.00\u202fkPa)" in units
    assert "deeper than wide" in units
    assert "10.2\u202fm is 31.9 times the contact radius of 319\u202fmm" in slopes


def test_what_is_stiffer_than_diamond_is_questioned():
    (units,) = checks(effective_modulus=210e12)
    assert "E* = 210\u202fTPa is stiffer than diamond (2.00\u202fTPa)" in units


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
    assert sum("(a/R of a ball)" in note for note in result) == told


def test_steel_is_not_questioned():
    assert checks(youngs_modulus="210 GPa", poisson_ratio=0.3) == []


@pytest.mark.parametrize(
    ("scene", "changes", "said"),
    [
        (
            "adhesive-ball",
            {"adhesion.work": "3178 J/m^2"},  # E* R/(2 pi): a = R at d = 0
            "a contact of radius 9.97\u202fmm, which without it takes a penetration of 0.997 times",
        ),
        ("rolling-ball", {"rolling.creep": 2.0}, "a creep of 2.00 is 200\u202f% of the speed"),
        (
            "plastic-ball",
            {"plasticity.hardening": "500 GPa"},
            "a hardening of 500\u202fGPa is steeper than E = 210\u202fGPa",
        ),
    ],
)
def test_adhesion_creep_and_hardening_beyond_any_material_are_questioned(scene, changes, said):
    (plan,) = plan_scene(load_scene(scene, changes | {"compare.methods": ["reduced"]}))
    (doubt,) = plan.doubts
    assert said in doubt


@pytest.mark.slow
def test_of_the_built_in_scenes_those_with_steep_flanks_are_questioned():
    steep = {
        name for name in builtin_names() for plan in plan_scene(load_scene(name)) if plan.doubts
    }
    assert steep <= {"sphere", "impact-rubber"}
