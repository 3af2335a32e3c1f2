"""Summits of Gaussian surfaces, and asperities on them that do not know of each other.

With the moments m0 = <h^2>, m2 = <(dh/dx)^2> and m4 = <(d2h/dx2)^2> of any section through an
isotropic surface, <|grad h|^2> = 2 m2, <(lap h)^2> = (8/3) m4, <kappa1 kappa2> = 0, and the joint
density of height and curvatures of its summits is known (M. S. Longuet-Higgins, Phil. Trans. R.
Soc. A 249 (1957) 321; P. R. Nayak, J. Lubr. Technol. 93 (1971) 398). A. W. Bush, R. D. Gibson and
T. R. Thomas (Wear 35 (1975) 87) put Hertz's elliptic contact on each of them; J. A. Greenwood and
J. B. P. Williamson (Proc. R. Soc. A 295 (1966) 300) a round one of the mean radius, with normal
heights. E* = 1.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.special import gamma, pbdv

from reference.arguments import positive_faults, refuse
from reference.closed_form.form import checked_load, require_positive
from reference.closed_form.numerics import gauss_rule
from reference.closed_form.shapes import ellipsoid

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Peaks:
    """Averages over the maxima of a random surface or line.

    Attributes
    ----------
    density : float
        Maxima per area, or per length.
    mean_curvature : float
        Mean of the curvature: (kappa1 + kappa2)/2 of a surface, -h'' of a line.
    gaussian_curvature : float
        Mean of kappa1 kappa2; of a line the mean square of -h''.
    mean_radius : float
        Mean of the Gaussian radius 1/sqrt(kappa1 kappa2); of a line the mean of 1/(-h'').
    """

    density: float
    mean_curvature: float
    gaussian_curvature: float
    mean_radius: float


def line_peaks(slope_moment: float, curvature_moment: float) -> Peaks:
    """Return averages over the maxima of a Gaussian line with <h'^2> = m2 and <h''^2> = m4.

    By the Kac-Rice formula the curvature k of maxima has the density k exp(-k^2/(2 m4))/m4 for any
    spectrum: mean sqrt(pi m4/2), mean of 1/k the same number over m4.

    >>> line = line_peaks(1.0, 1.0)
    >>> round(line.mean_curvature * line.mean_radius, 6)  # pi/2 for any moments
    1.570796
    """
    require_positive("line_peaks", slope_moment=slope_moment, curvature_moment=curvature_moment)
    mean = math.sqrt(math.pi * curvature_moment / 2)
    return Peaks(
        density=math.sqrt(curvature_moment / slope_moment) / (2 * math.pi),
        mean_curvature=mean,
        gaussian_curvature=2 * curvature_moment,
        mean_radius=mean / curvature_moment,
    )


def surface_peaks(slope_moment: float, curvature_moment: float) -> Peaks:
    """Return averages over the summits of an isotropic Gaussian surface with moments m2, m4.

    The density is m4/(6 sqrt(3) pi m2) and the mean curvature 8 sqrt(m4)/(3 sqrt(pi)) (Nayak 1971).

    >>> summits = surface_peaks(1.0, 1.0)
    >>> round(summits.mean_curvature * 3 * math.pi**0.5 / 8, 10)
    1.0
    """
    require_positive("surface_peaks", slope_moment=slope_moment, curvature_moment=curvature_moment)
    root = math.sqrt(curvature_moment)
    weight, total, angle = _summits()
    product = (total * np.cos(angle)) ** 2 / 4
    return Peaks(
        density=curvature_moment / slope_moment / (6 * math.sqrt(3) * math.pi),
        mean_curvature=root * float(np.sum(weight * total / 2)),
        gaussian_curvature=curvature_moment * float(np.sum(weight * product)),
        mean_radius=float(np.sum(weight / np.sqrt(product))) / root,
    )


@lru_cache(maxsize=1)
def _summits() -> tuple[Array, Array, Array]:
    """Return weights that add up to one, s and the angle of classes of summits for m4 = 1.

    At a stationary point s = kappa1 + kappa2 is normal with variance (8/3) m4 and t = kappa1 -
    kappa2 = s sin(angle) >= 0 is Rayleigh with parameter (4/3) m4, independent of s and of the
    gradient; summits are the points with s > t, weighted by |kappa1 kappa2| (Kac-Rice).
    """
    nodes, of_s = gauss_rule(64)
    total = (nodes + 1)[:, None] * 20.0 / 2  # beyond s = 20 the density is below 1e-32
    nodes, of_angle = gauss_rule(24)
    angle = (nodes + 1)[None, :] * math.pi / 4
    t, product = total * np.sin(angle), (total * np.cos(angle)) ** 2 / 4
    density = np.exp(-3 * total**2 / 16 - 3 * t**2 / 8) * t * product * total * np.cos(angle)
    weight = of_s[:, None] * of_angle[None, :] * density
    return weight / weight.sum(), total, angle


@dataclass(frozen=True)
class Moments:
    """Moments of the spectrum of an isotropic surface: m0, m2, m4, with m0 m4 >= (3/2) m2^2."""

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


def bush_gibson_thomas_area(relative_load: ArrayLike) -> Any:
    """Return A/A0 = sqrt(2 pi) F/(E* A0 h'), the limit of vanishing load; h' = sqrt<|grad h|^2>.

    An asymptote, meaningless if it exceeds one.

    >>> round(float(bush_gibson_thomas_area(0.01)), 5)
    0.02507
    """
    load = checked_load("relative_load", relative_load)
    return np.asarray(math.sqrt(2 * math.pi) * load)[()]


@dataclass(frozen=True)
class BushGibsonThomas:
    """Elliptic asperities with the heights and curvatures of the summits of a surface."""

    moments: Moments

    @property
    def density(self) -> float:
        """Summits per area."""
        return surface_peaks(self.moments.slope, self.moments.curvature).density

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

    def _sum(self, separation: float, power: float, radius_power: float, factor: int) -> float:
        """Return the mean over summits of depth^power radius^radius_power, times their density.

        `factor` is that of Hertz's ellipse: 0 for force and stiffness, 1 for the area.
        """
        weight, total, angle = _summits()
        root = math.sqrt(self.moments.curvature)
        radius = 2 / (root * total * np.cos(angle))
        height = self.moments.lean * root * total * np.ones_like(angle)
        spread = max(self.moments.spread, 1e-9 * math.sqrt(self.moments.height))
        mean = spread**power * _excess((separation - height) / spread, power)
        return self.density * float(
            np.sum(weight * radius**radius_power * _ellipses()[factor] * mean)
        )


@lru_cache(maxsize=1)
def _ellipses() -> tuple[Array, Array]:
    """Return force and area of Hertz's ellipses at unit depth and Gaussian radius, by angle."""
    stretches = [math.sqrt((1 + math.sin(t)) / (1 - math.sin(t))) for t in _summits()[2][0]]
    forms = [ellipsoid(stretch, 1 / stretch, 1.0) for stretch in stretches]
    force = np.array([float(form.force(1.0)) for form in forms])
    return force, np.array([float(form.contact_area(1.0)) for form in forms])


def _excess(low: Array, power: float) -> Array:
    """Return the mean of (z - low)^power over a standard normal z above low."""
    deep = np.minimum(low, -30.0)
    far = (-deep) ** power * (1 + power * (power - 1) / (2 * deep**2))  # all heights are above
    small = np.clip(low, -30.0, 37.0)
    factor = gamma(power + 1) / math.sqrt(2 * math.pi)
    near = factor * np.exp(-(small**2) / 4) * pbdv(-power - 1, small)[0]
    return np.where(low < -30.0, far, np.where(low > 37.0, 0.0, near))


@dataclass(frozen=True)
class GreenwoodWilliamson:
    """Spherical caps of one radius whose heights are normal, each a Hertz contact of its own.

    Attributes
    ----------
    density : float
        Summits per area.
    radius : float
        Their radius.
    mean, deviation : float
        Mean and standard deviation of their heights.
    """

    density: float
    radius: float
    mean: float
    deviation: float

    def pressure(self, separation: float) -> float:
        """Return F/(E* A0) at a separation of the mean plane from the flat one."""
        factor = 4 / 3 * self.density * math.sqrt(self.radius)
        return factor * self._moment(separation, 1.5)

    def separation(self, pressure: float) -> float:
        """Return the separation at F/(E* A0)."""
        ends = self.mean - 10 * self.deviation, self.mean + 10 * self.deviation
        return float(brentq(lambda d: math.log(self.pressure(d) / pressure), *ends, xtol=1e-12))

    def area(self, separation: float) -> float:
        """Return A/A0."""
        return math.pi * self.density * self.radius * self._moment(separation, 1.0)

    def stiffness(self, separation: float) -> float:
        """Return the contact stiffness per area, over E*."""
        return 2 * self.density * math.sqrt(self.radius) * self._moment(separation, 0.5)

    def _moment(self, separation: float, power: float) -> float:
        """Return the mean of (z - separation)^power over the summits that are higher."""
        low = (separation - self.mean) / self.deviation

        def integrand(t: float) -> float:
            return float(t**power * math.exp(-0.5 * (low + t) ** 2))

        integral = quad(integrand, max(0.0, -low - 12), max(0.0, -low) + 12, epsabs=0)[0]
        return self.deviation**power * integral / math.sqrt(2 * math.pi)


def greenwood_williamson(moments: Moments) -> GreenwoodWilliamson:
    """Return the model with density, mean radius and heights of the summits of a surface.

    Mean and variance of the heights from those of the curvatures, as h given s is normal.
    """
    peaks = surface_peaks(moments.slope, moments.curvature)
    weight, total, _ = _summits()
    sums = total * math.sqrt(moments.curvature)
    mean = float(np.sum(weight * sums))
    variance = float(np.sum(weight * (sums - mean) ** 2))
    return GreenwoodWilliamson(
        density=peaks.density,
        radius=peaks.mean_radius,
        mean=moments.lean * mean,
        deviation=math.sqrt(moments.spread**2 + moments.lean**2 * variance),
    )
