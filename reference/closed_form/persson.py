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

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import CubicSpline, PPoly
from scipy.special import erf, exp1, ndtr

from reference.arguments import positive_faults, refuse

Array = NDArray[np.float64]
# Share of the elastic energy of waves that are not in contact everywhere (Almqvist et al. 2011).
GAMMA = 0.45
_LEAST, _MOST, _NODES = 1e-9, 7.0, 4000


@dataclass(frozen=True)
class Persson:
    """The theory for one surface.

    Parameters
    ----------
    wavenumber : ndarray, shape (m,)
        Of rings of its waves, ascending.
    power : ndarray, shape (m,)
        Their contributions to the mean square height.

    Raises
    ------
    ValueError
        For numbers that are not positive, or wavenumbers that do not ascend.

    Examples
    --------
    >>> theory = Persson(np.array([1.0, 10.0]), np.array([1.0, 0.01]))
    >>> round(theory.area(0.1), 6) == round(math.erf(math.sqrt(2) * 0.1 / math.sqrt(2)), 6)
    True
    """

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
        high = np.maximum(np.asarray(limits, dtype=float), 0.0)
        width = math.sqrt(self._slopes[-1]) / 2
        # Phi((s - p)/w) - Phi((s + p)/w), less its value at zero
        there = ndtr((high - pressure) / width) + ndtr(-(high + pressure) / width)
        return np.asarray(there - 2 * ndtr(-pressure / width))

    def mean_gap(self, pressure: float) -> float:
        """Return the mean gap at p/E*."""
        return float(self._gaps(np.array([pressure]), np.array([-1]))[0])

    def stiffness(self, pressure: float) -> float:
        """Return -dp/dgap, the contact stiffness per nominal area over E*."""
        weight, over = self._weights(-1)
        slope = -float(np.sum(weight * _integrand(over * pressure) / pressure))
        return -1.0 / slope

    def _weights(self, after: int) -> tuple[Array, Array]:
        """Return q h_q^2 w/(2 sqrt pi) and w of the waves after a ring, w = sqrt2/h'.

        Of its own gradient a ring counts with half.
        """
        q, power = self.wavenumber[after + 1 :], self.power[after + 1 :]
        own = q**2 * power
        over = math.sqrt(2) / np.sqrt(np.cumsum(own) - 0.5 * own)
        return q * power * over / (2 * math.sqrt(math.pi)), over

    def _gaps(self, pressures: Array, after: NDArray[np.int_]) -> Array:
        """Return mean gaps of the waves after each ring, at a pressure of its own."""
        values = []
        for pressure, ring in zip(pressures, after, strict=True):
            weight, over = self._weights(int(ring))
            values.append(float(np.sum(weight * _integral(over * pressure))))
        return np.array(values)

    def gap_below(self, pressure: float, limits: ArrayLike) -> Array:
        """Return the share of A0 out of contact whose gap is below each limit, over A0.

        What a ring of waves takes from the area in contact gets the mean gap u1 that keeps the
        volume, spread by the roughness of the shorter waves as a Gaussian that is folded at zero.
        """
        inside = np.concatenate([[1.0], self._areas(pressure)])
        rings = np.arange(-1, len(self.power))
        volume = inside * self._gaps(pressure / inside, rings)
        lost, opened = -np.diff(inside), -np.diff(volume)
        some = lost > 1e-15
        place = opened[some] / lost[some]
        shorter = np.cumsum(self.power[::-1])[::-1] - 0.5 * self.power
        width = np.sqrt(shorter[some])
        high = np.maximum(np.asarray(limits, dtype=float), 0.0)[..., None]
        folded = ndtr((high - place) / width) - ndtr((-high - place) / width)
        return np.asarray(folded @ lost[some])


def _integrand(t: Array) -> Array:
    """Return [gamma + 3 (1 - gamma) erf^2 t] exp(-t^2)."""
    return np.asarray((GAMMA + 3 * (1 - GAMMA) * erf(t) ** 2) * np.exp(-(t**2)))


def _integral(t: Array) -> Array:
    """Return the integral of `_integrand`/t from t on."""
    inside = np.clip(t, _LEAST, _MOST)
    first = 0.5 * GAMMA * exp1(np.maximum(t, 1e-300) ** 2)
    return np.asarray(first + _regular()(math.log(_MOST)) - _regular()(np.log(inside)))


@lru_cache(maxsize=1)
def _regular() -> PPoly:
    """Return the antiderivative in log t of the part with erf^2, which is regular at zero."""
    t = np.geomspace(_LEAST, _MOST, _NODES)
    values = 3 * (1 - GAMMA) * erf(t) ** 2 * np.exp(-(t**2))
    return CubicSpline(np.log(t), values).antiderivative()
