"""J2 plasticity with isotropic hardening: stress, plastic strain and tangent of many points.

Stresses have three direct components first, then their shears: (rr, zz, tt, rz) or (xx, yy, zz, yz,
xz, xy); shear strains are twice those of the tensor. Units of the caller.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from reference.arguments import choice_faults, poisson_faults, refuse
from reference.elasticity import Material
from reference.errors import ConvergenceError

Array = NDArray[np.float64]
Law = Literal["linear", "power"]

# Newton steps for the plastic strain of a point; the flow stress is concave, so they never fail.
_ROUNDS = 60


@dataclass(frozen=True)
class PlasticMaterial:
    """Elastic constants, yield stress and hardening.

    Parameters
    ----------
    elastic : Material
        E and nu <= 0.4999.
    yield_stress : float
        Y in uniaxial tension; infinite: elastic.
    hardening : float
        "linear": slope h of the flow stress Y + h p over the plastic strain p (0: perfectly
        plastic); "power": exponent n of Y (1 + E p/Y)^n, below 1.
    law : {"linear", "power"}
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

    @property
    def shear_modulus(self) -> float:
        """G = E/(2 (1 + nu))."""
        return self.elastic.youngs_modulus / (2 * (1 + self.elastic.poisson_ratio))

    @property
    def bulk_modulus(self) -> float:
        """K = E/(3 (1 - 2 nu))."""
        return self.elastic.youngs_modulus / (3 * (1 - 2 * self.elastic.poisson_ratio))

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
    """The state of material points: plastic strain (..., c) and its accumulated amount (...)."""

    strain: Array
    amount: Array

    @classmethod
    def virgin(cls, shape: tuple[int, ...], components: int = 4) -> Points:
        """Return points that have not yielded."""
        return cls(np.zeros((*shape, components)), np.zeros(shape))


@dataclass(frozen=True)
class Response:
    """Stress (..., c), state and, where asked for, consistent tangent (..., c, c) of a step."""

    stress: Array
    points: Points
    tangent: Array | None


def respond(material: PlasticMaterial, strain: Array, old: Points, *, tangent: bool) -> Response:
    """Return the points one implicit (backward Euler) step later: radial return.

    The step minimises a convex incremental potential; the tangent is its second derivative (Simo &
    Taylor 1985; Simo & Hughes 1998, box 3.2).

    Parameters
    ----------
    material : PlasticMaterial
    strain : (..., c)
        Total strain at the end of the step.
    old : Points
        State at its beginning.
    tangent : bool
        Whether the tangent is needed.
    """
    shear, bulk = material.shear_modulus, material.bulk_modulus
    trace, twice, deviator = _frame(strain.shape[-1])
    elastic = strain - old.strain
    trial = 2 * shear * elastic @ deviator
    norm = np.sqrt((twice * trial**2).sum(-1))
    equivalent = np.sqrt(1.5) * norm
    more = plastic_step(material, equivalent, old.amount)
    kept = 1 - 3 * shear * more / np.where(equivalent > 0, equivalent, 1.0)
    pressure = bulk * strain[..., :3].sum(-1)
    stress = kept[..., None] * trial + pressure[..., None] * trace
    normal = trial / np.where(norm > 0, norm, 1.0)[..., None]
    flow = np.sqrt(1.5) * more[..., None] * normal * twice
    points = Points(old.strain + flow, old.amount + more)
    if not tangent:
        return Response(stress, points, None)
    slope = material.flow_stress(points.amount)[1]
    along = np.where(more > 0, 1 / (1 + slope / (3 * shear)) - (1 - kept), 0.0)
    matrix = 2 * shear * kept[..., None, None] * deviator
    matrix -= (2 * shear * along)[..., None, None] * normal[..., :, None] * normal[..., None, :]
    return Response(stress, points, matrix + bulk * np.outer(trace, trace))


def _frame(components: int) -> tuple[Array, Array, Array]:
    """Return what sums direct components, doubles shears, and makes deviators of strains."""
    trace = np.where(np.arange(components) < 3, 1.0, 0.0)
    return trace, 2 - trace, np.diag((1 + trace) / 2) - np.outer(trace, trace) / 3


def plastic_step(material: PlasticMaterial, trial: Array, amount: Array) -> Array:
    """Return the plastic strain that brings the trial stress back to the flow stress."""
    more = np.zeros(trial.shape)
    active = trial > material.flow_stress(amount)[0]
    if not active.any():
        return more
    trial, start, shear = trial[active], amount[active], material.shear_modulus
    step = np.zeros(trial.shape)
    for _ in range(_ROUNDS):
        flow, slope = material.flow_stress(start + step)
        excess = trial - 3 * shear * step - flow
        step = np.maximum(step + excess / (3 * shear + slope), 0.0)
        if np.abs(excess).max() <= 1e-13 * trial.max():
            more[active] = step
            return more
    raise ConvergenceError("the plastic strain of a point is not found", [float(excess.max())])


def yield_pressure(poisson_ratio: float) -> float:
    """Return p0/Y at which a circular Hertzian contact first yields, by von Mises.

    The larger of two stresses counts. On the axis at depth z a the stresses below the pressure p0
    are sigma_z = -p0/(1 + z^2) and
    sigma_r = -p0 [(1 + nu)(1 - z atan(1/z)) - 1/(2 (1 + z^2))] (Johnson 1985, eq. 3.45); the
    largest difference of both lies at z = 0.48 for nu = 0.3. At the edge there is pure shear,
    sigma_r = -sigma_t = (1 - 2 nu) p0/3, von Mises' (1 - 2 nu)/sqrt(3) p0: the larger one below
    nu = -0.4.

    Raises
    ------
    ValueError
        Outside -1 < nu <= 1/2.

    Examples
    --------
    >>> round(yield_pressure(0.3), 4)
    1.6128
    """
    refuse(poisson_faults(poisson_ratio))
    depth = np.linspace(1e-6, 2.0, 4001)
    share = (1 + poisson_ratio) * (1 - depth * np.arctan(1 / depth)) - 1 / (2 * (1 + depth**2))
    difference = np.abs(1 / (1 + depth**2) - share)
    top = int(np.clip(np.argmax(difference), 1, depth.size - 2))
    low, mid, high = difference[top - 1 : top + 2]
    peak = mid - (high - low) ** 2 / (8 * (high - 2 * mid + low))
    edge = (1 - 2 * poisson_ratio) / np.sqrt(3)
    return float(1 / max(peak, edge))


def yield_depth(radius: float, effective_modulus: float, pressure: float) -> float:
    """Return the penetration of a ball whose Hertzian contact has a largest pressure p0.

    d = (pi p0/(2 E*))^2 R; with p0 of first yield (`yield_pressure`), that of first yield.

    Examples
    --------
    >>> round(yield_depth(2.0, np.pi / 2, 0.1), 12)
    0.02
    """
    return float((np.pi * pressure / (2 * effective_modulus)) ** 2 * radius)
