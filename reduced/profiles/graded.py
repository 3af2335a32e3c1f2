r"""Springs for a half-space whose modulus is a power of the depth, E = E0 (z/c0)^k.

Springs of stiffness c_N |x/c0|^k dx under the profile

    g(x) = x^(1-k) int_0^x f'(r) (x^2 - r^2)^((k-1)/2) dr = x int_0^(pi/2) f'(x sin t) cos(t)^k dt

have the force, penetration and contact radius of every round body on it (Hess, Int. J. Eng. Sci.
104 (2016) 20; Popov, Hess & Willert 2019, ch. 9). In the coordinate

    s = x |x/c0|^k/(1 + k)

these springs are all alike, c_N ds: the row of springs of a half-space, under g(x(s)).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import gamma

from reduced.arguments import poisson_faults, positive_faults, refuse
from reduced.profiles.section import Profile, Section
from reduced.profiles.transform import weighted


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
