"""Persson's theory with the partial contact of Xu, Zhou, Mueser et al. (2024).

In `persson` the pressure spreads by the variance V = h'^2/4 that the waves up to q have in full
contact. Where the share A of the surface is in contact less of them is pressed flat; with what is
left of the variance, W (E* = 1),

    A(q) = erf(p/sqrt(2 W)),    W = [gamma + (1 - gamma) A] V,    gamma = 0.42,

and the elastic energy per area is U = int A dW/q, as the code that was published with it has it.
The mean gap follows from dU = -p dgap.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import PchipInterpolator
from scipy.special import erf, ndtr

from reference.arguments import positive_faults, refuse
from reference.closed_form.persson import Array, Persson

GAMMA = 0.42
# Pressures over h' for which the energy is known, and how many; A = 1 - 1e-16 at the last.
_LEAST, _MOST, _LOADS = 1e-7, 6.0, 600
_HALVINGS = 50


@dataclass(frozen=True)
class PerssonXu:
    """The theory for one surface; E* = 1.

    Parameters
    ----------
    wavenumber, power : ndarray, shape (m,)
        As of `Persson`.

    Raises
    ------
    ValueError
        As of `Persson`.

    Examples
    --------
    At light loads the area is that of Persson over sqrt(gamma):

    >>> rings = np.array([1.0, 10.0]), np.array([1.0, 0.01])
    >>> round(PerssonXu(*rings).area(1e-5) / Persson(*rings).area(1e-5) * GAMMA**0.5, 3)
    1.0
    """

    wavenumber: Array
    power: Array

    def __post_init__(self) -> None:
        checked = Persson(self.wavenumber, self.power)
        object.__setattr__(self, "wavenumber", checked.wavenumber)
        object.__setattr__(self, "power", checked.power)

    @cached_property
    def _full(self) -> Array:
        """V of the waves up to each ring."""
        return np.cumsum(self.wavenumber**2 * self.power) / 4

    def _spread(self, pressures: ArrayLike, full: Array) -> tuple[Array, Array]:
        """Return A and W of waves whose variances V are `full`, (pressures, rings)."""
        p = np.atleast_1d(np.asarray(pressures, dtype=float))[:, None]
        low, high = np.zeros((len(p), len(full))), np.ones((len(p), len(full)))
        for _ in range(_HALVINGS):
            share = (low + high) / 2
            short = erf(p / np.sqrt(2 * (GAMMA + (1 - GAMMA) * share) * full)) > share
            low, high = np.where(short, share, low), np.where(short, high, share)
        return share, (GAMMA + (1 - GAMMA) * share) * full

    def area(self, pressure: float) -> float:
        """Return A/A0 at the nominal pressure p/E*."""
        refuse(positive_faults(pressure=pressure))
        return float(self._spread(pressure, self._full[-1:])[0][0, 0])

    def pressure_below(self, pressure: float, limits: ArrayLike) -> Array:
        """Return the share of A0 in contact whose pressure is below each limit, over A0.

        As of `Persson`, with W of all waves for the variance.
        """
        refuse(positive_faults(pressure=pressure))
        high = np.maximum(np.asarray(limits, dtype=float), 0.0)
        width = math.sqrt(self._spread(pressure, self._full[-1:])[1][0, 0])
        there = ndtr((high - pressure) / width) + ndtr(-(high + pressure) / width)
        return np.asarray(there - 2 * ndtr(-pressure / width))

    @cached_property
    def _gap(self) -> tuple[PchipInterpolator, float, float]:
        """Mean gap over ln p, the integral of dU/p from p on, and the ends of what is known."""
        p = 2 * math.sqrt(self._full[-1]) * np.geomspace(_LEAST, _MOST, _LOADS)
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
