"""Asperities that do not know of each other, on the summits of a Gaussian surface.

With the moments m0 = <h^2>, m2 = <(dh/dx)^2> and m4 = <(d2h/dx2)^2> of an isotropic surface, the
joint density of height and curvatures of its summits is known (Longuet-Higgins 1957; Nayak 1971).
A. W. Bush, R. D. Gibson and T. R. Thomas (Wear 35 (1975) 87) put Hertz's elliptic contact on each
of them; J. A. Greenwood and J. B. P. Williamson (Proc. R. Soc. A 295 (1966) 300) a round one of the
mean radius, with normal heights.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.special import gamma, pbdv

from reference.arguments import positive_faults, refuse
from reference.closed_form.elliptic import ellipsoid
from reference.closed_form.random_field import surface_peaks
from reference.closed_form.rough import GreenwoodWilliamson

Array = NDArray[np.float64]
_SUMS, _ANGLES, _LARGEST = 64, 24, 20.0


@dataclass(frozen=True)
class Moments:
    """Moments of the spectrum of an isotropic surface: m0, m2, m4.

    Raises
    ------
    ValueError
        For moments that no surface has: m0 m4 < (3/2) m2^2.
    """

    height: float
    slope: float
    curvature: float

    def __post_init__(self) -> None:
        named = {"m0": self.height, "m2": self.slope, "m4": self.curvature}
        wrong = positive_faults(**named)
        if not wrong and self.height * self.curvature < 1.5 * self.slope**2 * (1 - 1e-12):
            wrong.append(f"m0 m4/m2^2 must be 1.5 at least, got {self.breadth:.6g}")
        refuse(wrong)

    @property
    def breadth(self) -> float:
        """Nayak's parameter m0 m4/m2^2."""
        return self.height * self.curvature / self.slope**2

    @property
    def lean(self) -> float:
        """Mean height of summits over the sum of their curvatures: (3/4) m2/m4."""
        return 0.75 * self.slope / self.curvature

    @property
    def spread(self) -> float:
        """Standard deviation of the height of summits of given curvatures."""
        return math.sqrt(max(self.height - 1.5 * self.slope**2 / self.curvature, 0.0))


@dataclass(frozen=True)
class BushGibsonThomas:
    """Elliptic asperities with the heights and curvatures of the summits of a surface; E* = 1.

    Attributes
    ----------
    moments : Moments
    """

    moments: Moments

    @cached_property
    def _summits(self) -> tuple[Array, Array, Array, Array]:
        """Return weights, mean heights, radii and shapes of the classes of summits.

        (sums, angles): the sum of the curvatures is s, their difference s sin(angle).
        """
        weight, total, angle = _classes()
        root = math.sqrt(self.moments.curvature)
        radius = 2 / (root * total * np.cos(angle))
        height = self.moments.lean * root * total * np.ones_like(angle)
        return weight, height, radius, angle

    @property
    def density(self) -> float:
        """Summits per area."""
        return surface_peaks(self.moments.slope, self.moments.curvature).density

    def _sum(self, separation: float, power: float, radius_power: float, factor: int) -> float:
        weight, height, radius, _ = self._summits
        spread = max(self.moments.spread, 1e-9 * math.sqrt(self.moments.height))
        mean = spread**power * _excess((separation - height) / spread, power)
        shape = _shapes()[factor]
        return self.density * float(np.sum(weight * radius**radius_power * shape * mean))

    def pressure(self, separation: float) -> float:
        """Return F/(E* A0) at a separation of the mean plane from the flat one."""
        return self._sum(separation, 1.5, 0.5, 0)

    def area(self, separation: float) -> float:
        """Return A/A0."""
        return self._sum(separation, 1.0, 1.0, 1)

    def stiffness(self, separation: float) -> float:
        """Return the contact stiffness per area, over E*."""
        return 1.5 * self._sum(separation, 0.5, 0.5, 0)

    def separation(self, pressure: float) -> float:
        """Return the separation at F/(E* A0)."""
        rms = math.sqrt(self.moments.height)

        def excess(separation: float) -> float:
            return math.log(self.pressure(separation) / pressure)

        return float(brentq(excess, -20 * rms, 12 * rms, xtol=1e-12 * rms))


def greenwood_williamson(moments: Moments) -> GreenwoodWilliamson:
    """Return the model with density, mean radius and heights of the summits of a surface.

    Mean and variance of the heights from those of the curvatures, as h given s is normal.
    """
    peaks = surface_peaks(moments.slope, moments.curvature)
    weight, total, _ = _classes()
    sums = total * math.sqrt(moments.curvature)
    mean = float(np.sum(weight * sums))
    variance = float(np.sum(weight * (sums - mean) ** 2))
    return GreenwoodWilliamson(
        density=peaks.density,
        radius=peaks.mean_radius,
        mean=moments.lean * mean,
        deviation=math.sqrt(moments.spread**2 + moments.lean**2 * variance),
    )


@lru_cache(maxsize=1)
def _classes() -> tuple[Array, Array, Array]:
    """Return weights that add up to one, s and the angle of classes of summits for m4 = 1.

    The density of `reference.closed_form.random_field`: exp(-3 s^2/16 - 3 t^2/8) t k1 k2.
    """
    nodes, of_s = np.polynomial.legendre.leggauss(_SUMS)
    total = (nodes + 1)[:, None] * _LARGEST / 2
    nodes, of_angle = np.polynomial.legendre.leggauss(_ANGLES)
    angle = (nodes + 1)[None, :] * math.pi / 4
    t, product = total * np.sin(angle), (total * np.cos(angle)) ** 2 / 4
    density = np.exp(-3 * total**2 / 16 - 3 * t**2 / 8) * t * product * total * np.cos(angle)
    weight = of_s[:, None] * of_angle[None, :] * density
    return weight / weight.sum(), total, angle


@lru_cache(maxsize=1)
def _shapes() -> tuple[Array, Array]:
    """Return force and area of Hertz's ellipses at unit depth and Gaussian radius, by angle."""
    angle = _classes()[2][0]
    force, area = [], []
    for tilt in angle:
        stretch = math.sqrt((1 + math.sin(tilt)) / (1 - math.sin(tilt)))
        form = ellipsoid(stretch, 1 / stretch, 1.0)
        force.append(float(form.force(1.0)))
        area.append(float(form.contact_area(1.0)))
    return np.array(force), np.array(area)


def _excess(low: Array, power: float) -> Array:
    """Return the mean of (z - low)^power over a standard normal z above low."""
    deep = np.minimum(low, -30.0)
    far = (-deep) ** power * (1 + power * (power - 1) / (2 * deep**2))  # all heights are above
    small = np.clip(low, -30.0, 37.0)
    factor = gamma(power + 1) / math.sqrt(2 * math.pi)
    near = factor * np.exp(-(small**2) / 4) * pbdv(-power - 1, small)[0]
    return np.where(low < -30.0, far, np.where(low > 37.0, 0.0, near))
