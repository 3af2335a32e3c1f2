r"""Films in closed form, and Hamrock & Dowson's fit.

Speeds U are means of both surfaces' (entrainment), radii those of one body on a plane.

**Rigid cylinder**, per length, with Reynolds' condition at the rupture, p = dp/dx = 0
(Reynolds 1886; Martin 1916): W = 4.895 eta U R/h0, ruptured from x = 0.4751 sqrt(2 R h0) on.

**Rigid sphere**, entrained: div(h^3 grad p) = 12 eta U dh/dx has the solution
p = -(12/5) eta U x/h^2 without cavitation (Kapitza 1955); its positive half (half-Sommerfeld)
carries W = (24/5) (pi/sqrt 2) eta U R^(3/2)/h0^(1/2) = 10.66 eta U R^(3/2)/h0^(1/2).

**Rigid sphere**, squeezed: W = 6 pi eta R^2 V/h0 (Taylor).

**Soft** (isoviscous) point contact, Hamrock & Dowson (J. Lubr. Technol. 100 (1978) 236), round:

    h_c/R = 3.34 (eta U/(E' R))^0.64 (W/(E' R^2))^-0.22,
    h_min/R = 2.80 (eta U/(E' R))^0.65 (W/(E' R^2))^-0.21,    E' = 2 E*,

a fit to computed films at speeds 5e-9 to 5e-8 and loads 2e-4 to 2e-3 in these units.

**Softer and slower**: the film is made where Hertz's pressure begins, p = A sqrt(x), as below a
long cylinder, and carried through (Snoeijer, Eggers & Venner, Phys. Fluids 25 (2013) 101705):

    h_c = 0.5122 (12 eta U)^(3/5) E*^(1/5) A^(-4/5),    A = 2 sqrt(2 a) E*/(pi R),

so that h_c/R goes as 3.55 (eta U/(E' R))^0.6 (W/(E' R^2))^-0.133.
"""

from dataclasses import dataclass

import numpy as np

from reference.errors import positive_faults, refuse

CYLINDER = 4.894968493913368
HALF_SOMMERFELD = 24 / 5 * np.pi / np.sqrt(2)
# Of the film behind the inlet of a contact that is large beside it; to 1e-4, by the tests.
INLET = 0.5122
# Speeds and loads that the fit was made for.
SPEEDS, LOADS = (5e-9, 5e-8), (2e-4, 2e-3)
# A ball is a paraboloid over this many lengths of the contact.
SMALLEST = 3.0


@dataclass(frozen=True)
class SoftFit:
    """Hamrock & Dowson's film of a soft ball.

    >>> ball = SoftFit(radius=0.01, effective_modulus=1e6, viscosity=1.0, load=0.2)
    >>> round(1e6 * ball.central(1e-4), 1), ball.covers(1e-4)
    (0.7, True)
    """

    radius: float
    effective_modulus: float
    viscosity: float
    load: float

    def __post_init__(self) -> None:
        refuse(positive_faults(**vars(self)))

    def central(self, speed: float) -> float:
        """Return the film in the middle."""
        return 3.34 * self.radius * self._speed(speed) ** 0.64 * self._load**-0.22

    def minimum(self, speed: float) -> float:
        """Return the thinnest film."""
        return 2.80 * self.radius * self._speed(speed) ** 0.65 * self._load**-0.21

    def covers(self, speed: float) -> bool:
        """Whether the fit was made for such a speed and load."""
        (slow, fast), (light, heavy) = SPEEDS, LOADS
        return slow <= self._speed(speed) <= fast and light <= self._load <= heavy

    def _speed(self, speed: float) -> float:
        return self.viscosity * speed / (2 * self.effective_modulus * self.radius)

    @property
    def _load(self) -> float:
        return self.load / (2 * self.effective_modulus * self.radius**2)


def hertz_radius(radius: float, effective_modulus: float, load: float) -> float:
    """Return the radius of the dry contact."""
    return float(np.cbrt(0.75 * load * radius / effective_modulus))


def contact_length(
    radius: float, effective_modulus: float, load: float, rigid_film: float
) -> float:
    """Return l = a + sqrt(2 R h0), within which a film carries its load; refuse smaller balls."""
    length = hertz_radius(radius, effective_modulus, load) + np.sqrt(2 * radius * rigid_film)
    if length * SMALLEST > radius:
        raise ValueError(
            f"the film or the contact reaches {length:.3g} around the middle: no ball of radius "
            f"{radius:.3g} is a paraboloid there"
        )
    return float(length)


def sphere_film(radius: float, viscosity: float, speed: float, load: float) -> float:
    """Return h0 of an entrained rigid sphere by the half-Sommerfeld condition."""
    return (HALF_SOMMERFELD * viscosity * speed * radius**1.5 / load) ** 2


def soft_limit(
    radius: float, effective_modulus: float, viscosity: float, speed: float, load: float
) -> float:
    """Return the central film of a ball so soft that its inlet is small beside the contact."""
    contact = hertz_radius(radius, effective_modulus, load)
    rise = 2 * np.sqrt(2 * contact) * effective_modulus / (np.pi * radius)
    return float(INLET * (12 * viscosity * speed) ** 0.6 * effective_modulus**0.2 * rise**-0.8)


def wave_amplitude(
    number: float, effective_modulus: float, viscosity: float, speed: float, film: float
) -> complex:
    """Return what a film leaves of a small wave at rest across the flow, over its amplitude.

    Linear, where the film is even and the pressure's slope small (the middle of a soft contact):
    i q h^3 dp = 12 eta U dh with dh = A + 2 dp/(E* q), of e^(iqx).
    """
    return 1 / (1 + 24j * viscosity * speed / (effective_modulus * number**2 * film**3))


def squeezed_film(radius: float, viscosity: float, speed: float, load: float) -> float:
    """Return h0 of a rigid sphere that approaches a plane at a speed under a load."""
    return 6 * np.pi * viscosity * radius**2 * speed / load
