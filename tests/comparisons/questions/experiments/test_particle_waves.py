"""Automata in motion."""

from itertools import islice

import numpy as np

from comparisons.questions.experiments.particles import leapfrog
from reference.elasticity import lame_parameters
from reference.particles import Automata, periodic_packing

RNG = np.random.default_rng(1)


def ringing(step_share=0.35):
    packing = periodic_packing((2, 2, 2))
    lame, shear = lame_parameters(0.3)
    fastest = np.sqrt(lame + 2 * shear)
    velocities = RNG.normal(size=(packing.free, 6))
    moved, automata = np.zeros_like(velocities), Automata(packing, 0.3)
    return leapfrog(automata, moved, velocities, step_share / fastest), velocities


def test_undamped_motion_conserves_energy_and_momentum():
    motion, velocities = ringing()
    before = velocities[:, :3].sum(axis=0)
    energies = list(islice(motion, 2000))
    assert np.ptp(energies) < 1e-10 * energies[0]
    np.testing.assert_allclose(velocities[:, :3].sum(axis=0), before, atol=1e-11)
