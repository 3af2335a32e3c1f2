"""Blocks with Coulomb friction, exact between the events: slip, stick, reversal.

While no block changes between sticking and sliding the equations are linear with constant
coefficients in z = (x, w, 1, cos(W t), sin(W t)): z' = A z and z(t) = exp(A t) z(0), whatever the
frequencies, damping or resonance. What remains is to find when a phase ends: when a sliding speed
reaches zero, or the force on a sticking block reaches its limit.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import eigvals, expm
from scipy.optimize import brentq

from reference.dynamics.blocks import Array, Blocks, in_units, initial_state, natural_units
from reference.errors import ConvergenceError

# Samples per shortest period: of a sum of harmonics, no two extrema are missed between two.
_SAMPLES = 32
_DOUBLINGS = 10  # the first sample after an event lies so many halvings before the regular one


class Phase(NamedTuple):
    """Time between two events.

    Attributes
    ----------
    start : float
        Time at which it begins, in the motion's unit of time.
    direction : ndarray of int, shape (n,)
        0 where a block sticks, else the sign of its sliding velocity.
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
        In the units of length and time below.
    duration : float
        Up to here the motion is known.
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
        asked = np.atleast_1d(np.asarray(times, float))
        if not ((asked >= 0) & (asked <= self.duration)).all():
            raise ValueError(f"times must lie in [0, {self.duration!r}], not {times!r}")
        starts = np.array([phase.start for phase in self.phases])
        which = np.searchsorted(starts, asked / self.time, side="right") - 1
        states = np.empty((asked.size, self.phases[0].state.size))
        for k in np.unique(which):
            phase, mine = self.phases[k], which == k
            after = (asked[mine] / self.time - phase.start)[:, None, None]
            states[mine] = expm(phase.matrix * after) @ phase.state
        n = self.belt.size
        speed = self.length / self.time
        return self.length * states[:, :n], speed * states[:, n : 2 * n] + self.belt

    @property
    def events(self) -> Array:
        """Times at which a block begins to slide, to stick or turns back."""
        return self.time * np.array([phase.start for phase in self.phases[1:]])

    def time_sticking(self, block: int = 0) -> float:
        """Return the whole time for which a block sticks."""
        starts = np.array([0.0, *self.events])
        sticks = np.array([phase.direction[block] == 0 for phase in self.phases])
        return float(np.diff([*starts, self.duration]) @ sticks)


def follow(
    system: Blocks,
    duration: float,
    *,
    position: ArrayLike = 0.0,
    velocity: ArrayLike = 0.0,
    most_events: int = 10_000,
) -> Motion:
    """Follow the blocks from t = 0 to `duration`.

    A block that comes to rest on its ground sticks if the force on it is at most mu_s F_N, else it
    goes on in the direction of the force. Since the mass matrix is diagonal, blocks that stop at
    the same time decide for themselves.

    Parameters
    ----------
    system : Blocks
    duration : float
        Positive.
    position, velocity : array_like, shape (n,)
        At t = 0.
    most_events : int
        More raise ConvergenceError.

    Examples
    --------
    >>> from reference.dynamics.blocks import blocks
    >>> sled = follow(blocks(1.0, 0.5), 10.0, velocity=2.0)
    >>> sled.events, round(float(sled.at(10.0)[0][0, 0]), 12)  # v^2/(2 mu g)
    (array([4.]), 4.0)
    """
    if not (np.isfinite(duration) and duration > 0):
        raise ValueError(f"duration must be finite and positive, not {duration!r}")
    x, v = initial_state(system, position, velocity)
    mass, length, unit = natural_units(system, x, v, duration)
    scaled = in_units(system, mass, length, unit)
    slip = v / (length / unit) - scaled.belt
    state = np.concatenate([x / length, slip, [1.0, 1.0, 0.0]])
    phases = _phases(scaled, state, np.where(slip < 0, -1, 1), duration / unit, most_events)
    return Motion(phases, float(duration), system.belt, length, unit)


def _phases(
    system: Blocks, state: Array, direction: np.ndarray, duration: float, most_events: int
) -> list[Phase]:
    """Go from event to event."""
    fresh = np.ones(direction.size, bool)
    phases: list[Phase] = []
    time = 0.0
    while len(phases) <= most_events:
        direction = _decide(system, direction, state, fresh)
        phases.append(Phase(time, direction, state, _matrix(system, direction)))
        found = _next_event(system, phases[-1], duration - time, fresh)
        if found is None:
            return phases
        block, after, state = found
        time += after
        fresh = np.arange(direction.size) == block
    raise ConvergenceError(f"more than {most_events} events", [phase.start for phase in phases])


def _force_rows(system: Blocks) -> Array:
    """Rows G with G z the force on each block without friction, at the ground's speed added."""
    n = system.mass.size
    rows = np.zeros((n, 2 * n + 3))
    rows[:, :n], rows[:, n : 2 * n] = -system.stiffness, -system.damping
    rows[:, 2 * n] = system.load - system.damping @ system.belt
    rows[:, 2 * n + 1] = system.amplitude
    return rows


def _matrix(system: Blocks, direction: np.ndarray) -> Array:
    """Return A of the phase: x' = w + V; w' = 0 where a block sticks."""
    n = system.mass.size
    A = np.zeros((2 * n + 3,) * 2)
    A[:n, n : 2 * n], A[:n, 2 * n] = np.eye(n), system.belt
    A[n : 2 * n] = _force_rows(system) / system.mass[:, None]
    A[n : 2 * n, 2 * n] -= direction * system.kinetic / system.mass
    A[n : 2 * n][direction == 0] = 0
    A[-2, -1], A[-1, -2] = -system.frequency, system.frequency
    return A


def _decide(system: Blocks, direction: np.ndarray, state: Array, fresh: np.ndarray) -> np.ndarray:
    """Choose stick or slip for the blocks that an event (or the start) leaves open.

    `direction` is that before the event: a sliding block has come to rest, a sticking one is torn
    off.
    """
    n = system.mass.size
    chosen, slip = direction.copy(), state[n : 2 * n]
    force = _force_rows(system) @ state
    for i in np.flatnonzero(fresh):
        if slip[i] != 0:
            chosen[i] = np.sign(slip[i])
        elif direction[i] != 0 and abs(force[i]) <= system.static[i]:
            chosen[i] = 0
        else:
            chosen[i] = np.sign(force[i])
    return chosen


def _guards(system: Blocks, direction: np.ndarray) -> tuple[Array, np.ndarray]:
    """Rows with row z >= 0 as long as the phase lasts, and the block that each belongs to."""
    n = system.mass.size
    force = _force_rows(system)
    rows, owners = [], []
    for i in range(n):
        if direction[i] != 0:
            speed = np.zeros(2 * n + 3)
            speed[n + i] = direction[i]
            rows.append(speed)
            owners.append(i)
        else:
            limit = np.zeros(2 * n + 3)
            limit[2 * n] = system.static[i]
            rows += [limit - force[i], limit + force[i]]
            owners += [i, i]
    return np.array(rows), np.array(owners)


def _next_event(
    system: Blocks, phase: Phase, rest: float, fresh: np.ndarray
) -> tuple[int, float, Array] | None:
    """Return block, time after the phase's start and state of the first event, if there is one.

    The speed of a block that has just begun to slide is zero: it may not end the phase before it
    has become positive.
    """
    A, n = phase.matrix, system.mass.size
    rows, owners = _guards(system, phase.direction)
    excused = fresh[owners] & (phase.direction[owners] != 0)
    state, time = phase.state, 0.0
    for step, propagator in _steps(A, rest):
        later = propagator @ state
        events = [
            (after, owners[k])
            for k in range(len(rows))
            if (after := _crossing(rows[k], A, state, later, step, bool(excused[k]))) is not None
        ]
        if events:
            after, block = min(events)
            state = expm(A * after) @ state
            if phase.direction[block] != 0:
                state[n + block] = 0.0  # up to rounding it is
            return int(block), time + after, state
        state = later
        excused &= rows @ state <= 0
        time += step
    return None


def _steps(A: Array, rest: float) -> Iterator[tuple[float, Array]]:
    """Yield steps and their propagators up to `rest`: doubling at first, then regular.

    Each propagator is an exponential of its own: squaring the one before doubles its rounding.
    """
    rate = float(np.abs(eigvals(A)).max())
    regular = rest / _SAMPLES
    if rate * regular > 2 * np.pi / _SAMPLES:
        regular = 2 * np.pi / (_SAMPLES * rate)
    step = regular * 2.0**-_DOUBLINGS
    propagator, time, first = expm(A * step), 0.0, True
    while time + step < rest:
        yield step, propagator
        time += step
        if not first and step < regular:  # the first is taken twice: 1, 1, 2, 4, ...
            step *= 2
            propagator = expm(A * step)
        first = False
    yield rest - time, expm(A * (rest - time))


def _crossing(
    row: Array, A: Array, state: Array, after: Array, step: float, excused: bool
) -> float | None:
    """Return the time at which row z first becomes negative between `state` and `after`."""
    rate = row @ A
    if row @ state <= 0:
        return None if excused or rate @ state >= 0 else 0.0

    def value(time: float, line: Array) -> float:
        return float(line @ (expm(A * time) @ state))

    def root(line: Array, until: float) -> float:
        precision = 4 * float(np.finfo(float).eps)
        return brentq(value, 0, until, args=(line,), xtol=precision * until, rtol=precision)

    if row @ after <= 0:
        return root(row, step)
    if rate @ state < 0 < rate @ after:
        lowest = root(rate, step)
        if value(lowest, row) < 0:
            return root(row, lowest)
    return None
