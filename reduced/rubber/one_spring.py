"""Exact history of one spring under a rough line at constant speed and level, cell by cell.

In steady sliding every spring goes through the same history, so one spring that passes under the
line once represents the whole contact. The line is linear between its points. In contact the arms
of the material follow a linear deflection exactly; a free spring relaxes in its retardation modes,
which are exponentials; contacts begin and end inside the cells. (A force that becomes negative and
recovers within one cell is not detected; with at most one arm this cannot happen.)

All times are multiplied by the speed to lengths: v tau_k of the arms, v lambda_m of the modes, and
v eta of a parallel dashpot. Forces are per length of line, without the factor 4 of (19.30).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

FORCE, WORK, LOSS, LENGTH, SQUARES, COUNT = range(6)
SUMS = 6
_ROUNDS = 200
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(4)


class Rubber(NamedTuple):
    """A material at one speed.

    Attributes
    ----------
    solid, wet : float
        G_inf and v eta.
    arms, lengths : ndarray, shape (k,)
        Moduli G_k and relaxation lengths v tau_k.
    modes : ndarray, shape (m,)
        Retardation lengths v lambda_m, m = k, or k + 1 with a parallel dashpot.
    matrix, inverse : ndarray, shape (m, m)
        From the amplitudes of the modes of a free spring to the deflections q_k of the arms'
        dashpots (and w in the last row, with a dashpot), and back.
    """

    solid: float
    wet: float
    arms: np.ndarray
    lengths: np.ndarray
    modes: np.ndarray
    matrix: np.ndarray
    inverse: np.ndarray


@njit(cache=True)
def draw(line, level, step, touching, rubber, state):
    """Move a spring under the line; return integrals over the line, and the spring's final state.

    Parameters
    ----------
    line : ndarray, shape (n,)
        Heights in the order of passage.
    level, step : float
        Z0 of the rubber's undisturbed surface, and dx.
    touching : bool
        Whether the spring is initially in contact.
    state : ndarray, shape (m,)
        q_k of a spring in contact (the last entry may be unused), or mode amplitudes of a free one.

    Returns
    -------
    sums : ndarray, shape (6,)
        Integrals of the force and of its work on the line's slope, the energy dissipated (including
        the loss of stored energy between release and renewed contact), the lengths of the contacts,
        their squares, and their number. A contact across the seam is one.
    touching : bool
        Whether the spring ends in contact.
    """
    arms, modes = rubber.arms, rubber.modes
    sums, began, first, run = np.zeros(SUMS), touching, -1.0, 0.0
    decays, factors = np.exp(-step / modes), np.empty((3, arms.size))
    for i in range(line.size - 1):
        height, remaining = line[i] - level, step
        rate = (line[i + 1] - line[i]) / step
        if not touching:
            at = _entry(state, modes, decays, height, rate, step)
            if at > step:
                state *= decays
                continue
            height, remaining, touching = height + rate * at, step - at, True
            _to_arms(state, modes, rubber.matrix, at)
            sums[LOSS] -= _stored(state, height, rubber.solid, arms)
        part = _contact_part(state, height, rate, remaining, rubber, factors)
        pull = _follow(state, height, rate, part, rubber, factors, sums)
        sums[FORCE] += pull
        sums[WORK] += rate * pull
        run += part
        if part < remaining:
            sums[LOSS] += _stored(state, height + rate * part, rubber.solid, arms)
            _to_modes(
                state, modes, rubber.inverse, height + rate * part, arms.size, remaining - part
            )
            if began and first < 0.0:
                first = run
            else:
                _add_contact(sums, run)
            touching, run = False, 0.0
    if touching or first >= 0.0:
        _add_contact(sums, (run if touching else 0.0) + max(first, 0.0))
    return sums, touching


@njit(cache=True)
def _add_contact(sums, length):
    sums[LENGTH] += length
    sums[SQUARES] += length * length
    sums[COUNT] += 1.0


@njit(cache=True)
def _free_place(state, modes, s):
    """Return the deflection and its rate of a free spring after a distance s."""
    place, rate = 0.0, 0.0
    for j in range(modes.size):
        now = state[j] * np.exp(-s / modes[j])
        place += now
        rate -= now / modes[j]
    return place, rate


@njit(cache=True)
def _entry(state, modes, decays, height, rate, step):
    """Return the distance to contact of the line with a free spring, or twice the step if none.

    The clearance is convex (all amplitudes are >= 0): Newton iterates from a point before the first
    zero stay before it.
    """
    end = 0.0
    for j in range(modes.size):
        end += state[j] * decays[j]
    if end > height + rate * step:
        # positive at both ends of the cell: does the clearance become negative in between?
        low, high = 0.0, step
        if rate >= 0.0 or _free_place(state, modes, low)[1] >= rate:
            return 2 * step
        if _free_place(state, modes, high)[1] <= rate:
            return 2 * step
        for _ in range(60):
            middle = (low + high) / 2
            place, fall = _free_place(state, modes, middle)
            if place < height + rate * middle:
                break
            if fall < rate:
                low = middle
            else:
                high = middle
        else:
            return 2 * step
    elif rate <= 0.0 and height + rate * step <= 0.0:
        return 2 * step  # both fully relaxed, at or below the level
    # where the line rises through the level, the spring, never below it, is not yet in contact
    at = min(-height / rate, step) if rate > 0.0 and height < 0.0 else 0.0
    for _ in range(_ROUNDS):
        place, fall = _free_place(state, modes, at)
        slope = fall - rate
        if slope >= 0.0:
            return at
        further = at - (place - height - rate * at) / slope
        if not further > at:
            return at
        at = min(further, step)
    return at


@njit(cache=True)
def _factors(way, lengths, factors):
    """Compute exp(-x), phi_1 = (1 - exp(-x))/x and phi_2 = (1 - phi_1)/x at x = distance/length."""
    for j in range(lengths.size):
        x = way / lengths[j]
        factors[0, j] = np.exp(-x)
        factors[1, j] = -np.expm1(-x) / x if x > 0.0 else 1.0
        if x > 0.1:
            factors[2, j] = (1 - factors[1, j]) / x
        else:
            factors[2, j] = 0.5 - x / 6 * (1 - x / 4 * (1 - x / 5 * (1 - x / 6 * (1 - x / 7))))


@njit(cache=True)
def _force(state, height, rate, way, rubber, factors):
    """Return the force after a distance in contact; also store the factors of this distance."""
    arms = rubber.arms
    _factors(way, rubber.lengths, factors)
    force = rubber.solid * (height + rate * way) + rubber.wet * rate
    for j in range(arms.size):
        force += arms[j] * ((height - state[j]) * factors[0, j] + rate * way * factors[1, j])
    return force


@njit(cache=True)
def _contact_part(state, height, rate, remaining, rubber, factors):
    """Return the distance in contact: all of it, or up to zero force."""
    if _force(state, height, rate, remaining, rubber, factors) >= 0.0:
        return remaining
    if _force(state, height, rate, 0.0, rubber, factors) <= 0.0:
        return 0.0
    if rubber.arms.size == 0:
        solid = rubber.solid
        return min(max(-(height * solid + rubber.wet * rate) / (solid * rate), 0.0), remaining)
    low, high = 0.0, remaining
    for _ in range(60):
        middle = (low + high) / 2
        if _force(state, height, rate, middle, rubber, factors) > 0.0:
            low = middle
        else:
            high = middle
    _factors(low, rubber.lengths, factors)
    return low


@njit(cache=True)
def _follow(state, height, rate, way, rubber, factors, sums):
    """Follow the line over a distance in contact; return the integral of the force, add losses."""
    solid, wet, arms, lengths = rubber.solid, rubber.wet, rubber.arms, rubber.lengths
    pull = solid * way * (height + rate * way / 2) + wet * rate * way
    sums[LOSS] += wet * rate * rate * way
    for j in range(arms.size):
        begin, x = height - state[j], way / lengths[j]
        decay, phi_1, phi_2 = factors[0, j], factors[1, j], factors[2, j]
        pull += arms[j] * way * (begin * phi_1 + rate * way * phi_2)
        steady = rate * lengths[j]
        if x < 0.5:  # Gauss points, where the closed form suffers cancellation
            square = 0.0
            for p in range(_NODES.size):
                u = x * (1 + _NODES[p]) / 2
                stretch = begin * np.exp(-u) - steady * np.expm1(-u)
                square += _WEIGHTS[p] * way / 2 * stretch * stretch
        else:
            deviation = begin - steady
            square = way * steady * steady + 2 * steady * deviation * way * phi_1
            square += deviation * deviation * lengths[j] / 2 * (1 - decay * decay)
        sums[LOSS] += arms[j] * square / lengths[j]
        state[j] = height + rate * way - (begin * decay + rate * way * phi_1)
    return pull


@njit(cache=True)
def _stored(state, height, solid, arms):
    """Return the elastic energy of a spring in contact."""
    energy = solid * height * height
    for j in range(arms.size):
        energy += arms[j] * (height - state[j]) ** 2
    return energy / 2


@njit(cache=True)
def _to_arms(state, modes, matrix, way):
    """Replace the amplitudes by the deflections of the arms' dashpots after a free distance."""
    _put(matrix @ (state * np.exp(-way / modes)), state)


@njit(cache=True)
def _to_modes(state, modes, inverse, height, arms, way):
    """Replace the arms' deflections by mode amplitudes at a distance after release."""
    if modes.size > arms:
        state[arms] = height
    _put((inverse @ state) * np.exp(-way / modes), state)


@njit(cache=True)
def _put(values, state):
    """Copy values; Numba compiles the checks of a slice for longer than the rest of this file."""
    for j in range(state.size):
        state[j] = values[j]
