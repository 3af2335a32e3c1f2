"""Problem 1 of the chapter as printed, steps 7 to 14, with its flaws.

`history` is the corrected version and lists the flaws. Nothing is corrected here, as this module
shows the behaviour of the printed algorithm. Where the print is ambiguous, the choice is stated.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from reduced.errors import ConvergenceError, positive_faults, refuse
from reduced.memory.materials import Prony
from reduced.rough.press import RoughLines
from reduced.rubber.steady import kelvin_voigt_faults

_SPRING = 4.0  # (19.30) at nu = 1/2
_ESCAPED = 2.0**20  # diverged beyond this many ranges of the line
OUTCOMES = ("completed", "no contact", "diverged")
_COMPLETED, _NO_CONTACT, _DIVERGED = range(3)
_FRICTION, _CONJUGATE, _LEVEL, _COUNT, _NEGATIVE = range(5)


@dataclass(frozen=True)
class PrintedSliding:
    """Results of the printed scheme up to its end; arrays have shape (steps done,)."""

    # "completed", "no contact", "diverged". "no contact": N = 0, the divisor in step 12.
    # "diverged": a spring or the level is 2^20 times the line's range away
    outcome: str
    tangential_force: np.ndarray  # F_x of step 13, forces times the central difference
    # the same forces times dz/dx of their springs: their work over the distance
    conjugate_force: np.ndarray
    # level, contact_count: Z0 and N
    level: np.ndarray
    contact_count: np.ndarray
    # springs in tension after the shift of the level, as the contact set is that of the old one
    tensile_count: np.ndarray
    # G dt/eta = dx/(v tau) of the explicit relaxation: free springs overshoot the level above
    # 1 and diverge above 2
    relaxation_number: float
    force: float  # F_N, met by construction

    def friction_coefficient(self, steps: int | None = None) -> float:
        """Return step 14: mean of F_x/F_N over the last steps; the print includes the transient.

        Raises ConvergenceError if no step was completed.
        """
        part = self.tangential_force[-steps:] if steps else self.tangential_force
        if part.size == 0:
            raise ConvergenceError(
                f"the printed scheme ended before its first step: {self.outcome}"
            )
        return float(part.mean() / self.force)


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
    number = shear_modulus * spacing / (speed * material.viscosity)
    unit = _SPRING * shear_modulus * spacing
    rows = np.zeros((5, int(steps)))
    with np.errstate(over="ignore"):
        outcome, done = _march(heights, spacing, number, force / unit, start, rows)
    rows = rows[:, :done]
    return PrintedSliding(
        outcome=OUTCOMES[outcome],
        tangential_force=unit * rows[_FRICTION],
        conjugate_force=unit * rows[_CONJUGATE],
        level=rows[_LEVEL],
        contact_count=rows[_COUNT].astype(np.int64),
        tensile_count=rows[_NEGATIVE].astype(np.int64),
        relaxation_number=number,
        force=float(force),
    )


@njit(cache=True)
def _march(line, spacing, number, goal, level, rows):
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
                rows[_FRICTION, step] += carried * slope
                rows[_CONJUGATE, step] += carried * (moved[i] - z[i]) / spacing
                rows[_NEGATIVE, step] += carried < 0.0
        rows[_LEVEL, step], rows[_COUNT, step] = level, count
        z, moved = moved, z
    return _COMPLETED, rows.shape[1]
