"""Three ways to the same contact: elimination by fronts, MKL Pardiso, conjugate gradients."""

import numpy as np
import pytest

from reference.errors import ConvergenceError
from reference.fem import (
    Enforcement,
    Material,
    RingMesh,
    TensorMesh,
    half_space_body,
    indent,
    pardiso,
    recover,
)
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


@pytest.mark.parametrize("control", ["penetration", "force"])
def test_conjugate_gradients_follow_the_load_curve_with_two_solves(control):
    """All depths of a paraboloid lie in the span of 1 and r^2; the force errs by a square."""
    direct, iterative = both(RingMesh(1.0, elements=3, edge=1.0))
    load = Load(control, [0.1, 0.5, 2.0])
    for (_, exact), (_, step) in zip(
        indent(direct, paraboloid, load), indent(iterative, paraboloid, load), strict=True
    ):
        assert step.force == pytest.approx(exact.force, rel=1e-9)
        assert step.penetration == pytest.approx(exact.penetration, rel=1e-9)
        assert np.array_equal(step.active, exact.active)
    assert len(iterative.flexibility.iterations) == 2


LINES = np.linspace(-1.1, 1.2, 6)
MESHES = {
    "quarter": RingMesh(1.0, elements=3, edge=1.0),
    "half": RingMesh(1.0, elements=2, edge=1.0, symmetry="half_x"),
    "whole": RingMesh(1.0, elements=2, symmetry="none"),
    "sharp": RingMesh(1.0, elements=2, edge=1.0, sharp=True),
    "elongated": RingMesh(1.0, elements=2, edge=1.0, stretch=(5.0, 0.2)),
    "bricks": TensorMesh(LINES, LINES),
    "straight": TensorMesh(LINES[3:] - LINES[3], LINES, "half_x", order=2),
}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "nu"), [*((kind, 0.3) for kind in MESHES), ("quarter", -0.5), ("quarter", 0.49)]
)
def test_conjugate_gradients_solve_the_equations_of_the_elimination(kind, nu):
    """On every kind of mesh: displacements to 2e-5, the total force, stationary, to 1e-8."""
    direct, iterative = both(MESHES[kind], nu)
    inside = np.flatnonzero(np.hypot(*(direct.points / direct.stretch).T) <= 1.0 + 1e-9)
    right = np.stack([np.ones(len(inside)), direct.points[inside, 0] ** 2], axis=1)
    rigid = np.zeros(len(inside))
    (exact, sunk), (forces, field) = (
        body.flexibility.respond(inside, right, rigid) for body in (direct, iterative)
    )
    np.testing.assert_allclose(forces.sum(axis=0), exact.sum(axis=0), rtol=1e-8)
    np.testing.assert_allclose(field, sunk, atol=2e-5 * np.abs(sunk).max())


def test_conjugate_gradients_take_as_many_steps_on_every_mesh():
    """They grow with the logarithm of radius over element, not with its root, 1.7 from 2 to 6."""
    steps = []
    for elements in (2, 6):
        mesh, material = RingMesh(1.0, elements=elements, edge=1.0), Material(1.0, 0.3)
        body = half_space_body(mesh, material, solver="conjugate_gradients")
        next(indent(body, paraboloid, Load("penetration", 1.0)))
        steps.append(max(body.flexibility.iterations))
    assert steps[1] <= 1.35 * steps[0] <= 40


def test_conjugate_gradients_recover_the_interior():
    """One more solve under the same nodal forces; 1e-5 of the largest displacement."""
    bodies = both(RingMesh(1.0, elements=2, edge=1.0))
    _, step = next(indent(bodies[0], paraboloid, Load("penetration", 1.0)))
    exact, result = (recover(body, step.reactions).displacement for body in bodies)
    np.testing.assert_allclose(result, exact, atol=1e-5 * np.abs(exact).max())


def test_conjugate_gradients_recover_the_interior_under_any_load():
    """Units of a power of two change no digit, though single precision ends at 1e-45."""
    body = half_space_body(
        RingMesh(1.0, elements=2), Material(1.0, 0.3), solver="conjugate_gradients"
    )
    reactions = np.zeros(len(body.nodes))
    reactions[3] = 1.0
    field = body.flexibility.interior(reactions)
    for unit in (2.0**-150, 2.0**150):
        np.testing.assert_array_equal(body.flexibility.interior(unit * reactions), unit * field)
    assert not body.flexibility.interior(0.0 * reactions).any()
    with pytest.raises(ConvergenceError, match="broke down"):
        body.flexibility.interior(np.nan * reactions)


def test_a_preconditioner_that_is_not_definite_is_no_convergence(monkeypatch):
    body = half_space_body(
        RingMesh(1.0, elements=2), Material(1.0, 0.3), solver="conjugate_gradients"
    )
    monkeypatch.setattr(body.flexibility, "_precondition", lambda residual, free: -residual)
    with pytest.raises(ConvergenceError, match="broke down") as caught:
        body.flexibility.interior(np.ones(len(body.nodes)))
    assert caught.value.history == [1.0]


def test_conjugate_gradients_refuse_springs_between_the_bodies():
    body = both(RingMesh(1.0, elements=2, edge=1.0))[1]
    with pytest.raises(ValueError, match="active_set"):
        next(indent(body, paraboloid, Load("penetration", 1.0), Enforcement(method="penalty")))


def both(mesh, nu=0.3):
    """Return the body condensed by nested dissection, and that of conjugate gradients."""
    solvers = "nested_dissection", "conjugate_gradients"
    return [half_space_body(mesh, Material(1.0, nu), solver=s) for s in solvers]
