"""Blocks with Coulomb friction, exact between the events: slip, stick, reversal.

While no block changes between stick and slip, the equations are linear with constant
coefficients in z = (x, w, 1, cos(W t), sin(W t)): z' = A z and z(t) = exp(A t) z(0), for any
frequencies, damping or resonance. Only the ends of phases have to be located: when a sliding speed
reaches zero, or the force on a sticking block reaches its limit.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import eigvals, expm
from scipy.optimize import brentq

from comparisons.questions.experiments.coulomb import Blocks
from reference.arrays import Array
from reference.errors import ConvergenceError, positive_faults, refuse

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
