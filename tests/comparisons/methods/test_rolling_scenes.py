"""Scenes with [rolling]: springs, half-space, elements and theories, and what is wrong is told."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from comparisons.methods.registry import concerned
from comparisons.scene.scene import Scene

RUBBER = {"youngs_modulus": "3 MPa", "poisson_ratio": 0.5}
ROLLS = {"creep": [-0.002, 0.0, 0.001, 0.01]}


def rolling(scene, **tables) -> Scene:
    """Return a ball that rolls on rubber, but for what is given."""
    ball = {"half_space": RUBBER, "loading": {"force": "10 mN"}, "friction": {"coefficient": 0.3}}
    return scene(**ball | {"rolling": ROLLS} | tables)


@pytest.mark.parametrize(
    ("name", "resolution", "within"),
    [("fem", 8, 0.03), ("fastsim", 40, 0.08), ("reduced", 40, 0.55), ("kalker", 1, 0.7)],
)
def test_methods_stay_within_what_they_leave_out_of_the_half_space(
    solved, scene, name, resolution, within
):
    ball = rolling(scene)
    ours, truth = solved(ball, name, resolution), solved(ball, "bem_fft", 8)
    theirs = truth.quantities["traction"][0]
    assert_allclose(ours.quantities["traction"][0][:3], theirs[:3], rtol=within, atol=1e-12)
    assert theirs[1] == 0.0


def test_matched_springs_are_within_some_percent(solved, scene):
    ball = rolling(scene, methods={"reduced": {"rolling": "matched"}})
    ours, truth = solved(ball, "reduced", 40), solved(ball, "bem_fft", 12)
    assert_allclose(
        ours.quantities["traction"][0], truth.quantities["traction"][0], rtol=0.05, atol=1e-12
    )


def test_lateral_creep_drives_aside(solved, scene):
    aside = rolling(scene, rolling={"creep": 0.0, "lateral_creep": [-0.001, 0.001]})
    for name in ("reduced", "bem_fft", "fem", "fastsim", "kalker"):
        answer = solved(aside, name, {"kalker": 1}.get(name, 6), "lateral_force")
        force = answer.quantities["lateral_force"][0]
        assert_allclose(force[0], -force[1], rtol=1e-6)
        assert force[1] > 0
        assert_allclose(answer.quantities["tangential_force"][0], 0, atol=1e-6 * force[1])


def test_spin_drives_aside(solved, scene):
    spins = rolling(scene, rolling={"creep": 0.0, "spin": "0.02 m^-1"})
    forces = {
        name: solved(spins, name, resolution, "lateral_force").quantities["lateral_force"][0, 0]
        for name, resolution in {"bem_fft": 8, "fem": 6, "fastsim": 40, "kalker": 1}.items()
    }
    # six elements and eight cells per radius, of first order
    assert_allclose(list(forces.values()), forces["kalker"], rtol=0.13)
    assert forces["kalker"] > 0


def test_elements_soften_by_the_inertia_of_the_flow(solved, scene):
    flow = rolling(scene, methods={"fem": {"inertia": 0.1}})
    fast = solved(flow, "fem", 6).quantities["traction"][0]
    slow = solved(rolling(scene), "fem", 6).quantities["traction"][0]
    assert 0.93 < fast[2] / slow[2] < 0.99


def test_fields_tell_stick_from_slip_at_every_creep(solved, scene):
    ball = rolling(scene)
    fields = solved(ball, "bem_fft", 6, "pressure").fields
    assert np.nanmax(fields["friction_used"]) <= 1 + 1e-8
    assert np.nanmin(fields["friction_used"]) > 0.9  # the last creep: all slips
    still = fields["step.1.friction_used"]
    assert np.nanmax(still) == 0.0


def test_theories_of_rolling_are_no_part_of_other_plans(scene):
    pushed = scene(friction={"coefficient": 0.3}, loading={"force": 1.0, "tangential_force": 0.1})
    assert "fastsim" not in concerned(scene())
    assert "kalker" not in concerned(pushed)
    assert "kalker" in concerned(rolling(scene))
    assert "fastsim" in concerned(scene(compare={"methods": ["fastsim"]}))
