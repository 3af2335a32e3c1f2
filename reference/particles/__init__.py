"""Movable cellular automata: a body of particles with pair forces and a mean stress."""

from __future__ import annotations

from reference.particles.far_field import Domain
from reference.particles.half_space import ParticleContact, ParticleHalfSpace
from reference.particles.interaction import Automata, Elastic
from reference.particles.packing import Packing, half_space_packing, periodic_packing
from reference.particles.two_bodies import ParticlePair

__all__ = [
    "Automata",
    "Domain",
    "Elastic",
    "Packing",
    "ParticleContact",
    "ParticleHalfSpace",
    "ParticlePair",
    "half_space_packing",
    "periodic_packing",
]
