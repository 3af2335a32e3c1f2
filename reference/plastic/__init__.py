"""Elastic-plastic half-spaces: J2 finite elements below round indenters, a cap on grids."""

from reference.plastic.dent_formulas import yield_depth, yield_pressure
from reference.plastic.indentation import DentMoment, OutgrownError, Walk
from reference.plastic.j2 import PlasticMaterial

__all__ = [
    "DentMoment",
    "OutgrownError",
    "PlasticMaterial",
    "Walk",
    "yield_depth",
    "yield_pressure",
]
