"""Single contacts on springs: closed forms, rates over random alignments, inversion, energy."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reduced.loads import Load
from reduced.profiles.equivalents import (
    cone,
    cylinder,
    paraboloid,
    power_law,
    rounded_punch,
    sphere,
    tabulated,
)
from reduced.springs.indent import indent
from reduced.springs.line import Springs

D = np.geomspace(1e-3, 0.4, 9)
EXACT = 1e-14


def pressed(springs, depths):
    return indent(springs, Load("penetration", depths))


def loaded(springs, forces):
    return indent(springs, Load("force", forces))


def power_force(n, c, d):
    """F = 2 E* n/(n+1) d a with d = kappa_n c a^n; kappa from Popov & Hess 2015."""
    kappa = {1: np.pi / 2, 2: 2.0, 3: 3 * np.pi / 4, 4: 8 / 3}[n]
    a = (d / (kappa * c)) ** (1 / n)
    return 2 * n / (n + 1) * d * a, a


@pytest.mark.parametrize("n", [1, 2, 3])
@given(offset=st.floats(0, 0.999), springs=st.integers(1, 90))
def test_cone_paraboloid_and_cubic_are_exact_for_any_alignment(n, offset, springs):
    """Monotone cubics through heights and slopes hold x, x^2, x^3: only rounding is left."""
    force, radius = power_force(n, 0.3, D)
    contact = pressed(Springs(power_law(n, 0.3), 1.0, per_radius=springs, offset=offset), D)
    np.testing.assert_allclose(contact.force, force, rtol=EXACT * 10)
    np.testing.assert_allclose(contact.contact_radius, radius, rtol=EXACT * 10)


@given(offset=st.floats(0, 0.999), springs=st.integers(1, 50))
def test_flat_punch_is_exact_for_any_alignment(offset, springs):
    """F = 2 E* b d, U = E* b d^2."""
    contact = pressed(Springs(cylinder(0.7), 2.0, per_radius=springs, offset=offset), D)
    np.testing.assert_allclose(contact.force, 2 * 2.0 * 0.7 * D, rtol=EXACT)
    np.testing.assert_allclose(contact.energy, 2.0 * 0.7 * D**2, rtol=EXACT)
    np.testing.assert_array_equal(contact.contact_radius, 0.7)


def rounded_force(b, radius, a):
    """F of the rounded punch (Popov, Hess & Willert 2019) by parts: 2 E* int x g' dx."""
    nodes, weights = np.polynomial.legendre.leggauss(40)
    t = (nodes + 1) / 2
    w = np.sqrt(a**2 - b**2) * t  # x dx = w dw makes the integrand smooth
    slope = (2 * w - b * np.arctan(w / b)) / radius
    return 2 * np.sum(weights / 2 * w * slope) * np.sqrt(a**2 - b**2)


def random_errors(make, exact_force, largest, springs, edges, rng):
    """Rms relative errors of F and a over random offsets and a/dx."""
    errors = []
    for _ in range(60):
        a = largest * rng.uniform(0.6, 1.0)
        d = [float(make.height(np.array(a))), float(make.height(np.array(largest)))]
        contact = pressed(
            Springs(make, 1.0, per_radius=springs, edges=edges, offset=rng.uniform(0, 1)), d
        )
        errors.append([contact.force[0] / exact_force(a) - 1, contact.contact_radius[0] / a - 1])
    return np.sqrt(np.mean(np.square(errors), axis=0))


def fitted_rates(make, exact_force, largest, edges):
    rng = np.random.default_rng(20)
    springs = np.array([10, 20, 40, 80])
    errors = np.array([random_errors(make, exact_force, largest, n, edges, rng) for n in springs])
    return -np.polyfit(np.log(springs), np.log(errors), 1)[0], errors


def quartic_force(a):
    return 2 * (4 / 5) * (8 / 3 * 0.5 * a**4) * a


def sphere_force(a):
    """Segedin's sphere: F = 2 int x g' dx, R = 1: closed form (R^2 + a^2) atanh(a/R) - a R."""
    return (1 + a**2) * np.arctanh(a) - a


@pytest.mark.parametrize(
    ("make", "exact", "largest", "rates", "errors"),
    [
        (power_law(4, 0.5), quartic_force, 1.0, (3.7, 3.5), (1e-7, 1e-6)),
        (sphere(1.0), sphere_force, 0.6, (3.7, 3.5), (1e-7, 1e-6)),
        # behind the flat g ~ (x - b)^1.5: order 2.5
        (
            rounded_punch(0.4, 3.0),
            lambda a: rounded_force(0.4, 3.0, a),
            1.0,
            (2.3, 2.3),
            (1e-5, 1e-6),
        ),
    ],
    ids=["quartic", "sphere", "rounded punch"],
)
def test_sub_cell_rates_over_random_alignments(make, exact, largest, rates, errors):
    """At least the stated order in F and a, and the stated rms error at 40 springs."""
    fitted, rms = fitted_rates(make, exact, largest, "sub_cell")
    assert np.all(fitted > rates)
    assert np.all(rms[2] < errors)


def test_printed_sums_converge_as_the_theory_page_says():
    """Nodal parabola: F as dx^2 and a as dx; at 10 springs per radius rms 7e-4 and 2e-2."""
    fitted, rms = fitted_rates(paraboloid(1.0), lambda a: 4 / 3 * a**3, 1.0, "nodal")
    # The rms of 60 random alignments scatters by 10 %, the slope over three doublings by 0.15.
    np.testing.assert_allclose(fitted, [2.0, 1.0], atol=0.25)
    # a/dx between 6 and 10 here, so the values lie above those for 10.
    assert 7e-4 / 1.5 < rms[0, 0] < 7e-4 * 3
    assert 2e-2 / 1.5 < rms[0, 1] < 2e-2 * 2.5


def test_springs_much_wider_than_the_contact_still_carry_the_right_order():
    """Loads over twelve decades on one line: at the smallest, a is a thousandth of dx."""
    d = np.geomspace(1e-12, 1.0, 13)
    for n in (1, 2, 3):
        exact, _ = power_force(n, 0.5, d)
        force = pressed(Springs(power_law(n, 0.5), 1.0), d).force
        np.testing.assert_allclose(force, exact, rtol=1e-12)
    exact, _ = power_force(4, 0.5, d)
    # x^4 inside the first cell is a cubic there: at most a tenth of a decade off
    assert np.all(np.abs(np.log10(pressed(Springs(power_law(4, 0.5), 1.0), d).force / exact)) < 1)


TABLE = tabulated(np.linspace(0, 2, 21), np.linspace(0, 2, 21) ** 2 / 4)
PROFILES = [paraboloid(2.0), sphere(2.0), cone(0.3), power_law(1.5, 0.3), power_law(6, 0.3)]
PROFILES += [rounded_punch(0.3, 3.0), cylinder(0.5), TABLE]


@pytest.mark.parametrize("edges", ["sub_cell", "nodal"])
@pytest.mark.parametrize("profile", PROFILES, ids=lambda p: p.name)
@settings(max_examples=5)
@given(offset=st.floats(0, 0.99), springs=st.integers(1, 20))
def test_pressing_again_to_the_penetrations_found_gives_the_forces(profile, edges, offset, springs):
    """Same line, both controls.

    The line is fixed by its spacing, hence by a largest penetration whose contact radius is
    `springs` spacings. What is left is the rounding of that spacing.
    """
    options = {"offset": offset, "per_radius": springs, "edges": edges}
    forces = np.geomspace(1e-2, 0.3, 7)
    contact = loaded(Springs(profile, 1.0, **options), forces)
    top = float(profile.height(np.array(contact.spacing * springs)))
    below = contact.penetration < (top if top > 0 else np.inf)
    loads = [*contact.penetration[below], top] if top > 0 else contact.penetration
    again = pressed(Springs(profile, 1.0, **options), loads)
    assert again.spacing == pytest.approx(contact.spacing, rel=1e-14)
    count = np.count_nonzero(below)
    np.testing.assert_allclose(again.force[:count], forces[:count], rtol=1e-11)


@pytest.mark.parametrize("edges", ["sub_cell", "nodal"])
@pytest.mark.parametrize("profile", PROFILES, ids=lambda p: p.name)
def test_energy_is_the_work_of_the_force(profile, edges):
    """U(d) = int F dd on the discrete law.

    Trapezoid between 4000 loads, second order in their step (relative 1e-7); the part below the
    first load is bounded by F d.
    """
    d = np.linspace(1e-4, 0.4, 4001)
    contact = pressed(Springs(profile, 3.0, per_radius=15, edges=edges, offset=0.37), d)
    work = np.sum((contact.force[1:] + contact.force[:-1]) / 2 * np.diff(d))
    assert contact.energy[-1] - contact.energy[0] == pytest.approx(work, rel=1e-6)
    assert contact.energy[0] <= contact.force[0] * d[0]


def test_whole_numbers_are_numbers():
    """A radius of 2 is one of 2.0."""
    for make in (sphere, paraboloid, cylinder, cone, lambda r: rounded_punch(r, 3 * r)):
        one, two = (pressed(Springs(make(r), 1, edges="sub_cell"), [1]) for r in (2, 2.0))
        np.testing.assert_array_equal(one.force, two.force)
