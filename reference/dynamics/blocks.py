"""Rigid blocks under Coulomb's set-valued law, with any friction force up to the limit at rest.

    M v' = f + P cos(W t) - K x - C v + R,   x' = v,   w = v - V,
    R_i = -sign(w_i) mu_k F_N where the block slides,  |R_i| <= mu_s F_N where it sticks (w_i = 0),

with V the constant speed of the support of a block (Coulomb 1785; Den Hartog 1931).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.arguments import refuse

Array = NDArray[np.float64]


class System(NamedTuple):
    """Blocks as full arrays of shape (n,) and (n, n)."""

    mass: Array
    load: Array
    amplitude: Array
    belt: Array
    kinetic: Array
    static: Array
    stiffness: Array
    damping: Array
    frequency: float


@dataclass(frozen=True, eq=False)
class Blocks:
    """n rigid blocks, given by arrays or by numbers (one block, or equal values for all).

    Parameters
    ----------
    mass : array_like, shape (n,)
        m, positive.
    kinetic, static : array_like, shape (n,)
        mu_k F_N and mu_s F_N; static friction equals the kinetic one by default.
    stiffness, damping : array_like
        K and C: numbers, or symmetric (n, n).
    load, amplitude, belt : array_like, shape (n,)
        f, P, V.
    frequency : float
        W.

    Examples
    --------
    >>> Blocks([1.0, 2.0], 0.5, stiffness=[[1.0, -1.0], [-1.0, 1.0]]).arrays().static
    array([0.5, 0.5])
    """

    mass: ArrayLike
    kinetic: ArrayLike
    static: ArrayLike | None = None
    stiffness: ArrayLike = 0.0
    damping: ArrayLike = 0.0
    load: ArrayLike = 0.0
    amplitude: ArrayLike = 0.0
    frequency: float = 0.0
    belt: ArrayLike = 0.0

    def __post_init__(self) -> None:
        system = self.arrays()
        faults = [
            f"{name} must be finite, not {value!r}"
            for name, value in system._asdict().items()
            if not np.isfinite(value).all()
        ]
        if (system.mass <= 0).any():
            faults.append(f"mass must be positive, not {self.mass!r}")
        if not ((system.kinetic >= 0) & (system.static >= system.kinetic)).all():
            friction = f"{self.static!r} and {self.kinetic!r}"
            faults.append(f"expected static >= kinetic >= 0, not {friction}")
        n = system.mass.size
        for name, matrix in (("stiffness", system.stiffness), ("damping", system.damping)):
            if matrix.shape != (n, n) or not np.array_equal(matrix, matrix.T):
                faults.append(f"{name} must be a symmetric ({n}, {n}) matrix, not {matrix!r}")
        refuse(faults)

    def arrays(self) -> System:
        """Return the system as full arrays."""
        static_friction = self.kinetic if self.static is None else self.static
        columns = self.mass, self.load, self.amplitude, self.belt, self.kinetic, static_friction
        size = max(np.size(value) for value in columns)
        mass, load, amplitude, belt, kinetic, static = (
            np.array(np.broadcast_to(value, size), float) for value in columns
        )
        stiffness, damping = (
            np.array(value, float) if np.ndim(value) else np.asarray(value, float) * np.eye(size)
            for value in (self.stiffness, self.damping)
        )
        vectors = mass, load, amplitude, belt, kinetic, static
        return System(*vectors, stiffness, damping, float(self.frequency))


def natural_units(system: System, x: Array, v: Array, duration: float) -> tuple[float, ...]:
    """Return units of mass, length and time (powers of two) that make all numbers of order one.

    The time is that of the fastest oscillation or decay (else the duration), the length the largest
    displacement due to initial state, belts and forces in that time.
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


def in_units(system: System, mass: float, length: float, time: float) -> System:
    """Return the same blocks in other units."""
    force, speed = mass * length / time**2, length / time
    return System(
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


def initial_state(system: System, position: ArrayLike, velocity: ArrayLike) -> tuple[Array, Array]:
    """Return initial x and v as arrays (n,), or raise ValueError."""
    x, v = (np.array(np.broadcast_to(y, system.mass.size), float) for y in (position, velocity))
    if not (np.isfinite(x).all() and np.isfinite(v).all()):
        raise ValueError(f"position and velocity must be finite, not {position!r}, {velocity!r}")
    return x, v
