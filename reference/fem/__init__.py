"""Finite elements: an elastic half-space condensed onto its contact points, and rigid shapes on it.

All but the surface is eliminated: of any mesh by nested dissection (`condensation`), of a grid that
repeats wave by wave (`columns`).

>>> import numpy as np
>>> from reference.loads import LoadPath
>>> body = half_space_body(RingMesh(contact_radius=1.0), Material(1.0, 0.3))
>>> gap = 0.5 * (body.points**2).sum(axis=1)  # a paraboloid of radius 1
>>> (step,) = press(body, gap, LoadPath("penetration", 0.9))
>>> hertz = 4.0 / 3.0 * body.effective_modulus * 0.9**1.5
>>> bool(abs(step.force / hertz - 1.0) < 0.005)
True
"""

from reference.elasticity import Material
from reference.fem.condensed_body import CondensedBody, half_space_body, recover
from reference.fem.contact import (
    Enforcement,
    NodalContact,
    at_quadrature_points,
    contact_radius,
    indent,
    press,
)
from reference.fem.half_space_mesh import SYMMETRIES, RingMesh, TensorMesh

__all__ = [
    "SYMMETRIES",
    "CondensedBody",
    "Enforcement",
    "Material",
    "NodalContact",
    "RingMesh",
    "TensorMesh",
    "at_quadrature_points",
    "contact_radius",
    "half_space_body",
    "indent",
    "press",
    "recover",
]
