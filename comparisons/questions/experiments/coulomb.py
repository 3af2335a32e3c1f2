"""Rigid blocks under Coulomb's set-valued law, with any friction force up to the limit at rest.

    M v' = f + P cos(W t) - K x - C v + R,   x' = v,   w = v - V,
    R_i = -sign(w_i) mu_k F_N where the block slides,  |R_i| <= mu_s F_N where it sticks (w_i = 0),

with V the constant speed of the support of a block (Coulomb 1785; Den Hartog 1931). Their motion is
followed exactly by `event_driven`, and here in fixed steps; three have closed forms.
"""

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from reference.arrays import Array
from reference.errors import ConvergenceError, positive_faults, refuse

_EPSILON = float(np.finfo(float).eps)


class Blocks:
    """n rigid blocks, given by arrays (n,) or by numbers (one block, or equal values for all).

    m; mu_k F_N and mu_s F_N (by default equal); K and C, numbers or symmetric (n, n); f, P, W, V.

    >>> Blocks([1.0, 2.0], 0.5, stiffness=[[1.0, -1.0], [-1.0, 1.0]]).static
    array([0.5, 0.5])
    """

    def __init__(
        self,
        mass: ArrayLike,
        kinetic: ArrayLike,
        static: ArrayLike | None = None,
        stiffness: ArrayLike = 0.0,
        damping: ArrayLike = 0.0,
        load: ArrayLike = 0.0,
        amplitude: ArrayLike = 0.0,
        frequency: float = 0.0,
        belt: ArrayLike = 0.0,
    ) -> None:
        columns = mass, load, amplitude, belt, kinetic, kinetic if static is None else static
        n = max(np.size(column) for column in columns)
        self.mass, self.load, self.amplitude, self.belt, self.kinetic, self.static = (
            np.array(np.broadcast_to(column, n), float) for column in columns
        )
        self.stiffness, self.damping = (
            np.array(matrix, float) if np.ndim(matrix) else np.asarray(matrix, float) * np.eye(n)
            for matrix in (stiffness, damping)
        )
        self.frequency = float(frequency)
        faults = [
            f"{name} must be finite, not {value!r}"
            for name, value in vars(self).items()
            if not np.isfinite(value).all()
        ]
        if (self.mass <= 0).any():
            faults.append(f"mass must be positive, not {mass!r}")
        if not ((self.kinetic >= 0) & (self.static >= self.kinetic)).all():
            faults.append(f"expected static >= kinetic >= 0, not {static!r} and {kinetic!r}")
        for name, matrix in (("stiffness", self.stiffness), ("damping", self.damping)):
            if matrix.shape != (n, n) or not np.array_equal(matrix, matrix.T):
                faults.append(f"{name} must be a symmetric ({n}, {n}) matrix, not {matrix!r}")
        refuse(faults)

    def initial_state(self, position: ArrayLike, velocity: ArrayLike) -> tuple[Array, Array]:
        """Return initial x and v as arrays (n,), or raise ValueError."""
        x, v = (np.array(np.broadcast_to(y, self.mass.size), float) for y in (position, velocity))
        if not (np.isfinite(x).all() and np.isfinite(v).all()):
            raise ValueError(
                f"position and velocity must be finite, not {position!r}, {velocity!r}"
            )
        return x, v


def stopping(mass: float, friction: float, speed: float, load: float = 0.0) -> tuple[float, float]:
    """Return time and distance to rest of a sliding body: m v/(R - F), v t/2.

    R = mu F_N, and F in the direction of motion is below it (on a slope m g sin a).

    >>> stopping(1.0, 0.5, 2.0)
    (4.0, 4.0)
    """
    refuse(positive_faults(mass=mass, friction=friction, speed=speed))
    if not load < friction:
        raise ValueError(f"the body does not stop: load {load!r}, friction {friction!r}")
    time = mass * speed / (friction - load)
    return time, 0.5 * speed * time


@dataclass(frozen=True)
class StickSlip:
    """One cycle of an oscillator on a belt: times of stick and slip, elongations of the spring.

    It grows by `jump` during stick; `largest` and `smallest` in the cycle include the overshoot
    after the onset of slip.
    """

    sticking: float
    slipping: float
    jump: float
    largest: float
    smallest: float

    @property
    def period(self) -> float:
        """Period, sticking plus slipping time."""
        return self.sticking + self.slipping


def stick_slip(
    mass: float, stiffness: float, belt_speed: float, static: float, kinetic: float
) -> StickSlip:
    """Return the limit cycle of a mass held by a spring on a belt moving at V.

    With D = (F_s - F_k)/k, the block sticks while the spring elongates by 2 D, then oscillates
    about F_k/k with amplitude sqrt(D^2 + (V/w)^2) for the time (2 pi - 2 arctan(D w/V))/w, then it
    moves with the belt again (Popov, Contact Mechanics and Friction, ch. 12; Den Hartog, Mechanical
    Vibrations, ch. 7). For F_s = F_k there is no stick.

    >>> round(stick_slip(1.0, 1.0, 1.0, 2.0, 1.0).period - 2 - 1.5 * math.pi, 12)
    0.0
    """
    numbers = {"mass": mass, "stiffness": stiffness, "belt_speed": belt_speed}
    refuse(positive_faults(**numbers, static=static, kinetic=kinetic))
    if static < kinetic:
        raise ValueError(f"static friction {static!r} is below the kinetic one {kinetic!r}")
    frequency = math.sqrt(stiffness / mass)
    half = (static - kinetic) / stiffness
    swing = math.hypot(half, belt_speed / frequency)
    angle = math.atan2(half * frequency, belt_speed)
    return StickSlip(
        sticking=2 * half / belt_speed,
        slipping=2 * (math.pi - angle) / frequency,
        jump=2 * half,
        largest=kinetic / stiffness + swing,
        smallest=kinetic / stiffness - swing,
    )


def dry_oscillator_amplitude(
    stiffness: float, friction: float, force: float, frequency_ratio: float
) -> float:
    """Return the amplitude of an oscillator under P cos(W t) and Coulomb friction R, without stops.

    x0 = (P/k) sqrt(A^2 - (R/P)^2 B^2), A = 1/(1 - r^2), B = sin(pi/r)/(r (1 + cos(pi/r))), r the
    ratio of W to the natural frequency (Den Hartog, Trans. ASME 53 (1931) APM-107). Valid if the
    block does not stop within a half-period, which the caller checks.

    >>> round(dry_oscillator_amplitude(1.0, 0.0, 1.0, 0.5), 12)  # no friction: 1/(1 - r^2)
    1.333333333333
    """
    refuse(positive_faults(stiffness=stiffness, force=force, frequency_ratio=frequency_ratio))
    r = frequency_ratio
    if r == 1 or not friction >= 0:
        raise ValueError(f"no amplitude at resonance or below no friction: {r!r}, {friction!r}")
    response = 1 / (1 - r * r)
    loss = math.sin(math.pi / r) / (r * (1 + math.cos(math.pi / r)))
    square = response**2 - (friction / force * loss) ** 2
    if not square > 0:
        raise ValueError(f"friction {friction!r} stops the block within each half-period")
    return force / stiffness * math.sqrt(square)


@dataclass(frozen=True)
class March:
    """Motion in steps: (k,) and (k, n); evaluations of Coulomb's law per block are the cost."""

    time: Array
    position: Array
    velocity: Array
    evaluations: int


def march(
    blocks: Blocks,
    *,
    step: float,
    steps: int,
    theta: float = 0.5,
    position: ArrayLike = 0.0,
    velocity: ArrayLike = 0.0,
) -> March:
    r"""Integrate the motion of the blocks from t = 0 in fixed steps (Moreau 1988, Jean 1999).

    Events are not located; every step solves the law for its impulse p. With the theta rule for the
    smooth forces,

        (M + h theta C + h^2 theta^2 K) v+ = M v - h (1 - theta) C v
                              - h K (x + h theta (1 - theta) v) + h f(t + theta h) + p,
        x+ = x + h (theta v+ + (1 - theta) v),    -p in h mu F_N Sign(v+ - V)

    (Acary & Brogliato, Numerical Methods for Nonsmooth Dynamical Systems, 2008, chapter 10). With
    theta = 1/2 the order is near 2 if the friction is continuous at the events (mu_s = mu_k), else
    1. Unconditionally stable for theta >= 1/2; a block at rest has exactly zero velocity.

    A block at rest at the end of a step resists up to mu_s F_N in the next one, others mu_k F_N.

    >>> sled = march(Blocks(1.0, 0.5), step=0.25, steps=40, velocity=2.0)
    >>> float(sled.position[-1, 0]), float(sled.velocity[-1, 0])  # v^2/(2 mu g), and rest
    (4.0, 0.0)
    """
    if not (np.isfinite(step) and step > 0 and steps >= 1 and 0.5 <= theta <= 1):
        raise ValueError(
            "expected step > 0, steps >= 1 and 1/2 <= theta <= 1, "
            f"not {step!r}, {steps!r} and {theta!r}"
        )
    x, v = blocks.initial_state(position, velocity)
    records = np.empty((2, int(steps) + 1, x.size))
    records[:, 0] = x, v
    part = float(step) * float(theta)
    matrix = np.diag(blocks.mass) + part * blocks.damping + part * part * blocks.stiffness
    evaluations, failed = _march(
        *(blocks.mass, blocks.kinetic, blocks.static, blocks.stiffness, blocks.damping),
        *(blocks.load, blocks.amplitude, blocks.frequency, blocks.belt),
        *(matrix, float(step), float(theta), records),
    )
    if failed >= 0 or not np.isfinite(records).all():
        raise ConvergenceError(f"no finite velocity at step {max(failed, 0)}", [step])
    time = np.asarray(step * np.arange(steps + 1), dtype=np.float64)
    return March(time, records[0], records[1], int(evaluations // x.size))


@njit(cache=True)
def _march(  # noqa: PLR0913
    mass: Array,
    kinetic: Array,
    static: Array,
    stiffness: Array,
    damping: Array,
    load: Array,
    amplitude: Array,
    frequency: float,
    belt: Array,
    matrix: Array,
    h: float,
    theta: float,
    records: Array,
) -> tuple[int, int]:
    """Fill positions and velocities; return evaluations, and the failed step or -1."""
    n, evaluations = mass.size, 0
    free, moved, bound = np.empty(n), np.empty(n), np.empty(n)
    for k in range(records.shape[1] - 1):
        x, v = records[0, k], records[1, k]
        moves, new = records[0, k + 1], records[1, k + 1]

        # right-hand side without friction
        for i in range(n):
            new[i], moved[i] = v[i], x[i] + h * theta * (1.0 - theta) * v[i]
        swing = np.cos(frequency * (k + theta) * h)
        for i in range(n):
            free[i] = mass[i] * v[i] + h * (load[i] + amplitude[i] * swing)
            for j in range(n):
                free[i] -= h * (1.0 - theta) * damping[i, j] * v[j] + h * stiffness[i, j] * moved[j]
            bound[i] = h * (static[i] if v[i] == belt[i] else kinetic[i])

        # Coulomb's law, by non-smooth Gauss-Seidel sweeps: the velocities minimise a strictly
        # convex function, for which they converge (Jean 1999)
        settled = False
        for _ in range(10_000):
            change, size = 0.0, 0.0
            for i in range(n):
                drive = free[i] - matrix[i, i] * belt[i]
                for j in range(n):
                    if j != i:
                        drive -= matrix[i, j] * new[j]
                if abs(drive) <= bound[i]:
                    speed = belt[i]
                else:
                    speed = belt[i] + (drive - np.copysign(bound[i], drive)) / matrix[i, i]
                change, size = max(change, abs(speed - new[i])), max(size, abs(speed))
                new[i] = speed
            evaluations += n
            if n == 1 or change <= 4.0 * _EPSILON * size:
                settled = True
                break
        if not settled:
            return evaluations, k

        for i in range(n):
            moves[i] = x[i] + h * (theta * new[i] + (1.0 - theta) * v[i])
    return evaluations, -1
