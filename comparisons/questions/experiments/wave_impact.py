"""Impact of a sphere with radiated waves, and the share of Rayleigh waves in them."""

import math
from dataclasses import dataclass
from typing import Any

from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from reference.arrays import Array
from reference.dynamics.collision import HERTZ_DURATION, radiation_number, speed_ratio
from reference.errors import ConvergenceError


def rayleigh_share(poisson_ratio: float) -> float:
    """Return the fraction of the radiated power in Rayleigh waves.

    It is the residue of Lamb's integrand at the Rayleigh pole over `radiation_number`.

    >>> round(rayleigh_share(0.25), 3)
    0.674
    """
    g2 = speed_ratio(poisson_ratio)

    def rayleigh(k: float) -> float:
        return (2 * k * k - 1) ** 2 - 4 * k * k * math.sqrt((k * k - g2) * (k * k - 1))

    pole = brentq(rayleigh, 1 + 1e-9, 2.0, xtol=1e-15)
    step = 1e-6 * pole
    slope = (rayleigh(pole + step) - rayleigh(pole - step)) / (2 * step)
    residue = math.pi * pole * math.sqrt(pole * pole - g2) / abs(slope)
    return residue / radiation_number(poisson_ratio)


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
