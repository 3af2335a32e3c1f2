r"""The half-space whose modulus is a power of the depth, E = E0 (z/c0)^k, -1 < k < 1.

A point force F displaces the surface by

    u = F cos(pi k/2) c0^k/(pi c_N r^(1+k)),    c_N = h(k, nu) E0/(1 - nu^2)

(Booker, Balaam & Davis, Int. J. Numer. Anal. Meth. Geomech. 9 (1985) 353; Giannakopoulos & Suresh,
Int. J. Solids Struct. 34 (1997) 2357; in this form Hess, Int. J. Eng. Sci. 104 (2016) 20), so that
a wave of pressure gives C(q) ~ q^(k-1). c_N |x/c0|^k is the stiffness per length of springs that
give the same force, penetration and radius of every round contact, under the line g(x) = x^(1-k)
int_0^x f'(r) (x^2 - r^2)^((k-1)/2) dr. For k >= 1 the integral of u over a loaded area diverges:
such a body has no compliance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import beta, gamma

from reference.arguments import choice_faults, positive_faults, refuse
from reference.elasticity import Material
from reference.layered.round_contact import RoundStep

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Graded:
    """A half-space that grows stiffer (k > 0) or softer (k < 0) with depth.

    Parameters
    ----------
    material : Material
        Modulus E0 at the depth c0, and Poisson's ratio everywhere.
    exponent, depth : float
        k and c0.

    Examples
    --------
    k = 0 is a half-space, 2/(E* q):

    >>> float(np.round(Graded(Material(1.0, 0.5), 0.0, 1.0).compliance(2.0), 12))
    0.75
    """

    material: Material
    exponent: float
    depth: float

    def __post_init__(self) -> None:
        faults = positive_faults(depth=self.depth)
        if not -1 < self.exponent < 1:
            faults.append(f"exponent must lie between -1 and 1, not {self.exponent!r}")
        refuse(faults)

    @property
    def top(self) -> Material:
        """The material at the depth c0; at the surface there is none."""
        return self.material

    @property
    def spring_modulus(self) -> float:
        """c_N: stiffness of the equivalent springs per length at x = c0."""
        nu = self.material.poisson_ratio
        return stiffening(self.exponent, nu) * self.material.youngs_modulus / (1 - nu**2)

    @property
    def point_factor(self) -> float:
        """Displacement times r^(1+k) of a point force, over the force."""
        k = self.exponent
        return float(np.cos(np.pi * k / 2) * self.depth**k / (np.pi * self.spring_modulus))

    def compliance(self, wavenumber: ArrayLike) -> Array:
        """Return the displacement of the surface per pressure, for waves; infinite at q = 0."""
        k = self.exponent
        factor = 2 * np.pi * self.point_factor * 2**-k * gamma((1 - k) / 2) / gamma((1 + k) / 2)
        with np.errstate(divide="ignore"):
            return factor * np.asarray(wavenumber, dtype=float) ** (k - 1)

    def modulus(self, wavenumber: ArrayLike) -> Array:
        """2/(q C): the effective modulus of the half-space that gives way as much to this wave."""
        q = np.asarray(wavenumber, dtype=float)
        return 2 / (q * self.compliance(q))

    def slices(self, ends: Array) -> list[Material]:
        """Return the materials of slices between increasing depths, from zero on.

        E of the geometric mean of their ends; of the uppermost, up to the surface where E is zero
        or infinite, by the mean of 1/E.
        """
        k, nu = self.exponent, self.material.poisson_ratio
        ratios = np.append((1 - k) * ends[1] ** k, (ends[1:-1] * ends[2:]) ** (k / 2))
        moduli = self.material.youngs_modulus * ratios / self.depth**k
        return [Material(float(E), nu) for E in moduli]


def stiffening(exponent: float, poisson_ratio: float) -> float:
    """h(k, nu), one for k = 0 (Hess 2016, eq. 9 with (5)).

    >>> round(stiffening(0.0, 0.3), 12)
    1.0
    """
    k, nu = exponent, poisson_ratio
    root = np.sqrt((1 + k) * (1 - k * nu / (1 - nu)))
    C = 2 ** (1 + k) * gamma((3 + k + root) / 2) * gamma((3 + k - root) / 2)
    C /= np.pi * gamma(2 + k)
    upper = 2 * (1 + k) * np.cos(np.pi * k / 2) * gamma(1 + k / 2)
    lower = np.sqrt(np.pi) * C * root * np.sin(np.pi * root / 2) * gamma((1 + k) / 2)
    return float(upper / lower)


def line_factor(exponent: float, grading: float = 0.0) -> float:
    """G over f for a section f ~ r^n: (n/2) B(n/2, (1 + k)/2), two for a paraboloid and k = 0.

    >>> round(line_factor(2.0), 12)
    2.0
    """
    return float(exponent / 2 * beta(exponent / 2, (1 + grading) / 2))


def face_stiffness(body: Graded, radius: float) -> float:
    """F/d of a flat circular face: 2 c_N a^(1+k)/((1 + k) c0^k)."""
    k = body.exponent
    return float(2 * body.spring_modulus * radius * (radius / body.depth) ** k / (1 + k))


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
        refuse(choice_faults("control", control, ("penetration", "force")))
        power = self.exponent + (self.body.exponent + 1 if control == "force" else 0)
        unit = self.at_radius(1.0)
        return self.at_radius(float((value / getattr(unit, control)) ** (1 / power)))
