"""Theories of the real contact area of random surfaces as functions of the relative load."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.special import erf

from reference.closed_form.form import checked_load

# kappa = A E* h'/F at vanishing load, h' the rms of the full gradient.
KAPPA_BUSH = math.sqrt(2 * math.pi)


def persson_area(relative_load: ArrayLike) -> Any:
    """Return A/A0 = erf(sqrt(2) p/(E* h')) of Persson's theory.

    B. N. J. Persson, J. Chem. Phys. 115 (2001) 3840: A/A0 = erf(p/(2 sqrt G)) with
    G = (pi/4) E*^2 int q^3 C2D dq = (E* h')^2/8. Exact for full contact, otherwise a diffusion
    approximation; A = sqrt(8/pi) F/(E* h') at small loads. For stationary random surfaces much
    larger than their roll-off wavelength.

    Parameters
    ----------
    relative_load : array_like
        F/(E* A0 h'), not negative, h' = sqrt<|grad h|^2>.

    Examples
    --------
    >>> round(float(persson_area(1e-3)) / 1e-3 / math.sqrt(8 / math.pi), 5)
    1.0
    """
    return erf(math.sqrt(2) * checked_load("relative_load", relative_load))[()]


def bush_gibson_thomas_area(relative_load: ArrayLike) -> Any:
    """Return A/A0 = sqrt(2 pi) F/(E* A0 h'), the limit of vanishing load.

    A. W. Bush, R. D. Gibson and T. R. Thomas, Wear 35 (1975) 87: paraboloids on the summits of an
    isotropic Gaussian surface, without interaction, as the separation tends to infinity.

    Parameters
    ----------
    relative_load : array_like
        F/(E* A0 h'), not negative. An asymptote, meaningless if it exceeds one.

    Examples
    --------
    >>> round(float(bush_gibson_thomas_area(0.01)), 5)
    0.02507
    """
    return np.asarray(KAPPA_BUSH * checked_load("relative_load", relative_load))[()]


@dataclass(frozen=True)
class GreenwoodWilliamson:
    """J. A. Greenwood and J. B. P. Williamson, Proc. R. Soc. A 295 (1966) 300.

    Spherical caps of one radius whose heights are normal, each a Hertz contact of its own; E* = 1.

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

    def _moment(self, separation: float, power: float) -> float:
        """Return the mean of (z - separation)^power over the summits that are higher."""
        low = (separation - self.mean) / self.deviation

        def integrand(t: float) -> float:
            return float(t**power * math.exp(-0.5 * (low + t) ** 2))

        integral = quad(integrand, max(0.0, -low - 12), max(0.0, -low) + 12, epsabs=0)[0]
        return self.deviation**power * integral / math.sqrt(2 * math.pi)

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
