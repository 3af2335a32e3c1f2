"""Linear viscoelastic material of the reference: a generalised Maxwell body.

Independent of the material of the reduced model, in other variables: the state is the strain of the
dashpots, and creep uses the retardation times as zeros of the compliance's denominator. A spring
G_0, arms (G_i, tau_i) and a dashpot eta in parallel:

    sigma = G_0 gamma + sum_i G_i (gamma - q_i) + eta dgamma/dt,   tau_i dq_i/dt = gamma - q_i
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from reference.arrays import Array, Modes
from reference.errors import refuse

# Arms whose times differ by less than this are merged, as their creep is indistinguishable.
_ALIKE = 1e-10


class CreepModes(NamedTuple):
    """J(t) = instantaneous + fluidity t + sum of compliances (1 - exp(-t/times))."""

    instantaneous: float
    fluidity: float
    compliances: Array
    times: Array


class GeneralisedMaxwell:
    """Spring, dashpot and Maxwell arms in parallel, in shear.

    The long-term modulus is G_0 >= 0; arms have G_i >= 0 and tau_i > 0, in any order; the dashpot
    eta >= 0. They must not all be zero.

    >>> zener = GeneralisedMaxwell(1.0, [3.0], [2.0])
    >>> float(zener.relaxation(0.0)), float(zener.creep(0.0)), float(zener.creep(1e9))
    (4.0, 0.25, 1.0)
    """

    def __init__(
        self,
        equilibrium_modulus: float,
        arm_moduli: Sequence[float] = (),
        arm_times: Sequence[float] = (),
        viscosity: float = 0.0,
    ) -> None:
        faults = []
        for name, value in (("equilibrium_modulus", equilibrium_modulus), ("viscosity", viscosity)):
            if not (math.isfinite(value) and value >= 0):
                faults.append(f"{name} must be finite and not negative, not {value!r}")
        if len(arm_moduli) != len(arm_times):
            faults.append(f"{len(arm_moduli)} arm_moduli for {len(arm_times)} arm_times")
        if not all(math.isfinite(g) and g >= 0 for g in arm_moduli):
            faults.append(f"arm_moduli must be finite and not negative, not {arm_moduli!r}")
        if not all(math.isfinite(tau) and tau > 0 for tau in arm_times):
            faults.append(f"arm_times must be finite and positive, not {arm_times!r}")
        if not faults and not any(g > 0 for g in (equilibrium_modulus, viscosity, *arm_moduli)):
            faults.append("nothing resists: all moduli and the viscosity are zero")
        refuse(faults)
        times: list[float] = []
        moduli: list[float] = []
        for time, modulus in sorted(zip(arm_times, arm_moduli, strict=True)):
            if modulus > 0 and times and time <= times[-1] * (1 + _ALIKE):
                moduli[-1] += float(modulus)
            elif modulus > 0:
                times.append(float(time))
                moduli.append(float(modulus))
        self.equilibrium_modulus = float(equilibrium_modulus)
        self.viscosity = float(viscosity)
        self.arm_times = np.array(times, dtype=float)
        self.arm_moduli = np.array(moduli, dtype=float)

    @classmethod
    def kelvin_voigt(cls, shear_modulus: float, viscosity: float) -> GeneralisedMaxwell:
        """Return a spring parallel to a dashpot."""
        return cls(shear_modulus, viscosity=viscosity)

    @classmethod
    def standard(
        cls, equilibrium_modulus: float, shear_modulus: float, relaxation_time: float
    ) -> GeneralisedMaxwell:
        """Return a spring parallel to one arm (Zener)."""
        return cls(equilibrium_modulus, [shear_modulus], [relaxation_time])

    @property
    def instantaneous_modulus(self) -> float:
        """G_0 + sum G_i, the response to a jump without the dashpot's pulse."""
        return math.fsum([self.equilibrium_modulus, *self.arm_moduli])

    def relaxation(self, time: ArrayLike) -> Array:
        """Return the stress at a time t > 0 after a unit jump of strain."""
        t = np.asarray(time, dtype=float)
        stress = np.full(t.shape, self.equilibrium_modulus)
        for modulus, tau in zip(self.arm_moduli, self.arm_times, strict=True):
            stress = stress + modulus * np.exp(-t / tau)
        return stress

    def dynamic_modulus(self, frequency: ArrayLike) -> Modes:
        """Return the stress amplitude under unit strain exp(i w t), w of either sign."""
        s = 1j * np.asarray(frequency, dtype=float)
        stress = self.equilibrium_modulus + self.viscosity * s
        for modulus, tau in zip(self.arm_moduli, self.arm_times, strict=True):
            stress = stress + modulus * (s * tau / (1 + s * tau))
        return stress

    def creep(self, time: ArrayLike) -> Array:
        """Return the strain at a time t >= 0 after a unit jump of stress."""
        t = np.asarray(time, dtype=float)
        modes = self.creep_modes
        strain = modes.instantaneous + t * modes.fluidity
        for delayed, retardation in zip(modes.compliances, modes.times, strict=True):
            strain = strain - delayed * np.expm1(-t / retardation)
        return np.asarray(strain)

    @cached_property
    def creep_modes(self) -> CreepModes:
        """The series of springs and dashpots with the creep of this material.

        By partial fractions. As a function of the time l = -1/s, sigma/gamma = G_0 -
        sum G_i tau_i/(l - tau_i) - eta/l has one zero between successive arm times, one more above
        the longest (solids) and one below the shortest (with a dashpot).
        """
        times = [float(tau) for tau in self.arm_times]
        weights = [float(g * tau) for g, tau in zip(self.arm_moduli, times, strict=True)]
        solid, damped = self.equilibrium_modulus > 0, self.viscosity > 0

        def modulus(ell: float) -> float:
            arms = sum(w / (ell - tau) for w, tau in zip(weights, times, strict=True))
            return self.equilibrium_modulus - arms - self.viscosity / ell

        brackets = list(itertools.pairwise(times))
        flow = sum(weights) + self.viscosity
        longest = times[-1] if times else 0.0
        if solid and flow > 0:
            brackets.append((longest, longest + 2 * flow / self.equilibrium_modulus))
        if damped and times:
            stiff = sum(w / tau for w, tau in zip(weights, times, strict=True))
            least = self.viscosity / (self.equilibrium_modulus + 2 * stiff)
            brackets.append((min(times[0], least) / 4, times[0]))
        modes = []
        for low, high in brackets:
            margin, ell = 1e-3, None
            while ell is None:  # the ends may be poles
                inner, outer = low + margin * (high - low), high - margin * (high - low)
                if inner <= low or outer >= high:
                    # the zero is at a pole to rounding: an arm too weak to add compliance
                    ell = low if inner <= low else high
                elif modulus(inner) < 0 < modulus(outer):
                    ell = brentq(modulus, inner, outer, xtol=1e-15 * inner, rtol=1e-15, maxiter=300)
                margin /= 10
            if ell not in times:  # else the compliance vanishes
                slope = sum(w / (ell - tau) ** 2 for w, tau in zip(weights, times, strict=True))
                modes.append((1 / (ell * (slope + self.viscosity / ell**2)), ell))
        compliances, retardations = np.array(modes).reshape(-1, 2).T
        steady = float(self.arm_moduli @ self.arm_times) + self.viscosity
        return CreepModes(
            0.0 if damped else 1 / self.instantaneous_modulus,
            0.0 if solid else 1 / steady,
            compliances,
            retardations,
        )
