"""Time history of a mass on a contact: Runge-Kutta, stopped at every touch and knot."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import solve_ivp

from reference.closed_form.form import ClosedForm, require_positive
from reference.errors import ConvergenceError

Array = NDArray[np.float64]
Rates = Callable[[float, Array], Sequence[float]]
Pieces = list[tuple[float, float, Callable[[Array], Array]]]
_MOST_TOUCHES = 10_000


def through_touches(
    rates: Rates, start: float, end: float, state: Array, tolerance: float
) -> tuple[Pieces, Array]:
    """Integrate y' = rates(t, y), y = (x, x'), restarting at every zero of x.

    At x = 0 the contact force is not smooth. All numbers are of order one, so the tolerance is
    relative and absolute.

    Returns
    -------
    tuple
        Dense output as a sequence of (start, end, function), and the final state.

    Raises
    ------
    ConvergenceError
        If the integrator fails or the touches do not end.
    """

    def touching(_: float, y: Array) -> float:
        return y[0]

    touching.terminal = True  # type: ignore[attr-defined]
    pieces: Pieces = []
    while start < end and len(pieces) < _MOST_TOUCHES:
        run = solve_ivp(
            *(rates, (start, end), state),
            method="DOP853",
            rtol=tolerance,
            atol=tolerance,
            events=touching,
            dense_output=True,
        )
        if run.status < 0:
            raise ConvergenceError(f"the motion could not be integrated: {run.message}")
        pieces.append((start, float(run.t[-1]), run.sol))
        start, state = float(run.t[-1]), run.y[:, -1]
        if run.status == 1:
            # slightly beyond the surface, so that the same crossing is not detected again
            state = np.array([np.copysign(tolerance, state[1]), state[1]])
    if start < end:
        raise ConvergenceError(f"the mass touched {_MOST_TOUCHES} times before the end", [start])
    return pieces, state


def sample(pieces: Pieces, times: Array) -> Array:
    """Return y at times from the dense output, shape (2, k)."""
    states = np.empty((2, times.size))
    for low, high, solution in pieces:
        inside = (times >= low) & (times <= high)
        if inside.any():
            states[:, inside] = solution(times[inside])
    return states


def course(
    form: ClosedForm,
    mass: float,
    velocity: float,
    times: ArrayLike,
    history: tuple[ArrayLike, ArrayLike] | None = None,
    tolerance: float = 1e-10,
) -> tuple[Array, Array]:
    """Return x and x' at given times of m x'' = f(t) - F(x), x = 0 and x' = v at t = 0.

    Parameters
    ----------
    form : ClosedForm
        The contact, without force in flight (x < 0).
    mass, velocity : float
        m > 0, v >= 0.
    times : array_like, shape (k,)
        Increasing, from 0 on.
    history : tuple of array_like, shape (j,), optional
        Increasing times and the force f there, linear in between, constant outside.
    tolerance : float
        Tolerance of the integrator, relative to the largest numbers of the motion.

    Raises
    ------
    ValueError
        For arguments out of range, or if neither velocity nor force moves the mass.
    ConvergenceError
        If the integration fails.

    Examples
    --------
    >>> from reference.closed_form import cylinder
    >>> x, v = course(cylinder(0.5, 1.0), 1.0, 1.0, [0.5 * np.pi, np.pi + 1])  # k = m = 1
    >>> np.round(x, 8)
    array([ 1., -1.])
    """
    require_positive("course", mass=mass)
    instants = np.atleast_1d(np.asarray(times, float))
    knots, forces = (np.atleast_1d(np.asarray(y, float)) for y in history or (0.0, 0.0))
    if not (velocity >= 0 and instants[0] >= 0 and (np.diff(instants) > 0).all()):
        raise ValueError("expected velocity >= 0 and times that increase from 0 on")
    if knots.shape != forces.shape or not (np.diff(knots) > 0).all():
        raise ValueError("expected a history of increasing times with a force for each")
    depth, unit = _units(form, mass, velocity, float(instants[-1]), float(np.abs(forces).max()))
    strength = mass * depth / unit**2

    def rates(t: float, y: Array) -> list[float]:
        push = float(np.interp(t * unit, knots, forces))
        reaction = float(form.force(y[0] * depth)) if y[0] > 0 else 0.0
        return [y[1], (push - reaction) / strength]

    inner = knots[(knots > 0) & (knots < instants[-1])] / unit
    stops = np.unique([0.0, *inner, instants[-1] / unit])
    state = np.array([tolerance, velocity * unit / depth])
    pieces: Pieces = []
    for low, high in pairwise(stops):
        more, state = through_touches(rates, low, high, state, tolerance)
        pieces += more
    x, v = sample(pieces, instants / unit)
    return x * depth, v * depth / unit


def _units(
    form: ClosedForm, mass: float, velocity: float, end: float, force: float
) -> tuple[float, float]:
    """Return a length and a time of the motion: the largest depth, and the time to reach it.

    The depth is the largest power of two at which the mass is not yet stopped.
    """
    if not (velocity > 0 or force > 0):
        raise ValueError("expected a velocity or a force that moves the mass")
    depth = 1.0
    kinetic = 0.5 * mass * velocity**2

    def stops(d: float) -> bool:
        try:
            return bool(form.energy(d) - force * d >= kinetic)
        except ValueError:  # deeper than the shape's theory goes
            return True

    while stops(depth):
        depth /= 2
    while not stops(depth):
        depth *= 2
    depth /= 2
    slowness = mass * depth / (force + float(form.force(depth)))
    return depth, min(float(np.sqrt(slowness)), end)
