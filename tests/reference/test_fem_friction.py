"""Friction by finite elements: the second opinion on the coupled half-space solver."""

import numpy as np
import pytest

from reference.errors import ConvergenceError
from reference.fem import Material, nodal_friction
from reference.fem.far_field import boussinesq, cerruti
from reference.fem.nodal_friction import frictional_body
from reference.halfspace.friction import FrictionalPress, sweep
from reference.halfspace.traction import Compliance, NormalAndTangential
from reference.loads import LoadPath

MU = 0.3


def path(pressing: int) -> tuple[np.ndarray, np.ndarray]:
    """Return a ball pressed to 0.8 in steps, then pulled, and back beyond its start."""
    shift = MU * 0.8 * np.array([0.3, 0.6, 0.9, 0.3, -0.3, -0.9])
    depth = np.concatenate([np.geomspace(0.1, 0.8, pressing), np.full(6, 0.8)])
    return depth, np.concatenate([np.zeros(pressing), shift])


def both(nu: float, elements: int, pressing: int = 8) -> list[tuple]:
    """Solve the same path of the same ball by both, G = 1."""
    depth, shift = path(pressing)
    loads = LoadPath("penetration", depth), LoadPath("tangential_displacement", shift)
    body = frictional_body(1.0, Material(2 * (1 + nu), nu), elements=elements)
    gap = (body.points**2).sum(axis=1) / 2
    x = (np.arange(44) - 21.6) / 20
    half_space = NormalAndTangential((44, 44), (1 / 20,) * 2, Compliance.of(1.0, nu))
    press = FrictionalPress(half_space, (x[:, None] ** 2 + x**2) / 2, MU)
    pairs = list(
        zip(nodal_friction.follow(body, gap, MU, *loads), sweep(press, *loads), strict=True)
    )
    return pairs[pressing - 1 :]


def check(pairs: list[tuple], bound: float) -> None:
    """Compare forces, over F and over mu F."""
    for one, other in pairs:
        assert one.force == pytest.approx(other.force, rel=bound)
        difference = one.tangential_force - other.tangential_force
        assert abs(difference) < bound * MU * other.force
        assert one.error <= 1e-7


def test_cerruti_meets_boussinesq_by_reciprocity():
    """u_z at x of a tangential force is -u_x at x of a normal one, on the surface."""
    points = np.array([[0.7, 0.4, 0.0], [-1.0, 2.0, 0.0]])
    for nu in (0.0, 0.3):
        normal, _ = boussinesq(points, nu)
        assert cerruti(points, nu)[:, 2] == pytest.approx(-normal[:, 0], rel=1e-13)


@pytest.mark.slow
@pytest.mark.parametrize("nu", [0.0, 0.2, 0.45])
def test_both_references_agree(nu):
    """Four elements per contact radius: 0.5 %. What springs leave out is 9 to 20 % (nu <= 0.3)."""
    check(both(nu, 4), 0.005)


def test_coulomb_holds_node_by_node():
    """|f_t| <= mu f_z, no tension, and no force normal to the plane of symmetry."""
    depth, shift = path(5)
    body = frictional_body(1.0, Material(2.0, 0.0), elements=2)
    gap = (body.points**2).sum(axis=1) / 2
    loads = LoadPath("penetration", depth), LoadPath("tangential_displacement", shift)
    for step in nodal_friction.follow(body, gap, MU, *loads):
        tangential = np.hypot(step.reactions[:, 0], step.reactions[:, 1])
        assert (step.reactions[:, 2] >= 0).all()
        assert (tangential <= MU * step.reactions[:, 2] * (1 + 1e-12)).all()
        assert (step.reactions[body.fixed, 1] == 0).all()


def test_refusals():
    body = frictional_body(1.0, Material(1.0, 0.2), elements=2)
    gap = np.zeros(len(body.points))
    loads = LoadPath("penetration", 1.0), LoadPath("tangential_displacement", 0.0)
    with pytest.raises(ValueError, match="gap"):
        nodal_friction.follow(body, gap[1:], MU, *loads)
    with pytest.raises(ConvergenceError, match="node by node"):
        next(nodal_friction.follow(body, gap, MU, *loads, max_sweeps=2))


def test_prescribed_forces_are_those_of_the_prescribed_displacements():
    depth, shift = path(5)
    body = frictional_body(1.0, Material(2.4, 0.2), elements=2)
    gap = (body.points**2).sum(axis=1) / 2
    moves = LoadPath("penetration", depth), LoadPath("tangential_displacement", shift)
    driven = list(nodal_friction.follow(body, gap, MU, *moves))
    forces = (LoadPath(k, [getattr(s, k) for s in driven]) for k in ("force", "tangential_force"))
    for one, other in zip(nodal_friction.follow(body, gap, MU, *forces), driven, strict=True):
        assert one.penetration == pytest.approx(other.penetration, rel=1e-5)
        apart = one.tangential_displacement - other.tangential_displacement
        assert abs(apart) < 1e-4 * MU * other.penetration
        assert one.force == pytest.approx(other.force, rel=1e-6)


def test_forces_beyond_friction_are_not_found():
    """F_x = 1.2 mu F is no equilibrium, and the search says so."""
    body = frictional_body(1.0, Material(2.4, 0.2), elements=2)
    gap = (body.points**2).sum(axis=1) / 2
    pulled = LoadPath("tangential_force", [0.0, 1.2 * MU])
    with pytest.raises(ConvergenceError, match="full sliding"):
        list(nodal_friction.follow(body, gap, MU, LoadPath("force", [1.0, 1.0]), pulled))
    with pytest.raises(ValueError, match="control must be one of penetration, force"):
        nodal_friction.follow(body, gap, MU, pulled, pulled)
