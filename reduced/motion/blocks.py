"""The friction law (19.1), a function of velocity, and rigid blocks under it in fixed steps.

(19.1) takes F_R = (2/pi) mu F_N arctan(v/v0) for the friction of a contact sliding at v, with a
characteristic speed v0 that "must be chosen so that it is significantly smaller than the
characteristic sliding velocity of the system". Under any load below mu F_N the contact creeps.
Blocks on springs, explicit or implicit:

    m_i v_i' = f_i + P_i cos(W t) - (K x)_i - (C v)_i - (2/pi) L_i arctan((v_i - V_i)/v0),  x' = v

with L = mu F_N of a block and V the speed of its support (a belt; 0 for the ground).
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from reduced.errors import ConvergenceError, choice_faults, positive_faults, refuse
from reduced.motion.course import Stepping

# Real stability limits: the largest h |lambda| on v' = -|lambda| v.
STABILITY_LIMITS = {
    "explicit_euler": 2.0,
    "semi_implicit_euler": 2.0,
    "runge_kutta_4": 2.785293563405282,  # 24 - 12 z + 4 z^2 - z^3 = 0
}


def friction(velocity: ArrayLike, limit: float, characteristic_speed: float) -> np.ndarray:
    """Return the friction force (2/pi) mu F_N arctan(v/v0) (19.1), of the sign of v.

    `limit` is mu F_N, below which it stays by (2/pi) v0/v of it where v >> v0.

    >>> float(friction(1.0, 2.0, 1.0))
    1.0
    """
    refuse(positive_faults(characteristic_speed=characteristic_speed, limit=limit))
    return 2 / np.pi * limit * np.arctan(np.asarray(velocity) / characteristic_speed)


def creep_speed(load: ArrayLike, limit: float, characteristic_speed: float):
    """Return the steady speed v0 tan(pi F/(2 mu F_N)) under a load below the limit.

    The inverse of (19.1): Coulomb's law predicts rest.

    >>> round(float(creep_speed(0.5, 1.0, 1e-3)), 12)
    0.001
    """
    wrong = positive_faults(characteristic_speed=characteristic_speed, limit=limit)
    refuse(wrong or _load_faults(load, limit))
    return characteristic_speed * np.tan(np.pi / 2 * (np.asarray(load) / limit))


def missing_friction(speed: ArrayLike, characteristic_speed: float) -> np.ndarray:
    """Return the fraction of mu F_N missing in (19.1) at a sliding speed: (2/pi) arctan(v0/v).

    It decreases only as v0/v: 1 % needs v > 64 v0, 0.1 % needs v > 640 v0.

    >>> round(float(missing_friction(63.65674, 1.0)), 6)
    0.01
    """
    refuse(positive_faults(characteristic_speed=characteristic_speed))
    return 2 / np.pi * np.arctan(characteristic_speed / np.abs(np.asarray(speed)))


def stable_step(
    mass: float,
    limit: float,
    characteristic_speed: float,
    load: float = 0.0,
    scheme: str = "explicit_euler",
) -> float:
    """Return the largest stable step of an explicit scheme of `blocks` for a mass under a load.

    Linearised about the creep, m v' = -F_R'(v) v with F_R' = (2/pi) (mu F_N/v0) cos^2(pi F/(2 mu
    F_N)); Euler's step is stable for h F_R'/m < 2, that is h < pi m v0/(mu F_N) at rest. A spring
    shortens the step of the semi-implicit scheme to h F_R'/m + h^2 k/(2 m) < 2.

    >>> round(stable_step(1.0, 2.0, 1e-3) / np.pi, 12)
    0.0005
    """
    wrong = positive_faults(mass=mass, limit=limit, characteristic_speed=characteristic_speed)
    wrong += choice_faults("scheme", scheme, STABILITY_LIMITS)
    refuse(wrong or _load_faults(load, limit))
    slope = 2 / np.pi * (limit / characteristic_speed) * np.cos(np.pi / 2 * (load / limit)) ** 2
    return float(STABILITY_LIMITS[scheme] * mass / slope)


def _load_faults(load: ArrayLike, limit: float) -> list[str]:
    below = np.all(np.abs(np.asarray(load)) < limit)
    return [] if below else [f"the load must be below the limit {limit!r}, got {load!r}"]


_EXPLICIT = {"explicit_euler": 0, "semi_implicit_euler": 1, "runge_kutta_4": 2}
_IMPLICIT = {"implicit_euler": 1.0, "implicit_midpoint": 0.5}  # position of u in the step
SCHEMES = (*_EXPLICIT, *_IMPLICIT)
"""Explicit schemes need `stable_step`; implicit ones permit any step."""

_EPSILON = float(np.finfo(float).eps)


class System(NamedTuple):
    """Blocks as full arrays of shape (n,) and (n, n)."""

    mass: np.ndarray
    load: np.ndarray
    amplitude: np.ndarray
    frequency: float
    stiffness: np.ndarray
    damping: np.ndarray
    belt: np.ndarray
    limit: np.ndarray


class Blocks:
    """n rigid blocks, given by arrays or by numbers (one block, or equal values for all).

    A block on a slope is ``Blocks(m, mu * m * g * cos(a), load=m * g * sin(a))``, an oscillator on
    a belt ``Blocks(m, limit, stiffness=k, belt=V)``. `limit` is L = mu F_N; stiffness and damping
    are numbers, or symmetric (n, n); `frequency` is that of the harmonic load.
    """

    def __init__(
        self,
        mass: ArrayLike,
        limit: ArrayLike,
        stiffness: ArrayLike = 0.0,
        damping: ArrayLike = 0.0,
        load: ArrayLike = 0.0,
        amplitude: ArrayLike = 0.0,
        frequency: float = 0.0,
        belt: ArrayLike = 0.0,
    ) -> None:
        columns = mass, load, amplitude, belt, limit
        n = max(np.size(column) for column in columns)
        mass, load, amplitude, belt, limit = (
            np.array(np.broadcast_to(np.asarray(column, float), n)) for column in columns
        )
        stiffness, damping = (
            np.array(matrix, float) if np.ndim(matrix) else np.asarray(matrix, float) * np.eye(n)
            for matrix in (stiffness, damping)
        )
        self.system = System(
            *(mass, load, amplitude, float(frequency), stiffness, damping, belt, limit)
        )
        parts = self.system._asdict()
        wrong = [
            f"{name} must be finite, got {value!r}"
            for name, value in parts.items()
            if not np.isfinite(value).all()
        ]
        wrong += [
            f"{name} must be positive, got {parts[name]!r}"
            for name in ("mass", "limit")
            if (parts[name] <= 0).any()
        ]
        for name in ("stiffness", "damping"):
            matrix = parts[name]
            if matrix.shape != (n, n) or not np.array_equal(matrix, matrix.T):
                wrong.append(f"{name} must be a symmetric ({n}, {n}) matrix, got {matrix!r}")
        refuse(wrong)


@dataclass(frozen=True)
class BlockMotion:
    """Motion at the recorded times: time (k,), position and velocity (k, n).

    `evaluations` of the law (19.1) per block, those of the implicit solver included, are the cost.
    """

    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    evaluations: int


def integrate(
    blocks: Blocks,
    characteristic_speed: float,
    stepping: Stepping,
    scheme: str = "implicit_euler",
    *,
    position: ArrayLike = 0.0,
    velocity: ArrayLike = 0.0,
) -> BlockMotion:
    """Integrate the motion of blocks under the regularised law of characteristic speed v0.

    - ``"explicit_euler"``, ``"semi_implicit_euler"`` (the new velocity moves the block),
      ``"runge_kutta_4"``: stable below `stable_step` only. Beyond it the velocity jumps between +v
      and -v at every step.
    - ``"implicit_euler"``, ``"implicit_midpoint"``: the friction of the new (mean) velocity; any
      step is stable. Each step is a strictly convex problem, solved block by block to round-off;
      for v0 -> 0 it becomes the step of Moreau and Jean for Coulomb's law.

    >>> resting = Blocks(1.0, 1.0, load=0.5)  # it creeps at v0 tan(pi/4)
    >>> slow = integrate(resting, 1e-3, Stepping(1.0, 100))
    >>> round(float(slow.velocity[-1, 0]), 12)
    0.001
    """
    wrong = positive_faults(characteristic_speed=characteristic_speed)
    wrong += choice_faults("scheme", scheme, SCHEMES)
    data = blocks.system
    size = data.mass.size
    start = tuple(np.array(np.broadcast_to(value, size), float) for value in (position, velocity))
    if not all(np.isfinite(part).all() for part in start):
        wrong.append(f"position and velocity must be finite, got {position!r}, {velocity!r}")
    refuse(wrong)
    records = np.empty((2, stepping.records, size))
    clock = float(stepping.step), int(stepping.steps), int(stepping.stride)
    problem = data, float(characteristic_speed), *start, *clock, records
    if scheme in _EXPLICIT:
        evaluations, failed = _explicit(_EXPLICIT[scheme], *problem), -1
    else:
        evaluations, failed = _implicit(_IMPLICIT[scheme], *problem)
    if failed >= 0 or not np.isfinite(records).all():
        at = max(failed, 0)
        raise ConvergenceError(f"{scheme}: no finite velocity at step {at}", [stepping.step])
    return BlockMotion(stepping.times, records[0], records[1], int(evaluations))


@njit(cache=True)
def _acceleration(t, x, v, system, v0, out):
    """Return the accelerations of the blocks; one evaluation of the law per block."""
    mass, load, amplitude, frequency, stiffness, damping, belt, limit = system
    swing = np.cos(frequency * t)
    for i in range(mass.size):
        force = load[i] + amplitude[i] * swing
        for j in range(mass.size):
            force -= stiffness[i, j] * x[j] + damping[i, j] * v[j]
        force -= 2.0 / np.pi * limit[i] * np.arctan((v[i] - belt[i]) / v0)
        out[i] = force / mass[i]


@njit(cache=True)
def _record(records, k, x, v):
    """Store positions and velocities: loops compile in a tenth of the time of slices."""
    for i in range(x.size):
        records[0, k, i], records[1, k, i] = x[i], v[i]


@njit(cache=True)
def _explicit(scheme, system, v0, x, v, h, steps, stride, records):
    """Run Euler (0), semi-implicit Euler (1) or Runge and Kutta (2)."""
    _record(records, 0, x, v)
    slopes = np.empty((4, x.size))
    for k in range(steps):
        t = k * h
        _acceleration(t, x, v, system, v0, slopes[0])
        if scheme == 0:
            x, v = x + h * v, v + h * slopes[0]
        elif scheme == 1:
            v = v + h * slopes[0]
            x = x + h * v
        else:
            v1 = v + 0.5 * h * slopes[0]
            _acceleration(t + 0.5 * h, x + 0.5 * h * v, v1, system, v0, slopes[1])
            v2 = v + 0.5 * h * slopes[1]
            _acceleration(t + 0.5 * h, x + 0.5 * h * v1, v2, system, v0, slopes[2])
            v3 = v + h * slopes[2]
            _acceleration(t + h, x + h * v2, v3, system, v0, slopes[3])
            x = x + h / 6.0 * (v + 2.0 * v1 + 2.0 * v2 + v3)
            v = v + h / 6.0 * (slopes[0] + 2.0 * slopes[1] + 2.0 * slopes[2] + slopes[3])
        if (k + 1) % stride == 0:
            _record(records, (k + 1) // stride, x, v)
    return steps * (4 if scheme == 2 else 1)


@njit(cache=True)
def _implicit(theta, system, v0, x, v, h, steps, stride, records):
    """Run m (u - v)/(theta h) = force(t + theta h, x + theta h u, u), u the velocity at theta.

    Each step solves A u + (2/pi) h L arctan((u - V)/v0) = b by Gauss-Seidel sweeps with exact block
    solves; the solution minimises a strictly convex function, for which such sweeps converge.
    Returns the evaluations of the law and the step at which the velocities did not converge, or -1.
    """
    mass, load, amplitude, frequency, stiffness, damping, belt, limit = system
    n = mass.size
    matrix = h * damping + h * h * theta * stiffness
    for i in range(n):
        matrix[i, i] += mass[i] / theta
    _record(records, 0, x, v)
    evaluations, u, impulse = 0, v.copy(), h * limit
    for k in range(steps):
        swing = np.cos(frequency * (k + theta) * h)
        right = mass * v / theta + h * (load + amplitude * swing)
        for i in range(n):
            for j in range(n):
                right[i] -= h * stiffness[i, j] * x[j]
        for _ in range(10_000):
            change, size = 0.0, 0.0
            for i in range(n):
                remainder = right[i] - matrix[i, i] * belt[i]
                for j in range(n):
                    if j != i:
                        remainder -= matrix[i, j] * u[j]
                # a w + (2/pi) b arctan(w/v0) = c: for c > 0 the left side is concave in w > 0,
                # Newton's method increases to the root from any smaller w, such as (c - b)/a and
                # the root of the tangent at w = 0, until rounding stops it
                a, b, goal = matrix[i, i], impulse[i], abs(remainder)
                w = max((goal - b) / a, goal / (a + 2.0 / np.pi * b / v0))
                for _ in range(200):
                    evaluations += 1
                    ratio = w / v0
                    excess = goal - a * w - 2.0 / np.pi * b * np.arctan(ratio)
                    slope = a + 2.0 / np.pi * b / (v0 * (1.0 + ratio * ratio))
                    way = excess / slope
                    if way <= 2.0 * _EPSILON * w:
                        break
                    w += way
                new = belt[i] + np.copysign(w, remainder)
                change, size = max(change, abs(new - u[i])), max(size, abs(new))
                u[i] = new
            if n == 1 or change <= 4.0 * _EPSILON * size:
                break
        else:
            return evaluations, k
        x = x + h * u
        v = (u - (1.0 - theta) * v) / theta
        if (k + 1) % stride == 0:
            _record(records, (k + 1) // stride, x, v)
    return evaluations // n, -1
