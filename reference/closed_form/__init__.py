"""Exact solutions of contact with an elastic half-space, as vectorised functions."""

from reference.closed_form.form import ClosedForm
from reference.closed_form.infinite import Westergaard, boussinesq, boussinesq_energy
from reference.closed_form.partial_slip import PartialSlip, stiffness_ratio
from reference.closed_form.shapes import (
    cone,
    cylinder,
    ellipsoid,
    elliptic_punch,
    paraboloid,
    power_law,
    rounded_punch,
    sphere,
)

__all__ = [
    "ClosedForm",
    "PartialSlip",
    "Westergaard",
    "boussinesq",
    "boussinesq_energy",
    "cone",
    "cylinder",
    "ellipsoid",
    "elliptic_punch",
    "paraboloid",
    "power_law",
    "rounded_punch",
    "sphere",
    "stiffness_ratio",
]
