"""An adhesive contact along its path: springs, current edge, jumps and dissipation."""

from __future__ import annotations

from dataclasses import astuple, dataclass

import numpy as np

from reduced.adhesion import line as adhesive_line
from reduced.adhesion.line import FORCE, PENETRATION
from reduced.errors import ConvergenceError
from reduced.profiles.section import Profile
from reduced.springs.indent import continuum_radius
from reduced.springs.line import Springs

_ROUNDS = 200
_SETTLED = 1e-3
_NOTHING = 2.0**-100  # fraction of the profile's length, which is arbitrary for a cone
_EXTENSIONS = 60


@dataclass(frozen=True)
class State:
    """A state of the contact: d, F, a and the elastic energy; a = 0 without contact."""

    penetration: float
    force: float
    contact_radius: float
    elastic_energy: float


@dataclass(frozen=True)
class Event:
    """A jump of the contact, at or between loads of the path.

    Attributes
    ----------
    kind : {"snap_in", "pull_off", "jump"}
        Formation of contact, loss of contact, or a jump between two contact radii.
    step : int
        Index of the load towards which it happened.
    before, after : State
        The states before and after the jump. After a pull-off under force control the penetration
        is that at which the surfaces separate, see `dissipated`.
    dissipated : float
        Free energy lost in the jump: U - pi w a^2 at given penetration, U - pi w a^2 - F d at given
        force. Under force control no equilibrium follows a pull-off; the energy released by contact
        and force until the surfaces separate, at the pull-off depth of penetration control, is
        counted.
    """

    kind: str
    step: int
    before: State
    after: State
    dissipated: float


@dataclass(frozen=True)
class Body:
    """The body and the controlled quantity."""

    profile: Profile
    modulus: float
    work: float
    control: int

    @property
    def surface(self) -> float:
        """Return pi w/E*; times a^2 it is the surface energy of a contact in units of E*."""
        return np.pi * self.work / self.modulus

    @property
    def stretch(self) -> float:
        """Return l(a)^2/a = 2 pi w/E*."""
        return 2 * self.surface


class _LineEndsError(Exception):
    """The contact grew beyond the existing springs."""


def walk(body: Body, loads: np.ndarray, springs: Springs) -> Walk:
    """Create enough springs for the contact and follow it along the loads."""
    reach = _largest_radius(body, float(loads.max()))
    spacing = reach / springs.per_radius if springs.spacing is None else springs.spacing
    for _ in range(_EXTENSIONS):
        way = Walk(body, spacing, springs.offset, reach)
        try:
            for load in loads:
                way.to(float(load))
        except _LineEndsError:
            # close to a fold the estimate of the largest radius is a lower bound only
            reach *= 1.25
        else:
            return way
    raise ConvergenceError("the contact grows without limit: the profile is too flat", [reach])


class Walk:
    """The contact along its path: springs, current edge, and past events."""

    def __init__(self, body: Body, spacing: float, offset: float, reach: float) -> None:
        self.body, self.spacing = body, spacing
        self.half = adhesive_line.half_line(body.profile, spacing, offset, reach)
        self.pieces = adhesive_line.cut(self.half, body.stretch, body.control)
        self.sharp = bool(self.half.x[-1] == body.profile.edge)
        self.piece, self.place = -1, 0.0  # piece -1: no contact; number of pieces: sharp edge
        self.events: list[Event] = []
        self.dissipated = 0.0
        self.record: list[tuple[tuple[float, ...], float, bool]] = []

    def to(self, load: float) -> None:
        """Move to the next load and record the state."""
        # the characteristic is d for penetration, F/(2 E*) for force
        goal = load if self.body.control == PENETRATION else load / (2 * self.body.modulus)
        if self.piece < 0 and goal >= 0:
            self._touch()
        if self.piece >= 0:
            self._shrink(goal)
        if self.piece >= 0:
            self._grow(goal)
        state = self._state(goal)
        holds = self.piece >= 0 or self.body.control == PENETRATION or goal == 0
        self.record.append((astuple(state), self.dissipated, holds))

    def _touch(self) -> None:
        """Start at the axis; if contact spreads at zero load, that is a jump."""
        self.piece, self.place = 0, 0.0
        if self.pieces.load[1] < self.pieces.load[0]:
            self._jump("snap_in", State(0.0, 0.0, 0.0, 0.0), outwards=0, goal=0.0)

    def _grow(self, goal: float) -> None:
        fold = not self._at_edge and self._load() < goal
        while fold:
            piece, fold = adhesive_line.advance(self.pieces, self.piece, goal)
            if not fold:
                self._settle(piece, goal)
                return
            level = self.pieces.load[piece + 1]
            self.piece, self.place = piece, self.pieces.stop[piece]
            self._jump("jump", self._state(level), outwards=piece + 1, goal=level)
            fold = not self._at_edge

    def _shrink(self, goal: float) -> None:
        fold = self._load() > goal
        while fold:
            node, fold = adhesive_line.retreat(self.pieces, self.piece, goal)
            if not fold:
                self._settle(node, goal)
                return
            level = self.pieces.load[node]
            self.piece = node
            if not self._at_edge:
                self.place = self.pieces.begin[node]
            before = self._state(level)
            self._settle(adhesive_line.last_stable(self.pieces, node, level), level)
            self._note("jump" if self.piece >= 0 else "pull_off", before, level)
            fold = self.piece >= 0

    def _jump(self, kind: str, before: State, outwards: int, goal: float) -> None:
        """Move to the next stable radius beyond a node at the load `goal`."""
        self._settle(adhesive_line.next_stable(self.pieces, outwards, goal), goal)
        self._note(kind, before, goal)

    def _settle(self, piece: int, goal: float) -> None:
        """Set the edge where the characteristic of this piece is the goal."""
        if piece == self.pieces.cell.size and not self.sharp:
            raise _LineEndsError
        self.piece, self.place = piece, 1.0
        if 0 <= piece < self.pieces.cell.size:
            line = self.half, self.body.stretch, self.body.control, self.pieces
            self.place = adhesive_line.place_on(*line, piece, goal)

    @property
    def _at_edge(self) -> bool:
        return self.piece == self.pieces.cell.size

    def _load(self) -> float:
        """Return the characteristic load of the current contact."""
        if self._at_edge:
            return self.pieces.load[-1]
        cell = self.pieces.cell[self.piece]
        line = self.half, self.body.stretch, self.body.control
        return adhesive_line.characteristic(*line, cell, self.place)[0]

    def _state(self, goal: float) -> State:
        """Return the state of the current contact at the characteristic load `goal`."""
        goal = float(goal)
        if self.piece < 0:
            return State(goal if self.body.control == PENETRATION else 0.0, 0.0, 0.0, 0.0)
        if self._at_edge:
            a, first, second = (
                part[-1] for part in (self.half.x, self.half.first, self.half.second)
            )
        else:
            cell = self.pieces.cell[self.piece]
            a, _, first, second, _ = adhesive_line.evaluate(self.half, cell, self.place)
        if self.body.control == PENETRATION:
            d, reduced = goal, a * goal - first
        else:
            d, reduced = float((goal + first) / a) if a > 0 else 0.0, goal
        energy = a * d * d - 2 * d * first + second
        return State(
            d,
            float(2 * self.body.modulus * reduced),
            float(a),
            float(self.body.modulus * energy),
        )

    def _note(self, kind: str, before: State, level: float) -> None:
        """Record the jump from `before` to the current contact."""
        after = self._state(level)
        if kind == "pull_off" and self.body.control == FORCE:
            after = State(self._parting_depth(before.contact_radius), 0.0, 0.0, 0.0)
        lost = self._free_energy(before) - self._free_energy(after)
        if self.body.control == FORCE:
            lost -= before.force * (before.penetration - after.penetration)
        self.dissipated += lost
        self.events.append(Event(kind, len(self.record), before, after, lost))

    def _free_energy(self, state: State) -> float:
        area = state.contact_radius**2
        return state.elastic_energy - self.body.modulus * self.body.surface * area

    def _parting_depth(self, radius: float) -> float:
        """Return the smallest penetration at which a contact of at most this radius is stable."""
        pieces = adhesive_line.cut(self.half, self.body.stretch, PENETRATION)
        return float(pieces.load[pieces.radius <= radius].min())


def _largest_radius(body: Body, top: float) -> float:
    """Return the contact radius at the largest load of the path, for the spacing of the springs.

    The smallest a with g(a) = d + l(a), or the same for the force: the iteration a -> g^-1(d +
    l(a)) increases to it from any smaller radius. Close to a fold it is slow and ends early.
    """
    radius = body.profile.length * 2.0**-20
    top = max(top, 0.0)
    for _ in range(_ROUNDS):
        edge = np.sqrt(body.stretch * radius)
        if body.control == PENETRATION:
            grown = float(body.profile.contact_radius(top + edge))
        else:
            reduced = top / body.modulus + 2 * radius * edge
            grown = continuum_radius(body.profile, reduced)
        settled = abs(grown - radius) <= _SETTLED * grown
        radius = grown
        if radius < _NOTHING * body.profile.length:
            raise ValueError(
                "the tip is sharper than the root of r: adhesion does not hold it, and the contact "
                "has no size at zero load"
            )
        if settled:
            break
    return radius
