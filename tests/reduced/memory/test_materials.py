"""Viscoelastic materials, and impacts on springs of them."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from reduced.errors import ConvergenceError
from reduced.memory.in_time import impact
from reduced.memory.materials import fit, kelvin_voigt, prony, standard_solid
from reduced.memory.row import RelaxingSprings
from reduced.profiles.equivalents import cylinder, paraboloid

SOLID = prony(0.7, [2.0, 0.1, 5.0, 1.3], [0.3, 4.0, 1e-3, 90.0])
FLUID = prony(0.0, [2.0, 1.0], [0.5, 8.0])
DAMPED = prony(0.7, [2.0, 5.0], [0.3, 20.0], viscosity=0.4)
POSITIVE = st.floats(1e-3, 1e3)
ARMS = st.lists(st.tuples(POSITIVE, POSITIVE), min_size=1, max_size=6)


@pytest.mark.parametrize("material", [SOLID, FLUID, DAMPED], ids=["solid", "fluid", "dashpot"])
def test_creep_and_relaxation_are_inverse(material):
    """int_0^t G(t - s) J(s) ds = t (Ferry 1980, 1(18)), by quadrature split at every scale."""
    creep = material.creep()
    for t in (1e-3, 0.2, 5.0, 300.0):
        cuts = np.concatenate([[0.0], t * np.geomspace(1e-6, 0.5, 12)])
        cuts = np.unique(np.concatenate([cuts, t - cuts]))
        total = sum(
            quad(
                lambda s, t=t: float(material.relaxation(t - s) * creep.compliance(s)),
                *ends,
                epsrel=1e-11,
            )[0]
            for ends in itertools.pairwise(cuts)
        )
        total += material.viscosity * float(creep.compliance(t))
        assert total == pytest.approx(t, rel=1e-9)


@given(long_term=POSITIVE, arms=ARMS, viscosity=st.one_of(st.just(0.0), POSITIVE))
def test_creep_limits(long_term, arms, viscosity):
    """J runs from 1/(G_inf + sum G) (0 with a dashpot) to 1/G_inf: the compliances add up."""
    material = prony(long_term, *zip(*arms, strict=True), viscosity=viscosity)
    creep = material.creep()
    # Zeros next to a pole lose digits of their small compliance to cancellation.
    assert creep.instantaneous + creep.compliances.sum() == pytest.approx(1 / long_term, rel=1e-9)
    assert (creep.compliances >= 0).all()
    assert creep.times.size == material.times.size + (viscosity > 0)


def test_fit_recovers_a_material_among_its_own_times():
    """Data of a Prony series at its own times: the fit is that series, other arms drop out."""
    w = np.geomspace(1e-3, 1e4, 29)
    data = SOLID.complex_modulus(w)
    times = np.concatenate([SOLID.times, [1e-2, 20.0, 1.0]])
    fitted = fit(w, data, times=times)
    np.testing.assert_array_equal(fitted.material.times, SOLID.times)
    np.testing.assert_allclose(fitted.material.moduli, SOLID.moduli, rtol=1e-8)
    assert fitted.rms_error < 1e-10


def test_fit_with_a_dashpot_recovers_kelvin_voigt():
    w = np.geomspace(1e-2, 1e3, 11)
    fitted = fit(w, 3.0 + 0.5j * w, dashpot=True)
    assert fitted.material.long_term == pytest.approx(3.0, rel=1e-9)
    assert fitted.material.viscosity == pytest.approx(0.5, rel=1e-9)


@given(noise=st.integers(0, 10_000))
def test_a_fit_to_noisy_data_is_passive(noise):
    rng = np.random.default_rng(noise)
    w = np.geomspace(1e-2, 1e2, 15)
    data = SOLID.complex_modulus(w) * rng.uniform(0.3, 3.0, 15)
    result = fit(w, data, dashpot=True).material
    assert result.long_term >= 0
    assert result.viscosity >= 0
    assert (result.moduli > 0).all()


BALL = paraboloid(1.0)


def zener(ratio, tau):
    return standard_solid(1.0, ratio, relaxation_time=tau)


@pytest.mark.parametrize("damping", [0.05, 0.3, 0.9])
def test_punch_on_kelvin_voigt_is_the_damped_oscillator(damping):
    """Restitution exp(-z/sqrt(1 - z^2) arccos(2 z^2 - 1)) (Schwager & Poeschel 2007).

    The contact ends at zero force, before the depth is zero;
    k = 8 G b, c = 8 eta b, z = c/(2 sqrt(k m)); second order in the step.
    """
    stiffness, mass = 8 * 1.5 * 0.2, 0.7
    viscosity = 2 * damping * np.sqrt(stiffness * mass) / (8 * 0.2)
    root = np.sqrt(1 - damping**2)
    exact = np.exp(-damping / root * np.arccos(2 * damping**2 - 1))
    steps = np.array([25, 50, 100, 200])
    springs = RelaxingSprings(cylinder(0.2), kelvin_voigt(1.5, viscosity), per_radius=3)
    errors = [abs(impact(springs, mass, 0.1, steps=n).restitution / exact - 1) for n in steps]
    assert -np.polyfit(np.log(steps), np.log(errors), 1)[0] > 1.9
    assert errors[-1] < 1e-4


@given(tau=st.floats(1e-2, 1e2), ratio=st.floats(0.1, 20))
@settings(max_examples=8)
def test_energy_is_lost_and_accounted_for(tau, ratio):
    """Kinetic energy falls by the work done on the springs: int F dd over the path."""
    speed = 1e-2
    rebound = impact(RelaxingSprings(BALL, zener(ratio, tau)), 1.0, speed)
    assert 0 < rebound.restitution <= 1 + 1e-5
    work = np.sum((rebound.force[1:] + rebound.force[:-1]) / 2 * np.diff(rebound.penetration))
    lost = (1 - rebound.restitution**2) * speed**2 / 2
    # trapezoids in 200 steps, second order
    assert work == pytest.approx(lost, abs=5e-4 * speed**2 / 2)


def test_a_fluid_that_keeps_the_body_says_so():
    """A heavy body creeps into a thin fluid for far longer than an impact lasts."""
    thin = RelaxingSprings(cylinder(1.0), prony(0.0, [1.0], [1e-3]), per_radius=2)
    with pytest.raises(ConvergenceError, match="still in contact"):
        impact(thin, 1e9, 1e-6, steps=3)
