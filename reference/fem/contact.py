"""Frictionless contact of a condensed body with a rigid shape."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.arguments import choice_faults, count_faults, positive_faults, refuse
from reference.contact.pivot import pivot
from reference.errors import ConvergenceError
from reference.fem.body import CondensedBody
from reference.fem.contact_area import best_area
from reference.loads import LoadPath

METHODS = ("active_set", "penalty", "augmented_lagrangian")
CONTROLS = ("penetration", "force")

Response = tuple[NDArray[np.float64], NDArray[np.float64]]


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
        Largest overlap over the penetration from first touch of a point; with a penalty also that
        inside the contact.
    history : list of int
        Number of wrong points by iteration.
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
        any order; every step starts from the previous contact set (`reference.contact.pivot`).
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
    gap = np.asarray(gap, dtype=float)
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
    load.one_of(*CONTROLS)
    load.positive()
    active = np.zeros(shape, bool) if start is None else np.asarray(start, bool) & np.isfinite(gap)
    return _pressed(body, gap, load, enforcement, active)


def _pressed(
    body: CondensedBody,
    gap: NDArray[np.float64],
    load: LoadPath,
    enforcement: Enforcement,
    active: NDArray[np.bool_],
) -> Iterator[Contact]:
    """Solve in lengths of body.length and forces of E length^2, with depths from first touch.

    So a distant shape loses no digits of the overlap.
    """
    length, weights, by_force = body.length, body.scaled_weights, load.control == "force"
    first_touch = float(gap.min())
    scaled = (gap - first_touch) / length
    unit = body.youngs_modulus * length * length
    softness = np.zeros_like(weights)
    if enforcement.method != "active_set":
        per_area = enforcement.penalty / (1.0 - body.poisson_ratio**2) / body.spacing_scaled
        softness = 1.0 / (per_area * weights)

    def respond(inside: NDArray[np.int64], right: NDArray[np.float64]) -> Response:
        return body.flexibility.respond(inside, right, softness[inside])

    for value in load.values:
        depth = (value - first_touch) / length
        target = value / (unit * body.symmetry) if by_force else depth
        if not by_force and depth <= 0.0:  # first touch may be between the points
            nothing = np.zeros_like(weights)
            yield _contact(body, nothing, nothing, 0.0, float(value), 0.0, 0.0, [])
            continue
        if not active.any():
            active = scaled == 0.0 if by_force else scaled < depth
        history: list[int] = []
        offset = np.zeros_like(scaled)
        for _ in range(enforcement.max_iterations):
            settled = pivot(
                respond,
                scaled - offset,
                active,
                target,
                per_depth=0.0 if by_force else 1.0,
                per_pressure=1.0 if by_force else 0.0,
                max_rounds=enforcement.max_iterations,
            )
            history += settled.history
            active, depth, reactions = settled.active, settled.depth, settled.pressures
            overlap = float(np.max(depth - scaled - settled.displacement, initial=0.0))
            if enforcement.method != "augmented_lagrangian" or overlap <= 1e-10 * depth:
                break
            offset = reactions * softness  # the forces of the last solution, as multipliers
        else:
            raise ConvergenceError(
                f"the overlap did not vanish in {enforcement.max_iterations} updates of the "
                "multipliers",
                history,
            )
        slope = settled.slope
        if enforcement.method == "augmented_lagrangian":
            inside = np.flatnonzero(active)
            rigid = np.zeros(len(inside))
            ones = np.ones((len(inside), 1))
            slope = float(body.flexibility.respond(inside, ones, rigid)[0].sum())
        yield _contact(
            body,
            reactions * unit,
            settled.displacement * length,
            slope * body.symmetry * body.youngs_modulus * length,
            float(first_touch + depth * length if by_force else value),
            float(value) if by_force else float(body.symmetry * unit * reactions.sum()),
            overlap / depth,
            history,
            sharp=not np.isfinite(gap).all(),
        )


def _contact(
    body: CondensedBody,
    reactions: NDArray[np.float64],
    displacement: NDArray[np.float64],
    stiffness: float,
    penetration: float,
    force: float,
    violation: float,
    history: list[int],
    *,
    sharp: bool = False,
) -> Contact:
    """Return a converged step, with energy and areas."""
    active = reactions > 0.0
    with np.errstate(over="ignore", invalid="ignore"):
        energy = float(0.5 * body.symmetry * reactions @ displacement)
    if not np.isfinite(energy):
        raise ConvergenceError(f"the energy overflows at penetration {penetration:.6g}", history)
    return Contact(
        penetration=penetration,
        force=force,
        reactions=reactions,
        pressure=reactions / body.weights,
        displacement=displacement,
        active=active,
        stiffness=stiffness,
        energy=energy,
        contact_area=best_area(body, reactions, active, sharp=sharp),
        contact_area_raw=float(body.symmetry * body.weights[active].sum()),
        iterations=len(history),
        violation=violation,
        history=history,
    )
