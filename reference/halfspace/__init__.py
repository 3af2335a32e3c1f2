"""Contact on the elastic half-space: kernels, operators, dense and FFT solvers, areas."""

from __future__ import annotations

from reference.halfspace import areas, dense, fft, kernels
from reference.halfspace.operators import FreeOperator, HalfSpace, PeriodicOperator
from reference.halfspace.solution import Contact

__all__ = [
    "Contact",
    "FreeOperator",
    "HalfSpace",
    "PeriodicOperator",
    "areas",
    "dense",
    "fft",
    "kernels",
]
