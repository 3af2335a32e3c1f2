"""Movable cellular automata: particles in place of a continuum."""
