"""Adhesion of rough surfaces: a stable equilibrium of a periodic contact, by least energy.

Rough surfaces with a cohesive law jump into and out of contact spot by spot, at folds too many to
follow (`reference.halfspace.cohesive.trace`). Here the energy per area of all gaps h >= 0,

    E(h) = <(h - g) S (h - g)>/2 - <phi(h)> + F <h>/A0,   phi(h) = int_h^inf sigma,

is minimised instead, with S = E* |q|/2 the stiffness of the half-space to waves, g the initial gap
and F the load (Rey, Anciaux & Molinari 2017). Where the mean gap is prescribed in place of the
load, a stiff machine holds it, F/A0 = S_max (<h> - m). Several minima exist: the one downhill from
the start is taken, as a slow motion would.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike
from scipy import fft
from scipy.optimize import fmin_l_bfgs_b

from reference.arrays import Array, Mask
from reference.contact.body import ElasticBody
from reference.contact.press import check_gap
from reference.errors import ConvergenceError, refuse
from reference.halfspace.cohesive import CohesiveLaw
from reference.halfspace.kernels import whole

_MEMORY, _ITERATIONS = 5, 20_000
_SETTINGS = 12  # of the machine at most; each cuts the error by the ratio of both stiffnesses
_SAME = 1e-3
_UNBALANCED = 1e-4  # largest tension that nothing balances, relative to the strength of the law
# The energy is known to its rounding, its slope, the pressure, to the square root of that.
_ROUNDED = 1e-6


@dataclass(frozen=True)
class Settled:
    """A stable equilibrium."""

    force: float  # F, negative when pulling
    # (nx, ny): gap, and net pressure on the body: negative in tension
    gap: Array = field(repr=False)
    pressure: Array = field(repr=False)
    # cells pressed together: in contact, under compression
    mask: Mask = field(repr=False)
    residual: float  # largest unbalanced tension, relative to the strength of the law

    @property
    def mean_gap(self) -> float:
        """Mean gap."""
        return float(self.gap.mean())


class Adhesive:
    """A periodic half-space, the gap of a rough body and a cohesive law.

    The operator is periodic; its grid must resolve the zone in which the tension falls, see
    `CohesiveProblem`. The gap is finite.
    """

    def __init__(self, operator: ElasticBody, gap: ArrayLike, law: CohesiveLaw) -> None:
        self.operator, self.law = operator, law
        self.initial = check_gap(operator, gap)
        faults = [] if operator.periodic else ["operator must be periodic"]
        faults += [] if np.isfinite(self.initial).all() else ["gap must be finite"]
        refuse(faults)
        compliance = whole(operator.transfer, operator.shape[0])
        self._stiffness = np.zeros_like(compliance)
        np.divide(1.0, compliance, out=self._stiffness, where=compliance > 0)
        # units of pressure, and of energy per area
        self._unit = float(self._stiffness.max()) * law.reach

    def at_force(self, force: float, start: Array) -> Settled:
        """Return the equilibrium under a force F >= 0 that is downhill from a field of gaps."""
        if not force >= 0:
            refuse([f"force must be at least 0, not {force!r}: pulls have no least energy"])
        area = self.operator.cell_area * start.size
        return self._downhill(start, load=force / area)

    def at_setting(self, setting: float, start: Array) -> Settled:
        """Return the equilibrium in the machine, downhill from a field of gaps.

        Its mean gap exceeds the setting by F/(A0 S_max), the deflection of the machine.
        """
        machine = float(self._stiffness.max())
        return self._downhill(start, machine=machine, setting=setting)

    def at_mean_gap(self, mean: float, start: Array, force: float) -> Settled:
        """Return the equilibrium at a mean gap, to a thousandth of the reach of the law.

        The machine's first setting is that for `force`, an estimate of F.
        """
        machine = float(self._stiffness.max()) * self.operator.cell_area * start.size
        setting = mean - force / machine
        for _ in range(_SETTINGS):
            settled = self.at_setting(setting, start)
            missing = mean - settled.mean_gap
            if abs(missing) <= _SAME * self.law.reach:
                return settled
            setting, start = setting + missing, settled.gap
        history = [abs(missing) / self.law.reach]
        raise ConvergenceError("no adhesive equilibrium at this mean gap", history)

    def _downhill(
        self, start: Array, *, load: float = 0.0, machine: float = 0.0, setting: float = 0.0
    ) -> Settled:
        """Return the least energy under a force per area and a machine F/A0 = k (<h> - setting)."""
        law, shape, reach = self.law, start.shape, self.law.reach

        def pressed(mean: float) -> float:
            return load + machine * (mean - setting)

        def energy(flat: Array) -> tuple[float, Array]:
            gap = flat.reshape(shape) * reach
            mean = float(gap.mean())
            elastic = self._elastic(gap)
            total = 0.5 * np.mean((gap - self.initial) * elastic) - law.energy(gap).mean()
            total += load * mean + 0.5 * machine * (mean - setting) ** 2
            slope = elastic + law.tension(gap) + pressed(mean)
            return total / (self._unit * reach), slope.ravel() / (self._unit * gap.size)

        goal = _UNBALANCED * law.strength / (self._unit * start.size)
        flat = np.maximum(start, 0.0).ravel() / reach
        # this way in checks the bounds of every cell once, `minimize` three times
        flat, _, _ = fmin_l_bfgs_b(
            energy,
            flat,
            bounds=[(0, None)] * flat.size,
            m=_MEMORY,
            factr=0.0,
            pgtol=0.5 * goal,
            maxiter=_ITERATIONS,
            maxfun=2 * _ITERATIONS,
        )
        gap = flat.reshape(shape) * reach
        mean_pressure = pressed(float(gap.mean()))
        pressure = self._elastic(gap) + mean_pressure
        free = pressure + law.tension(gap)
        unbalanced = float(np.where(gap > 0, np.abs(free), np.maximum(-free, 0.0)).max())
        residual = unbalanced / law.strength
        if not unbalanced <= _UNBALANCED * law.strength + _ROUNDED * np.abs(pressure).max():
            raise ConvergenceError("no adhesive equilibrium of least energy", [residual])
        force = mean_pressure * self.operator.cell_area * gap.size
        return Settled(force, gap, pressure, (gap == 0) & (pressure > 0), residual)

    def _elastic(self, gap: Array) -> Array:
        """Return the pressure, of zero mean, under which the half-space has these gaps."""
        waves = self._stiffness * fft.rfft2(gap - self.initial)
        pressure: Array = fft.irfft2(waves, s=self.initial.shape)
        return pressure
