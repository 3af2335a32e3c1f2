"""Exact solutions of contact with an elastic half-space, as vectorised functions."""

from reference.closed_form.axisymmetric import cone, paraboloid, power_law, sphere
from reference.closed_form.elliptic import ellipsoid, elliptic_punch
from reference.closed_form.form import ClosedForm
from reference.closed_form.infinite import WavyForm, boussinesq, boussinesq_energy, westergaard
from reference.closed_form.partial_slip import PartialSlip, PartialSlipPath, stiffness_ratio
from reference.closed_form.punches import cylinder, rounded_punch

__all__ = [
    "ClosedForm",
    "PartialSlip",
    "PartialSlipPath",
    "WavyForm",
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
    "westergaard",
]
