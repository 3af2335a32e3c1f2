"""Closed forms, checked by the laws they must obey and not by repeating their formulas."""

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import minimize_scalar
from scipy.special import poch

from reference import closed_form
from reference.closed_form.adhesive import AdhesiveForm, MaugisForm, strength_of
from reference.fem import far_field

E_STAR = 1.7
# One of each shape, with lengths of order one, and its gap f(r) for the axisymmetric ones.
SHAPES = {
    "paraboloid": (closed_form.paraboloid, {"radius": 1.3}),
    "sphere": (closed_form.sphere, {"radius": 1.3}),
    "cone": (closed_form.cone, {"slope": 0.4}),
    "power_law_0.7": (closed_form.power_law, {"exponent": 0.7, "coefficient": 0.6}),
    "power_law_1.5": (closed_form.power_law, {"exponent": 1.5, "coefficient": 0.6}),
    "power_law_4": (closed_form.power_law, {"exponent": 4, "coefficient": 0.6}),
    "power_law_12": (closed_form.power_law, {"exponent": 12, "coefficient": 0.6}),
    "cylinder": (closed_form.cylinder, {"radius": 0.8}),
    "rounded_punch": (closed_form.rounded_punch, {"flat_radius": 0.5, "edge_radius": 1.3}),
    "ellipsoid": (closed_form.ellipsoid, {"radius_x": 0.7, "radius_y": 2.9}),
    "elliptic_punch": (closed_form.elliptic_punch, {"semi_axis_x": 1.4, "semi_axis_y": 0.5}),
}
GAPS = {
    "paraboloid": lambda r: r**2 / 2.6,
    "sphere": lambda r: 1.3 - math.sqrt(1.3**2 - r**2),
    "cone": lambda r: 0.4 * r,
    "power_law_0.7": lambda r: 0.6 * r**0.7,
    "power_law_1.5": lambda r: 0.6 * r**1.5,
    "power_law_4": lambda r: 0.6 * r**4,
    "power_law_12": lambda r: 0.6 * r**12,
    "cylinder": lambda r: 0.0,
    "rounded_punch": lambda r: max(r - 0.5, 0.0) ** 2 / 2.6,
}
DEPTH = 0.31
NODES, WEIGHTS = np.polynomial.legendre.leggauss(300)
every_shape = pytest.mark.parametrize("shape", SHAPES)
axisymmetric = pytest.mark.parametrize("shape", GAPS)


def make(shape: str) -> closed_form.ClosedForm:
    constructor, parameters = SHAPES[shape]
    return constructor(**parameters, effective_modulus=E_STAR)


def breaks(shape: str, a: float) -> list[float]:
    """Radii at which the pressure is not smooth, centre and edge included."""
    return [0.0, 0.5, a] if shape == "rounded_punch" else [0.0, a]


def radial_integral(integrand, radii: list[float]) -> float:
    """Integrate over [0, a] piece by piece, roots at the ends removed by x = sin(q)^2.

    Of a logarithm at an end, 300 points of Gauss leave about 1e-10.
    """
    q = math.pi / 4 * (1 + NODES)
    weights = math.pi / 2 * WEIGHTS * np.sin(q) * np.cos(q)

    def piece(low: float, high: float) -> float:
        values = integrand(low + (high - low) * np.sin(q) ** 2)
        return float((high - low) * (weights @ values))

    return sum(piece(low, high) for low, high in pairwise(radii))


@every_shape
def test_pressure_carries_the_force(shape):
    """The integral of p over the contact is F: quadrature of elliptic rings to 1e-9."""
    form = make(shape)
    half_x, half_y = form.semi_axes(DEPTH)
    angles = np.linspace(0, 2 * np.pi, 7)[:-1] + 0.2

    def ring(rho):
        x, y = half_x * np.outer(rho, np.cos(angles)), half_y * np.outer(rho, np.sin(angles))
        return 2 * math.pi * rho * form.pressure(x, y, DEPTH).mean(axis=1)

    radii = [radius / half_x for radius in breaks(shape, half_x)]
    force = half_x * half_y * radial_integral(ring, radii)
    # The pressure near a singular edge is known to sqrt(rounding) only, hence not 1e-11.
    assert force == pytest.approx(form.force(DEPTH), rel=2e-8)


@every_shape
@pytest.mark.parametrize("depth", [0.02, 0.31, 1.9])
def test_stiffness_is_the_slope_of_the_force(shape, depth):
    """Sixth-order differences with a step of 1 %: 1e-12 truncation, 1e-13 rounding."""
    form = make(shape)
    step = 0.01 * depth
    slope = sum(
        weight * (form.force(depth + k * step) - form.force(depth - k * step))
        for k, weight in ((1, 45 / 60), (2, -9 / 60), (3, 1 / 60))
    )
    assert slope / step == pytest.approx(form.stiffness(depth), rel=1e-10)


@every_shape
def test_energy_is_the_work_of_the_force(shape):
    form = make(shape)
    work = quad(
        lambda q: form.force(DEPTH * q**6) * 6 * DEPTH * q**5, 0, 1, epsabs=0, epsrel=1e-12
    )[0]  # d = D q^6 makes every root of d at zero smooth
    assert form.energy(DEPTH) == pytest.approx(work, rel=1e-10)


@every_shape
def test_penetration_inverts_the_force(shape):
    """Over sixteen decades, to a few roundings (the force itself is good to 1e-15)."""
    form = make(shape)
    depth = np.geomspace(1e-14, 10.0, 97)
    assert np.allclose(form.penetration(form.force(depth)), depth, rtol=4e-15, atol=0)


@axisymmetric
@pytest.mark.parametrize("fraction", [0.0, 0.3, 0.8])
def test_pressed_surface_follows_the_indenter(shape, fraction):
    """The deflection under p, u = (4/(pi E*)) int p s K(m)/(r+s) ds, is d - f(r) in the contact.

    Love's ring solution; K(m) by the arithmetic-geometric mean, which needs no library.
    """
    form = make(shape)
    a = float(form.contact_radius(DEPTH))
    r = fraction * a

    def ring(s):
        mean = arithmetic_geometric_mean(r + s, abs(r - s))
        return 2 / E_STAR * s * form.pressure(s, 0.0 * s, DEPTH) / mean

    radii = sorted({*breaks(shape, a), r})
    deflection = radial_integral(ring, radii)
    # Logarithm at s = r, and singular edge pressures known to sqrt(rounding) only.
    assert deflection == pytest.approx(DEPTH - GAPS[shape](r), rel=1e-7)


def arithmetic_geometric_mean(x, y):
    """Return M(x, y); K(m) = pi/(2 M(1, sqrt(1-m)))."""
    for _ in range(40):
        x, y = (x + y) / 2, np.sqrt(x * y)
    return x


@pytest.mark.parametrize("ratio", [1.0, 1 + 1e-9, 3.0, 1e3, 1e6, 1e-6])
def test_ellipsoid_deflection_by_the_potential_integral(ratio):
    """It is u = p0 a b/(2E*) int_0^inf (1 - x^2/(a^2+w) - y^2/(b^2+w)) dw/s, s^2 = (a^2+w)(b^2+w)w.

    (Johnson 1985, section 3.5.) In w = a b e^t the integrand decays exponentially: the trapezoidal
    rule converges geometrically, so all three of d, 1/(2Rx), 1/(2Ry) must come out to 1e-12.
    """
    form = closed_form.ellipsoid(ratio, 1.0, E_STAR)
    half_x, half_y = (float(axis) for axis in form.semi_axes(DEPTH))
    p0 = float(form.pressure(0, 0, DEPTH))
    t, step = np.linspace(-120, 120, 4001, retstep=True)
    w = half_x * half_y * np.exp(t)
    base = np.sqrt(w) / np.sqrt((half_x**2 + w) * (half_y**2 + w)) * step
    lever = p0 * half_x * half_y / (2 * E_STAR)
    assert lever * base.sum() == pytest.approx(DEPTH, rel=1e-12)
    assert lever * (base / (half_x**2 + w)).sum() == pytest.approx(1 / (2 * ratio), rel=1e-12)
    assert lever * (base / (half_y**2 + w)).sum() == pytest.approx(1 / 2, rel=1e-12)


def test_elliptic_punch_sinks_as_a_flat_by_the_potential_integral():
    """At any interior point u = F/(2 pi E*) int_0^inf dw/sqrt((a^2+w)(b^2+w)w) (Johnson 3.5)."""
    form = make("elliptic_punch")
    t, step = np.linspace(-90, 90, 3001, retstep=True)
    w = np.exp(t)
    integral = step * (np.sqrt(w) / np.sqrt((1.4**2 + w) * (0.5**2 + w))).sum()
    depth = form.force(DEPTH) / (2 * np.pi * E_STAR) * integral
    assert depth == pytest.approx(DEPTH, rel=1e-12)


@every_shape
def test_pressure_vanishes_outside_and_diverges_only_where_announced(shape):
    form = make(shape)
    half_x, half_y = form.semi_axes(DEPTH)
    assert form.pressure(1.001 * half_x, 0, DEPTH) == 0
    assert form.pressure(0, 1.001 * half_y, DEPTH) == 0
    assert form.pressure(half_x, 0, 0.0) == 0
    edge = form.pressure(np.array([half_x, 0.0]), np.array([0.0, half_y]), DEPTH)
    centre = form.pressure(0, 0, DEPTH)
    assert np.isinf(edge).all() == (form.singular_at == "edge")
    assert np.isinf(centre) == (form.singular_at == "centre")
    assert (form.singular_at is not None) == bool(np.isinf(edge).any() or np.isinf(centre))
    assert form.relative_radius(0, half_y, DEPTH) == 1
    if form.singular_at is None:
        # Approaches zero like the root of the distance to the edge: 1e-12 gives about 1e-6.
        assert 0 < form.pressure(half_x * (1 - 1e-12), 0, DEPTH) < 1e-4 * (1 + centre)


@every_shape
def test_arrays_numbers_and_nothing(shape):
    form = make(shape)
    depth = np.array([[0.0, 0.1], [0.2, 0.3]])
    for quantity in (form.force, form.contact_area, form.stiffness, form.energy):
        assert quantity(depth).shape == depth.shape
        # Vectorised and scalar powers of NumPy may differ in the last digit.
        assert quantity(depth)[1, 0] == pytest.approx(quantity(0.2), rel=1e-15)
        assert isinstance(quantity(0.2), float)
    assert form.force(0.0) == form.energy(0.0) == form.penetration(0.0) == 0
    assert form.pressure(np.zeros((3, 1)), np.zeros(4), DEPTH).shape == (3, 4)
    assert (form.contact_radius is None) == (shape in ("ellipsoid", "elliptic_punch"))


@every_shape
@pytest.mark.parametrize("bad", [-1e-9, math.nan, math.inf, "1"])
def test_bad_loads_are_refused(shape, bad):
    form = make(shape)
    for function in (form.force, form.penetration, form.contact_area):
        with pytest.raises(ValueError, match=r"penetration|force"):
            function([0.1, bad] if not isinstance(bad, str) else bad)


def test_sphere_is_refused_where_the_contact_reaches_its_radius():
    form = make("sphere")
    assert form.contact_radius(1.3 * 13) < 1.3
    with pytest.raises(ValueError, match="radius of the sphere"):
        form.force(1.3 * 15)
    with pytest.raises(ValueError, match="radius of the sphere"):
        form.penetration(100.0)


@pytest.mark.parametrize("share", [0.03, 0.5, 0.97])
def test_wavy_surface_is_followed_in_the_contact(share):
    """Its u(x) = -(2/(pi E*)) int p(s) ln|2 sin(pi (x-s)/l)| ds has zero mean and equals d - gap.

    At the crest and half-way to the edge; the mean of p must be the load. The integrals are taken
    with s = a sin(q) and, for the logarithm, split at x.
    """
    amplitude, wavelength = 0.03, 2.2
    wave = closed_form.Westergaard(amplitude, wavelength, E_STAR)
    load = share * wave.full_contact_pressure
    a = 0.5 * wavelength * float(wave.contact_fraction(load))
    assert float(wave.pressure(1.0001 * a, load)) == 0

    def mean(weight, split: float) -> float:
        def integrand(q: float) -> float:
            s = a * math.sin(q)
            return weight(s) * float(wave.pressure(s, load)) * a * math.cos(q)

        middle = math.asin(split / a)
        parts = (-math.pi / 2, middle), (middle, math.pi / 2)
        return sum(quad(integrand, *part, epsabs=0, epsrel=1e-10, limit=200)[0] for part in parts)

    assert mean(lambda s: 1.0, 0.0) / wavelength == pytest.approx(load, rel=1e-9)
    for x in (0.0, 0.5 * a):
        deflection = mean(
            lambda s, x=x: (
                -2
                / (np.pi * E_STAR)
                * math.log(abs(2 * math.sin(math.pi * (x - s) / wavelength)) or 1.0)
            ),
            x,
        )
        gap = amplitude * (1 - math.cos(2 * math.pi * x / wavelength))
        assert deflection == pytest.approx(wave.penetration(load) - gap, rel=1e-8)
    assert wave.mean_gap(load) == pytest.approx(amplitude - wave.penetration(load), rel=1e-15)


@pytest.mark.parametrize("poisson_ratio", [-0.5, 0.0, 0.3, 0.49])
def test_the_energy_beyond_a_hemisphere_is_the_integral_of_its_density(poisson_ratio):
    """The strain energy of Boussinesq's field as the far field of the FEM has it, E = F = 1.

    The density falls as r^-4, so the integral over a hemisphere of radius one is the energy beyond.
    """
    nodes, weights = np.polynomial.legendre.leggauss(60)
    cosine, weights = 0.5 * (nodes + 1), 0.5 * weights
    sine = np.sqrt(1 - cosine**2)
    gradient = far_field.boussinesq(np.stack([sine, 0 * sine, cosine], -1), poisson_ratio)[1]
    strain = 0.5 * (gradient + np.swapaxes(gradient, -1, -2))
    shear = 0.5 / (1 + poisson_ratio)
    trace = np.trace(strain, axis1=-2, axis2=-1)
    volume = shear * poisson_ratio / (1 - 2 * poisson_ratio) * trace**2
    density = volume + shear * (strain**2).sum((-2, -1))
    exact = closed_form.boussinesq_energy(1.0, 1.0, 1 / (1 - poisson_ratio**2), poisson_ratio)
    assert 2 * np.pi * (weights * density).sum() == pytest.approx(exact, rel=1e-12)


@pytest.mark.parametrize(("exponent", "coefficient"), [(3, 1e-300), (50, 1e-308), (1.01, 1e300)])
def test_a_power_law_is_never_beyond_floats_where_its_contact_is_not(exponent, coefficient):
    """Against (d/(kappa c))^(1/n) in logarithms; an exponent of 700 costs three digits."""
    form = closed_form.power_law(exponent, coefficient, 1.0)
    kappa = 0.5 * np.sqrt(np.pi) * exponent / poch(exponent / 2, 0.5)
    expected = np.exp(-(np.log(kappa) + np.log(coefficient)) / exponent)
    np.testing.assert_allclose(form.contact_radius(1.0), expected, rtol=1e-12)


W, E = 0.02, 1.7
FORMS = {
    "paraboloid": (AdhesiveForm(closed_form.paraboloid(2.0, E), W), (0.2, 1.0)),
    "cone": (AdhesiveForm(closed_form.cone(0.3, E), W), (0.05, 2.0)),
    "quartic": (AdhesiveForm(closed_form.power_law(4, 0.3, E), W), (0.2, 1.5)),
    "sphere": (AdhesiveForm(closed_form.sphere(1.0, E), W), (0.1, 0.9)),
    "rounded": (AdhesiveForm(closed_form.rounded_punch(1.0, 2.0, E), W), (1.001, 3.0)),
}


def test_pull_off_of_a_paraboloid():
    """-(3/2) pi w R, -(5/6) pi w R; contact radii (9 pi w R^2/(8 E*))^(1/3) and a ninth inside."""
    form = FORMS["paraboloid"][0]
    for control, share, ninth in (("force", -1.5, 9), ("penetration", -5 / 6, 1)):
        a = form.pull_off(control)
        assert float(form.force(a)) == pytest.approx(share * np.pi * W * 2.0, rel=1e-13)
        assert a == pytest.approx(np.cbrt(ninth * np.pi * W * 4.0 / (8 * E)), rel=1e-13)


@pytest.mark.parametrize("name", list(FORMS))
def test_the_contact_is_lost_at_the_lowest_load(name):
    """The fold is where a search finds the minimum (xatol 1e-9: the load to its square)."""
    form, bounds = FORMS[name]
    for control, law in (("force", form.force), ("penetration", form.penetration)):
        minimum = minimize_scalar(law, bounds=bounds, method="bounded", options={"xatol": 1e-9})
        assert form.pull_off(control) == pytest.approx(minimum.x, rel=1e-5)
        assert float(law(form.pull_off(control))) == pytest.approx(minimum.fun, rel=1e-12)


@pytest.mark.parametrize("name", list(FORMS))
def test_without_adhesion_force_follows_depth(name):
    """dF0/da = 2 E* a dd0/da for every contact; central differences of 1e-5 err by 1e-9."""
    form, (low, high) = FORMS[name][0]._laws, FORMS[name][1]
    a = np.linspace(low, high, 7)[1:-1]
    step = 1e-5
    depth_rate = (form.depth(a + step) - form.depth(a - step)) / (2 * step)
    load_rate = (form.load(a + step) - form.load(a - step)) / (2 * step)
    np.testing.assert_allclose(depth_rate, form.rate(a), rtol=1e-7)
    np.testing.assert_allclose(load_rate, 2 * E * a * form.rate(a), rtol=1e-7)


def test_a_flat_punch_is_a_rounded_one_of_a_sharp_edge():
    """As the edge radius goes to zero, pull-off tends to Kendall's from below."""
    kendall = AdhesiveForm(closed_form.cylinder(1.0, E), W)
    exact = float(kendall.force(kendall.pull_off()))
    assert exact == pytest.approx(-np.sqrt(8 * np.pi * E * W), rel=1e-14)
    result = []
    for edge in (1e-2, 1e-4, 1e-6):
        form = AdhesiveForm(closed_form.rounded_punch(1.0, edge, E), W)
        result.append(float(form.force(form.pull_off())) / exact - 1)
    assert result[0] > result[1] > result[2] > 0
    assert result[2] < 1e-3


def test_maugis_of_long_range_is_derjaguin_muller_toporov():
    """Pull-off tends to -2 pi w R as lambda goes to zero, the force to Hertz's less that."""
    form = MaugisForm(2.0, E, W, strength_of(2.0, E, W, 1e-3))
    assert float(form.force(form.pull_off())) == pytest.approx(-2 * np.pi * W * 2.0, rel=2e-3)
    a = 3 * form.units[0]
    hertz = 4 / 3 * E * a**3 / 2.0
    assert float(form.force(a)) == pytest.approx(hertz - 2 * np.pi * W * 2.0, rel=2e-3)


@pytest.mark.parametrize("control", ["force", "penetration"])
def test_maugis_path_of_short_range_is_johnson_kendall_roberts(control):
    """Jumps included, at lambda = 2000: a range of 1e-4 of the depths, which first touch feels."""
    jkr = AdhesiveForm(closed_form.paraboloid(2.0, E), W)
    form = MaugisForm(2.0, E, W, strength_of(2.0, E, W, 2000.0))
    unit = form.units[{"force": 1, "penetration": 2}[control]]
    loads = unit * np.array([-0.5, 0.0, 2.0, 0.0, -0.7, -3.0, 1.0])
    one, other = form.follow(control, loads), jkr.follow(control, loads)
    np.testing.assert_array_equal(one.contact_radius > 0, other.contact_radius > 0)
    for name in ("contact_radius", "penetration", "force", "largest_pull"):
        expected = getattr(other, name)
        scale = np.nanmax(np.abs(expected))
        np.testing.assert_allclose(getattr(one, name), expected, rtol=0, atol=3e-3 * scale)


def test_maugis_ball_is_drawn_over_the_gap_before_it_touches():
    """At long range almost as a rigid one: -2 pi R sigma0 (d + h0), h0 = w/sigma0, from d = -h0."""
    form = MaugisForm(2.0, E, W, strength_of(2.0, E, W, 1e-3))
    reach = W / strength_of(2.0, E, W, 1e-3)
    path = form.follow("penetration", reach * np.array([-1.01, -0.9, -0.5, -0.1, -1.01]))
    np.testing.assert_array_equal(path.contact_radius, 0)
    expected = -2 * np.pi * 2.0 * W * np.array([0, 0.1, 0.5, 0.9, 0])
    np.testing.assert_allclose(path.force, expected, rtol=2e-3)
    assert path.largest_pull == pytest.approx(-path.force[3], rel=1e-12)
    # through the depth of the strongest pull, just after touch
    passed = form.follow("penetration", [0.01 * reach, -reach]).largest_pull
    assert passed == pytest.approx(-path.pull_off, rel=1e-12)
