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

from reference.dynamics.blocks import Array, Blocks, initial_state
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
    """Integrate the motion of the blocks from t = 0.

    A block at rest at the end of a step resists up to mu_s F_N in the next one, others mu_k F_N.

    Parameters
    ----------
    blocks : Blocks
    step, steps
        Length h and number of the steps.
    theta : float
        In [1/2, 1].
    position, velocity : array_like, shape (n,)
        At t = 0.

    Raises
    ------
    ValueError
        For arguments out of range.
    ConvergenceError
        If the impulses of a step do not converge, or a velocity is not finite.

    Examples
    --------
    >>> sled = march(Blocks(1.0, 0.5), step=0.25, steps=40, velocity=2.0)
    >>> float(sled.position[-1, 0]), float(sled.velocity[-1, 0])  # v^2/(2 mu g), and rest
    (4.0, 0.0)
    """
    if not (np.isfinite(step) and step > 0 and steps >= 1 and 0.5 <= theta <= 1):
        raise ValueError(
            "expected step > 0, steps >= 1 and 1/2 <= theta <= 1, "
            f"not {step!r}, {steps!r} and {theta!r}"
        )
    system = blocks.arrays()
    x, v = initial_state(system, position, velocity)
    records = np.empty((2, int(steps) + 1, x.size))
    records[:, 0] = x, v
    part = float(step) * float(theta)
    matrix = np.diag(system.mass) + part * system.damping + part * part * system.stiffness
    evaluations, failed = _march(system, matrix, float(step), float(theta), records)
    if failed >= 0 or not np.isfinite(records).all():
        raise ConvergenceError(f"no finite velocity at step {max(failed, 0)}", [step])
    time = np.asarray(step * np.arange(steps + 1), dtype=np.float64)
    return March(time, records[0], records[1], int(evaluations // x.size))


@njit(cache=True)
def _march(system, matrix, h, theta, records):
    """Fill positions and velocities; return evaluations, and the failed step or -1."""
    mass, load, amplitude, belt, kinetic, static, stiffness, damping, frequency = system
    n, evaluations = mass.size, 0
    free, moved, bound = np.empty(n), np.empty(n), np.empty(n)
    for k in range(records.shape[1] - 1):
        x, v = records[0, k], records[1, k]
        new, moves = records[1, k + 1], records[0, k + 1]
        for i in range(n):
            new[i], moved[i] = v[i], x[i] + h * theta * (1.0 - theta) * v[i]
        swing = np.cos(frequency * (k + theta) * h)
        for i in range(n):
            free[i] = mass[i] * v[i] + h * (load[i] + amplitude[i] * swing)
            for j in range(n):
                free[i] -= h * (1.0 - theta) * damping[i, j] * v[j] + h * stiffness[i, j] * moved[j]
            bound[i] = h * (static[i] if v[i] == belt[i] else kinetic[i])
        used = _solve(matrix, free, bound, belt, new)
        if used < 0:
            return evaluations, k
        evaluations += used
        for i in range(n):
            moves[i] = x[i] + h * (theta * new[i] + (1.0 - theta) * v[i])
    return evaluations, -1


@njit(cache=True)
def _solve(matrix, free, bound, belt, v):
    """Solve for the velocities under Coulomb's law by non-smooth Gauss-Seidel sweeps.

    The solution minimises a strictly convex function, for which such sweeps converge (Jean 1999).
    Returns evaluations of the law, or -1.
    """
    n = free.size
    for sweep in range(_SWEEPS):
        change, size = 0.0, 0.0
        for i in range(n):
            drive = free[i] - matrix[i, i] * belt[i]
            for j in range(n):
                if j != i:
                    drive -= matrix[i, j] * v[j]
            if abs(drive) <= bound[i]:
                new = belt[i]
            else:
                new = belt[i] + (drive - np.copysign(bound[i], drive)) / matrix[i, i]
            change, size = max(change, abs(new - v[i])), max(size, abs(new))
            v[i] = new
        if n == 1 or change <= 4.0 * _EPSILON * size:
            return (sweep + 1) * n
    return -1
