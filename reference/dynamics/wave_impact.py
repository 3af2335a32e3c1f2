"""Impact of a sphere on a half-space, with radiated waves.

For contacts much smaller than the wavelength, a force F(t) displaces the surface by the static
displacement less a term that is independent of the contact size,

    x = delta(F) - beta dF/dt,   beta = I(nu)/(2 pi G c_s),

the next term of Lamb's solution in powers of (contact radius)/(wavelength). G and c_s are the
shear modulus and the speed of shear waves; int beta (dF/dt)^2 dt is radiated.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq
from scipy.special import beta as beta_function

from reference.errors import ConvergenceError

# Contact time of Hertz's impact in units of delta_max/v: 2 int_0^1 dx/sqrt(1 - x^(5/2)).
HERTZ_DURATION = 0.8 * float(beta_function(0.4, 0.5))


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

    Attributes
    ----------
    radiation : float
        e = beta F_max v/delta_max^2, with values of Hertz's impact: the only parameter.
    energy_lost : float
        Radiated fraction of the kinetic energy.
    restitution : float
        Ratio of the speeds after and before.
    duration, force : float
        Time in contact and largest force over those of Hertz's impact.
    slowness : float
        Largest contact radius over the path of a shear wave in the time delta_max/v, the relative
        order of the neglected terms.
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

    Parameters
    ----------
    speed : float
        v/c0, the initial speed over c0 = sqrt(E/rho) of the half-space; in (0, 0.2].
    poisson_ratio : float
        In [0, 1/2].
    density_ratio : float
        Density of the sphere over that of the half-space.
    elastic_sphere : bool
        A sphere with the moduli of the half-space instead of a rigid one; its vibrations are
        neglected (Rayleigh 1906: they take little energy).

    Examples
    --------
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

    def rates(_: float, state: np.ndarray) -> list[float]:
        return [state[1], -1.25 * force(*state)]

    def parting(_: float, state: np.ndarray) -> float:
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
    return 4.5 * float(beta_function(0.8, 1.5)) * radiation
