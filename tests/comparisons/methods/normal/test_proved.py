"""Rough scenes between proved bounds: free patches and periods, under force and penetration."""

from functools import partial
from pathlib import Path

import numpy as np
import pytest

from comparisons.errors import InputError
from comparisons.methods.normal import proved as proofs
from comparisons.methods.normal.proved import enclosures
from comparisons.questions.single import solve_scene
from comparisons.scene.scene import load_scene
from comparisons.solving.planning import plan_scene
from reference.bounds.interval import Interval, inverse

BLOCK = Path(__file__).parents[4] / "docs" / "examples" / "block.toml"
FORCE = {"force": {"values": [0.05], "relative_to": "E* A0 h'"}}


@pytest.fixture
def proved(rough):
    asked = {"quantities": ["force", "penetration", "energy", "stiffness"], "proved": True}
    return partial(rough, compare=asked | {"tolerance": 0.05}, points=4, short_cutoff="0.5 um")


@pytest.mark.slow
@pytest.mark.parametrize(("periodic", "width"), [(False, 0.2), (True, 0.15)])
def test_penetration_at_a_force_and_force_at_that_penetration_are_enclosed(proved, periodic, width):
    """The half-space on 64 x 64 cells lies between bounds on 32 x 32.

    Four points a side are few: the bounds of the free patch are wide at its rim.
    """

    def solved(loading):
        """Solve on cells that are finer than those of the bounds."""
        return solve_scene(proved(periodic=periodic, loading=loading), "bem_fft", 64).columns()

    columns = solved(FORCE)
    depth = columns["penetration"]
    assert columns["penetration_lower"] < depth < columns["penetration_upper"]
    assert columns["penetration_upper"] / columns["penetration_lower"] - 1 < width
    assert "force_lower" not in columns
    for name in ("energy", "stiffness"):
        assert columns[f"{name}_lower"] < columns[name] < columns[f"{name}_upper"]
    again = solved({"penetration": list(depth)})
    assert again["force_lower"] < columns["force"] < again["force_upper"]
    assert again["force_upper"] / again["force_lower"] - 1 < 2.5 * width
    assert again["energy_lower"] < columns["energy"] < again["energy_upper"]
    assert again["stiffness_lower"] < columns["stiffness"] < again["stiffness_upper"]


@pytest.mark.slow
def test_a_load_at_which_nothing_is_proved_leaves_the_others_theirs(proved):
    """Cells of a period prove nothing of a contact far smaller than they are: NaN, no traceback."""
    loads = {"penetration": ["1e-15 m", "10 nm"]}
    (plan,) = plan_scene(proved(periodic=True, loading=loads))
    sides = enclosures(plan.scene, plan.geometry, plan.loads)
    assert np.isnan([sides["force_lower"][0], sides["force_upper"][0]]).all()
    assert 0 < sides["force_lower"][1] < sides["force_upper"][1]


class Sampled:
    """Bounds without width, which hand back depth, load and pressure as they are asked for them."""

    top = 0.0

    def __init__(self, *_):
        pass

    def mean_pressure(self, depth, _):
        return Interval(depth, depth)

    force = mean_pressure

    def penetration(self, load, _):
        return Interval(load, load)

    def stored(self, mean, depth, _):
        return depth

    def energy(self, depth, _):
        return depth

    def stiffness(self, *arguments):
        return arguments[0]  # the mean pressure of a period, the depth of a patch


@pytest.mark.parametrize("periodic", [False, True])
def test_depths_of_bounds_count_from_their_highest_sample(proved, periodic, monkeypatch):
    """Of the scene from the top of the surface, which lies above it."""
    (plan,) = plan_scene(proved(periodic=periodic, loading=FORCE))
    higher, area = 2e-9, plan.geometry.area
    highest = plan.geometry.top(0) - plan.geometry.heights(0, 4).mean()
    monkeypatch.setattr(Sampled, "top", highest - higher)
    monkeypatch.setattr(proofs, "PeriodicSurface" if periodic else "Patch", Sampled)
    proof = proofs.proof_of(plan.scene, plan.geometry)
    per = area if periodic else 1.0
    deep = proof.force(5e-9)
    np.testing.assert_allclose((deep.lower / per, deep.upper / per), 3e-9, rtol=1e-6)
    # what is short of the sample is not proved to touch, and bears less than what touches deeper
    short = proof.force(1e-9)
    assert (short.lower, short.upper / per) == (0.0, pytest.approx(1e-9, rel=1e-6))
    back = proof.penetration(3e-9 * per)
    np.testing.assert_allclose((back.lower, back.upper), 5e-9, rtol=1e-6)
    depth, load = Interval(5e-9, 6e-9), Interval(3e-9 * area, 4e-9 * area)
    energy = proof.energy(depth, load)
    np.testing.assert_allclose((energy.lower / per, energy.upper / per), (3e-9, 4e-9), rtol=1e-6)
    stiffness = proof.stiffness(depth, load)
    np.testing.assert_allclose(stiffness.lower / per, 3e-9, rtol=1e-6)
    for quantity in (proof.energy, proof.stiffness):
        with pytest.raises(ArithmeticError, match="not proved to touch"):
            quantity(Interval(1e-9, 6e-9), load)


def test_an_energy_that_underflows_is_not_enclosed():
    """Of 1e-300 N: d is 1e-203 m, and F d is no double-precision number."""
    (plan,) = plan_scene(load_scene("paraboloid", {"loading": {"force": ["1e-300 N", "1 N"]}}))
    sides = enclosures(plan.scene, plan.geometry, plan.loads)
    assert np.isnan([sides["energy_lower"][0], sides["energy_upper"][0]]).all()
    assert 0 < sides["penetration_lower"][0] < sides["penetration_upper"][0] < 1e-200
    assert 0 < sides["energy_lower"][1] < sides["energy_upper"][1]


def indented(shape, **keys):
    return {"indenter": {"shape": shape, **keys}}


SPHERE = indented("sphere", radius="1 mm") | {"half_space": {"effective_modulus": "1 GPa"}}


@pytest.mark.parametrize(
    ("scene", "changes", "reason"),
    [
        ("rough-free", {}, "one surface, .* the mean over 20000: surface.realisations = 1"),
        ("measured-map", {}, "a measured patch goes on between its points by splines"),
        ("rough-patch", {"surface.points": [60, 64]}, "of a free patch are for square ones"),
        ("rough-patch", {"surface.points": 256}, "more than 128 points a side .* minutes a load"),
        (
            "rough-patch",
            {"surface.periodic": True, "loading": {"penetration": ["1 um"]}},
            "up to a penetration of",
        ),
        ("rough-patch", {"loading": {"mean_gap": ["10 nm"]}}, "nothing .* prescribed mean_gap"),
        ("adhesive-ball", {}, "without friction, adhesion or memory"),
        ("friction-steel", {}, "without friction, adhesion or memory"),
        ("rubber-ball", {}, "without friction, adhesion or memory"),
        (BLOCK, {}, r"for a half-space, and the \[body\] is finite"),
        ("paraboloid", indented("profile", r=[0, 1e-3], f=[0, 1e-4]), "no bound"),
        ("paraboloid", indented("power_law", exponent=0.5, coefficient=0.1), "convex"),
        (
            "paraboloid",
            indented("ellipsoid", radius_x="1 mm", radius_y="1 m"),
            "the contact is 67.9 times as long as wide, .* ratios up to 60",
        ),
        (
            "paraboloid",
            indented("rectangle_punch", sides=["1 mm", "31 mm"]),
            "the face is 31 times as long as wide, .* ratios up to 30",
        ),
        (
            "paraboloid",
            SPHERE | {"loading": {"penetration": ["1.5 mm"]}},
            r"up to a penetration of 1.00\smm",
        ),
        (
            "paraboloid",
            SPHERE | {"loading": {"force": ["5 kN"]}},
            r"up to a force of 1.20\skN, and the largest is 5.00\skN",
        ),
    ],
)
def test_scenes_of_which_nothing_is_proved_are_refused_in_words(scene, changes, reason):
    with pytest.raises(InputError, match=f"compare.proved: .*{reason}"):
        plan_scene(load_scene(scene, changes | {"compare.proved": True}))


def test_an_argument_is_enclosed_by_what_was_tried_and_nothing_else():
    """Bounds of x^3 with kinks: inside; no upper end is claimed where none was reached."""

    def lower(x):
        return 0.98 * x**3 - (0.05 if x > 1.97 else 0.0)

    for guess in (0.1, 1.0, 2.0, 30.0):
        found = inverse(8.0, lower, lambda x: 1.03 * x**3, guess)
        assert 2.0 in found
        assert found.width < 0.03
    with pytest.raises(ArithmeticError, match="nothing is proved that reaches 8"):
        inverse(8.0, lambda x: min(lower(x), 7.0), lambda x: x**3, 1.0)
