"""Frictionless contact of a condensed body with a rigid shape."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.arguments import choice_faults, count_faults, positive_faults, refuse
from reference.errors import ConvergenceError
from reference.fem.body import CondensedBody
from reference.fem.contact_area import best_area
from reference.loads import LoadPath

METHODS = ("active_set", "penalty", "augmented_lagrangian")
CONTROLS = ("penetration", "force")


@dataclass(frozen=True, eq=False)
class Contact:
    """One converged load step, with forces and energy of all symmetric parts.

    Attributes
    ----------
    penetration, force : float
    reactions : (n,)
        Nodal normal forces on the meshed part.
    pressure : (n,)
        Reaction over tributary area.
    displacement : (n,)
        Normal displacement of the candidates, into the half-space.
    active : (n,) bool
    stiffness : float
        dF/dd on the fixed contact set.
    energy : float
        Elastic energy ``1/2 sum R u``.
    contact_area_raw : float
        Tributary area of the active points.
    contact_area : float
        Best estimate, see `reference.fem.contact_area.best_area`.
    iterations : int
    violation : float
        The larger of overlap outside the contact over penetration (from first touch of a point),
        and tension inside over mean pressure; with a penalty also the overlap inside.
    history : list of int
        Number of active points by iteration.
    """

    penetration: float
    force: float
    reactions: NDArray[np.float64]
    pressure: NDArray[np.float64]
    displacement: NDArray[np.float64]
    active: NDArray[np.bool_]
    stiffness: float
    energy: float
    contact_area: float
    contact_area_raw: float
    iterations: int
    violation: float
    history: list[int] = field(default_factory=list)


@dataclass(frozen=True)
class Enforcement:
    """Enforcement of contact on the candidates.

    Parameters
    ----------
    method : {"active_set", "penalty", "augmented_lagrangian"}
        The primal-dual active set (Hintermüller, Ito & Kunisch 2002) is exact. "penalty" uses nodal
        springs of stiffness eps per area between shape and body, with an error of O(1/eps).
        "augmented_lagrangian" repeats it with the forces of the last solution until the overlap
        vanishes.
    penalty : float
        ``eps h / E*`` with h the size of the surface elements.
    max_iterations : int
        Limit of active-set iterations per load.

    Raises
    ------
    ValueError
        Lists all invalid arguments.
    """

    method: str = "active_set"
    penalty: float = 1e3
    max_iterations: int = 100

    def __post_init__(self) -> None:
        faults = choice_faults("method", self.method, METHODS)
        faults += positive_faults(penalty=self.penalty)
        refuse(faults + count_faults(1, max_iterations=self.max_iterations))


EXACT = Enforcement()


def press(
    body: CondensedBody,
    gap: ArrayLike,
    load: LoadPath,
    enforcement: Enforcement = EXACT,
    *,
    start: ArrayLike | None = None,
) -> Iterator[Contact]:
    """Solve the contact of a rigid shape with the body, load by load.

    Linearised kinematics: ``u = d - g`` at the undeformed position in contact; ``u >= d - g`` and
    no force elsewhere.

    Parameters
    ----------
    body : CondensedBody
    gap : (n,)
        Initial gap of the rigid shape over `body.points`, relative to which the penetration is
        measured; +inf where contact is impossible.
    load : LoadPath
        ``"penetration"`` or ``"force"`` on the whole contact (all symmetric parts), positive, in
        any order; every step starts from the previous contact set.
    enforcement : Enforcement
        Exact by default.
    start : (n,) bool, optional
        Initial contact set; by default (and if empty) all points with geometric overlap.

    Yields
    ------
    Contact

    Raises
    ------
    ValueError
        Before the first step, with all errors in gap, start and enforcement, or for a load that is
        not positive.
    ConvergenceError
        On iteration, if a step does not converge or overflows.
    """
    problem = _Problem(body, np.asarray(gap, dtype=float), enforcement, start)
    if load.one_of(*CONTROLS) == "penetration":
        return problem.by_penetration(load.positive())
    return problem.by_force(load.positive())


class _Problem:
    """Scaled contact problem: lengths in body.length, forces in E length^2."""

    def __init__(
        self,
        body: CondensedBody,
        gap: NDArray[np.float64],
        enforcement: Enforcement,
        start: ArrayLike | None,
    ) -> None:
        shape, method = body.scaled_weights.shape, enforcement.method
        faults = []
        if gap.shape != shape:
            faults.append(f"gap must have shape {shape}, not {gap.shape}")
        elif np.isnan(gap).any() or np.isneginf(gap).any() or not np.isfinite(gap).any():
            faults.append("gap must be finite or +inf, and finite somewhere")
        if start is not None and np.shape(start) != shape:
            faults.append(f"start must have shape {shape}, not {np.shape(start)}")
        if method != "penalty" and body.interpolation is not None:
            faults.append(
                f"method must be 'penalty' at quadrature points, not {method!r}: there are more of "
                "them than nodes, so that rigid contact in all of them is not defined"
            )
        refuse(faults)
        self.body, self.method, self.limit = body, method, enforcement.max_iterations
        self.possible = np.flatnonzero(np.isfinite(gap))
        # depths are relative to first touch, so that a distant shape loses no digits of the overlap
        self.first_touch = float(gap[self.possible].min())
        self.gap = (gap[self.possible] - self.first_touch) / body.length
        self.start = self._starting_set(start)
        self.weights = body.scaled_weights[self.possible]
        self.softness = np.zeros_like(self.weights)
        if method != "active_set":
            per_area = enforcement.penalty / (1.0 - body.poisson_ratio**2) / body.spacing_scaled
            self.softness = 1.0 / (per_area * self.weights)
        self.force_unit = body.youngs_modulus * body.length * body.length * body.symmetry

    def _starting_set(self, start: ArrayLike | None) -> NDArray[np.bool_] | None:
        active = None if start is None else np.asarray(start, dtype=bool)[self.possible]
        return None if active is None or not active.any() else active

    def by_penetration(self, values: NDArray[np.float64]) -> Iterator[Contact]:
        active = self.start
        for value in values:
            depth = (value - self.first_touch) / self.body.length
            if depth <= 0.0:  # first touch may be between the points
                nothing = np.zeros(len(self.gap), dtype=bool)
                yield self._contact(self._fixed(nothing, depth, self.gap), value, None)
                continue
            step = self._solve(depth, active)
            active = step.active
            yield self._contact(step, value, None)

    def by_force(self, values: NDArray[np.float64]) -> Iterator[Contact]:
        touching = self.gap == 0.0 if self.start is None else self.start
        step = self._fixed(touching, 0.0, np.zeros_like(self.gap))
        for value in values:
            step = self._reach(value / self.force_unit, step)
            penetration = self.first_touch + step.depth * self.body.length
            yield self._contact(step, penetration, value)

    def _reach(self, target: float, step: _Step) -> _Step:
        """Return the depth for a force, by bracketed Newton steps."""
        low, high, iterations, history = 0.0, np.inf, 0, []
        for _ in range(self.limit):
            depth = step.depth + (target - step.reactions.sum()) / step.slope
            if not low < depth < high:
                depth = 0.5 * (low + high) if np.isfinite(high) else low + 2 * (step.depth - low)
            solution = self._solve(depth, step.active)
            iterations += solution.iterations
            history += solution.history
            force = solution.reactions.sum()
            if (
                np.array_equal(solution.active, step.active)
                and abs(force - target) <= 1e-9 * target
            ):
                return solution.after(iterations, history)
            low, high = (max(low, depth), high) if force < target else (low, min(high, depth))
            step = solution
        raise ConvergenceError(
            f"the force {target * self.force_unit:.6g} was not reached in {self.limit} rounds",
            history,
        )

    def _solve(self, depth: float, active: NDArray[np.bool_] | None) -> _Step:
        """Return the solution at a given penetration by active sets."""
        active = self.gap < depth if active is None else active
        offset = np.zeros_like(self.gap)
        step = self._settle(depth, active, offset)
        if self.method != "augmented_lagrangian":
            return step
        iterations, history = step.iterations, list(step.history)
        for _ in range(self.limit):
            if step.overlap(self.gap) <= 1e-10 * depth:
                slope = self._slope(step.active, np.zeros_like(self.softness))
                return replace(step.after(iterations, history), slope=slope)
            offset = np.where(step.active, step.reactions * self.softness, 0.0)
            step = self._settle(depth, step.active, offset)
            iterations += step.iterations
            history += step.history
        raise ConvergenceError(
            f"the overlap did not vanish in {self.limit} updates of the multipliers", history
        )

    def _settle(
        self, depth: float, active: NDArray[np.bool_], offset: NDArray[np.float64]
    ) -> _Step:
        visited: set[bytes] = set()
        history: list[int] = []
        budget, one_by_one = self.limit, False
        while len(history) < budget:
            step = self._fixed(active, depth, offset)
            proposal = self._next_set(step, offset)
            history.append(int(active.sum()))
            if np.array_equal(proposal, active):
                return step.after(len(history), history)
            if proposal.tobytes() in visited and not one_by_one:
                one_by_one, budget = True, budget + 10 * len(self.gap)
            visited.add(proposal.tobytes())
            if one_by_one:
                # Murty's least-index pivoting, finite because the compliance is positive definite
                change = np.flatnonzero(proposal != active)[0]
                proposal = active.copy()
                proposal[change] = ~active[change]
            active = proposal
        raise ConvergenceError(
            f"the contact set did not settle in {budget} iterations at penetration "
            f"{depth * self.body.length:.6g}",
            history,
        )

    def _fixed(self, active: NDArray[np.bool_], depth: float, offset: NDArray[np.float64]) -> _Step:
        """Return forces and displacements for contact at exactly the active points."""
        reactions = np.zeros_like(self.gap)
        everywhere, slope = np.zeros_like(self.body.scaled_weights), 0.0
        inside = np.flatnonzero(active)
        if len(inside):
            right = np.stack([depth - self.gap + offset, np.ones_like(offset)], axis=1)[inside]
            with np.errstate(over="ignore", invalid="ignore"):
                solved, displacement = self._respond(inside, self.softness, right)
                reactions[inside], slope = solved[:, 0], float(solved[:, 1].sum())
            everywhere = displacement[:, 0]
            if not (np.isfinite(everywhere).all() and np.isfinite(reactions.sum())):
                raise ConvergenceError(
                    f"forces overflow at penetration {depth * self.body.length:.6g}"
                )
        return _Step(depth, active, reactions, everywhere[self.possible], everywhere, slope)

    def _respond(
        self, inside: NDArray[np.int64], softness: NDArray[np.float64], right: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        flexibility = self.body.flexibility
        return flexibility.respond(self.possible[inside], right, softness[inside])

    def _slope(self, active: NDArray[np.bool_], softness: NDArray[np.float64]) -> float:
        inside = np.flatnonzero(active)
        return float(self._respond(inside, softness, np.ones((len(inside), 1)))[0].sum())

    def _next_set(self, step: _Step, offset: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return the next contact set: points in compression stay, overlapping points join."""
        # equality to rounding is no overlap, as points exactly at the edge would alternate
        # otherwise
        noise = 64 * np.finfo(float).eps * (abs(step.depth) + np.abs(self.gap))
        overlap = step.depth - self.gap - step.displacement + offset > noise
        return np.where(step.active, step.reactions > 0.0, overlap)

    def _contact(self, step: _Step, penetration: float, force: float | None) -> Contact:
        body = self.body
        unit = body.youngs_modulus * body.length * body.length
        count = len(body.scaled_weights)
        reactions = np.zeros(count)
        active = np.zeros(count, dtype=bool)
        reactions[self.possible] = step.reactions * unit
        active[self.possible] = step.active
        displacement = step.everywhere * body.length
        stiffness = step.slope * body.symmetry * body.youngs_modulus * body.length
        total = body.symmetry * reactions.sum()
        raw = float(body.symmetry * body.weights[active].sum())
        with np.errstate(over="ignore", invalid="ignore"):
            energy = float(0.5 * body.symmetry * reactions @ displacement)
        if not np.isfinite(energy):
            raise ConvergenceError(f"the energy overflows at penetration {penetration:.6g}")
        return Contact(
            penetration=float(penetration),
            force=float(total if force is None else force),
            reactions=reactions,
            pressure=reactions / body.weights,
            displacement=displacement,
            active=active,
            stiffness=stiffness,
            energy=energy,
            contact_area=best_area(body, reactions, active, sharp=len(self.possible) < count),
            contact_area_raw=raw,
            iterations=step.iterations,
            violation=self._violation(step),
            history=step.history,
        )

    def _violation(self, step: _Step) -> float:
        if not step.active.any():
            return 0.0
        overlap = step.overlap(self.gap) / step.depth
        pressure = step.reactions[step.active] / self.weights[step.active]
        mean = step.reactions.sum() / self.weights[step.active].sum()
        return float(max(overlap, 0.0, -pressure.min() / mean))


@dataclass(frozen=True, eq=False)
class _Step:
    depth: float
    active: NDArray[np.bool_]
    reactions: NDArray[np.float64]
    displacement: NDArray[np.float64]
    everywhere: NDArray[np.float64]
    slope: float
    iterations: int = 0
    history: list[int] = field(default_factory=list)

    def after(self, iterations: int, history: list[int]) -> _Step:
        return replace(self, iterations=iterations, history=history)

    def overlap(self, gap: NDArray[np.float64]) -> float:
        return float(np.max(self.depth - gap - self.displacement, initial=0.0))
