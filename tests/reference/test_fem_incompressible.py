"""Rubber: nu = 1/2 exactly, by displacements and mean stresses."""

from functools import cache

import numpy as np
import pytest

from reference.fem import Material, RingMesh, half_space_body, indent, recover
from reference.fem.element_stiffness import facet_quadrature, mixed_matrices, shape_gradients
from reference.fem.far_field import exterior_stiffness
from reference.fem.half_space_mesh import tensor_mesh
from reference.loads import Load


@cache
def rubber(elements=4, nu=0.5):
    return half_space_body(RingMesh(1.0, edge=1.0, elements=elements), Material(1.0, nu))


def hertz(body):
    fitted, step = next(indent(body, lambda x, y: 0.5 * (x**2 + y**2), Load("penetration", 1.0)))
    return fitted, step, step.force / (4.0 / 3.0 * body.effective_modulus) - 1.0


def test_hertz_force_on_rubber_converges_with_fourth_order():
    """Measured 6.9e-4, 1.7e-4, 4.9e-5 at 2, 3, 4 elements: as for compressible bodies."""
    sizes = np.array([2, 3, 4])
    errors = np.array([hertz(rubber(int(n)))[2] for n in sizes])
    assert np.all(errors > 0.0)
    assert errors[-1] < 2e-4
    assert -np.polyfit(np.log(sizes), np.log(errors), 1)[0] > 3.3


@pytest.mark.slow
def test_volume_is_kept_and_the_mean_stress_is_smooth():
    """Divergence has no mean in any element; no checkerboard: below the centre -s = 0.99 p0.

    On the axis of Hertz's contact with nu = 1/2 the mean stress is ``-p0 (1 - z/a atan(a/z))``
    (Johnson 1985, eqs. 3.45).
    """
    body, step, _ = hertz(rubber())
    fields = recover(body, step.reactions)
    mesh = body.grid.mesh
    gradients, volumes = shape_gradients(mesh, 3)
    u = fields.displacement[mesh.dofs.element_dofs.T] / body.length
    divergence = np.einsum("eqai,eai->eq", gradients, u)
    strain = np.linalg.norm(np.einsum("eqai,eaj->eqij", gradients, u), axis=(2, 3))
    mean = np.abs((divergence * volumes).sum(axis=1)) / (strain * volumes).sum(axis=1).max()
    assert mean.max() < 1e-12
    axis = np.flatnonzero((fields.points[:, :2] == 0.0).all(axis=1) & (fields.points[:, 2] < 1.0))
    z = fields.points[axis, 2] / body.length
    with np.errstate(divide="ignore"):
        exact = 1.0 - z * np.arctan(1.0 / z)
    peak = 2.0 * body.effective_modulus / np.pi
    result = -fields.stress[axis, :3].mean(axis=1) / peak
    np.testing.assert_allclose(result, exact, atol=0.03)


def test_mixed_element_is_symmetric_with_the_right_signs():
    """Positive on displacements (six rigid motions free), zero on mean stresses at nu = 1/2."""
    lines = np.array([0.0, 0.4, 1.0])
    matrix = mixed_matrices(
        tensor_mesh(lines, lines, lines, order=2, planes=(True, True)).mesh, 0.5
    )[0]
    np.testing.assert_allclose(matrix, matrix.T, atol=1e-14)
    values = np.linalg.eigvalsh(matrix[:81, :81])
    assert np.all(np.abs(values[:6]) < 1e-12 * values[-1])
    assert values[6] > 1e-5 * values[-1]
    assert np.all(matrix[81:, 81:] == 0.0)
    assert np.linalg.matrix_rank(matrix[:81, 81:]) == 4


def test_exterior_of_rubber_is_the_limit_of_nearly_incompressible_ones():
    """The mean stress of Boussinesq's field is finite: no jump from 0.4999 to 0.5."""
    lines = np.array([0.0, 0.5, 1.0])
    grid = tensor_mesh(lines, lines, lines, order=2, planes=(True, True))
    values = [
        exterior_stiffness(*facet_quadrature(grid.mesh, grid.outer, 5)[2:], [np.zeros((1, 2))], nu)[
            0, 0
        ]
        for nu in (0.4998, 0.4999, 0.5)
    ]
    assert values[2] == pytest.approx(2 * values[1] - values[0], rel=1e-6)
