"""Impact of a mass on springs: elastic, damped oscillator, energy, rates, units."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reduced.errors import ConvergenceError
from reduced.memory.in_time import impact
from reduced.memory.materials import kelvin_voigt, prony, standard_solid
from reduced.memory.row import RelaxingSprings
from reduced.profiles.equivalents import cylinder, paraboloid

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
