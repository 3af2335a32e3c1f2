"""A rigid mass against an elastic half-space: impacts, the course in time, radiated waves.

Quasi-static is m x'' = -F(x) from x = 0 at the velocity v, F the static force of a penetration
(Hertz 1881), in closed form or by quadrature.

For contacts much smaller than the wavelength, a force F(t) displaces the surface by the static
displacement less a term that is independent of the contact size,

    x = delta(F) - beta dF/dt,   beta = I(nu)/(2 pi G c_s),

the next term of Lamb's solution in powers of (contact radius)/(wavelength). G and c_s are the
shear modulus and the speed of shear waves; int beta (dF/dt)^2 dt is radiated.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import quad, solve_ivp
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq
from scipy.special import beta

from reference.arrays import Array
from reference.closed_form.form import ClosedForm, require_positive
from reference.closed_form.numerics import gauss_rule
from reference.closed_form.shapes import power_law
from reference.errors import ConvergenceError

Curve = Callable[[Any], Any]
Rates = Callable[[float, Array], Sequence[float]]

_MOST_TOUCHES = 10_000

# Contact time of Hertz's impact in units of delta_max/v: 2 int_0^1 dx/sqrt(1 - x^(5/2)).
HERTZ_DURATION = 0.8 * float(beta(0.4, 0.5))


@dataclass(frozen=True)
class Collision:
    """One elastic impact: time in contact, largest penetration and force.

    `bar` is the relative uncertainty of the duration, from round-off, quadrature, or a measured
    load curve.
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
    through the first two; the error is estimated by leaving out every second point. Half of `bar`,
    the relative uncertainty of the forces, enters the duration (T ~ F^(-1/2) at equal depth).
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
        return float(form.energy(d)) / kinetic - 1

    low = min(1.0, form.limit)
    while excess(low) > 0:
        low /= 16
    high = low
    while excess(high) < 0:
        if high == form.limit or high > 1e300:
            raise ConvergenceError(f"{form.name}: the contact does not stop the mass", [low, high])
        high = min(16 * high, form.limit)
    return brentq(excess, low, high, xtol=1e-15 * high, rtol=1e-15)


def work(force: Curve, energy: Curve, low: ArrayLike, high: ArrayLike) -> Array:
    """Return the energy stored between two penetrations, elementwise.

    It is a difference of energies or, if digits would be lost, an integral of the force.
    """
    low, high = np.broadcast_arrays(np.asarray(low, float), np.asarray(high, float))
    way = high - low
    stored, far = np.array(_integral(force, low, way)), np.asarray(way > 0.1 * high)
    if far.any():
        stored[far] = np.asarray(energy(high[far])) - np.asarray(energy(low[far]))
    return stored


def _by_quadrature(force: Curve, energy: Curve, mass: float, depth: float) -> Collision:
    """Return T = 2 int_0^d dx/w, m w^2/2 = U(d) - U(x), by x = d (1 - s^2), smooth at the turn.

    Panels halve towards first touch, s = 1. The bar is the change for fewer nodes.
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


def through_touches(
    rates: Rates,
    span: tuple[float, float],
    state: Array,
    tolerance: float,
    times: Array,
    out: Array,
) -> Array:
    """Integrate y' = rates(t, y), y = (x, x'), restarting at every zero of x; return the end.

    There the force is not smooth. All numbers are of order one, so the tolerance is relative and
    absolute. The states at those of the `times` that lie in the span go to `out`.
    """

    def touching(_: float, y: Array) -> float:
        return y[0]

    touching.terminal = True  # type: ignore[attr-defined]
    start, end = span
    for _ in range(_MOST_TOUCHES):
        run = solve_ivp(
            *(rates, (start, end), state),
            method="DOP853",
            rtol=tolerance,
            atol=tolerance,
            events=touching,
            dense_output=True,
        )
        if run.status < 0:
            raise ConvergenceError(f"the motion could not be integrated: {run.message}")
        inside = (times >= start) & (times <= run.t[-1])
        if inside.any():
            out[:, inside] = run.sol(times[inside])
        start, state = float(run.t[-1]), run.y[:, -1]
        if run.status == 1:
            # slightly beyond the surface, so that the same crossing is not detected again
            state = np.array([np.copysign(tolerance, state[1]), state[1]])
        if not start < end:
            return state
    raise ConvergenceError(f"the mass touched {_MOST_TOUCHES} times before the end", [start])


def course(
    form: ClosedForm,
    mass: float,
    velocity: float,
    times: ArrayLike,
    history: tuple[ArrayLike, ArrayLike] | None = None,
) -> tuple[Array, Array]:
    """Return x and x' at given times of m x'' = f(t) - F(x), x = 0 and x' = v >= 0 at t = 0.

    Velocity or force must move the mass; times increase, from 0 on. `history` is increasing times
    and the force f there, linear in between, constant outside.

    >>> from reference.closed_form import cylinder
    >>> x, v = course(cylinder(0.5, 1.0), 1.0, 1.0, [0.5 * np.pi, np.pi + 1])  # k = m = 1
    >>> np.round(x, 8)
    array([ 1., -1.])
    """
    require_positive("course", mass=mass)
    instants = np.atleast_1d(np.asarray(times, float))
    knots, forces = (np.atleast_1d(np.asarray(y, float)) for y in history or (0.0, 0.0))
    if not (velocity >= 0 and instants[0] >= 0 and (np.diff(instants) > 0).all()):
        raise ValueError("expected velocity >= 0 and times that increase from 0 on")
    if knots.shape != forces.shape or not (np.diff(knots) > 0).all():
        raise ValueError("expected a history of increasing times with a force for each")
    most, kinetic = float(np.abs(forces).max()), 0.5 * mass * velocity**2
    if not (velocity > 0 or most > 0):
        raise ValueError("expected a velocity or a force that moves the mass")

    def stops(d: float) -> bool:
        try:
            return bool(form.energy(d) - most * d >= kinetic)
        except ValueError:  # deeper than the shape's theory goes
            return True

    # units: the largest power of two at which the mass is not yet stopped, and the time to there
    depth, tolerance = 1.0, 1e-10
    while stops(depth):
        depth /= 2
    while not stops(depth):
        depth *= 2
    depth /= 2
    slowness = mass * depth / (most + float(form.force(depth)))
    unit = min(float(np.sqrt(slowness)), float(instants[-1]))
    strength = mass * depth / unit**2

    def rates(t: float, y: Array) -> list[float]:
        push = float(np.interp(t * unit, knots, forces))
        reaction = float(form.force(y[0] * depth)) if y[0] > 0 else 0.0
        return [y[1], (push - reaction) / strength]

    inner = knots[(knots > 0) & (knots < instants[-1])] / unit
    ends = np.unique([0.0, *inner, instants[-1] / unit])
    state, states = np.array([tolerance, velocity * unit / depth]), np.empty((2, instants.size))
    for span in pairwise(ends):
        state = through_touches(rates, span, state, tolerance, instants / unit, states)
    return states[0] * depth, states[1] * depth / unit


def radiation_number(poisson_ratio: float) -> float:
    r"""Return I(nu) of beta = I/(2 pi G c_s), for 0 <= nu <= 1/2.

    From Lamb's problem (Phil. Trans. R. Soc. A 203 (1904) 1) in the Laplace domain, without
    singularities: under a point force F exp(s t) the surface displacement is

        u = F/(2 pi G) int k a(k)/R(k) J0(k r) dk * (s/c_s),  a^2 = k^2 + g^2,  b^2 = k^2 + 1,
        R = (2 k^2 + 1)^2 - 4 k^2 a b,  g = c_s/c_p,

    k in units of s/c_s. The integrand tends to 1 - nu, the static solution F (1 - nu)/(2 pi G r);
    I = int_0^inf (1 - nu - k a/R) dk is the difference at r = 0. R is rationalised to avoid
    cancellation. The power radiated by an oscillating force, (1/2) beta omega^2 F^2, is that of
    Miller and Pursey (Proc. R. Soc. A 233 (1955) 55): 67 % of it in Rayleigh waves at nu = 1/4.
    """
    g2 = speed_ratio(poisson_ratio)

    def missing(k: float) -> float:
        a, b = math.sqrt(k * k + g2), math.sqrt(k * k + 1)
        sum_of_both = (2 * k * k + 1) ** 2 + 4 * k * k * a * b
        product = 16 * (1 - g2) * k**6 + (24 - 16 * g2) * k**4 + 8 * k * k + 1
        return 1 - poisson_ratio - k * a * sum_of_both / product

    near = quad(missing, 0, 1, epsabs=0, epsrel=1e-11)[0]
    # k = 1/t: the integrand decreases as 1/k^2
    far = quad(lambda t: missing(1 / t) / t**2, 1e-5, 1, epsabs=0, epsrel=1e-9, limit=200)[0]
    return near + far + missing(1e5) * 1e5


def speed_ratio(poisson_ratio: float) -> float:
    """Return (c_s/c_p)^2."""
    if not 0 <= poisson_ratio <= 0.5:
        raise ValueError(f"poisson_ratio must lie in [0, 1/2], got {poisson_ratio!r}")
    return (1 - 2 * poisson_ratio) / (2 * (1 - poisson_ratio))


def weak_loss(radiation: float) -> float:
    """Return the energy lost to first order in e: 2 (5/4) e int f'^2 dt over Hertz's impact.

    With f = x^(3/2), x'^2 = 1 - x^(5/2): (9/2) B(4/5, 3/2) e.
    """
    return 4.5 * float(beta(0.8, 1.5)) * radiation
