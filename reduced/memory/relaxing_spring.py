"""One viscoelastic spring between two states: it holds, lets go, recovers, catches.

In contact the spring follows the body, and its arms have stresses s_j. Free, it has no force, and
its deflection is a sum of modes w_k that decay with the retardation times lambda_k, plus the
permanent part of a fluid. Both describe the same state (partial fractions of G and J):

    w_k = J_k [G_inf u + sum_j s_j tau_j/(tau_j - lambda_k)],
    s_j = sum_k w_k G_j tau_j/(tau_j - lambda_k)      at f = 0.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from reduced.memory.materials import Prony


class SpringLaw(NamedTuple):
    """Material of a spring per unit spacing; times may be in any unit, lengths v t included."""

    long_term: float
    moduli: np.ndarray
    times: np.ndarray
    viscosity: float
    fluid: bool
    compliances: np.ndarray
    retardations: np.ndarray
    spread: np.ndarray  # tau_j/(tau_j - lambda_k), shape (arms, modes)


def law_of(material: Prony, speed: float = 1.0) -> SpringLaw:
    """Return the law of springs of a material; with a speed, times become lengths v t."""
    creep = material.creep()
    apart = material.times[:, None] - creep.times
    spread = np.divide(material.times[:, None], apart, out=np.zeros(apart.shape), where=apart != 0)
    return SpringLaw(
        float(material.long_term),
        material.moduli,
        speed * material.times,
        float(speed * material.viscosity),
        material.long_term == 0,
        np.asarray(creep.compliances),
        speed * np.asarray(creep.times),
        spread,
    )


@njit(cache=True)
def held_stress(stress, modulus, ratio, change):
    """Return the stress of an arm after a linear strain `change` over `ratio` = time/tau."""
    gain = -np.expm1(-ratio) / ratio if ratio > 0 else 1.0
    return stress * np.exp(-ratio) + modulus * gain * change


@njit(cache=True)
def hold(law, arms, change, duration):
    """Advance the arms of a spring in contact through a linear change of its deflection."""
    for j in range(arms.size):
        arms[j] = held_stress(arms[j], law.moduli[j], duration / law.times[j], change)


@njit(cache=True)
def let_go(law, deflection, arms, modes):
    """Turn the arms of a released spring into modes; return the permanent deflection."""
    permanent = deflection
    for k in range(modes.size):
        total = law.long_term * deflection
        for j in range(arms.size):
            total += arms[j] * law.spread[j, k]
        modes[k] = law.compliances[k] * total
        permanent -= modes[k]
    arms[:] = 0.0
    return permanent if law.fluid else 0.0


@njit(cache=True)
def recover(law, modes, duration):
    """Advance the modes of a free spring."""
    for k in range(modes.size):
        modes[k] *= np.exp(-duration / law.retardations[k])


@njit(cache=True)
def catch(law, arms, modes):
    """Turn the modes of a free spring into the arms of one that makes contact."""
    for j in range(arms.size):
        total = 0.0
        for k in range(modes.size):
            total += modes[k] * law.spread[j, k]
        arms[j] = law.moduli[j] * total
    modes[:] = 0.0
