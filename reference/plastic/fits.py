"""Fits of finite-element results for a deformable ball that a rigid flat flattens.

That is another problem than a rigid ball in a half-space: both agree only while a << R (Jackson &
Kogut 2006, J. Tribol. 128, 209), beyond first yield they part as the contact grows. Both fits are
functions of w = d/d_c, d_c the penetration at first yield as their authors compute it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reference.plastic.materials import yield_depth

Array = NDArray[np.float64]

_FLATTENED = "fit for a deformable ball under a rigid flat: a dented half-space while a << R"


@dataclass(frozen=True)
class Ball:
    """Radius R, E*, nu and Y: of the ball that is flattened, while a << R of the body it dents."""

    radius: float
    effective_modulus: float
    poisson_ratio: float
    yield_stress: float


@dataclass(frozen=True)
class Fit:
    """Curves over w = d/d_c.

    Attributes
    ----------
    ball : Ball
    pressure : float
        p0 of Hertz's contact at first yield.
    force, area : callable
        Of w, in units of those of Hertz's contact at first yield.
    residual : callable or None
        Depth that remains after unloading from w, in units of d_c.
    largest : float
        w up to which it was fitted.
    source : str
        The paper, and what it has computed.
    """

    ball: Ball
    pressure: float
    force: Callable[[Array], Array]
    area: Callable[[Array], Array]
    residual: Callable[[Array], Array] | None
    largest: float
    source: str

    @property
    def yields_at(self) -> float:
        """d_c = (pi p0/(2 E*))^2 R."""
        return yield_depth(self.ball.radius, self.ball.effective_modulus, self.pressure)

    @property
    def force_unit(self) -> float:
        """Force of Hertz's contact at d_c."""
        ball, depth = self.ball, self.yields_at
        return float(4 / 3 * ball.effective_modulus * np.sqrt(ball.radius * depth) * depth)

    @property
    def area_unit(self) -> float:
        """Area of Hertz's contact at d_c."""
        return float(np.pi * self.ball.radius * self.yields_at)


def kogut_etsion(ball: Ball) -> Fit:
    """Kogut & Etsion (2002), 1 <= w <= 110; unloading by Etsion, Kligerman & Kadin (2005).

    p0 at first yield K H, K = 0.454 + 0.41 nu, H = 2.8 Y (Tabor 1951). Below w = 1 Hertz.

    Examples
    --------
    >>> fit = kogut_etsion(Ball(1.0, 1.0, 0.3, 1e-3))
    >>> fit.force(np.array([1.0, 10.0])).round(2)
    array([ 1.  , 25.65])
    """

    def force(w: Array) -> Array:
        middle = np.where(w < 6, 1.03 * w**1.425, 1.40 * w**1.263)
        return np.where(w <= 1, w**1.5, middle)

    def area(w: Array) -> Array:
        return np.where(w <= 1, w, np.where(w < 6, 0.93 * w**1.136, 0.94 * w**1.146))

    def residual(w: Array) -> Array:
        beyond = np.maximum(w, 1.0)
        return w * (1 - beyond**-0.28) * (1 - beyond**-0.69)

    pressure = (0.454 + 0.41 * ball.poisson_ratio) * 2.8 * ball.yield_stress
    return Fit(ball, pressure, force, area, residual, 110.0, f"Kogut & Etsion 2002, {_FLATTENED}")


def jackson_green(ball: Ball) -> Fit:
    """Jackson & Green (2005), up to a/R = 0.41, with the hardness H_G of Jackson et al.

    p0 at first yield C Y, C = 1.295 exp(0.736 nu); Hertz up to w = 1.9; H_G/Y =
    2.84 - 0.92 (1 - cos(pi a/R)) falls with the contact.

    Examples
    --------
    >>> fit = jackson_green(Ball(1.0, 1.0, 0.3, 1e-3))
    >>> fit.force(np.array([1.0])).tolist()
    [1.0]
    """
    factor = 1.295 * np.exp(0.736 * ball.poisson_ratio)
    pressure = float(factor * ball.yield_stress)
    strain = ball.yield_stress / ball.effective_modulus
    power = 0.14 * np.exp(23 * strain)
    depth = yield_depth(ball.radius, ball.effective_modulus, pressure)

    def area(w: Array) -> Array:
        return np.where(w <= 1.9, w, w * (np.maximum(w, 1.9) / 1.9) ** power)

    def force(w: Array) -> Array:
        radius = np.sqrt(area(w) * ball.radius * depth)
        hardness = 2.84 - 0.92 * (1 - np.cos(np.pi * radius / ball.radius))
        elastic = np.exp(-0.25 * w ** (5 / 12)) * w**1.5
        plastic = 4 * hardness / factor * (1 - np.exp(-(w ** (5 / 9)) / 25)) * w
        return np.where(w <= 1.9, w**1.5, elastic + plastic)

    w = np.geomspace(1.0, 1e8, 4001)
    fitted = area(w) * depth / ball.radius <= 0.41**2
    largest = float(w[fitted][-1]) if fitted.any() else 0.0
    return Fit(ball, pressure, force, area, None, largest, f"Jackson & Green 2005, {_FLATTENED}")
