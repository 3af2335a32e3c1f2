r"""Automata that yield: J2 plasticity by radial return on the stress of each automaton.

The stress s of an automaton, the mean of what pulls at its faces less what its plastic strain e
relieves, is the force that works on this strain, dW/de = -V s: what the rule of flow has to limit.
The increment of a load minimises elastic energy, dissipation and what hardening stores together, a
convex problem. It is solved in turn for displacements and for plastic strains, those by the radial
return of `reference.plastic.j2` from the trial stress

    s' = s + 2 G (e - e_0),

e_0 at the load before (J. C. Simo & T. J. R. Hughes, Computational Inelasticity, 1998, sec. 3.3).
2 G is the largest stiffness that any pattern of plastic strains meets, and so each turn lowers the
sum: steps of a proximal gradient in the plastic strains, accelerated by Nesterov's rule (A. Beck &
M. Teboulle, SIAM J. Imaging Sci. 2 (2009) 183), without momentum after a turn that has gone too
far. A load is solved when no strain would change its automaton's stress by more than a per cent of
the yield stress; strains, displacements and force are then those of one and the same turn.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from reference.arrays import Array, Integers
from reference.errors import ConvergenceError
from reference.loads import LoadPath
from reference.particles.automata import Domain
from reference.particles.mprgp import Rest
from reference.particles.particle_body import BALANCE, Held, ParticleContact, ParticleHalfSpace
from reference.plastic.j2 import PlasticMaterial, plastic_step

# Largest change of a stress that flow would still make, over the yield stress, and turns at most.
EXCESS = 0.01
MOST_TURNS = 400
# A load beyond all before is reached in stages of this ratio, as the direction of flow changes: of
# first order, the force on a ball at sixty times the depth of first yield is 5 % too small in one
# stage, and 1.4 % in these. In the first one an automaton or two touch.
STAGE, FIRST_STAGE = 2**0.25, 1 / 8


class PlasticHalfSpace(ParticleHalfSpace):
    """A half-space of automata that yield; loads follow each other on the same body.

    `flowed` (n, 3, 3) and `amount` (n,) are plastic strains and accumulated equivalent plastic
    strains of all automata, after the last load.
    """

    def __init__(self, domain: Domain, material: PlasticMaterial, *, spacing: float = 1.0) -> None:
        elastic = material.elastic
        modulus = elastic.youngs_modulus
        super().__init__(domain, [(modulus, elastic.poisson_ratio)], spacing=spacing)
        self.material = material.scaled(modulus)
        count = len(self.automata.packing.places)
        self.flowed, self.amount = np.zeros((count, 3, 3)), np.zeros(count)
        self._before = self.flowed, self.amount

    def walk(
        self, gap: ArrayLike, path: LoadPath, *, balance: float = BALANCE
    ) -> Iterator[ParticleContact]:
        """Yield the contact at each load of a path, up and down; without force where it is lost.

        Penetrations, or forces of at least zero; `gap` and `balance` as for `press`.
        """
        forced = path.one_of("penetration", "force") == "force"
        scale = self._unit_of(path.control)
        gap = self._scaled_gap(gap)
        last, largest = None, 0.0
        for value in (path.values / scale).tolist():
            origin = 0.0
            if value < largest:  # down, or up from there: the dent has a depth
                origin = self._lift_off(gap, balance).penetration / self.spacing
            earlier, largest = largest, max(largest, value)
            if value <= (0.0 if forced else origin):
                yield self._lift_off(gap, balance, depth=None if forced else value, keep=True)
                last = None
                continue
            # beyond the largest load so far in stages
            start = max(earlier, FIRST_STAGE * value)
            count = max(int(np.ceil(np.log(value / start) / np.log(STAGE) - 1e-9)), 1)
            stages = start * (value / start) ** (np.arange(1, count + 1) / count)
            for stage in stages.tolist() if value > start else [value]:
                contact, last = self._agreed(
                    gap, stage, origin, last, forced=forced, balance=balance
                )
            yield contact

    def residual_depth(self, gap: ArrayLike, *, balance: float = BALANCE) -> float:
        """Return the penetration at which contact would be lost if the shape were lifted off."""
        return self._lift_off(self._scaled_gap(gap), balance).penetration

    def _lift_off(
        self, gap: Array, balance: float, *, depth: float | None = None, keep: bool = False
    ) -> ParticleContact:
        """Return the body without load, at a given penetration or where contact is lost."""
        state = self._before
        none, nothing = np.zeros(0, dtype=np.int64), np.zeros(0)
        moved, sources = np.zeros(self._forces.size), np.zeros(self._far[0].shares.shape[1])
        rest = Rest(moved, nothing, np.zeros(0, dtype=bool), 0, [0.0])
        if self.amount.any():
            rest = self._relaxed(none, nothing, moved, sources, balance)
        left = self._contact(0.0, sources, rest, nothing, none, rest.steps)
        if keep:
            self._before = self.flowed, self.amount
        else:
            self.flowed, self.amount = state
        if depth is None:
            depth = float(np.min(gap + left.displacement / self.spacing))
        return replace(left, penetration=depth * self.spacing)

    def _agreed(self, *arguments: Any, **options: Any) -> tuple[ParticleContact, Held]:
        """Solve one load, from whose plastic strains the next one begins."""
        solved = super()._agreed(*arguments, **options)
        self._before = self.flowed, self.amount
        return solved

    def _relaxed(
        self, numbers: Integers, floor: Array, moved: Array, sources: Array, balance: float
    ) -> Rest:
        """Solve for displacements and plastic strains in turn until no automaton yields further."""
        free, double = self.automata.packing.free, 2 * self.automata.shear
        begun, amount = self._before
        history: list[float] = []
        steps, pace, last = 0, 1.0, self.flowed
        for _ in range(MOST_TURNS):
            rest = super()._relaxed(numbers, floor, moved, sources, balance)
            moved, steps = rest.moved, steps + rest.steps
            # radial return from the trial stress of each automaton
            self._hold(sources)
            self._move(moved)
            stress = deviator(self.automata.stresses(self._moved[0], self._traces[0], self.flowed))
            self._hold(None)
            tried = stress + double * (self.flowed[:free] - begun[:free])
            size = np.sqrt(1.5) * np.linalg.norm(tried, axis=(1, 2))
            more = plastic_step(self.material, size, amount[:free])
            share = 1.5 * more / np.where(size > 0, size, 1.0)
            strain, total = begun.copy(), amount.copy()
            strain[:free] += share[:, None, None] * tried
            total[:free] += more
            # the largest change of a stress is no less than the excess of any
            change = double * np.linalg.norm(strain - self.flowed, axis=(1, 2)).max()
            history.append(float(np.sqrt(1.5) * change / self.material.yield_stress))
            if history[-1] <= EXCESS:
                return replace(rest, steps=steps)
            # Nesterov's momentum, none after a turn that has gone too far
            too_far = len(history) > 1 and history[-1] > history[-2]
            before, pace = pace, 0.5 * (1 + np.sqrt(1 + 4 * pace**2))
            ahead = 0.0 if too_far else (before - 1) / pace
            self.flowed, last = strain + ahead * (strain - last), strain
            self.amount = total
        raise ConvergenceError(
            f"stresses are {history[-1]:.1%} of the yield stress off after {MOST_TURNS} turns",
            history,
        )


def deviator(stresses: Array) -> Array:
    """Return the symmetric part of tensors (n, 3, 3) less its mean."""
    symmetric: Array = 0.5 * (stresses + np.swapaxes(stresses, 1, 2))
    return symmetric - np.trace(symmetric, axis1=1, axis2=2)[:, None, None] * np.eye(3) / 3
