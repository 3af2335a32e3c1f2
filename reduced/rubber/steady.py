"""Steady sliding of a rough rigid line under viscoelastic springs.

Problem 1 of the chapter moves the line step by step until the state is steady. At constant level
Z0 all springs have the same history, one after the other, so one spring that passes under the line
once represents the whole contact (`_pass`); the level follows from the force, which decreases with
it. `history` is the time loop. Per unit length of line a spring carries (19.30), (19.31)

    f = 4 [G_inf w + sum_k s_k + eta dw/dt] >= 0,   ds_k/dt = G_k dw/dt - s_k/tau_k,

w its deflection; w = h - Z0 in contact. The friction is the force that is work-conjugate to the
sliding, F_x = int f dh/dx dx; F_x v is the power dissipated.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from reduced.errors import ConvergenceError, refuse
from reduced.loads import LoadPath
from reduced.memory.materials import Prony
from reduced.memory.row import SpringLaw, catch, law_of, let_go, recover
from reduced.rough.press import RoughLines

FORCE, WORK, LOSS, LENGTH, SQUARES, COUNT = range(6)

_SPRING = 4.0  # (19.30) at nu = 1/2
_TINY = 2.0**-46  # largest change of the state over a period, relative to the deflection
_ROUNDS, _HALVINGS = 200, 60
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(4)


@dataclass(frozen=True)
class SteadySliding:
    """Steady sliding of m lines at k speeds; every array has shape (m, k).

    Forces are those on the whole line, the penetration that of its highest point below the level of
    the rubber; contact length sum l_j and area (pi/4) sum l_j^2 (19.29) over the connected
    contacts. The dissipation is that of the dashpots over one period, the energy error
    (F_x L - dissipation)/dissipation.
    """

    friction_coefficient: np.ndarray
    force: np.ndarray
    tangential_force: np.ndarray
    penetration: np.ndarray
    contact_length: np.ndarray
    contact_area: np.ndarray
    contact_count: np.ndarray
    dissipation: np.ndarray
    energy_error: np.ndarray


def slide(lines: RoughLines, material: Prony, speed: ArrayLike, load: LoadPath) -> SteadySliding:
    """Return the steady sliding of rigid lines under a viscoelastic foundation.

    The line is linear between its points; everything else is exact at any speed and spacing. Over a
    period the mean force of the arms is zero, so the mean deflection of a periodic line is
    F/(4 G_inf L) at any speed.

    Heights are in the order in which a point of the rubber passes them. A free line meets rubber at
    rest; its contact must be inside the line, else ConvergenceError. The material is a solid (a
    fluid cannot carry a steady load), nu = 1/2. The load is a ``"force"`` on the line or a
    ``"penetration"`` of its highest point below the level of the rubber: one for all speeds, or one
    per speed.

    A parabola h = -x^2/2 under a Kelvin-Voigt rubber, slowly: mu = 2 v tau/R, R = 1.

    >>> from reduced.memory.materials import kelvin_voigt
    >>> x = np.linspace(-0.2, 0.2, 401)
    >>> parabola = RoughLines(-(x**2), 1e-3, periodic=False)
    >>> sliding = slide(parabola, kelvin_voigt(1.0, 1.0), 1e-6, LoadPath("force", 1e-3))
    >>> round(sliding.friction_coefficient.item() / 2e-6, 3)
    1.0
    """
    speeds = LoadPath("speed", speed).values
    wrong = []
    if not material.long_term > 0:
        wrong.append("material must be a solid, G_inf > 0: a fluid sinks without limit")
    if not material.steady_viscosity > 0:
        wrong.append("material must have a dashpot: an elastic foundation has no friction")
    for name, values in (("speed", speeds), (load.control, load.values)):
        if not np.all(values > 0):
            wrong.append(f"{name} must be positive, got {values}")
    if load.values.shape not in ((1,), speeds.shape):
        wrong.append(f"loads must be one, or one per speed ({speeds.size}), got {load.values.size}")
    refuse(wrong)
    loads = np.broadcast_to(load.values, speeds.shape)
    forced = load.one_of("force", "penetration") == "force"
    depth, sums = np.empty((len(lines), speeds.size)), np.empty((6, len(lines), speeds.size))
    for row, k in np.ndindex(depth.shape):
        law = law_of(material, float(speeds[k]))
        depth[row, k], sums[:, row, k] = _steady(lines[row], law, float(loads[k]), forced)
    tangential, normal, loss = _SPRING * sums[WORK], _SPRING * sums[FORCE], _SPRING * sums[LOSS]
    return SteadySliding(
        friction_coefficient=tangential / normal,
        force=normal,
        tangential_force=tangential,
        penetration=depth,
        contact_length=sums[LENGTH],
        contact_area=np.pi / 4 * sums[SQUARES],
        contact_count=sums[COUNT].astype(np.int64),
        dissipation=loss,
        energy_error=(tangential - loss) / loss,
    )


def _steady(
    line: RoughLines, law: SpringLaw, load: float, forced: bool
) -> tuple[float, np.ndarray]:
    """Return the depth of the highest point of a line, and the integrals over it, at one load."""
    heights, moduli = line.single(), law.moduli
    peak = int(np.argmax(heights))
    path = heights - heights[peak]
    if line.periodic:
        path = np.concatenate([path[peak:], path[: peak + 1]])

    def passed(depth: float, arms: np.ndarray) -> tuple[np.ndarray, bool]:
        """Return integrals over the line at a depth of its highest point; advance the arms."""
        modes = np.zeros(law.retardations.size)
        return _pass(path, -depth, line.spacing, line.periodic, law, arms, modes)

    def settled(depth: float) -> np.ndarray:
        """Return integrals over one period of the steady state, or over a free line.

        The highest point is always in contact, so the state is that of the arms there. The map of a
        period is piecewise linear, so Newton's method reaches the fixed point.
        """
        begin = np.zeros(moduli.size)
        if not line.periodic:
            inside = path[0] + depth <= 0
            sums, touching = passed(depth, begin) if inside else (begin, True)
            if touching:
                raise ConvergenceError(
                    f"at depth {depth!r} the contact reaches the end of the line"
                )
            return sums
        history = []
        for _ in range(60):
            end = begin.copy()
            sums, _ = passed(depth, end)
            change = end - begin
            history.append(float(np.max(np.abs(change / moduli), initial=0.0)) / depth)
            if history[-1] <= _TINY:
                return sums
            # d(state after a period)/d(state); differences are exact on a linear piece
            tangent = np.empty((moduli.size, moduli.size))
            for k, probe in enumerate(depth * 2.0**-20 * moduli):
                moved = begin.copy()
                moved[k] += probe
                passed(depth, moved)
                tangent[:, k] = (moved - end) / probe
            begin += np.linalg.solve(np.eye(moduli.size) - tangent, change)
        raise ConvergenceError("the steady state of the line was not reached", history)

    if not forced:
        return load, settled(load)
    goal = load / _SPRING
    deflection = goal / (law.long_term * line.spacing)  # of a single spring

    def excess(depth: float) -> float:
        return settled(depth)[FORCE] / goal - 1 if depth > 0 else -1.0

    if line.periodic:
        # mean deflection F/(4 G_inf L), and w >= h - Z0 everywhere
        deepest = deflection / (path.size - 1) - path[:-1].mean()
        deepest *= 1 + 2.0**-40  # at full contact this is the root up to rounding
    else:
        # a free line: doubled from a single spring until it exceeds the force
        end = -float(path[[0, -1]].max())
        deepest = min(deflection, end / 1024)
        while deepest < end and excess(deepest) < 0:
            deepest *= 2
        if deepest >= end:
            deepest = end
            if excess(end) < 0:
                raise ConvergenceError(f"at depth {end!r} the contact reaches the end of the line")
    precision = 4 * np.finfo(float).eps
    depth = brentq(excess, 0.0, deepest, xtol=2.0**-52 * deepest, rtol=precision, maxiter=200)
    return float(depth), settled(depth)


def kelvin_voigt_faults(material: Prony) -> list[str]:
    """Return a message if a material is not a spring and a dashpot in parallel."""
    if material.long_term > 0 and material.viscosity > 0 and material.moduli.size == 0:
        return []
    return ["material must be a spring and a dashpot in parallel (Kelvin-Voigt), without arms"]


@njit(cache=True)
def _pass(line, level, step, touching, law, arms, modes):
    """Move one spring under the line, heights in the order of passage; advance its state.

    The line is linear between its points, contacts begin and end inside the cells, and everything
    is exact. (A force that becomes negative and recovers within one cell is not seen; with at most
    one arm there is none.) Times in the law are lengths v t; forces are without the factor 4 of
    (19.30).

    Returns the integrals of the force and of its work on the line's slope, the energy dissipated
    (with the stored energy lost between release and renewed contact), the lengths of the contacts,
    their squares and number (a contact across the seam is one), and whether it ends in contact.
    """
    sums, began, first, run = np.zeros(6), touching, -1.0, 0.0
    decays, factors = np.exp(-step / law.retardations), np.empty((3, arms.size))
    solid, moduli, lengths = law.long_term, law.moduli, law.times
    for i in range(line.size - 1):
        height, remaining = line[i] - level, step
        rate = (line[i + 1] - line[i]) / step
        if not touching:
            at = _entry(modes, law.retardations, decays, height, rate, step)
            if at > step:
                modes *= decays
                continue
            height, remaining, touching = height + rate * at, step - at, True
            recover(law, modes, at)
            catch(law, arms, modes)
            sums[LOSS] -= _stored(law, height, arms)
        # in contact to the end of the cell, or to zero force
        part = remaining
        if _force(law, arms, height, rate, part, factors) < 0.0:
            part = 0.0
            if _force(law, arms, height, rate, part, factors) > 0.0:
                if arms.size == 0:
                    lift = height * solid + law.viscosity * rate
                    part = min(max(-lift / (solid * rate), 0.0), remaining)
                else:
                    high = remaining
                    for _ in range(_HALVINGS):
                        middle = (part + high) / 2
                        if _force(law, arms, height, rate, middle, factors) > 0.0:
                            part = middle
                        else:
                            high = middle
                    _force(law, arms, height, rate, part, factors)
        # integrals of the force and of the dashpots' losses along the part, and the arms at its end
        rise = rate * part
        pull = solid * part * (height + rise / 2) + law.viscosity * rate * part
        sums[LOSS] += law.viscosity * rate * rate * part
        for j in range(arms.size):
            strain, x, steady = arms[j] / moduli[j], part / lengths[j], rate * lengths[j]
            decay, phi_1, phi_2 = factors[0, j], factors[1, j], factors[2, j]
            pull += moduli[j] * part * (strain * phi_1 + rise * phi_2)
            if x < 0.5:  # Gauss points, where the closed form suffers cancellation
                square = 0.0
                for p in range(_NODES.size):
                    u = x * (1 + _NODES[p]) / 2
                    stretch = strain * np.exp(-u) - steady * np.expm1(-u)
                    square += _WEIGHTS[p] * part / 2 * stretch * stretch
            else:
                apart = strain - steady
                square = part * steady * steady + 2 * steady * apart * part * phi_1
                square += apart * apart * lengths[j] / 2 * (1 - decay * decay)
            sums[LOSS] += moduli[j] * square / lengths[j]
            arms[j] = moduli[j] * (strain * decay + rise * phi_1)
        sums[FORCE] += pull
        sums[WORK] += rate * pull
        run += part
        if part < remaining:
            height += rise
            sums[LOSS] += _stored(law, height, arms)
            let_go(law, height, arms, modes)
            recover(law, modes, remaining - part)
            if began and first < 0.0:
                first = run
            else:
                _add_contact(sums, run)
            touching, run = False, 0.0
    if touching or first >= 0.0:
        _add_contact(sums, (run if touching else 0.0) + max(first, 0.0))
    return sums, touching


@njit(cache=True)
def _force(law, arms, height, rate, way, factors):
    """Return the force after a way in contact from `height`, and store the factors of the way.

    They are exp(-x), phi_1 = (1 - exp(-x))/x and phi_2 = (1 - phi_1)/x at x = way/length.
    """
    force = law.long_term * (height + rate * way) + law.viscosity * rate
    for j in range(arms.size):
        x = way / law.times[j]
        factors[0, j] = np.exp(-x)
        factors[1, j] = -np.expm1(-x) / x if x > 0.0 else 1.0
        if x > 0.1:
            factors[2, j] = (1 - factors[1, j]) / x
        else:
            factors[2, j] = 0.5 - x / 6 * (1 - x / 4 * (1 - x / 5 * (1 - x / 6 * (1 - x / 7))))
        force += arms[j] * factors[0, j] + law.moduli[j] * rate * way * factors[1, j]
    return force


@njit(cache=True)
def _stored(law, height, arms):
    """Return the elastic energy of a spring in contact."""
    energy = law.long_term * height * height
    for j in range(arms.size):
        energy += arms[j] * arms[j] / law.moduli[j]
    return energy / 2


@njit(cache=True)
def _add_contact(sums, length):
    sums[LENGTH] += length
    sums[SQUARES] += length * length
    sums[COUNT] += 1.0


@njit(cache=True)
def _free_place(modes, lengths, s):
    """Return the deflection and its rate of a free spring after a distance s."""
    place, rate = 0.0, 0.0
    for j in range(modes.size):
        now = modes[j] * np.exp(-s / lengths[j])
        place += now
        rate -= now / lengths[j]
    return place, rate


@njit(cache=True)
def _entry(modes, lengths, decays, height, rate, step):
    """Return the distance to contact of the line with a free spring, or twice the step if none.

    The clearance is convex (all amplitudes are >= 0): Newton iterates from a point before the first
    zero stay before it.
    """
    end = 0.0
    for j in range(modes.size):
        end += modes[j] * decays[j]
    if end > height + rate * step:
        # positive at both ends of the cell: does the clearance become negative in between?
        low, high = 0.0, step
        if rate >= 0.0 or _free_place(modes, lengths, low)[1] >= rate:
            return 2 * step
        if _free_place(modes, lengths, high)[1] <= rate:
            return 2 * step
        for _ in range(_HALVINGS):
            middle = (low + high) / 2
            place, fall = _free_place(modes, lengths, middle)
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
        place, fall = _free_place(modes, lengths, at)
        slope = fall - rate
        if slope >= 0.0:
            return at
        further = at - (place - height - rate * at) / slope
        if not further > at:
            return at
        at = min(further, step)
    return at
