"""Round contacts on a graded half-space in closed form: powers of the radius, and flat faces."""

from __future__ import annotations

from dataclasses import dataclass

from scipy.special import beta

from reference.arguments import choice_faults, positive_faults, refuse
from reference.layered.graded import Graded
from reference.layered.round_contact import RoundStep

CONTROLS = ("penetration", "force")


def line_factor(exponent: float, grading: float = 0.0) -> float:
    """G over f for a section f ~ r^n: (n/2) B(n/2, (1 + k)/2), two for a paraboloid and k = 0.

    >>> round(line_factor(2.0), 12)
    2.0
    """
    return float(exponent / 2 * beta(exponent / 2, (1 + grading) / 2))


@dataclass(frozen=True)
class GradedContact:
    """A rigid body of revolution f = c r^n on a graded half-space (Hess 2016).

    d = kappa c a^n, and F is the integral of c_N |x/c0|^k (d - g) over the contact; Giannakopoulos
    & Suresh (1997) have the cone and the paraboloid.

    Parameters
    ----------
    body : Graded
    exponent, coefficient : float
        n and c.

    Examples
    --------
    Hertz, k = 0:

    >>> from reference.elasticity import Material
    >>> ball = GradedContact(Graded(Material(0.75, 0.5), 0.0, 1.0), 2.0, 0.5)
    >>> round(ball.at("penetration", 0.25).force, 12)
    0.166666666667
    """

    body: Graded
    exponent: float
    coefficient: float

    def __post_init__(self) -> None:
        refuse(positive_faults(exponent=self.exponent, coefficient=self.coefficient))

    def at_radius(self, contact_radius: float) -> RoundStep:
        """Return the contact of a radius."""
        n, k, a = self.exponent, self.body.exponent, contact_radius
        depth = line_factor(n, k) * self.coefficient * a**n
        stiffness = face_stiffness(self.body, a)
        force = stiffness * depth * n / (n + k + 1)
        return RoundStep(a, depth, force, stiffness, force * depth * n / (2 * n + k + 1))

    def at(self, control: str, value: float) -> RoundStep:
        """Return the contact at a penetration or a force, whichever `control` names."""
        refuse(choice_faults("control", control, CONTROLS))
        power = self.exponent + (self.body.exponent + 1 if control == "force" else 0)
        unit = self.at_radius(1.0)
        return self.at_radius(float((value / getattr(unit, control)) ** (1 / power)))


def face_stiffness(body: Graded, radius: float) -> float:
    """F/d of a flat circular face: 2 c_N a^(1+k)/((1 + k) c0^k)."""
    k = body.exponent
    return float(2 * body.spring_modulus * radius * (radius / body.depth) ** k / (1 + k))
