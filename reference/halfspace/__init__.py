"""Contact on the elastic half-space: kernels, operators, areas."""

from reference.contact.press import Contact
from reference.halfspace import areas, kernels
from reference.halfspace.kernels import FreeOperator, PeriodicOperator

__all__ = ["Contact", "FreeOperator", "PeriodicOperator", "areas", "kernels"]
