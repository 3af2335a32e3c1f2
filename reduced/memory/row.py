"""A row of unilateral viscoelastic springs under an equivalent profile, in steps of time.

Every spring holds, lets go, recovers, catches. In contact (deflection d - g, force f >= 0) it
follows the body, and its arms have stresses s_j. Free (f = 0, below the body) its deflection u is a
sum of modes w_k that decay with the retardation times lambda_k, plus the permanent part of a fluid.
Both describe the same state (partial fractions of G and J):

    w_k = J_k [G_inf u + sum_j s_j tau_j/(tau_j - lambda_k)],
    s_j = sum_k w_k G_j tau_j/(tau_j - lambda_k)      at f = 0.

In a step the depth d is linear in time, so each is a sum of exponentials; a spring loses contact at
the root of f and returns at the root of its gap, both inside the step. A loss and a return within
one step are not seen.

Springs stand at x = 0, dx, 2 dx, ..., at the breakpoints of the profile and at its sharp edge; the
line is symmetric and only its right half is kept. Between neighbours the force per length is linear
in the height g, as for elastic springs: the force of the line is then exact for elastic springs
under a paraboloid or a cone at any spacing, and has an error of dx^2 for others.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit

from reduced.errors import poisson_faults, positive_faults, refuse
from reduced.memory.materials import Prony, contact_modulus
from reduced.profiles.section import Profile
from reduced.springs.line import row_faults


class SpringLaw(NamedTuple):
    """Material of a spring per unit spacing; times may be in any unit, lengths v t included."""

    long_term: float
    moduli: np.ndarray
    times: np.ndarray
    viscosity: float
    compliances: np.ndarray
    retardations: np.ndarray
    spread: np.ndarray  # tau_j/(tau_j - lambda_k), shape (arms, modes)


def law_of(material: Prony, speed: float = 1.0) -> SpringLaw:
    """Return the law of springs of a material; with a speed, times become lengths v t."""
    creep = material.creep()
    apart = material.times[:, None] - creep.times
    spread = np.divide(material.times[:, None], apart, out=np.zeros(apart.shape), where=apart != 0)
    return SpringLaw(
        float(material.long_term),
        material.moduli,
        speed * material.times,
        float(speed * material.viscosity),
        np.asarray(creep.compliances),
        speed * np.asarray(creep.times),
        spread,
    )


@njit(cache=True)
def held_stress(stress, modulus, ratio, change):
    """Return the stress of an arm after a linear strain `change` over `ratio` = time/tau."""
    gain = -np.expm1(-ratio) / ratio if ratio > 0 else 1.0
    return stress * np.exp(-ratio) + modulus * gain * change


@njit(cache=True)
def hold(law, arms, change, duration):
    """Advance the arms of a spring in contact through a linear change of its deflection."""
    for j in range(arms.size):
        arms[j] = held_stress(arms[j], law.moduli[j], duration / law.times[j], change)


@njit(cache=True)
def let_go(law, deflection, arms, modes):
    """Turn the arms of a released spring into modes; return the permanent deflection."""
    permanent = deflection
    for k in range(modes.size):
        total = law.long_term * deflection
        for j in range(arms.size):
            total += arms[j] * law.spread[j, k]
        modes[k] = law.compliances[k] * total
        permanent -= modes[k]
    arms[:] = 0.0
    return permanent if law.long_term == 0 else 0.0


@njit(cache=True)
def recover(law, modes, duration):
    """Advance the modes of a free spring."""
    for k in range(modes.size):
        modes[k] *= np.exp(-duration / law.retardations[k])


@njit(cache=True)
def catch(law, arms, modes):
    """Turn the modes of a free spring into the arms of one that makes contact."""
    for j in range(arms.size):
        total = 0.0
        for k in range(modes.size):
            total += modes[k] * law.spread[j, k]
        arms[j] = law.moduli[j] * total
    modes[:] = 0.0


# Share of the heights below which a gap or a deflection is rounding: a spring that the body just
# reaches is in contact and stays so at rest, in all units of length; in nodal sums it is left out.
_TIE = 1e-12
_LEAST, _MOST = 0.25, 0.75  # relative middle heights of cells for which the parabola is monotone


class Row(NamedTuple):
    """State of all springs, and of the cells between neighbours.

    `edge` is the position of the contact edge in a cell, as a fraction of the cell's height
    difference from the spring in contact; `fall` is the decrease of the force per length over the
    whole cell when the edge last advanced.
    """

    touching: np.ndarray
    deflection: np.ndarray
    arms: np.ndarray
    modes: np.ndarray
    permanent: np.ndarray
    force: np.ndarray
    edge: np.ndarray
    fall: np.ndarray


class Step(NamedTuple):
    """Linear motion of the body in one step; `wet` is the force per length of a dashpot."""

    start: float
    change: float
    duration: float
    wet: float


def _fresh_row(n: int, law: SpringLaw) -> Row:
    arms, modes = np.zeros((n, law.times.size)), np.zeros((n, law.retardations.size))
    deflection, permanent, force = np.zeros((3, n))
    edge, fall = np.zeros((2, n - 1))
    return Row(np.zeros(n, np.bool_), deflection, arms, modes, permanent, force, edge, fall)


@njit(cache=True)
def _advance(law, heights, old, new, start, end, duration, nodal):
    """Advance a row by one step with a linear change of depth; a jump takes no time.

    `heights` (n,) is the profile g at the springs, `old` the state before, which is not changed.
    """
    count = heights.size
    wet = law.viscosity * ((end - start) / duration) if duration > 0 else 0.0
    step = Step(start, end - start, duration, wet)
    decay, rise = np.empty(law.times.size), np.empty(law.times.size)
    glassy = law.long_term
    for j in range(law.times.size):
        ratio = duration / law.times[j]
        decay[j] = np.exp(-ratio)
        rise[j] = held_stress(0.0, law.moduli[j], ratio, step.change)
        glassy += law.moduli[j]
    fade = np.exp(-duration / law.retardations)
    events, left = np.full(count, -1.0), np.zeros(count)
    for i in range(count):
        # most springs hold, or recover, through the whole step: written out, as a call costs more
        tie = _TIE * (abs(heights[i]) + abs(end))
        pull = 4 * tie * glassy
        if nodal:
            tie, pull = -tie, 0.0
        new.touching[i], new.permanent[i] = old.touching[i], old.permanent[i]
        if old.touching[i]:
            force, reached = law.long_term * (end - heights[i]) + wet, end - heights[i]
            for j in range(decay.size):
                new.arms[i, j] = old.arms[i, j] * decay[j] + rise[j]
                force += new.arms[i, j]
            new.modes[i, :] = 0.0
            new.force[i] = max(force, 0.0)
            eventful = force < -pull
        else:
            reached = old.permanent[i]
            for k in range(fade.size):
                new.modes[i, k] = old.modes[i, k] * fade[k]
                reached += new.modes[i, k]
            new.arms[i, :] = 0.0
            new.force[i] = 0.0
            eventful = heights[i] + reached - end < tie
        new.deflection[i] = old.deflection[i] if eventful else reached
        if eventful:
            for j in range(decay.size):  # slices take longer to compile
                new.arms[i, j] = old.arms[i, j]
            for k in range(fade.size):
                new.modes[i, k] = old.modes[i, k]
            events[i], left[i] = _alternate(law, step, heights[i], new, i, tie, pull)
    for cell in range(count - 1):
        if new.touching[cell] == new.touching[cell + 1]:
            new.edge[cell] = new.fall[cell] = 0.0
        else:
            _place_edge(law, step, heights, old, new, events, left, cell)


@njit(cache=True)
def _held_force(law, step, deflection, arms, share):
    """Return the force per length of a spring in contact after a share of the step."""
    change = step.change * share
    force = law.long_term * (deflection + change) + step.wet
    for j in range(law.times.size):
        ratio = share * step.duration / law.times[j]
        force += held_stress(arms[j], law.moduli[j], ratio, change)
    return force


@njit(cache=True)
def _free_deflection(law, modes, permanent, duration):
    """Return the deflection of a spring that has been free for a time."""
    deflection = permanent
    for k in range(law.retardations.size):
        deflection += modes[k] * np.exp(-duration / law.retardations[k])
    return deflection


@njit(cache=True)
def _margin(law, step, height, row, i, begin, share):
    """Return the force of spring i, or its gap if free, a share of the step after `begin`."""
    if row.touching[i]:
        return _held_force(law, step, row.deflection[i], row.arms[i], share)
    free = _free_deflection(law, row.modes[i], row.permanent[i], share * step.duration)
    return height + free - (step.start + step.change * (begin + share))


@njit(cache=True)
def _alternate(law, step, height, row, i, tie, pull):
    """Advance spring i through loss and return of contact; return (last event, force at loss).

    The event is the fraction of the step at which contact was lost or made, or -1.
    """
    arms, modes = row.arms[i], row.modes[i]
    begin, event, left = 0.0, -1.0, 0.0
    for _ in range(8):
        first = _margin(law, step, height, row, i, begin, 0.0)
        last = _margin(law, step, height, row, i, begin, 1.0 - begin)
        if last >= (-pull if row.touching[i] else tie):
            break
        # the last fraction after `begin` with a force or gap >= 0, by bisection
        share, high = 0.0, 1.0 - begin
        if first > 0:
            for _ in range(80):
                middle = 0.5 * (share + high)
                if not share < middle < high:
                    break
                if _margin(law, step, height, row, i, begin, middle) >= 0:
                    share = middle
                else:
                    high = middle
        begin = event = begin + share
        deflection = step.start + step.change * begin - height
        if row.touching[i]:
            left = min(first, 0.0)
            hold(law, arms, step.change * share, share * step.duration)
            row.permanent[i] = let_go(law, deflection, arms, modes)
        else:
            recover(law, modes, share * step.duration)
            catch(law, arms, modes)
            row.permanent[i] = 0.0
        row.touching[i], row.deflection[i] = not row.touching[i], deflection
    share = 1.0 - begin
    row.force[i] = 0.0
    if row.touching[i]:
        row.force[i] = max(_held_force(law, step, row.deflection[i], arms, share), 0.0)
        hold(law, arms, step.change * share, share * step.duration)
        row.deflection[i] = step.start + step.change - height
    else:
        recover(law, modes, share * step.duration)
        row.deflection[i] = _free_deflection(law, modes, row.permanent[i], 0.0)
    return event, left


@njit(cache=True)
def _place_edge(law, step, heights, old, new, events, left, cell):
    """Place the contact edge between a spring in contact and a free one; store edge and fall.

    `events` are the last events of the springs, `left` their forces at loss of contact. While the
    cell closes, the gap is linear in height from the edge to the free spring; while it opens, the
    force decreases to zero with the slope at the last advance of the edge: exact for the first
    loading of elastic springs, otherwise to the square of the spacing.
    """
    pressed = cell if new.touching[cell] else cell + 1
    free = 2 * cell + 1 - pressed
    end, height = step.start + step.change, heights[free]
    gap, force = height + new.deflection[free] - end, new.force[pressed]
    fall, edge = old.fall[cell], old.edge[cell]
    if events[free] >= 0 and events[free] > events[pressed]:
        # the edge has passed the free spring and is inside the cell
        fall = force
        if events[pressed] < 0:
            fall = _held_force(law, step, old.deflection[pressed], old.arms[pressed], events[free])
            fall -= left[free]
        edge = min(1.0, force / fall) if fall > 0 else 0.0
    else:
        before, since = gap, max(events[pressed], 0.0)
        if events[pressed] < 0 or events[free] < 0:
            place = _free_deflection(
                law, old.modes[free], old.permanent[free], since * step.duration
            )
            before = height + place - (step.start + step.change * since)
        if events[pressed] >= 0:
            edge = 0.0
        if gap <= before + _TIE * (abs(height) + abs(end)):
            edge = 1.0 - (1.0 - edge) * min(gap / before, 1.0) if before > 0 else edge
            fall = (force - max(step.wet, 0.0)) / edge if edge > 0 else 0.0
        elif fall > 0:
            edge = max(0.0, min(edge, force / fall))
    new.edge[cell], new.fall[cell] = edge, fall


@njit(cache=True)
def _along(middle, level):
    """Return the fraction of a cell's width at which its height has risen by the fraction `level`.

    Within a cell the height is the parabola through both ends and the middle, if it is monotone,
    else a power of the distance from the flatter end (exact at the tip of c x^n).
    """
    if level <= 0 or level >= 1:
        return min(max(level, 0.0), 1.0)
    if middle < _LEAST:
        return level ** (-1 / np.log2(middle)) if middle > 0 else 1.0
    if middle > _MOST:
        return 1 - (1 - level) ** (-1 / np.log2(1 - middle)) if middle < 1 else 0.0
    slope, bend = 4 * middle - 1, 2 - 4 * middle
    return 2 * level / (slope + np.sqrt(slope * slope + 4 * bend * level))


@njit(cache=True)
def _risen(middle, share):
    """Return integrals of relative height and its square over a part of a cell, see `_along`."""
    if middle <= 0:
        return 0.0, 0.0
    if middle >= 1:
        return share, share
    if middle < _LEAST:
        power = -np.log2(middle)
        return share ** (power + 1) / (power + 1), share ** (2 * power + 1) / (2 * power + 1)
    if middle > _MOST:
        power = -np.log2(1 - middle)
        once = (1 - (1 - share) ** (power + 1)) / (power + 1)
        twice = (1 - (1 - share) ** (2 * power + 1)) / (2 * power + 1)
        return share - once, share - 2 * once + twice
    slope, bend = 4 * middle - 1, 2 - 4 * middle
    first = share * share * (slope / 2 + bend * share / 3)
    second = slope * slope / 3 + share * slope * bend / 2 + share * share * bend * bend / 5
    return first, share**3 * second


@njit(cache=True)
def _bend(heights, force, i, j, k):
    """Return the second divided difference of the force over the height; 0 for equal heights."""
    low, high = heights[j] - heights[i], heights[k] - heights[j]
    if low == 0 or high == 0:
        return 0.0
    steeper = (force[k] - force[j]) / high - (force[j] - force[i]) / low
    return steeper / (heights[k] - heights[i])


@njit(cache=True)
def _sub_cell(places, heights, middles, row, rim):
    """Return force, contact length and outermost contact edge of the right half."""
    touching, force = row.touching, row.force
    total, length, radius = 0.0, 0.0, 0.0
    for i in range(places.size - 1):
        if not (touching[i] or touching[i + 1]):
            continue
        width, middle = places[i + 1] - places[i], middles[i]
        if touching[i] and touching[i + 1]:
            # the linear value less the curvature from the neighbours (mean of both sides)
            once, twice = _risen(middle, 1.0)
            before = i > 0 and touching[i - 1]
            after = i + 2 < heights.size and touching[i + 2]
            bend, share = 0.0, 1.0
            if before:
                bend += _bend(heights, force, i - 1, i, i + 1)
            if after:
                bend += _bend(heights, force, i, i + 1, i + 2)
            if before and after:
                bend /= 2
            rise = heights[i + 1] - heights[i]
            mean = force[i] * (1 - once) + force[i + 1] * once - bend * rise * rise * (once - twice)
        else:
            # linear in the height to the edge
            inward, edge = touching[i], row.edge[i]
            pressed_force = force[i] if inward else force[i + 1]
            share = _along(middle, edge if inward else 1 - edge)
            once = _risen(middle, share)[0]
            if not inward:
                share, once = 1 - share, (1 - share) - (_risen(middle, 1.0)[0] - once)
            ramp = once / edge if edge > 0 else 0.0
            mean = pressed_force * share + (rim - pressed_force) * ramp
        total += width * mean
        length += width * share
        radius = places[i + 1] if touching[i + 1] else places[i] + width * share
    return total, length, radius


@dataclass(frozen=True)
class RelaxingSprings:
    """Viscoelastic springs E*(t) dx (19.30) under an equivalent profile.

    `material` is the shear modulus in time, Poisson's ratio is constant (1/2 for rubber). There are
    `per_radius` springs per contact radius at the largest depth, or one per `spacing`; contacts end
    inside cells (``"sub_cell"``), or are whole springs at (i + 1/2) dx as printed (``"nodal"``).
    """

    profile: Profile
    material: Prony
    poisson_ratio: float = 0.5
    per_radius: int = 40
    spacing: float | None = None
    edges: str = "sub_cell"

    def __post_init__(self) -> None:
        wrong = poisson_faults(self.poisson_ratio)
        refuse(wrong + row_faults(self.per_radius, self.spacing, self.edges))

    @property
    def modulus(self) -> Prony:
        """The contact modulus E*(t)."""
        return contact_modulus(self.material, self.poisson_ratio)


class SpringRow:
    """Springs with their history, laid for a largest depth; at larger ones springs are added."""

    def __init__(self, springs: RelaxingSprings, depth: float) -> None:
        profile, spacing = springs.profile, springs.spacing
        if spacing is None:
            spacing = float(profile.contact_radius(max(depth, 0.0))) / springs.per_radius
            refuse(positive_faults(largest_contact_radius=spacing))
        self._profile, self._law, self._edges = profile, law_of(springs.modulus), springs.edges
        law, self.spacing = self._law, float(spacing)
        self.time, self.depth = 0.0, 0.0
        self._place(4 * spacing)
        self._row = _fresh_row(self._places.size, law)
        self._trial = _fresh_row(self._places.size, law)

    def trial(self, depth: float, duration: float) -> tuple[float, float, float]:
        """Return force, contact length and contact radius of a trial step to a depth.

        The velocity is constant; a duration of 0 is a jump. The state is not changed.
        """
        if depth >= self._heights[-1] and self._places[-1] < self._profile.edge:
            # add springs until the profile rises above the depth
            known = self._row
            reach = float(self._profile.contact_radius(depth)) + self.spacing
            self._place(2 * max(reach, self._places[-1]))
            self._row, self._trial = (_fresh_row(self._places.size, self._law) for _ in range(2))
            for new, old in zip(self._row, known, strict=True):
                new[: old.shape[0]] = old
        way = float(self.depth), float(depth), float(duration)
        _advance(self._law, self._heights, self._row, self._trial, *way, self._edges == "nodal")
        if self._edges == "nodal":
            touching = int(self._trial.touching.sum())
            radius = touching * self.spacing
            return 2 * self.spacing * float(self._trial.force.sum()), 2 * radius, radius
        speed = (depth - self.depth) / duration if duration > 0 else 0.0
        rim = self._law.viscosity * max(speed, 0.0)
        line = self._places, self._heights, self._middles
        total, length, radius = _sub_cell(*line, self._trial, rim)
        return 2 * total, 2 * length, radius

    def go(self, depth: float, duration: float) -> tuple[float, float, float]:
        """Take a step; return the same as `trial`."""
        answer = self.trial(depth, duration)
        self._row, self._trial = self._trial, self._row
        self.depth, self.time = depth, self.time + duration
        return answer

    def _place(self, reach: float) -> None:
        """Place springs from the axis to `reach` or the profile's edge; they remain fixed."""
        count = int(np.ceil(reach / self.spacing)) + 1
        nodal = self._edges == "nodal"
        places = self.spacing * (np.arange(count) + 0.5 * nodal)
        if not nodal:
            marks = np.array([*self._profile.breakpoints, self._profile.edge])
            places = np.union1d(places, marks[marks < places[-1]])
        places = places[places <= self._profile.edge]
        heights = np.asarray(self._profile.height(places), dtype=float)
        defined = np.isfinite(heights)
        self._places, self._heights = places[defined], heights[defined]
        rise = np.diff(self._heights)
        middle = self._profile.height((self._places[:-1] + self._places[1:]) / 2)
        steep = rise > 0
        share = (middle - self._heights[:-1]) / np.where(steep, rise, 1.0)
        self._middles = np.where(steep, share, 0.5)
