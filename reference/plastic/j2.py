"""J2 plasticity with isotropic hardening: stress, plastic strain and tangent of many points.

Stresses have three direct components first, then their shears: (rr, zz, tt, rz) or (xx, yy, zz, yz,
xz, xy); shear strains are twice those of the tensor. Units of the caller.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from reference.arrays import Array
from reference.elasticity import Material
from reference.errors import ConvergenceError, choice_faults, refuse

Law = Literal["linear", "power"]

# Newton steps for the plastic strain of a point; the flow stress is concave, so they never fail.
_ROUNDS = 60


@dataclass(frozen=True)
class PlasticMaterial:
    """Elastic constants, yield stress and hardening.

    nu <= 0.4999; Y in uniaxial tension, infinite: elastic. `hardening` over the plastic strain p:
    by the law "linear" the slope h of the flow stress Y + h p (0: perfectly plastic), by "power"
    the exponent n < 1 of Y (1 + E p/Y)^n.
    """

    elastic: Material
    yield_stress: float
    hardening: float = 0.0
    law: Law = "linear"

    def __post_init__(self) -> None:
        faults = choice_faults("law", self.law, ("linear", "power"))
        if not self.yield_stress > 0:  # infinite: elastic
            faults.append(f"yield_stress must be positive, got {self.yield_stress!r}")
        if not 0 <= self.hardening < (1 if self.law == "power" else np.inf):
            faults.append(f"hardening must be at least 0 (a power below 1), got {self.hardening!r}")
        if self.elastic.incompressible:
            faults.append("poisson_ratio must be at most 0.4999 (displacement elements)")
        refuse(faults)

    def scaled(self, modulus: float) -> PlasticMaterial:
        """Return the material with all stresses in units of a modulus."""
        return replace(
            self,
            elastic=Material(self.elastic.youngs_modulus / modulus, self.elastic.poisson_ratio),
            yield_stress=self.yield_stress / modulus,
            hardening=self.hardening / modulus if self.law == "linear" else self.hardening,
        )

    def flow_stress(self, strain: Array) -> tuple[Array, Array]:
        """Return flow stress and its slope at an accumulated plastic strain."""
        if self.law == "linear":
            slope = np.full(strain.shape, self.hardening)
            return self.yield_stress + self.hardening * strain, slope
        modulus = self.elastic.youngs_modulus
        base = 1 + modulus * strain / self.yield_stress
        stress = self.yield_stress * base**self.hardening
        return stress, self.hardening * modulus * base ** (self.hardening - 1)


@dataclass(frozen=True)
class Points:
    """Material points: plastic strain (..., c) and its accumulated amount (...)."""

    strain: Array
    amount: Array

    @classmethod
    def virgin(cls, shape: tuple[int, ...], components: int = 4) -> Points:
        """Return points that have not yielded."""
        return cls(np.zeros((*shape, components)), np.zeros(shape))


def respond(material: PlasticMaterial, strain: Array, old: Points) -> tuple[Array, Points, Array]:
    """Return stress (..., c), points and tangent (..., c, c) of an implicit step: radial return.

    `strain` (..., c) is the total one at the end of the step, `old` the points at its beginning.
    The step minimises a convex incremental potential; the consistent tangent is its second
    derivative (Simo & Taylor 1985; Simo & Hughes 1998, box 3.2).
    """
    elastic = material.elastic
    shear = elastic.shear_modulus
    bulk = elastic.youngs_modulus / (3 * (1 - 2 * elastic.poisson_ratio))
    trace = np.where(np.arange(strain.shape[-1]) < 3, 1.0, 0.0)
    twice = 2 - trace  # a shear stands for two components of the tensor
    deviator = np.diag((1 + trace) / 2) - np.outer(trace, trace) / 3
    # trial stress, as if the step were elastic
    trial = 2 * shear * (strain - old.strain) @ deviator
    norm = np.sqrt((twice * trial**2).sum(-1))
    equivalent = np.sqrt(1.5) * norm
    # return along its direction to the flow stress
    more = plastic_step(material, equivalent, old.amount)
    kept = 1 - 3 * shear * more / np.where(equivalent > 0, equivalent, 1.0)
    pressure = bulk * strain[..., :3].sum(-1)
    stress = kept[..., None] * trial + pressure[..., None] * trace
    normal = trial / np.where(norm > 0, norm, 1.0)[..., None]
    flow = np.sqrt(1.5) * more[..., None] * normal * twice
    points = Points(old.strain + flow, old.amount + more)
    slope = material.flow_stress(points.amount)[1]
    along = np.where(more > 0, 1 / (1 + slope / (3 * shear)) - (1 - kept), 0.0)
    matrix = 2 * shear * kept[..., None, None] * deviator
    matrix -= (2 * shear * along)[..., None, None] * normal[..., :, None] * normal[..., None, :]
    return stress, points, matrix + bulk * np.outer(trace, trace)


def plastic_step(material: PlasticMaterial, trial: Array, amount: Array) -> Array:
    """Return the plastic strain that brings the trial stress back to the flow stress."""
    more = np.zeros(trial.shape)
    active = trial > material.flow_stress(amount)[0]
    if not active.any():
        return more
    trial, start, shear = trial[active], amount[active], material.elastic.shear_modulus
    step = np.zeros(trial.shape)
    for _ in range(_ROUNDS):
        flow, slope = material.flow_stress(start + step)
        excess = trial - 3 * shear * step - flow
        step = np.maximum(step + excess / (3 * shear + slope), 0.0)
        if np.abs(excess).max() <= 1e-13 * trial.max():
            more[active] = step
            return more
    raise ConvergenceError("the plastic strain of a point is not found", [float(excess.max())])
