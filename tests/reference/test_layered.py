"""Layers, coatings and graded bodies: closed forms, limits, and solvers that share nothing."""

import mpmath
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from reference.contact.press import press
from reference.elasticity import Material
from reference.fem.grid_body import PeriodicBody
from reference.halfspace import kernels
from reference.layered import Graded, LayeredFree, LayeredPeriodic, RoundContact, Stack
from reference.layered.layered_grid import cell_coefficients, cell_modes
from reference.loads import Load

STEEL = Material(1.0, 0.3)
RATIOS = [-0.5, 0.0, 0.3, 0.45, 0.4999, 0.5]


def bonded(q, thickness, material):
    """Return the bonded layer in closed form (Johnson 1985, 5.7; 50 digits)."""
    with mpmath.workdps(50):
        nu = mpmath.mpf(material.poisson_ratio)
        s, k = mpmath.mpf(q) * thickness, 3 - 4 * nu
        upper = k * mpmath.sinh(2 * s) - 2 * s
        lower = k * mpmath.cosh(2 * s) + 2 * s**2 + (1 + k**2) / 2
        return float(2 / (material.effective_modulus * mpmath.mpf(q)) * upper / lower)


def by_matrices(stack, q):
    """Return the same by products of raw transfer matrices, with the digits they need."""
    with mpmath.workdps(200):

        def exponents(material):
            nu = mpmath.mpf(material.poisson_ratio)
            b, c = nu / (1 - nu), (1 - 2 * nu) / (2 * (1 - nu))
            return mpmath.matrix(
                [[0, 1, 1, 0], [-b, 0, 0, c], [2 / (1 - nu), 0, 0, b], [0, 0, -1, 0]]
            )

        def shear(material):
            nu = mpmath.mpf(material.poisson_ratio)
            return material.youngs_modulus / (2 + 2 * nu)

        nu, modulus = mpmath.mpf(stack.base.poisson_ratio), shear(stack.base)
        half = mpmath.mpf(1) / 2
        state = mpmath.matrix([[nu - 1, half - nu], [half - nu, nu - 1], [1, 0], [0, 1]])
        pairs = list(zip(stack.thicknesses, stack.materials, strict=True))
        for thickness, material in reversed(pairs):
            ratio, modulus = modulus / shear(material), shear(material)
            for column in (0, 1):
                state[2, column] *= ratio
                state[3, column] *= ratio
            state = mpmath.expm(-exponents(material) * mpmath.mpf(q) * thickness) * state
        compliance = state[:2, :] * state[2:, :] ** -1
        return float(-compliance[1, 1] / (modulus * q))


@pytest.mark.parametrize("nu", RATIOS)
def test_bonded_layer_is_the_closed_form_at_every_wave(nu):
    material = Material(3.0, nu)
    waves = np.geomspace(1e-4, 300.0, 25)
    exact = [bonded(q, 0.7, material) for q in waves]
    np.testing.assert_allclose(Stack([0.7], [material]).compliance(waves), exact, rtol=1e-13)


@pytest.mark.parametrize("contrast", [1e-3, 10.0])
@pytest.mark.parametrize(("above", "below"), [(0.3, 0.3), (0.5, 0.2), (0.0, 0.5)])
def test_coating_is_the_product_of_transfer_matrices(contrast, above, below):
    layers = [Material(contrast, above), Material(0.7, 0.4)]
    stack = Stack([1.0, 0.1], layers, Material(1.0, below))
    for q in (1e-4, 0.03, 0.5, 5.0):
        assert stack.compliance(q) == pytest.approx(by_matrices(stack, q), rel=1e-13)


@pytest.mark.parametrize("nu", [-0.3, 0.3, 0.5])
@pytest.mark.parametrize("exponent", [0.1, 0.8])
def test_graded_compliance_is_that_of_the_differential_equation(exponent, nu):
    """From forty over q upwards, where nothing of the surface is felt: exp(-80)."""
    graded = Graded(Material(1.3, nu), exponent, 2.0)
    b, c = nu / (1 - nu), (1 - 2 * nu) / (2 * (1 - nu))
    power = 2 / (1 - exponent)

    def change(s, compliance):
        z = s**power
        G = 1.3 / (2 + 2 * nu) * (z / 2.0) ** exponent
        R = compliance.reshape(2, 2)
        first, second = np.array([[1 / G, 0], [0, c / G]]), np.array([[0, 1], [-b, 0]])
        third, fourth = np.array([[2 * G / (1 - nu), 0], [0, 0]]), np.array([[0, b], [-1, 0]])
        rate = first + second @ R - R @ third @ R - R @ fourth
        return (rate * power * s ** (power - 1)).ravel()

    deep = 1.3 / (2 + 2 * nu) * 20.0**exponent
    start = np.array([nu - 1, 0.5 - nu, 0.5 - nu, nu - 1]) / deep
    ends = 40 ** (1 / power), 1e-9
    solved = solve_ivp(change, ends, start, rtol=1e-9, atol=1e-12, max_step=0.05)
    assert graded.compliance(1.0) == pytest.approx(-solved.y[3, -1], rel=1e-7)


@pytest.mark.parametrize("spacing", [(0.1, 0.1), (1.0, 0.01)])
def test_cells_on_layers_of_one_material_are_loves(spacing):
    i, j = np.arange(40)[:, None], np.arange(30)
    exact = kernels.love(i, j, spacing, STEEL.effective_modulus)
    for body in (Stack([0.3, 2.0], [STEEL, STEEL], STEEL), Graded(STEEL, 1e-13, 1.0)):
        np.testing.assert_allclose(cell_coefficients(body, (40, 30), spacing), exact, rtol=1e-9)


@pytest.mark.parametrize("nu", [0.3, 0.5])
def test_cells_on_a_bonded_layer_are_a_sum_of_waves_or_of_forces(nu):
    """Nothing reaches the images of a period of 80 thicknesses."""
    body = Stack([0.1], [Material(1.0, nu)])
    forces = cell_coefficients(body, (40, 40), (0.1, 0.1))
    waves = np.fft.irfft2(cell_modes(body, (80, 80), (0.1, 0.1)))[:40, :40]
    np.testing.assert_allclose(waves, forces, atol=1e-10 * forces[0, 0])


@pytest.mark.parametrize("spacing", [(0.1, 0.2), (1.0, 0.1)])
def test_modes_of_cells_are_those_of_the_half_space(spacing):
    """Of nearly square cells as of needles."""
    plain = kernels.periodic((24, 16), spacing, STEEL.effective_modulus, "cells")
    layered = cell_modes(Stack([0.3], [STEEL], STEEL), (24, 16), spacing)
    np.testing.assert_allclose(layered, plain, rtol=1e-10)


BODIES = {
    "hard coating": Stack([0.3], [Material(1e3, 0.3)], STEEL),
    "soft coating": Stack([0.3], [Material(1e-3, 0.3)], STEEL),
    "two coatings": Stack([0.05, 0.2], [Material(10.0, 0.5), Material(0.1, 0.2)], STEEL),
    "layer": Stack([0.1], [STEEL]),
    "rubber": Stack([0.1], [Material(1.0, 0.5)]),
    "thin layer": Stack([1e-2], [STEEL]),
    "thin rubber": Stack([1e-2], [Material(1.0, 0.5)]),
}


def pressed(body, cells, depth, side=2.4):
    x = (np.arange(cells) - (cells - 1) / 2) * (side / cells)
    gap = (x[:, None] ** 2 + x**2) / 2
    operator = LayeredFree((cells, cells), (side / cells,) * 2, body)
    return press(operator, gap, Load("penetration", depth))


@pytest.mark.slow
@pytest.mark.parametrize("name", BODIES)
def test_ball_on_layers_is_the_same_by_cells_and_by_the_integral_equation(name):
    """They share the compliance of waves only; 64 cells have 2e-4 on Hertz, 1e-3 on rubber."""
    exact = RoundContact(BODIES[name], lambda x: x**2).at("penetration", 0.3, 0.5, 1e-9)
    contact = pressed(BODIES[name], 64, 0.3)
    assert contact.force == pytest.approx(exact.force, rel=1e-3)
    radius = np.sqrt(contact.mask.sum() * contact.operator.cell_area / np.pi)
    assert radius == pytest.approx(exact.contact_radius, abs=contact.operator.spacing[0] / 2)


@pytest.mark.parametrize("control", ["penetration", "force"])
def test_the_load_of_a_first_guess_is_found_to_the_last_digit(control):
    """A guess that is right but for rounding: Hertz' radius, of a layer of the body below it."""
    alike = RoundContact(Stack([1.0], [STEEL], STEEL), lambda x: x**2)
    for guess in (0.3, 0.5, 1.0, 2.0):
        load = getattr(alike.at_radius(guess), control)
        for digits in (-2, -1, 0, 1, 2):
            found = alike.at(control, load * (1 + digits * np.finfo(float).eps), guess)
            assert found.contact_radius == pytest.approx(guess, rel=1e-12)


def test_thin_layers_approach_springs_and_squeezed_rubber():
    """Springs have a^2 = 2 R d; rubber a^2 = 4 R d and F = 2 pi a^6 E/(96 R t^3) (Johnson 5.8)."""
    layer = RoundContact(Stack([1e-3], [STEEL]), lambda x: x**2).at_radius(1.0)
    # the edge is a boundary layer of the thickness
    assert layer.penetration == pytest.approx(0.5, rel=2e-3)
    springs = Stack([1e-3], [STEEL]).squeezed
    assert layer.force == pytest.approx(np.pi / (4 * springs), rel=5e-3)
    rubber = RoundContact(Stack([1e-2], [Material(1.0, 0.5)]), lambda x: x**2).at_radius(1.0)
    assert rubber.penetration == pytest.approx(0.25, rel=3e-2)


def test_stiffness_is_the_slope_of_the_force_and_force_that_of_the_energy():
    contact = RoundContact(BODIES["hard coating"], lambda x: x**2)
    low, middle, high = (contact.at_radius(a) for a in (0.4999, 0.5, 0.5001))
    slope = (high.force - low.force) / (high.penetration - low.penetration)
    assert middle.stiffness == pytest.approx(slope, rel=1e-6)
    slope = (high.energy - low.energy) / (high.penetration - low.penetration)
    assert middle.force == pytest.approx(slope, rel=1e-6)


@pytest.mark.parametrize("control", ["force", "penetration"])
@pytest.mark.parametrize("edge", [0.33, 0.7, 1.9])
def test_the_load_that_reaches_a_sharp_edge_is_found_from_either_side_of_it(edge, control):
    """To rounding, and never beyond the edge, where a body has no profile."""
    ball = RoundContact(BODIES["hard coating"], lambda x: x**2, edge)
    load = getattr(ball.at_radius(edge), control)
    for value in (np.nextafter(load, 0), load):
        step = ball.at(control, float(value), 0.77 * edge)
        assert step.contact_radius <= edge
        assert getattr(step, control) == pytest.approx(load, rel=1e-12)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("control", ["force", "penetration"])
def test_a_punch_with_a_flat_face_is_found_from_a_radius_inside_it(control):
    """Below the face there is neither force nor penetration; half of the guess lies there."""
    punch = RoundContact(BODIES["hard coating"], lambda x: x * np.sqrt(np.maximum(x**2 - 0.09, 0)))
    exact = punch.at_radius(0.31)
    found = punch.at(control, getattr(exact, control), 0.45)
    assert found.contact_radius == pytest.approx(0.31, rel=1e-11)


@pytest.mark.parametrize("exponent", [-0.5, 0.3, 0.7])
def test_ball_on_a_graded_half_space_has_the_force_of_graded_springs(exponent):
    """A paraboloid has g = x^2/((1 + k) R); springs of c_N |x/c0|^k are exact (Hess 2016)."""
    k = exponent
    body = Graded(STEEL, k, 2.0)
    radius = np.sqrt(0.3 * (1 + k))
    springs = 2 * body.spring_modulus / 2.0**k
    force = springs * radius ** (k + 3) / (1 + k) * (1 / (k + 1) - 1 / (k + 3))
    contact = pressed(body, 96, 0.3, side=2.4 * radius)
    # with k below 0 the pressure rises at the edge like a smaller power of the distance
    assert contact.force == pytest.approx(force, rel=2e-3)


@pytest.mark.parametrize("name", [*BODIES, "graded"])
def test_waves_on_elements_are_those_of_the_body(name):
    """Periods of 64 cells: their longest wave errs by what elements of that size err."""
    body = BODIES.get(name, Graded(STEEL, 0.6, 1.0))
    elements = PeriodicBody((64, 64), (0.05, 0.05), body)
    continuum = LayeredPeriodic((64, 64), (0.05, 0.05), body)
    ratio = elements.transfer[:3, :3].ravel()[1:] / continuum.transfer[:3, :3].ravel()[1:]
    # (q h)^2/10 of two waves a period, and 1e-3 of hard coatings, whose waves are short
    np.testing.assert_allclose(ratio, 1.0, atol=6e-3)
    assert elements.transfer[0, 0] == pytest.approx(continuum.transfer[0, 0], rel=1e-12)


def test_transfer_functions_have_the_same_digits_every_time():
    """No order of interpolation is drawn at random."""
    body = Stack([0.5], [Material(3.0, 0.3)], STEEL)
    one, other = (cell_modes(body, (12, 8), (0.1, 0.3)) for _ in range(2))
    np.testing.assert_array_equal(one, other)
