"""Rigid blocks under Coulomb's law as it is: a force of any size up to the limit while at rest.

    M v' = f + P cos(W t) - K x - C v + R,   x' = v,   w = v - V,
    R_i = -sign(w_i) mu_k F_N where the block slides,  |R_i| <= mu_s F_N where it sticks (w_i = 0),

with V the constant speed of what each block slides on (Coulomb 1785; Den Hartog 1931).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Blocks:
    """n rigid blocks; build them with `blocks`.

    Attributes
    ----------
    mass, load, amplitude, belt : ndarray, shape (n,)
        m, f, P, V.
    kinetic, static : ndarray, shape (n,)
        mu_k F_N and mu_s F_N.
    stiffness, damping : ndarray, shape (n, n)
        K and C.
    frequency : float
        W.
    """

    mass: Array
    load: Array
    amplitude: Array
    belt: Array
    kinetic: Array
    static: Array
    stiffness: Array
    damping: Array
    frequency: float


def blocks(
    mass: ArrayLike,
    kinetic: ArrayLike,
    *,
    static: ArrayLike | None = None,
    stiffness: ArrayLike = 0.0,
    damping: ArrayLike = 0.0,
    load: ArrayLike = 0.0,
    amplitude: ArrayLike = 0.0,
    frequency: float = 0.0,
    belt: ArrayLike = 0.0,
) -> Blocks:
    """Collect blocks from numbers and arrays; static friction is the kinetic one if not given.

    Raises
    ------
    ValueError
        Listing every argument that is wrong.

    Examples
    --------
    >>> blocks([1.0, 2.0], 0.5, stiffness=[[1.0, -1.0], [-1.0, 1.0]]).static
    array([0.5, 0.5])
    """
    given = {
        "mass": mass,
        "kinetic": kinetic,
        "static": kinetic if static is None else static,
        "load": load,
        "amplitude": amplitude,
        "belt": belt,
    }
    size = max(np.size(value) for value in given.values())
    vectors = {k: np.array(np.broadcast_to(value, size), float) for k, value in given.items()}
    eye = np.eye(size)
    matrices = {
        name: np.array(value, float) if np.ndim(value) else np.asarray(value, float) * eye
        for name, value in {"stiffness": stiffness, "damping": damping}.items()
    }
    problems = [
        f"{name} must be finite, not {value!r}"
        for name, value in {**vectors, **matrices, "frequency": frequency}.items()
        if not np.isfinite(value).all()
    ]
    if (vectors["mass"] <= 0).any():
        problems.append(f"mass must be positive, not {mass!r}")
    if not ((vectors["kinetic"] >= 0) & (vectors["static"] >= vectors["kinetic"])).all():
        problems.append(f"expected static >= kinetic >= 0, not {static!r} and {kinetic!r}")
    for name, matrix in matrices.items():
        if matrix.shape != (size, size) or not np.array_equal(matrix, matrix.T):
            problems.append(f"{name} must be a symmetric ({size}, {size}) matrix, not {matrix!r}")
    if problems:
        raise ValueError("; ".join(problems))
    return Blocks(**vectors, **matrices, frequency=float(frequency))


def natural_units(system: Blocks, x: Array, v: Array, duration: float) -> tuple[float, ...]:
    """Return units of mass, length and time, powers of two, that make all numbers of order one.

    Time is that of the fastest oscillation or decay (the duration, where there is none), length the
    largest of what the start, the belts and the forces move in that time.
    """
    mass = float(system.mass.max())
    stiff = float((np.abs(system.stiffness).sum(axis=1) / system.mass).max())
    damped = float((np.abs(system.damping).sum(axis=1) / system.mass).max())
    rate = max(np.sqrt(stiff), damped, abs(system.frequency)) or 1 / duration
    forces = np.abs(system.load) + np.abs(system.amplitude) + system.static
    length = max(
        float(np.abs(x).max()),
        float(np.abs(v).max() / rate),
        float(np.abs(system.belt).max() / rate),
        float((forces / system.mass).max() / rate**2),
    )
    return tuple(2.0 ** round(np.log2(unit)) for unit in (mass, length or 1.0, 1 / rate))


def in_units(system: Blocks, mass: float, length: float, time: float) -> Blocks:
    """Return the same blocks in other units."""
    force, speed = mass * length / time**2, length / time
    return Blocks(
        mass=system.mass / mass,
        load=system.load / force,
        amplitude=system.amplitude / force,
        belt=system.belt / speed,
        kinetic=system.kinetic / force,
        static=system.static / force,
        stiffness=system.stiffness / (mass / time**2),
        damping=system.damping / (mass / time),
        frequency=system.frequency * time,
    )


def initial_state(system: Blocks, position: ArrayLike, velocity: ArrayLike) -> tuple[Array, Array]:
    """Return x and v at the start as arrays (n,), or raise ValueError."""
    x, v = (np.array(np.broadcast_to(y, system.mass.size), float) for y in (position, velocity))
    if not (np.isfinite(x).all() and np.isfinite(v).all()):
        raise ValueError(f"position and velocity must be finite, not {position!r}, {velocity!r}")
    return x, v
