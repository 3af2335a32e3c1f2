"""The elements, the exterior fields, the condensation and stresses inside the body."""

from functools import cache

import numpy as np
import pytest

from reference.elasticity import lame_parameters, largest_shear
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
from reference.fem.element_stiffness import facet_quadrature, shape_gradients, stiffness_matrices
from reference.fem.far_field import boussinesq, exterior_stiffness
from reference.fem.half_space_mesh import ring_mesh, tensor_mesh
from reference.loads import Load


def distorted_mesh(order):
    """Unequal bricks, or stretched curved rings for the triquadratic elements."""
    if order == 2:
        rings = np.array([0.5, 0.8, 1.0, 1.7])
        return ring_mesh(
            rings, np.array([0.0, 0.3, 1.0]), core_cells=2, round_from=1.0, stretch=(1.5, 1.0)
        )
    lines = np.array([0.0, 0.4, 1.0, 2.1])
    return tensor_mesh(lines, lines, lines, order=1, planes=(True, True))


def internal_forces(grid, displacement, nu):
    mesh = grid.mesh
    numbers = mesh.dofs.element_dofs.T
    forces = np.einsum(
        "eij,ej->ei", stiffness_matrices(mesh, nu), displacement[numbers].reshape(len(numbers), -1)
    )
    total = np.zeros_like(displacement)
    np.add.at(total, numbers.reshape(-1), forces.reshape(-1, 3))
    return total


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("nu", [-0.5, 0.0, 0.3, 0.499])
def test_linear_displacement_leaves_inner_nodes_free_of_force(order, nu):
    """Patch test: exact up to rounding (1e-10 covers the lambda/mu = 500 of nu = 0.499).

    Only for straight cells is a linear field's stress integral exact on *every* face; inside the
    body it is exact on curved cells too, because shape functions reproduce the coordinates.
    """
    grid = distorted_mesh(order)
    gradient = np.array([[0.3, -0.2, 0.5], [0.1, 0.7, -0.4], [-0.6, 0.2, -0.9]])
    points = grid.mesh.p.T
    forces = internal_forces(grid, points @ gradient.T, nu)
    boundary = np.unique(facet_quadrature(grid.mesh, grid.mesh.boundary_facets(), 2)[0])
    inner = np.setdiff1d(np.arange(len(points)), boundary)
    assert len(inner) > 0
    assert np.abs(forces[inner]).max() <= 1e-10 * np.abs(forces).max()
    # and the outer forces are those of the uniform stress: virtual work over the volume
    _, volumes = shape_gradients(grid.mesh, 3)
    lame, shear = lame_parameters(nu)
    strain = 0.5 * (gradient + gradient.T)
    stress = 2 * shear * strain + lame * np.trace(strain) * np.eye(3)
    np.testing.assert_allclose(forces.T @ points, stress * volumes.sum(), atol=1e-10)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("nu", [-0.9, -0.3, 0.0, 0.3, 0.4999])
def test_only_the_six_rigid_motions_of_an_element_are_free(order, nu):
    """With selective reduced integration there are no hourglass modes."""
    for matrix in stiffness_matrices(distorted_mesh(order).mesh, nu)[::5]:
        values = np.linalg.eigvalsh(matrix)
        assert np.all(np.abs(values[:6]) < 1e-12 * values[-1])
        # the largest is 1e4 times stiffer in compression than in shear at nu = 0.4999
        assert values[6] > 1e-7 * values[-1]


@pytest.mark.parametrize("nu", [-0.3, 0.0, 0.3, 0.49])
def test_boussinesq_field_is_in_equilibrium_and_carries_the_force(nu):
    """Gradient against central differences (1e-7), force through a hemisphere by quadrature."""
    rng = np.random.default_rng(2)
    points = rng.uniform([-2, -2, 0.3], [2, 2, 3], (20, 3))
    _, gradient = boussinesq(points, nu)
    step = 1e-5
    for axis in range(3):
        shift = step * np.eye(3)[axis]
        slope = (boussinesq(points + shift, nu)[0] - boussinesq(points - shift, nu)[0]) / (2 * step)
        np.testing.assert_allclose(gradient[..., axis], slope, atol=1e-7)
    lame, shear = lame_parameters(nu)
    grid = distorted_mesh(2)
    _, _, points, areas = facet_quadrature(grid.mesh, grid.outer, 8)
    areas = areas * np.sign((areas * points).sum(-1))[..., None]
    _, du = boussinesq(points, nu)
    stress = shear * (du + np.swapaxes(du, -1, -2))
    stress += lame * np.trace(du, axis1=-2, axis2=-1)[..., None, None] * np.eye(3)
    force = 4.0 * np.einsum("fqj,fqj->", stress[..., 2, :], areas)
    assert force == pytest.approx(-1.0, rel=2e-4)  # the mesh's outer circle is piecewise quadratic


def test_exterior_energy_does_not_depend_on_the_reference_surface():
    """Work theorem: energy outside a region falls as 1/size (the field has no length)."""
    energies = []
    for size in (1.0, 2.0):
        lines = size * np.array([0.0, 0.5, 1.0])
        grid = tensor_mesh(lines, lines, lines, order=2, planes=(True, True))
        energies.append(
            exterior_stiffness(
                *facet_quadrature(grid.mesh, grid.outer, 5)[2:], [np.zeros((1, 2))], 0.3
            )[0, 0]
        )
    assert energies[0] > 0.0
    assert energies[0] / energies[1] == pytest.approx(2.0, rel=1e-12)


def test_recovered_displacement_matches_compliance_and_balances_the_load():
    """The interior solution returns the condensed displacements; the stress meets the pressure.

    Averaged stress is extrapolated half an element to the surface: 5 % there at 4 elements.
    """
    body = half_space_body(RingMesh(2.0, elements=4), Material(5.0, 0.3))
    reactions = np.where(np.hypot(*body.points.T) < 1.0, body.weights, 0.0)
    fields = recover(body, reactions)
    displacement = body.scaled_compliance @ reactions / (5.0 * body.length)
    for point, value in zip(body.points[::7], displacement[::7], strict=True):
        node = np.flatnonzero(np.all(np.isclose(fields.points, [*point, 0.0]), axis=1))
        assert fields.displacement[node[0], 2] == pytest.approx(value, rel=1e-9)
    centre = np.all(fields.points == 0.0, axis=1)
    assert fields.stress[centre, 2][0] == pytest.approx(-1.0, rel=0.07)
    assert np.all(fields.von_mises >= 0.0)


def test_recovered_cells_have_positive_volume_and_fill_the_body():
    """Eight straight sub-cells for each curved element: chords of 11 degrees miss 0.6 %."""
    body = half_space_body(RingMesh(1.0, elements=4, extent=3.0), Material(1.0, 0.3))
    fields = recover(body, np.zeros(len(body.weights)))
    corners = fields.points[fields.cells]
    edges = corners[:, [1, 3, 4]] - corners[:, [0]]
    assert np.all(np.linalg.det(edges) > 0.0)
    # a hexahedron as six tetrahedra around its diagonal 0-6
    rim = [1, 2, 3, 7, 4, 5, 1]
    a = corners - corners[:, [0]]
    volume = sum(np.linalg.det(a[:, [rim[k], rim[k + 1], 6]]).sum() / 6.0 for k in range(6))
    assert abs(volume) == pytest.approx(0.25 * np.pi * 27.0, rel=0.008)


@cache
def hertz(elements=4, nu=0.3):
    body = half_space_body(RingMesh(1.0, edge=1.0, elements=elements), Material(1.0, nu))
    return next(indent(body, lambda x, y: 0.5 * (x**2 + y**2), Load("penetration", 1.0)))


@pytest.mark.slow
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
    largest = largest_shear(fields.stress)[axis]
    np.testing.assert_allclose(largest / peak, shear, atol=0.02)
    np.testing.assert_allclose(fields.von_mises[axis] / peak, 2 * shear, atol=0.04)
    top = np.argmax(largest)
    assert largest[top] / peak == pytest.approx(0.310, rel=0.04)
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


def test_uniform_gap_gives_uniform_pressure_at_gauss_points():
    """Under a soft penalty the pressure is eps times the overlap, at every point alike (1 %)."""
    lines = np.linspace(0.0, 1.0, 4)
    mesh = TensorMesh(lines, lines, symmetry="quarter", order=2)
    body = half_space_body(mesh, Material(1.0, 0.3))
    points = at_quadrature_points(body)
    level, soft = np.zeros(len(points.weights)), Enforcement(method="penalty", penalty=1e-3)
    (step,) = press(points, level, Load("penetration", 1.0), soft)
    assert np.ptp(step.pressure) < 0.01 * step.pressure.mean()
