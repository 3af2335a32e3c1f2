"""Automata that move freely: leapfrog steps, their energy, and the waves of the packing.

Units: the spacing, Young's modulus and the density; times are in r0 sqrt(rho/E). An automaton has
the mass V and, as a ball of diameter r0, the moment of inertia V/10.

Leapfrog steps of a linear system conserve 1/2 v+ M v- + 1/2 x K x with the velocities half a step
before and after, up to round-off and at any stable step (E. Hairer et al., Acta Numerica 12 (2003)
399): what changes in it is an error of the forces.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.arguments import positive_faults, refuse
from reference.particles.interaction import Automata, Elastic
from reference.particles.packing import DIRECTIONS, FACE, VOLUME

Floats = NDArray[np.float64]

MASSES = VOLUME * np.array([1.0, 1.0, 1.0, 0.1, 0.1, 0.1])


@dataclass(eq=False)
class Motion:
    """Automata in motion.

    Parameters
    ----------
    automata : Automata
        None of them held.
    moved, velocities : (n, 6) ndarray
        Displacements and rotations, and their rates half a step before.
    step : float
        Time step; stable below 2 over the highest frequency.

    Raises
    ------
    ValueError
        If the step is not positive, or automata are held.
    """

    automata: Automata
    moved: Floats
    velocities: Floats
    step: float

    def __post_init__(self) -> None:
        faults = positive_faults(step=self.step)
        packing = self.automata.packing
        if packing.free < len(packing.places):
            faults.append("automata must all be free: those of a half-space's shell are held")
        refuse(faults)
        self._traces = np.zeros(len(self.moved))
        self._pulls = np.empty_like(self.moved)

    def run(self, steps: int) -> Floats:
        """Make steps; return the conserved energy of each."""
        energies = np.empty(steps)
        for number in range(steps):
            pull = self.automata.forces(self.moved, self._traces, self._pulls)
            stored = -0.5 * np.vdot(self.moved, pull)
            after = self.velocities + self.step * pull / MASSES
            energies[number] = 0.5 * np.vdot(self.velocities, MASSES * after) + stored
            self.velocities = after
            self.moved += self.step * after
        return energies


def wave_speeds(material: Elastic, wave: ArrayLike) -> Floats:
    """Return the speeds of the plane waves of a wave vector (in 1/r0), ascending.

    Three of displacement; those of rotation are cut off at high frequencies and left out. From the
    stiffness of the packing under u exp(i q x), theta exp(i q x).

    Examples
    --------
    Long waves have the speeds of the continuum, sqrt(G/rho) twice and sqrt((lambda + 2 G)/rho):

    >>> speeds = wave_speeds(Elastic(0.25), [1e-3, 0.0, 0.0])
    >>> (speeds**2).round(5).tolist()
    [0.4, 0.4, 1.2]
    """
    wave = np.asarray(wave, dtype=float)
    stiffness = wave_stiffness(material, wave) / np.sqrt(np.outer(MASSES, MASSES))
    frequencies = np.sqrt(np.maximum(np.linalg.eigvalsh(stiffness)[:3], 0.0))
    return frequencies / np.linalg.norm(wave)


def wave_stiffness(material: Elastic, wave: Floats) -> NDArray[np.complex128]:
    """Return the (6, 6) Hermitian stiffness of an automaton in a plane wave of the packing.

    The energy of `reference.particles.interaction`, bond by bond.
    """
    total = np.zeros((6, 6), dtype=complex)
    volume = np.zeros(3, dtype=complex)
    for normal in DIRECTIONS:
        there = np.exp(1j * wave @ normal)
        volume += 0.25 * (there - 1) * normal
        # relative displacement less the common rotation: eps n + gamma
        cross = np.array(
            [
                [0.0, -normal[2], normal[1]],
                [normal[2], 0.0, -normal[0]],
                [-normal[1], normal[0], 0.0],
            ]
        )
        strain = np.hstack([(there - 1) * np.eye(3), 0.5 * (there + 1) * cross])
        # each bond belongs to two automata, and has 2 G of V/4 in its face
        total += material.shear * FACE * strain.conj().T @ strain
    total[:3, :3] += VOLUME * material.lame * np.outer(volume.conj(), volume)
    return total
