"""Springs for bodies that depend on depth: coatings, and a modulus that is a power of the depth.

**Coatings.** For the effective modulus under a contact of radius a Xu & Pharr (Scripta Mater. 55
(2006) 315) mix compliances with the weight that Gao, Chiu & Lee (Int. J. Solids Struct. 29 (1992)
2471) found for a flat punch and nearly equal moduli,

    1/E = I(t/a)/E_coating + (1 - I(t/a))/E_substrate,
    I(s) = (2/pi) arctan s + [(1 - 2 nu) s ln(1 + 1/s^2) - s/(1 + s^2)]/(2 pi (1 - nu)).

Several coatings have the differences of their weights; a rigid base has no compliance.

**Grading**, E = E0 (z/c0)^k. Springs of stiffness c_N |x/c0|^k dx under the profile

    g(x) = x^(1-k) int_0^x f'(r) (x^2 - r^2)^((k-1)/2) dr = x int_0^(pi/2) f'(x sin t) cos(t)^k dt

have the force, penetration and contact radius of every round body on it (Hess, Int. J. Eng. Sci.
104 (2016) 20; Popov, Hess & Willert 2019, ch. 9). In the coordinate

    s = x |x/c0|^k/(1 + k)

these springs are all alike, c_N ds: the row of springs of a half-space, under g(x(s)).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import gamma

from reduced.errors import poisson_faults, positive_faults, refuse
from reduced.profiles.section import Profile, Section
from reduced.profiles.transform import weighted


@dataclass(frozen=True)
class Coatings:
    """Layers from the surface down, on a half-space: E* of each and of the base (inf: rigid).

    Poisson's ratio is that of the uppermost layer.

    >>> coated = Coatings([1.0], [4.0], 1.0, 0.3)
    >>> np.round(coated.modulus(np.array([1e-6, 1e6])), 4)
    array([4., 1.])
    """

    thicknesses: Sequence[float]
    moduli: Sequence[float]
    base: float
    poisson_ratio: float

    def __post_init__(self) -> None:
        wrong = poisson_faults(self.poisson_ratio)
        if len(self.thicknesses) != len(self.moduli):
            wrong.append("thicknesses and moduli must be as many")
        for name, values in (("thicknesses", self.thicknesses), ("moduli", self.moduli)):
            for index, value in enumerate(values):
                wrong += positive_faults(**{f"{name}[{index}]": value})
        if not self.base > 0:
            wrong.append(f"base must be positive, got {self.base!r}")
        refuse(wrong)

    def modulus(self, contact_radius: np.ndarray) -> np.ndarray:
        """Return the effective modulus of contacts of these radii."""
        s, nu = np.cumsum(self.thicknesses)[:, None] / contact_radius, self.poisson_ratio
        more = (1 - 2 * nu) * s * np.log1p(s**-2) - s / (1 + s**2)
        below = 2 / np.pi * np.arctan(s) + more / (2 * np.pi * (1 - nu))
        weights = np.vstack([np.zeros(contact_radius.size), below])
        shares = np.diff(weights, axis=0) / np.array(self.moduli)[:, None]
        return np.asarray(1 / (shares.sum(axis=0) + (1 - weights[-1]) / self.base))


@dataclass(frozen=True)
class Grading:
    """E = E0 (z/c0)^k of a half-space, -1 < k < 1; `modulus` is E0/(1 - nu^2), `depth` c0.

    >>> round(Grading(1.0, 0.3, 0.0, 1.0).spring_modulus, 12)
    1.0
    """

    modulus: float
    poisson_ratio: float
    exponent: float
    depth: float

    def __post_init__(self) -> None:
        wrong = positive_faults(modulus=self.modulus, depth=self.depth)
        wrong += poisson_faults(self.poisson_ratio)
        if not -1 < self.exponent < 1:
            wrong.append(f"exponent must be in (-1, 1), got {self.exponent!r}")
        refuse(wrong)

    @property
    def spring_modulus(self) -> float:
        """c_N, from the displacement by a point force (Hess 2016, eq. 9)."""
        k, nu = self.exponent, self.poisson_ratio
        root = np.sqrt((1 + k) * (1 - k * nu / (1 - nu)))
        gammas = gamma((3 + k + root) / 2) * gamma((3 + k - root) / 2) / gamma(2 + k)
        upper = np.sqrt(np.pi) * (1 + k) * np.cos(np.pi * k / 2) * gamma(1 + k / 2)
        lower = 2**k * gammas * root * np.sin(np.pi * root / 2) * gamma((1 + k) / 2)
        return float(self.modulus * upper / lower)

    def even(self, x: np.ndarray) -> np.ndarray:
        """Return the coordinate in which springs are alike."""
        return x * (x / self.depth) ** self.exponent / (1 + self.exponent)

    def place(self, even: np.ndarray) -> np.ndarray:
        """Return x from the coordinate in which springs are alike."""
        k = self.exponent
        return self.depth * ((1 + k) * (np.asarray(even) / self.depth)) ** (1 / (1 + k))

    def profile(self, section: Section) -> Profile:
        """Return g of a body of cross-section f(r) over the coordinate of alike springs."""
        curve = weighted(section, self.exponent)

        def slope(even: np.ndarray) -> np.ndarray:
            x = self.place(np.where(np.asarray(even) > 0, even, 1.0))
            steep = curve.slope(x) * (self.depth / x) ** self.exponent
            return np.where(np.asarray(even) > 0, steep, 0.0)

        return Profile(
            section.name,
            height=lambda even: curve.height(self.place(even)),
            slope=slope,
            curvature=None,
            # inside the edge, where a sphere is infinitely steep
            length=float(self.even(np.array(min(section.length, section.edge / 2)))),
            breakpoints=tuple(float(self.even(np.array(b))) for b in curve.breakpoints),
            edge=float(self.even(np.array(section.edge))) if section.edge < np.inf else np.inf,
            section=section,
        )
