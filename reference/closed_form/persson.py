"""Persson's theory of rough contact: area, mean gap, distributions of pressure and gap.

B. N. J. Persson, J. Chem. Phys. 115 (2001) 3840 (area, pressure); C. Yang and B. N. J. Persson, J.
Phys.: Condens. Matter 20 (2008) 215214 (mean gap); A. Almqvist, C. Campana, N. Prodanov and B. N.
J. Persson, J. Mech. Phys. Solids 59 (2011) 2355 (distribution of the gap). For stationary surfaces
much larger than their longest wave. E* = 1: pressures are in units of it.

With the waves up to q of a surface that is pressed against a flat half-space, the pressure spreads
like heat, and what reaches zero has lost contact: with h'(q) the rms gradient of these waves the
share in contact is P = erf(sqrt2 p/h').
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import CubicSpline, PchipInterpolator, PPoly
from scipy.special import erf, exp1, ndtr

from reference.arguments import positive_faults, refuse
from reference.closed_form.form import checked_load

Array = NDArray[np.float64]


def persson_area(relative_load: ArrayLike) -> Any:
    """Return A/A0 = erf(sqrt(2) p/(E* h')), for F/(E* A0 h') with h' = sqrt<|grad h|^2>.

    B. N. J. Persson, J. Chem. Phys. 115 (2001) 3840: A/A0 = erf(p/(2 sqrt G)) with
    G = (pi/4) E*^2 int q^3 C2D dq = (E* h')^2/8. Exact for full contact, otherwise a diffusion
    approximation; A = sqrt(8/pi) F/(E* h') at small loads.

    >>> round(float(persson_area(1e-3)) / 1e-3 / math.sqrt(8 / math.pi), 5)
    1.0
    """
    return erf(math.sqrt(2) * checked_load("relative_load", relative_load))[()]


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


def _pressure_below(pressure: float, limits: ArrayLike, width: float) -> Array:
    """Phi((s - p)/w) - Phi((s + p)/w), less its value at zero."""
    high = np.maximum(np.asarray(limits, dtype=float), 0.0)
    there = ndtr((high - pressure) / width) + ndtr(-(high + pressure) / width)
    return np.asarray(there - 2 * ndtr(-pressure / width))


class Persson(WaveRings):
    """The theory for one surface.

    Examples
    --------
    >>> theory = Persson(np.array([1.0, 10.0]), np.array([1.0, 0.01]))
    >>> round(theory.area(0.1), 6) == round(math.erf(math.sqrt(2) * 0.1 / math.sqrt(2)), 6)
    True
    """

    # Share of the elastic energy of waves that are not in contact everywhere (Almqvist et al. 2011)
    gamma = 0.45

    def area(self, pressure: float) -> float:
        """Return A/A0 at the nominal pressure p/E*."""
        return float(self._areas(pressure)[-1])

    def _areas(self, pressure: float) -> Array:
        """Return the share in contact that is seen with the waves up to each ring."""
        refuse(positive_faults(pressure=pressure))
        return np.asarray(erf(math.sqrt(2) * pressure / np.sqrt(self._slopes)))

    def pressure_below(self, pressure: float, limits: ArrayLike) -> Array:
        """Return the share of A0 in contact whose pressure is below each limit, over A0.

        The density is that of two Gaussians of variance h'^2/4 at p and, negative, at -p: it starts
        in proportion to the pressure.
        """
        refuse(positive_faults(pressure=pressure))
        return _pressure_below(pressure, limits, math.sqrt(self._slopes[-1]) / 2)

    def mean_gap(self, pressure: float) -> float:
        """Return the mean gap at p/E*."""
        return self._gap(pressure, -1)

    def stiffness(self, pressure: float) -> float:
        """Return -dp/dgap, the contact stiffness per nominal area over E*."""
        weight, over = self._weights(-1)
        t = over * pressure
        rate = (self.gamma + 3 * (1 - self.gamma) * erf(t) ** 2) * np.exp(-(t**2)) / pressure
        return 1.0 / float(np.sum(weight * rate))

    def _weights(self, after: int) -> tuple[Array, Array]:
        """Return q h_q^2 w/(2 sqrt pi) and w of the waves after a ring, w = sqrt2/h'.

        Of its own gradient a ring counts with half.
        """
        q, power = self.wavenumber[after + 1 :], self.power[after + 1 :]
        own = q**2 * power
        over = math.sqrt(2) / np.sqrt(np.cumsum(own) - 0.5 * own)
        return q * power * over / (2 * math.sqrt(math.pi)), over

    def _gap(self, pressure: float, after: int) -> float:
        """Return the mean gap of the waves after a ring: the rate integrated from t = w p on.

        The part of the rate with erf^2 is regular at t = 0.
        """
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

    Examples
    --------
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

    def area(self, pressure: float) -> float:
        """Return A/A0 at the nominal pressure p/E*."""
        refuse(positive_faults(pressure=pressure))
        return float(self._spread(pressure, self._full[-1:])[0][0, 0])

    def pressure_below(self, pressure: float, limits: ArrayLike) -> Array:
        """Return the share of A0 in contact whose pressure is below each limit, over A0.

        As of `Persson`, with W of all waves for the variance.
        """
        refuse(positive_faults(pressure=pressure))
        width = math.sqrt(self._spread(pressure, self._full[-1:])[1][0, 0])
        return _pressure_below(pressure, limits, width)

    @cached_property
    def _gap(self) -> tuple[PchipInterpolator, float, float]:
        """Mean gap over ln p, the integral of dU/p from p on, and the ends of what is known."""
        # A = 1 - 1e-16 at the last
        p = 2 * math.sqrt(self._full[-1]) * np.geomspace(1e-7, 6.0, 600)
        # a ring's energy is that of the area that it has half way
        own = self.wavenumber**2 * self.power / 4
        share, _ = self._spread(p, self._full - own / 2)
        _, width = self._spread(p, self._full)
        energy = (share * np.diff(width, axis=1, prepend=0.0) / self.wavenumber).sum(axis=1)
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
