"""Steady rolling of a rigid roller on an elastic half-space, with Coulomb friction and creep.

Normal and tangential problem are solved in turn, as in `halfspace.friction`: tractions lift the
surface under the roller, and pressure drags it along, which is a creep that varies over the
contact. Both vanish at nu = 1/2 and between bodies of equal constants (``coupled = False``).

The contact moves along +x over the half-space; creep and tangential force count positive along the
same axes, the force being that on the half-space. Reversing the creep reverses the tractions only
without coupling: a driven and a braked roller differ by it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from reference.arguments import finite_faults, refuse
from reference.contact.press import Contact, violation
from reference.errors import ConvergenceError
from reference.halfspace import fft
from reference.halfspace.friction import FrictionalPress
from reference.halfspace.solution import Press
from reference.loads import Load
from reference.rolling.tractions import Rolling, Tractions

Field = NDArray[np.float64]
Fields = NDArray[np.float64]

_NORMAL = ("penetration", "force")
_ROUNDS = 40
# Of a cell: where the slip by spin is taken, see `rigid_slip`.
_AHEAD = 1 / 6


class Creep(NamedTuple):
    """Rigid slip of the roller over the half-space, per distance rolled.

    Attributes
    ----------
    along, across : float
        Of the middle of the grid, along x (rolling) and y.
    spin : float
        Rotation about z per distance rolled: -spin y along x, spin x along y.
    """

    along: float
    across: float = 0.0
    spin: float = 0.0


@dataclass(frozen=True)
class RollingStep:
    """Steady rolling at one creep.

    Attributes
    ----------
    creep : Creep
    penetration, force : float
    tangential_force, lateral_force, moment : float
        On the half-space, along x and y, and about z at the middle of the grid.
    pressure : ndarray, shape (nx, ny)
    traction, slip : ndarray, shape (2, nx, ny)
        On the half-space; slip per distance rolled.
    sticking : ndarray of bool, shape (nx, ny)
    loss : float
        Energy lost to friction per distance rolled.
    violation : float
        Violation of the normal conditions with all tractions, as in `solution.Contact`.
    error : float
        `Tractions.error`.
    rounds : int
        Of Newton's method, all rounds of normal and tangential problem together.
    """

    creep: Creep
    penetration: float
    force: float
    tangential_force: float
    lateral_force: float
    moment: float
    pressure: Field = field(repr=False)
    traction: Fields = field(repr=False)
    slip: Fields = field(repr=False)
    sticking: NDArray[np.bool_] = field(repr=False)
    loss: float
    violation: float
    error: float
    rounds: int


def rigid_slip(creep: Creep, shape: tuple[int, int], spacing: tuple[float, float]) -> Fields:
    """Return the rigid slip between each cell and the next one upstream, shape (2, nx, ny).

    Its mean is that half a cell ahead. But tractions of stick, which have no bound at the trailing
    edge, act on cells as in a contact whose middle lies a third of a cell behind: spin is taken a
    sixth of a cell ahead, as CONTACT does (Vollebregt & Kalker). On eight cells per radius C23
    then errs by 2.2 % at most, with half a cell by 12.5 %.
    """
    x, y = _places(shape, spacing)
    slip = np.empty((2, *shape))
    slip[0] = creep.along - creep.spin * y
    slip[1] = creep.across + creep.spin * (x + spacing[0] * _AHEAD)[:, None]
    return slip


def _places(shape: tuple[int, int], spacing: tuple[float, float]) -> tuple[Field, Field]:
    """Return x and y of the cells from the middle of the grid."""
    nx, ny = shape
    dx, dy = spacing
    x = dx * (np.arange(float(nx)) - (nx - 1) / 2)
    y = dy * (np.arange(float(ny)) - (ny - 1) / 2)
    return x, y


def roll(
    roller: FrictionalPress,
    load: Load,
    creeps: Iterable[Creep],
    *,
    tolerance: float = 1e-8,
) -> Iterator[RollingStep]:
    """Solve steady rolling at several creeps under one normal load.

    Parameters
    ----------
    roller : FrictionalPress
        Free half-space, initial gap and mu. At least one row of cells without contact lies at the
        end of largest x.
    load : Load
        ``"penetration"`` or ``"force"``, one value.
    creeps : iterable of Creep
    tolerance : float
        Largest `violation` and `error`.

    Yields
    ------
    RollingStep

    Raises
    ------
    ValueError
        At the call: load, or creep that is not finite.
    ConvergenceError
        On iteration.

    Examples
    --------
    A creep of 1 is beyond all stick:

    >>> from reference.halfspace.cerruti import Compliance
    >>> from reference.halfspace.traction import NormalAndTangential
    >>> x = (np.arange(12) - 5.5) / 4
    >>> body = NormalAndTangential((12, 12), (0.25, 0.25), Compliance.of(1.0, 0.5))
    >>> ball = FrictionalPress(body, (x[:, None] ** 2 + x**2) / 2, 0.1)
    >>> (sliding,) = roll(ball, Load("force", 5.0), [Creep(1.0)])
    >>> round(sliding.tangential_force, 4), bool(sliding.sticking.any())
    (0.5, False)
    """
    load.one_of(*_NORMAL)
    load.single()
    listed = [Creep(*creep) for creep in creeps]
    for creep in listed:
        refuse(finite_faults(**creep._asdict()))
    return _Roller(roller, load, tolerance).steps(listed)


class _Roller:
    """The contact between two creeps: its pressure and tractions."""

    def __init__(self, roller: FrictionalPress, load: Load, tolerance: float) -> None:
        self.body, self.gap, self.friction = roller.body, roller.gap, roller.friction
        self.load, self.tolerance = load, tolerance
        self.coupled = roller.coupled and self.body.compliance.coupling > 0
        self.contact: Contact | None = None
        self.rolling: Rolling | None = None

    def steps(self, creeps: list[Creep]) -> Iterator[RollingStep]:
        """Yield the steps, each from the tractions of the one before."""
        before: Fields | None = None
        for creep in creeps:
            step = self._step(creep, before)
            before = step.traction
            yield step

    def _step(self, creep: Creep, start: Fields | None) -> RollingStep:
        """Solve normal and tangential problem in turn."""
        lift, history, rounds = np.zeros(self.body.shape), [], 0
        if self.coupled and start is not None:
            lift = self.body.lift(start)
        for _ in range(_ROUNDS):
            contact, depth = self._pressed(lift)
            answer = self._rolled(contact, creep, start)
            rounds, start = rounds + answer.rounds, answer.traction
            lifted = self.body.lift(answer.traction) if self.coupled else lift
            history.append(self._violation(contact, depth, lifted - lift))
            if history[-1] <= self.tolerance:
                return self._result(creep, contact, depth, answer, history[-1], rounds)
            lift = lifted
        raise ConvergenceError(
            f"normal and tangential problem of rolling disagree by {history[-1]:.1e} of the "
            f"penetration after {_ROUNDS} rounds",
            history,
        )

    def _pressed(self, lift: Field) -> tuple[Contact, float]:
        """Return the contact under the lifted surface and the true penetration."""
        if not self.coupled and self.contact is not None:
            return self.contact, self.contact.penetration
        lifted = self.gap + lift
        offset = float(lifted.min()) if self.coupled else 0.0
        applied = self.load.single()
        applied -= offset if self.load.control == "penetration" else 0.0
        self.contact = fft.solve(
            Press(self.body.normal, lifted - offset),
            Load(self.load.control, applied),
            tolerance=self.tolerance / 4,
            start=self.contact,
        )
        self.rolling = None
        return self.contact, self.contact.penetration + offset

    def _rolled(self, contact: Contact, creep: Creep, start: Fields | None) -> Tractions:
        if self.rolling is None:
            self.rolling = Rolling(self.body, self.friction * contact.pressure)
        rate = rigid_slip(creep, self.body.shape, self.body.spacing)
        if self.coupled:
            drag = self.body.drag(contact.pressure)
            rate[:, :-1] += np.diff(drag, axis=1) / self.body.spacing[0]
        return self.rolling.at(rate, start, self.tolerance / 10)

    def _violation(self, contact: Contact, depth: float, change: Field) -> float:
        """Return the violation of the normal conditions by a change of the lift."""
        if not self.coupled:
            return contact.violation
        if self.load.control == "force":
            change = change - change[contact.mask].mean()
        finite = np.isfinite(self.gap)
        return violation(contact.gap + change, contact.mask, finite, depth)

    def _result(
        self,
        creep: Creep,
        contact: Contact,
        depth: float,
        answer: Tractions,
        worst: float,
        rounds: int,
    ) -> RollingStep:
        along, across = answer.traction.sum(axis=(1, 2)) * self.body.cell_area
        x, y = _places(self.body.shape, self.body.spacing)
        turning = answer.traction[1] * x[:, None] - answer.traction[0] * y
        return RollingStep(
            creep=creep,
            penetration=depth,
            force=contact.force,
            tangential_force=float(along),
            lateral_force=float(across),
            moment=float(turning.sum() * self.body.cell_area),
            pressure=contact.pressure,
            traction=answer.traction,
            slip=answer.slip,
            sticking=contact.mask & ~answer.sliding,
            loss=float((answer.traction * answer.slip).sum() * self.body.cell_area),
            violation=worst,
            error=answer.error,
            rounds=rounds,
        )
