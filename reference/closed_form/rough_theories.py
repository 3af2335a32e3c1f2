"""Theories of rough contact: asperities that do not know of each other, and Persson's.

Pressures are in units of E* (E* = 1).

With the moments m0 = <h^2>, m2 = <(dh/dx)^2> and m4 = <(d2h/dx2)^2> of any section through an
isotropic surface, <|grad h|^2> = 2 m2, <(lap h)^2> = (8/3) m4, <kappa1 kappa2> = 0, and the joint
density of height and curvatures of its summits is known (M. S. Longuet-Higgins, Phil. Trans. R.
Soc. A 249 (1957) 321; P. R. Nayak, J. Lubr. Technol. 93 (1971) 398). A. W. Bush, R. D. Gibson and
T. R. Thomas (Wear 35 (1975) 87) put Hertz's elliptic contact on each of them; J. A. Greenwood and
J. B. P. Williamson (Proc. R. Soc. A 295 (1966) 300) a round one of the mean radius, with normal
heights.

Persson's theory is for stationary surfaces much larger than their longest wave: B. N. J. Persson,
J. Chem. Phys. 115 (2001) 3840 (area, pressure); C. Yang and B. N. J. Persson, J. Phys.: Condens.
Matter 20 (2008) 215214 (mean gap); A. Almqvist, C. Campana, N. Prodanov and B. N. J. Persson, J.
Mech. Phys. Solids 59 (2011) 2355 (distribution of the gap). With the waves up to q of a surface
that is pressed against a flat half-space, the pressure spreads like heat, and what reaches zero has
lost contact: with h'(q) the rms gradient of these waves the share in contact is P = erf(sqrt2
p/h').
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import quad
from scipy.interpolate import CubicSpline, PchipInterpolator, PPoly
from scipy.optimize import brentq
from scipy.special import erf, exp1, gamma, ndtr, pbdv

from reference.arrays import Array
from reference.closed_form.form import checked_load, require_positive
from reference.closed_form.numerics import gauss_rule
from reference.closed_form.shapes import ellipsoid
from reference.errors import positive_faults, refuse


@dataclass(frozen=True)
class Peaks:
    """Averages over the maxima of a random surface or line."""

    density: float  # maxima per area, or per length
    mean_curvature: float  # mean of the curvature: (kappa1 + kappa2)/2 of a surface, -h'' of a line
    # mean of the Gaussian radius 1/sqrt(kappa1 kappa2); of a line the mean of 1/(-h'')
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


def _separation(
    law: Callable[[float], float], pressure: float, ends: tuple[float, float], unit: float
) -> float:
    """Return the separation between two ends at which a law has a pressure."""
    return float(brentq(lambda at: math.log(law(at) / pressure), *ends, xtol=1e-12 * unit))


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
        return _separation(self.pressure, pressure, (-20 * rms, 12 * rms), rms)

    def _sum(self, separation: float, power: float, radius_power: float, factor: int) -> float:
        """Return the mean over summits of depth^power radius^radius_power, times their density.

        `factor` is that of Hertz's ellipse: 0 for force and stiffness, 1 for the area.
        """
        weight, total, angle = _summits()
        root = math.sqrt(self.moments.curvature)
        radius = 2 / (root * total * np.cos(angle))
        height = self.moments.lean * root * total * np.ones_like(angle)
        spread = max(self.moments.spread, 1e-9 * math.sqrt(self.moments.height))
        # the mean of (z - low)^power over a standard normal z above low
        low = (separation - height) / spread
        deep = np.minimum(low, -30.0)
        far = (-deep) ** power * (1 + power * (power - 1) / (2 * deep**2))  # all heights are above
        small = np.clip(low, -30.0, 37.0)
        unit = gamma(power + 1) / math.sqrt(2 * math.pi)
        near = unit * np.exp(-(small**2) / 4) * pbdv(-power - 1, small)[0]
        mean = spread**power * np.where(low < -30.0, far, np.where(low > 37.0, 0.0, near))
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


@dataclass(frozen=True)
class GreenwoodWilliamson:
    """Spherical caps of one radius whose heights are normal, each a Hertz contact of its own."""

    density: float  # summits per area
    radius: float  # their radius
    # mean and standard deviation of their heights
    mean: float
    deviation: float

    def pressure(self, separation: float) -> float:
        """Return F/(E* A0) at a separation of the mean plane from the flat one."""
        factor = 4 / 3 * self.density * math.sqrt(self.radius)
        return factor * self._moment(separation, 1.5)

    def separation(self, pressure: float) -> float:
        """Return the separation at F/(E* A0)."""
        ends = self.mean - 10 * self.deviation, self.mean + 10 * self.deviation
        return _separation(self.pressure, pressure, ends, self.deviation)

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


@dataclass(frozen=True)
class WaveRings:
    """A surface by the rings of its waves, (m,): ascending wavenumbers, and mean square heights."""

    wavenumber: Array
    power: Array

    def __post_init__(self) -> None:
        q, power = (np.asarray(x, dtype=float) for x in (self.wavenumber, self.power))
        wrong = []
        if q.ndim != 1 or q.shape != power.shape or not len(q):
            wrong.append(f"wavenumber and power must be of one length, got {q.shape} {power.shape}")
        elif not ((q > 0).all() and (np.diff(q) > 0).all() and (power > 0).all()):
            wrong.append("wavenumber and power must be positive, and wavenumber ascend")
        refuse(wrong)
        object.__setattr__(self, "wavenumber", q)
        object.__setattr__(self, "power", power)

    @cached_property
    def _slopes(self) -> Array:
        """Mean square gradients of the waves up to each ring, with it."""
        return np.cumsum(self.wavenumber**2 * self.power)

    def _in_contact(self, pressure: float) -> tuple[float, float]:
        """Return A/A0 and the variance to which the pressure has spread, with all waves."""
        raise NotImplementedError

    def area(self, pressure: float) -> float:
        """Return A/A0 at the nominal pressure p/E*."""
        refuse(positive_faults(pressure=pressure))
        return self._in_contact(pressure)[0]

    def pressure_below(self, pressure: float, limits: ArrayLike) -> Array:
        """Return the share of A0 in contact whose pressure is below each limit, over A0.

        The density is that of two Gaussians, at p and, negative, at -p: it starts in proportion to
        the pressure.
        """
        refuse(positive_faults(pressure=pressure))
        width = math.sqrt(self._in_contact(pressure)[1])
        high = np.maximum(np.asarray(limits, dtype=float), 0.0)
        there = ndtr((high - pressure) / width) + ndtr(-(high + pressure) / width)
        return np.asarray(there - 2 * ndtr(-pressure / width))


class Persson(WaveRings):
    """The theory for one surface."""

    # Share of the elastic energy of waves that are not in contact everywhere (Almqvist et al. 2011)
    gamma = 0.45

    def _in_contact(self, pressure: float) -> tuple[float, float]:
        return float(self._areas(pressure)[-1]), float(self._slopes[-1]) / 4

    def _areas(self, pressure: float) -> Array:
        """Return the share in contact that is seen with the waves up to each ring."""
        return np.asarray(erf(math.sqrt(2) * pressure / np.sqrt(self._slopes)))

    def mean_gap(self, pressure: float) -> float:
        """Return the mean gap at p/E*."""
        return self._gap(pressure, -1)

    def stiffness(self, pressure: float) -> float:
        """Return -dp/dgap, the contact stiffness per nominal area over E*; infinite at gap zero."""
        weight, over = self._weights(-1)
        t = over * pressure
        rate = (self.gamma + 3 * (1 - self.gamma) * erf(t) ** 2) * np.exp(-(t**2)) / pressure
        softness = float(np.sum(weight * rate))
        return 1.0 / softness if softness else math.inf

    def _weights(self, after: int) -> tuple[Array, Array]:
        """Return q h_q^2 w/(2 sqrt pi) and w of the waves after a ring, w = sqrt2/h'."""
        q, power = self.wavenumber[after + 1 :], self.power[after + 1 :]
        own = q**2 * power  # of its own gradient a ring counts with half
        over = math.sqrt(2) / np.sqrt(np.cumsum(own) - 0.5 * own)
        return q * power * over / (2 * math.sqrt(math.pi)), over

    def _gap(self, pressure: float, after: int) -> float:
        """Return the mean gap of the waves after a ring: the rate integrated from t = w p on."""
        weight, over = self._weights(after)
        t = over * pressure
        singular = 0.5 * self.gamma * exp1(np.maximum(t, 1e-300) ** 2)
        least, most = _GAP_RANGE
        regular = _regular_part()(math.log(most)) - _regular_part()(np.log(np.clip(t, least, most)))
        return float(np.sum(weight * (singular + regular)))

    def gap_below(self, pressure: float, limits: ArrayLike) -> Array:
        """Return the share of A0 out of contact whose gap is below each limit, over A0.

        What a ring of waves takes from the area in contact gets the mean gap u1 that keeps the
        volume, spread by the roughness of the shorter waves as a Gaussian that is folded at zero.
        """
        refuse(positive_faults(pressure=pressure))
        inside = np.concatenate([[1.0], self._areas(pressure)])
        gaps = [self._gap(pressure / share, ring - 1) for ring, share in enumerate(inside)]
        lost, opened = -np.diff(inside), -np.diff(inside * gaps)
        some = lost > 1e-15
        place = opened[some] / lost[some]
        shorter = np.cumsum(self.power[::-1])[::-1] - 0.5 * self.power
        width = np.sqrt(shorter[some])
        high = np.maximum(np.asarray(limits, dtype=float), 0.0)[..., None]
        folded = ndtr((high - place) / width) - ndtr((-high - place) / width)
        return np.asarray(folded @ lost[some])


_GAP_RANGE = 1e-9, 7.0


@lru_cache(maxsize=1)
def _regular_part() -> PPoly:
    """Return the antiderivative in log t of 3 (1 - gamma) erf(t)^2 exp(-t^2)."""
    t = np.geomspace(*_GAP_RANGE, 4000)
    values = 3 * (1 - Persson.gamma) * erf(t) ** 2 * np.exp(-(t**2))
    return CubicSpline(np.log(t), values).antiderivative()


class PerssonXu(WaveRings):
    """The theory with the partial contact of Xu, Zhou, Mueser et al. (2024), for one surface.

    In `Persson` the pressure spreads by the variance V = h'^2/4 that the waves up to q have in full
    contact. Where the share A of the surface is in contact less of them is pressed flat; with the
    rest of the variance, W (E* = 1),

        A(q) = erf(p/sqrt(2 W)),    W = [gamma + (1 - gamma) A] V,    gamma = 0.42,

    and the elastic energy per area is U = int A dW/q, as the code that was published with it has
    it. The mean gap follows from dU = -p dgap.

    At light loads the area is that of Persson over sqrt(gamma):

    >>> rings = np.array([1.0, 10.0]), np.array([1.0, 0.01])
    >>> light = PerssonXu(*rings).area(1e-5) / Persson(*rings).area(1e-5)
    >>> round(light * PerssonXu.gamma**0.5, 3)
    1.0
    """

    gamma = 0.42

    @cached_property
    def _full(self) -> Array:
        """V of the waves up to each ring."""
        return self._slopes / 4

    def _spread(self, pressures: ArrayLike, full: Array) -> tuple[Array, Array]:
        """Return A and W of waves whose variances V are `full`, (pressures, rings)."""
        gamma = self.gamma
        p = np.atleast_1d(np.asarray(pressures, dtype=float))[:, None]
        low, high = np.zeros((len(p), len(full))), np.ones((len(p), len(full)))
        for _ in range(50):  # halvings
            share = (low + high) / 2
            short = erf(p / np.sqrt(2 * (gamma + (1 - gamma) * share) * full)) > share
            low, high = np.where(short, share, low), np.where(short, high, share)
        return share, (gamma + (1 - gamma) * share) * full

    def _in_contact(self, pressure: float) -> tuple[float, float]:
        share, variance = self._spread(pressure, self._full[-1:])
        return float(share[0, 0]), float(variance[0, 0])

    @cached_property
    def _gap(self) -> tuple[PchipInterpolator, float, float]:
        """Mean gap over ln p, the integral of dU/p from p on, and the ends of what is known."""
        # A = 1 - 1e-16 at the last
        p = 2 * math.sqrt(self._full[-1]) * np.geomspace(1e-7, 6.0, 600)
        # a ring's energy is that of the area that it has half way
        own = self.wavenumber**2 * self.power / 4
        share, _ = self._spread(p, self._full - own / 2)
        _, variance = self._spread(p, self._full)
        energy = (share * np.diff(variance, axis=1, prepend=0.0) / self.wavenumber).sum(axis=1)
        steps = np.diff(energy) / np.diff(p) * np.diff(np.log(p))
        gap = np.concatenate([np.cumsum(steps[::-1])[::-1], [0.0]])
        return PchipInterpolator(np.log(p), gap), math.log(p[0]), math.log(p[-1])

    def mean_gap(self, pressure: float) -> float:
        """Return the mean gap at p/E*.

        Zero beyond 6 h', where all is in contact; with the logarithm of the pressure below 1e-7 h',
        where area and energy are in proportion to it.
        """
        refuse(positive_faults(pressure=pressure))
        gap, least, most = self._gap
        at = math.log(pressure)
        inside = min(max(at, least), most)
        return float(gap(inside)) + min(at - least, 0.0) * float(gap.derivative()(least))

    def stiffness(self, pressure: float) -> float:
        """Return -dp/dgap, the contact stiffness per nominal area over E*; infinite beyond 6 h'."""
        refuse(positive_faults(pressure=pressure))
        gap, least, most = self._gap
        at = math.log(pressure)
        slope = float(gap.derivative()(max(at, least))) if at < most else 0.0
        return -pressure / slope if slope else math.inf
