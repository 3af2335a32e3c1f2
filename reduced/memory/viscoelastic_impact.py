"""Impact of a rigid mass on viscoelastic springs (19.3): the coefficient of restitution.

The contact has no mass and responds instantly (19.3 (a)), so the equation of motion is m d'' = -F
with F the force of the row of springs, including their history.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reduced.arguments import count_faults, positive_faults, refuse
from reduced.errors import ConvergenceError
from reduced.loads import Load
from reduced.memory.row import RelaxingSprings
from reduced.springs.indent import indent
from reduced.springs.line import Springs

_ITERATIONS = 60
_LONGEST = 200  # longest contact in units of the elastic contact time
_ROUNDING = 4 * np.finfo(float).eps


@dataclass(frozen=True)
class ViscoelasticImpact:
    """Motion of the body from first touch to loss of contact.

    `restitution` is the ratio of the speeds after and before, `duration` the time in contact; the
    motion has shape (k,), velocities are positive inwards.
    """

    restitution: float
    duration: float
    time: np.ndarray
    penetration: np.ndarray
    velocity: np.ndarray
    force: np.ndarray


def impact(
    springs: RelaxingSprings, mass: float, velocity: float, steps: int = 200
) -> ViscoelasticImpact:
    """Solve the impact of a rigid mass on springs, without weight.

    In a step the depth is linear with the velocity V, so that the springs are exact; V follows from
    the force in the middle of the step, m (2 V - 2 v) = -F dt (implicit midpoint rule: second
    order, stable at any step, also with a parallel dashpot). The last step ends when the last
    spring loses contact. The speed at first touch is far below that of sound; there are `steps` in
    three times d/v, about the duration of an elastic impact, d the depth estimated from the energy,
    to which `per_radius` refers.

    Raises ConvergenceError if the body does not rebound within 200 times the elastic duration.

    Examples
    --------
    >>> from reduced.profiles.equivalents import paraboloid
    >>> from reduced.memory.materials import prony
    >>> elastic = RelaxingSprings(paraboloid(1.0), prony(1.0))
    >>> round(impact(elastic, 1.0, 1e-3).restitution, 5)
    1.0
    """
    refuse(positive_faults(mass=mass, velocity=velocity) + count_faults(steps=steps))
    law = springs.modulus

    def work(depth: float) -> float:
        """Return the energy at a depth, with the modulus of a ramp of duration d/v."""
        time = depth / velocity
        modulus = law.long_term + float(law.advance(time)[1].sum()) + law.viscosity / time
        pressed = indent(Springs(springs.profile, 1.0), Load("penetration", [depth]))
        return modulus * float(pressed.energy[0])

    # the depth that stores the kinetic energy, to 1 %
    energy = mass * velocity**2 / 2
    low = depth = springs.profile.length
    while work(depth) < energy:
        depth *= 4
    while work(low) > energy:
        low /= 4
    while depth > 1.01 * low:
        middle = float(np.sqrt(low * depth))
        low, depth = (middle, depth) if work(middle) < energy else (low, middle)
    row, speed = springs.lay(depth), velocity
    path = [(0.0, 0.0, velocity, 0.0)]

    def mean_velocity(duration: float) -> float:
        """Return V of a step, by Newton's method on 2 m (V - v) + dt F(V) in a bracket."""
        half, slope = duration / 2, speed
        stiffness = law.long_term + float(law.advance(half)[1].sum())
        low, high, history = -np.inf, np.inf, []
        for _ in range(_ITERATIONS):
            force, length, _ = row.trial(row.depth + slope * half, half)
            excess = slope - speed + force * half / mass
            low, high = (slope, high) if excess < 0 else (low, slope)
            # d(force)/dV: springs follow the depth V dt/2, dashpots V
            rise = length * (stiffness * half + law.viscosity) * half / mass
            change = -excess / (1 + rise)
            if not low <= slope + change <= high:
                change = (low + high) / 2 - slope
            slope += change
            history.append(abs(change))
            if abs(change) <= _ROUNDING * abs(speed) or high - low <= _ROUNDING * abs(high):
                return slope
        if history[-1] <= 1e-9 * abs(speed):
            return slope
        raise ConvergenceError("no velocity balances the force of the springs", history)

    def leaves(slope: float, duration: float) -> bool:
        length = row.trial(row.depth + slope * duration, duration)[1]
        return slope < 0 and length == 0

    step = 3 * depth / velocity / steps
    for _ in range(_LONGEST * steps):
        duration, slope = step, mean_velocity(step)
        lost = leaves(slope, duration)
        if lost:  # the longest step that still ends in contact, by bisection
            low = 0.0
            for _ in range(_ITERATIONS):
                middle = (low + duration) / 2
                if leaves(mean_velocity(middle), middle):
                    duration = middle
                else:
                    low = middle
            slope = mean_velocity(duration)
        force, length, _ = row.go(row.depth + slope * duration, duration)
        speed = 2 * slope - speed
        # the row was loaded at the mean velocity of the step; its dashpots now have that at its end
        force += law.viscosity * length * (speed - slope)
        path.append((row.time, row.depth, speed, 0.0 if lost else force))
        if lost:
            columns = (np.array(column) for column in zip(*path, strict=True))
            return ViscoelasticImpact(-speed / velocity, row.time, *columns)
    raise ConvergenceError(f"the body is still in contact after {_LONGEST} elastic durations")
