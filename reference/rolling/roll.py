"""Rolling of a rigid roller on an elastic body with Coulomb friction and creep.

**Steady.** The contact stands still, and the surface flows through it along -x. Its material enters
undeformed ahead of the contact; a point that has arrived at x slips over the roller by

    s = c + dx(u)        per distance rolled (steady state: the time derivative of u is -V dx(u)),

c the creep, by which the roller's surface would slide over a rigid one, u = A q the displacement
(Johnson 1985, sec. 8.1; Kalker 1990, sec. 1.3). Between a cell and the next one upstream the
derivative is a difference, D q = A q - A q(x + dx) over dx: `contact.slide` for a body of the
compliance D, which is not symmetric. First order in the cells, as the slip belongs to the middle
between two.

The contact moves along +x over the half-space; creep and tangential force count positive along the
same axes, the force being that on the half-space. Pressure drags the surface along, which is a
creep that varies over the contact, and tractions lift it; both vanish at nu = 1/2 and between
bodies of equal constants (``coupled = False``). Reversing the creep reverses the tractions only
without coupling: a driven and a braked roller differ by it.

**Step by step** (`roll_on`), from any state. The grid rolls on by one cell per step, dx; the
surface carries its displacement along,

    slip of a step = dx c + u(x + dx) before - u(x) now,

a problem of a symmetric body. Where the steps come to rest they obey the steady equations. Rollers
whose shape changes as they roll (roughness that travels with the surface) have no steady state.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from functools import partial
from typing import NamedTuple, Protocol

import numpy as np
from scipy import fft as transforms

from reference.arrays import Array, Mask
from reference.contact.press import Contact, press
from reference.contact.slide import Tractions, slide
from reference.errors import ConvergenceError, finite_faults, refuse
from reference.halfspace.friction import FrictionalPress, alternate
from reference.halfspace.traction import Compliance, NormalAndTangential, tensor_product
from reference.loads import Load

# Of a cell: where the slip by spin is taken, see `rigid_slip`.
_AHEAD = 1 / 6
# Empty cells around the periodic grid of the approximate inverse.
_RIM = 8
# Error of the tractions in a step of `roll_on`.
_STEP_ERROR = 1e-7


class TangentialSurface(Protocol):
    """An elastic surface under tangential tractions on cells."""

    @property
    def spacing(self) -> tuple[float, float]:
        """Sides of a cell."""
        ...

    @property
    def compliance(self) -> Compliance:
        """That of the half-space which it resembles from cell to cell."""
        ...

    def shear_coefficients(self) -> Array:
        """Return u_x by q_x, u_y by q_y, and u_x by q_y, at all offsets of cells.

        Shape (3, mx, my), the offsets modulo m, of at least the grid's size to either side.
        """
        ...


class Creep(NamedTuple):
    """Rigid slip of the roller over the half-space, per distance rolled."""

    # of the middle of the grid, along x (rolling) and y
    along: float
    across: float = 0.0
    spin: float = 0.0  # rotation about z per distance rolled: -spin y along x, spin x along y


@dataclass(frozen=True)
class RollingStep:
    """Steady rolling at one creep."""

    creep: Creep
    penetration: float
    force: float
    tangential_force: float  # on the half-space, along x
    lateral_force: float
    moment: float  # about z at the middle of the grid
    pressure: Array = field(repr=False)  # (nx, ny)
    traction: Array = field(repr=False)  # (2, nx, ny), on the half-space
    slip: Array = field(repr=False)  # of loaded cells, per distance rolled
    sticking: Mask = field(repr=False)  # (nx, ny)
    loss: float  # energy lost to friction per distance rolled
    # as `halfspace.friction.FrictionStep`; rounds are Newton's
    violation: float
    error: float
    rounds: int


class Upstream:
    """D: the displacement of a surface less that of the next cell upstream, over dx.

    The grid's row of largest x stays unloaded.
    """

    def __init__(self, surface: TangentialSurface, shape: tuple[int, int]) -> None:
        self.shape, self.step = shape, surface.spacing[0]
        table = surface.shear_coefficients()
        table = (table - np.roll(table, -1, axis=1)) / self.step
        self.own = float(table[:2, 0, 0].max())
        self._padded = table.shape[1:]
        self._modes = transforms.rfft2(table)
        around = [transforms.next_fast_len(n + _RIM, real=True) if n > 1 else 1 for n in shape]
        self._near = NormalAndTangential(
            (around[0], around[1]), surface.spacing, surface.compliance, periodic=True
        )

    def shear(self, traction: Array) -> Array:
        """Return D q."""
        return tensor_product(self._modes, traction, self._padded)

    def near(self, slip: Array) -> Array:
        """Return the traction on a periodic grid that leads to this slip up from its front."""
        nx, ny = self.shape
        displacement = np.zeros((2, *self._near.shape))
        displacement[:, :nx, :ny] = np.cumsum(slip[:, ::-1], axis=1)[:, ::-1] * self.step
        return self._near.near(displacement)[:, :nx, :ny]


def steady(
    flow: Upstream, bound: Array, creep: Array, start: Array | None = None, tolerance: float = 1e-9
) -> Tractions:
    """Return the tractions of steady rolling at given bounds; slip is per distance rolled.

    `bound` is mu p, infinite where no slip is possible, as in the limit of small creep; `creep`
    is c on all cells, the part that the pressure drags along included.
    """
    if (bound[-1] > 0).any():
        raise ConvergenceError("the contact reaches the leading edge of the grid")
    return slide(flow, bound, creep, start=start, tolerance=tolerance)


def rigid_slip(creep: Creep, shape: tuple[int, int], spacing: tuple[float, float]) -> Array:
    """Return the rigid slip between each cell and the next one upstream, shape (2, nx, ny).

    Its mean is that half a cell ahead. But tractions of stick act on cells as in a contact whose
    middle lies a third of a cell behind: spin is taken a sixth of a cell ahead, as CONTACT does
    (Vollebregt & Kalker). On eight cells per radius C23 then errs by 2.2 % at most, else by 12.5 %.
    """
    x, y = _places(shape, spacing)
    slip = np.empty((2, *shape))
    slip[0] = creep.along - creep.spin * y
    slip[1] = creep.across + creep.spin * (x + spacing[0] * _AHEAD)[:, None]
    return slip


def _places(shape: tuple[int, int], spacing: tuple[float, float]) -> tuple[Array, Array]:
    """Return x and y of the cells from the middle of the grid."""
    x, y = ((np.arange(float(n)) - (n - 1) / 2) * d for n, d in zip(shape, spacing, strict=True))
    return x, y


def roll(
    roller: FrictionalPress, load: Load, creeps: Iterable[Creep], *, tolerance: float = 1e-8
) -> Iterator[RollingStep]:
    """Solve steady rolling at several creeps under one normal load.

    The body is a free half-space; at least one row of cells without contact lies at the end of
    largest x. The load is one penetration or force. Each creep starts from the tractions of the
    one before; the tolerance is the largest `violation` and `error`.

    A creep of 1 is beyond all stick:

    >>> x = (np.arange(12) - 5.5) / 4
    >>> body = NormalAndTangential((12, 12), (0.25, 0.25), Compliance.of(1.0, 0.5))
    >>> ball = FrictionalPress(body, (x[:, None] ** 2 + x**2) / 2, 0.1)
    >>> (sliding,) = roll(ball, Load("force", 5.0), [Creep(1.0)])
    >>> round(sliding.tangential_force, 4), bool(sliding.sticking.any())
    (0.5, False)
    """
    load.one_of("penetration", "force")
    load.single()
    listed = [Creep(*creep) for creep in creeps]
    for creep in listed:
        refuse(finite_faults(**creep._asdict()))
    body, flow = roller.body, Upstream(roller.body, roller.body.shape)

    def rolled(rigid: Array, contact: Contact, start: Array, precision: float) -> Tractions:
        rate = rigid
        if roller.coupled:
            dragged = np.diff(body.drag(contact.pressure), axis=1) / body.spacing[0]
            rate = rigid + np.pad(dragged, ((0, 0), (0, 1), (0, 0)))
        return steady(flow, roller.friction * contact.pressure, rate, start, precision / 10)

    def steps() -> Iterator[RollingStep]:
        x, y = _places(body.shape, body.spacing)
        contact: Contact | None = None
        traction = np.zeros((2, *body.shape))
        for creep in listed:
            rigid = rigid_slip(creep, body.shape, body.spacing)
            answer = alternate(roller, load, partial(rolled, rigid), (contact, traction), tolerance)
            contact, solved = answer.contact, answer.tractions
            traction = solved.traction
            along, across = traction.sum(axis=(1, 2)) * body.cell_area
            turning = traction[1] * x[:, None] - traction[0] * y
            yield RollingStep(
                creep=creep,
                penetration=answer.penetration,
                force=contact.force,
                tangential_force=float(along),
                lateral_force=float(across),
                moment=float(turning.sum() * body.cell_area),
                pressure=contact.pressure,
                traction=traction,
                slip=solved.slip,
                sticking=(contact.pressure > 0) & ~solved.sliding,
                loss=float((traction * solved.slip).sum() * body.cell_area),
                violation=answer.violation,
                error=solved.error,
                rounds=answer.iterations,
            )

    return steps()


def roll_on(
    body: NormalAndTangential,
    pressures: Iterable[Array],
    friction: float,
    creep: Creep,
    start: Array | None = None,
) -> Iterator[Array]:
    """Yield the tractions (2, nx, ny) of a roll by one cell per pressure, uncoupled from these.

    The pressure is the same one in every step for a smooth roller, `pressed` for a rough one;
    `start` has the tractions (2, nx, ny) before the first step, such as Cattaneo's.
    """
    traction = np.zeros((2, *body.shape)) if start is None else start.copy()
    displacement = body.shear(traction)
    rigid = body.spacing[0] * rigid_slip(creep, body.shape, body.spacing)
    for pressure in pressures:
        bound = friction * pressure
        if (bound[-1] > 0).any():
            raise ConvergenceError("the contact reaches the leading edge of the grid")
        carried = np.zeros_like(displacement)
        carried[:, :-1] = displacement[:, 1:]
        solved = slide(body, bound, carried + rigid, start=traction, tolerance=_STEP_ERROR)
        traction, displacement = solved.traction, solved.displacement
        yield traction


def pressed(
    body: NormalAndTangential, gap: Array, roughness: Array, load: Load, tolerance: float = 1e-7
) -> Iterator[Array]:
    """Yield the pressures of a roller whose roughness travels through the contact with the surface.

    `gap` is that of the smooth roller. `roughness` has heights (mx, ny), mx >= nx, with peaks
    towards the half-space, of which rows enter at the grid's end of largest x.
    """
    rows, contact = body.shape[0], None
    for first in range(roughness.shape[0] - rows + 1):
        rough = gap - roughness[first : first + rows]
        lowest = float(rough.min())
        applied = load.single() - (lowest if load.control == "penetration" else 0.0)
        wanted = Load(load.control, applied)
        contact = press(body.normal, rough - lowest, wanted, tolerance=tolerance, start=contact)
        yield contact.pressure
