"""Coulomb's set-valued law in fixed steps (Moreau 1988, Jean 1999).

Events are not located; every step solves the law for its impulse. With the theta rule for the
smooth forces,

    (M + h theta C + h^2 theta^2 K) v+ = M v - h (1 - theta) C v - h K (x + h theta (1 - theta) v)
                                         + h f(t + theta h) + p,
    x+ = x + h (theta v+ + (1 - theta) v),    -p in h mu F_N Sign(v+ - V)

(Acary & Brogliato, Numerical Methods for Nonsmooth Dynamical Systems, 2008, chapter 10). Events may
occur anywhere in a step: with theta = 1/2 the order is near 2 if the friction is continuous at the
event (mu_s = mu_k), else 1. Unconditionally stable for theta >= 1/2; a block at rest has exactly
zero velocity.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from reference.dynamics.coulomb import Array, Blocks
from reference.errors import ConvergenceError

_EPSILON = float(np.finfo(float).eps)
_SWEEPS = 10_000


@dataclass(frozen=True)
class March:
    """Motion in steps.

    Attributes
    ----------
    time : ndarray, shape (k,)
    position, velocity : ndarray, shape (k, n)
    evaluations : int
        Evaluations of Coulomb's law per block: the cost.
    """

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
    """Integrate the motion of the blocks from t = 0, with position and velocity (n,) there.

    A block at rest at the end of a step resists up to mu_s F_N in the next one, others mu_k F_N.
    ConvergenceError if the impulses of a step do not converge, or a velocity is not finite.

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
    mass,
    kinetic,
    static,
    stiffness,
    damping,
    load,
    amplitude,
    frequency,
    belt,
    matrix,
    h,
    theta,
    records,
):
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
        for _ in range(_SWEEPS):
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
