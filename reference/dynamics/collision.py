"""A rigid mass against an elastic half-space: quasi-static, and with radiated waves.

Quasi-static is m x'' = -F(x) from x = 0 at the velocity v, F the static force of a penetration
(Hertz 1881), in closed form or by quadrature.

For contacts much smaller than the wavelength, a force F(t) displaces the surface by the static
displacement less a term that is independent of the contact size,

    x = delta(F) - beta dF/dt,   beta = I(nu)/(2 pi G c_s),

the next term of Lamb's solution in powers of (contact radius)/(wavelength). G and c_s are the
shear modulus and the speed of shear waves; int beta (dF/dt)^2 dt is radiated.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
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
    g2 = _speed_ratio(poisson_ratio)

    def missing(k: float) -> float:
        a, b = math.sqrt(k * k + g2), math.sqrt(k * k + 1)
        sum_of_both = (2 * k * k + 1) ** 2 + 4 * k * k * a * b
        product = 16 * (1 - g2) * k**6 + (24 - 16 * g2) * k**4 + 8 * k * k + 1
        return 1 - poisson_ratio - k * a * sum_of_both / product

    near = quad(missing, 0, 1, epsabs=0, epsrel=1e-11)[0]
    # k = 1/t: the integrand decreases as 1/k^2
    far = quad(lambda t: missing(1 / t) / t**2, 1e-5, 1, epsabs=0, epsrel=1e-9, limit=200)[0]
    return near + far + missing(1e5) * 1e5


def rayleigh_share(poisson_ratio: float) -> float:
    """Return the fraction of the radiated power in Rayleigh waves.

    It is the residue of Lamb's integrand at the Rayleigh pole over `radiation_number`.

    >>> round(rayleigh_share(0.25), 3)
    0.674
    """
    g2 = _speed_ratio(poisson_ratio)

    def rayleigh(k: float) -> float:
        return (2 * k * k - 1) ** 2 - 4 * k * k * math.sqrt((k * k - g2) * (k * k - 1))

    pole = brentq(rayleigh, 1 + 1e-9, 2.0, xtol=1e-15)
    step = 1e-6 * pole
    slope = (rayleigh(pole + step) - rayleigh(pole - step)) / (2 * step)
    residue = math.pi * pole * math.sqrt(pole * pole - g2) / abs(slope)
    return residue / radiation_number(poisson_ratio)


def _speed_ratio(poisson_ratio: float) -> float:
    """Return (c_s/c_p)^2."""
    if not 0 <= poisson_ratio <= 0.5:
        raise ValueError(f"poisson_ratio must lie in [0, 1/2], got {poisson_ratio!r}")
    return (1 - 2 * poisson_ratio) / (2 * (1 - poisson_ratio))


@dataclass(frozen=True)
class WaveImpact:
    """Impact with radiation relative to Hertz's impact without (Johnson 1985, 11.4).

    `radiation` is e = beta F_max v/delta_max^2, with values of Hertz's impact: the only parameter.
    `energy_lost` is the radiated fraction of the kinetic energy; duration and largest force are
    over those of Hertz's impact. `slowness`, the largest contact radius over the path of a shear
    wave in the time delta_max/v, is the relative order of the neglected terms.
    """

    radiation: float
    energy_lost: float
    restitution: float
    duration: float
    force: float
    slowness: float


def wave_impact(
    speed: float,
    poisson_ratio: float = 0.3,
    density_ratio: float = 1.0,
    elastic_sphere: bool = False,
) -> WaveImpact:
    """Return the impact of a sphere on an elastic half-space.

    x'' = -(5/4) f, f = (x + e d(x^(3/2))/dt)^(3/2), until the rebound, in units of Hertz's largest
    depth, force and the time delta_max/v. The rate of the force is expressed by x, to the order of
    the expansion, because x = f^(2/3) - e f' has runaway solutions, like every radiation reaction.

    The speed is v/c0, over c0 = sqrt(E/rho) of the half-space, in (0, 0.2]; nu in [0, 1/2];
    `density_ratio` is that of the sphere over the half-space. An elastic sphere has the moduli of
    the half-space; its vibrations are neglected (Rayleigh 1906: they take little energy).

    >>> slow, fast = wave_impact(1e-4), wave_impact(1e-2)
    >>> round(math.log(fast.energy_lost / slow.energy_lost) / math.log(100), 2)  # Hunter: 3/5
    0.58
    """
    number = radiation_number(poisson_ratio)
    if not (0 < speed <= 0.2 and density_ratio > 0 and math.isfinite(density_ratio)):
        raise ValueError(
            "expected 0 < speed <= 0.2 and a positive density_ratio, "
            f"got {speed!r} and {density_ratio!r}"
        )
    # Hertz's impact, in units R = E = rho = 1, so that c0 = 1
    modulus = 1 / (1 - poisson_ratio**2) / (2 if elastic_sphere else 1)
    shear = 0.5 / (1 + poisson_ratio)
    mass = 4 / 3 * math.pi * density_ratio
    depth = (15 / 16 * mass * speed**2 / modulus) ** 0.4
    largest = 4 / 3 * modulus * depth**1.5
    wave = math.sqrt(shear)
    radiation = number / (2 * math.pi * shear * wave) * largest * speed / depth**2

    def force(x: float, velocity: float) -> float:
        root = math.sqrt(max(x, 0.0))
        return max(root * (root + 1.5 * radiation * velocity), 0.0) ** 1.5

    def rates(_: float, state: Array) -> list[float]:
        return [state[1], -1.25 * force(*state)]

    def parting(_: float, state: Array) -> float:
        return math.sqrt(max(state[0], 0.0)) + 1.5 * radiation * state[1]

    event: Any = parting  # SciPy reads these attributes of the function
    event.terminal, event.direction = True, -1.0
    solution = solve_ivp(
        *(rates, (0.0, 50.0), [0.0, 1.0]),
        method="DOP853",
        rtol=1e-10,
        atol=1e-12,
        max_step=0.05,
        events=parting,
    )
    if solution.status != 1:
        raise ConvergenceError(f"the sphere stayed in contact: {solution.message}")
    rebound = -float(solution.y[1, -1])
    return WaveImpact(
        radiation=radiation,
        energy_lost=1 - rebound**2,
        restitution=rebound,
        duration=float(solution.t[-1]) / HERTZ_DURATION,
        force=float(max(force(*state) for state in solution.y.T)),
        slowness=math.sqrt(depth) * speed / (wave * depth),
    )


def weak_loss(radiation: float) -> float:
    """Return the energy lost to first order in e: 2 (5/4) e int f'^2 dt over Hertz's impact.

    With f = x^(3/2), x'^2 = 1 - x^(5/2): (9/2) B(4/5, 3/2) e.
    """
    return 4.5 * float(beta(0.8, 1.5)) * radiation
