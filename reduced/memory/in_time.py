"""Viscoelastic indentation on springs, exact in time: histories of depth or force, and impacts.

Every spring of the line follows (19.31), f = dx int E*(t - t') d(delta)/dt' dt' with
E* = 2 G/(1 - nu) (19.30), independently: it makes contact when the body reaches it, loses contact
when its force would become tensile, recovers freely, and may be touched again. For a body of
revolution with circular contact this is exact: the transform from an elastic half-space to springs
E* dx (Popov & Hess 2015) acts on space only, so it holds for every history. For growing contact it
gives Lee and Radok (1960), for unloading Ting (1968).

A rigid mass that strikes (19.3) has the equation of motion m d'' = -F with F the force of the row
of springs, including their history: the contact has no mass and responds instantly (19.3 (a)).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from reduced.errors import ConvergenceError, count_faults, positive_faults, refuse
from reduced.loads import Load, LoadPath
from reduced.memory.materials import Prony, contact_modulus
from reduced.memory.row import RelaxingSprings, SpringRow
from reduced.profiles.section import Profile
from reduced.springs.indent import indent
from reduced.springs.line import Springs

_ROUNDING = 4 * np.finfo(float).eps
_STALLED = 1e-12  # below this, a residual that stops decreasing is rounding of the sums


@dataclass(frozen=True)
class History:
    """Contact at k instants; arrays of shape (k,).

    The force at an instant is that for the velocity before it (relevant only with a parallel
    dashpot). If a time occurs twice, the second entry is after the jump. `contact_length` is 2 a
    unless the contact is a ring; `spacing` is dx.
    """

    time: np.ndarray
    penetration: np.ndarray
    force: np.ndarray
    contact_radius: np.ndarray
    contact_length: np.ndarray
    spacing: float


def harmonic_stiffness(
    material: Prony,
    contact_radius: float | np.ndarray,
    frequency: float | np.ndarray,
    *,
    poisson_ratio: float = 0.5,
) -> np.ndarray:
    """Return the complex stiffness 2 a E*(w) of a contact of constant size (19.30).

    Real part: force in phase with the depth; imaginary part over w: damping. It holds for a flat
    punch, and for other shapes at amplitudes too small to change the contact radius. Radius a > 0
    and angular frequency w >= 0 broadcast.

    >>> from reduced.memory.materials import kelvin_voigt
    >>> complex(harmonic_stiffness(kelvin_voigt(1.0, 0.5), 1.0, 2.0))  # 8 G a (1 + i w eta/G)
    (8+8j)
    """
    radius = np.asarray(contact_radius, dtype=float)
    if not (np.isfinite(radius).all() and (radius > 0).all()):
        raise ValueError(f"contact_radius must be finite and positive, got {contact_radius!r}")
    return 2 * radius * contact_modulus(material, poisson_ratio).complex_modulus(frequency)


def indent_in_time(springs: RelaxingSprings, time: ArrayLike, path: LoadPath) -> History:
    """Solve the indentation of a viscoelastic half-space along a history of depth or force.

    Depth or force is linear between the times, which do not decrease; a repeated time is a jump,
    and so is a non-zero first value. Under prescribed depth (of any sign) every spring is exact for
    any step, so that only dx has to converge (as dx^2). Under prescribed force (positive, the first
    may be 0) the depth is linear in every step, with an error of dt^2; the force is met at the ends
    of steps, or in the middle if a parallel dashpot hides jumps of the velocity. (With a dashpot
    and a curved body the depth starts as t^(2/3): grade the times, `graded_times`.) Then
    `per_radius` refers to the largest depth of the history for a contact that never shrinks.

    >>> from reduced.profiles.equivalents import paraboloid
    >>> from reduced.memory.materials import prony
    >>> ball = RelaxingSprings(paraboloid(1.0), prony(0.0, [0.25], [1.0]))
    >>> held = indent_in_time(ball, [0.0, 2.0], LoadPath("penetration", [0.01, 0.01]))
    >>> np.round(held.force * 1e3, 6)  # (4/3) E* sqrt(R) d^1.5, then exp(-t/tau) of it
    array([1.333333, 0.180447])
    """
    forced = path.one_of("penetration", "force") == "force"
    law, values = springs.modulus, path.values
    times = np.array(time, dtype=float, ndmin=1)
    wrong = []
    if times.shape != values.shape:
        wrong.append(
            f"time and {path.control} must be lists of one length, got {times.shape}, "
            f"{values.shape}"
        )
    if not (np.isfinite(times).all() and (np.diff(times) >= 0).all()):
        wrong.append(f"time must be finite and not decreasing, got {time!r}")
    if forced and not (values[0] >= 0 and (values[1:] > 0).all()):
        wrong.append(f"force must be positive (the first may be 0), got {values}")
    elif not (values > 0).any():
        wrong.append(f"{path.control} must be positive somewhere, got {values}")
    if law.viscosity > 0 and not forced and not wrong:  # no jump of the depth during contact
        at_once = np.diff(times, prepend=times[0]) == 0
        change = np.diff(values, prepend=0.0)[at_once]
        before = np.concatenate([[0.0], values])[:-1][at_once]
        if np.any((change != 0) & ((before > 0) | (before + change > 0))):
            wrong.append("penetration jumps, which a parallel dashpot does not let it")
    refuse(wrong)
    durations = np.diff(times, prepend=times[0])
    if not forced:
        row = SpringRow(springs, values.max())
        states = [row.go(d, h) for d, h in zip(values, durations, strict=True)]
        forces, lengths, radii = (np.array(column) for column in zip(*states, strict=True))
        return History(times, values, forces, radii, lengths, row.spacing)
    # the largest depth for a contact that never shrinks, A(d) = int J*(t - s) dF(s), increments of
    # the force in the middle of the steps; it only sets the spacing
    creep = law.creep()
    missing = np.zeros(creep.times.size)
    flow, largest, before = 0.0, 0.0, 0.0
    for duration, value in zip(durations, values, strict=True):
        decay = np.exp(-0.5 * duration / creep.times)
        missing = (missing * decay + creep.compliances * (value - before)) * decay
        flow += duration * (value + before) / 2
        total = (creep.instantaneous + creep.compliances.sum()) * value - missing.sum()
        largest, before = max(largest, total + creep.fluidity * flow), value
    deepest = indent(Springs(springs.profile, 1.0), Load("force", [largest])).penetration[0]
    row = SpringRow(springs, float(deepest))
    # With a parallel dashpot a jump of the force is a jump of the velocity, so the force is met in
    # the middle of a step, where the velocity is accurate to second order.
    place = 0.5 if law.viscosity > 0 else 1.0
    steps, before, rate = [], values[0], 0.0
    for duration, value in zip(durations, values, strict=True):
        depth = row.depth
        if value > 0 and (duration > 0 or law.viscosity == 0):
            target = before + place * (value - before)
            part = place * duration
            depth = _depth_under(row, springs.profile, law, target, part, row.depth + rate * part)
            depth = row.depth + (depth - row.depth) / place
            rate = (depth - row.depth) / duration if duration > 0 else 0.0
        _, length, radius = row.go(depth, duration)
        steps.append((depth, radius, length))
        before = value
    depths, radii, lengths = (np.array(column) for column in zip(*steps, strict=True))
    return History(times, depths, values, radii, lengths, row.spacing)


def graded_times(duration: float, steps: int, exponent: float = 3.0) -> np.ndarray:
    """Return T (k/n)^p, k = 0 ... n, fine at the start, where creep with a dashpot is singular.

    >>> graded_times(8.0, 2).tolist()
    [0.0, 1.0, 8.0]
    """
    refuse(positive_faults(duration=duration, exponent=exponent) + count_faults(steps=steps))
    return duration * np.linspace(0.0, 1.0, steps + 1) ** exponent


def _depth_under(
    row: SpringRow, profile: Profile, law: Prony, target: float, duration: float, guess: float
) -> float:
    """Return the depth after a time at which the row carries a force, by bracketed Newton steps."""
    stiffness = law.ramp_modulus(duration)
    if law.viscosity > 0:
        stiffness += law.viscosity / duration
    low, high, depth = -np.inf, np.inf, guess
    history: list[float] = []
    for _ in range(100):
        force, length, _ = row.trial(depth, duration)
        history.append(abs(force / target - 1))
        stalled = history[-1] < _STALLED and len(history) > 1 and history[-1] >= history[-2]
        if history[-1] <= _ROUNDING or stalled:
            return depth
        low, high = (depth, high) if force < target else (low, depth)
        if length > 0:
            change = (target - force) / (stiffness * length)
        else:
            change = float(
                indent(Springs(profile, stiffness), Load("force", [target])).penetration[0]
            )
        overshoot = not low < depth + change < high
        if overshoot and np.isfinite(high - low):
            change = (low + high) / 2 - depth
        depth += change
        if abs(change) <= _ROUNDING * abs(depth):
            return depth
    raise ConvergenceError("no depth carries the force", history)


_ROUNDS = 60
_LONGEST = 200  # longest contact in units of the elastic contact time


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
    order, stable at any step, also with a parallel dashpot). There are `steps` in three times d/v,
    about the duration of an elastic impact, d the depth estimated from the energy, to which
    `per_radius` refers. ConvergenceError if the body does not rebound within 200 times that.

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
        modulus = law.ramp_modulus(time) + law.viscosity / time
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
    row, speed = SpringRow(springs, depth), velocity
    path = [(0.0, 0.0, velocity, 0.0)]

    def mean_velocity(duration: float) -> float:
        """Return V of a step, by Newton's method on 2 m (V - v) + dt F(V) in a bracket."""
        half, slope = duration / 2, speed
        stiffness = law.ramp_modulus(half)
        low, high, history = -np.inf, np.inf, []
        for _ in range(_ROUNDS):
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
            for _ in range(_ROUNDS):
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
