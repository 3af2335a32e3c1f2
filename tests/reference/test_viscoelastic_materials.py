"""The reference's material against quadrature, and against the one of the reduced model."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from reduced.memory.materials import prony
from reference.viscoelastic.materials import GeneralisedMaxwell

POSITIVE = st.floats(1e-3, 1e3)
ARMS = st.lists(st.tuples(POSITIVE, POSITIVE), max_size=6)
MAYBE = st.one_of(st.just(0.0), POSITIVE)


def test_creep_of_a_dashpot_and_two_arms_is_that_of_its_differential_equations():
    """States are the strains of the dashpots; constant stress 1, integrated to 1e-10."""
    material = GeneralisedMaxwell(0.7, [2.0, 5.0], [0.3, 20.0], viscosity=0.4)
    G, tau = np.array([2.0, 5.0]), np.array([0.3, 20.0])

    def rates(_, state):
        strain, arms = state[0], state[1:]
        stress = 0.7 * strain + G @ (strain - arms)
        return np.array([(1 - stress) / 0.4, *((strain - arms) / tau)])

    t = np.array([0.1, 1.0, 30.0])
    result = solve_ivp(rates, (0, 30), np.zeros(3), "Radau", t, rtol=1e-10, atol=1e-13).y[0]
    np.testing.assert_allclose(material.creep(t), result, rtol=1e-8)


@given(equilibrium=MAYBE, arms=ARMS, viscosity=MAYBE)
def test_two_materials_written_apart_agree(equilibrium, arms, viscosity):
    """Relaxation, complex modulus and creep of the same springs and dashpots."""
    if not (equilibrium or arms or viscosity):
        return
    moduli, times = zip(*arms, strict=True) if arms else ((), ())
    here = prony(equilibrium, moduli, times, viscosity=viscosity)
    there = GeneralisedMaxwell(equilibrium, moduli, times, viscosity)
    t = np.geomspace(1e-4, 1e4, 9)
    np.testing.assert_allclose(there.relaxation(t), here.relaxation(t), rtol=1e-12, atol=0)
    w = np.concatenate([-t, t])
    np.testing.assert_allclose(there.dynamic_modulus(w), here.complex_modulus(w), rtol=1e-12)
    np.testing.assert_allclose(there.creep(t), here.creep().compliance(t), rtol=1e-9)


def test_bad_materials_are_refused_with_every_fault():
    with pytest.raises(ValueError, match=r"equilibrium.*viscosity.*arm_moduli.*arm_times"):
        GeneralisedMaxwell(-1.0, [np.inf], [0.0], viscosity=np.nan)
    with pytest.raises(ValueError, match="nothing resists"):
        GeneralisedMaxwell(0.0)
