"""Ways to the same contact of finite elements, over their whole range."""

from functools import cache

import numpy as np
import pytest

from reference.contact import press as unilateral
from reference.errors import ConvergenceError
from reference.fem import (
    Enforcement,
    Material,
    RingMesh,
    TensorMesh,
    half_space_body,
    indent,
    press,
    recover,
)
from reference.halfspace import FreeOperator
from reference.loads import Load


def paraboloid(x, y):
    return 0.5 * (x**2 + y**2)


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
    (exact, sunk), (forces, field) = (
        body.flexibility.respond(inside, right) for body in (direct, iterative)
    )
    np.testing.assert_allclose(forces.sum(axis=0), exact.sum(axis=0), rtol=1e-8)
    np.testing.assert_allclose(field, sunk, atol=2e-5 * np.abs(sunk).max())


@pytest.mark.slow
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
    monkeypatch.setattr(body.flexibility, "inverse", lambda load, touching: -load)
    with pytest.raises(ConvergenceError, match="broke down") as caught:
        body.flexibility.interior(np.ones(len(body.nodes)))
    assert caught.value.history == [1.0]


def both(mesh, nu=0.3):
    """Return the body condensed by nested dissection, and that of conjugate gradients."""
    solvers = "nested_dissection", "conjugate_gradients"
    return [half_space_body(mesh, Material(1.0, nu), solver=s) for s in solvers]


@cache
def body():
    return half_space_body(RingMesh(1.0, elements=4), Material(1.0, 0.3))


def paraboloid_gap():
    return 0.5 * (body().points ** 2).sum(axis=1)


def penalty_sweep():
    """Rows (eps h/E*, relative force error, iterations, condition estimate, broken)."""
    (exact,) = press(body(), paraboloid_gap(), Load("penetration", 1.0))
    stiffness = np.linalg.inv(body().scaled_compliance)
    weights = body().scaled_weights * exact.active
    for penalty in 10.0 ** np.arange(9):
        per_area = penalty / (1 - 0.3**2) / body().spacing_scaled
        condition = np.linalg.cond(stiffness + np.diag(per_area * weights))
        try:
            (step,) = press(
                body(),
                paraboloid_gap(),
                Load("penetration", 1.0),
                Enforcement(method="penalty", penalty=penalty),
            )
        except ConvergenceError:
            yield penalty, np.nan, np.nan, condition, True
            continue
        yield penalty, step.force / exact.force - 1.0, step.iterations, condition, False


def test_penalty_from_one_to_a_hundred_million_never_breaks():
    """Error -8.9 % at eps h/E* = 1, then in proportion to 1/eps down to rounding.

    A spring's flexibility is *added* to the compliance here, so nothing is lost at 1e8; the
    condition of the primal stiffness, which other programs factorise, grows with eps.
    """
    rows = np.array(list(penalty_sweep()))
    penalty, error, iterations, condition, broken = rows.T
    assert not broken.any()
    assert np.all(error < 0.0)
    late = penalty >= 10.0
    assert np.polyfit(np.log(penalty[late]), np.log(-error[late]), 1)[0] == pytest.approx(
        -1.0, abs=0.03
    )
    assert iterations.max() <= 10
    assert np.polyfit(np.log(penalty[-4:]), np.log(condition[-4:]), 1)[0] == pytest.approx(
        1.0, abs=0.05
    )


def rough_gap(x, y):
    """Return the gap of random waves, the shortest a third of the unit patch."""
    rng = np.random.default_rng(5)
    height = 0.0
    for _ in range(8):
        waves, phase = rng.uniform(-6 * np.pi, 6 * np.pi, 2), rng.uniform(0, 2 * np.pi)
        height = height + 0.02 * np.cos(waves[0] * x + waves[1] * y + phase)
    # the whole is a little round, so that contact stays away from the rim
    return 0.16 - height + 0.3 * ((x - 0.5) ** 2 + (y - 0.5) ** 2)


def parts(x, y, force):
    place = 2 * (x > 0.4) + (y > 0.4)
    return np.bincount(place.ravel(), force.ravel(), minlength=4) / force.sum()


def by_elements(cells, depth):
    lines = np.linspace(0.0, 1.0, cells + 1)
    rough = half_space_body(
        TensorMesh(lines, lines, order=2, growth=2.0, extent=2.0), Material(1.0, 0.3)
    )
    x, y = rough.points.T
    (step,) = press(rough, rough_gap(x, y), Load("penetration", depth))
    return np.array([step.force, *(parts(x, y, step.reactions) * step.force)])


def by_cells(points, depth):
    place = (np.arange(points) + 0.5) / points
    x, y = np.meshgrid(place, place, indexing="ij")
    operator = FreeOperator((points, points), (1 / points, 1 / points), 1 / (1 - 0.3**2))
    step = unilateral.press(operator, rough_gap(x, y), Load("penetration", depth))
    return np.array([step.force, *(parts(x, y, step.pressure) * step.force)])


@pytest.mark.slow
def test_rough_patch_agrees_with_the_half_space_solver():
    """Force, and the forces on the four parts, within the summed error estimates.

    Each solver's estimate is the change from its next coarser grid. The two share no code.
    """
    place = np.linspace(0.0, 1.0, 200)
    depth = float(rough_gap(*np.meshgrid(place, place)).min()) + 0.1
    coarse, fine = by_elements(9, depth), by_elements(13, depth)
    cells = [by_cells(points, depth) for points in (64, 128)]
    errors = np.abs(fine - coarse) + np.abs(cells[1] - cells[0])
    assert errors[0] < 0.1 * fine[0]  # the estimates say something
    assert np.all(np.abs(fine - cells[1]) <= errors)
