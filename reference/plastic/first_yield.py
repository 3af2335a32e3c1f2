"""When a half-space first yields: under Hertz's circle and ellipse, below any shape by elements."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from reference.arguments import poisson_faults, refuse
from reference.elasticity import von_mises
from reference.errors import ConvergenceError
from reference.fem.far_field import boussinesq
from reference.plastic.j2 import PlasticMaterial
from reference.plastic.path import Walk

Array = NDArray[np.float64]

_ROUNDS, _TOLERANCE = 30, 1e-4


def yield_pressure(poisson_ratio: float) -> float:
    """Return p0/Y at which a circular Hertzian contact first yields, by von Mises.

    The larger of two stresses counts. On the axis at depth z a the stresses below the pressure p0
    are sigma_z = -p0/(1 + z^2) and
    sigma_r = -p0 [(1 + nu)(1 - z atan(1/z)) - 1/(2 (1 + z^2))] (Johnson 1985, eq. 3.45); the
    largest difference of both lies at z = 0.48 for nu = 0.3. At the edge there is pure shear,
    sigma_r = -sigma_t = (1 - 2 nu) p0/3, von Mises' (1 - 2 nu)/sqrt(3) p0: the larger one below
    nu = -0.4. -1 < nu <= 1/2.

    Examples
    --------
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

    Examples
    --------
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

    Examples
    --------
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
    depths = np.linspace(0.15, 1.0, 35)
    stress = np.array([_central_stress(poisson_ratio, slenderness, z) for z in depths])
    equivalent = von_mises(stress)
    top = int(np.clip(equivalent.argmax(), 1, depths.size - 2))
    low, mid, high = equivalent[top - 1 : top + 2]
    peak = equivalent.max()
    if peak == mid:
        peak = mid - (high - low) ** 2 / (8 * (high - 2 * mid + low))
    share = np.array([slenderness, 1.0]) / (1 + slenderness)
    surface = np.array([*(2 * poisson_ratio + (1 - 2 * poisson_ratio) * share), 1.0, 0, 0, 0])
    return float(1 / max(peak, von_mises(surface)))


def _central_stress(nu: float, slenderness: float, depth: float) -> Array:
    """Return the stress (6) below the centre, b = p0 = 1, on the axis.

    Rays from the centre, under angles that are equally spread after a stretch by the root of the
    ratio of the axes; along them r = depth sinh(w), w by Gauss.
    """
    turn = np.arange(0.5, 64) * np.pi / 128
    long = 1 / slenderness
    root = np.sqrt(long)
    angle = np.arctan2(np.sin(turn), root * np.cos(turn))
    d_angle = root / ((root * np.cos(turn)) ** 2 + np.sin(turn) ** 2) * np.pi / 128
    reach = 1 / np.hypot(np.cos(angle) / long, np.sin(angle))
    nodes, weights = np.polynomial.legendre.leggauss(32)
    end = np.arcsinh(reach / depth)
    w = 0.5 * (nodes + 1) * end[:, None]
    r = depth * np.sinh(w)
    share = np.sqrt(np.maximum(1 - (r / reach[:, None]) ** 2, 0.0))
    force = share * r * depth * np.cosh(w) * 0.5 * weights * end[:, None] * d_angle[:, None]
    points = np.stack(
        [r * np.cos(angle)[:, None], r * np.sin(angle)[:, None], np.full(r.shape, depth)], axis=-1
    )
    _, gradient = boussinesq(points, nu)
    shear = 0.5 / (1 + nu)
    lame = 2 * shear * nu / (1 - 2 * nu)
    direct = 2 * shear * np.diagonal(gradient, axis1=-2, axis2=-1)
    direct = direct + lame * direct.sum(-1, keepdims=True) / (2 * shear)
    total = 4 * (force[..., None] * direct).sum(axis=(0, 1))
    return np.concatenate([total, np.zeros(3)])


def first_yield(
    material: PlasticMaterial,
    shape: Callable[..., Array],
    contact_radius: Callable[[float], float | tuple[float, float]],
    start: float,
    *,
    per_radius: int = 8,
    even: tuple[bool, bool] = (True, True),
) -> float:
    """Return the penetration at which von Mises' stress first reaches the yield stress.

    `shape`, `per_radius` and `even` as for `Walk`; the mesh is made for the `contact_radius` of the
    elastic contact at a penetration, or its half-widths. The search begins at the penetration
    `start`.

    Raises
    ------
    ConvergenceError
        If the stress hardly rises with the penetration, as below a cone.
    """
    modulus = material.elastic.youngs_modulus
    elastic = PlasticMaterial(material.elastic, np.inf)

    def excess(depth: float) -> float:
        walk = Walk(elastic, shape, contact_radius(depth), per_radius=per_radius, even=even)
        state = walk.indentation.press(walk.indentation.virgin, depth / walk.length)
        return float(np.log(von_mises(state.stress).max() * modulus / material.yield_stress))

    here, value, slope = float(np.log(start)), excess(start), 0.5
    for _ in range(_ROUNDS):
        if abs(value) <= _TOLERANCE:
            return float(np.exp(here - value / slope))
        step = float(np.clip(-value / slope, -5.0, 5.0))
        before, value = value, excess(float(np.exp(here + step)))
        here, slope = here + step, (value - before) / step
        if not slope > 0.02:
            raise ConvergenceError("the stress does not rise with the penetration: a sharp tip")
    raise ConvergenceError("the penetration of first yield was not found")
