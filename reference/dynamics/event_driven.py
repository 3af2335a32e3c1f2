"""Blocks with Coulomb friction, exact between the events: slip, stick, reversal.

While no block changes between stick and slip, the equations are linear with constant
coefficients in z = (x, w, 1, cos(W t), sin(W t)): z' = A z and z(t) = exp(A t) z(0), for any
frequencies, damping or resonance. Only the ends of phases have to be located: when a sliding speed
reaches zero, or the force on a sticking block reaches its limit.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import eigvals, expm
from scipy.optimize import brentq

from reference.dynamics.blocks import (
    Array,
    Blocks,
    System,
    in_units,
    initial_state,
    natural_units,
)
from reference.errors import ConvergenceError

# Samples per shortest period, enough not to miss two extrema of a sum of harmonics between samples.
_SAMPLES = 32
_ROUNDING = 16 * float(np.finfo(float).eps)  # of a sum, relative to its absolute terms
_DOUBLINGS = 10  # number of halvings of the regular step for the first sample after an event


class Phase(NamedTuple):
    """The phase between two events.

    Attributes
    ----------
    start : float
        Start time in the motion's unit of time.
    direction : ndarray of int, shape (n,)
        0 for a sticking block, else the sign of its sliding velocity.
    state : ndarray, shape (2n + 3,)
        z at the start.
    matrix : ndarray
        A.
    """

    start: float
    direction: np.ndarray
    state: Array
    matrix: Array


@dataclass(frozen=True)
class Motion:
    """The exact motion, to be evaluated at any time.

    Attributes
    ----------
    phases : list of Phase
        Phases in the units of length and time below.
    duration : float
        Duration of the computed motion.
    belt : ndarray, shape (n,)
        V.
    length, time : float
        Units of the phases, powers of two.
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

    def time_sticking(self, block: int = 0) -> float:
        """Return the total sticking time of a block."""
        starts = np.array([0.0, *self.events])
        sticks = np.array([phase.direction[block] == 0 for phase in self.phases])
        return float(np.diff([*starts, self.duration]) @ sticks)


def follow(
    blocks: Blocks,
    duration: float,
    *,
    position: ArrayLike = 0.0,
    velocity: ArrayLike = 0.0,
    most_events: int = 10_000,
) -> Motion:
    """Return the motion of the blocks from t = 0 to `duration`.

    A block that comes to rest on its support sticks if the force on it is at most mu_s F_N, else it
    moves in the direction of the force. Because the mass matrix is diagonal, blocks that stop at
    the same time are independent.

    Parameters
    ----------
    blocks : Blocks
    duration : float
        Positive.
    position, velocity : array_like, shape (n,)
        At t = 0.
    most_events : int
        Limit of events; more raise ConvergenceError.

    Examples
    --------
    >>> sled = follow(Blocks(1.0, 0.5), 10.0, velocity=2.0)
    >>> sled.events, round(float(sled.at(10.0)[0][0, 0]), 12)  # v^2/(2 mu g)
    (array([4.]), 4.0)
    """
    if not (np.isfinite(duration) and duration > 0):
        raise ValueError(f"duration must be finite and positive, not {duration!r}")
    system = blocks.arrays()
    x, v = initial_state(system, position, velocity)
    mass, length, unit = natural_units(system, x, v, duration)
    scaled = in_units(system, mass, length, unit)
    slip = v / (length / unit) - scaled.belt
    state = np.concatenate([x / length, slip, [1.0, 1.0, 0.0]])
    phases = _phases(scaled, state, np.where(slip < 0, -1, 1), duration / unit, most_events)
    return Motion(phases, float(duration), system.belt, length, unit)


def _phases(
    system: System, state: Array, direction: np.ndarray, duration: float, most_events: int
) -> list[Phase]:
    """Return the phases from event to event."""
    slip = state[direction.size : 2 * direction.size]
    direction = _at_rest(system, direction, state, np.flatnonzero(slip == 0))
    starting = (slip == 0) & (direction != 0)
    phases: list[Phase] = []
    time = 0.0
    while len(phases) <= most_events:
        phases.append(Phase(time, direction, state, _matrix(system, direction)))
        event = _next_event(system, phases[-1], duration - time, starting)
        if event is None:
            return phases
        time, state, starting = time + event.after, event.state, event.starting
        if event.sense:
            direction = direction.copy()
            direction[event.block] = event.sense
        else:
            direction = _at_rest(system, direction, state, [event.block])
        starting[event.block] = direction[event.block] != 0
    raise ConvergenceError(f"more than {most_events} events", [phase.start for phase in phases])


def _force_rows(system: System) -> Array:
    """Return rows G; G z is the force on the blocks without friction at the support's speed."""
    n = system.mass.size
    rows = np.zeros((n, 2 * n + 3))
    rows[:, :n], rows[:, n : 2 * n] = -system.stiffness, -system.damping
    rows[:, 2 * n] = system.load - system.damping @ system.belt
    rows[:, 2 * n + 1] = system.amplitude
    return rows


def _matrix(system: System, direction: np.ndarray) -> Array:
    """Return A of the phase: x' = w + V; w' = 0 for sticking blocks."""
    n = system.mass.size
    A = np.zeros((2 * n + 3,) * 2)
    A[:n, n : 2 * n], A[:n, 2 * n] = np.eye(n), system.belt
    A[n : 2 * n] = _force_rows(system) / system.mass[:, None]
    A[n : 2 * n, 2 * n] -= direction * system.kinetic / system.mass
    A[n : 2 * n][direction == 0] = 0
    A[-2, -1], A[-1, -2] = -system.frequency, system.frequency
    return A


def _at_rest(
    system: System, direction: np.ndarray, state: Array, resting: Sequence[int] | np.ndarray
) -> np.ndarray:
    """Return the directions after the `resting` blocks came to rest: 0 if they stick.

    A force beyond the limit moves a block. A force at the limit within rounding moves it if the
    force would grow during stick: a block that comes to rest at -mu_s F_N with the belt relaxing
    the spring sticks, and one that only touches rest continues to slide.
    """
    chosen = direction.copy()
    chosen[resting] = 0
    rows = _force_rows(system)
    rates = rows @ _matrix(system, chosen)
    force, rounding = rows @ state, _ROUNDING * (np.abs(rows) @ np.abs(state) + system.static)
    growth, slow = np.sign(force) * (rates @ state), _ROUNDING * (np.abs(rates) @ np.abs(state))
    excess = np.abs(force) - system.static
    torn = (excess > rounding) | ((excess > -rounding) & (growth > slow))
    for i in resting:
        chosen[i] = np.sign(force[i]) if torn[i] else 0
    return chosen


class Guard(NamedTuple):
    """A linear function of the state that is positive during a phase.

    Attributes
    ----------
    row : ndarray
        row z is the sliding speed of the block, or the distance of its force from the limit.
    block : int
    sense : int
        Event when row z becomes negative: -1, 1: the block starts to slide in that direction; 0: it
        comes to rest.
    """

    row: Array
    block: int
    sense: int


def _guards(system: System, direction: np.ndarray) -> list[Guard]:
    """Return the guards: one speed, or two distances to the limit, per block."""
    n = system.mass.size
    force = _force_rows(system)
    guards = []
    for i in range(n):
        row = np.zeros(2 * n + 3)
        if direction[i] != 0:
            row[n + i] = direction[i]
            guards.append(Guard(row, i, 0))
        else:
            row[2 * n] = system.static[i]
            guards += [Guard(row - sense * force[i], i, sense) for sense in (1, -1)]
    return guards


class Event(NamedTuple):
    """The end of a phase.

    Attributes
    ----------
    block, sense : int
        As for the triggering guard.
    after : float
        Time since the start of the phase.
    state : ndarray
        z, with exactly zero speed of a block that comes to rest.
    starting : ndarray of bool, shape (n,)
        Blocks whose sliding speed has not yet exceeded its rounding.
    """

    block: int
    sense: int
    after: float
    state: Array
    starting: np.ndarray


def _next_event(
    system: System, phase: Phase, remaining: float, starting: np.ndarray
) -> Event | None:
    """Return the first event within the time `remaining`, if there is one.

    The speed of a block that has just started to slide is zero with rounding of either sign: it
    cannot end a phase before it has become positive, in this or a later phase.
    """
    A, guards = phase.matrix, _guards(system, phase.direction)
    state, time, starting = phase.state, 0.0, starting.copy()
    regular = _regular_step(A, remaining)
    rows = np.array([guard.row for guard in guards])
    # Rounding of a guard's value and rate: that of their terms in a regular step, even for short
    # steps after an event, with the largest states so far in this phase.
    terms = np.abs(np.stack([rows, rows @ A], axis=1)) @ np.abs(expm(A * regular))
    sizes = np.abs(state)
    for step, propagator in _steps(A, regular, remaining):
        later = _sticking_exactly(phase, propagator @ state)
        sizes = np.maximum(sizes, np.abs(later))
        rounding = _ROUNDING * (terms @ sizes)
        stretch, crossings = Stretch(state, step, later), []
        for k, (row, block, sense) in enumerate(guards):
            excused = sense == 0 and bool(starting[block])
            after = _crossing(row, phase, stretch, rounding[k], starting=excused)
            if after is not None:
                crossings.append((after, k))
        if crossings:
            after, k = min(crossings)
            _, block, sense = guards[k]
            state = _propagated(phase, after, state)
            if sense == 0:
                state[starting.size + block] = 0.0  # zero up to rounding
            return Event(block, sense, time + after, state, starting)
        state = later
        for k, (row, block, sense) in enumerate(guards):
            starting[block] &= sense != 0 or row @ state <= rounding[k, 0]
        time += step
    return None


def _propagated(phase: Phase, time: float, state: Array) -> Array:
    """Return exp(A t) z."""
    return _sticking_exactly(phase, expm(phase.matrix * time) @ state)


def _sticking_exactly(phase: Phase, state: Array) -> Array:
    """Set the components of a propagated state that are known exactly.

    A zero row of A is a row of the identity in exp(A t), but the linear solve rounds differently on
    every processor: a sticking block would have a speed of arbitrary sign.
    """
    n = phase.direction.size
    state[n : 2 * n][phase.direction == 0] = 0.0
    state[2 * n] = 1.0
    return state


def _regular_step(A: Array, remaining: float) -> float:
    """Return the step between the regular samples of a phase."""
    rate = float(np.abs(eigvals(A)).max())
    regular = remaining / _SAMPLES
    if rate * regular > 2 * np.pi / _SAMPLES:
        regular = 2 * np.pi / (_SAMPLES * rate)
    return regular


def _steps(A: Array, regular: float, remaining: float) -> Iterator[tuple[float, Array]]:
    """Yield steps and their propagators up to `remaining`: doubling at first, then regular.

    Every propagator is computed as an exponential; squaring the previous one would double its
    rounding.
    """
    step = regular * 2.0**-_DOUBLINGS
    propagator, time, first = expm(A * step), 0.0, True
    while time + step < remaining:
        yield step, propagator
        time += step
        if not first and step < regular:  # the first step is repeated: 1, 1, 2, 4, ...
            step *= 2
            propagator = expm(A * step)
        first = False
    yield remaining - time, expm(A * (remaining - time))


class Stretch(NamedTuple):
    """State, time to the next sample, and the state there."""

    state: Array
    step: float
    after: Array


def _crossing(
    row: Array, phase: Phase, stretch: Stretch, rounding: Array, *, starting: bool
) -> float | None:
    """Return the time in the interval at which row z first becomes negative.

    Negative means beyond the `rounding` of value and rate: a guard that touches zero does not
    trigger. A guard that is zero initially triggers there if it decreases, or after its maximum if
    it first increases (or if the block is `starting`).
    """
    state, step, after = stretch
    rate = row @ phase.matrix

    def value(time: float, line: Array) -> float:
        return float(line @ (_propagated(phase, time, state) if time else state))

    def root(line: Array, since: float, until: float) -> float:
        precision = 4 * float(np.finfo(float).eps)
        return brentq(value, since, until, args=(line,), xtol=precision * until, rtol=precision)

    below = row @ after < -rounding[0]
    if row @ state <= rounding[0]:
        if rate @ state < -rounding[1] and not starting:
            return 0.0
        if not below:
            return None
        top = root(rate, 0.0, step) if rate @ state > 0 > rate @ after else 0.0
        return root(row, top, step) if value(top, row) > 0 else top
    if below:
        return root(row, 0.0, step)
    if rate @ state < 0 < rate @ after:
        lowest = root(rate, 0.0, step)
        if value(lowest, row) < -rounding[0]:
            return root(row, 0.0, lowest)
    return None
