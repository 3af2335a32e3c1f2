"""Hereditary integrals of Lee & Radok and of Ting for bodies of revolution, by quadrature.

With A(d) the force of an elastic half-space of E* = 1 at depth d, E*(t) = 2 G(t)/(1 - nu) and
J* its creep function:

- while the contact grows (Lee & Radok, J. Appl. Mech. 27 (1960) 438):
  F(t) = int_0^t E*(t - s) d[A(d(s))],  A(d(t)) = int_0^t J*(t - s) dF(s),  a = a(d);
- while it shrinks after one maximum (Ting, J. Appl. Mech. 33 (1966) 845; 35 (1968) 248): the
  contact is that of the loading at t1(t) with int_t1^t E*(t - s) d'(s) ds = 0, and F(t) = int_0^t1
  E*(t - s) d[A(d(s))].

Ting's t1 must not increase again: if a retreat slows down, the recovering surface catches up with
the body, which then touches parts that have been free, and the solution no longer holds. Such
histories are refused. Histories are linear between given times, and may begin with a jump d0, which
adds E*(t) A(d0) or, once the contact is smaller than that of the jump, is replaced by the depth h <
d0 of the spring without force, E*(t) (d0 - h) + int E*(t - s) d'(s) ds = 0, with F = E*(t) A(h).
Nothing is discretised in space.

`impact` is an initial value problem, m d'' = -F(t) with F of Lee & Radok on approach and of Ting on
rebound, quasi-static: the speed is far below that of sound (19.3). For Maxwell arms the hereditary
integrals are states,

    z_j' = A'(d) d' - z_j/tau_j,   s_j' = d' - s_j/tau_j,

F = G_0 A + sum G_j z_j + eta A' d' on approach (times E*/G); on rebound F follows from the decay of
these z_j, stopped at t1(t), with t1 the root of the force of a spring first touched then. The
contact is lost when that root is the time of first touch.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from reference.arrays import Array
from reference.closed_form.form import ClosedForm, require_positive
from reference.closed_form.numerics import gauss_rule
from reference.errors import ConvergenceError, poisson_faults, refuse
from reference.loads import History
from reference.viscoelastic.materials import GeneralisedMaxwell

_NODES = (14, 24)  # their difference is the error estimate of the first rule
_SAMPLES = 24  # samples per piece of the retreat
_LEVELS = 36  # halvings towards the ends of a segment, where d^(1/2) or fast arms vary


@dataclass(frozen=True)
class Curve:
    """Contact along a history; arrays have the shape of the requested times.

    `error` estimates that of the force (or of the depth, if the force is given) from quadrature and
    rounding.
    """

    time: Array
    penetration: Array
    force: Array
    contact_radius: Array
    error: Array


def contact_factor(poisson_ratio: float) -> float:
    """Return E*/G = 2/(1 - nu), constant in time (4 for rubber)."""
    refuse(poisson_faults(poisson_ratio))
    return 2 / (1 - poisson_ratio)


class _Path:
    """A history as few linear pieces: values at times, and slopes between."""

    def __init__(self, history: History) -> None:
        time, values = history.time, history.values
        if time.size < 2:
            raise ValueError(f"a history of the integrals needs two times, not {time!r}")
        # changes by rounding count as zero, and consecutive pieces of equal slope are merged
        still = np.abs(np.diff(values)) <= 1e-13 * np.abs(values).max()
        slopes = np.where(still, 0.0, np.diff(values) / np.diff(time))
        bends = np.abs(np.diff(slopes)) > 1e-9 * np.abs(slopes).max(initial=0.0)
        corners = np.flatnonzero(np.concatenate([[True], bends, [True]]))
        flat = np.append(slopes[corners[:-1]] == 0, False)
        values = values.copy()
        values[corners[1:][flat[:-1]]] = values[corners[:-1][flat[:-1]]]
        self.time, self.value = time[corners], values[corners]
        self.slopes = np.diff(self.value) / np.diff(self.time)

    def at(self, t: ArrayLike) -> Array:
        return np.interp(np.asarray(t, dtype=float), self.time, self.value)

    def slope_before(self, t: float) -> float:
        place = int(np.searchsorted(self.time, t, side="left")) - 1
        return float(self.slopes[place]) if place >= 0 else 0.0

    def segments(self, end: float, begin: float = -np.inf) -> list[tuple[float, float, float]]:
        """Return pieces with non-zero slope between two times: (start, end, slope)."""
        first, last = np.maximum(self.time[:-1], begin), np.minimum(self.time[1:], end)
        used = (last > first) & (self.slopes != 0)
        return list(zip(first[used], last[used], self.slopes[used], strict=True))


def indentation(
    form: ClosedForm,
    effective_modulus: float,
    material: GeneralisedMaxwell,
    history: History,
    time: ArrayLike,
    *,
    poisson_ratio: float = 0.5,
) -> Curve:
    """Return force and contact radius of a depth that increases, is constant and decreases once.

    A positive first depth is a jump (not with a dashpot). Refused where the contact grows during
    the retreat. With a dashpot the force at a kink is that for the velocity before it. `form` is
    the elastic contact, axisymmetric, with `effective_modulus`; the material is that in shear.

    A ramp against a dashpot, F = 4 eta A'(d) d' with A' = 2 sqrt(R d):

    >>> from reference.closed_form import paraboloid
    >>> oil = GeneralisedMaxwell(0.0, viscosity=1.0)
    >>> ramp = History("penetration", [0, 1], [0, 0.01])
    >>> round(float(indentation(paraboloid(1.0, 1.0), 1.0, oil, ramp, 1.0).force[0]), 12)
    0.008
    """
    history.one_of("penetration")
    path = _Path(history)
    falling = np.flatnonzero(path.slopes < 0)
    if path.value[0] < 0 or (falling.size and (path.slopes[falling[0] :] > 0).any()):
        raise ValueError(
            "the integrals of Lee-Radok and Ting need a penetration that starts at 0 or above it, "
            "rises, rests, and falls once"
        )
    if material.viscosity > 0 and path.value[0] > 0:
        raise ValueError("penetration must start at 0 against a dashpot")
    times = np.atleast_1d(np.asarray(time, dtype=float))
    if not ((times >= path.time[0]) & (times <= path.time[-1])).all():
        raise ValueError("time must lie within the history")
    factor = contact_factor(poisson_ratio)

    def growth(d: Array) -> Array:
        return np.asarray(form.stiffness(d)) / effective_modulus

    def integrand(s: Array, t: float) -> Array:
        return material.relaxation(t - s) * growth(path.at(s))

    # the contact must not grow after the depth has started to decrease (sampled)
    peak, until = float(path.time[path.value == path.value.max()][-1]), times.max()
    if until > peak:
        kinks = path.time[(path.time > peak) & (path.time < until)]
        pieces = pairwise([peak, *kinks, until])
        samples = np.concatenate([np.linspace(*ends, _SAMPLES) for ends in pieces])
        depths = np.array([_contact(material, path, t)[1] for t in samples])
        grows = np.diff(depths) > 1e-9 * path.value.max()
        if grows.any():
            raise ValueError(
                f"the contact grows again near time {samples[1:][grows][0]:.6g}, where the retreat "
                "is slower than the surface recovers: Ting's solution does not hold there"
            )
    force, depth, error = np.zeros((3, times.size))
    for i, t in enumerate(times):
        touching, depth[i] = _contact(material, path, t)
        # int E(t - s) A'(d(s)) d'(s) ds up to the time whose contact this is
        for begin, end, slope in path.segments(touching):
            part, doubt = _quadrature(partial(integrand, t=t), begin, end)
            force[i] += slope * part
            error[i] += abs(slope) * doubt
        # the dashpot's pulse counts fully while the contact grows, and not afterwards
        if material.viscosity > 0 and touching == t:
            force[i] += material.viscosity * float(growth(path.at(t))) * path.slope_before(t)
        jump = float(form.force(min(depth[i], path.value[0]))) / effective_modulus
        force[i] += float(material.relaxation(t - path.time[0])) * jump
    radius = np.where(depth > 0, _contact_radius(form, depth), 0.0)
    return Curve(times, path.at(times), factor * force, radius, factor * error)


def creep(
    form: ClosedForm,
    effective_modulus: float,
    material: GeneralisedMaxwell,
    history: History,
    time: ArrayLike,
    *,
    poisson_ratio: float = 0.5,
) -> Curve:
    """Return the depth under a force for which the contact never shrinks (Lee & Radok).

    Arguments as for `indentation`, but the history is that of the ``"force"``, non-decreasing.

    >>> from reference.closed_form import paraboloid
    >>> zener = GeneralisedMaxwell.standard(0.25, 0.25, 1.0)
    >>> held = History("force", [0, 1], [4 / 3, 4 / 3])
    >>> crept = creep(paraboloid(1.0, 1.0), 1.0, zener, held, 0.0)
    >>> round(float(crept.penetration[0]), 12)  # Hertz with E* = 4 (G_0 + G_1) = 2
    0.629960524947
    """
    history.one_of("force")
    path, t, values = _Path(history), history.time, history.values
    if not (values[0] >= 0 and (path.slopes >= 0).all() and values[-1] > 0):
        raise ValueError(
            "the integral of Lee and Radok needs a force that never falls, so that the contact "
            "never shrinks, and ends above 0"
        )

    def late_creep(s: Array, end: float) -> Array:
        return material.creep(end - s)

    times = np.atleast_1d(np.asarray(time, dtype=float))
    total = values[0] * material.creep(times - t[0])
    error = np.zeros(times.size)
    for i, end in enumerate(times):
        for begin, stop, slope in path.segments(end):
            part, doubt = _quadrature(partial(late_creep, end=end), begin, stop)
            total[i] += slope * part
            error[i] += abs(slope) * doubt
    total, error = total / contact_factor(poisson_ratio), error / contact_factor(poisson_ratio)
    depth = np.asarray(form.penetration(effective_modulus * total))
    stiffness = np.asarray(form.stiffness(depth)) / effective_modulus
    spread = np.divide(error, stiffness, out=np.zeros(times.size), where=stiffness > 0)
    return Curve(times, depth, path.at(times), _contact_radius(form, depth), spread)


def _contact_radius(form: ClosedForm, depth: Array) -> Array:
    if form.contact_radius is None:
        raise ValueError("the integral holds for round contacts: form must be axisymmetric")
    return np.asarray(form.contact_radius(depth))


def _contact(material: GeneralisedMaxwell, path: _Path, t: float) -> tuple[float, float]:
    """Return time and depth of the loading with the same contact as at time t."""
    start = float(path.time[0])
    rising = np.flatnonzero((path.slopes > 0) & (path.time[:-1] < t))
    top = min(t, float(path.time[rising[-1] + 1])) if rising.size else start

    def tension(t1: float) -> float:
        """Return the stress of a spring that was touched first at t1, in closed form."""
        total = material.equilibrium_modulus * (path.at(t) - path.at(t1))
        for first, last, slope in path.segments(t, t1):
            for modulus, tau in zip(material.arm_moduli, material.arm_times, strict=True):
                grown = np.exp(-(t - last) / tau) * -np.expm1(-(last - first) / tau)
                total += slope * modulus * tau * grown
        return float(total + material.viscosity * path.slope_before(t))

    if tension(top) >= 0:
        return top, float(path.at(top))
    if (late := tension(start)) > 0:
        solution = brentq(tension, start, top, xtol=4e-16 * path.time[-1], rtol=1e-15)
        return solution, float(path.at(solution))
    if path.value[0] == 0:
        return start, 0.0
    return start, max(0.0, float(path.value[0] + late / material.relaxation(t - start)))


def _quadrature(
    function: Callable[[Array], Array], begin: float, end: float
) -> tuple[float, float]:
    """Return an integral and its error estimate by panels that halve towards both ends."""
    halves = 0.5 * 2.0 ** -np.arange(_LEVELS)
    marks = np.concatenate([[0.0], halves[::-1], 1 - halves[1:], [1.0]])
    low, width = begin + (end - begin) * marks[:-1, None], (end - begin) * np.diff(marks)[:, None]
    values = []
    for count in _NODES:
        nodes, weights = gauss_rule(count)
        samples = function(low + width * (nodes + 1) / 2)
        values.append(float((samples * weights * width / 2).sum()))
    rounding = 16 * np.finfo(float).eps * abs(values[1])
    return values[1], abs(values[1] - values[0]) + rounding


Rates = Callable[[float, Array], Array]
Event = Callable[[float, Array], float]

_TOLERANCES = (1e-9, 1e-11)
_INSTANTS = 1000  # of the force per direction; its flat maximum is accurate to 1e-6


@dataclass(frozen=True)
class Rebound:
    """Outcome of an impact.

    `restitution` is the speed after over that before, `duration` the time in contact; `penetration`
    and `force` are the largest. `error` is the difference of the restitution between two
    tolerances of the integration.
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
) -> Rebound:
    """Return the impact of a body on the half-space, with a speed `velocity` at first touch.

    A fluid may keep it for very long: then no rebound is found.

    >>> from reference.closed_form import paraboloid
    >>> hit = impact(paraboloid(1.0, 1.0), 1.0, GeneralisedMaxwell(0.25), 1.0, 1e-3)
    >>> round(hit.restitution, 8)
    1.0
    """
    require_positive("impact", mass=mass, velocity=velocity, effective_modulus=effective_modulus)
    factor = contact_factor(poisson_ratio)

    def reached(d: float) -> float:
        if d > form.limit:
            raise ConvergenceError(f"the mass is not stopped: {form.limit_reason}")
        return max(d, 0.0)

    def growth(d: float) -> float:
        return factor * float(form.stiffness(reached(d))) / effective_modulus

    def area(d: float) -> float:
        return factor * float(form.force(reached(d))) / effective_modulus

    def collided(tolerance: float) -> tuple[float, float, float, float]:
        """Return restitution, duration, largest depth and largest force.

        States are (depth, velocity, s_j, z_j) on approach, and without z_j on rebound.
        """
        moduli, times = material.arm_moduli, material.arm_times
        arms, spring, viscosity = times.size, material.equilibrium_modulus, material.viscosity

        # the depth at which the glassy half-space or its dashpot absorbs the energy
        def excess(depth: float) -> float:
            modulus = material.instantaneous_modulus + viscosity * velocity / depth
            return modulus * area(depth) * depth / 2 - mass * velocity**2 / 2

        low = high = min(velocity, form.limit)
        while excess(low) > 0:
            low /= 4
        while excess(high) < 0:
            high *= 4
        depth = brentq(excess, low, high, xtol=1e-3 * low, rtol=1e-3)

        def integrate(rates: Rates, begin: float, start: Array, stop: Event) -> Any:
            event: Any = stop  # SciPy reads these attributes of the function
            event.terminal, event.direction = True, -1.0
            scale = np.full(start.size, depth)
            scale[1] = velocity
            scale[2 + arms :] *= growth(depth)
            time = 3 * depth / velocity
            solution = solve_ivp(
                *(rates, (begin, begin + 200 * time), start, "LSODA"),
                rtol=tolerance,
                atol=1e-2 * tolerance * scale,
                max_step=time / 20,
                events=stop,
                dense_output=True,
            )
            if solution.status != 1:
                raise ConvergenceError(f"the body does not come back: {solution.message}")
            return solution

        # approach: Lee & Radok, until the body stands still
        def force_in(state: Array) -> float:
            damping = viscosity * growth(state[0]) * state[1]
            return float(spring * area(state[0]) + moduli @ state[2 + arms :] + damping)

        def rates_in(_: float, state: Array) -> Array:
            speed, strained, loaded = state[1], state[2 : 2 + arms], state[2 + arms :]
            strain_rates = speed - strained / times
            load_rates = speed * growth(state[0]) - loaded / times
            return np.concatenate([[speed, -force_in(state) / mass], strain_rates, load_rates])

        start = np.concatenate([[0.0, velocity], np.zeros(2 * arms)])
        way_in = integrate(rates_in, 0.0, start, lambda _, y: y[1])
        turn, past, turned = float(way_in.t[-1]), way_in.sol, way_in.y[:, -1]

        # rebound: Ting, until a spring of the first touch bears nothing
        def tension(t: float, state: Array, touched: float) -> float:
            """Return the stress of a spring first touched at a time on approach."""
            before = past(touched)
            relaxed = state[2:] - np.exp(-(t - touched) / times) * before[2 : 2 + arms]
            return float(spring * (state[0] - before[0]) + moduli @ relaxed + viscosity * state[1])

        def force_out(t: float, state: Array) -> float:
            if tension(t, state, 0.0) <= 0:
                return 0.0
            touched = turn
            if tension(t, state, turn) < 0:
                touched = brentq(
                    lambda at: tension(t, state, at), 0.0, turn, xtol=1e-14 * turn, rtol=1e-14
                )
            then = past(touched)
            decayed = np.exp(-(t - touched) / times) * then[2 + arms :]
            return float(spring * area(then[0]) + moduli @ decayed)

        def rates_out(t: float, state: Array) -> Array:
            acceleration = -force_out(t, state) / mass
            return np.concatenate([[state[1], acceleration], state[1] - state[2:] / times])

        way_out = integrate(rates_out, turn, turned[: 2 + arms], lambda t, y: tension(t, y, 0.0))
        forces = [force_in(past(t)) for t in np.linspace(0, turn, _INSTANTS)]
        forces += [
            force_out(t, way_out.sol(t)) for t in np.linspace(turn, way_out.t[-1], _INSTANTS)
        ]
        restitution = -float(way_out.y[1, -1]) / velocity
        return restitution, float(way_out.t[-1]), float(turned[0]), max(forces)

    coarse, fine = (collided(tolerance) for tolerance in _TOLERANCES)
    return Rebound(*fine, error=abs(fine[0] - coarse[0]))
