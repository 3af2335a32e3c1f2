"""Normal and tangential contact with Coulomb friction on the half-space, along a loading path.

In every step the normal problem (`contact.press`, with the lift of the tangential tractions in the
gap) and the tangential one (`contact.slide`, with the drag of the pressure and the slip of steps
before) are solved in turn until both are satisfied (Panagiotopoulos 1975). They are coupled by 1 -
2 nu only, and the rounds converge with the factor (mu times Dundurs' second constant)^2. Without
this coupling one round is exact.

Slip is measured over whole steps (implicit Euler): if its direction turns or the contact grows in a
step, the result is of first order in the steps. Under constant pressure and increasing force,
without coupling, one step is as good as many except for the turning of slip off the axis.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from reference.arrays import Array, Mask
from reference.contact import press as unilateral
from reference.contact.press import Contact, check_gap, rectangle, violation
from reference.contact.slide import Tractions, slide
from reference.errors import ConvergenceError, NoEquilibriumError, positive_faults, refuse
from reference.halfspace.traction import NormalAndTangential
from reference.loads import Load, LoadPath, slides

# Precision of the first round of a step, and of the next ones relative to the remaining error.
_FIRST_ROUND, _PER_ROUND, _MOST_ROUNDS = 1e-3, 0.1, 60


@dataclass(frozen=True, eq=False)
class FrictionalPress:
    """A rigid shape over a half-space for normal and tangential loads."""

    body: NormalAndTangential
    gap: Array  # (nx, ny): initial gap of the rigid shape; +inf where contact is impossible
    friction: float  # mu, positive and finite
    # False neglects the coupling of normal and tangential displacements; there is none at nu = 1/2
    coupled: bool = True

    def __post_init__(self) -> None:
        object.__setattr__(self, "gap", check_gap(self.body.normal, self.gap))
        refuse(positive_faults(friction=self.friction))
        coupled = self.coupled and self.body.compliance.coupling > 0
        object.__setattr__(self, "coupled", coupled)


@dataclass(frozen=True)
class FrictionStep:
    """One converged step of normal and tangential loading."""

    penetration: float
    force: float
    # U of the rigid shape along x (guided, without motion along y) and F_x on it
    tangential_displacement: float
    tangential_force: float
    pressure: Array = field(repr=False)  # (nx, ny)
    # (2, nx, ny): tangential tractions on the half-space, and slip of the shape over it since the
    # previous step
    traction: Array = field(repr=False)
    slip: Array = field(repr=False)
    sticking: Mask = field(repr=False)  # (nx, ny): loaded cells below their bounds
    dissipation: float  # energy lost to friction since the start of the path
    # violation of the normal conditions, as in `press.Contact`, with all tractions
    violation: float
    error: float  # that of the tractions in Coulomb's law, `slide.Tractions.error`
    # rounds of normal and tangential problems, and Newton's of the latter
    rounds: int
    iterations: int


def slide_inside(
    body: NormalAndTangential,
    bound: Array,
    target: Array,
    total: float | None,
    start: Array,
    tolerance: float,
) -> Tractions:
    """`slide` on a free body of the smallest rectangle around loaded cells."""
    loaded = bound > 0
    if body.periodic or not loaded.any():
        return slide(body, bound, target, total=total, start=start, tolerance=tolerance)
    box = rectangle(loaded)
    inside = (slice(None), *box)
    part = body.restrict(bound[*box].shape)
    solved = slide(
        part, bound[*box], target[inside], total=total, start=start[inside], tolerance=tolerance
    )
    for name in ("traction", "slip"):
        whole = np.zeros_like(target)
        whole[inside] = getattr(solved, name)
        setattr(solved, name, whole)
    sliding = np.zeros_like(loaded)
    sliding[*box] = solved.sliding
    solved.sliding, solved.displacement = sliding, body.shear(solved.traction)
    return solved


@dataclass(frozen=True)
class Alternated:
    """Pressure and tractions that satisfy each other; numbers as in `FrictionStep`."""

    contact: Contact
    penetration: float
    tractions: Tractions
    violation: float
    rounds: int
    iterations: int


def alternate(
    press: FrictionalPress,
    load: Load,
    sheared: Callable[[Contact, Array, float], Tractions],
    start: tuple[Contact | None, Array],
    tolerance: float,
) -> Alternated:
    """Solve normal and tangential problem in turn.

    ``sheared(contact, start, tolerance)`` gives the tractions below the pressure of a contact;
    `start` has the contact and the tractions to start from. The tolerance is for the violation,
    and for the error of the tractions.
    """
    contact, traction = start
    body, finite = press.body, np.isfinite(press.gap)
    lift = body.lift(traction) if press.coupled else np.zeros(body.shape)
    # each problem to the accuracy of the other one, finally to the tolerance
    precision = max(tolerance, _FIRST_ROUND) if press.coupled else tolerance
    history: list[float] = []
    iterations = 0
    for rounds in range(1, _MOST_ROUNDS + 1):
        lifted = press.gap + lift
        offset = float(lifted.min()) if press.coupled else 0.0
        applied = load.single() - (offset if load.control == "penetration" else 0.0)
        contact = unilateral.press(
            body.normal,
            lifted - offset,
            Load(load.control, applied),
            tolerance=0.3 * precision,
            start=contact,
        )
        depth = contact.penetration + offset
        tractions = sheared(contact, traction, precision)
        traction = tractions.traction
        iterations += tractions.rounds
        worst = contact.violation
        if press.coupled:
            change = body.lift(traction) - lift
            lift = lift + change
            if load.control == "force":
                change -= change[contact.mask].mean()
            worst = violation(contact.gap + change, contact.mask, finite, depth)
        history.append(worst)
        if max(worst, precision) <= tolerance:
            return Alternated(contact, depth, tractions, worst, rounds, iterations)
        precision = max(tolerance, _PER_ROUND * worst)
    raise ConvergenceError(
        f"normal and tangential problem disagree by {worst:.1e} of the penetration after "
        f"{_MOST_ROUNDS} rounds",
        history,
    )


def sweep(
    press: FrictionalPress, normal: LoadPath, tangential: LoadPath, *, tolerance: float = 1e-6
) -> Iterator[FrictionStep]:
    """Solve a path of normal and tangential loads.

    The normal path is one of penetrations or forces, positive; a single value is constant. The
    tangential one has displacements or forces along x of any sign; a force must be below mu F.
    The tolerance is the largest `violation` and `error`.

    Cattaneo (1938): F_x = 7/8 mu F leaves a stick circle of half the contact radius.

    >>> from reference.halfspace.traction import Compliance
    >>> x = (np.arange(32) - 15.7) / 14
    >>> body = NormalAndTangential((32, 32), (1 / 14, 1 / 14), Compliance.of(1.0, 0.0))
    >>> gap = (x[:, None] ** 2 + x**2) / 2
    >>> load = 4 / 3 * body.compliance.effective_modulus
    >>> ball = FrictionalPress(body, gap, 0.1, coupled=False)
    >>> (step,) = sweep(ball, LoadPath("force", load), LoadPath("tangential_force", 0.0875 * load))
    >>> round(float(np.sqrt(step.sticking.sum() / np.pi)) / 14, 1)
    0.5
    """
    normal.one_of("penetration", "force")
    by_force = tangential.one_of("tangential_displacement", "tangential_force").endswith("force")
    normal.positive()
    if len({path.values.size for path in (normal, tangential)} - {1}) > 1:
        sizes = " and ".join(f"{p.values.size} of {p.control}" for p in (normal, tangential))
        raise ValueError(f"both paths must have the same number of steps, not {sizes}")
    loads = np.broadcast_arrays(normal.values, tangential.values)
    body = press.body

    def drag(contact: Contact) -> Array:
        return body.drag(contact.pressure) if press.coupled else np.zeros((2, *body.shape))

    def sheared(
        position: Array, pulled: float, contact: Contact, start: Array, precision: float
    ) -> Tractions:
        target, bound = -position - drag(contact), press.friction * contact.pressure
        if not by_force:
            target[0] += pulled
            return slide_inside(body, bound, target, None, start, precision)
        limit = press.friction * contact.force
        if slides(pulled, limit):
            raise NoEquilibriumError(
                f"the tangential force {pulled!r} is not below friction times the normal force, "
                f"{limit!r}: full sliding"
            )
        return slide_inside(body, bound, target, pulled / body.cell_area, start, precision)

    def steps() -> Iterator[FrictionStep]:
        # position of the shape relative to the half-space, and what acts before the step
        position, traction = np.zeros((2, *body.shape)), np.zeros((2, *body.shape))
        contact, dissipation = None, 0.0
        for pushed, pulled in np.transpose(loads).tolist():
            now = Load(normal.control, pushed)
            shear = partial(sheared, position, pulled)
            answer = alternate(press, now, shear, (contact, traction), tolerance)
            contact, traction = answer.contact, answer.tractions.traction
            before, shift = position, answer.tractions.shift if by_force else pulled
            position = -answer.tractions.displacement - drag(contact)
            position[0] += shift
            dissipation += float((traction * (position - before)).sum()) * body.cell_area
            yield FrictionStep(
                penetration=answer.penetration,
                force=contact.force,
                tangential_displacement=shift,
                tangential_force=float(traction[0].sum()) * body.cell_area,
                pressure=contact.pressure,
                traction=traction,
                slip=position - before,
                sticking=contact.mask & ~answer.tractions.sliding,
                dissipation=dissipation,
                violation=answer.violation,
                error=answer.tractions.error,
                rounds=answer.rounds,
                iterations=answer.iterations,
            )

    return steps()


def tangential_stiffness(
    body: NormalAndTangential, mask: ArrayLike, direction: tuple[float, float] = (1.0, 0.0)
) -> tuple[float, float]:
    """Return the tangential stiffness in full stick, without coupling to normal displacement.

    Of the cells in contact, as forces along and transverse to the direction of the
    displacement, a unit vector, per unit of it.
    """
    mask = np.asarray(mask, dtype=bool)
    if mask.shape != body.shape or not mask.any():
        raise ValueError(f"mask must have shape {body.shape} and a cell in contact")
    target = np.array(direction)[:, None, None] * np.ones((2, *body.shape))
    bound = np.where(mask, np.inf, 0.0)
    stuck = slide(body, bound, target, tolerance=1e-8)
    along, across = stuck.traction.sum(axis=(1, 2)) * body.cell_area
    c, s = direction
    return float(c * along + s * across), float(c * across - s * along)
