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

_TOLERANCES = (1e-9, 1e-11)
_SAMPLES = 1000  # of the force per direction; its flat maximum is accurate to 1e-6


@dataclass(frozen=True)
class Impact:
    """Outcome of an impact.

    Attributes
    ----------
    restitution : float
        Speed after over speed before.
    duration, penetration, force : float
        Time in contact, largest depth and largest force.
    error : float
        Difference of the restitution between two tolerances of the integration.
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
) -> Impact:
    """Return the impact of a body on the half-space.

    Parameters
    ----------
    form : ClosedForm
        Elastic contact of the body, axisymmetric, with `effective_modulus`.
    material : GeneralisedMaxwell
        In shear.
    mass, velocity : float
        m and the speed v > 0 at first touch.
    poisson_ratio : float

    Raises
    ------
    ValueError
        For arguments out of range.
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
        _Collision(material, growth, area, mass, velocity, tolerance).run()
        for tolerance in _TOLERANCES
    )
    return Impact(*fine, error=abs(fine[0] - coarse[0]))


class _Collision:
    """One integration: states (depth, velocity, s_j, z_j) on approach, without z_j on rebound."""

    def __init__(
        self,
        material: GeneralisedMaxwell,
        growth: Callable[[float], float],
        area: Callable[[float], float],
        mass: float,
        velocity: float,
        tolerance: float,
    ) -> None:
        self._material, self._growth, self._area = material, growth, area
        self._mass, self._velocity, self._tolerance = mass, velocity, tolerance
        self._moduli, self._times = material.arm_moduli, material.arm_times
        self._depth = self._typical_depth()

    def run(self) -> tuple[float, float, float, float]:
        """Return restitution, duration, largest depth and largest force."""
        arms = self._times.size
        start = np.concatenate([[0.0, self._velocity], np.zeros(2 * arms)])
        way_in = self._integrate(self._rates_in, 0.0, start, lambda _, y: y[1])
        self._turn, self._past = float(way_in.t[-1]), way_in.sol
        turned = way_in.y[:, -1]
        way_out = self._integrate(
            self._rates_out, self._turn, turned[: 2 + arms], lambda t, y: self._load_out(t, y, 0.0)
        )
        forces = [self._force_in(self._past(t)) for t in np.linspace(0, self._turn, _SAMPLES)]
        later = np.linspace(self._turn, way_out.t[-1], _SAMPLES)
        forces += [self._force_out(t, way_out.sol(t)) for t in later]
        restitution = -float(way_out.y[1, -1]) / self._velocity
        return restitution, float(way_out.t[-1]), float(turned[0]), max(forces)

    def _rates_in(self, _: float, state: Array) -> Array:
        arms = self._times.size
        strained, loaded = state[2 : 2 + arms], state[2 + arms :]
        speed = state[1]
        return np.concatenate(
            [
                [speed, -self._force_in(state) / self._mass],
                speed - strained / self._times,
                speed * self._growth(state[0]) - loaded / self._times,
            ]
        )

    def _force_in(self, state: Array) -> float:
        material, loaded = self._material, state[2 + self._times.size :]
        damping = material.viscosity * self._growth(state[0]) * state[1]
        spring = material.equilibrium_modulus * self._area(state[0])
        return float(spring + self._moduli @ loaded + damping)

    def _rates_out(self, t: float, state: Array) -> Array:
        acceleration = -self._force_out(t, state) / self._mass
        return np.concatenate([[state[1], acceleration], state[1] - state[2:] / self._times])

    def _load_out(self, t: float, state: Array, touched: float) -> float:
        """Return the stress of a spring first touched at a time on approach."""
        material, before = self._material, self._past(touched)
        decay = np.exp(-(t - touched) / self._times)
        arms = state[2:] - decay * before[2 : 2 + self._times.size]
        spring = material.equilibrium_modulus * (state[0] - before[0])
        return float(spring + self._moduli @ arms + material.viscosity * state[1])

    def _force_out(self, t: float, state: Array) -> float:
        """Return the force of the contact at t1(t)."""

        def tension(touched: float) -> float:
            return self._load_out(t, state, touched)

        if tension(0.0) <= 0:
            return 0.0
        touched = self._turn
        if tension(self._turn) < 0:
            touched = brentq(tension, 0.0, self._turn, xtol=1e-14 * self._turn, rtol=1e-14)
        then = self._past(touched)
        decayed = np.exp(-(t - touched) / self._times) * then[2 + self._times.size :]
        spring = self._material.equilibrium_modulus * self._area(then[0])
        return float(spring + self._moduli @ decayed)

    def _integrate(
        self,
        rates: Callable[[float, Array], Array],
        begin: float,
        start: Array,
        stop: Callable[[float, Array], float],
    ) -> Any:
        """Integrate up to the event, with tolerances relative to the scales of the impact."""
        event: Any = stop  # SciPy reads these attributes of the function
        event.terminal, event.direction = True, -1.0
        arms, depth = self._times.size, self._depth
        scale = np.full(start.size, depth)
        scale[1] = self._velocity
        scale[2 + arms :] *= self._growth(depth)
        time = 3 * depth / self._velocity
        solution = solve_ivp(
            *(rates, (begin, begin + 200 * time), start, "LSODA"),
            rtol=self._tolerance,
            atol=1e-2 * self._tolerance * scale,
            max_step=time / 20,
            events=stop,
            dense_output=True,
        )
        if solution.status != 1:
            raise ConvergenceError(f"the body does not come back: {solution.message}")
        return solution

    def _typical_depth(self) -> float:
        """Return the depth at which the glassy half-space or its dashpot absorbs the energy."""
        material, energy = self._material, self._mass * self._velocity**2 / 2

        def excess(depth: float) -> float:
            modulus = material.instantaneous_modulus + material.viscosity * self._velocity / depth
            return modulus * self._area(depth) * depth / 2 - energy

        low = high = self._velocity
        while excess(low) > 0:
            low /= 4
        while excess(high) < 0:
            high *= 4
        return brentq(excess, low, high, xtol=1e-3 * low, rtol=1e-3)
