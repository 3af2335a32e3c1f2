"""Contact with Coulomb friction, node by node (Jourdan, Alart & Jean 1998).

With f the force of the rigid shape on a node and u its displacement, Signorini's and Coulomb's
conditions in a step are the fixed points of

    f_z <- max(0, f_z + (d - g - u_z)/C_zz),
    f_t <- the nearest within |f_t| <= mu f_z to f_t + (U - s_before - u_t)/C_tt,

which a Gauss-Seidel sweep applies node by node, with the latest forces of all others. It shares no
code with the half-space solvers and is an independent check of them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from reference.arguments import positive_faults, refuse
from reference.errors import ConvergenceError
from reference.fem.half_space import FrictionalBody
from reference.loads import LoadPath


@dataclass(frozen=True, eq=False)
class FrictionStep:
    """One converged step, with forces of both halves.

    Attributes
    ----------
    penetration, tangential_displacement : float
    force, tangential_force : float
    reactions : (n, 3)
        Nodal forces on the meshed half.
    sticking : (n,) bool
        Nodes in contact below their bound.
    error : float
        Largest error of a displacement in the contact conditions, over the penetration.
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


# Newton steps towards prescribed forces, their relative error, and the finite-difference step as a
# fraction of the penetration.
_NEWTON, _FORCE_ERROR, _SLOPE_STEP = 60, 1e-6, 1e-3
# Largest factor of the penetration in a Newton step.
_LARGEST_FACTOR = 2.0
_NORMAL, _TANGENTIAL = ("penetration", "force"), ("tangential_displacement", "tangential_force")


@dataclass(frozen=True, eq=False)
class FrictionalPress:
    """A rigid shape over a body for normal and tangential loads.

    Parameters
    ----------
    body : FrictionalBody
    gap : array_like, shape (n,)
        Initial gap over `body.points`, symmetric about y = 0.
    friction : float
        mu, positive and finite.

    Raises
    ------
    ValueError
        Lists all errors in gap and friction.
    """

    body: FrictionalBody
    gap: NDArray[np.float64]
    friction: float

    def __post_init__(self) -> None:
        gap, shape = np.asarray(self.gap, dtype=float), self.body.fixed.shape
        object.__setattr__(self, "gap", gap)
        faults = positive_faults(friction=self.friction)
        if gap.shape != shape or not np.isfinite(gap).all():
            faults.append(f"gap must be finite, of shape {shape}, not {gap.shape}")
        refuse(faults)


def follow(
    press: FrictionalPress,
    normal: LoadPath,
    tangential: LoadPath,
    *,
    tolerance: float = 1e-7,
    max_sweeps: int = 20_000,
) -> Iterator[FrictionStep]:
    """Solve a path of normal and tangential loads of a rigid shape.

    Parameters
    ----------
    press : FrictionalPress
    normal : LoadPath
        ``"penetration"`` or positive ``"force"``.
    tangential : LoadPath
        ``"tangential_displacement"`` or ``"tangential_force"``, of equal length; a force below mu
        F. Slip is measured over whole steps (implicit Euler).
    tolerance : float
        Largest `FrictionStep.error`.
    max_sweeps : int

    Yields
    ------
    FrictionStep

    Raises
    ------
    ValueError
        If the paths are of other quantities, or of different lengths.
    ConvergenceError
        On iteration, if the sweeps of a step do not converge or its forces are impossible.
    """
    kinds = normal.one_of(*_NORMAL), tangential.one_of(*_TANGENTIAL)
    if kinds[0] == "force":
        normal.positive()
    steps = np.column_stack([normal.values, tangential.values])
    walk = _Walk(press, kinds, tolerance, max_sweeps)
    return (walk.step(row) for row in steps)


class _Walk:
    """The state between two steps: nodal forces and relative position of the shape."""

    def __init__(
        self, press: FrictionalPress, kinds: tuple[str, str], tolerance: float, max_sweeps: int
    ) -> None:
        self.body, self.gap, self.friction = press.body, press.gap, press.friction
        self.tolerance, self.max_sweeps = tolerance, max_sweeps
        count = len(press.gap)
        self.table = np.ascontiguousarray(press.body.compliance.reshape(3 * count, 3 * count))
        self.forces, self.position = np.zeros((count, 3)), np.zeros((count, 2))
        # whether penetration and displacement are unknown (prescribed forces)
        self.sought = np.array([kinds[0] == "force", kinds[1] == "tangential_force"])
        self.place = np.zeros(2)

    def step(self, loads: NDArray[np.float64]) -> FrictionStep:
        """Solve one step and store its state."""
        place, forces, errors = self._balanced(loads)
        moved = (self.table @ forces.ravel()).reshape(-1, 3)
        self.position = np.column_stack([place[1] - moved[:, 0], -moved[:, 1]])
        self.forces, self.place = forces, place
        normal, along = self._totals(forces)
        size = np.hypot(forces[:, 0], forces[:, 1])
        return FrictionStep(
            penetration=float(place[0]),
            tangential_displacement=float(place[1]),
            force=float(normal),
            tangential_force=float(along),
            reactions=forces.copy(),
            sticking=(forces[:, 2] > 0) & (size < (1 - 1e-9) * self.friction * forces[:, 2]),
            error=float(errors[-1] / abs(place[0])),
            sweeps=len(errors),
        )

    def _balanced(
        self, loads: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Return penetration and displacement for the loads, by Newton's method."""
        sought = np.flatnonzero(self.sought)
        place = np.where(self.sought, self.place, loads)
        if self.sought[0] and place[0] <= 0:
            place[0] = self._first_depth(loads[0])
        history: list[float] = []
        for _ in range(_NEWTON):
            forces, errors = self._solved(place)
            if not sought.size:
                return place, forces, errors
            totals = self._totals(forces)
            missing = (loads - totals)[sought]
            normal = loads[0] if self.sought[0] else totals[0]
            if self.sought[1] and not abs(loads[1]) < self.friction * normal:
                raise ConvergenceError(
                    f"the tangential force {loads[1]!r} is not below friction times the normal "
                    "force: full sliding"
                )
            # relative to the normal force, as a tangential one may be zero
            unit = np.array([1.0, self.friction])[sought] * normal
            history.append(float(np.abs(missing / unit).max()))
            if history[-1] <= _FORCE_ERROR:
                return place, forces, errors
            place = self._improved(place, totals, missing, sought)
        raise ConvergenceError("no displacement carries the forces of a frictional step", history)

    def _improved(
        self,
        place: NDArray[np.float64],
        totals: NDArray[np.float64],
        missing: NDArray[np.float64],
        sought: NDArray[np.intp],
    ) -> NDArray[np.float64]:
        """Return the result of one Newton step, with slopes by differences."""
        slopes = np.empty((sought.size, sought.size))
        moved = _SLOPE_STEP * np.array([1.0, self.friction]) * abs(place[0])
        for column, sought_place in enumerate(sought):
            beside = place.copy()
            beside[sought_place] += moved[sought_place]
            change = self._totals(self._solved(beside)[0]) - totals
            slopes[:, column] = change[sought] / moved[sought_place]
        new = place.copy()
        new[sought] += np.linalg.lstsq(slopes, missing)[0]
        if self.sought[0]:
            new[0] = np.clip(new[0], place[0] / _LARGEST_FACTOR, place[0] * _LARGEST_FACTOR)
        return new

    def _solved(
        self, place: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return nodal forces at a position of the shape, and the errors of the sweeps."""
        depth, shift = place
        aim = np.column_stack([shift - self.position[:, 0], -self.position[:, 1], depth - self.gap])
        forces, bound = self.forces.copy(), self.tolerance * abs(depth)
        errors = np.zeros(self.max_sweeps)
        errors = errors[
            : _sweeps(
                _Nodes(self.table, aim, self.body.fixed), self.friction, forces, errors, bound
            )
        ]
        if not errors[-1] <= bound:
            raise ConvergenceError(
                f"node by node, friction stopped at an error of {errors[-1] / abs(depth):.1e} of "
                "the penetration",
                errors / abs(depth),
            )
        return forces, errors

    def _first_depth(self, force: float) -> float:
        """Return the depth of a punch as wide as the candidates, to start Newton's method."""
        lift = float((self.table @ _even(self.gap.size)).reshape(-1, 3)[:, 2].mean())
        return force / 2 * lift

    @staticmethod
    def _totals(forces: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the normal and tangential force of both halves."""
        return 2.0 * np.array([forces[:, 2].sum(), forces[:, 0].sum()])


def _even(count: int) -> NDArray[np.float64]:
    """Return equal normal forces on all nodes with sum one."""
    forces = np.zeros((count, 3))
    forces[:, 2] = 1 / count
    return forces.ravel()


class _Nodes(NamedTuple):
    """Input of the sweeps: compliance of the nodes, target displacements, fixed nodes."""

    table: NDArray[np.float64]
    aim: NDArray[np.float64]
    fixed: NDArray[np.bool_]


@njit(cache=True)
def _sweeps(nodes, friction, forces, errors, tolerance):
    """Sweep until all changes are below the tolerance; return the number of sweeps."""
    table, aim, fixed = nodes
    count = len(forces)
    flat = forces.reshape(-1)
    for sweep in range(errors.size):
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
            new_y = 0.0 if fixed[i] else y + (aim[i, 1] - np.dot(rows[1], flat)) / soft
            size, bound = np.hypot(new_x, new_y), friction * normal
            if size > bound:
                new_x, new_y = new_x * bound / size, new_y * bound / size
            worst = max(worst, np.hypot(new_x - x, new_y - y) * soft)
            flat[3 * i], flat[3 * i + 1] = new_x, new_y
        errors[sweep] = worst
        if worst <= tolerance:
            return sweep + 1
    return errors.size
