"""Elastic-plastic half-spaces: J2 finite elements below round indenters, a cap on grids."""

from reference.plastic.first_yield import yield_depth, yield_pressure
from reference.plastic.indentation import Indentation, OutgrownError, PlasticState
from reference.plastic.j2 import PlasticMaterial
from reference.plastic.path import DentMoment, Walk

__all__ = [
    "DentMoment",
    "Indentation",
    "OutgrownError",
    "PlasticMaterial",
    "PlasticState",
    "Walk",
    "yield_depth",
    "yield_pressure",
]
