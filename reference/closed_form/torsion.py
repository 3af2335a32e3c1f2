"""Torsion of a round contact with partial slip, in closed form (Lubkin 1951).

A body is pressed onto a half-space and twisted about the axis. Circumferential tractions have no
divergence, so that they neither lift the surface nor depend on Poisson's ratio. A disc of radius s
that sticks and turns by an angle b carries (Reissner & Sagoci 1944)

    q = (4 G b/pi) r/sqrt(s^2 - r^2),    M = (16/3) G s^3 b.

With discs of radii from c to a, none of which turns points within c against each other, the
traction is mu p outside c if (an Abel equation)

    b(c) = mu/(2 G) int_c^a p(r)/sqrt(r^2 - c^2) dr,

the angle by which the circle that sticks has turned; the torque is that of the discs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reference.closed_form.form import Array, ClosedForm, require_positive

# Gauss points of an integral over the slip annulus, smooth in the angle.
_POINTS = 400


@dataclass(frozen=True)
class Torsion:
    """A body of revolution under a constant penetration that is twisted once.

    Parameters
    ----------
    form : ClosedForm
        The normal contact, round.
    penetration, friction, shear_modulus : float
        d; mu; G of the half-space under a rigid body, or 1/G = 1/G1 + 1/G2 of two.

    Raises
    ------
    ValueError
        If an argument is not positive and finite, or the contact is not round.

    Examples
    --------
    A ball that sticks in half its radius: b = mu p0/(2 G) [K(k) - E(k)], k^2 = 1 - (c/a)^2.

    >>> from reference.closed_form import paraboloid
    >>> from scipy.special import ellipe, ellipk
    >>> ball = Torsion(paraboloid(1.0, 1.0), penetration=1.0, friction=0.3, shear_modulus=0.25)
    >>> exact = 0.3 * (2 / np.pi) / (2 * 0.25) * (ellipk(0.75) - ellipe(0.75))
    >>> round(float(ball.angle(0.5) / exact), 9)
    1.0
    """

    form: ClosedForm
    penetration: float
    friction: float
    shear_modulus: float

    def __post_init__(self) -> None:
        if self.form.contact_radius is None:
            raise ValueError(f"{self.form.name}: torsion is known of round contacts only")
        require_positive(
            "torsion",
            penetration=self.penetration,
            friction=self.friction,
            shear_modulus=self.shear_modulus,
        )

    @property
    def contact_radius(self) -> float:
        """The radius a."""
        assert self.form.contact_radius is not None
        return float(self.form.contact_radius(self.penetration))

    def angle(self, stick_radius: float) -> float:
        """Return the twist b in radians at which the circle of this radius sticks."""
        return float(self._angles(np.array([stick_radius]))[0])

    def torque(self, stick_radius: float) -> float:
        """Return M = (16/3) G [c^3 b(c) + 3 int_c^a s^2 b(s) ds]."""
        a = self.contact_radius
        nodes, weights = np.polynomial.legendre.leggauss(_POINTS)
        s = stick_radius + (a - stick_radius) * (nodes + 1) / 2
        outer = (a - stick_radius) / 2 * float(weights @ (s**2 * self._angles(s)))
        inner = stick_radius**3 * self.angle(stick_radius)
        return 16 / 3 * self.shear_modulus * (inner + 3 * outer)

    def _angles(self, c: Array) -> Array:
        a = self.contact_radius
        if not ((c > 0) & (c <= a)).all():
            raise ValueError(f"a stick radius lies between 0 and the contact radius {a!r}: {c}")
        nodes, weights = np.polynomial.legendre.leggauss(_POINTS)
        t = np.pi / 4 * (nodes + 1)
        width = np.sqrt((a - c) * (a + c))[:, None]
        # r^2 = c^2 + (a^2 - c^2) sin^2 t
        r = np.sqrt(c[:, None] ** 2 + (width * np.sin(t)) ** 2)
        pressure = self.form.pressure(r, 0.0, self.penetration)
        integral = np.pi / 4 * ((pressure * width * np.cos(t) / r) @ weights)
        return np.asarray(self.friction / (2 * self.shear_modulus) * integral)
