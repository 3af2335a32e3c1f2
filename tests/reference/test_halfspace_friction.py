"""Cerruti's kernels, tractions within friction bounds and coupled paths, by independent answers."""

import mpmath
import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipkm1

from reference.closed_form import PartialSlip, paraboloid, stiffness_ratio
from reference.contact.press import press
from reference.halfspace import areas
from reference.halfspace.friction import FrictionalPress, sweep, tangential_stiffness
from reference.halfspace.traction import Compliance, NormalAndTangential, cell_integrals
from reference.loads import Load, LoadPath
from reference.surfaces import SelfAffine, self_affine

MU = 0.4


def exact_cell(i: int, j: int, dx: float, dy: float) -> list:
    """Integrals of x^2/r^3, y^2/r^3, xy/r^3, x/r^2, y/r^2 over a cell, 40 digits."""
    with mpmath.workdps(40):
        a, b = (mpmath.mpf(i + s) * dx for s in (0.5, -0.5))
        c, d = (mpmath.mpf(j + s) * dy for s in (0.5, -0.5))

        def difference(f):
            return f(a, c) - f(a, d) - f(b, c) + f(b, d)

        def root(x, y):
            return mpmath.sqrt(x * x + y * y)

        def square(x, y):
            return y * mpmath.asinh(x / abs(y))

        def pull(x, y):
            return y * mpmath.log(root(x, y)) + x * mpmath.atan(y / x)

        return [
            difference(square),
            difference(lambda x, y: square(y, x)),
            -difference(root),
            difference(pull),
            difference(lambda x, y: pull(y, x)),
        ]


@pytest.mark.parametrize("sides", [(1.0, 1.0), (1.0, 7.0), (100.0, 1.0)])
def test_cell_integrals_to_all_digits(sides):
    """Near, at the change to Gauss points, and 1e4 cells away, in every quadrant: 1e-13."""
    for place in [(0, 0), (1, 0), (-1, 1), (5, -7), (16, 16), (17, -2), (0, 17), (-9000, 8000)]:
        exact = exact_cell(*place, *sides)
        result = cell_integrals(*place, sides)
        for part in (slice(0, 3), slice(3, 5)):
            largest = float(max(map(abs, exact[part]))) or 1.0
            gap = np.array([float(e) for e in exact[part]]) - np.array(result[part])
            assert np.abs(gap).max() < 1e-13 * largest


def paths(**loads):
    return [LoadPath(control, values) for control, values in loads.items()]


def body_of(points: int, width: float, nu: float, **options) -> NormalAndTangential:
    return NormalAndTangential(
        (points,) * 2, (width / points,) * 2, Compliance.of(1.0, nu), **options
    )


@pytest.mark.parametrize("periodic", [False, True])
def test_operators_are_reciprocal_and_positive(periodic):
    """Betti: the whole operator is symmetric; its energy is positive for every traction."""
    rng = np.random.default_rng(0)
    for nu in (-0.4, 0.0, 0.3, 0.5):
        body = NormalAndTangential((9, 14), (1.0, 0.7), Compliance.of(1.0, nu), periodic=periodic)
        q, r = rng.standard_normal((2, 2, 9, 14))
        p = rng.standard_normal((9, 14))
        assert (r * body.shear(q)).sum() == pytest.approx((q * body.shear(r)).sum(), rel=1e-12)
        lifted, dragged = (p * body.lift(q)).sum(), (q * body.drag(p)).sum()
        assert lifted == pytest.approx(dragged, rel=1e-9, abs=1e-12)
        p, q = p - p.mean(), q - q.mean(axis=(1, 2), keepdims=True)
        work = p * (body.normal.apply(p) + body.lift(q))
        assert (work + (q * (body.shear(q) + body.drag(p))).sum(axis=0)).sum() > 0


def test_free_operator_is_the_sum_over_cells():
    """FFT against the plain double sum with Johnson's (3.76) integrated cell by cell."""
    nu, G = 0.3, 1.0
    body = NormalAndTangential((4, 5), (1.0, 0.5), Compliance.of(G, nu))
    rng = np.random.default_rng(1)
    q, p = rng.standard_normal((2, 4, 5)), rng.standard_normal((4, 5))
    expected = np.zeros((3, 4, 5))
    for k in np.ndindex(4, 5):
        for m in np.ndindex(4, 5):
            xx, yy, xy, x, y = map(float, exact_cell(k[0] - m[0], k[1] - m[1], 1.0, 0.5))
            shear = np.array([[xx + (1 - nu) * yy, nu * xy], [nu * xy, yy + (1 - nu) * xx]])
            expected[:2, *k] += shear @ q[:, *m] / (2 * np.pi * G)
            pull = (1 - 2 * nu) / (4 * np.pi * G) * np.array([x, y])
            expected[:2, *k] -= pull * p[m]
            expected[2, *k] += pull @ q[:, *m]
    assert np.allclose(body.shear(q) + body.drag(p), expected[:2], rtol=0, atol=1e-13 * 5)
    assert np.allclose(body.lift(q), expected[2], rtol=0, atol=1e-13 * 5)


def test_a_wave_of_traction_shears_lifts_and_is_dragged():
    """Traction cos k.x moves by cos k.x/(G k) across k (antiplane), 1 - nu times that along k.

    Along k it lifts by (1 - 2 nu)/(2 G k) sin k.x; pressure drags as much backwards. To round-off.
    """
    nu, G = 0.3, 2.0
    body = NormalAndTangential((12, 16), (0.5, 0.25), Compliance.of(G, nu), periodic=True)
    x, y = np.ix_(np.arange(12) * 0.5, np.arange(16) * 0.25)
    k = 2 * np.pi * np.array([3 / 6.0, 5 / 4.0])
    wave, behind = np.cos(k[0] * x + k[1] * y), np.sin(k[0] * x + k[1] * y)
    along = (k / np.hypot(*k))[:, None, None]
    across = along[::-1] * np.array([-1, 1])[:, None, None]
    unit = 1 / (G * np.hypot(*k))
    pull = (1 - 2 * nu) / 2 * unit * behind
    for result, expected in (
        (body.shear(across * wave), unit * across * wave),
        (body.shear(along * wave), (1 - nu) * unit * along * wave),
        (body.lift(across * wave), 0.0),
        (body.lift(along * wave), pull),
        (body.drag(wave), -along * pull),
    ):
        assert np.abs(result - expected).max() < 1e-14 * unit
    for traction in (along * wave, across * wave):
        assert np.abs(body.near(body.shear(traction)) - traction).max() < 1e-13


@pytest.mark.slow
@pytest.mark.parametrize(("half_y", "bound"), [(1.0, 6e-4), (0.5, 4e-3)])
def test_ellipses_are_as_stiff_as_mindlin_says(half_y, bound):
    """k_x/k_z over nu, both directions: edges cost both alike, the ratio keeps 1e-4 to 4e-3.

    (64 cells along the long axis; the staircase of the 2:1 ellipse is the coarser one.)
    """
    x = (np.arange(66) - 32.5) / 32
    mask = np.hypot(x[:, None], x / half_y) < 1
    for nu in (-0.5, 0.0, 0.3, 0.5):
        body = body_of(66, 66 / 32, nu)
        normal = areas.contact_stiffness(body.normal, mask)
        for direction, axes in (((1.0, 0.0), (1.0, half_y)), ((0.0, 1.0), (half_y, 1.0))):
            along, across = tangential_stiffness(body, mask, direction)
            assert along / normal == pytest.approx(stiffness_ratio(*axes, nu), rel=bound)
            assert abs(across) < 1e-6 * along


def test_cattaneo_force_converges():
    """F_x(u) of the paraboloid, nu = 0: second order in the cell size over random grid offsets."""
    slip = PartialSlip(paraboloid(1.0, 2.0), 1.0, MU, 1.0)
    # half of the displacement at which all slides, mu d E*/G*
    u = 0.5 * slip.friction * slip.penetration / slip.modulus_ratio
    exact = slip.limit * (1 - 0.5**1.5)
    rng = np.random.default_rng(3)
    errors = []
    for points in (12, 24, 48):
        result = []
        for _ in range(8):
            shift = rng.uniform(size=2)
            x, y = ((np.arange(points) - points / 2 + s) * 2.3 / points for s in shift)
            body = body_of(points, 2.3, 0.0)
            gap = (x[:, None] ** 2 + y**2) / 2
            (step,) = sweep(
                FrictionalPress(body, gap, MU, coupled=False),
                *paths(penetration=1.0, tangential_displacement=[u]),
            )
            result.append(step.tangential_force / exact - 1)
        errors.append(np.sqrt(np.mean(np.square(result))))
    assert np.log2(errors[0] / errors[2]) / 2 > 1.7
    assert errors[2] < 2e-3


def test_a_periodic_path_at_zero_poisson_ratio_is_a_sum_of_normal_solutions():
    """One operator serves both directions: Jaeger's and Ciavarella's superposition on the grid.

    F_x = 0.6 mu F, then -0.2 mu F, on a rough surface. Slip keeps 1e-7, pressures are worse by the
    condition of a cell.
    """
    body = body_of(24, 24.0, 0.0, periodic=True)
    rough = SelfAffine(hurst=0.8, rms_slope=0.1, short_cutoff=4.0)
    height = self_affine(24, 24.0, rough, seed=0, realisation=0)
    gap, force = height.max() - height, 0.004 * 24.0**2
    *_, last = sweep(
        FrictionalPress(body, gap, MU, coupled=False),
        *paths(force=force, tangential_force=np.array([0.6, -0.2]) * MU * force),
        tolerance=1e-7,
    )
    whole, unmoved, turned = (
        press(body.normal, gap, Load("force", share * force), tolerance=1e-10).pressure
        for share in (1.0, 1 - 0.6, 1 - 0.8 / 2)
    )
    expected = MU * (whole - unmoved - 2 * (whole - turned))
    assert np.abs(last.traction[0] - expected).max() < 2e-4 * MU * whole.max()
    assert np.abs(last.traction[1]).max() < 2e-4 * MU * whole.max()


def conditions(body, step, before, coupled: bool) -> tuple[float, float]:
    """Slip of sticking cells, and slip off the direction of the traction, evaluated afresh."""
    u = body.shear(step.traction) + (body.drag(step.pressure) if coupled else 0.0)
    position = -u
    position[0] += step.tangential_displacement
    slip = position - before
    size = np.hypot(*step.traction)
    sliding = (step.pressure > 0) & ~step.sticking
    normal = np.divide(step.traction, size, out=np.zeros_like(step.traction), where=size > 0)
    along = (slip * normal).sum(axis=0)
    off = np.hypot(*(slip - np.maximum(along, 0) * normal))
    return np.hypot(*slip)[step.sticking].max(initial=0), off[sliding].max(initial=0), position


@pytest.mark.parametrize("coupled", [False, True])
def test_every_condition_holds_on_a_coupled_path(coupled):
    """Coulomb's law cell by cell on a path of both loads, evaluated outside the solver.

    |q| <= mu p; no slip below; slip along q at the bound; both to the tolerance 1e-6 of mu d E*/G*.
    """
    nu = 0.2
    body = body_of(32, 2.4, nu)
    x = (np.arange(32) - 15.7) * 2.4 / 32
    gap = (x[:, None] ** 2 + 1.5 * x**2) / 2
    normal = [0.2, 0.5, 0.9, 0.9, 0.7, 0.7]
    shift = np.array([0.0, 0.02, 0.1, 0.25, 0.1, -0.2])
    before = np.zeros((2, 32, 32))
    lost = 0.0
    for step in sweep(
        FrictionalPress(body, gap, MU, coupled=coupled),
        *paths(penetration=normal, tangential_displacement=shift),
    ):
        scale = MU * step.penetration * 2.5
        assert (np.hypot(*step.traction) <= MU * step.pressure * (1 + 1e-9)).all()
        stick, off, before = conditions(body, step, before, coupled)
        assert max(stick, off) < 3e-6 * scale
        clear = body.normal.apply(step.pressure) + gap - step.penetration
        if coupled:
            clear += body.lift(step.traction)
        assert np.abs(clear[step.pressure > 0]).max() < 2e-6 * step.penetration
        assert clear.min() > -2e-6 * step.penetration
        assert step.dissipation >= lost * (1 - 1e-9)
        lost = step.dissipation


def test_no_coupling_for_an_incompressible_body():
    """1 - 2 nu = 0: the coupled solver returns the decoupled answer in one round."""
    body = body_of(24, 2.4, 0.5)
    x = (np.arange(24) - 11.7) * 0.1
    gap = (x[:, None] ** 2 + x**2) / 2
    loads = LoadPath("force", 3.0), LoadPath("tangential_force", [0.5, -0.3])
    ways = (sweep(FrictionalPress(body, gap, MU, coupled=c), *loads) for c in (True, False))
    pairs = zip(*ways, strict=True)
    for one, other in pairs:
        assert one.rounds == 1
        assert one.tangential_displacement == pytest.approx(other.tangential_displacement, rel=1e-6)


@pytest.mark.slow
def test_spence_stick_radius_under_normal_load():
    """Pressing alone lets an annulus slip (Spence 1975).

    [a/(2c)] ln[(a + c)/(a - c)] = (mu/beta) K'(c/a), beta = (1 - 2 nu)/(2 (1 - nu)); derived with
    the pressure of Hertz, so taken at a small beta. The implicit steps converge with first order in
    their ratio: two of them are extrapolated, to 1.5 % (half a cell of stick radius is 2 %).
    """
    nu, share = 0.45, 2 / 3
    beta = (1 - 2 * nu) / (2 * (1 - nu))
    body = body_of(48, 2.3, nu)
    x = (np.arange(48) - 23.6) * 2.3 / 48
    gap = (x[:, None] ** 2 + x**2) / 2
    radii = []
    for steps in (20, 40):
        depths = np.geomspace(0.02, 1.0, steps)
        *_, last = sweep(
            FrictionalPress(body, gap, share * beta),
            *paths(penetration=depths, tangential_displacement=0.0),
        )
        radii.append(np.sqrt(last.sticking.sum() / (last.pressure > 0).sum()))
    exact = brentq(lambda c: np.arctanh(c) / c - share * ellipkm1(c * c), 0.1, 0.99)
    assert exact - radii[1] < 0.7 * (exact - radii[0])
    assert 2 * radii[1] - radii[0] == pytest.approx(exact, rel=0.015)


def test_the_force_tends_to_sliding_as_slip_turns_into_its_direction():
    """For nu > 0 no cell needs to stick below mu F: 1 - F_x/(mu F) ~ <angle^2>/2 ~ 1/u^2.

    The displacement grows tenfold from 0.9999 to 0.999999 mu F but for the part that the surface
    follows, mu d E*/G* = 0.45; without slip across it could not exceed that.
    """
    body = body_of(20, 2.2, 0.5)
    x = (np.arange(20) - 9.5) * 0.11
    limit = 0.3 * 4 / 3 * body.compliance.effective_modulus
    far = []
    for share in (0.9999, 0.999999):
        (step,) = sweep(
            FrictionalPress(body, (x[:, None] ** 2 + x**2) / 2, 0.3),
            *paths(force=limit / 0.3, tangential_force=[share * limit]),
        )
        assert not step.sticking.any()
        assert step.error < 1e-6
        assert step.tangential_force == pytest.approx(share * limit, rel=1e-8)
        far.append(step.tangential_displacement)
    assert far[0] > 2 * 0.45
    assert far[1] / far[0] > 7
    assert (far[1] - 0.45) / (far[0] - 0.45) < 14


def test_errors_are_relative_to_what_moves_even_where_nothing_slips():
    """A million times more friction than needed: u = F_x/(2 a G*), to the grid's 5e-3.

    An error relative to mu d E*/G* would leave it free.
    """
    body = body_of(40, 2.2, 0.5)
    x = (np.arange(40) - 19.6) * 0.055
    (step,) = sweep(
        FrictionalPress(body, (x[:, None] ** 2 + x**2) / 2, 1e6),
        *paths(penetration=1.0, tangential_force=[0.1]),
    )
    exact = 0.1 / (2 * body.compliance.tangential_modulus)
    assert step.tangential_displacement == pytest.approx(exact, rel=5e-3)
