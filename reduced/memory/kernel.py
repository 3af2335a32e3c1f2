"""One step in time of a row of unilateral viscoelastic springs, exact for a linear depth.

Every spring is independently in contact (deflection d - g, force f >= 0) or free (f = 0, recovering
below the body). Within a step the depth d is linear in time, so a spring in contact is a sum of
exponentials of the relaxation times tau, a free one of the retardation times lambda; it loses
contact at the root of f and returns at the root of its gap, both inside the step. Events that are
not visible at the ends of a step (loss and return of contact within one step) are not detected.

State of a spring in contact: the arms' stresses s_j. Free: the modes w_k of its recovery and the
permanent deflection of a fluid. Both describe the same state (partial fractions of G and J):

    w_k = J_k [G_inf u + sum_j s_j tau_j/(tau_j - lambda_k)],
    s_j = sum_k w_k G_j tau_j/(tau_j - lambda_k)      at f = 0.

Times inside a step are fractions of it, 0 to 1.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from reduced.memory.materials import Prony

_ALTERNATIONS = 8
_HALVINGS = 80
# A change of a gap below this share of its heights is rounding: without it the spring at the rim of
# the largest contact, and an edge at rest, would move in some units of length and not in others.
_TIE = 1e-12


class SpringLaw(NamedTuple):
    """Material of the springs per unit spacing."""

    long_term: float
    moduli: np.ndarray
    times: np.ndarray
    viscosity: float
    fluid: bool
    compliances: np.ndarray
    retardations: np.ndarray
    spread: np.ndarray  # tau_j/(tau_j - lambda_k), shape (arms, modes)


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


class Spring(NamedTuple):
    """State of one spring between two events; `height` is the profile at the spring."""

    touching: bool
    height: float
    deflection: float
    arms: np.ndarray
    modes: np.ndarray
    permanent: float


class Step(NamedTuple):
    """Linear motion of the body in one step; a jump has zero duration.

    `decay`, `rise` of the arms and `fade` of the modes are for the whole step, which suffices for
    most springs.
    """

    start: float
    change: float
    duration: float
    decay: np.ndarray
    rise: np.ndarray
    fade: np.ndarray


def law_of(material: Prony) -> SpringLaw:
    """Return the law of springs of a material, with its creep."""
    creep = material.creep()
    apart = material.times[:, None] - creep.times
    spread = np.divide(material.times[:, None], apart, out=np.zeros(apart.shape), where=apart != 0)
    return SpringLaw(
        float(material.long_term),
        material.moduli,
        material.times,
        float(material.viscosity),
        material.long_term == 0,
        np.asarray(creep.compliances),
        np.asarray(creep.times),
        spread,
    )


def fresh_row(springs: int, law: SpringLaw) -> Row:
    """Return a row of springs without history."""
    return Row(
        np.zeros(springs, dtype=np.bool_),
        np.zeros(springs),
        np.zeros((springs, law.times.size)),
        np.zeros((springs, law.retardations.size)),
        np.zeros(springs),
        np.zeros(springs),
        np.zeros(springs - 1),
        np.zeros(springs - 1),
    )


@njit(cache=True)
def _held_arm(stress, modulus, ratio, change):
    """Return the stress of an arm after a linear strain `change` over `ratio` = time/tau."""
    gain = -np.expm1(-ratio) / ratio if ratio > 0 else 1.0
    return stress * np.exp(-ratio) + modulus * gain * change


@njit(cache=True)
def _held_force(law, step, deflection, arms, share):
    """Return the force per length of a spring in contact after a fraction of the step."""
    change = step.change * share
    force = law.long_term * (deflection + change)
    if step.duration > 0:
        force += law.viscosity * (step.change / step.duration)
    for j in range(law.times.size):
        ratio = share * step.duration / law.times[j]
        force += _held_arm(arms[j], law.moduli[j], ratio, change)
    return force


@njit(cache=True)
def _free_deflection(law, step, modes, permanent, share):
    """Return the deflection of a spring that has been free for a fraction of the step."""
    deflection = permanent
    for k in range(law.retardations.size):
        deflection += modes[k] * np.exp(-share * step.duration / law.retardations[k])
    return deflection


@njit(cache=True)
def _signed(law, step, spring, begin, share):
    """Return the force of a held spring or gap of a free one, `share` of the step after `begin`."""
    if spring.touching:
        return _held_force(law, step, spring.deflection, spring.arms, share)
    depth = step.start + step.change * (begin + share)
    return (
        spring.height + _free_deflection(law, step, spring.modes, spring.permanent, share) - depth
    )


@njit(cache=True)
def _hold(law, step, arms, share):
    """Advance the arms of a held spring by a fraction of the step."""
    for j in range(law.times.size):
        ratio = share * step.duration / law.times[j]
        arms[j] = _held_arm(arms[j], law.moduli[j], ratio, step.change * share)


@njit(cache=True)
def _let_go(law, deflection, arms, modes):
    """Convert the arms of a released spring to recovery modes; return the permanent deflection."""
    permanent = deflection
    for k in range(modes.size):
        total = law.long_term * deflection
        for j in range(arms.size):
            total += arms[j] * law.spread[j, k]
        modes[k] = law.compliances[k] * total
        permanent -= modes[k]
    arms[:] = 0.0
    return permanent if law.fluid else 0.0


@njit(cache=True)
def _recover(law, step, modes, share):
    """Advance the modes of a free spring by a fraction of the step."""
    for k in range(modes.size):
        modes[k] *= np.exp(-share * step.duration / law.retardations[k])


@njit(cache=True)
def _catch(law, arms, modes):
    """Convert modes of recovery to the arms of a spring that makes contact."""
    for j in range(arms.size):
        total = 0.0
        for k in range(modes.size):
            total += modes[k] * law.spread[j, k]
        arms[j] = law.moduli[j] * total
    modes[:] = 0.0


@njit(cache=True)
def _carry_quiet(law, step, heights, old, new):
    """Advance all springs without an event by one step; mark the others.

    A single loop, because a call with these tuples costs more than a spring.
    """
    end = step.start + step.change
    rim = law.viscosity * (step.change / step.duration) if step.duration > 0 else 0.0
    eventful = np.zeros(heights.size, dtype=np.bool_)
    for i in range(heights.size):
        new.touching[i], new.permanent[i] = old.touching[i], old.permanent[i]
        new.deflection[i] = old.deflection[i]
        if old.touching[i]:
            force = law.long_term * (end - heights[i]) + rim
            for j in range(step.decay.size):
                new.arms[i, j] = old.arms[i, j] * step.decay[j] + step.rise[j]
                force += new.arms[i, j]
            new.modes[i, :] = 0.0
            eventful[i] = force < 0
            new.force[i] = force
            free = end - heights[i]
        else:
            free = old.permanent[i]
            for k in range(step.fade.size):
                new.modes[i, k] = old.modes[i, k] * step.fade[k]
                free += new.modes[i, k]
            new.arms[i, :] = 0.0
            gap = heights[i] + free - end
            eventful[i] = gap < -_TIE * (abs(heights[i]) + abs(end))
            new.force[i] = 0.0
        if eventful[i]:
            for j in range(step.decay.size):  # slices take longer to compile
                new.arms[i, j] = old.arms[i, j]
            for k in range(step.fade.size):
                new.modes[i, k] = old.modes[i, k]
        else:
            new.deflection[i] = free
    return eventful


@njit(cache=True)
def _move_spring(law, step, height, row, i):
    """Advance spring i of a row by a step; return (last event, force at loss of contact).

    The event is the fraction of the step at which contact was lost or made, or -1.
    """
    arms, modes = row.arms[i], row.modes[i]
    touching, deflection, permanent = row.touching[i], row.deflection[i], row.permanent[i]
    begin, event, left = 0.0, -1.0, 0.0
    for _ in range(_ALTERNATIONS):
        spring = Spring(touching, height, deflection, arms, modes, permanent)
        first = _signed(law, step, spring, begin, 0.0)
        last = _signed(law, step, spring, begin, 1.0 - begin)
        if last >= 0:
            break
        share = 0.0
        if first > 0:
            # the last fraction after `begin` with force or gap >= 0, by bisection
            high = 1.0 - begin
            for _ in range(_HALVINGS):
                middle = 0.5 * (share + high)
                if not share < middle < high:
                    break
                if _signed(law, step, spring, begin, middle) >= 0:
                    share = middle
                else:
                    high = middle
        begin = event = begin + share
        if touching:
            left = min(first, 0.0)
            _hold(law, step, arms, share)
            deflection = step.start + step.change * begin - height
            permanent = _let_go(law, deflection, arms, modes)
        else:
            _recover(law, step, modes, share)
            deflection = step.start + step.change * begin - height
            _catch(law, arms, modes)
            permanent = 0.0
        touching = not touching
    if touching:
        row.force[i] = _held_force(law, step, deflection, arms, 1.0 - begin)
        _hold(law, step, arms, 1.0 - begin)
        deflection = step.start + step.change - height
    else:
        row.force[i] = 0.0
        _recover(law, step, modes, 1.0 - begin)
        deflection = _free_deflection(law, step, modes, permanent, 0.0)
    row.touching[i], row.deflection[i], row.permanent[i] = touching, deflection, permanent
    return event, left


@njit(cache=True)
def _gap(law, step, height, row, i, share):
    """Return the gap of a spring that has been free since the start of the step."""
    depth = step.start + step.change * share
    return height + _free_deflection(law, step, row.modes[i], row.permanent[i], share) - depth


@njit(cache=True)
def _place_edge(law, step, heights, old, new, events, left, cell):
    """Compute the contact edge between a held and a free spring; store edge and fall.

    `events` are the last events of the springs, `left` their forces at loss of contact.

    While the cell closes, the gap is assumed linear in height from the edge to the free spring;
    while it opens, the force decreases to zero with the slope at the last advance of the edge. Both
    are exact for the first loading of elastic springs, and otherwise have an error of the square of
    the spacing.
    """
    pressed = cell if new.touching[cell] else cell + 1
    free = 2 * cell + 1 - pressed
    end = step.start + step.change
    gap = heights[free] + new.deflection[free] - end
    force = new.force[pressed]
    speed = step.change / step.duration if step.duration > 0 else 0.0
    rim = law.viscosity * max(speed, 0.0)
    fall = old.fall[cell]
    edge = old.edge[cell]
    if events[free] >= 0 and events[free] > events[pressed]:
        if events[pressed] < 0:
            at = _held_force(law, step, old.deflection[pressed], old.arms[pressed], events[free])
            fall = at - left[free]
        else:
            fall = force
        edge = min(1.0, force / fall) if fall > 0 else 0.0
    else:
        if events[pressed] >= 0:
            edge = 0.0
            before = gap
            if events[free] < 0:
                before = _gap(law, step, heights[free], old, free, events[pressed])
        else:
            before = _gap(law, step, heights[free], old, free, 0.0)
        if gap <= before + _TIE * (abs(heights[free]) + abs(end)):
            edge = 1.0 - (1.0 - edge) * min(gap / before, 1.0) if before > 0 else edge
            fall = (force - rim) / edge if edge > 0 else 0.0
        elif fall > 0:
            edge = max(0.0, min(edge, force / fall))
    new.edge[cell], new.fall[cell] = edge, fall


@njit(cache=True)
def advance(law, heights, old, new, start, end, duration):
    """Advance a row of springs by one step with a linear change of depth; a jump takes no time.

    `heights` (n,) is the profile g at the springs, `old` the state before, which is not changed.
    """
    decay, rise = np.empty(law.times.size), np.empty(law.times.size)
    for j in range(law.times.size):
        ratio = duration / law.times[j]
        decay[j] = np.exp(-ratio)
        rise[j] = _held_arm(0.0, law.moduli[j], ratio, end - start)
    step = Step(start, end - start, duration, decay, rise, np.exp(-duration / law.retardations))
    count = heights.size
    events, left = np.full(count, -1.0), np.zeros(count)
    eventful = _carry_quiet(law, step, heights, old, new)
    for i in range(count):
        if eventful[i]:
            events[i], left[i] = _move_spring(law, step, heights[i], new, i)
    for cell in range(count - 1):
        if new.touching[cell] == new.touching[cell + 1]:
            new.edge[cell] = new.fall[cell] = 0.0
        else:
            _place_edge(law, step, heights, old, new, events, left, cell)
