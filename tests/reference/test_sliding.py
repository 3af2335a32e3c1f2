"""Steady sliding over a viscoelastic half-space: kernel, contact, closed forms, another method."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from reference.contact.press import press
from reference.halfspace import kernels as elastic
from reference.halfspace.kernels import FreeOperator
from reference.loads import Load
from reference.viscoelastic.materials import GeneralisedMaxwell
from reference.viscoelastic.rubber import slide_on_rubber
from reference.viscoelastic.travelling import Travelling

NODES, WEIGHTS = np.polynomial.legendre.leggauss(80)
KELVIN = GeneralisedMaxwell.kelvin_voigt(0.25, 0.25)  # E* = 1, tau = 1
ZENER = GeneralisedMaxwell.standard(0.25, 2.5, 0.1)


def grid(cells, half_width):
    x = (np.arange(cells) - (cells - 1) / 2) * (2 * half_width / cells)
    return x, (x[:, None] ** 2 + x**2) / 2


@pytest.mark.parametrize("reach", [0.05, 0.7, 5.0, 300.0])
@pytest.mark.parametrize("place", [(0, 0), (-1, 0), (3, 5), (-9, 1), (9, 0)])
def test_travelling_kernel_is_the_average_of_what_lies_ahead(reach, place):
    """Against the integral of Love's coefficient, split where an edge of the cell passes.

    With x = sin(q)^2 the logarithms at the edges are smooth enough for 80 points of Gauss: 1e-10.
    """
    table = Travelling((10, 6), (1.0, 1.0), KELVIN, reach).coefficients()
    ends = {0.0, *np.arange(0.5, 20), *(reach * np.array([0.1, 1, 3, 10, 20, 46.0]))}
    ends = sorted(end for end in ends if end <= 46 * reach)
    i, j = place

    low, high = np.array(list(itertools.pairwise(ends))).T[:, :, None]
    s = low + (high - low) * np.sin(np.pi / 4 * (1 + NODES)) ** 2
    weights = np.pi / 4 * (high - low) * WEIGHTS * np.cos(np.pi / 2 * NODES)
    exact = (weights * np.exp(-s / reach) / reach * elastic.love(i + s, j, (1.0, 1.0), 1.0)).sum()
    assert_allclose(table[9 + i, j], exact, rtol=5e-8)


def test_free_kernel_is_the_transform_of_the_complex_modulus():
    """A wave of pressure in the middle of a large patch moves as |q| and E*(-q v) say, to 1 %."""
    n, q = 192, 2 * np.pi / 12
    operator = Travelling((n, n), (1.0, 1.0), ZENER, 30.0)
    x = np.arange(n) - n / 2
    taper = np.exp(-((x / 34.0) ** 2))
    taper = taper[:, None] * taper
    wave = taper * np.exp(1j * q * x)[:, None]
    u = operator.apply(wave.real) + 1j * operator.apply(wave.imag)
    result = u[n // 2, n // 2] / wave[n // 2, n // 2]
    exact = 2 / (q * 4 * ZENER.dynamic_modulus(-30.0 * q))
    # cells are a comb of averages: sinc(q dx/2) and its aliases, 0.7 % here
    assert abs(result / exact - 1) < 0.02


@pytest.mark.slow
@settings(max_examples=15, deadline=None)
@given(speed=st.floats(-3, 3).map(lambda e: 10.0**e), seed=st.integers(0, 99))
def test_any_pressure_dissipates(speed, seed):
    """The symmetric part is positive definite: what makes the contact unique."""
    pressure = np.random.default_rng(seed).normal(size=(12, 10))
    for periodic in (False, True):
        operator = Travelling((12, 10), (1.0, 1.0), ZENER, speed, periodic=periodic)
        assert np.sum(pressure * operator.apply(pressure)) > 0


@pytest.mark.parametrize("material", [KELVIN, ZENER], ids=["Kelvin-Voigt", "standard"])
@pytest.mark.parametrize("periodic", [False, True])
def test_pressures_and_clearances_are_not_negative(material, periodic):
    x, gap = grid(32, 0.2)
    operator = Travelling((32, 32), (x[1] - x[0],) * 2, material, 0.1, periodic=periodic)
    contact = slide_on_rubber(operator, gap, Load("force", 1e-3))
    clearance = gap - contact.penetration + operator.apply(contact.pressure)
    assert contact.violation < 1e-9
    assert np.all(contact.pressure >= 0)
    assert clearance.min() > -1e-9 * contact.penetration
    assert np.abs(clearance[contact.mask]).max() < 1e-9 * contact.penetration
    assert_allclose(contact.force, 1e-3, rtol=1e-12)
    assert contact.friction_coefficient > 0
    if not periodic:
        again = slide_on_rubber(operator, gap, Load("penetration", contact.penetration))
        assert_allclose(again.pressure, contact.pressure, atol=1e-9 * contact.pressure.max())


def test_the_fft_solver_at_rest_is_the_limit_of_slow_sliding():
    x, gap = grid(32, 0.2)
    spacing = (x[1] - x[0],) * 2
    contact = slide_on_rubber(
        Travelling((32, 32), spacing, KELVIN, 1e-10), gap, Load("force", 1e-3)
    )
    still = press(FreeOperator((32, 32), spacing, 1.0), gap, Load("force", 1e-3), tolerance=1e-11)
    assert_allclose(contact.penetration, still.penetration, rtol=1e-6)
    assert_allclose(contact.pressure, still.pressure, atol=1e-6 * still.pressure.max())


@pytest.mark.parametrize("material", [KELVIN, ZENER], ids=["Kelvin-Voigt", "standard"])
@pytest.mark.parametrize("speed", [0.01, 0.3, 20.0])
def test_full_contact_with_a_ridge_follows_the_complex_modulus(material, speed):
    """F_x/A0 = E*'' q (q D^2)/4, E*'' = 4 G''(q v): the half-space of Westergaard's problem."""
    n, amplitude, q = 64, 0.01, 2 * np.pi
    x = np.arange(n) / n
    height = amplitude * np.cos(q * x)[:, None] * np.ones((1, 2))
    slope = amplitude * q * np.sin(q * x)[:, None] * np.ones((1, 2))
    operator = Travelling((n, 2), (1 / n, 1 / n), material, speed, periodic=True)
    modulus = 4 * material.dynamic_modulus(q * speed)
    pressure = 2 * abs(modulus) * q * amplitude / 2
    contact = slide_on_rubber(
        operator, amplitude - height, Load("force", pressure * 2 / n), slope=slope
    )
    assert contact.mask.all()
    assert_allclose(
        contact.tangential_force / (2 / n), modulus.imag * q * q * amplitude**2 / 4, rtol=1e-9
    )
