"""A rigid mass against an elastic half-space, quasi-static: closed forms and quadrature.

m x'' = -F(x) from x = 0 at the velocity v; F is the static force of a penetration (Hertz 1881; the
neglected waves are in `wave_impact`).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq
from scipy.special import beta, betaincinv

from reference.closed_form.form import ClosedForm, require_positive
from reference.closed_form.numerics import gauss_rule
from reference.closed_form.shapes import power_law
from reference.errors import ConvergenceError

Array = NDArray[np.float64]
Curve = Callable[[Any], Any]


@dataclass(frozen=True)
class Collision:
    """One elastic impact; the rebound is as fast as the approach.

    Attributes
    ----------
    duration : float
        Time in contact.
    penetration, force : float
        Largest penetration, and the corresponding force.
    bar : float
        Relative uncertainty of the duration, from round-off, quadrature, or a measured load curve.
    """

    duration: float
    penetration: float
    force: float
    bar: float


def power_law_collision(
    exponent: float, coefficient: float, effective_modulus: float, mass: float, velocity: float
) -> Collision:
    """Return the impact of a body with the section f = c r^n, in closed form.

    The force is F = C x^((n+1)/n); with p = (2n+1)/n the energy gives x_m^p = p m v^2/(2 C) and the
    duration 2 (x_m/v) int_0^1 du/sqrt(1 - u^p) = 2 (x_m/v) B(1/p, 1/2)/p. For n = 2 (a paraboloid,
    c = 1/(2 R)) the integral is that of Hertz and Deresiewicz, 2.9432 x_m/v (Hertz 1881;
    Deresiewicz, Acta Mech. 6 (1968) 110; Johnson 1985, (11.21)-(11.24); other n: Galin's static
    law).

    >>> hertz = power_law_collision(2, 0.5, 1.0, 1.0, 1.0)
    >>> round(hertz.duration / hertz.penetration, 4)
    2.9433
    """
    require_positive("collision", mass=mass, velocity=velocity)
    form = power_law(exponent, coefficient, effective_modulus)
    p = 2 + 1 / exponent
    unit = 2.0 ** round(math.log2(_stopping_depth(form, 0.5 * mass * velocity**2)))
    scale = float(form.energy(unit))
    depth = unit * (0.5 * mass * velocity**2 / scale) ** (1 / p)
    duration = 2 * depth / velocity * float(beta(1 / p, 0.5)) / p
    return Collision(duration, depth, float(form.force(depth)), 1e-14)


def power_law_motion(exponent: float, collision: Collision, times: ArrayLike) -> np.ndarray:
    """Return x(t) of that impact: u = x/x_m solves I(u^p; 1/p, 1/2) = 2 t/T.

    I is the regularised incomplete beta function: Deresiewicz's integral, inverted. For times in
    [0, T]; the second half is symmetric to the first.
    """
    t = np.asarray(times, float)
    if not ((t >= 0) & (t <= collision.duration)).all():
        raise ValueError(f"times must lie in [0, {collision.duration!r}], not {times!r}")
    p = 2 + 1 / exponent
    early = np.minimum(t, collision.duration - t) / (collision.duration / 2)
    return collision.penetration * betaincinv(1 / p, 0.5, early) ** (1 / p)


def collide(form: ClosedForm, mass: float, velocity: float) -> Collision:
    """Return the impact of a body with a closed-form static contact, by quadrature.

    >>> from reference.closed_form import cylinder
    >>> disc = collide(cylinder(0.5, 1.0), 1.0, 0.1)  # a linear spring: half a period
    >>> round(disc.duration / math.pi, 12)
    1.0
    """
    require_positive("collision", mass=mass, velocity=velocity)
    depth = _stopping_depth(form, 0.5 * mass * velocity**2)
    return _by_quadrature(form.force, form.energy, mass, depth)


def collide_curve(
    penetration: ArrayLike, force: ArrayLike, mass: float, velocity: float, bar: float = 0.0
) -> Collision:
    """Return the impact on a contact with a computed static load curve.

    log F is interpolated against log d (monotone cubics), below the first point by the power law
    through the first two; the error is estimated by leaving out every second point.

    Parameters
    ----------
    penetration, force : array_like, shape (k,)
        Increasing, at least four points, up to a depth that stops the mass, else ValueError.
    mass, velocity : float
        m and v.
    bar : float
        Relative uncertainty of the forces; half of it enters the duration (T ~ F^(-1/2) at equal
        depth).
    """
    require_positive("collision", mass=mass, velocity=velocity)
    d, F = np.asarray(penetration, float), np.asarray(force, float)
    if d.ndim != 1 or d.size < 4 or d.shape != F.shape or not (np.diff(d) > 0).all():
        raise ValueError("expected at least four increasing penetrations and as many forces")
    full = _collide_points(d, F, mass, velocity)
    coarse = _collide_points(d[::-2][::-1], F[::-2][::-1], mass, velocity)
    refinement = abs(coarse.duration / full.duration - 1)
    return Collision(
        full.duration, full.penetration, full.force, max(full.bar, refinement) + bar / 2
    )


def _collide_points(d: Array, F: Array, mass: float, velocity: float) -> Collision:
    """Return the impact on the interpolated curve, with energies by integration."""
    unit, size = d[-1], F[-1]
    curve = PchipInterpolator(np.log(d / unit), np.log(F / size))
    start, slope = math.log(d[0] / unit), float(curve.derivative()(math.log(d[0] / unit)))

    def force(x: Any) -> Any:
        place = np.log(np.maximum(np.asarray(x, float) / unit, 1e-300))
        inside = curve(np.maximum(place, start)) + slope * np.minimum(place - start, 0)
        return size * np.exp(inside)

    grid = np.concatenate([[0.0], np.geomspace(1e-6, 1, 400)]) * unit
    stored = np.concatenate([[0.0], np.cumsum(_integral(force, grid[:-1], np.diff(grid)))])

    def energy(at: Any) -> Any:
        at = np.asarray(at, float)
        k = np.clip(np.searchsorted(grid, at, side="right") - 1, 0, grid.size - 2)
        return stored[k] + _integral(force, grid[k], at - grid[k])

    kinetic = 0.5 * mass * velocity**2
    if stored[-1] < kinetic:
        raise ValueError(f"the load curve ends at {unit!r}, before it stops the mass")
    depth = unit * brentq(lambda s: float(energy(s * unit)) / kinetic - 1, 0, 1, xtol=1e-15)
    return _by_quadrature(force, energy, mass, depth)


def _integral(force: Curve, low: Array, way: Array) -> Array:
    """Integrate a force over intervals, by 8 Gauss points each."""
    nodes, weights = gauss_rule(8)
    x = low[..., None] + way[..., None] * ((nodes + 1) / 2)
    return (np.asarray(force(x)) @ (weights / 2)) * way


def _stopping_depth(form: ClosedForm, kinetic: float) -> float:
    """Solve U(d) = m v^2/2, first by halving and doubling; a shape may end (a sphere at R)."""

    def excess(d: float) -> float:
        try:
            return float(form.energy(d)) / kinetic - 1
        except ValueError:  # deeper than valid for the shape
            return math.inf

    low, searches = 1.0, 2000
    for _ in range(searches):
        if excess(low) <= 0:
            break
        low /= 16
    high = low
    for _ in range(searches):
        if excess(high) >= 0:
            break
        high *= 16
    if math.isinf(excess(high)):
        # the largest depth valid for the shape, by bisection
        inside = high / 16
        for _ in range(60):
            middle = 0.5 * (inside + high)
            inside, high = (inside, middle) if math.isinf(excess(middle)) else (middle, high)
        high = inside
    if not excess(low) <= 0 <= excess(high):
        raise ConvergenceError(f"{form.name}: the contact does not stop the mass", [low, high])
    return brentq(excess, low, high, xtol=1e-15 * high, rtol=1e-15)


def work(force: Curve, energy: Curve, low: ArrayLike, high: ArrayLike) -> Array:
    """Return the energy stored between two penetrations, without cancellation; elementwise.

    It is a difference of energies or, if digits would be lost, an integral of the force over an
    interval short enough for it to be smooth.
    """
    low, high = np.broadcast_arrays(np.asarray(low, float), np.asarray(high, float))
    way = high - low
    stored, far = np.array(_integral(force, low, way)), np.asarray(way > 0.1 * high)
    if far.any():
        stored[far] = np.asarray(energy(high[far])) - np.asarray(energy(low[far]))
    return stored


def _by_quadrature(force: Curve, energy: Curve, mass: float, depth: float) -> Collision:
    """Return T = 2 int_0^d dx/w, m w^2/2 = U(d) - U(x), by x = d (1 - s^2), smooth at the turn.

    At first touch, s = 1, the power law depends on the shape: panels halve towards it. The bar is
    the change for fewer nodes.
    """
    ends = np.concatenate([[0.0], 1 - 0.5 ** np.arange(1, 20), [1.0]])

    def half(order: int) -> float:
        nodes, weights = gauss_rule(order)
        s = ends[:-1, None] + np.diff(ends)[:, None] * (nodes + 1) / 2
        released = work(force, energy, depth * (1 - s) * (1 + s), depth)
        rate = 2 * depth * s / np.sqrt(2 / mass * released)
        return float(np.diff(ends) / 2 @ (rate @ weights))

    time = half(16)
    bar = abs(half(12) / time - 1)
    return Collision(2 * time, depth, float(force(depth)), max(bar, 1e-13))
