r"""The effective modulus of a half-space with coatings under a contact of radius a.

Xu & Pharr (Scripta Mater. 55 (2006) 315) mix compliances with the weight that Gao, Chiu & Lee
(Int. J. Solids Struct. 29 (1992) 2471) found for a flat punch and nearly equal moduli,

    1/E = I(t/a)/E_coating + (1 - I(t/a))/E_substrate,
    I(s) = (2/pi) arctan s + [(1 - 2 nu) s ln(1 + 1/s^2) - s/(1 + s^2)]/(2 pi (1 - nu)).

Several coatings have the differences of their weights; a rigid base has no compliance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from reduced.arguments import poisson_faults, positive_faults, refuse


@dataclass(frozen=True)
class Coatings:
    """Layers from the surface down, on a half-space.

    E* of the layers and of the base below (inf: rigid); Poisson's ratio is that of the uppermost
    layer.

    >>> coated = Coatings([1.0], [4.0], 1.0, 0.3)
    >>> np.round(coated.modulus(np.array([1e-6, 1e6])), 4)
    array([4., 1.])
    """

    thicknesses: Sequence[float]
    moduli: Sequence[float]
    base: float
    poisson_ratio: float

    def __post_init__(self) -> None:
        wrong = poisson_faults(self.poisson_ratio)
        if len(self.thicknesses) != len(self.moduli):
            wrong.append("thicknesses and moduli must be as many")
        for name, values in (("thicknesses", self.thicknesses), ("moduli", self.moduli)):
            for index, value in enumerate(values):
                wrong += positive_faults(**{f"{name}[{index}]": value})
        if not self.base > 0:
            wrong.append(f"base must be positive, got {self.base!r}")
        refuse(wrong)

    def modulus(self, contact_radius: np.ndarray) -> np.ndarray:
        """Return the effective modulus of contacts of these radii."""
        s, nu = np.cumsum(self.thicknesses)[:, None] / contact_radius, self.poisson_ratio
        more = (1 - 2 * nu) * s * np.log1p(s**-2) - s / (1 + s**2)
        below = 2 / np.pi * np.arctan(s) + more / (2 * np.pi * (1 - nu))
        weights = np.vstack([np.zeros(contact_radius.size), below])
        shares = np.diff(weights, axis=0) / np.array(self.moduli)[:, None]
        return np.asarray(1 / (shares.sum(axis=0) + (1 - weights[-1]) / self.base))
