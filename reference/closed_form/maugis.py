"""Adhesion of any range on a paraboloid: a constant tension up to a fixed gap.

D. Maugis, J. Colloid Interface Sci. 150 (1992) 243: the tension sigma0 acts where the gap is below
w/sigma0. The only parameter is lambda = 2 sigma0 (R/(pi w K^2))^(1/3) with K = 4 E*/3: for large
lambda the contact is that of Johnson, Kendall & Roberts, for small lambda that of Derjaguin, Muller
& Toporov (pull-off at -2 pi w R).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq, minimize_scalar

from reference.closed_form.form import Array, require_positive


def maugis_parameter(
    radius: float, effective_modulus: float, work: float, strength: float
) -> float:
    """Return lambda = 2 sigma0 (R/(pi w K^2))^(1/3), K = 4 E*/3.

    >>> round(maugis_parameter(1.0, 0.75, 1 / math.pi, 0.5), 12)
    1.0
    """
    stiffness = 4 / 3 * effective_modulus
    return 2 * strength * float(np.cbrt(radius / (math.pi * work * stiffness**2)))


def strength_of(radius: float, effective_modulus: float, work: float, parameter: float) -> float:
    """Return the tension sigma0 for a Maugis parameter."""
    return parameter / maugis_parameter(radius, effective_modulus, work, 1.0)


@dataclass(frozen=True)
class MaugisForm:
    """Equilibria of a paraboloid by contact radius a >= 0 (a = 0: attraction across the gap only).

    In Maugis' units, a in (pi w R^2/K)^(1/3), F in pi w R, d in (pi^2 w^2 R/K^2)^(1/3), with
    m = c/a for the edge of the tension, s = sqrt(m^2 - 1), q = arctan s:

        (lambda a^2/2) [s + (m^2 - 2) q] + (4 lambda^2 a/3) [s q - m + 1] = 1,
        F = a^3 - lambda a^2 [s + m^2 q],   d = a^2 - (4/3) lambda a s.

    Attributes
    ----------
    radius, effective_modulus, work, strength : float
        R, E*, w and sigma0.
    """

    radius: float
    effective_modulus: float
    work: float
    strength: float

    def __post_init__(self) -> None:
        require_positive("maugis", **vars(self))

    @property
    def parameter(self) -> float:
        """Maugis' lambda."""
        return maugis_parameter(self.radius, self.effective_modulus, self.work, self.strength)

    def units(self) -> tuple[float, float, float]:
        """Units of contact radius, force and penetration."""
        R, w, K = self.radius, self.work, 4 / 3 * self.effective_modulus
        length = float(np.cbrt(math.pi * w / K * R * R))
        return length, math.pi * w * R, length / R * length

    def tension_radius(self, contact_radius: ArrayLike) -> Array:
        """Return c(a), the radius up to which the tension acts."""
        unit = self.units()[0]
        a = np.asarray(contact_radius, dtype=float) / unit
        if not (a >= 0).all():
            raise ValueError(f"contact radius must not be negative, not {contact_radius!r}")
        return unit * np.vectorize(self._scaled_edge, otypes=[float])(a)

    def force(self, contact_radius: ArrayLike) -> Array:
        """Return F(a)."""
        length, unit, _ = self.units()
        a = np.asarray(contact_radius, dtype=float) / length
        c, s, q = self._angles(a, contact_radius)
        return unit * (a**3 - self.parameter * (a * s + c * c * q))

    def penetration(self, contact_radius: ArrayLike) -> Array:
        """Return d(a)."""
        length, _, unit = self.units()
        a = np.asarray(contact_radius, dtype=float) / length
        _, s, _ = self._angles(a, contact_radius)
        return unit * (a**2 - 4 / 3 * self.parameter * s)

    def pull_off(self, control: str = "force") -> float:
        """Return the contact radius at minimum force or penetration, 0 if there is no fold."""
        law = {"force": self.force, "penetration": self.penetration}[control]
        length = self.units()[0]
        radii = length * np.linspace(0.0, 2.5, 251)
        lowest = int(np.argmin(law(radii)))
        if lowest == 0:
            return 0.0
        around = radii[lowest - 1], radii[lowest + 1]
        options = {"xatol": 1e-9 * length}
        return float(minimize_scalar(law, bounds=around, method="bounded", options=options).x)

    def _angles(self, a: Array, contact_radius: ArrayLike) -> tuple[Array, Array, Array]:
        """Return c, sqrt(c^2 - a^2) and arctan(sqrt(c^2 - a^2)/a) in Maugis' units."""
        c = self.tension_radius(contact_radius) / self.units()[0]
        s = np.sqrt(np.maximum(c - a, 0.0) * (c + a))
        return c, s, np.arctan2(s, a)

    def _scaled_edge(self, a: float) -> float:
        """Solve Maugis' condition for c = m a; it increases with c from 0 at c = a."""
        strength = self.parameter

        def excess(c: float) -> float:
            s = math.sqrt((c - a) * (c + a))
            q = math.atan2(s, a)
            near = 0.5 * strength * (a * s + (c * c - 2 * a * a) * q)
            return near + 4 / 3 * strength**2 * (s * q - c + a) - 1

        high = max(2 * a, 1.0)
        while excess(high) < 0:
            high *= 2
        return float(brentq(excess, a, high, xtol=1e-300, rtol=8.9e-16))
