"""Impact of a rigid body of revolution on a viscoelastic half-space, as an initial value problem.

m d'' = -F(t) with F of Lee & Radok on approach and of Ting on rebound (see `hereditary`),
quasi-static: the speed is far below that of sound (19.3). For Maxwell arms the hereditary integrals
are states,

    z_j' = A'(d) d' - z_j/tau_j,   s_j' = d' - s_j/tau_j,

F = G_0 A + sum G_j z_j + eta A' d' on approach (times E*/G); on rebound F follows from the decay of
these z_j, stopped at t1(t), with t1 the root of the force of a spring first touched then. The
contact is lost when that root is the time of first touch.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from reference.closed_form.form import ClosedForm, require_positive
from reference.errors import ConvergenceError
from reference.viscoelastic.hereditary import contact_factor
from reference.viscoelastic.materials import GeneralisedMaxwell

Array = NDArray[np.float64]
Rates = Callable[[float, Array], Array]
Event = Callable[[float, Array], float]

_TOLERANCES = (1e-9, 1e-11)
_SAMPLES = 1000  # of the force per direction; its flat maximum is accurate to 1e-6


@dataclass(frozen=True)
class Rebound:
    """Outcome of an impact.

    `restitution` is the speed after over that before, `duration` the time in contact; `penetration`
    and `force` are the largest. `error` is the difference of the restitution between two
    tolerances of the integration.
    """

    restitution: float
    duration: float
    penetration: float
    force: float
    error: float


def impact(
    form: ClosedForm,
    effective_modulus: float,
    material: GeneralisedMaxwell,
    mass: float,
    velocity: float,
    *,
    poisson_ratio: float = 0.5,
) -> Rebound:
    """Return the impact of a body on the half-space.

    `form` is its elastic contact, axisymmetric, with `effective_modulus`; `material` is that in
    shear, `velocity` the speed at first touch.

    Raises
    ------
    ConvergenceError
        If the body does not rebound; a fluid may keep it for very long.

    Examples
    --------
    >>> from reference.closed_form import paraboloid
    >>> hit = impact(paraboloid(1.0, 1.0), 1.0, GeneralisedMaxwell(0.25), 1.0, 1e-3)
    >>> round(hit.restitution, 8)
    1.0
    """
    require_positive("impact", mass=mass, velocity=velocity, effective_modulus=effective_modulus)
    factor = contact_factor(poisson_ratio)

    def growth(d: float) -> float:
        return factor * float(form.stiffness(max(d, 0.0))) / effective_modulus

    def area(d: float) -> float:
        return factor * float(form.force(max(d, 0.0))) / effective_modulus

    coarse, fine = (
        _collide(material, growth, area, mass, velocity, tolerance) for tolerance in _TOLERANCES
    )
    return Rebound(*fine, error=abs(fine[0] - coarse[0]))


def _collide(
    material: GeneralisedMaxwell,
    growth: Callable[[float], float],
    area: Callable[[float], float],
    mass: float,
    velocity: float,
    tolerance: float,
) -> tuple[float, float, float, float]:
    """Return restitution, duration, largest depth and largest force.

    States are (depth, velocity, s_j, z_j) on approach, and without z_j on rebound.
    """
    moduli, times = material.arm_moduli, material.arm_times
    arms, spring, viscosity = times.size, material.equilibrium_modulus, material.viscosity
    depth = _typical_depth(material, area, mass, velocity)

    def integrate(rates: Rates, begin: float, start: Array, stop: Event) -> Any:
        event: Any = stop  # SciPy reads these attributes of the function
        event.terminal, event.direction = True, -1.0
        scale = np.full(start.size, depth)
        scale[1] = velocity
        scale[2 + arms :] *= growth(depth)
        time = 3 * depth / velocity
        solution = solve_ivp(
            *(rates, (begin, begin + 200 * time), start, "LSODA"),
            rtol=tolerance,
            atol=1e-2 * tolerance * scale,
            max_step=time / 20,
            events=stop,
            dense_output=True,
        )
        if solution.status != 1:
            raise ConvergenceError(f"the body does not come back: {solution.message}")
        return solution

    # approach: Lee & Radok, until the body stands still
    def force_in(state: Array) -> float:
        damping = viscosity * growth(state[0]) * state[1]
        return float(spring * area(state[0]) + moduli @ state[2 + arms :] + damping)

    def rates_in(_: float, state: Array) -> Array:
        speed, strained, loaded = state[1], state[2 : 2 + arms], state[2 + arms :]
        strain_rates = speed - strained / times
        load_rates = speed * growth(state[0]) - loaded / times
        return np.concatenate([[speed, -force_in(state) / mass], strain_rates, load_rates])

    start = np.concatenate([[0.0, velocity], np.zeros(2 * arms)])
    way_in = integrate(rates_in, 0.0, start, lambda _, y: y[1])
    turn, past, turned = float(way_in.t[-1]), way_in.sol, way_in.y[:, -1]

    # rebound: Ting, until a spring of the first touch bears nothing
    def tension(t: float, state: Array, touched: float) -> float:
        """Return the stress of a spring first touched at a time on approach."""
        before = past(touched)
        relaxed = state[2:] - np.exp(-(t - touched) / times) * before[2 : 2 + arms]
        return float(spring * (state[0] - before[0]) + moduli @ relaxed + viscosity * state[1])

    def force_out(t: float, state: Array) -> float:
        if tension(t, state, 0.0) <= 0:
            return 0.0
        touched = turn
        if tension(t, state, turn) < 0:
            touched = brentq(
                lambda at: tension(t, state, at), 0.0, turn, xtol=1e-14 * turn, rtol=1e-14
            )
        then = past(touched)
        decayed = np.exp(-(t - touched) / times) * then[2 + arms :]
        return float(spring * area(then[0]) + moduli @ decayed)

    def rates_out(t: float, state: Array) -> Array:
        acceleration = -force_out(t, state) / mass
        return np.concatenate([[state[1], acceleration], state[1] - state[2:] / times])

    way_out = integrate(rates_out, turn, turned[: 2 + arms], lambda t, y: tension(t, y, 0.0))
    forces = [force_in(past(t)) for t in np.linspace(0, turn, _SAMPLES)]
    forces += [force_out(t, way_out.sol(t)) for t in np.linspace(turn, way_out.t[-1], _SAMPLES)]
    restitution = -float(way_out.y[1, -1]) / velocity
    return restitution, float(way_out.t[-1]), float(turned[0]), max(forces)


def _typical_depth(
    material: GeneralisedMaxwell, area: Callable[[float], float], mass: float, velocity: float
) -> float:
    """Return the depth at which the glassy half-space or its dashpot absorbs the energy."""

    def excess(depth: float) -> float:
        modulus = material.instantaneous_modulus + material.viscosity * velocity / depth
        return modulus * area(depth) * depth / 2 - mass * velocity**2 / 2

    low = high = velocity
    while excess(low) > 0:
        low /= 4
    while excess(high) < 0:
        high *= 4
    return brentq(excess, low, high, xtol=1e-3 * low, rtol=1e-3)
