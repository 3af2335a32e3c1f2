"""Closed forms of a ball that dents a half-space, and fits of finite elements.

- Johnson (1985, 6.3): the core below the contact presses like a fluid into a spherical cavity, p_m
  its pressure and (2/3) Y; between first and full yield.
- Thornton (1997): Hertz's pressure cut off at that of first yield, unloading along Hertz's law of
  the flattened ball.
- Johnson (1985, 11.4): full yield at a constant pressure from the first touch, Hertz on unloading.
- Fits for a deformable ball that a rigid flat flattens: another problem than a rigid ball in a
  half-space. Both agree only while a << R (Jackson & Kogut 2006, J. Tribol. 128, 209), beyond first
  yield they part as the contact grows. Both fits are functions of w = d/d_c, d_c the penetration at
  first yield as their authors compute it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.arguments import refuse
from reference.plastic.first_yield import yield_depth

Array = NDArray[np.float64]

_FLATTENED = "fit for a deformable ball under a rigid flat: a dented half-space while a << R"


@dataclass(frozen=True)
class FlattenedBall:
    """Radius R, E*, nu and Y: of the ball that is flattened, while a << R of the body it dents."""

    radius: float
    effective_modulus: float
    poisson_ratio: float
    yield_stress: float


@dataclass(frozen=True)
class Fit:
    """Curves over w = d/d_c.

    `force` and `area` are in units of Hertz's contact at first yield, whose largest pressure is
    `pressure`; `residual` is the depth that remains after unloading from w, in units of d_c. Fitted
    up to w = `largest`; `source` names the paper, and its problem.
    """

    ball: FlattenedBall
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


def kogut_etsion(ball: FlattenedBall) -> Fit:
    """Kogut & Etsion (2002), 1 <= w <= 110; unloading by Etsion, Kligerman & Kadin (2005).

    p0 at first yield K H, K = 0.454 + 0.41 nu, H = 2.8 Y (Tabor 1951). Below w = 1 Hertz.

    Examples
    --------
    >>> fit = kogut_etsion(FlattenedBall(1.0, 1.0, 0.3, 1e-3))
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


def jackson_green(ball: FlattenedBall) -> Fit:
    """Jackson & Green (2005), up to a/R = 0.41, with the hardness H_G of Jackson et al.

    p0 at first yield C Y, C = 1.295 exp(0.736 nu); Hertz up to w = 1.9; H_G/Y =
    2.84 - 0.92 (1 - cos(pi a/R)) falls with the contact.

    Examples
    --------
    >>> fit = jackson_green(FlattenedBall(1.0, 1.0, 0.3, 1e-3))
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


def cavity_pressure(strain: ArrayLike, poisson_ratio: float) -> Array:
    """Return p_m/Y of the contact by the expanding cavity.

    p_m/Y = (2/3) (2 + ln((E a/(Y R) + 4 (1 - 2 nu))/(6 (1 - nu)))), `strain` being E a/(Y R) of a
    rigid ball.

    Examples
    --------
    >>> round(float(cavity_pressure(40.0, 0.5)), 2)
    3.06
    """
    core = (np.asarray(strain, dtype=float) + 4 * (1 - 2 * poisson_ratio)) / (
        6 * (1 - poisson_ratio)
    )
    return np.asarray(2 / 3 * (2 + np.log(core)))


def thornton_restitution(speed: ArrayLike) -> Array:
    """Return the coefficient of restitution at a speed over that of first yield.

    With w = d/d_y the largest force is f = 1 + (3/2)(w - 1) and the work on loading
    l = 2/5 + (w - 1) + (3/4)(w - 1)^2, in units of first yield; (v/v_y)^2 = (5/2) l, and of it
    e^2 = (2/5) f^2/(sqrt(w) l) is given back: 1.18 (v_y/v)^(1/4) at last.

    Examples
    --------
    >>> thornton_restitution([0.5, 1.0, 1e4]).round(4).tolist()
    [1.0, 1.0, 0.1185]
    """
    speeds = np.asarray(speed, dtype=float)
    refuse([] if (speeds > 0).all() else [f"speed must be positive, got {speed!r}"])
    work = 0.4 * np.maximum(speeds, 1.0) ** 2
    # (3/4) x^2 + x = l - 2/5
    beyond = (np.sqrt(1 + 3 * (work - 0.4)) - 1) * 2 / 3
    force = 1 + 1.5 * beyond
    return np.asarray(np.sqrt(0.4 * force**2 / (np.sqrt(1 + beyond) * work)))


def johnson_restitution(energy: ArrayLike, softness: float, hardness: float = 3.0) -> Array:
    """Return the coefficient of restitution of a ball in full yield from the first touch.

    F = pi a^2 p with a^2 = 2 R d takes the energy W = pi a^4 p/(4 R), and 3 F^2/(10 E* a) of it is
    given back: e^2 = (6 pi/5) (p/E*) (R/a), 3.7 (Y/E*)^(1/2) (W/(Y R^3))^(-1/8) at p = 3 Y.
    `energy` is W/(Y R^3), `softness` Y/E*, `hardness` p/Y.

    Examples
    --------
    >>> round(float(johnson_restitution(1.0, 1e-4)), 4)
    0.0374
    """
    radius = (4 * np.asarray(energy, dtype=float) / (np.pi * hardness)) ** 0.25
    return np.asarray(np.sqrt(1.2 * np.pi * hardness * softness / radius))
