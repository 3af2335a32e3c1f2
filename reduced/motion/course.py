"""A rigid mass on a reduced contact (Fig. 19.4) by time stepping: impact, bounce, vibration.

    m x'' = f(t) + P cos(W t) - c x' - F(x),   x the penetration (negative: in flight, F = 0)

F is the force of the springs (19.14) under the profile, with sub-cell contact edges.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import ArrayLike
from scipy.interpolate import CubicHermiteSpline

from reduced.errors import (
    ConvergenceError,
    choice_faults,
    count_faults,
    finite_faults,
    nonnegative_faults,
    positive_faults,
    refuse,
)
from reduced.motion.elastic_impact import SpringContact
from reduced.profiles.quadrature import gauss_legendre
from reduced.springs.line import SmoothLine, respond


@dataclass(frozen=True)
class Stepping:
    """Equal time steps, of which every `stride`-th is recorded; `steps` is a multiple of it.

    >>> Stepping(0.5, 4, stride=2).times
    array([0., 1., 2.])
    """

    step: float
    steps: int
    stride: int = 1

    def __post_init__(self) -> None:
        wrong = count_faults(steps=self.steps, stride=self.stride)
        if not wrong and self.steps % self.stride:
            wrong.append(f"steps must be a multiple of stride = {self.stride}, got {self.steps}")
        refuse(positive_faults(step=self.step) + wrong)

    @property
    def records(self) -> int:
        """Number of records, including the start."""
        return int(self.steps // self.stride) + 1

    @property
    def times(self) -> np.ndarray:
        """Times of the records, from 0."""
        return self.step * self.stride * np.arange(self.records)


SCHEMES = ("verlet", "yoshida", "energy")
_CUBE_ROOT = 2.0 ** (1 / 3)
# Verlet steps of a fourth-order step (Yoshida 1990).
_YOSHIDA = (1 / (2 - _CUBE_ROOT), -_CUBE_ROOT / (2 - _CUBE_ROOT), 1 / (2 - _CUBE_ROOT))
_NODES, _WEIGHTS = (tuple(map(float, part)) for part in gauss_legendre(4))
_EPSILON = float(np.finfo(float).eps)


@dataclass(frozen=True)
class Motion:
    """Motion at the recorded times; all arrays have shape (k,).

    Force and energy are those of the springs at x; `evaluations` counts the contact law; `pull` is
    f/m, the acceleration in flight.
    """

    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    force: np.ndarray
    energy: np.ndarray
    evaluations: int
    pull: float

    def at(self, times: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Return position and velocity at any times, by Hermite cubics between the records."""
        t = np.asarray(times, dtype=float)
        end = self.time[-1] * (1 + 4 * _EPSILON)
        if not ((t >= 0) & (t <= end)).all():
            raise ValueError(f"times must lie in [0, {self.time[-1]!r}], got {times!r}")
        curve = CubicHermiteSpline(self.time, self.position, self.velocity)
        return curve(t), curve(t, 1)

    def release(self) -> tuple[float, float]:
        """Return time and velocity at the first loss of contact.

        By the flight under the constant load alone, backwards from the first record out of contact.
        """
        leaving = np.flatnonzero((self.position[:-1] > 0) & (self.position[1:] <= 0))
        if leaving.size == 0:
            raise ConvergenceError(
                "the mass did not leave the contact", self.position[-1:].tolist()
            )
        k = int(leaving[0]) + 1
        height, speed = -self.position[k], -self.velocity[k]
        parting = float(np.sqrt(speed**2 + 2 * self.pull * height))
        return float(self.time[k] - 2 * height / (speed + parting)), -parting


@dataclass(frozen=True)
class Mass:
    """A rigid mass m > 0 with damping c >= 0, and its position and velocity at t = 0."""

    mass: float
    damping: float = 0.0
    position: float = 0.0
    velocity: float = 0.0

    def __post_init__(self) -> None:
        refuse(
            positive_faults(mass=self.mass)
            + nonnegative_faults(damping=self.damping)
            + finite_faults(position=self.position, velocity=self.velocity)
        )


@dataclass(frozen=True)
class Push:
    """Force on a mass over time: f + P cos(W t), and a history of increasing times and forces.

    The history is added: linear in between, constant outside. Energy is conserved while the force
    is constant.
    """

    load: float = 0.0
    amplitude: float = 0.0
    frequency: float = 0.0
    history: tuple[ArrayLike, ArrayLike] = (0.0, 0.0)

    def __post_init__(self) -> None:
        parts = finite_faults(load=self.load, amplitude=self.amplitude, frequency=self.frequency)
        times, forces = self.table
        finite = np.isfinite(times).all() and np.isfinite(forces).all()
        if times.shape != forces.shape or not finite or not (np.diff(times) > 0).all():
            parts.append(
                f"history must be increasing times with a force each, got {self.history!r}"
            )
        refuse(parts)

    @property
    def table(self) -> tuple[np.ndarray, np.ndarray]:
        """Times and forces of the history."""
        times, forces = (np.array(part, float, ndmin=1) for part in self.history)
        return times, forces


AT_REST = Push()


def move(
    contact: SpringContact,
    mass: Mass,
    stepping: Stepping,
    push: Push = AT_REST,
    scheme: str = "energy",
) -> Motion:
    """Integrate the motion of a mass on a contact with sub-cell edges.

    - ``"verlet"``: kick, drift, kick; explicit, symplectic, second order; stable for h w < 2, w the
      largest frequency sqrt(F'(x)/m) of the motion.
    - ``"yoshida"``: three Verlet steps, one backwards: fourth order while in contact, but not
      across first touch, where the force of a ball, x^1.5, is not smooth.
    - ``"energy"``: implicit, m (v+ - v)/h = f - (U(x+) - U(x))/(x+ - x) with x+ - x = h (v + v+)/2:
      second order, stable for any step, and conserves m v^2/2 + U - f x to round-off (Gonzalez
      1996), so that an elastic impact has no loss at any step.

    Damping acts by its exact factor exp(-c h/(2 m)) before and after every step.

    >>> from reduced.motion.elastic_impact import SpringContact
    >>> from reduced.profiles.equivalents import cylinder
    >>> from reduced.springs.line import Springs
    >>> disc = SpringContact(Springs(cylinder(0.5), 1.0), 1.0)  # stiffness 2 E* a = 1: half a sine
    >>> time, speed = move(disc, Mass(1.0, velocity=1.0), Stepping(0.001, 4000)).release()
    >>> round(time, 5), round(speed, 6)
    (3.14159, -1.0)
    """
    wrong = choice_faults("scheme", scheme, SCHEMES)
    if not isinstance(contact.line, SmoothLine):
        raise ValueError("; ".join([*wrong, "the contact's edges must be 'sub_cell'"]))
    refuse(wrong)
    records = np.empty((2, stepping.records))
    records[:, 0] = mass.position, mass.velocity
    parts = (1.0,) if scheme != "yoshida" else _YOSHIDA
    evaluations, failed = _move(
        (tuple(contact.line.halves), contact.effective_modulus),
        scheme == "energy",
        parts,
        float(mass.mass),
        float(mass.damping),
        (float(push.load), float(push.amplitude), float(push.frequency), *push.table),
        float(stepping.step),
        int(stepping.stride),
        records,
    )
    if failed >= 0 or not np.isfinite(records).all():
        at = max(failed, 0)
        raise ConvergenceError(f"{scheme}: no finite position at step {at}", [stepping.step])
    force, energy, _ = contact.respond(records[0])
    pull = float(push.load / mass.mass)
    position, velocity = records
    return Motion(stepping.times, position, velocity, force, energy, int(evaluations), pull)


@njit(cache=True)
def _law(contact, x, out):
    """Write stiffness, force and energy of the contact at x to out[:, 0].

    `contact` are the cubics of both halves, and E*.
    """
    halves, modulus = contact
    out[:] = 0.0
    if x > 0.0:
        place = np.array([x])
        for half in halves:
            respond(half, place, out)
        out *= modulus


@njit(cache=True)
def _push(t, pushed):
    """Return the force on the mass: constant, harmonic and piecewise linear parts."""
    load, amplitude, frequency, times, forces = pushed
    push = load + amplitude * np.cos(frequency * t)
    k = np.searchsorted(times, t)
    if k == 0:
        return push + forces[0]
    if k == times.size:
        return push + forces[-1]
    share = (t - times[k - 1]) / (times[k] - times[k - 1])
    return push + (1.0 - share) * forces[k - 1] + share * forces[k]


@njit(cache=True)
def _move(contact, implicit, parts, mass, damping, pushed, step, stride, records):
    """Fill the records; return the evaluations of the law, and the failed step or -1."""
    x, v = records[0, 0], records[1, 0]
    out = np.empty((3, 1))
    _law(contact, x, out)
    force, evaluations = out[1, 0], 1
    for k in range((records.shape[1] - 1) * stride):
        t = k * step
        for part in parts:
            h = part * step
            decay = np.exp(-0.5 * damping * h / mass)
            v *= decay
            if implicit:
                push = _push(t + 0.5 * h, pushed)
                new, used = _implicit_position(contact, mass, push, x, v, h, out)
                if used < 0:
                    return evaluations, k
                evaluations += used
                v = 2.0 * (new - x) / h - v
                x = new
            else:
                v += 0.5 * h / mass * (_push(t, pushed) - force)
                x += h * v
                _law(contact, x, out)
                force = out[1, 0]
                evaluations += 1
                v += 0.5 * h / mass * (_push(t + h, pushed) - force)
            v *= decay
            t += h
        if (k + 1) % stride == 0:
            records[0, (k + 1) // stride], records[1, (k + 1) // stride] = x, v
    return evaluations, -1


@njit(cache=True)
def _implicit_position(contact, mass, push, x, v, h, out):
    """Solve y = x + h v + h^2/(2 m) (push - mean force between x and y); evaluations, or -1.

    The mean force increases with y, so the difference of both sides has a slope of at least 1:
    Newton's method inside a shrinking bracket.
    """
    free = x + h * v + 0.5 * h * h / mass * push
    gain = 0.5 * h * h / mass
    _law(contact, x, out)
    start_force, start_energy = out[1, 0], out[2, 0]
    _law(contact, free, out)
    low, high = free - gain * max(start_force, out[1, 0]), free
    y, used = free - gain * start_force, 2
    scale = abs(x) + abs(h * v) + abs(free)
    for _ in range(100):
        # the mean of F between x and y, (U(y) - U(x))/(y - x), and its derivative in y; close to x,
        # where digits cancel, by a Gauss rule
        _law(contact, y, out)
        stiffness, force, energy = out[0, 0], out[1, 0], out[2, 0]
        way = y - x
        used += 1
        if abs(way) > 1e-3 * max(abs(x), abs(y)):
            mean = (energy - start_energy) / way
            slope = (force - mean) / way
        else:
            mean, slope = 0.0, 0.5 * stiffness
            for k in range(len(_NODES)):
                _law(contact, x + _NODES[k] * way, out)
                mean += _WEIGHTS[k] * out[1, 0]
            used += len(_NODES)
        excess = y + gain * mean - free
        if excess > 0.0:
            high = y
        else:
            low = y
        new = y - excess / (1.0 + gain * slope)
        # The residual is accurate to a rounding or two of its terms; below this, steps may
        # alternate.
        if abs(new - y) <= 4.0 * _EPSILON * scale:
            return new, used
        y = new if low <= new <= high else 0.5 * (low + high)
    return y, -1
