"""Rigid blocks under Coulomb's set-valued law, with any friction force up to the limit at rest.

    M v' = f + P cos(W t) - K x - C v + R,   x' = v,   w = v - V,
    R_i = -sign(w_i) mu_k F_N where the block slides,  |R_i| <= mu_s F_N where it sticks (w_i = 0),

with V the constant speed of the support of a block (Coulomb 1785; Den Hartog 1931). Three motions
have closed forms; all are followed in fixed steps (`march`), and exactly between the events: slip,
stick, reversal (`follow`). While no block changes between stick and slip, the equations are linear
with constant coefficients in z = (x, w, 1, cos(W t), sin(W t)): z' = A z and z(t) = exp(A t) z(0),
for any frequencies, damping or resonance. Only the ends of phases have to be located: when a
sliding speed reaches zero, or the force on a sticking block reaches its limit.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import ArrayLike
from scipy.linalg import eigvals, expm
from scipy.optimize import brentq

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


# Samples per shortest period, enough not to miss two extrema of a sum of harmonics between samples.
_SAMPLES = 32
_ROUNDING = 16 * float(np.finfo(float).eps)  # of a sum, relative to its absolute terms
_DOUBLINGS = 10  # number of halvings of the regular step for the first sample after an event


class Phase(NamedTuple):
    """The phase between two events: start (in the motion's unit of time), direction, z there, A.

    The direction (n,) is 0 for a sticking block, else the sign of its sliding velocity.
    """

    start: float
    direction: np.ndarray
    state: Array
    matrix: Array

    def moved(self, state: Array, time: float, propagator: Array | None = None) -> Array:
        """Return exp(A t) z, with the components that are known exactly.

        A zero row of A is a row of the identity in exp(A t), but the linear solve rounds
        differently on every processor: a sticking block would have a speed of arbitrary sign.
        """
        later = (expm(self.matrix * time) if propagator is None else propagator) @ state
        n = self.direction.size
        later[n : 2 * n][self.direction == 0] = 0.0
        later[2 * n] = 1.0
        return later


@dataclass(frozen=True)
class BlockMotion:
    """The exact motion, to be evaluated at any time.

    `length` and `time` are the units of the phases, powers of two; `belt` (n,) is V.
    """

    phases: list[Phase]
    duration: float
    belt: Array
    length: float
    time: float

    def at(self, times: ArrayLike) -> tuple[Array, Array]:
        """Return positions and velocities, shape (k, n), at times in [0, duration]."""
        instants = np.atleast_1d(np.asarray(times, float))
        if not ((instants >= 0) & (instants <= self.duration)).all():
            raise ValueError(f"times must lie in [0, {self.duration!r}], not {times!r}")
        starts = np.array([phase.start for phase in self.phases])
        phases = np.searchsorted(starts, instants / self.time, side="right") - 1
        states = np.empty((instants.size, self.phases[0].state.size))
        for k in np.unique(phases):
            phase, mine = self.phases[k], phases == k
            after = (instants[mine] / self.time - phase.start)[:, None, None]
            states[mine] = expm(phase.matrix * after) @ phase.state
        n = self.belt.size
        speed = self.length / self.time
        return self.length * states[:, :n], speed * states[:, n : 2 * n] + self.belt

    @property
    def events(self) -> Array:
        """Return the times at which a block starts to slide, sticks or reverses."""
        return self.time * np.array([phase.start for phase in self.phases[1:]])

    def time_sticking(self) -> float:
        """Return the total sticking time of the first block."""
        starts = np.array([0.0, *self.events])
        sticks = np.array([phase.direction[0] == 0 for phase in self.phases])
        return float(np.diff([*starts, self.duration]) @ sticks)


def follow(
    blocks: Blocks,
    duration: float,
    *,
    position: ArrayLike = 0.0,
    velocity: ArrayLike = 0.0,
    most_events: int = 10_000,
) -> BlockMotion:
    """Return the motion of the blocks from t = 0, with position and velocity (n,) there.

    A block that comes to rest on its support sticks if the force on it is at most mu_s F_N, else it
    moves in the direction of the force. As the mass matrix is diagonal, blocks that stop at the
    same time are independent.

    >>> sled = follow(Blocks(1.0, 0.5), 10.0, velocity=2.0)
    >>> sled.events, round(float(sled.at(10.0)[0][0, 0]), 12)  # v^2/(2 mu g)
    (array([4.]), 4.0)
    """
    refuse(positive_faults(duration=duration))
    x, v = blocks.initial_state(position, velocity)
    system, length, unit = _in_natural_units(blocks, x, v, duration)
    n = x.size
    # rows G; G z is the force on the blocks without friction at the support's speed
    force = np.zeros((n, 2 * n + 3))
    force[:, :n], force[:, n : 2 * n] = -system.stiffness, -system.damping
    force[:, 2 * n] = system.load - system.damping @ system.belt
    force[:, 2 * n + 1] = system.amplitude

    def matrix(direction: np.ndarray) -> Array:
        # A of a phase: x' = w + V; w' = 0 for sticking blocks
        A = np.zeros((2 * n + 3,) * 2)
        A[:n, n : 2 * n], A[:n, 2 * n] = np.eye(n), system.belt
        A[n : 2 * n] = force / system.mass[:, None]
        A[n : 2 * n, 2 * n] -= direction * system.kinetic / system.mass
        A[n : 2 * n][direction == 0] = 0
        A[-2, -1], A[-1, -2] = -system.frequency, system.frequency
        return A

    def at_rest(direction: np.ndarray, state: Array, resting: np.ndarray | list[int]) -> np.ndarray:
        # Directions after blocks came to rest: 0 if they stick. A force beyond the limit moves a
        # block. A force at the limit within rounding moves it if the force would grow during stick:
        # a block that comes to rest at -mu_s F_N with the belt relaxing the spring sticks, and one
        # that only touches rest continues to slide.
        chosen = direction.copy()
        chosen[resting] = 0
        rates = force @ matrix(chosen)
        pull, rounding = force @ state, _ROUNDING * (np.abs(force) @ np.abs(state) + system.static)
        growth, slow = np.sign(pull) * (rates @ state), _ROUNDING * (np.abs(rates) @ np.abs(state))
        excess = np.abs(pull) - system.static
        torn = (excess > rounding) | ((excess > -rounding) & (growth > slow))
        chosen[resting] = np.where(torn, np.sign(pull), 0)[resting]
        return chosen

    slip = v / (length / unit) - system.belt
    state = np.concatenate([x / length, slip, [1.0, 1.0, 0.0]])
    direction = at_rest(np.where(slip < 0, -1, 1), state, np.flatnonzero(slip == 0))
    starting = (slip == 0) & (direction != 0)
    phases: list[Phase] = []
    time = 0.0
    while len(phases) <= most_events:
        phases.append(Phase(time, direction, state, matrix(direction)))
        # guards: the speed of a sliding block, two distances to the limit of a sticking one
        guards = []
        for i in range(n):
            row = np.zeros(2 * n + 3)
            if direction[i] != 0:
                row[n + i] = direction[i]
                guards.append(Guard(row, i, 0))
            else:
                row[2 * n] = system.static[i]
                guards += [Guard(row - sense * force[i], i, sense) for sense in (1, -1)]
        event = _next_event(phases[-1], guards, duration / unit - time, starting)
        if event is None:
            return BlockMotion(phases, float(duration), blocks.belt, length, unit)
        (_, block, sense), after, state, starting = event
        time += after
        if sense:
            direction = direction.copy()
            direction[block] = sense
        else:
            direction = at_rest(direction, state, [block])
        starting[block] = direction[block] != 0
    raise ConvergenceError(f"more than {most_events} events", [phase.start for phase in phases])


def _in_natural_units(
    blocks: Blocks, x: Array, v: Array, duration: float
) -> tuple[Blocks, float, float]:
    """Return the blocks in units that make all numbers of order one, and those of length and time.

    Powers of two. The time is that of the fastest oscillation or decay (else the duration), the
    length the largest displacement due to initial state, belts and forces in that time.
    """
    stiff = float((np.abs(blocks.stiffness).sum(axis=1) / blocks.mass).max())
    damped = float((np.abs(blocks.damping).sum(axis=1) / blocks.mass).max())
    rate = max(np.sqrt(stiff), damped, abs(blocks.frequency)) or 1 / duration
    forces = np.abs(blocks.load) + np.abs(blocks.amplitude) + blocks.static
    longest = max(
        float(np.abs(x).max()),
        float(np.abs(v).max() / rate),
        float(np.abs(blocks.belt).max() / rate),
        float((forces / blocks.mass).max() / rate**2),
    )
    units = float(blocks.mass.max()), longest or 1.0, 1 / rate
    mass, length, time = (2.0 ** round(np.log2(unit)) for unit in units)
    force, speed = mass * length / time**2, length / time
    scaled = Blocks(
        blocks.mass / mass,
        blocks.kinetic / force,
        blocks.static / force,
        stiffness=blocks.stiffness / (mass / time**2),
        damping=blocks.damping / (mass / time),
        load=blocks.load / force,
        amplitude=blocks.amplitude / force,
        frequency=blocks.frequency * time,
        belt=blocks.belt / speed,
    )
    return scaled, length, time


class Guard(NamedTuple):
    """A linear function of the state, row z, that is positive during a phase."""

    row: Array
    block: int
    sense: int  # direction in which the block starts to slide below zero; 0: it comes to rest


def _next_event(
    phase: Phase, guards: list[Guard], remaining: float, starting: np.ndarray
) -> tuple[Guard, float, Array, np.ndarray] | None:
    """Return the first event within the time `remaining`: guard, time since the start, z.

    In z the speed of a block that comes to rest is exactly zero. The speed of a block that has just
    started to slide is zero with rounding of either sign: it cannot end a phase before it has
    become positive, in this or a later phase; which are still `starting` (n,) is returned, too.
    """
    A, state, time, starting = phase.matrix, phase.state, 0.0, starting.copy()
    rate = float(np.abs(eigvals(A)).max())
    regular = remaining / _SAMPLES
    if rate * regular > 2 * np.pi / _SAMPLES:
        regular = 2 * np.pi / (_SAMPLES * rate)
    rows = np.array([guard.row for guard in guards])
    # Rounding of a guard's value and rate: that of their terms in a regular step, even for short
    # steps after an event, with the largest states so far in this phase.
    terms = np.abs(np.stack([rows, rows @ A], axis=1)) @ np.abs(expm(A * regular))
    sizes = np.abs(state)

    # Steps double at first, 1, 1, 2, 4, ..., then they are regular. Every propagator is computed as
    # an exponential; squaring the previous one would double its rounding.
    step, first, last = regular * 2.0**-_DOUBLINGS, True, False
    propagator = expm(A * step)
    while not last:
        last = not time + step < remaining
        if last:
            step = remaining - time
            propagator = expm(A * step)
        later = phase.moved(state, step, propagator)
        sizes = np.maximum(sizes, np.abs(later))
        rounding = _ROUNDING * (terms @ sizes)
        crossings = []
        for k, (row, block, sense) in enumerate(guards):
            excused = sense == 0 and bool(starting[block])
            after = _crossing(row, phase, state, step, later, rounding[k], starting=excused)
            if after is not None:
                crossings.append((after, k))
        if crossings:
            after, k = min(crossings)
            state = phase.moved(state, after)
            if guards[k].sense == 0:
                state[starting.size + guards[k].block] = 0.0  # zero up to rounding
            return guards[k], time + after, state, starting
        state = later
        for k, (row, block, sense) in enumerate(guards):
            starting[block] &= sense != 0 or row @ state <= rounding[k, 0]
        time += step
        if not first and step < regular:
            step *= 2
            propagator = expm(A * step)
        first = False
    return None


def _crossing(
    row: Array,
    phase: Phase,
    state: Array,
    step: float,
    later: Array,
    rounding: Array,
    *,
    starting: bool,
) -> float | None:
    """Return the time in a step, from a state to a later one, at which row z first goes below zero.

    Beyond the `rounding` of value and rate: a guard that touches zero does not trigger. One that is
    zero initially triggers there if it decreases, or after its maximum if it first increases (or if
    the block is `starting`).
    """
    rate = row @ phase.matrix

    def value(time: float, line: Array) -> float:
        return float(line @ (phase.moved(state, time) if time else state))

    def root(line: Array, since: float, until: float) -> float:
        precision = 4 * float(np.finfo(float).eps)
        return brentq(value, since, until, args=(line,), xtol=precision * until, rtol=precision)

    below = row @ later < -rounding[0]
    if row @ state <= rounding[0]:
        if rate @ state < -rounding[1] and not starting:
            return 0.0
        if not below:
            return None
        top = root(rate, 0.0, step) if rate @ state > 0 > rate @ later else 0.0
        return root(row, top, step) if value(top, row) > 0 else top
    if below:
        return root(row, 0.0, step)
    if rate @ state < 0 < rate @ later:
        lowest = root(rate, 0.0, step)
        if value(lowest, row) < -rounding[0]:
            return root(row, 0.0, lowest)
    return None
