"""Three ways to the same contact: elimination by fronts, MKL Pardiso, multigrid."""

from __future__ import annotations

import numpy as np
import pytest

from reference.fem import Enforcement, Material, RingMesh, half_space_body, indent, pardiso, recover
from reference.fem.multigrid import rigid_motions
from reference.loads import Load

needs_pardiso = pytest.mark.skipif(
    not pardiso.available(), reason="pypardiso (extra `fast`) is not installed"
)


def paraboloid(x, y):
    return 0.5 * (x**2 + y**2)


@needs_pardiso
def test_pardiso_condenses_to_the_same_compliance():
    """Both are direct: rounding times the condition of the matrix, 1e-11 is generous."""
    ours, theirs = (
        half_space_body(RingMesh(1.0, elements=3, edge=1.0), Material(1.0, 0.3), solver=solver)
        for solver in ("nested_dissection", "pardiso")
    )
    scale = np.abs(ours.scaled_compliance).max()
    np.testing.assert_allclose(
        theirs.scaled_compliance, ours.scaled_compliance, atol=1e-11 * scale, rtol=0
    )


@pytest.mark.slow
@pytest.mark.parametrize("control", ["penetration", "force"])
def test_multigrid_follows_the_load_curve_with_two_solves(control):
    """All depths of a paraboloid lie in the span of 1 and r^2; force to 1e-5 (energy norm)."""
    direct = half_space_body(RingMesh(1.0, elements=3, edge=1.0), Material(1.0, 0.3))
    multigrid = half_space_body(
        RingMesh(1.0, elements=3, edge=1.0), Material(1.0, 0.3), solver="multigrid"
    )
    load = Load(control, [0.1, 0.5, 2.0])
    for (_, exact), (_, step) in zip(
        indent(direct, paraboloid, load), indent(multigrid, paraboloid, load), strict=True
    ):
        assert step.force == pytest.approx(exact.force, rel=1e-5)
        assert step.penetration == pytest.approx(exact.penetration, rel=1e-5)
        assert np.array_equal(step.active, exact.active)
    assert len(multigrid.flexibility.iterations) == 2


def test_multigrid_recovers_the_interior():
    """One more solve under the same nodal forces; 1e-4 of the largest displacement."""
    bodies = [
        half_space_body(RingMesh(1.0, elements=2, edge=1.0), Material(1.0, 0.3), solver=solver)
        for solver in ("nested_dissection", "multigrid")
    ]
    _, step = next(indent(bodies[0], paraboloid, Load("penetration", 1.0)))
    exact, result = (recover(body, step.reactions).displacement for body in bodies)
    np.testing.assert_allclose(result, exact, atol=1e-4 * np.abs(exact).max())


def test_multigrid_refuses_springs_between_the_bodies():
    body = half_space_body(
        RingMesh(1.0, elements=2, edge=1.0), Material(1.0, 0.3), solver="multigrid"
    )
    with pytest.raises(ValueError, match="active_set"):
        next(indent(body, paraboloid, Load("penetration", 1.0), Enforcement(method="penalty")))


def test_rigid_motions_strain_nothing():
    """Every column is a translation or a rotation u = w x r of the points."""
    positions = np.random.default_rng(0).normal(size=(30, 3))
    components = np.repeat([0, 1, 2], 10)
    place = np.repeat(positions[:10], 3, axis=0)
    result = rigid_motions(place, np.tile([0, 1, 2], 10)).reshape(10, 3, 6)
    for column, axis in zip(range(3, 6), np.eye(3), strict=True):
        np.testing.assert_allclose(result[..., column], np.cross(axis, positions[:10]))
    assert rigid_motions(positions, components)[:, :3].sum() == 30


def test_an_unknown_solver_is_refused():
    with pytest.raises(
        ValueError,
        match="solver must be 'nested_dissection', 'pardiso' or 'multigrid', not 'gauss'",
    ):
        half_space_body(RingMesh(1.0), Material(1.0, 0.3), solver="gauss")
