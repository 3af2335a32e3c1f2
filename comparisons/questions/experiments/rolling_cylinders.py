"""Cylinders that roll in plane strain: with friction and creep (Carter), on rubber (Hunter).

And the plane below them, on cells of the half-space or finite elements: loads per length of the
roller. A line force displaces the surface by a logarithm (Flamant; Johnson 1985, eqs. (2.19),
(2.29)), whose datum has no meaning and drops out of every difference:

    u_x = -Q c1/pi ln|x|,   c1 = (1 - nu)/G;    antiplane: u_y = -Q_y/(pi G) ln|x|.

Finite elements of plane strain take its place in `PlaneElements`, at rest or, with inertia, flowing
through their mesh at a speed V. For the continuum that is a factor of the compliance,

    alpha_s (1 - alpha_s^2)/(4 alpha_d alpha_s - (1 + alpha_s^2)^2) / (1 - nu),
    alpha^2 = 1 - V^2/c^2 of shear and of pressure waves

(L. B. Freund, Dynamic Fracture Mechanics, 1990, sec. 4.3): `moving_compliance`.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy import fft
from scipy.special import ive, kve

from reference.arrays import Array
from reference.elasticity import Material
from reference.errors import count_faults, positive_faults, refuse
from reference.fem.grid_body import beyond_cells
from reference.halfspace.traction import Compliance


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


# Cells of a period over those of the grid, and at least: elements differ from the half-space within
# some cells only, but with inertia everywhere.
_APART, _APART_MOVING, _LEAST = 1, 16, 64


@dataclass(frozen=True)
class PlaneSurface:
    """The plane half-space under uniform tractions on cells, a grid of shape (cells, 1)."""

    cells: int
    width: float  # of a cell along x
    compliance: Compliance

    def __post_init__(self) -> None:
        refuse(count_faults(1, cells=self.cells) + positive_faults(width=self.width))

    @property
    def spacing(self) -> tuple[float, float]:
        """Cell sides; the second is a unit of length of the roller."""
        return (self.width, 1.0)

    def shear_coefficients(self) -> Array:
        """Return the displacement at all offsets (`reference.rolling.roll.TangentialSurface`)."""
        offsets = np.minimum(np.arange(2 * self.cells), 2 * self.cells - np.arange(2 * self.cells))
        x = (offsets + 0.5) * self.width, (offsets - 0.5) * self.width
        # the integral of ln|x| over the cell
        logarithm = x[0] * np.log(x[0]) - x[1] * np.log(np.abs(x[1])) - self.width
        c1, c2 = self.compliance.normal, self.compliance.lateral
        table = np.zeros((3, offsets.size, 1))
        table[0, :, 0], table[1, :, 0] = (-c1 / np.pi * logarithm, -(c1 + c2) / np.pi * logarithm)
        return table


@dataclass(frozen=True)
class PlaneElements(PlaneSurface):
    """Finite elements of plane strain below the same cells: splines across the depth."""

    poisson_ratio: float  # of the material of `compliance`
    inertia: float = 0.0  # rho V^2/G

    def shear_coefficients(self) -> Array:
        """Return the displacement at all offsets (`reference.rolling.roll.TangentialSurface`)."""
        nu = self.poisson_ratio
        material = Material(2 * (1 + nu) * (1 - nu) / self.compliance.normal, nu)
        apart = _APART_MOVING if self.inertia else _APART
        period = 2 * fft.next_fast_len(max(apart * self.cells, _LEAST), real=True), 1
        more = beyond_cells(
            period, (self.width,) * 2, material, element="splines", inertia=self.inertia
        )
        table = super().shear_coefficients()
        places = np.minimum(np.arange(2 * self.cells), 2 * self.cells - np.arange(2 * self.cells))
        table[0, :, 0] += more.xx[places, 0]
        table[1, :, 0] += more.yy[places, 0]
        return table


def moving_compliance(poisson_ratio: float, inertia: float) -> float:
    """Return the compliance of tangential loads that move, over that at rest; rho V^2/G < 0.76.

    Rayleigh's function 4 p s - (1 + s^2)^2 with s^2 = 1 - I, p^2 = 1 - k I vanishes with I = rho
    V^2/G: it is divided by I before its two terms could cancel.

    >>> round(moving_compliance(0.25, 0.0), 12), moving_compliance(0.25, 0.3) > 1.1
    (1.0, True)
    """
    k = (1 - 2 * poisson_ratio) / (2 * (1 - poisson_ratio))
    shear, pressure = np.sqrt(1 - inertia), np.sqrt(1 - k * inertia)
    over_inertia = 16 * (1 - k) - (24 - 16 * k) * inertia + 8 * inertia**2 - inertia**3
    rayleigh = over_inertia / (4 * pressure * shear + (2 - inertia) ** 2)
    return float(shear / rayleigh / (1 - poisson_ratio))


def hertz(x: ArrayLike, half_width: float, force: float) -> Array:
    """Return the pressure of a cylinder, 2 F/(pi a) sqrt(1 - x^2/a^2), F per length.

    >>> round(float(hertz(0.0, 1.0, np.pi)), 12)
    2.0
    """
    share = np.maximum(1 - (np.asarray(x) / half_width) ** 2, 0.0)
    pressure: Array = 2 * force / (np.pi * half_width) * np.sqrt(share)
    return pressure
