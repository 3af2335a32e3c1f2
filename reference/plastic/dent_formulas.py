"""Closed forms of first yield and of a ball that dents a half-space, fits of finite elements.

- First yield under Hertz's circle and ellipse, by von Mises.
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

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from reference.arrays import Array
from reference.elasticity import von_mises
from reference.errors import poisson_faults, refuse
from reference.fem.far_field import boussinesq

_FLATTENED = "fit for a deformable ball under a rigid flat: a dented half-space while a << R"


def yield_pressure(poisson_ratio: float) -> float:
    """Return p0/Y at which a circular Hertzian contact first yields, by von Mises.

    The larger of two stresses counts. On the axis at depth z a the stresses below the pressure p0
    are sigma_z = -p0/(1 + z^2) and
    sigma_r = -p0 [(1 + nu)(1 - z atan(1/z)) - 1/(2 (1 + z^2))] (Johnson 1985, eq. 3.45); the
    largest difference of both lies at z = 0.48 for nu = 0.3. At the edge there is pure shear,
    sigma_r = -sigma_t = (1 - 2 nu) p0/3, von Mises' (1 - 2 nu)/sqrt(3) p0: the larger one below
    nu = -0.4. -1 < nu <= 1/2.

    >>> round(yield_pressure(0.3), 4)
    1.6128
    """
    refuse(poisson_faults(poisson_ratio))
    depth = np.linspace(1e-6, 2.0, 4001)
    share = (1 + poisson_ratio) * (1 - depth * np.arctan(1 / depth)) - 1 / (2 * (1 + depth**2))
    difference = np.abs(1 / (1 + depth**2) - share)
    top = int(np.clip(np.argmax(difference), 1, depth.size - 2))
    low, mid, high = difference[top - 1 : top + 2]
    peak = mid - (high - low) ** 2 / (8 * (high - 2 * mid + low))
    edge = (1 - 2 * poisson_ratio) / np.sqrt(3)
    return float(1 / max(peak, edge))


def yield_depth(radius: float, effective_modulus: float, pressure: float) -> float:
    """Return the penetration of a ball whose Hertzian contact has a largest pressure p0.

    d = (pi p0/(2 E*))^2 R; with p0 of first yield (`yield_pressure`), that of first yield.

    >>> round(yield_depth(2.0, np.pi / 2, 0.1), 12)
    0.02
    """
    return float((np.pi * pressure / (2 * effective_modulus)) ** 2 * radius)


def elliptic_yield_pressure(poisson_ratio: float, slenderness: float) -> float:
    """Return p0/Y at which an elliptic Hertzian contact first yields, by von Mises.

    The larger of two stresses on the axis counts: below the surface, from the point-force solution
    (Johnson 1985, eq. 3.18) integrated over p0 sqrt(1 - x^2/a^2 - y^2/b^2); and at the surface,
    sigma_x = -p0 [2 nu + (1 - 2 nu) b/(a + b)], sigma_y with a in place of b (ib., eq. 4.28), which
    is the larger one below slender ellipses of a small nu. The rim stays below both. For
    0 <= nu < 1/2 and a slenderness b/a from 0.001 to 1.

    Of a circle that of `yield_pressure`, and at last of a cylinder, 0.558 p0:

    >>> round(elliptic_yield_pressure(0.3, 1.0), 4)
    1.6128
    >>> round(1 / elliptic_yield_pressure(0.3, 1e-3), 3)
    0.558
    """
    faults = poisson_faults(poisson_ratio)
    if not 0 <= poisson_ratio < 0.5:
        faults.append(f"poisson_ratio must lie in [0, 1/2), not {poisson_ratio!r}")
    if not 1e-3 <= slenderness <= 1:
        faults.append(f"slenderness must lie in [0.001, 1], not {slenderness!r}")
    refuse(faults)
    # b = p0 = 1: rays from the centre, under angles that are equally spread after a stretch by the
    # root of the ratio of the axes; along them r = depth sinh(w), w by Gauss
    turn, long = np.arange(0.5, 64) * np.pi / 128, 1 / slenderness
    root = np.sqrt(long)
    angle = np.arctan2(np.sin(turn), root * np.cos(turn))
    d_angle = root / ((root * np.cos(turn)) ** 2 + np.sin(turn) ** 2) * np.pi / 128
    reach = 1 / np.hypot(np.cos(angle) / long, np.sin(angle))
    nodes, weights = np.polynomial.legendre.leggauss(32)
    shear = 0.5 / (1 + poisson_ratio)
    lame = 2 * shear * poisson_ratio / (1 - 2 * poisson_ratio)
    depths = np.linspace(0.15, 1.0, 35)
    stress = np.zeros((depths.size, 6))
    for row, depth in zip(stress, depths, strict=True):
        end = np.arcsinh(reach / depth)
        w = 0.5 * (nodes + 1) * end[:, None]
        r = depth * np.sinh(w)
        share = np.sqrt(np.maximum(1 - (r / reach[:, None]) ** 2, 0.0))
        force = share * r * depth * np.cosh(w) * 0.5 * weights * end[:, None] * d_angle[:, None]
        x, y = r * np.cos(angle)[:, None], r * np.sin(angle)[:, None]
        _, gradient = boussinesq(np.stack([x, y, np.full(r.shape, depth)], axis=-1), poisson_ratio)
        direct = 2 * shear * np.diagonal(gradient, axis1=-2, axis2=-1)
        direct = direct + lame * direct.sum(-1, keepdims=True) / (2 * shear)
        row[:3] = 4 * (force[..., None] * direct).sum(axis=(0, 1))
    equivalent = von_mises(stress)
    top = int(np.clip(equivalent.argmax(), 1, depths.size - 2))
    low, mid, high = equivalent[top - 1 : top + 2]
    peak = equivalent.max()
    if peak == mid:
        peak = mid - (high - low) ** 2 / (8 * (high - 2 * mid + low))
    share = np.array([slenderness, 1.0]) / (1 + slenderness)
    surface = np.array([*(2 * poisson_ratio + (1 - 2 * poisson_ratio) * share), 1.0, 0, 0, 0])
    return float(1 / max(peak, von_mises(surface)))


@dataclass(frozen=True)
class FlattenedBall:
    """Radius R, E*, nu and Y: of the ball that is flattened, while a << R of the body it dents."""

    radius: float
    effective_modulus: float
    poisson_ratio: float
    yield_stress: float


class Fit:
    """Curves over w = d/d_c.

    `force` and `area` are in units of Hertz's contact at first yield, whose largest pressure is
    `pressure`; `residual` is the depth that remains after unloading from w, in units of d_c. Fitted
    up to w = `largest`; `source` names the paper, and its problem. The ball `yields_at`
    d_c = (pi p0/(2 E*))^2 R.
    """

    def __init__(
        self,
        ball: FlattenedBall,
        pressure: float,
        force: Callable[[Array], Array],
        area: Callable[[Array], Array],
        residual: Callable[[Array], Array] | None,
        largest: float,
        source: str,
    ) -> None:
        self.pressure, self.largest, self.source = pressure, largest, source
        self.force, self.area, self.residual = force, area, residual
        R, E = ball.radius, ball.effective_modulus
        self.yields_at = d = yield_depth(R, E, pressure)
        self.force_unit = float(4 / 3 * E * np.sqrt(R * d) * d)
        self.area_unit = float(np.pi * R * d)


def kogut_etsion(ball: FlattenedBall) -> Fit:
    """Kogut & Etsion (2002), 1 <= w <= 110; unloading by Etsion, Kligerman & Kadin (2005).

    p0 at first yield K H, K = 0.454 + 0.41 nu, H = 2.8 Y (Tabor 1951). Below w = 1 Hertz.

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
        with np.errstate(over="ignore"):  # of what hardly yields, which is out of its range
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


def johnson_restitution(energy: ArrayLike, softness: float) -> Array:
    """Return the coefficient of restitution of a ball in full yield from the first touch.

    F = pi a^2 p with a^2 = 2 R d takes the energy W = pi a^4 p/(4 R), and 3 F^2/(10 E* a) of it is
    given back: e^2 = (6 pi/5) (p/E*) (R/a), 3.7 (Y/E*)^(1/2) (W/(Y R^3))^(-1/8) at p = 3 Y.
    `energy` is W/(Y R^3), `softness` Y/E*.

    >>> round(float(johnson_restitution(1.0, 1e-4)), 4)
    0.0374
    """
    hardness = 3.0  # p/Y
    radius = (4 * np.asarray(energy, dtype=float) / (np.pi * hardness)) ** 0.25
    return np.asarray(np.sqrt(1.2 * np.pi * hardness * softness / radius))
