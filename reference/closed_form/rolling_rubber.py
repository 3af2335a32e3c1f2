"""Rolling of a rigid cylinder without friction on a standard solid (Hunter 1961).

S. C. Hunter, J. Appl. Mech. 28 (1961) 611. Plane strain, nu = 1/2; in the frame of the contact,
which moves along +x, the surface has passed x + v t a time t ago. With the creep compliance of
shear J(t) = J0 + J1 (1 - exp(-t/lambda)), l = v lambda, and K p' = -(2/pi) int p(s)/(x - s) ds,

    (1 - l D) u' = K' q,    4 q = (J0 + J1) p - J0 l p'.

Under the cylinder u' = -x/R. With x = c + h t from the middle c of the contact, whose half-width
is h, and no traction at t = 1 and t = -1,

    q = [h (1/2 - t^2) - (c - l) t + C]/(2 R sqrt(1 - t^2)).

Three conditions remain. The slope is continuous at the leading edge, which is a condition since
the operator 1 - l D has a solution of its own, exp(x/l); the pressure that starts from zero there
is zero again at the trailing edge; and the force per length is F. With Bessel functions of
m = h/l and k = m (J0 + J1)/J0, and rho = I1(k)/I0(k),

    c = l J1/(J0 + J1) rho K0(m)/(K1(m) + rho K0(m)),
    C = h/2 + c K1(m)/K0(m),
    F = 2 pi h C/(R (J0 + J1)).

The resistance is the moment of the pressure about the axis: M/(F R) = F_x/F, as rolling without
friction and sliding without friction are the same problem. Kelvin and Voigt's solid is J0 = 0,
k infinite and rho = 1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import ive, kve

from reference.arguments import positive_faults, refuse


@dataclass(frozen=True)
class RubberCylinder:
    """A cylinder that rolls on a standard solid, by the half-width of its contact.

    Attributes
    ----------
    half_width : float
        h.
    radius : float
        R of the cylinder.
    way : float
        l, the way rolled in the retardation time.
    modulus : float
        G at rest, 1/(J0 + J1).
    glassy : float
        Instantaneous modulus over that at rest, 1 + J1/J0; inf for Kelvin and Voigt's solid.

    Raises
    ------
    ValueError
        Lists all arguments that are not positive, and a `glassy` of one or less.

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

    half_width: float
    radius: float
    way: float
    modulus: float
    glassy: float

    def __post_init__(self) -> None:
        faults = positive_faults(
            half_width=self.half_width, radius=self.radius, way=self.way, modulus=self.modulus
        )
        if not self.glassy > 1:
            faults.append(f"glassy must be above 1, not {self.glassy!r}")
        refuse(faults)

    @property
    def delayed(self) -> float:
        """J1/(J0 + J1), the part of the compliance that comes with time."""
        return 1 - 1 / self.glassy

    @property
    def middle(self) -> float:
        """The middle c of the contact, ahead of the axis."""
        share = self._quotient * self._bessel
        return self.way * self.delayed * share / (1 + share)

    @property
    def _bessel(self) -> float:
        """K0(m)/K1(m)."""
        m = self.half_width / self.way
        return float(kve(0, m) / kve(1, m))

    @property
    def _quotient(self) -> float:
        """Rho = I1(k)/I0(k)."""
        k = self.half_width / self.way * self.glassy
        return 1.0 if np.isinf(k) else float(ive(1, k) / ive(0, k))

    @property
    def _constant(self) -> float:
        return self.half_width / 2 + self.middle / self._bessel

    @property
    def force(self) -> float:
        """F per length."""
        return 2 * np.pi * self.modulus * self.half_width * self._constant / self.radius

    @property
    def resistance(self) -> float:
        """M/(F R): the moment about the axis that rolling needs, over force and radius."""
        h, c = self.half_width, self.middle
        # first moments about the middle of 4 q = (J0 + J1) p - J0 l p'
        about = (self.way - c) / (2 * self._constant) - self.way / (self.glassy * h)
        return float((c + h * about) / self.radius)
