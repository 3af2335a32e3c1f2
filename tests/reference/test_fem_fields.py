"""Stresses inside the body, and contact at Gauss points."""

from functools import cache

import numpy as np
import pytest

from reference.fem import (
    Enforcement,
    Material,
    RingMesh,
    TensorMesh,
    at_quadrature_points,
    half_space_body,
    indent,
    press,
    recover,
)
from reference.loads import Load


@cache
def hertz(elements=4, nu=0.3):
    body = half_space_body(RingMesh(1.0, edge=1.0, elements=elements), Material(1.0, nu))
    return next(indent(body, lambda x, y: 0.5 * (x**2 + y**2), Load("penetration", 1.0)))


def test_von_mises_and_largest_shear_on_the_axis_are_those_of_hertz():
    """Johnson 1985, eqs. 3.45, nu = 0.3: largest at 0.481 a, shear 0.310 p0, von Mises 0.620 p0.

    On the axis ``s_r = -p0 [(1 + nu)(1 - t) - 1/(2 (1 + z^2))]`` with ``t = z atan(1/z)`` and
    ``s_z = -p0/(1 + z^2)``. Nodal averages of elements of a/4 are good to 2 % of p0.
    """
    body, step = hertz()
    fields = recover(body, step.reactions)
    peak = 2.0 * body.effective_modulus / np.pi
    axis = np.flatnonzero((fields.points[:, :2] == 0.0).all(axis=1))
    z = fields.points[axis, 2]
    axis, z = axis[(z > 0.1) & (z < 1.5)], z[(z > 0.1) & (z < 1.5)]
    radial = 0.5 / (1 + z**2) - 1.3 * (1 - z * np.arctan(1 / z))
    shear = 0.5 * np.abs(radial + 1.0 / (1 + z**2))
    np.testing.assert_allclose(fields.largest_shear[axis] / peak, shear, atol=0.02)
    np.testing.assert_allclose(fields.von_mises[axis] / peak, 2 * shear, atol=0.04)
    top = np.argmax(fields.largest_shear[axis])
    assert fields.largest_shear[axis][top] / peak == pytest.approx(0.310, rel=0.04)
    assert fields.von_mises[axis][top] / peak == pytest.approx(0.620, rel=0.04)
    assert abs(z[top] - 0.481) < 0.15


def test_gauss_points_follow_the_contact_as_nodes_do():
    """Hertz at a depth that only the scaled mesh knows: 2e-4 in force, area from the stiffness.

    Interior fields come from the nodal forces.
    """
    body = half_space_body(RingMesh(1.0, edge=1.0, elements=4), Material(1.0, 0.3))
    soft = Enforcement("penalty", 1e4)
    for depth in (1e-6, 3.0):
        load = Load("penetration", depth)
        _, step = next(
            indent(body, lambda x, y: 0.5 * (x**2 + y**2), load, soft, points="quadrature")
        )
        exact = 4.0 / 3.0 * body.effective_modulus * depth**1.5
        assert step.force == pytest.approx(exact, rel=3e-4)
        assert step.contact_area == pytest.approx(np.pi * depth, rel=1e-3)


def test_rigid_contact_at_gauss_points_is_refused():
    body = half_space_body(RingMesh(1.0, edge=1.0, elements=2), Material(1.0, 0.3))
    points = at_quadrature_points(body)
    level = np.zeros(len(points.weights))
    for contact in ("active_set", "augmented_lagrangian"):
        with pytest.raises(ValueError, match="must be 'penalty' at quadrature points"):
            press(points, level, Load("penetration", 1.0), Enforcement(method=contact))
    with pytest.raises(ValueError, match="nodes as candidates"):
        at_quadrature_points(points)
    with pytest.raises(ValueError, match="'nodes' or 'quadrature'"):
        indent(body, lambda x, y: x**2 + y**2, Load("penetration", 1.0), points="corners")


def test_uniform_gap_gives_uniform_pressure_at_gauss_points():
    """Under a soft penalty the pressure is eps times the overlap, at every point alike (1 %)."""
    lines = np.linspace(0.0, 1.0, 4)
    mesh = TensorMesh(lines, lines, symmetry="quarter", order=2)
    body = half_space_body(mesh, Material(1.0, 0.3))
    points = at_quadrature_points(body)
    level, soft = np.zeros(len(points.weights)), Enforcement(method="penalty", penalty=1e-3)
    (step,) = press(points, level, Load("penetration", 1.0), soft)
    assert np.ptp(step.pressure) < 0.01 * step.pressure.mean()
