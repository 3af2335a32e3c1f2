"""Isotropic linear elasticity: constants of a material, invariants of its stress."""

from dataclasses import dataclass

import numpy as np

from reference.arrays import Array
from reference.errors import poisson_faults, positive_faults, refuse

# Beyond it lambda is more than 5000 times the shear modulus, and a displacement method loses the
# digits of the pressure.
LARGEST_POISSON_RATIO = 0.4999


@dataclass(frozen=True)
class Material:
    """Isotropic linear elasticity."""

    youngs_modulus: float
    # -1 < nu <= 0.5; displacement methods are limited to `LARGEST_POISSON_RATIO`
    poisson_ratio: float

    def __post_init__(self) -> None:
        faults = positive_faults(youngs_modulus=self.youngs_modulus)
        refuse(faults + poisson_faults(self.poisson_ratio))

    @property
    def shear_modulus(self) -> float:
        """G = E/(2 (1 + nu))."""
        return self.youngs_modulus / (2 * (1 + self.poisson_ratio))

    @property
    def effective_modulus(self) -> float:
        """E* = E/(1 - nu^2), under a rigid body."""
        return self.youngs_modulus / (1 - self.poisson_ratio**2)

    @property
    def incompressible(self) -> bool:
        """Whether displacement methods lock."""
        return self.poisson_ratio > LARGEST_POISSON_RATIO


def lame_parameters(poisson_ratio: float) -> tuple[float, float]:
    """Return Lamé's constants for a unit Young's modulus.

    ``lambda = nu / ((1 + nu)(1 - 2 nu))``, ``mu = 1 / (2 (1 + nu))`` (Johnson 1985, app. 1).

    >>> lame_parameters(0.25)
    (0.4, 0.4)
    """
    if not -1.0 < poisson_ratio <= LARGEST_POISSON_RATIO:
        raise ValueError(
            f"poisson_ratio must lie in (-1, {LARGEST_POISSON_RATIO}], got {poisson_ratio!r}: "
            "nearer to 1/2 a displacement-based element cannot carry the pressure of an "
            "incompressible body; take 0.4999 (its effect on E* is below 0.01 % of that of 0.5)"
        )
    shear = 0.5 / (1.0 + poisson_ratio)
    return poisson_ratio / ((1.0 + poisson_ratio) * (1.0 - 2.0 * poisson_ratio)), shear


def von_mises(stress: Array) -> Array:
    """Return ``sqrt(3 J2)`` of stresses (..., 6) in the order xx, yy, zz, yz, xz, xy.

    Those of an axisymmetric body have one shear stress (..., 4): rr, zz, tt, rz.

    >>> float(von_mises(np.array([-3.0, 0.0, 0.0, 0.0, 0.0, 0.0])))
    3.0
    """
    direct = stress[..., :3]
    differences = direct - np.roll(direct, 1, axis=-1)
    return np.sqrt(0.5 * (differences**2).sum(axis=-1) + 3.0 * (stress[..., 3:] ** 2).sum(axis=-1))


def largest_shear(stress: Array) -> Array:
    """Return ``(s_1 - s_3)/2`` of stresses (..., 6) in the order xx, yy, zz, yz, xz, xy.

    >>> float(largest_shear(np.array([-3.0, 0.0, 0.0, 0.0, 0.0, 0.0])))
    1.5
    """
    principal = np.linalg.eigvalsh(stress[..., [[0, 5, 4], [5, 1, 3], [4, 3, 2]]])
    return 0.5 * (principal[..., 2] - principal[..., 0])
