"""Problem 1 of the chapter, corrected: time stepping of a rough line under Kelvin-Voigt springs.

Gaps and errors of the print (`printed` follows it literally), and their corrections:

- Step 10 starts without contact if no point is 3 rms high, its forces lack dx, and z_i is
  undefined: here the line is pressed on at rest, in equilibrium with the relaxed springs.
- Step 11 sets dt = dx/v, step 12 relaxes by an explicit step, unstable for G dt/eta > 2 and hence
  in slow sliding: here relaxation is exact for steps of any length.
- Free springs relax towards the level but do not move with it: here w = z - Z0 relaxes.
- The level is shifted for the springs in contact before the shift, which then pull or overlap: here
  the contact set is that of the new level, and the force of the step is met exactly. N = 0, a
  division by zero in the print, is not a special case.
- Step 13 multiplies by the line's central difference, which is not the slope along which the spring
  moves: here the work of the contact forces over the distance.

The mean over the step equals the prescribed force. For steps of one cell the mean is an integral
over the cell, so the limiting state is that of `steady.slide` on the same line.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reduced.arguments import count_faults, positive_faults, refuse
from reduced.errors import ConvergenceError
from reduced.loads import Load
from reduced.memory.materials import Prony
from reduced.rough.lines import RoughLines
from reduced.rough.press import press
from reduced.rubber import steps as sliding_steps
from reduced.rubber.steady import kelvin_voigt_faults
from reduced.rubber.steps import COUNT, IMPULSE, LENGTH, LOSS, SUMS, WORK

_SPRING = 4.0  # (19.30) at nu = 1/2


@dataclass(frozen=True)
class SlidingHistory:
    """Sliding of m lines in k steps; arrays have shape (m, k).

    Attributes
    ----------
    distance : ndarray, shape (k,)
        Sliding distance at the end of the steps.
    level : ndarray
        Z0 during the step, relative to the zero of the heights.
    force, tangential_force : ndarray
        Means over the step; F_x is the work over the distance.
    contact_count : ndarray of int
        Springs in contact at the end of the step.
    contact_length : ndarray
        Mean over the step of dx times the number in contact.
    dissipation : ndarray
        Energy dissipated in the step by sliding (without shifts of the level).
    stored : ndarray
        Elastic energy at the end of the step.
    period, spacing : float
        Length of the line, and dx.
    """

    distance: np.ndarray
    level: np.ndarray
    force: np.ndarray
    tangential_force: np.ndarray
    contact_count: np.ndarray
    contact_length: np.ndarray
    dissipation: np.ndarray
    stored: np.ndarray
    period: float
    spacing: float

    def last(self, way: float | None = None) -> slice:
        """Return the steps of the last distance, by default one period of the line."""
        way = self.period if way is None else way
        return slice(
            int(np.searchsorted(self.distance, self.distance[-1] - way * (1 - 1e-9))), None
        )

    def friction_coefficient(self, way: float | None = None) -> np.ndarray:
        """Return the mean F_x over the mean F in the last distance (steps 13, 14), shape (m,)."""
        part = self.last(way)
        return self.tangential_force[:, part].mean(axis=1) / self.force[:, part].mean(axis=1)

    def energy_error(self) -> np.ndarray:
        """Return (work - dissipation)/dissipation over the last period, shape (m,).

        In a steady state the stored energy is equal at both ends. Only steps of whole cells have a
        steady state: within a cell few springs carry the load and the level follows them up and
        down, which causes additional dissipation that vanishes with dx.
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

    Parameters
    ----------
    lines : RoughLines
        Periodic lines; the spring at x is under h(x + v t).
    material : Prony
        `materials.kelvin_voigt`: G and eta of (19.30) with f = 4 dx (G w + eta dw/dt).
    speed, force : float
        v and the force on every line.
    steps : int
        Number of steps.
    step_length : float, optional
        v dt, of any length; default: dx.

    Raises
    ------
    ConvergenceError
        If the force of a step could not be met.

    Examples
    --------
    >>> from reduced.memory.materials import kelvin_voigt
    >>> line = RoughLines(0.01 * np.cos(2 * np.pi * np.arange(64) / 64), 1 / 64)
    >>> sliding = slide_in_time(line, kelvin_voigt(1.0, 1e-3), 1.0, 0.01, steps=192)
    >>> bool(abs(sliding.energy_error()[0]) < 1e-6)
    True
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
    sums_by_line = np.empty((m, SUMS + 2, steps))
    for line, depth, rows in zip(heights - tops[:, None], at_rest, sums_by_line, strict=True):
        twice = np.concatenate([line, line, line[:1]])
        springs = np.maximum(line + depth, 0.0)
        goal = force * way / unit
        lengths = (float(spacing), float(way), float(memory))
        done = sliding_steps.march(twice, lengths, float(goal), -depth, springs, rows)
        if done < steps:
            raise ConvergenceError(f"the force of step {done} could not be met")
    sums = np.moveaxis(sums_by_line, 1, 0)
    return SlidingHistory(
        distance=way * np.arange(1, steps + 1),
        level=tops[:, None] + sums[SUMS],
        force=sums[IMPULSE] * (unit / way),
        tangential_force=sums[WORK] * (unit / way),
        contact_count=sums[COUNT].astype(np.int64),
        contact_length=sums[LENGTH] * (spacing / way),
        dissipation=sums[LOSS] * unit,
        stored=sums[SUMS + 1] * unit,
        period=n * spacing,
        spacing=spacing,
    )
