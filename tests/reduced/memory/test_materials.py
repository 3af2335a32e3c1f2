"""Viscoelastic materials: textbook cases, creep against relaxation, update, fit."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from reduced.memory.materials import fit, prony

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
