"""Elastic-plastic half-spaces: J2 finite elements below round indenters, a cap on grids."""

from reference.plastic.indentation import Indentation, OutgrownError, State
from reference.plastic.materials import PlasticMaterial, yield_depth, yield_pressure
from reference.plastic.path import Moment, Walk

__all__ = [
    "Indentation",
    "Moment",
    "OutgrownError",
    "PlasticMaterial",
    "State",
    "Walk",
    "yield_depth",
    "yield_pressure",
]
