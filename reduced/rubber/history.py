"""Problem 1 of the chapter, corrected: time stepping of a rough line under Kelvin-Voigt springs.

What the print says (`slide_as_printed` follows it literally), and what `slide_in_time` does:

- Step 10 starts without contact if no point is 3 rms high, its forces lack dx, and z_i is
  undefined: the line is pressed on at rest, in equilibrium with the relaxed springs.
- Step 11 sets dt = dx/v, step 12 relaxes by an explicit step, unstable for G dt/eta > 2 and hence
  in slow sliding: relaxation is exact for steps of any length, and w = z - Z0 relaxes, so that free
  springs move with the level.
- The level is shifted for the springs in contact before the shift, which then pull or overlap, and
  N = 0 divides by zero: the contact set is that of the new level, which meets the force exactly.
- Step 13 multiplies by the line's central difference, which is not the slope along which the spring
  moves: the friction is the work of the contact forces over the distance.

The mean over the step equals the prescribed force: with steps of one cell the limiting state is
that of `steady.slide` on the same line.

A spring has the length w = z - Z0, at least that of free relaxation: w is the running maximum of
the line's height above the level, with values decaying as exp(-t/tau). Contacts begin and end at
exactly computed positions between the points of the line, so a step may have any length. In the
compiled part times are lengths v t, the relaxation length is l = v tau, and forces are per 4 G dx;
then a spring in contact carries g + l dg/ds, g = h - Z0.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit

from reduced.errors import ConvergenceError, count_faults, positive_faults, refuse
from reduced.loads import Load
from reduced.memory.materials import Prony
from reduced.rough.press import RoughLines, press
from reduced.rubber.steady import kelvin_voigt_faults

_SPRING = 4.0  # (19.30) at nu = 1/2
_IMPULSE, _SLOPE, _WORK, _LOSS, _LENGTH, _COUNT, _LEVEL, _STORED = range(8)
_SUMS = 6
_NEWTON = 100
_BALANCE = 1e-12  # relative residual of the force; rounding is about 1e-14
_FINEST = 2.0**-50  # tolerance of the level over the line's range: rounding of heights
_ROUNDING = 1e-14  # error of a contact position, relative to the step
# Of steps 7 to 14 as printed; where the print is ambiguous, the choice is stated.
OUTCOMES = ("completed", "no contact", "diverged")
_COMPLETED, _NO_CONTACT, _DIVERGED = range(3)
_ESCAPED = 2.0**20  # diverged beyond this many ranges of the line
_PRINTED_FRICTION, _PRINTED_CONJUGATE, _PRINTED_LEVEL, _PRINTED_COUNT, _PRINTED_TENSILE = range(5)


@dataclass(frozen=True)
class SlidingHistory:
    """Sliding of m lines in k steps; arrays have shape (m, k), `distance` (at the ends) (k,)."""

    distance: np.ndarray
    level: np.ndarray  # Z0 during the step, relative to the zero of the heights
    force: np.ndarray  # mean over the step
    tangential_force: np.ndarray  # work over the distance
    contact_count: np.ndarray  # springs in contact at the end of the step
    contact_length: np.ndarray  # mean over the step of dx times their number
    dissipation: np.ndarray  # in the step by sliding, without shifts of the level
    stored: np.ndarray  # elastic energy at the end of the step
    period: float
    spacing: float

    def last(self) -> slice:
        """Return the steps of the last period of the line."""
        begin = self.distance[-1] - self.period * (1 - 1e-9)
        return slice(int(np.searchsorted(self.distance, begin)), None)

    def friction_coefficient(self) -> np.ndarray:
        """Return the mean F_x over the mean F in the last period (steps 13, 14), shape (m,)."""
        part = self.last()
        return self.tangential_force[:, part].mean(axis=1) / self.force[:, part].mean(axis=1)

    def energy_error(self) -> np.ndarray:
        """Return (work - dissipation)/dissipation over the last period, shape (m,).

        Only steps of whole cells have a steady state, with equal stored energy at both ends: within
        a cell few springs carry the load and the level follows them up and down, which causes
        additional dissipation that vanishes with dx.
        """
        part, cells = self.last(), self.distance[0] / self.spacing
        steps = self.distance.size - part.start
        if round(cells) < 1 or abs(cells - round(cells)) > 1e-9 or part.start < 1:
            raise ValueError(
                "an energy balance needs steps of whole cells, over one period or more"
            )
        if round(cells) * steps != round(self.period / self.spacing):
            raise ValueError(f"{steps} steps of {round(cells)} cells are not one period")
        work = self.tangential_force[:, part].sum(axis=1) * self.distance[0]
        loss = self.dissipation[:, part].sum(axis=1)
        return (work - loss) / loss


def slide_in_time(
    lines: RoughLines,
    material: Prony,
    speed: float,
    force: float,
    *,
    steps: int,
    step_length: float | None = None,
) -> SlidingHistory:
    """Solve the sliding of periodic lines on a Kelvin-Voigt foundation, Problem 1 as corrected.

    The spring at x is under h(x + v t) and carries f = 4 dx (G w + eta dw/dt) (19.30); the force is
    that on every line. `step_length` is v dt, of any length, by default dx.
    """
    heights, spacing = lines.heights, lines.spacing
    way = spacing if step_length is None else step_length
    wrong = positive_faults(speed=speed, force=force, step_length=way) + count_faults(steps=steps)
    refuse(wrong + kelvin_voigt_faults(material))
    m, n = heights.shape
    relaxed = _SPRING * material.long_term
    at_rest = press(lines, relaxed, Load("force", force), edges="nodal").penetration[:, 0]
    # relative to the highest point, close to the level, which keeps digits under light loads
    tops = heights.max(axis=1)
    unit = relaxed * spacing
    memory = speed * (material.viscosity / material.long_term)
    sums_by_line = np.empty((m, 8, steps))
    for line, depth, rows in zip(heights - tops[:, None], at_rest, sums_by_line, strict=True):
        twice = np.concatenate([line, line, line[:1]])
        springs = np.maximum(line + depth, 0.0)
        goal = float(force * way / unit)
        done = _march(twice, float(spacing), float(way), float(memory), goal, -depth, springs, rows)
        if done < steps:
            raise ConvergenceError(f"the force of step {done} could not be met")
    sums = np.moveaxis(sums_by_line, 1, 0)
    return SlidingHistory(
        distance=way * np.arange(1, steps + 1),
        level=tops[:, None] + sums[_LEVEL],
        force=sums[_IMPULSE] * (unit / way),
        tangential_force=sums[_WORK] * (unit / way),
        contact_count=sums[_COUNT].astype(np.int64),
        contact_length=sums[_LENGTH] * (spacing / way),
        dissipation=sums[_LOSS] * unit,
        stored=sums[_STORED] * unit,
        period=n * spacing,
        spacing=spacing,
    )


@njit(cache=True)
def _march(line, spacing, way, memory, goal, level, springs, rows):
    """Take all steps of one line; return the number of steps that met the force.

    The heights of the line (2 n + 1) are one period, repeated once; `way` is the length of a step,
    `memory` is l, `goal` the impulse per step. `springs` (n,) are the initial deflections w,
    overwritten; `rows` (8, steps) receives sums of the steps, levels, stored energies.
    """
    n = springs.size
    moved, sums, cells = np.empty(n), np.empty(_SUMS), way / spacing
    upper = np.maximum(line[:-1], line[1:])
    finest = _FINEST * (np.max(line) - np.min(line))
    mask, chosen = np.zeros(n + 8 - n % 8, np.uint8), np.empty(n, np.int64)
    last, stored, decay = level, _squares(springs) / 2, np.exp(-2 * way / memory)
    for step in range(rows.shape[1]):
        # The impulse of a step is convex and decreasing in the level: w is a maximum of functions
        # linear in it, and the impulse a sum of values of w with positive weights. Newton's method
        # from above the goal therefore reaches the root; from below, one step leads above. Most
        # springs remain free: those within reach of the line alone enter the search.
        begin, guess = step * cells, 2 * level - last
        end = begin + way / spacing
        last, level = level, guess
        floor, count, reach = np.inf, 0, 0.0
        for _ in range(_NEWTON):
            if level < floor:
                floor = level - 2 * reach
                if end > np.floor(begin) + 1:  # a step longer than a cell may reach any spring
                    count = n
                    for i in range(n):
                        chosen[i] = i
                else:
                    # all relax freely; listed are those within reach of a line above the floor
                    begun, count = int(np.floor(begin)) % n, 0
                    decayed = np.exp(-way / memory)
                    _relax(upper[begun : begun + n], floor, decayed, springs, moved, mask)
                    for block, bits in enumerate(mask.view(np.uint64)):
                        if bits:
                            for i in range(8 * block, 8 * block + 8):
                                chosen[count] = i
                                count += mask[i]
            near = chosen[:count]
            # The level is set at the start of the step: springs in contact follow it (with an
            # impulse l per shift on their dashpots), free ones move along unless the line reaches
            # them.
            sums[:] = 0.0
            at, now = begin, springs
            while at < end:
                cell = np.floor(at)
                until = min(cell + 1.0, end)
                part = line[int(cell) % n :]
                _sweep(
                    part, at - cell, until - cell, spacing, memory, level, now, moved, near, sums
                )
                at, now = until, moved
            excess = sums[_IMPULSE] - goal
            if abs(excess) <= _BALANCE * goal:
                break
            if sums[_SLOPE] == 0.0:
                # no contact in the whole step: first place the highest point on the surface
                highest, free = -np.inf, np.exp(-(way / memory))
                first, share = int(np.floor(end)) % n, end - np.floor(end)
                for i in range(n):
                    height = line[first + i] * (1 - share) + line[first + i + 1] * share
                    highest = max(highest, height - springs[i] * free)
                following = highest - goal / memory
            else:
                following = level + excess / sums[_SLOPE]
            reach = abs(following - level)
            if reach <= finest:
                break
            level = following
        else:
            return step
        if count < n:
            sums[_LOSS] += (1 - decay) * (stored - _squares(springs[chosen[:count]]) / 2)
        springs, moved = moved, springs
        stored = _squares(springs) / 2
        for k in range(_SUMS):
            rows[k, step] = sums[k]
        rows[_LEVEL, step], rows[_STORED, step] = level, stored
    return rows.shape[1]


@njit(cache=True, fastmath={"reassoc"})
def _squares(springs):
    total = 0.0
    for w in springs:
        total += w * w
    return total


@njit(cache=True)
def _relax(upper, floor, decay, springs, moved, mask):  # a loop of its own is vectorised
    for i in range(springs.size):
        free = springs[i] * decay
        moved[i] = free
        mask[i] = upper[i] - floor >= free


@njit(cache=True)
def _sweep(line, start, stop, spacing, memory, level, springs, moved, chosen, sums):
    """Move the selected springs within a cell of the line, from a position in it to another."""
    fresh, way = springs is not moved, (stop - start) * spacing
    decay, inverse = np.exp(-way / memory), 1 / spacing
    impulse = slope = work = loss = length = 0.0
    count = 0
    for i in chosen:
        w, rate = springs[i], (line[i + 1] - line[i]) * inverse
        low = line[i] * (1 - start) + line[i + 1] * start - level
        high = line[i] * (1 - stop) + line[i + 1] * stop - level
        at = 0.0
        if w > low:
            at = _meeting(w, low, high, rate, way, memory, decay)
            if at >= way:
                moved[i] = w * decay
                loss += (w * w - moved[i] * moved[i]) / 2
                continue
            low += rate * at
            loss += (w * w - low * low) / 2
            slope += memory
        elif fresh:
            impulse += memory * (low - w)
            slope += memory
        # in contact from `low` until the force g + l dg/ds is zero, and free from there on
        left = way - at
        if low + memory * rate <= 0.0:
            part, after = 0.0, low * np.exp(-left / memory)
        elif high + memory * rate >= 0.0:
            part, after = left, high
        else:
            release = -memory * rate
            part = min((release - low) / rate, left)
            after = release * np.exp(-(left - part) / memory)
        pull = part * (low + rate * (part / 2 + memory))
        impulse += pull
        slope += part
        work += rate * pull
        length += part
        release = low + rate * part
        loss += memory * rate * rate * part + (release * release - after * after) / 2
        moved[i] = after
        count += after == high
    sums[_IMPULSE] += impulse
    sums[_SLOPE] += slope
    sums[_WORK] += work
    sums[_LOSS] += loss
    sums[_LENGTH] += length
    sums[_COUNT] = count


@njit(cache=True)
def _meeting(w, low, high, rate, way, memory, decay):
    """Return the distance to contact with a free spring, or more than available.

    The clearance w exp(-s/l) - low - rate s is convex: Newton iterates from before its first zero
    stay before it.
    """
    if high <= w * decay:
        # contact inside the cell only: the maximum of g exp(s/l) is at zero force
        if low + memory * rate <= 0.0 or high + memory * rate >= 0.0:
            return 2 * way
        peak = -memory * rate
        if not peak * np.exp((peak - low) / (rate * memory)) > w:
            return 2 * way
    at = -low / rate if low < 0.0 < rate else 0.0
    for _ in range(_NEWTON):
        place = w * np.exp(-at / memory) if at > 0.0 else w
        fall = place / memory + rate
        if fall <= 0.0:
            return at
        step = (place - low - rate * at) / fall
        # the step is exact up to the curvature of the exponential, place/l^2
        if not step > 0.0 or place * step * step <= _ROUNDING * way * memory * memory * fall:
            return at + step
        at += step
    return at


@dataclass(frozen=True)
class PrintedSliding:
    """Results of the printed scheme up to its end; arrays have shape (steps done,)."""

    # of OUTCOMES; "no contact": N = 0, the divisor in step 12; "diverged": a spring or the level is
    # 2^20 times the line's range away
    outcome: str
    tangential_force: np.ndarray  # F_x of step 13, forces times the central difference
    conjugate_force: np.ndarray  # the same times dz/dx of their springs: work over the distance
    level: np.ndarray  # Z0
    contact_count: np.ndarray  # N
    tensile_count: np.ndarray  # springs in tension after the shift of the level
    force: float  # F_N, met by construction

    def friction_coefficient(self) -> float:
        """Return step 14: mean of F_x/F_N over all steps, the transient included as printed."""
        if self.tangential_force.size == 0:
            raise ConvergenceError(
                f"the printed scheme ended before its first step: {self.outcome}"
            )
        return float(self.tangential_force.mean() / self.force)


def slide_as_printed(
    line: RoughLines,
    material: Prony,
    speed: float,
    force: float,
    *,
    steps: int,
    level: float | None = None,
) -> PrintedSliding:
    """Solve the sliding of one periodic line under Kelvin-Voigt springs as printed in Problem 1.

    Step 10: Z0 = 3 times the rms height above the mean by default (many lines have no point there);
    z_i = h_i where h_i >= Z0 and (not stated in the print) z_i = Z0 elsewhere. Step 11: dt = dx/v.
    Step 12: points with h_i >= z_i join, those in contact remain while their force is positive, the
    others relax by one explicit step towards the old level; then the level is shifted for the
    points in contact. Step 13 takes the forces after the shift, which add up to F_N, and the line's
    central difference.

    >>> from reduced.memory.materials import kelvin_voigt
    >>> line = RoughLines(0.01 * np.cos(2 * np.pi * np.arange(64) / 64), 1 / 64)
    >>> slide_as_printed(line, kelvin_voigt(1.0, 1.0), 1.0, 0.01, steps=10).outcome
    'no contact'
    """
    wrong = positive_faults(speed=speed, force=force, steps=steps)
    refuse(wrong + kelvin_voigt_faults(material))
    heights, spacing, shear_modulus = line.single(), line.spacing, material.long_term
    start = 3 * float(np.sqrt(np.mean(heights**2))) if level is None else float(level)
    # G dt/eta of the explicit relaxation: free springs overshoot the level above 1, diverge above 2
    number = shear_modulus * spacing / (speed * material.viscosity)
    unit = _SPRING * shear_modulus * spacing
    rows = np.zeros((5, int(steps)))
    with np.errstate(over="ignore"):
        outcome, done = _march_as_printed(heights, spacing, number, force / unit, start, rows)
    rows = rows[:, :done]
    return PrintedSliding(
        outcome=OUTCOMES[outcome],
        tangential_force=unit * rows[_PRINTED_FRICTION],
        conjugate_force=unit * rows[_PRINTED_CONJUGATE],
        level=rows[_PRINTED_LEVEL],
        contact_count=rows[_PRINTED_COUNT].astype(np.int64),
        tensile_count=rows[_PRINTED_TENSILE].astype(np.int64),
        force=float(force),
    )


@njit(cache=True)
def _march_as_printed(line, spacing, number, goal, level, rows):
    """Take steps 10 to 13; forces are per 4 G dx, and eta/(G dt) = 1/number."""
    n = line.size
    escaped = _ESCAPED * (np.max(line) - np.min(line) + abs(level) + goal)
    z, force = np.maximum(line, level), np.zeros(n)
    touching, moved = line >= level, np.empty(n)
    stiffness = 1 + 1 / number
    for step in range(rows.shape[1]):
        total, count = 0.0, 0
        for i in range(n):
            height = line[(i + step + 1) % n]
            pushed = (height - level) + (height - z[i]) / number
            touching[i] = height >= z[i] or (touching[i] and pushed > 0.0)
            if touching[i]:
                force[i], moved[i] = pushed, height
                total += pushed
                count += 1
            else:
                moved[i] = z[i] - number * (z[i] - level)
        if count == 0:
            return _NO_CONTACT, step
        shift = (total - goal) / (count * stiffness)
        level += shift
        if not (np.max(np.abs(moved)) < escaped and abs(level) < escaped):
            return _DIVERGED, step
        for i in range(n):
            if touching[i]:
                place = i + step + 1
                carried = force[i] - shift * stiffness
                slope = (line[(place + 1) % n] - line[(place - 1) % n]) / (2 * spacing)
                rows[_PRINTED_FRICTION, step] += carried * slope
                rows[_PRINTED_CONJUGATE, step] += carried * (moved[i] - z[i]) / spacing
                rows[_PRINTED_TENSILE, step] += carried < 0.0
        rows[_PRINTED_LEVEL, step], rows[_PRINTED_COUNT, step] = level, count
        z, moved = moved, z
    return _COMPLETED, rows.shape[1]
