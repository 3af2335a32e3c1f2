"""When a half-space first yields: below any shape by finite elements, under Hertz's ellipse."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from reference.arguments import poisson_faults, refuse
from reference.elasticity import von_mises
from reference.errors import ConvergenceError
from reference.fem.far_field import boussinesq
from reference.plastic.materials import PlasticMaterial
from reference.plastic.path import below

Array = NDArray[np.float64]

_ROUNDS, _TOLERANCE = 30, 1e-4


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

    Parameters
    ----------
    material : PlasticMaterial
    shape : callable
        The gap at first touch, f(r) or f(x, y).
    contact_radius : callable
        Of the elastic contact at a penetration, or its half-widths: the mesh is made for it.
    start : float
        A penetration from which the search starts.
    per_radius : int
        Elements per contact radius.
    even : (bool, bool)
        Whether x = 0, and y = 0, is a plane of symmetry of f(x, y).

    Raises
    ------
    ConvergenceError
        If the stress hardly rises with the penetration, as below a cone.
    """
    modulus = material.elastic.youngs_modulus
    elastic = PlasticMaterial(material.elastic, np.inf)

    def excess(depth: float) -> float:
        body, length = below(
            elastic, shape, contact_radius(depth), per_radius=per_radius, even=even
        )
        state = body.press(body.virgin, depth / length)
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


def elliptic_yield_pressure(poisson_ratio: float, slenderness: float) -> float:
    """Return p0/Y at which an elliptic Hertzian contact first yields, by von Mises.

    The larger of two stresses on the axis counts: below the surface, from the point-force solution
    (Johnson 1985, eq. 3.18) integrated over p0 sqrt(1 - x^2/a^2 - y^2/b^2); and at the surface,
    sigma_x = -p0 [2 nu + (1 - 2 nu) b/(a + b)], sigma_y with a in place of b (ib., eq. 4.28), which
    is the larger one below slender ellipses of a small nu. The rim stays below both.

    Parameters
    ----------
    poisson_ratio : float
        From 0 to below 1/2.
    slenderness : float
        b/a, from 0.001 to 1.

    Raises
    ------
    ValueError
        Outside these.

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
