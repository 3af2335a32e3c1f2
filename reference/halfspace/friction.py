"""Normal and tangential contact with Coulomb friction on the half-space, along a loading path.

On every step the normal problem (`fft`, with the lift of the tangential tractions in the gap) and
the tangential problem (`stick_slip`, with the drag of the pressure and the slip of the steps
before) are solved in turn until both are satisfied (Panagiotopoulos 1975). They are coupled by 1 -
2 nu only, and the rounds converge with the factor (mu times Dundurs' second constant)^2. Without
this coupling one round is exact.

Slip is measured over whole steps (implicit Euler): if its direction turns or the contact grows in a
step, the result is of first order in the steps. Under constant pressure and increasing force,
without coupling, one step is as good as many except for the turning of slip off the axis.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.arguments import positive_faults, refuse
from reference.contact.press import Contact, check_gap, violation
from reference.errors import ConvergenceError
from reference.halfspace import fft, stick_slip
from reference.halfspace.solution import Press
from reference.halfspace.traction import NormalAndTangential
from reference.loads import Load, LoadPath

Field = NDArray[np.float64]
Fields = NDArray[np.float64]

# Precision of the first round of a step, and of the next ones relative to the remaining error.
_FIRST_ROUND, _PER_ROUND = 1e-3, 0.1
_NORMAL = ("penetration", "force")
_TANGENTIAL = ("tangential_displacement", "tangential_force")


@dataclass(frozen=True)
class FrictionStep:
    """One converged step of normal and tangential loading.

    Attributes
    ----------
    penetration, force : float
    tangential_displacement, tangential_force : float
        U of the rigid shape along x (guided, without motion along y) and F_x on it.
    pressure : ndarray, shape (nx, ny)
    traction : ndarray, shape (2, nx, ny)
        Tangential tractions on the half-space.
    slip : ndarray, shape (2, nx, ny)
        Slip of the shape over the half-space since the previous step.
    sticking : ndarray of bool, shape (nx, ny)
        Loaded cells below their bounds.
    dissipation : float
        Energy lost to friction since the start of the path.
    violation : float
        Violation of the normal conditions, as in `solution.Contact`, with all tractions.
    slip_error : float
        Largest slip of sticking cells, and of slipping ones transverse to their traction, in this
        step, over mu d E*/G*, the displacement of full sliding of a smooth contact, or over the
        largest displacement if smaller.
    rounds, iterations : int
        Rounds of normal and tangential problems, and iterations of the latter.
    """

    penetration: float
    force: float
    tangential_displacement: float
    tangential_force: float
    pressure: Field = field(repr=False)
    traction: Fields = field(repr=False)
    slip: Fields = field(repr=False)
    sticking: NDArray[np.bool_] = field(repr=False)
    dissipation: float
    violation: float
    slip_error: float
    rounds: int
    iterations: int


@dataclass(frozen=True, eq=False)
class FrictionalPress:
    """A rigid shape over a half-space for normal and tangential loads.

    Parameters
    ----------
    body : NormalAndTangential
    gap : array_like, shape (nx, ny)
        Initial gap of the rigid shape; +inf where contact is impossible.
    friction : float
        mu, positive and finite.
    coupled : bool
        False neglects the coupling of normal and tangential displacements.

    Raises
    ------
    ValueError
        If the gap or the friction is invalid.
    """

    body: NormalAndTangential
    gap: Field
    friction: float
    coupled: bool = True

    def __post_init__(self) -> None:
        object.__setattr__(self, "gap", check_gap(self.body.normal, self.gap))
        refuse(positive_faults(friction=self.friction))


def sweep(
    press: FrictionalPress,
    normal: LoadPath,
    tangential: LoadPath,
    *,
    tolerance: float = 1e-6,
    max_rounds: int = 60,
) -> Iterator[FrictionStep]:
    """Solve a path of normal and tangential loads.

    Parameters
    ----------
    press : FrictionalPress
    normal : LoadPath
        ``"penetration"`` or ``"force"`` at every step, positive. A single value is constant.
    tangential : LoadPath
        ``"tangential_displacement"`` or ``"tangential_force"`` along x, any sign. A force must be
        below mu F.
    tolerance : float
        Largest `violation` and `slip_error`.
    max_rounds : int
        Limit of rounds of normal and tangential problems per step.

    Yields
    ------
    FrictionStep

    Raises
    ------
    ValueError
        At the call, with all invalid arguments.
    ConvergenceError
        On iteration, if a step fails or its force causes full sliding.

    Examples
    --------
    Cattaneo (1938): F_x = 7/8 mu F leaves a stick circle of half the contact radius.

    >>> import numpy as np
    >>> from reference.halfspace.cerruti import Compliance
    >>> x = (np.arange(32) - 15.7) / 14
    >>> body = NormalAndTangential((32, 32), (1 / 14, 1 / 14), Compliance.of(1.0, 0.0))
    >>> gap = (x[:, None] ** 2 + x**2) / 2
    >>> load = 4 / 3 * body.compliance.effective_modulus
    >>> ball = FrictionalPress(body, gap, 0.1, coupled=False)
    >>> (step,) = sweep(ball, LoadPath("force", load), LoadPath("tangential_force", 0.0875 * load))
    >>> round(float(np.sqrt(step.sticking.sum() / np.pi)) / 14, 1)
    0.5
    """
    path = _steps(normal, tangential)
    way = _Path(press, (normal.control, tangential.control), tolerance, max_rounds)
    return (way.step(*loads) for loads in path)


class _Path:
    """The state between two steps: position relative to the half-space, tractions, pressure."""

    def __init__(
        self, press: FrictionalPress, kinds: tuple[str, str], tolerance: float, max_rounds: int
    ) -> None:
        self.body, self.gap, self.friction = press.body, press.gap, press.friction
        self.kinds, self.coupled = kinds, press.coupled
        self.tolerance, self.max_rounds = tolerance, max_rounds
        body = self.body
        self.position = np.zeros((2, *body.shape))
        self.traction = np.zeros((2, *body.shape))
        self.contact: Contact | None = None
        self.dissipation, self.scale = 0.0, 0.0

    def step(self, normal: float, tangential: float) -> FrictionStep:
        """Solve one step and store its state."""
        lift = self.body.lift(self.traction) if self.coupled else np.zeros(self.body.shape)
        history: list[float] = []
        iterations = 0
        # both problems to the accuracy of the other one, finally to the tolerance
        alone = not self.coupled or self.body.compliance.coupling == 0
        precision = self.tolerance if alone else max(self.tolerance, _FIRST_ROUND)
        for rounds in range(1, self.max_rounds + 1):
            contact, depth = self.press(normal, lift, precision)
            shear, drag = self.shift(contact, depth, tangential, precision)
            iterations += shear.iterations
            new_lift = self.body.lift(shear.traction) if self.coupled else lift
            worst = self.violation(contact, depth, lift, new_lift)
            history.append(worst)
            lift, self.traction = new_lift, shear.traction
            reached, precision = precision, max(self.tolerance, _PER_ROUND * worst)
            if worst <= self.tolerance and reached <= self.tolerance:
                step = self.finish((contact, depth), shear, drag, tangential)
                return replace(step, violation=worst, rounds=rounds, iterations=iterations)
        raise ConvergenceError(
            f"normal and tangential problem disagree by {worst:.1e} of the penetration after "
            f"{self.max_rounds} rounds",
            history,
        )

    def press(self, load: float, lift: Field, precision: float) -> tuple[Contact, float]:
        """Solve the normal problem on the lifted surface; return contact and true penetration."""
        lifted = self.gap + lift
        lowest = float(lifted.min())
        offset = lowest if self.coupled else 0.0
        applied = load - offset if self.kinds[0] == "penetration" else load
        contact = fft.solve(
            Press(self.body.normal, lifted - offset),
            Load(self.kinds[0], applied),
            tolerance=0.3 * precision,
            start=self.contact,
        )
        self.contact = contact
        return contact, contact.penetration + offset

    def violation(self, contact: Contact, depth: float, lift: Field, new_lift: Field) -> float:
        """Return the violation of the normal conditions under the current tractions."""
        if not self.coupled:
            return contact.violation
        finite = np.isfinite(self.gap)
        change = new_lift - lift
        if self.kinds[0] == "force":
            change -= change[contact.mask].mean()
        clearance = contact.gap + change
        return violation(clearance, contact.mask, finite, depth)

    def shift(
        self, contact: Contact, depth: float, load: float, precision: float
    ) -> tuple[stick_slip.Tractions, Fields]:
        """Solve the tangential problem for a pressure, in the box of the loaded cells."""
        drag = self.body.drag(contact.pressure) if self.coupled else np.zeros((2, *self.body.shape))
        target = -self.position - drag
        total = None
        if self.kinds[1] == "tangential_force":
            total = load / self.body.cell_area
            self.refuse_sliding(contact, load)
        else:
            target[0] += load
        self.scale = self.size_of_slip(contact, depth, target, load)
        box = self.box(contact.mask)
        rows, columns = box
        part = self.body.restrict((rows.stop - rows.start, columns.stop - columns.start))
        inside = (slice(None), *box)
        bound = self.friction * contact.pressure[box]
        problem = stick_slip.Shear(part, bound, target[inside], total)
        shear = stick_slip.minimise(problem, self.traction[inside], precision * self.scale)
        if part is not self.body:
            traction = np.zeros((2, *self.body.shape))
            traction[inside] = shear.traction
            shear.traction, shear.displacement = traction, self.body.shear(traction)
        return shear, drag

    def finish(
        self,
        normal: tuple[Contact, float],
        shear: stick_slip.Tractions,
        drag: Fields,
        load: float,
    ) -> FrictionStep:
        """Store the state of a converged step and return it."""
        contact, depth = normal
        shift = shear.shift if self.kinds[1] == "tangential_force" else load
        position = -shear.displacement - drag
        position[0] += shift
        slip, self.position = position - self.position, position
        area = self.body.cell_area
        self.dissipation += float((shear.traction * slip).sum()) * area
        forces = shear.traction.sum(axis=(1, 2)) * area
        bound = self.friction * contact.pressure
        return FrictionStep(
            penetration=depth,
            force=contact.force,
            tangential_displacement=shift,
            tangential_force=float(forces[0]),
            pressure=contact.pressure,
            traction=shear.traction,
            slip=slip,
            sticking=contact.mask & (np.hypot(*shear.traction) < stick_slip.ON_BOUND * bound),
            dissipation=self.dissipation,
            violation=contact.violation,
            slip_error=shear.error / self.scale,
            rounds=1,
            iterations=shear.iterations,
        )

    def refuse_sliding(self, contact: Contact, load: float) -> None:
        """Raise an error if the bounds cannot carry the force."""
        limit = self.friction * contact.force
        if not abs(load) < limit:
            raise ConvergenceError(
                f"the tangential force {load!r} is not below friction times the normal force, "
                f"{limit!r}: full sliding"
            )

    def size_of_slip(self, contact: Contact, depth: float, target: Fields, load: float) -> float:
        """Return the reference displacement for errors of slip.

        It is that of full sliding of a smooth contact, mu d E*/G*, or, if smaller, that of stick:
        the present displacements, and a force over the stiffness of a circle of the contact's area.
        """
        modulus = self.body.compliance.tangential_modulus
        sliding = self.friction * depth * self.body.compliance.effective_modulus / modulus
        size = float(np.hypot(*target)[contact.mask].max(initial=0.0))
        if self.kinds[1] == "tangential_force":
            area = np.count_nonzero(contact.mask) * self.body.cell_area
            size += abs(load) / (2 * np.sqrt(area / np.pi) * modulus)
        return min(sliding, size) if size > 0 else sliding

    def box(self, mask: NDArray[np.bool_]) -> tuple[slice, slice]:
        """Return the smallest rectangle around loaded cells, with sides in multiples of eight."""
        if self.body.periodic:
            return slice(0, mask.shape[0]), slice(0, mask.shape[1])

        def side(used: NDArray[np.intp], size: int) -> slice:
            length = min(size, -(-int(used[-1] + 1 - used[0]) // 8) * 8)
            first = min(int(used[0]), size - length)
            return slice(first, first + length)

        rows, columns = (np.flatnonzero(mask.any(axis=1 - axis)) for axis in (0, 1))
        return side(rows, mask.shape[0]), side(columns, mask.shape[1])


def tangential_stiffness(
    body: NormalAndTangential,
    mask: ArrayLike,
    direction: tuple[float, float] = (1.0, 0.0),
    tolerance: float = 1e-8,
) -> tuple[float, float]:
    """Return the tangential stiffness in full stick, without coupling to normal displacement.

    Parameters
    ----------
    body : NormalAndTangential
    mask : array_like of bool, shape (nx, ny)
        Cells in contact; at least one.
    direction : (float, float)
        Direction of the displacement, a unit vector.
    tolerance : float
        Largest error of the displacement, relative.

    Returns
    -------
    (float, float)
        Forces along and transverse to the direction, per unit of displacement.

    Examples
    --------
    For nu = 0 the tangential and normal stiffness of a cell are equal:

    >>> from reference.halfspace.cerruti import Compliance
    >>> body = NormalAndTangential((1, 1), (1.0, 1.0), Compliance.of(1.0, 0.0))
    >>> along, _ = tangential_stiffness(body, [[True]])
    >>> bool(np.isclose(along, 2 * np.pi / (4 * np.log(1 + np.sqrt(2)))))
    True
    """
    mask = np.asarray(mask, dtype=bool)
    if mask.shape != body.shape or not mask.any():
        raise ValueError(f"mask must have shape {body.shape} and a cell in contact")
    target = np.array(direction)[:, None, None] * np.ones((2, *body.shape))
    bound = np.where(mask, np.inf, 0.0)
    shear = stick_slip.minimise(
        stick_slip.Shear(body, bound, target), np.zeros_like(target), tolerance
    )
    along, across = shear.traction.sum(axis=(1, 2)) * body.cell_area
    c, s = direction
    return float(c * along + s * across), float(c * across - s * along)


def _steps(normal: LoadPath, tangential: LoadPath) -> list[tuple[float, float]]:
    """Return the loads by step, or raise ValueError."""
    normal.one_of(*_NORMAL)
    tangential.one_of(*_TANGENTIAL)
    normal.positive()
    if len({path.values.size for path in (normal, tangential)} - {1}) > 1:
        sizes = " and ".join(f"{p.values.size} of {p.control}" for p in (normal, tangential))
        raise ValueError(f"both paths must have the same number of steps, not {sizes}")
    normals, tangentials = np.broadcast_arrays(normal.values, tangential.values)
    return list(zip(normals.tolist(), tangentials.tolist(), strict=True))
