"""Finite elements: an elastic half-space condensed onto its contact points, and rigid shapes on it.

>>> import numpy as np
>>> body = ball_body(contact_radius=1.0, youngs_modulus=1.0, poisson_ratio=0.3)
>>> gap = 0.5 * (body.points**2).sum(axis=1)  # a paraboloid of radius 1
>>> (step,) = press(body, gap, penetration=0.9)
>>> hertz = 4.0 / 3.0 * body.effective_modulus * 0.9**1.5
>>> bool(abs(step.force / hertz - 1.0) < 0.005)
True
"""

from reference.fem.body import CondensedBody
from reference.fem.contact import Contact, press
from reference.fem.contact_area import contact_radius
from reference.fem.half_space import SYMMETRIES, ball_body, tensor_body, tensor_unknowns
from reference.fem.mesh import graded_lines
from reference.fem.quadrature_contact import at_quadrature_points
from reference.fem.recovery import Fields, recover
from reference.fem.single_contact import indent

__all__ = [
    "SYMMETRIES",
    "CondensedBody",
    "Contact",
    "Fields",
    "at_quadrature_points",
    "ball_body",
    "contact_radius",
    "graded_lines",
    "indent",
    "press",
    "recover",
    "tensor_body",
    "tensor_unknowns",
]
