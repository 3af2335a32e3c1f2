"""Peaks of isotropic Gaussian surfaces and of random lines: densities and curvatures.

With m2 = <(dh/dx)^2> and m4 = <(d2h/dx2)^2> of any section through the surface, <|grad h|^2> =
2 m2, <(lap h)^2> = (8/3) m4, <kappa1 kappa2> = <hxx hyy - hxy^2> = 0 (M. S. Longuet-Higgins, Phil.
Trans. R. Soc. A 249 (1957) 321; P. R. Nayak, J. Lubr. Technol. 93 (1971) 398).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import quad

from reference.closed_form.form import require_positive

Quantity = Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]]


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

    Examples
    --------
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

    At a stationary point s = kappa1 + kappa2 is normal with variance (8/3) m4 and t = kappa1 -
    kappa2 >= 0 is Rayleigh with parameter (4/3) m4, independent of s and of the gradient; summits
    are the points with s > t, weighted by |kappa1 kappa2| = (s^2 - t^2)/4 (Kac-Rice). The density
    is m4/(6 sqrt(3) pi m2) and the mean curvature 8 sqrt(m4)/(3 sqrt(pi)) (Nayak 1971).

    Examples
    --------
    >>> summits = surface_peaks(1.0, 1.0)
    >>> round(summits.mean_curvature * 3 * math.pi**0.5 / 8, 10)
    1.0
    """
    require_positive("surface_peaks", slope_moment=slope_moment, curvature_moment=curvature_moment)
    root = math.sqrt(curvature_moment)
    mean, gauss, radius = _unit_summits()
    return Peaks(
        density=curvature_moment / slope_moment / (6 * math.sqrt(3) * math.pi),
        mean_curvature=root * mean,
        gaussian_curvature=curvature_moment * gauss,
        mean_radius=radius / root,
    )


@lru_cache(maxsize=1)
def _unit_summits() -> tuple[float, ...]:
    """Return averages for m4 = 1: (k1 + k2)/2, k1 k2 and 1/sqrt(k1 k2)."""
    count = _summit_average(lambda total, gauss: np.ones_like(gauss))
    quantities: tuple[Quantity, ...] = (
        lambda total, gauss: total / 2,
        lambda total, gauss: gauss,
        lambda total, gauss: 1 / np.sqrt(gauss),
    )
    return tuple(_summit_average(quantity) / count for quantity in quantities)


def _summit_average(quantity: Quantity) -> float:
    """Return the integral of a function of (s, kappa1 kappa2) over the summits for m4 = 1.

    t = s sin(angle), so that kappa1 kappa2 = (s cos(angle))^2/4.
    """
    nodes, weights = np.polynomial.legendre.leggauss(40)
    angle = (nodes + 1) * math.pi / 4

    def along(s: float) -> float:
        t, gauss = s * np.sin(angle), (s * np.cos(angle)) ** 2 / 4
        density = np.exp(-3 * s**2 / 16 - 3 * t**2 / 8) * t * gauss
        values = quantity(np.asarray(s), gauss)
        return float((weights * s * np.cos(angle) * density * values).sum())

    # beyond s = 40 standard units the density is below 1e-130
    return quad(along, 0, 40, epsrel=1e-12, limit=200)[0]
