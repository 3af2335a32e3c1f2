"""Automata that yield: J2 plasticity by radial return on the stress of each automaton.

An automaton has a plastic strain e, without change of volume; a bond has the mean of both ends, so
that its relative motion u_j - u_i less the common rotation becomes

    eps n + gamma - (e_i + e_j)/2 n.

The stress of an automaton, the mean of what pulls at its faces, is then the force that works on
its plastic strain, dW/de_i = -V s_i: what the rule of flow has to limit. It is perfectly plastic,
|s| <= sqrt(2/3) Y for the deviator s, and the increment of a load minimises elastic energy and
dissipation together, a convex problem. It is solved in turn for displacements and for plastic
strains, those by

    s' = s + 2 G (e - e_0),    e = e_0 + max(1 - sqrt(2/3) Y/|s'|, 0) s'/(2 G),

e_0 at the load before (J. C. Simo & T. J. R. Hughes, Computational Inelasticity, 1998, sec. 3.3).
2 G is the largest stiffness that any pattern of plastic strains meets, and so each turn lowers the
sum. Loads have to follow each other in small steps only where the direction of flow changes.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from reference.arguments import positive_faults, refuse
from reference.errors import ConvergenceError
from reference.particles.equilibrium import Rest
from reference.particles.far_field import Domain, Search
from reference.particles.half_space import ParticleContact, ParticleHalfSpace
from reference.particles.packing import DIRECTIONS, FACE, LEVEL, VOLUME

Floats = NDArray[np.float64]
Integers = NDArray[np.int32]
Numbers = NDArray[np.int64]

# Largest excess of a stress over the yield stress at the end, and turns until then.
EXCESS = 0.01
MOST_TURNS = 400


class PlasticHalfSpace(ParticleHalfSpace):
    """A half-space of automata that yield; loads follow each other on the same body.

    Parameters
    ----------
    domain, poisson_ratio, spacing, youngs_modulus
        As for `ParticleHalfSpace`.
    yield_stress : float
        Y in a tensile test, of the unit of Young's modulus.

    Attributes
    ----------
    plastic_strain : (n, 3, 3) ndarray
        Of all automata, after the last load.
    """

    def __init__(
        self,
        domain: Domain,
        poisson_ratio: float,
        *,
        yield_stress: float,
        spacing: float = 1.0,
        youngs_modulus: float = 1.0,
    ) -> None:
        refuse(positive_faults(yield_stress=yield_stress))
        super().__init__(domain, poisson_ratio, spacing=spacing, youngs_modulus=youngs_modulus)
        self.limit = np.sqrt(2 / 3) * yield_stress / youngs_modulus
        self.plastic_strain = np.zeros((len(self.automata.packing.places), 3, 3))
        self._before = self.plastic_strain.copy()

    def stresses(self, moved: Floats, traces: Floats) -> Floats:
        """Return the stress tensors (free, 3, 3), in units of E."""
        packing, shear = self.automata.packing, self.automata.material.shear
        relieved = np.empty((packing.free, 3, 3))
        _relief(self.plastic_strain, packing.neighbours, packing.surface, shear, relieved)
        return self.automata.stresses(moved, traces) - relieved

    def _inner_load(self) -> Floats:
        """Return the forces of plastic strains at rest."""
        packing, shear = self.automata.packing, self.automata.material.shear
        out = np.empty((packing.free, 6))
        _forces_of(self.plastic_strain, packing.neighbours, packing.surface, shear, out)
        return -out.ravel()

    def _rest(self, gap: Floats, search: Search, balance: float) -> tuple[Rest, Numbers]:
        """Relax and let flow in turn, until no stress is beyond the limit."""
        history = []
        for _ in range(MOST_TURNS):
            rest, near = super()._rest(gap, search, balance)
            search.moved = rest.moved
            history.append(self._flow(search))
            if history[-1] <= EXCESS:
                return rest, near
        raise ConvergenceError(
            f"stresses are {history[-1]:.1%} above the yield stress after {MOST_TURNS} turns",
            history,
        )

    def _flow(self, search: Search) -> float:
        """Return the stresses to the limit; return the largest excess there was, over the limit."""
        free, double = self.automata.packing.free, 2 * self.automata.material.shear
        self._hold(search.sources)
        self._moved[:free] = search.moved.reshape(-1, 6)
        self.automata.strains(self._moved, self._traces)
        stress = deviator(self.stresses(self._moved, self._traces))
        self._hold(None)
        excess = float(np.linalg.norm(stress, axis=(1, 2)).max()) / self.limit - 1
        before = self._before[:free]
        tried = stress + double * (self.plastic_strain[:free] - before)
        size = np.linalg.norm(tried, axis=(1, 2))
        share = np.maximum(1 - self.limit / np.maximum(size, self.limit), 0.0)
        self.plastic_strain[:free] = before + share[:, None, None] * tried / double
        return excess

    def _contact(
        self, held: tuple[float, Floats], rest: Rest, near: Numbers, steps: int
    ) -> ParticleContact:
        self._before = self.plastic_strain.copy()
        return super()._contact(held, rest, near, steps)


def deviator(stresses: Floats) -> Floats:
    """Return the symmetric part of tensors (n, 3, 3) less its mean."""
    symmetric: Floats = 0.5 * (stresses + np.swapaxes(stresses, 1, 2))
    return symmetric - np.trace(symmetric, axis1=1, axis2=2)[:, None, None] * np.eye(3) / 3


@njit(cache=True, error_model="numpy", inline="always")
def _bond(
    strains: Floats, i: int, j: int, k: int, stiffness: float
) -> tuple[float, float, float]:  # pragma: no cover - compiled
    """Return the pull that a bond loses by the plastic strains of its ends."""
    normal = DIRECTIONS[k]
    x = y = z = 0.0
    for b in range(3):
        x += 0.5 * (strains[i, 0, b] + strains[j, 0, b]) * normal[b]
        y += 0.5 * (strains[i, 1, b] + strains[j, 1, b]) * normal[b]
        z += 0.5 * (strains[i, 2, b] + strains[j, 2, b]) * normal[b]
    return stiffness * x, stiffness * y, stiffness * z


@njit(cache=True, error_model="numpy")
def _forces_of(
    strains: Floats, neighbours: Integers, surface: int, shear: float, out: Floats
) -> None:
    stiffness = 2.0 * shear * FACE
    for i in range(len(out)):
        out[i] = 0.0
        for k in range(12):
            j = neighbours[i, k]
            if j < 0:
                continue
            share = 0.5 if i < surface and k < LEVEL else 1.0
            gx, gy, gz = _bond(strains, i, j, k, share * stiffness)
            nx, ny, nz = DIRECTIONS[k, 0], DIRECTIONS[k, 1], DIRECTIONS[k, 2]
            out[i, 0] += gx
            out[i, 1] += gy
            out[i, 2] += gz
            out[i, 3] += 0.5 * (ny * gz - nz * gy)
            out[i, 4] += 0.5 * (nz * gx - nx * gz)
            out[i, 5] += 0.5 * (nx * gy - ny * gx)


@njit(cache=True, error_model="numpy")
def _relief(strains: Floats, neighbours: Integers, surface: int, shear: float, out: Floats) -> None:
    stiffness = 2.0 * shear * FACE
    for i in range(len(out)):
        volume = 0.5 * VOLUME if i < surface else VOLUME
        out[i] = 0.0
        for k in range(12):
            j = neighbours[i, k]
            if j < 0:
                continue
            share = (0.5 if i < surface and k < LEVEL else 1.0) * 0.5 / volume
            pull = _bond(strains, i, j, k, share * stiffness)
            for a in range(3):
                for b in range(3):
                    out[i, a, b] += DIRECTIONS[k, a] * pull[b]
