"""Steady sliding of a rough rigid line under viscoelastic springs.

Problem 1 of the chapter moves the line step by step until the state is steady. The steady state can
be computed directly: at constant level Z0 all springs have the same history, one after the other,
so that one spring passing under the line (`one_spring`) represents the whole contact. The level
follows from the force, which decreases monotonically with it. `history` is the time loop.

Per unit length of line a spring of the reduced model carries (19.30), (19.31)

    f = 4 [G_inf w + sum_k G_k (w - q_k) + eta dw/dt] >= 0,  dq_k/dt = (w - q_k)/tau_k,

w its deflection; w = h - Z0 in contact. The friction is the force that is work-conjugate to the
sliding, F_x = int f dh/dx dx; F_x v is the power dissipated.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from reduced.arguments import refuse
from reduced.errors import ConvergenceError
from reduced.loads import LoadPath
from reduced.memory.materials import Prony
from reduced.rough.lines import RoughLines
from reduced.rubber import one_spring
from reduced.rubber.one_spring import COUNT, FORCE, LENGTH, LOSS, SQUARES, WORK, Rubber

CONTROLS = ("force", "penetration")

_SPRING = 4.0  # (19.30) at nu = 1/2
_PERIODS = 60
_TINY = 2.0**-46  # largest change of the state over a period, relative to the deflection


@dataclass(frozen=True)
class SteadySliding:
    """Steady sliding of m lines at k speeds; every array has shape (m, k).

    Attributes
    ----------
    friction_coefficient : ndarray
        F_x/F.
    force, tangential_force : ndarray
        F and F_x on the whole line.
    penetration : ndarray
        Depth of the line's highest point below the level of the rubber.
    contact_length, contact_area : ndarray
        sum l_j and (pi/4) sum l_j^2 (19.29) over the connected contacts.
    contact_count : ndarray of int
        Their number.
    dissipation : ndarray
        Energy that the material dissipates over one period, summed from its dashpots.
    energy_error : ndarray
        (F_x L - dissipation)/dissipation, the error of the energy balance.
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

    The line is linear between its points; everything else is exact (`one_spring`) at any speed and
    spacing. The level is bracketed, as the force decreases with it. Over a period the mean force of
    the arms is zero, so the mean deflection of a periodic line is F/(4 G_inf L) at any speed.

    Parameters
    ----------
    lines : RoughLines
        Heights in the order in which a point of the rubber passes them. A free line meets rubber at
        rest; its contact must be inside the line.
    material : Prony
        Shear modulus with G_inf > 0 (a fluid cannot carry a steady load); nu = 1/2.
    speed : array_like, shape (k,) or float
        v > 0, any order.
    load : LoadPath
        ``"force"`` F > 0 on the line, or ``"penetration"``, the depth of its highest point below
        the level of the rubber: one value for all speeds, or one per speed.

    Raises
    ------
    ConvergenceError
        If a force could not be met, or the contact of a free line reaches its end.

    Examples
    --------
    A parabola h = -x^2/2 under a Kelvin-Voigt rubber, slowly: mu = 2 v tau/R, R = 1.

    >>> from reduced.memory.materials import kelvin_voigt
    >>> x = np.linspace(-0.2, 0.2, 401)
    >>> parabola = RoughLines(-(x**2), 1e-3, periodic=False)
    >>> sliding = slide(parabola, kelvin_voigt(1.0, 1.0), 1e-6, LoadPath("force", 1e-3))
    >>> round(sliding.friction_coefficient.item() / 2e-6, 3)
    1.0
    """
    speeds = LoadPath("speed", speed).values
    wrong = solid_faults(material)
    for name, values in (("speed", speeds), (load.control, load.values)):
        if not np.all(values > 0):
            wrong.append(f"{name} must be positive, got {values}")
    if load.values.shape not in ((1,), speeds.shape):
        wrong.append(f"loads must be one, or one per speed ({speeds.size}), got {load.values.size}")
    refuse(wrong)
    loads = np.broadcast_to(load.values, speeds.shape)
    forced = load.one_of(*CONTROLS) == "force"
    rows = [
        [
            _Line(lines, row, material, v).steady(value, forced)
            for v, value in zip(speeds, loads, strict=True)
        ]
        for row in range(len(lines))
    ]
    depth = np.array([[solution[0] for solution in row] for row in rows])
    sums = np.moveaxis(np.array([[solution[1] for solution in row] for row in rows]), -1, 0)
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


class _Line:
    """One line, from its highest point on, under a material at one speed."""

    def __init__(self, lines: RoughLines, row: int, material: Prony, speed: float) -> None:
        line = lines.heights[row]
        peak = int(np.argmax(line))
        path = line - line[peak]
        if lines.periodic:
            path = np.concatenate([path[peak:], path[: peak + 1]])
        self.path, self.step, self.periodic = path, lines.spacing, lines.periodic
        # times as lengths, and the modes
        modes = material.creep().times
        matrix = 1 / (1 - material.times[:, None] / modes)
        if material.viscosity > 0:
            matrix = np.vstack([matrix, np.ones(modes.size)])
        self.rubber = Rubber(
            *(material.long_term, speed * material.viscosity, material.moduli),
            *(speed * material.times, speed * modes, matrix, np.linalg.inv(matrix)),
        )

    def draw(self, depth: float, state: np.ndarray) -> tuple[np.ndarray, bool]:
        """Return integrals over the line at a depth of its highest point; advance `state`."""
        return one_spring.draw(self.path, -depth, self.step, self.periodic, self.rubber, state)

    def settled(self, depth: float) -> np.ndarray:
        """Return integrals over one period of the steady state, or over a free line.

        The highest point is always in contact, so the state is that of the arms there. The map of a
        period is piecewise linear, so Newton's method reaches the fixed point.
        """
        arms, size = self.rubber.arms.size, self.rubber.modes.size
        begin = np.zeros(size)
        if not self.periodic:
            inside = self.path[0] + depth <= 0
            sums, touching = self.draw(depth, begin) if inside else (begin, True)
            if touching:
                raise ConvergenceError(
                    f"at depth {depth!r} the contact reaches the end of the line"
                )
            return sums
        history = []
        for _ in range(_PERIODS):
            end = begin.copy()
            sums, _ = self.draw(depth, end)
            change = (end - begin)[:arms]
            history.append(float(np.max(np.abs(change), initial=0.0)) / depth)
            if history[-1] <= _TINY:
                return sums
            # d(state after a period)/d(state); differences are exact on a linear piece
            tangent, probe = np.empty((arms, arms)), depth * 2.0**-20
            for k in range(arms):
                moved = begin.copy()
                moved[k] += probe
                self.draw(depth, moved)
                tangent[:, k] = (moved - end)[:arms] / probe
            begin[:arms] += np.linalg.solve(np.eye(arms) - tangent, change)
        raise ConvergenceError("the steady state of the line was not reached", history)

    def steady(self, load: float, forced: bool) -> tuple[float, np.ndarray]:
        """Return depth of the highest point and integrals at one load."""
        if not forced:
            return load, self.settled(load)
        goal, path = load / _SPRING, self.path
        deflection = goal / (self.rubber.solid * self.step)  # of a single spring

        def excess(depth: float) -> float:
            return self.settled(depth)[FORCE] / goal - 1 if depth > 0 else -1.0

        if self.periodic:
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
                    raise ConvergenceError(
                        f"at depth {end!r} the contact reaches the end of the line"
                    )
        precision = 4 * np.finfo(float).eps
        depth = brentq(excess, 0.0, deepest, xtol=2.0**-52 * deepest, rtol=precision, maxiter=200)
        return float(depth), self.settled(depth)


def solid_faults(material: Prony) -> list[str]:
    """Return messages if the material cannot carry a static load, or has no dissipation."""
    wrong = []
    if not material.long_term > 0:
        wrong.append("material must be a solid, G_inf > 0: a fluid sinks without limit")
    if not material.steady_viscosity > 0:
        wrong.append("material must have a dashpot: an elastic foundation has no friction")
    return wrong


def kelvin_voigt_faults(material: Prony) -> list[str]:
    """Return a message if a material is not a spring and a dashpot in parallel."""
    if material.long_term > 0 and material.viscosity > 0 and material.moduli.size == 0:
        return []
    return ["material must be a spring and a dashpot in parallel (Kelvin-Voigt), without arms"]
