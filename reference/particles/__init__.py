"""Movable cellular automata: a body of particles with pair forces and a mean stress."""

from reference.particles.automata import (
    Automata,
    Domain,
    Packing,
    half_space_packing,
    periodic_packing,
)
from reference.particles.particle_body import ParticleContact, ParticleHalfSpace

__all__ = [
    "Automata",
    "Domain",
    "Packing",
    "ParticleContact",
    "ParticleHalfSpace",
    "half_space_packing",
    "periodic_packing",
]
