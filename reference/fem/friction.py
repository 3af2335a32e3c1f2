"""Contact with Coulomb friction on nodes, node after node (Jourdan, Alart & Jean 1998).

With f the force of the rigid shape on a node and u its displacement, Signorini's and Coulomb's
conditions on a step are the fixed points of

    f_z <- max(0, f_z + (d - g - u_z)/C_zz),
    f_t <- the nearest within |f_t| <= mu f_z to f_t + (U - s_before - u_t)/C_tt,

which a Gauss-Seidel sweep applies to one node after the other, with the newest forces of all
others. Nothing of it is shared with the half-space solvers: it is a second opinion on them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from reference.errors import ConvergenceError
from reference.fem.frictional_body import FrictionalBody


@dataclass(frozen=True, eq=False)
class FrictionStep:
    """One converged step; forces of both halves together.

    Attributes
    ----------
    penetration, tangential_displacement : float
    force, tangential_force : float
    reactions : (n, 3)
        Nodal forces on the meshed half.
    sticking : (n,) bool
        Nodes in contact below their bound.
    error : float
        Largest error of a displacement in the conditions, over the penetration.
    sweeps : int
    """

    penetration: float
    tangential_displacement: float
    force: float
    tangential_force: float
    reactions: NDArray[np.float64]
    sticking: NDArray[np.bool_]
    error: float
    sweeps: int


def follow(
    body: FrictionalBody,
    gap: ArrayLike,
    friction: float,
    *,
    penetration: Sequence[float],
    tangential_displacement: Sequence[float],
    tolerance: float = 1e-7,
    max_sweeps: int = 20_000,
) -> Iterator[FrictionStep]:
    """Follow a path of penetration and tangential displacement of a rigid shape.

    Parameters
    ----------
    body : FrictionalBody
    gap : array_like, shape (n,)
        Initial gap over `body.points`, symmetric about y = 0.
    friction : float
        mu.
    penetration, tangential_displacement : sequence, shape (k,)
        The steps, in order; slip is counted over each of them (implicit Euler).
    tolerance : float
        Bound of `FrictionStep.error`.
    max_sweeps : int

    Yields
    ------
    FrictionStep

    Raises
    ------
    ValueError
        If shapes differ or a number is out of range.
    ConvergenceError
        From the step whose sweeps do not converge.
    """
    gap = np.asarray(gap, dtype=float)
    steps = np.column_stack([penetration, tangential_displacement]).astype(float)
    if gap.shape != body.held.shape or not np.isfinite(gap).all():
        raise ValueError(f"gap must be finite, of shape {body.held.shape}, got {gap.shape}")
    if not (np.isfinite(friction) and friction > 0) or not np.isfinite(steps).all():
        raise ValueError(f"friction must be positive and all steps finite, got {friction!r}")
    return _follow(body, gap, friction, steps, tolerance, max_sweeps)


def _follow(
    body: FrictionalBody,
    gap: NDArray[np.float64],
    friction: float,
    steps: NDArray[np.float64],
    tolerance: float,
    max_sweeps: int,
) -> Iterator[FrictionStep]:
    count = len(gap)
    table = np.ascontiguousarray(body.compliance.reshape(3 * count, 3 * count))
    forces, position = np.zeros((count, 3)), np.zeros((count, 2))
    for depth, shift in steps:
        aim = np.column_stack([shift - position[:, 0], -position[:, 1], depth - gap])
        errors = _sweeps(
            table, aim, body.held, friction, forces, tolerance * abs(depth), max_sweeps
        )
        if not errors[-1] <= tolerance * abs(depth):
            raise ConvergenceError(
                f"node by node, friction stopped at an error of {errors[-1] / abs(depth):.1e} of "
                "the penetration",
                errors / abs(depth),
            )
        moved = (table @ forces.ravel()).reshape(count, 3)
        position = np.column_stack([shift - moved[:, 0], -moved[:, 1]])
        size = np.hypot(forces[:, 0], forces[:, 1])
        yield FrictionStep(
            penetration=float(depth),
            tangential_displacement=float(shift),
            force=2.0 * float(forces[:, 2].sum()),
            tangential_force=2.0 * float(forces[:, 0].sum()),
            reactions=forces.copy(),
            sticking=(forces[:, 2] > 0) & (size < (1 - 1e-9) * friction * forces[:, 2]),
            error=float(errors[-1] / abs(depth)),
            sweeps=len(errors),
        )


@njit(cache=True)
def _sweeps(table, aim, held, friction, forces, tolerance, max_sweeps):
    """Sweep until no node asks for a change beyond the tolerance; errors of the sweeps."""
    count = len(forces)
    flat = forces.reshape(-1)
    errors = np.zeros(max_sweeps)
    for sweep in range(max_sweeps):
        worst = 0.0
        for i in range(count):
            rows = table[3 * i : 3 * i + 3]
            x, y, z = forces[i]
            stiff = rows[2, 3 * i + 2]
            normal = max(0.0, z + (aim[i, 2] - np.dot(rows[2], flat)) / stiff)
            worst = max(worst, abs(normal - z) * stiff)
            flat[3 * i + 2] = normal
            soft = max(rows[0, 3 * i], rows[1, 3 * i + 1])
            new_x = x + (aim[i, 0] - np.dot(rows[0], flat)) / soft
            new_y = 0.0 if held[i] else y + (aim[i, 1] - np.dot(rows[1], flat)) / soft
            size, bound = np.hypot(new_x, new_y), friction * normal
            if size > bound:
                new_x, new_y = new_x * bound / size, new_y * bound / size
            worst = max(worst, np.hypot(new_x - x, new_y - y) * soft)
            flat[3 * i], flat[3 * i + 1] = new_x, new_y
        errors[sweep] = worst
        if worst <= tolerance:
            return errors[: sweep + 1]
    return errors
