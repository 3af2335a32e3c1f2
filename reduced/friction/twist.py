"""Springs under torsion: 8 G dx along the circumference, with Coulomb's law.

The chapter has no rule for torsion. Springs of stiffness 8 G dx that move by b x, at the distance x
from the axis, carry the torque (16/3) G a^3 b of every round contact that sticks (Popov & Hess
2015; exact after Reissner & Sagoci 1944). Whether they may slip one by one, each at mu times its
normal force, as under a force along x (19.19), is a question to them: in full slip they carry
mu E* int 2 x (d - g) dx, where the half-space carries mu int r p dA.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reduced.arguments import positive_faults, refuse
from reduced.loads import Load
from reduced.springs.indent import indent
from reduced.springs.line import Springs


@dataclass(frozen=True)
class Twist:
    """Torque and radius of the springs that stick, at each angle, shape (k,)."""

    torque: np.ndarray
    stick_radius: np.ndarray


def twist(
    springs: Springs, shear_modulus: float, friction: float, penetration: float, angle: np.ndarray
) -> Twist:
    """Twist springs at a constant penetration, from rest to each angle.

    Parameters
    ----------
    springs : Springs
        Their number per radius is that of the nodal sum, which converges with dx^2.
    shear_modulus, friction, penetration : float
        G, mu, d; positive.
    angle : ndarray, shape (k,)
        In radians.

    Examples
    --------
    What sticks carries (16/3) G a^3 b:

    >>> from reduced.profiles.equivalents import paraboloid
    >>> line = Springs(paraboloid(1.0), 1.0, per_radius=1000)
    >>> round(float(twist(line, 0.25, 0.5, 1.0, np.array([1e-9])).torque[0] / (4e-9 / 3)), 5)
    1.0
    """
    wrong = positive_faults(shear_modulus=shear_modulus, friction=friction)
    refuse(wrong + positive_faults(penetration=penetration))
    radius = float(indent(springs, Load("penetration", penetration)).contact_radius[0])
    step = radius / springs.per_radius
    x = (np.arange(springs.per_radius) + 0.5) * step
    limit = friction * springs.effective_modulus * (penetration - springs.profile.height(x))
    held = 8 * shear_modulus * np.abs(angle)[:, None] * x
    carried = np.sign(angle)[:, None] * np.minimum(held, limit)
    return Twist(2 * step * carried @ x, step * (held < limit).sum(axis=1))
