r"""Two half-spaces of automata, pressed together without friction.

Their nets lie upon each other, and an automaton of one may not enter the one below it: with the
displacements u_1 and u_2 of both into their own bodies u_1 + u_2 >= d - f. The unknowns of a pair
of surface automata are w = (u_1 + u_2)/sqrt(2), which the floor is under, and (u_1 - u_2)/sqrt(2):
a rotation, which leaves the stiffness as well conditioned as that of either body. Nothing is said
of an effective modulus.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from reference.arguments import positive_faults, refuse
from reference.elasticity import von_mises
from reference.particles.equilibrium import Rest
from reference.particles.far_field import Domain, FarField
from reference.particles.half_space import ParticleContact, ParticleHalfSpace
from reference.particles.interaction import Automata, Elastic, components

Floats = NDArray[np.float64]


class ParticlePair(ParticleHalfSpace):
    """Two half-spaces of automata of the same spacing; a gap belongs to both.

    Parameters
    ----------
    domain : Domain
        Of each of them.
    youngs_moduli, poisson_ratios : (float, float)
    spacing : float

    Examples
    --------
    Two equal bodies are half as stiff as one below a rigid shape:

    >>> from reference.loads import Load
    >>> domain = Domain((3.0, 3.0), 4.0)
    >>> pair, single = ParticlePair(domain, (1.0, 1.0), (0.3, 0.3)), ParticleHalfSpace(domain, 0.3)
    >>> gap = (pair.points**2).sum(axis=1) / 40
    >>> forces = [next(b.press(gap, Load("penetration", 0.2))).force for b in (pair, single)]
    >>> round(forces[0] / forces[1], 4)
    0.5
    """

    bodies = 2

    def __init__(
        self,
        domain: Domain,
        youngs_moduli: tuple[float, float],
        poisson_ratios: tuple[float, float],
        *,
        spacing: float = 1.0,
    ) -> None:
        first, second = youngs_moduli
        refuse(positive_faults(youngs_modulus=first, second_youngs_modulus=second))
        super().__init__(domain, poisson_ratios[0], spacing=spacing, youngs_modulus=first)
        packing = self.automata.packing
        self.ratio = second / first
        self.second = Automata(packing, Elastic(poisson_ratios[1]))
        self._second_far = FarField(domain, packing, poisson_ratios[1])
        self._moved = np.zeros((2, len(packing.places), 6))
        self._traces = np.zeros((2, len(packing.places)))

    @property
    def effective_modulus(self) -> float:
        """E* of both, by which the search begins; what comes out does not depend on it."""
        ratios = [a.material.poisson_ratio for a in (self.automata, self.second)]
        compliance = (1 - ratios[0] ** 2) + (1 - ratios[1] ** 2) / self.ratio
        return self.youngs_modulus / compliance

    def equivalent_stresses(self, contact: ParticleContact) -> Floats:
        """Return the von Mises stresses of all that move, the first body's before the second's."""
        tensors = [
            modulus * automata.stresses(moved, traces)
            for automata, modulus, moved, traces in zip(
                *((self.automata, self.second), (1.0, self.ratio), contact.moved, contact.traces),
                strict=True,
            )
        ]
        return self.youngs_modulus * von_mises(components(np.concatenate(tensors)))

    def inside(self, contact: ParticleContact) -> tuple[Floats, Floats, Floats]:
        """Return places, displacements and stresses, the second body above the first."""
        packing, mirror = self.automata.packing, np.array([1.0, 1.0, -1.0])
        places = packing.places[: packing.free] * self.spacing
        moved = contact.moved[:, : packing.free, :3] * self.spacing
        return (
            np.concatenate([places, places * mirror]),
            np.concatenate([moved[0], moved[1] * mirror]),
            self.equivalent_stresses(contact),
        )

    def _hold(self, sources: Floats | None) -> None:
        free = self.automata.packing.free
        for body, far in enumerate((self.far, self._second_far)):
            held = np.zeros((1, 7))
            if sources is not None:
                held = far.at_shell(sources) / self.ratio**body
            self._moved[body, free:], self._traces[body, free:] = held[:, :6], held[:, 6]

    def _pulls(self, way: Floats, flowed: Floats) -> Floats:
        free = self.automata.packing.free
        self._moved[:, :free] = self._turned(way.reshape(2, free, 6))
        pulls = np.empty((2, free, 6))
        self.automata.forces(self._moved[0], self._traces[0], pulls[0])
        self.second.forces(self._moved[1], self._traces[1], pulls[1])
        pulls[1] *= self.ratio
        return self._turned(pulls).ravel()

    def _turned(self, both: Floats) -> Floats:
        """Return normal parts of surface automata as sum and difference over sqrt(2), or back."""
        surface = self.automata.packing.surface
        first, second = both[:, :surface, 2]
        turned = both.copy()
        turned[0, :surface, 2] = np.sqrt(0.5) * (first + second)
        turned[1, :surface, 2] = np.sqrt(0.5) * (first - second)
        return turned

    def _contact(
        self, held: tuple[float, Floats], rest: Rest, near: NDArray[np.int64], steps: int
    ) -> ParticleContact:
        """Return the contact; its displacement is that of both surfaces together."""
        packing = self.automata.packing
        self._hold(held[1])
        self._moved[:, : packing.free] = self._turned(rest.moved.reshape(2, packing.free, 6))
        for body, automata in enumerate((self.automata, self.second)):
            automata.strains(self._moved[body], self._traces[body])
        shift = self._moved[:, : packing.surface, 2].sum(axis=0)
        return self._as_contact(held[0], rest, near, steps, shift)
