"""Cylinders that roll in plane strain: with friction and creep (Carter), on rubber (Hunter)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ive, kve

from reference.arrays import Array
from reference.errors import positive_faults, refuse


@dataclass(frozen=True)
class Carter:
    """A cylinder that rolls along its circumference with creep (Carter 1926; Johnson 1985, 8.3).

    The tractions are those of full sliding less those of a strip at the leading edge that sticks:

        q(x) = mu p0 [sqrt(1 - x^2/a^2) - (c/a) sqrt(1 - (x - a + c)^2/c^2)],
        Q/(mu P) = 1 - (c/a)^2,   xi = (mu a/R) (1 - c/a),

    2 c the length of the strip and R the radius of a rigid cylinder, or 1/R the sum of the
    curvatures. Exact without coupling of normal and tangential displacements: bodies of equal
    constants, or nu = 1/2.

    CONTACT's example: a 1 mm, R 500 mm, mu 0.3, and a strip of 0.6 a that sticks.

    >>> cylinder = Carter(1.0, 500.0, 0.3)
    >>> round(float(cylinder.traction(2.4e-4)), 12), round(float(cylinder.stick_share(2.4e-4)), 12)
    (0.64, 0.6)
    >>> round(float(cylinder.creep(0.64)), 15)
    0.00024
    """

    # a of the contact, R and mu
    half_width: float
    radius: float
    friction: float

    def __post_init__(self) -> None:
        refuse(
            positive_faults(half_width=self.half_width, radius=self.radius, friction=self.friction)
        )

    @property
    def full_creep(self) -> float:
        """Creep from which on nothing sticks, mu a/R."""
        return self.friction * self.half_width / self.radius

    def stick_share(self, creep: ArrayLike) -> Array:
        """Return c/a, the part of the contact that sticks."""
        return np.asarray(np.maximum(1 - np.abs(creep) / self.full_creep, 0.0))

    def traction(self, creep: ArrayLike) -> Array:
        """Return Q/(mu P), of the sign of the creep."""
        away = np.minimum(np.abs(creep) / self.full_creep, 1.0)
        return np.asarray(np.sign(creep) * away * (2 - away))

    def creep(self, traction: ArrayLike) -> Array:
        """Return the creep for Q/(mu P) in [-1, 1], the smallest one where it is 1."""
        size = np.abs(traction)
        if not (size <= 1).all():
            raise ValueError(f"traction must lie in [-1, 1], not {traction!r}")
        return np.asarray(np.sign(traction) * self.full_creep * size / (1 + np.sqrt(1 - size)))

    def shear(self, x: ArrayLike, creep: float) -> Array:
        """Return q/(mu p0) at places along the contact; material enters at x = a."""
        x = np.asarray(x) / self.half_width
        stick = float(self.stick_share(creep))
        sliding = np.sqrt(np.maximum(1 - x**2, 0.0))
        strip = np.maximum(stick**2 - (x - 1 + stick) ** 2, 0.0)
        return np.asarray(np.sign(creep) * (sliding - np.sqrt(strip)))


class RubberCylinder:
    """A rigid cylinder that rolls without friction on a standard solid, nu = 1/2.

    S. C. Hunter, J. Appl. Mech. 28 (1961) 611. In the frame of the contact, which moves along +x,
    the surface has passed x + v t a time t ago. With the creep compliance of shear
    J(t) = J0 + J1 (1 - exp(-t/lambda)), l = v lambda, and K p' = -(2/pi) int p(s)/(x - s) ds,

        (1 - l D) u' = K' q,    4 q = (J0 + J1) p - J0 l p'.

    Under the cylinder u' = -x/R. With x = c + h t from the middle c of the contact, whose
    half-width is h, and no traction at t = 1 and t = -1,

        q = [h (1/2 - t^2) - (c - l) t + C]/(2 R sqrt(1 - t^2)).

    Three conditions remain. The slope is continuous at the leading edge, which is a condition since
    the operator 1 - l D has a solution of its own, exp(x/l); the pressure that starts from zero
    there is zero again at the trailing edge; and the force per length is F. With Bessel functions
    of m = h/l and k = m (J0 + J1)/J0, and rho = I1(k)/I0(k),

        c = l J1/(J0 + J1) rho K0(m)/(K1(m) + rho K0(m)),
        C = h/2 + c K1(m)/K0(m),
        F = 2 pi h C/(R (J0 + J1)).

    The resistance is the moment of the pressure about the axis: M/(F R) = F_x/F, as rolling without
    friction and sliding without friction are the same problem. Kelvin and Voigt's solid is J0 = 0,
    k infinite and rho = 1.

    Parameters
    ----------
    half_width, radius : float
        h of the contact and R of the cylinder.
    way : float
        l, the way rolled in the retardation time.
    modulus : float
        G at rest, 1/(J0 + J1).
    glassy : float
        Instantaneous modulus over that at rest, 1 + J1/J0; inf for Kelvin and Voigt's solid.

    Attributes
    ----------
    middle : float
        c, ahead of the axis.
    force : float
        Per length.
    resistance : float
        M/(F R).

    Examples
    --------
    At rest, and at speeds beyond any retardation, Hertz: F = pi E* h^2/(4 R), E* = 4 G.

    >>> slow = RubberCylinder(1.0, 100.0, 1e-6, 0.25, 11.0)
    >>> fast = RubberCylinder(1.0, 100.0, 1e9, 0.25, 11.0)
    >>> round(slow.force / (np.pi / 400), 5), round(fast.force / (11 * np.pi / 400), 5)
    (1.0, 1.0)

    Slowly, the friction is that of the viscosity, G tau_r v/R with l = v lambda:

    >>> round(RubberCylinder(1.0, 100.0, 1e-4, 0.25, np.inf).resistance / 1e-6, 3)
    1.0
    """

    def __init__(
        self, half_width: float, radius: float, way: float, modulus: float, glassy: float
    ) -> None:
        faults = positive_faults(half_width=half_width, radius=radius, way=way, modulus=modulus)
        if not glassy > 1:
            faults.append(f"glassy must be above 1, not {glassy!r}")
        refuse(faults)
        h, m = half_width, half_width / way
        bessel, k = float(kve(0, m) / kve(1, m)), m * glassy
        rho = 1.0 if np.isinf(k) else float(ive(1, k) / ive(0, k))
        share = rho * bessel
        self.middle = way * (1 - 1 / glassy) * share / (1 + share)
        constant = h / 2 + self.middle / bessel
        self.force = 2 * np.pi * modulus * h * constant / radius
        # first moments about the middle of 4 q = (J0 + J1) p - J0 l p'
        about = (way - self.middle) / (2 * constant) - way / (glassy * h)
        self.resistance = float((self.middle + h * about) / radius)
