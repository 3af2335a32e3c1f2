"""Elastic-plastic half-spaces below rigid round indenters: J2 finite elements, axisymmetric."""

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
