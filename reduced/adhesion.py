"""Adhesive contact on springs: the edge-stretch rule along a path of loads, with its jumps.

The outermost springs adhere up to the stretch l(a) = sqrt(2 pi a w/E*) (Hess 2011; Popov & Hess
2015, ch. 4): with the exact equivalent profile this is the theory of Johnson, Kendall & Roberts
(1971) for every axisymmetric body with a compact contact, and for the flat punch Kendall's (1971).
The rule describes short-range adhesion; nothing acts across a gap.

With t = 2 pi w/E* and G(a) = int_0^a g dx the contact is in equilibrium at

    d = g(a) - l(a)             (penetration control),
    F/(2 E*) = a d - G(a)       (force control),

and grows if the given load is above this *characteristic load* of its radius, shrinks if it is
below: for both controls the derivative of the free energy, E* (d - g)^2 - 2 pi w a, has that sign.
Folds of the characteristic are where a g'(a)^2 = t/4 and 9 t/4. On cubics the folds and the extrema
of a g'^2 between them are computed to rounding, which divides the half line into pieces with
monotone characteristic; no event between springs is missed.
"""

from __future__ import annotations

from dataclasses import astuple, dataclass, replace
from typing import NamedTuple

import numpy as np
from numba import njit

from reduced.errors import ConvergenceError, choice_faults, positive_faults, refuse
from reduced.loads import LoadPath
from reduced.springs.indent import continuum_radius
from reduced.springs.line import SmoothLine, Springs, part_moments, rise_and_slope

PENETRATION, FORCE = 0, 1
FOLD_LEVEL = (0.25, 2.25)
"""a g'(a)^2/t where the characteristic load turns, by control."""

_STEPS = 100
_EPSILON = float(np.finfo(float).eps)


class Pieces(NamedTuple):
    """Pieces of a half line with monotone characteristic load, from the axis outwards.

    `cell`, `begin`, `stop` (n,): the cubic of every piece, and its ends on the cubic in [0, 1];
    `radius`, `load` (n + 1,): contact radius and characteristic load at the ends.
    """

    cell: np.ndarray
    begin: np.ndarray
    stop: np.ndarray
    radius: np.ndarray
    load: np.ndarray


@njit(cache=True)
def evaluate(half, cell, s):
    """Return a, g, int_0^a g dx, int_0^a g^2 dx and g' at position s in a cell."""
    width = half.x[cell + 1] - half.x[cell]
    base, height = half.heights[cell], half.heights[cell + 1] - half.heights[cell]
    value, slope = rise_and_slope(half.start[cell], half.end[cell], s)
    area, squares = part_moments(base, height, width, half.start[cell], half.end[cell], s)
    g = base + height * value
    first, second = half.first[cell] + area, half.second[cell] + squares
    return half.x[cell] + s * width, g, first, second, slope * height / width


@njit(cache=True)
def characteristic(half, stretch, control, cell, s):
    """Return d or F/(2 E*) at which the contact ends at s, and its derivative in a.

    On the axis, where l(a) begins as a square root, the infinite derivative is replaced by zero.
    """
    a, g, first, _, slope = evaluate(half, cell, s)
    edge = np.sqrt(stretch * a)
    rate = edge / (2.0 * a) if a > 0.0 else 0.0
    if control == PENETRATION:
        return g - edge, slope - rate
    return a * (g - edge) - first, a * (slope - 3.0 * rate)


@njit(cache=True)
def cut(half, stretch, control):
    """Return the half line divided into `Pieces` at the extrema of the characteristic load."""
    cells = half.x.size - 1
    level = FOLD_LEVEL[control] * stretch
    cell, begin, stop = [0], [0.0], [0.0]  # typed lists for numba: first entry dropped below
    for i in range(cells):
        # between the extrema of a g'^2, ordered roots of 2 a g'' + g' = 0, it is monotone
        m0, m1 = half.start[i], half.end[i]
        c2, c3 = 3.0 - 2.0 * m0 - m1, m0 + m1 - 2.0
        away = half.x[i] / (half.x[i + 1] - half.x[i])
        a, b, c = 15.0 * c3, 6.0 * c2 + 12.0 * c3 * away, 4.0 * c2 * away + m0
        first = second = 2.0
        square = b * b - 4.0 * a * c
        if square >= 0.0:
            q = -0.5 * (b + np.sqrt(square)) if b >= 0.0 else -0.5 * (b - np.sqrt(square))
            if a != 0.0:
                first = q / a
            if q != 0.0:
                second = c / q
        marks = [0.0]
        for place in (min(first, second), max(first, second)):
            if marks[-1] < place < 1.0:
                marks.append(place)
        marks.append(1.0)
        last = 0.0
        for j in range(len(marks) - 1):
            low, high = marks[j], marks[j + 1]
            a, _, _, _, slope = evaluate(half, i, high)
            rising = a * slope**2 > level
            a, _, _, _, slope = evaluate(half, i, low)
            if (a * slope**2 > level) == rising:
                continue
            for _ in range(_STEPS):  # bisection for the fold
                place = 0.5 * (low + high)
                if place in (low, high):
                    break
                a, _, _, _, slope = evaluate(half, i, place)
                if (a * slope**2 > level) == rising:
                    high = place
                else:
                    low = place
            place = 0.5 * (low + high)
            if last < place < 1.0:
                cell.append(i)
                begin.append(last)
                stop.append(place)
                last = place
        cell.append(i)
        begin.append(last)
        stop.append(1.0)
    radius, load = np.zeros(len(cell)), np.zeros(len(cell))
    for k in range(1, len(cell)):
        radius[k] = evaluate(half, cell[k], stop[k])[0]
        load[k] = characteristic(half, stretch, control, cell[k], stop[k])[0]
    load[0] = characteristic(half, stretch, control, 0, 0.0)[0]
    return Pieces(np.array(cell)[1:], np.array(begin)[1:], np.array(stop)[1:], radius, load)


@njit(cache=True)
def place_on(half, stretch, control, pieces, k, load):
    """Return the position on piece k with characteristic `load`, by bracketed Newton steps."""
    cell, low, high = pieces.cell[k], pieces.begin[k], pieces.stop[k]
    width = half.x[cell + 1] - half.x[cell]
    rising = pieces.load[k + 1] > pieces.load[k]
    s = 0.5 * (low + high)
    for _ in range(_STEPS):
        value, slope = characteristic(half, stretch, control, cell, s)
        if (value < load) == rising:
            low = s
        else:
            high = s
        last = s
        s = s - (value - load) / (slope * width) if slope != 0.0 else -1.0
        if not low <= s <= high:
            s = 0.5 * (low + high)
        if abs(s - last) <= _EPSILON * s:
            break
    return s


_CONTROLS = {"penetration": PENETRATION, "force": FORCE}
_NOTHING = 2.0**-100  # fraction of the profile's length, which is arbitrary for a cone


@dataclass(frozen=True)
class State:
    """A state of the contact: d, F, a and the elastic energy; a = 0 without contact."""

    penetration: float
    force: float
    contact_radius: float
    elastic_energy: float


@dataclass(frozen=True)
class Event:
    """A jump of the contact, at or between loads of the path: "snap_in", "pull_off" or "jump".

    `step` is the index of the load towards which it happened. `dissipated` is the free energy lost:
    U - pi w a^2 at given penetration, U - pi w a^2 - F d at given force. After a pull-off under
    force control the state is that of separation, at the pull-off depth of penetration control.
    """

    kind: str
    step: int
    before: State
    after: State
    dissipated: float


@dataclass(frozen=True)
class Adhesion:
    """An adhesive contact along a path; arrays have shape (k,).

    F < 0 pulls; `dissipated` is lost in all jumps so far. Force and penetration are NaN under a
    prescribed pull out of contact, where no equilibrium exists.
    """

    penetration: np.ndarray
    force: np.ndarray
    contact_radius: np.ndarray
    elastic_energy: np.ndarray
    dissipated: np.ndarray
    events: tuple[Event, ...]
    spacing: float


def adhere(springs: Springs, work: float, path: LoadPath) -> Adhesion:
    """Solve an adhesive contact along a path of penetrations or forces, starting out of contact.

    The contact jumps where its equilibrium ends: at the extrema of d(a) under penetration control,
    of F(a) under force control. First touch is at d = 0, F = 0. The error of events is that of the
    cubics between springs: zero for parabola, cone, cubic and flat punch, dx^4 for other smooth
    profiles. The work of adhesion w is an energy per area; `per_radius` refers to the largest
    contact of the path; edges are "sub_cell".

    >>> from reduced.profiles.equivalents import paraboloid
    >>> ball = adhere(Springs(paraboloid(1.0), 1.0), 0.1, LoadPath("force", [0.0, -1.0]))
    >>> [event.kind for event in ball.events]
    ['snap_in', 'pull_off']
    >>> round(ball.events[-1].before.force / (np.pi * 0.1), 12)  # Johnson, Kendall & Roberts 1971
    -1.5
    """
    way = _follow(springs, work, path.control, path.values)
    states, dissipated = (np.array(part) for part in zip(*way.record, strict=True))
    penetration, force, radius, energy = states.T
    return Adhesion(
        *(penetration, force, radius, energy, dissipated), tuple(way.events), way.spacing
    )


def pull_off(springs: Springs, work: float, control: str = "force") -> Event:
    """Return the pull-off event of a body placed on the surface at zero load.

    >>> from reduced.profiles.equivalents import cylinder
    >>> event = pull_off(Springs(cylinder(2.0), 1.0), 0.1)
    >>> bool(abs(event.before.force + np.sqrt(8 * np.pi * 0.1 * 2.0**3)) < 1e-14)  # Kendall 1971
    True
    """
    return _follow(springs, work, control, np.array([0.0, -np.inf])).events[-1]


class _LineEndsError(Exception):
    """The contact grew beyond the existing springs."""


def _follow(springs: Springs, work: float, control: str, loads: np.ndarray) -> _Contact:
    """Lay enough springs for the contact and follow it along the loads."""
    wrong = positive_faults(work=work) + choice_faults("control", control, tuple(_CONTROLS))
    if springs.edges != "sub_cell":
        wrong.append(f"edges must be 'sub_cell' for adhesive springs, got {springs.edges!r}")
    refuse(wrong)
    # The largest radius, for the spacing: the smallest a with g(a) = d + l(a), or the same for the
    # force. a -> g^-1(d + l(a)) increases to it from any smaller radius; close to a fold it is slow
    # and ends early.
    profile, modulus = springs.profile, springs.effective_modulus
    stretch = 2 * (np.pi * work / modulus)  # l(a)^2/a
    reach, top = profile.length * 2.0**-20, max(float(loads.max()), 0.0)
    for _ in range(200):
        edge = np.sqrt(stretch * reach)
        if control == "penetration":
            grown = float(profile.contact_radius(top + edge))
        else:
            grown = continuum_radius(profile, top / modulus + 2 * reach * edge)
        settled = abs(grown - reach) <= 1e-3 * grown
        reach = grown
        if reach < _NOTHING * profile.length:
            raise ValueError(
                "the tip is sharper than the root of r: adhesion does not hold it, and the contact "
                "has no size at zero load"
            )
        if settled:
            break
    spacing = reach / springs.per_radius if springs.spacing is None else springs.spacing
    for _ in range(60):
        way = _Contact(springs, spacing, reach, work, _CONTROLS[control])
        try:
            for load in loads:
                way.to(float(load))
        except _LineEndsError:
            # close to a fold the estimate of the largest radius is a lower bound only
            reach *= 1.25
        else:
            return way
    raise ConvergenceError("the contact grows without limit: the profile is too flat", [reach])


class _Contact:
    """The contact along its path: springs, current edge, and past events."""

    def __init__(
        self, springs: Springs, spacing: float, reach: float, work: float, control: int
    ) -> None:
        self.modulus, self.control, self.spacing = springs.effective_modulus, control, spacing
        self.surface = np.pi * work / self.modulus  # times a^2: the surface energy over E*
        # Beyond the tip and every breakpoint b the profile may rise as a fractional power of x - b,
        # which cubics approximate poorly near folds: knots at b + 4 dx/2^(k/2) are added there
        profile = springs.profile
        steps = 4 * spacing * 0.5 ** (np.arange(40) / 2)
        marks = np.array([0.0, *(b for b in profile.breakpoints if b < reach)])
        graded = np.concatenate([marks[1:], (marks[:, None] + steps).ravel()])
        graded = graded[graded < min(profile.edge, reach + spacing)]
        dense = replace(profile, breakpoints=tuple(map(float, graded)))
        # one half of the line; the other one is its mirror image
        self.half = SmoothLine(dense, spacing, springs.offset, reach).halves[0]
        self.law = (self.half, 2 * self.surface, control)
        self.pieces = cut(*self.law)
        self.sharp = bool(self.half.x[-1] == springs.profile.edge)
        self.piece, self.place = -1, 0.0  # piece -1: no contact; number of pieces: sharp edge
        self.events: list[Event] = []
        self.dissipated = 0.0
        self.record: list[tuple[tuple[float, ...], float]] = []

    def to(self, load: float) -> None:
        """Move to the next load and record the state."""
        # the characteristic is d for penetration, F/(2 E*) for force
        goal = load if self.control == PENETRATION else load / (2 * self.modulus)
        if self.piece < 0 and goal >= 0:
            # start at the axis; if contact spreads at zero load, that is a jump
            self.piece, self.place = 0, 0.0
            if self.pieces.load[1] < self.pieces.load[0]:
                self._spread("snap_in", State(0.0, 0.0, 0.0, 0.0), 0, 0.0)
        # a contact that is too large shrinks from fold to fold, down to the load
        loads = self.pieces.load
        fold = self.piece >= 0 and self._load() > goal
        while fold:
            begins = loads[: self.piece + 1]
            folds = np.append(-np.inf, begins[:-1]) > begins
            stops = np.flatnonzero((begins <= goal) | folds)
            node = int(stops[-1]) if stops.size else -1
            if node < 0 or loads[node] <= goal:
                self._settle(node, goal)
                break
            level = loads[node]
            self.piece = node
            if not self._at_edge:
                self.place = self.pieces.begin[node]
            before = self._state(level)
            below = np.flatnonzero(loads[:node] <= level)
            self._settle(int(below[-1]) if below.size else -1, level)
            self._note("jump" if self.piece >= 0 else "pull_off", before, level)
            fold = self.piece >= 0
        # one that is too small grows, likewise
        fold = self.piece >= 0 and not self._at_edge and self._load() < goal
        while fold:
            ends, beyond = loads[self.piece + 1 :], np.append(loads[self.piece + 2 :], np.inf)
            folds = (ends > loads[self.piece : -1]) & (ends > beyond)
            stops = np.flatnonzero((ends >= goal) | folds)
            piece = self.piece + int(stops[0]) if stops.size else self.pieces.cell.size
            if not stops.size or loads[piece + 1] >= goal:
                self._settle(piece, goal)
                break
            level = loads[piece + 1]
            self.piece, self.place = piece, self.pieces.stop[piece]
            self._spread("jump", self._state(level), piece + 1, level)
            fold = not self._at_edge
        self.record.append((astuple(self._state(goal)), self.dissipated))

    def _spread(self, kind: str, before: State, node: int, goal: float) -> None:
        """Jump to the next stable radius beyond a node at the load `goal`."""
        above = np.flatnonzero(self.pieces.load[node + 1 :] >= goal)
        self._settle(node + int(above[0]) if above.size else self.pieces.cell.size, goal)
        self._note(kind, before, goal)

    def _settle(self, piece: int, goal: float) -> None:
        """Set the edge where the characteristic of this piece is the goal."""
        if piece == self.pieces.cell.size and not self.sharp:
            raise _LineEndsError
        self.piece, self.place = piece, 1.0
        if 0 <= piece < self.pieces.cell.size:
            self.place = place_on(*self.law, self.pieces, piece, goal)

    @property
    def _at_edge(self) -> bool:
        return self.piece == self.pieces.cell.size

    def _load(self) -> float:
        """Return the characteristic load of the current contact."""
        if self._at_edge:
            return self.pieces.load[-1]
        return characteristic(*self.law, self.pieces.cell[self.piece], self.place)[0]

    def _state(self, goal: float) -> State:
        """Return the state of the current contact at the characteristic load `goal`."""
        goal = float(goal)
        if self.piece < 0:
            # apart, a body stays at any depth, but under no pull
            d, force = (goal, 0.0) if self.control == PENETRATION else (np.nan, np.nan)
            return State(d, force, 0.0, 0.0)
        if self._at_edge:
            half = self.half
            a, first, second = half.x[-1], half.first[-1], half.second[-1]
        else:
            cell = self.pieces.cell[self.piece]
            a, _, first, second, _ = evaluate(self.half, cell, self.place)
        if self.control == PENETRATION:
            d, reduced = goal, a * goal - first
        else:
            d, reduced = float((goal + first) / a) if a > 0 else 0.0, goal
        energy = a * d * d - 2 * d * first + second
        return State(
            *(d, float(2 * self.modulus * reduced), float(a), float(self.modulus * energy))
        )

    def _note(self, kind: str, before: State, level: float) -> None:
        """Record the jump from `before` to the current contact."""
        after = self._state(level)
        if kind == "pull_off" and self.control == FORCE:
            # the smallest penetration at which a contact of at most this radius is stable
            pieces = cut(self.half, 2 * self.surface, PENETRATION)
            parting = pieces.load[pieces.radius <= before.contact_radius].min()
            after = State(float(parting), 0.0, 0.0, 0.0)
        free = [
            state.elastic_energy - self.modulus * self.surface * state.contact_radius**2
            for state in (before, after)
        ]
        lost = free[0] - free[1]
        if self.control == FORCE:
            lost -= before.force * (before.penetration - after.penetration)
        self.dissipated += lost
        self.events.append(Event(kind, len(self.record), before, after, lost))
