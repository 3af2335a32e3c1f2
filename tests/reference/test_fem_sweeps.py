"""Contact algorithms over their whole range: penalties, random shapes, rough patches."""

from functools import cache

import numpy as np
import pytest

from reference.contact import press as unilateral
from reference.errors import ConvergenceError
from reference.fem import Enforcement, Material, RingMesh, TensorMesh, half_space_body, press
from reference.halfspace import FreeOperator
from reference.loads import Load


@cache
def body():
    return half_space_body(RingMesh(1.0, elements=4), Material(1.0, 0.3))


def paraboloid():
    return 0.5 * (body().points ** 2).sum(axis=1)


def penalty_sweep():
    """Rows (eps h/E*, relative force error, iterations, condition estimate, broken)."""
    (exact,) = press(body(), paraboloid(), Load("penetration", 1.0))
    stiffness = np.linalg.inv(body().scaled_compliance)
    weights = body().scaled_weights * exact.active
    for penalty in 10.0 ** np.arange(9):
        per_area = penalty / (1 - 0.3**2) / body().spacing_scaled
        condition = np.linalg.cond(stiffness + np.diag(per_area * weights))
        try:
            (step,) = press(
                body(),
                paraboloid(),
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


def random_gap(rng):
    """Return several bumps, a power law, noise and holes: anything but convex."""
    x, y = body().points.T
    gap = rng.uniform(0.2, 2.0) * np.hypot(x, y) ** rng.uniform(0.5, 6.0)
    for _ in range(rng.integers(0, 4)):
        centre, width = rng.uniform(-1, 1, 2), rng.uniform(0.1, 0.6)
        distance = np.hypot(x - centre[0], y - centre[1])
        gap += rng.uniform(-0.5, 0.5) * np.exp(-((distance / width) ** 2))
    gap += rng.uniform(0.0, 0.2) * rng.random(len(gap))
    gap -= gap.min()
    if rng.random() < 0.3:
        gap[rng.random(len(gap)) < 0.3] = np.inf
    return gap


def random_load(rng, gap):
    """Return a force of any size, or a depth that overlaps with 2 to 100 % of the points."""
    if rng.integers(2):
        return Load("force", 10.0 ** rng.uniform(-3, 1))
    return Load("penetration", np.quantile(gap[np.isfinite(gap)], rng.uniform(0.02, 1.0)))


def settle(count):
    """Return iterations and violations of the active set over random shapes, loads and starts.

    Half of them start from a random contact set, which has tension and overlap all over.
    """
    rng = np.random.default_rng(20)
    result = []
    for _ in range(count):
        gap = random_gap(rng)
        start = rng.random(len(gap)) < rng.random() if rng.integers(2) else None
        (step,) = press(body(), gap, random_load(rng, gap), start=start)
        result.append((step.iterations, step.violation, step.active.mean()))
    return np.array(result)


def test_active_set_settles_on_random_shapes():
    """Fifty of the five hundred of the slow test."""
    iterations, violation, share = settle(50).T
    assert violation.max() < 1e-9
    assert np.median(iterations) <= 12
    assert np.ptp(share) > 0.3  # from few points to much of the mesh


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
    """Return the shares of the force on the parts of the patch."""
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
