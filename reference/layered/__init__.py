"""Bodies whose stiffness depends on depth: layers, coatings, a rigid base, powers of the depth.

>>> from reference.elasticity import Material
>>> rubber = Stack([1.0], [Material(1.0, 0.5)])  # bonded to a rigid base
>>> bool(rubber.compliance(1e-3) < rubber.compliance(2e-3))  # long waves cannot squeeze it out
True
"""

from reference.layered.layered_grid import LayeredFree, LayeredPeriodic
from reference.layered.round_contact import RoundContact
from reference.layered.stack import Graded, Stack

__all__ = ["Graded", "LayeredFree", "LayeredPeriodic", "RoundContact", "Stack"]
